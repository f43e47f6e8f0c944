//! Curved bodies as the polyhedra that a drawing shows in their place.
//!
//! A body of revolution is the turn of its profile. The polyhedron has its corners on the surface, so it lies inside convex bodies; between corners it is off
//! by at most r·(1 − cos(π/n)) < 5·r/n² for n sides and a radius r, and along the profile by no more. n is chosen so that this is a quarter of a
//! pixel where the body is nearest to the eye, from [`SIDES`] sides to 256: more than that only bodies far larger than the picture would need.
//! A profile is a chain of smooth pieces, and each triangle knows the piece that it comes from: edges between pieces are the rims that are drawn, however
//! little they bend; edges within a piece are not on the body, however much they bend.
//! General quadrics have no profile, and are left out. Cost: about n²/2 triangles a body.

use std::{
    f64::consts::{FRAC_PI_2, PI},
    sync::Arc,
};

use glam::DVec3;
use umbriel_geometry::{Analytic, Mesh};
use umbriel_scene::{Object, Shape};

use super::projection::Projector;

/// Least and most sides.
const SIDES: [f64; 2] = [24.0, 256.0];

/// How far polyhedra may be off, pixels.
const OFF: f64 = 0.25;

/// A smooth piece of a profile: radius and height, point by point.
type Piece = Vec<[f64; 2]>;

/// An object with flat faces.
pub(super) struct Flattened {
    pub(super) object: Object,
    /// Of a curved body the smooth piece of its surface that each face stands for.
    pub(super) pieces: Option<Vec<u32>>,
}

/// An object with flat faces in the place of another one; `None` for general quadrics.
pub(super) fn flattened(object: &Object, projector: &Projector) -> Option<Flattened> {
    let Shape::Analytic(body) = &object.shape else {
        return Some(Flattened { object: object.clone(), pieces: None });
    };
    let parts = parts(object, projector);
    let stretch = if let Analytic::Ellipsoid { radii } = **body { radii.into() } else { DVec3::ONE };
    let Turned { points, triangles, pieces } = Turned::new(&profile(body, parts)?, 4 * parts);
    let positions = points.into_iter().map(|point| (point * stretch).to_array()).collect();
    let mesh = Mesh::new(positions, triangles).ok()?;
    let object = Object::new(object.name.clone(), Shape::Mesh(Arc::new(mesh)), object.placement, object.sides).ok()?;
    Some(Flattened { object, pieces: Some(pieces) })
}

/// Sides of a quarter turn.
fn parts(object: &Object, projector: &Projector) -> u32 {
    let bounds = object.bounds();
    let radius = 0.5 * bounds.size().length() / projector.least_pixel(&bounds);
    let sides = (5.0 * radius / OFF).sqrt().clamp(SIDES[0], SIDES[1]);
    // A body around the eye has no least pixel.
    if sides.is_finite() { (0.25 * sides).ceil() as u32 } else { SIDES[1] as u32 / 4 }
}

/// From the lower end of the axis to the upper one, each piece from where the one before ends; of an ellipsoid that of the unit ball.
fn profile(body: &Analytic, parts: u32) -> Option<Vec<Piece>> {
    Some(match *body {
        Analytic::Sphere { radius } => vec![round(radius, 0.0, parts)],
        Analytic::Ellipsoid { .. } => vec![round(1.0, 0.0, parts)],
        Analytic::Capsule { radius, height } => vec![round(radius, 0.5 * height, parts)],
        Analytic::Cylinder { radius, height } => closed(vec![[radius, -0.5 * height], [radius, 0.5 * height]]),
        Analytic::Cone { radius, height } => closed(vec![[radius, -0.5 * height], [0.0, 0.5 * height]]),
        Analytic::Frustum { bottom_radius, top_radius, height } => {
            closed(vec![[bottom_radius, -0.5 * height], [top_radius, 0.5 * height]])
        }
        Analytic::Paraboloid { radius, height } => {
            let at = |k: u32| f64::from(k) / f64::from(parts);
            closed((0..=parts).rev().map(|k| [radius * at(k), height * (0.5 - at(k) * at(k))]).collect())
        }
        Analytic::Hyperboloid { waist_radius, end_radius, height } => {
            closed(hyperbola([waist_radius, end_radius], 0.5 * height, parts))
        }
        // Its front looks up.
        Analytic::Disk { radius } => vec![vec![[radius, 0.0], [0.0, 0.0]]],
        _ => return None,
    })
}

