//! Curved bodies as the polyhedra that a drawing shows in their place.
//!
//! A body of revolution is the turn of its profile. The polyhedron has its corners on the surface, so it lies inside convex bodies; between corners it is off
//! by at most r·(1 − cos(π/n)) < 5·r/n² for n sides and a radius r, and along the profile by no more. n is chosen so that this is a quarter of a
//! pixel where the body is nearest to the eye, from [`SIDES`] sides to 256: more than that only bodies far larger than the picture would need.
//! General quadrics have no profile, and are left out. Cost: about n²/2 triangles a body.

use std::{
    f64::consts::{FRAC_PI_2, PI},
    sync::Arc,
};

use glam::DVec3;
use umbriel_geometry::{Analytic, Mesh};
use umbriel_scene::{Object, Shape};

use super::projection::Projector;

/// Least and most sides; with the least, neighbours bend by less than a crease.
const SIDES: [f64; 2] = [24.0, 256.0];

/// How far polyhedra may be off, pixels.
const OFF: f64 = 0.25;

/// Radius and height.
type Profile = Vec<[f64; 2]>;

/// An object with flat faces in the place of another one; `None` for general quadrics.
pub(super) fn flattened(object: &Object, projector: &Projector) -> Option<Object> {
    let Shape::Analytic(body) = &object.shape else { return Some(object.clone()) };
    let parts = parts(object, projector);
    let stretch = if let Analytic::Ellipsoid { radii } = body { (*radii).into() } else { DVec3::ONE };
    let (points, triangles) = turned(&profile(body, parts)?, 4 * parts);
    let positions = points.into_iter().map(|point| (point * stretch).to_array()).collect();
    let mesh = Mesh::new(positions, triangles).ok()?;
    Some(Object { shape: Shape::Mesh(Arc::new(mesh)), ..object.clone() })
}

/// Sides of a quarter turn.
fn parts(object: &Object, projector: &Projector) -> u32 {
    let bounds = object.bounds();
    let radius = 0.5 * bounds.size().length() / projector.least_pixel(&bounds);
    let sides = (5.0 * radius / OFF).sqrt().clamp(SIDES[0], SIDES[1]);
    // A body around the eye has no least pixel.
    if sides.is_finite() { (0.25 * sides).ceil() as u32 } else { SIDES[1] as u32 / 4 }
}

/// From the lower end of the axis to the upper one; of an ellipsoid that of the unit ball.
fn profile(body: &Analytic, parts: u32) -> Option<Profile> {
    let closed = |half: f64, side: Profile| -> Profile {
        std::iter::once([0.0, -half]).chain(side).chain([[0.0, half]]).collect()
    };
    Some(match *body {
        Analytic::Sphere { radius } => closed(radius, arcs(radius, 0.0, parts)),
        Analytic::Ellipsoid { .. } => closed(1.0, arcs(1.0, 0.0, parts)),
        Analytic::Capsule { radius, height } => closed(0.5 * height + radius, arcs(radius, 0.5 * height, parts)),
        Analytic::Cylinder { radius, height } => {
            closed(0.5 * height, vec![[radius, -0.5 * height], [radius, 0.5 * height]])
        }
        Analytic::Cone { radius, height } => closed(0.5 * height, vec![[radius, -0.5 * height]]),
        Analytic::Frustum { bottom_radius, top_radius, height } => {
            closed(0.5 * height, vec![[bottom_radius, -0.5 * height], [top_radius, 0.5 * height]])
        }
        Analytic::Paraboloid { radius, height } => {
            let at = |k: u32| f64::from(k) / f64::from(parts);
            let side = (1..=parts).rev().map(|k| [radius * at(k), height * (0.5 - at(k) * at(k))]);
            closed(0.5 * height, side.collect())
        }
        Analytic::Hyperboloid { waist_radius, end_radius, height } => {
            closed(0.5 * height, hyperbola([waist_radius, end_radius], 0.5 * height, parts))
        }
        // Its front looks up.
        Analytic::Disk { radius } => vec![[radius, 0.0], [0.0, 0.0]],
        _ => return None,
    })
}

/// Two quarters of a circle, apart by a line along the axis, without the ends of the axis.
fn arcs(radius: f64, half_height: f64, parts: u32) -> Profile {
    let upper = (0..parts).map(|k| {
        let angle = FRAC_PI_2 * f64::from(k) / f64::from(parts);
        [radius * angle.cos(), half_height + radius * angle.sin()]
    });
    let upper: Profile = upper.collect();
    let lower = upper.iter().rev().map(|&[r, y]| [r, -y]);
    // A sphere has one equator.
    let joint = usize::from(half_height == 0.0);
    lower.chain(upper.iter().skip(joint).copied()).collect()
}

/// r = waist·cosh t, y in proportion to sinh t, in equal steps of t.
fn hyperbola([waist, end]: [f64; 2], half_height: f64, parts: u32) -> Profile {
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

/// Corners and triangles of a profile turned about the y axis.
fn turned(profile: &[[f64; 2]], sides: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let mut before: Option<(u32, bool)> = None;
    for &[radius, y] in profile {
        let (first, is_point) = (points.len() as u32, radius == 0.0);
        let angles = (0..if is_point { 1 } else { sides }).map(|k| 2.0 * PI * f64::from(k) / f64::from(sides));
        points.extend(angles.map(|angle| DVec3::new(radius * angle.cos(), y, radius * angle.sin())));
        for (k, next) in (0..sides).map(|k| (k, (k + 1) % sides)) {
            match before {
                Some((below, true)) if !is_point => triangles.push([below, first + k, first + next]),
                Some((below, false)) if is_point => triangles.push([below + k, first, below + next]),
                Some((below, false)) => {
                    triangles.extend([[below + k, first + k, first + next], [below + k, first + next, below + next]]);
                }
                _ => {}
            }
        }
        before = Some((first, is_point));
    }
    (points, triangles)
}