/// A side with the flat ends that close it.
fn closed(side: Piece) -> Vec<Piece> {
    let (first, last) = (side[0], side[side.len() - 1]);
    let [bottom, top] = [vec![[0.0, first[1]], first], vec![last, [0.0, last[1]]]];
    [bottom, side, top].into_iter().filter(|piece| piece[0] != piece[1]).collect()
}

/// From pole to pole: two quarters of a circle, apart by a line along the axis.
fn round(radius: f64, half_height: f64, parts: u32) -> Piece {
    let upper = (0..parts).map(|k| {
        let angle = FRAC_PI_2 * f64::from(k) / f64::from(parts);
        [radius * angle.cos(), half_height + radius * angle.sin()]
    });
    let upper: Piece = upper.chain([[0.0, half_height + radius]]).collect();
    let lower = upper.iter().rev().map(|&[r, y]| [r, -y]);
    // A sphere has one equator.
    let joint = usize::from(half_height == 0.0);
    lower.chain(upper.iter().skip(joint).copied()).collect()
}

/// r = waist·cosh t, y in proportion to sinh t, in equal steps of t.
fn hyperbola([waist, end]: [f64; 2], half_height: f64, parts: u32) -> Piece {
    let last = (end / waist).acosh();
    if last <= 0.0 {
        return vec![[waist, -half_height], [waist, half_height]];
    }
    let steps = i64::from(parts) * (last.ceil().min(64.0) as i64);
    let inner = (1 - steps..steps).map(|k| {
        let t = last * k as f64 / steps as f64;
        [waist * t.cosh(), half_height * t.sinh() / last.sinh()]
    });
    std::iter::once([end, -half_height]).chain(inner).chain([[end, half_height]]).collect()
}

/// Pieces of a profile turned about the y axis.
struct Turned {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// The piece of each triangle.
    pieces: Vec<u32>,
}

impl Turned {
    fn new(profile: &[Piece], sides: u32) -> Self {
        let mut turned = Self { points: Vec::new(), triangles: Vec::new(), pieces: Vec::new() };
        let mut below = turned.ring(profile[0][0], sides);
        for (number, piece) in (0..).zip(profile) {
            for &point in &piece[1..] {
                let above = turned.ring(point, sides);
                turned.band(below, above, sides);
                below = above;
            }
            turned.pieces.resize(turned.triangles.len(), number);
        }
        turned
    }

    /// Adds the corners of one height: the first one's number, and whether it is the only one.
    fn ring(&mut self, [radius, y]: [f64; 2], sides: u32) -> (u32, bool) {
        let (first, is_point) = (self.points.len() as u32, radius == 0.0);
        let angles = (0..if is_point { 1 } else { sides }).map(|k| 2.0 * PI * f64::from(k) / f64::from(sides));
        self.points.extend(angles.map(|angle| DVec3::new(radius * angle.cos(), y, radius * angle.sin())));
        (first, is_point)
    }

    /// Adds the triangles between two heights.
    fn band(&mut self, (low, low_is_point): (u32, bool), (high, high_is_point): (u32, bool), sides: u32) {
        for (k, next) in (0..sides).map(|k| (k, (k + 1) % sides)) {
            match (low_is_point, high_is_point) {
                (true, true) => {}
                (true, false) => self.triangles.push([low, high + k, high + next]),
                (false, true) => self.triangles.push([low + k, high, low + next]),
                (false, false) => {
                    self.triangles.extend([[low + k, high + k, high + next], [low + k, high + next, low + next]]);
                }
            }
        }
    }
}
