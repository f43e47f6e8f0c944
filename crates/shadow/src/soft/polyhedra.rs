//! Curved bodies between two polyhedra: what the one inside hides the body hides, and no more than the one round it.
//!
//! A body of revolution is the turn of its outline. Its inner polyhedron has corners on the surface; its outer one has sides that touch
//! it: tangents of the outline, turned in prisms that are larger by 1/cos(π/n); of a hyperboloid, whose outline bends inward, tangents are inside
//! and chords outside. Both are then scaled about a point inside, outward
//! and inward, by more than placing and rounding their corners can move them (NUMERICS.md, "Soft shadows"). Guarantee: every triangle of
//! the inner one lies in the body, and the surface of the outer one winds about all of it. Cost: some 1,000 triangles for a ball; the
//! gap between the two is half a per cent of the radius.

use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};
use umbriel_geometry::{Analytic, Facets, Mesh, Placement};

/// Sides of a prism.
const AROUND: u32 = 32;

/// Parts of a quarter of a circle, and of a parabola.
const ALONG: i32 = 8;

/// Half the thickness of the prism round a disk, as a share of its radius.
const THIN: f64 = 1.0 / (1u64 << 16) as f64;

/// Covers the rounding of sines, products and sums of the corners' local coordinates.
const ROUNDING: f64 = 1.0 / (1u64 << 40) as f64;

/// Bodies that rounding may change by more than this are not bounded.
const MOST_MARGIN: f64 = 1.0 / (1u64 << 10) as f64;

/// A body between two polyhedra, in the world.
#[derive(Debug)]
pub(crate) struct Polyhedra {
    /// Triangles in the body.
    pub(crate) inner: Facets,
    /// Closed; the body is inside.
    pub(crate) outer: Facets,
}

/// Radius and height, from the bottom up.
type Outline = Vec<[f64; 2]>;

impl Polyhedra {
    /// `None` for quadrics, and where rounding is not small beside the body.
    pub(crate) fn of(body: &Analytic, placement: &Placement) -> Option<Self> {
        let [inner, outer] = outlines(body)?;
        let stretch = match body {
            Analytic::Ellipsoid { radii } => (*radii).into(),
            _ => DVec3::ONE,
        };
        let reach = outer.iter().fold([0.0_f64; 2], |reach, point| [0, 1].map(|k| reach[k].max(point[k].abs())));
        let half = DVec3::new(reach[0], reach[1], reach[0]) * stretch;
        let middle = middle_of(body);
        let margin =
            margin(half, placement).map(|margin| margin * slender(body)).filter(|margin| *margin < MOST_MARGIN)?;
        let placed = |outline: &Outline, wider: f64, scale: f64| {
            let corner = |point: DVec3| (middle + (point - middle) * scale).to_array();
            let (points, triangles) = turned(outline, wider);
            let positions = points.into_iter().map(|point| corner(point * stretch)).collect();
            Some(Facets::of_mesh(Mesh::new(positions, triangles).ok()?, placement))
        };
        let wider = 1.0 / (PI / f64::from(AROUND)).cos();
        Some(Self { inner: placed(&inner, 1.0, 1.0 - margin)?, outer: placed(&outer, wider, 1.0 + margin)? })
    }
}

/// The outline of the inner polyhedron, and of the outer one before it is turned; of an ellipsoid those of the unit ball.
fn outlines(body: &Analytic) -> Option<[Outline; 2]> {
    let straight = |outline: Outline| Some([outline.clone(), outline]);
    match *body {
        Analytic::Sphere { radius } => Some(capped_by_arcs(radius, 0.0)),
        Analytic::Ellipsoid { .. } => Some(capped_by_arcs(1.0, 0.0)),
        Analytic::Capsule { radius, height } => Some(capped_by_arcs(radius, 0.5 * height)),
        Analytic::Cylinder { radius, height } => straight(vec![[radius, -0.5 * height], [radius, 0.5 * height]]),
        Analytic::Hyperboloid { waist_radius, end_radius: radius, height } if waist_radius == radius => {
            straight(vec![[radius, -0.5 * height], [radius, 0.5 * height]])
        }
        Analytic::Hyperboloid { waist_radius, end_radius, height } => Some(hyperbola(waist_radius, end_radius, height)),
        Analytic::Cone { radius, height } => straight(vec![[radius, -0.5 * height], [0.0, 0.5 * height]]),
        Analytic::Frustum { bottom_radius, top_radius, height } => {
            straight(vec![[bottom_radius, -0.5 * height], [top_radius, 0.5 * height]])
        }
        Analytic::Paraboloid { radius, height } => Some(parabola(radius, height)),
        Analytic::Disk { radius } => {
            Some([vec![[radius, 0.0]], vec![[radius, -THIN * radius], [radius, THIN * radius]]])
        }
        _ => None,
    }
}

/// A line along the axis with a quarter of a circle at either end; its tangents cross half-way between the points that they touch.
fn capped_by_arcs(radius: f64, half_height: f64) -> [Outline; 2] {
    let step = FRAC_PI_2 / f64::from(ALONG);
    let quarter = |number: i32, offset: f64, radius: f64| {
        let angles = (0..number).map(move |k| (f64::from(k) + offset) * step);
        // From the end of the axis to the side.
        angles.map(move |angle| [radius * angle.sin(), half_height + radius * angle.cos()]).collect::<Outline>()
    };
    let both = |quarter: Outline| {
        let below = quarter.iter().map(|&[r, y]| [r, -y]);
        below.chain(quarter.iter().rev().copied()).collect::<Outline>()
    };
    let mut tangents = quarter(ALONG, 0.5, radius / (0.5 * step).cos());
    tangents.insert(0, [0.0, half_height + radius]);
    tangents.push([radius, half_height]);
    [both(quarter(ALONG + 1, 0.0, radius)), both(tangents)]
}

/// Tangents of a parabola at the radii p and q cross at (p + q)/2, as far below its apex as it is itself at √(pq).
fn parabola(radius: f64, height: f64) -> [Outline; 2] {
    let at = |k: i32| radius * f64::from(k) / f64::from(ALONG);
    let y = |square: f64| 0.5 * height - height * square / (radius * radius);
    let inner = (0..=ALONG).rev().map(|k| [at(k), y(at(k) * at(k))]).collect();
    let crossings = (0..ALONG).rev().map(|k| [0.5 * (at(k) + at(k + 1)), y(at(k) * at(k + 1))]);
    let mut outer: Outline = std::iter::once([radius, -0.5 * height]).chain(crossings).collect();
    outer.push([0.0, 0.5 * height]);
    [inner, outer]
}

/// A branch of a hyperbola, a·(cosh u, c·sinh u): tangents at u and v cross at the point of their mean, 1/cosh((v − u)/2) as far from the middle.
fn hyperbola(waist: f64, end: f64, height: f64) -> [Outline; 2] {
    let most = libm::acosh(end / waist);
    let step = most / f64::from(ALONG);
    let at = |u: f64| [waist * libm::cosh(u), 0.5 * height * (libm::sinh(u) / libm::sinh(most))];
    let chords: Outline = (-ALONG..=ALONG).map(|k| at(f64::from(k) * step)).collect();
    let crossings = (-ALONG..ALONG).map(|k| at((f64::from(k) + 0.5) * step));
    let nearer = 1.0 / libm::cosh(0.5 * step);
    let mut tangents = vec![[end, -0.5 * height]];
    tangents.extend(crossings.map(|[radius, y]| [radius * nearer, y * nearer]));
    tangents.push([end, 0.5 * height]);
    [tangents, chords]
}

/// How many times the margin of a convex body a body needs: where a hyperboloid has the slope of its ends, scaling moves its surface less than the ends.
fn slender(body: &Analytic) -> f64 {
    match *body {
        Analytic::Hyperboloid { waist_radius, end_radius, .. } => (end_radius / waist_radius).powi(2),
        _ => 1.0,
    }
}

/// A point with at least a quarter of the body's half extents about it, along every axis, in the body.
fn middle_of(body: &Analytic) -> DVec3 {
    let quarter = match *body {
        Analytic::Cone { height, .. } | Analytic::Paraboloid { height, .. } => -0.25 * height,
        Analytic::Frustum { bottom_radius, top_radius, height } => {
            0.25 * height * if bottom_radius < top_radius { 1.0 } else { -1.0 }
        }
        _ => 0.0,
    };
    DVec3::Y * quarter
}

/// By what share a body with these half extents must grow so that what rounding moves is still outside: twelve times the greatest
/// share of a half extent by which a corner may move along an axis, twice that for the roundings in here.
fn margin(half: DVec3, placement: &Placement) -> Option<f64> {
    let map = placement.map();
    let far = map
        .matrix3
        .to_cols_array_2d()
        .iter()
        .zip([half.x, half.y, half.z])
        .fold(map.translation.abs(), |far, (column, half)| far + DVec3::from_array(*column).abs() * (2.0 * half));
    let moved = far * f64::EPSILON;
    let local = DVec3::from_array(placement.inverse_bounds().map(|row| DVec3::from_array(row).dot(moved)));
    let share = (local / half).max_element();
    share.is_finite().then_some(ROUNDING + 24.0 * share)
}

/// Corners and triangles of an outline turned about the y axis, `wider` times as large; closed at both ends, of a single point a sheet.
fn turned(outline: &Outline, wider: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let on_axis = |point: &[f64; 2]| [0.0, point[1]];
    let ends = if outline.len() == 1 { None } else { outline.last().map(on_axis) };
    let whole = outline.first().map(on_axis).into_iter().chain(outline.iter().copied()).chain(ends);
    let mut before: Option<(u32, bool)> = None;
    for [radius, y] in whole {
        let first = points.len() as u32;
        let is_point = radius == 0.0;
        let count = if is_point { 1 } else { AROUND };
        points.extend((0..count).map(|k| {
            let angle = 2.0 * PI * f64::from(k) / f64::from(AROUND);
            DVec3::new(wider * radius * angle.cos(), y, wider * radius * angle.sin())
        }));
        for k in 0..AROUND {
            let next = (k + 1) % AROUND;
            match before {
                Some((below, true)) if !is_point => triangles.push([below, first + k, first + next]),
                Some((below, false)) if is_point => triangles.push([below + k, first, below + next]),
                Some((below, false)) => {
                    triangles.push([below + k, first + k, first + next]);
                    triangles.push([below + k, first + next, below + next]);
                }
                _ => {}
            }
        }
        before = Some((first, is_point));
    }
    (points, triangles)
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DMat3, DQuat};
    use umbriel_geometry::{LightSource, PlacedAnalytic, Sign};

    use super::*;
    use crate::exact::patch_probe;

    const BODIES: [Analytic; 9] = [
        Analytic::Sphere { radius: 0.7 },
        Analytic::Ellipsoid { radii: [0.5, 2.0, 1.0] },
        Analytic::Cylinder { radius: 0.5, height: 2.0 },
        Analytic::Cone { radius: 1.0, height: 0.5 },
        Analytic::Frustum { bottom_radius: 0.25, top_radius: 1.0, height: 1.0 },
        Analytic::Capsule { radius: 0.3, height: 1.0 },
        Analytic::Paraboloid { radius: 1.0, height: 2.0 },
        Analytic::Hyperboloid { waist_radius: 0.5, end_radius: 0.5, height: 1.0 },
        Analytic::Disk { radius: 1.0 },
    ];

    /// On which side of each outward plane of a closed mesh about its middle all of the points lie.
    fn holds(facets: &Facets, middle: DVec3, point: DVec3) -> bool {
        (0..facets.len()).all(|face| {
            let numbers = facets.facet(face).corners();
            let [a, b, c] = [0, 1, 2].map(|k| facets.positions()[numbers[k] as usize]);
            let normal = (b - a).cross(c - a);
            let outward = normal * (a - middle).dot(normal).signum();
            // Faces of no area, where the outline ends on the axis, say nothing.
            (point - a).dot(outward) <= 1e-9 * normal.length()
        })
    }

    /// Turned, and stretched differently along each axis.
    fn stretched() -> Placement {
        let turn = DQuat::from_xyzw(0.2, -0.4, 0.1, 0.9).normalize();
        let map =
            DAffine3::from_scale_rotation_translation(DVec3::new(1.0, 0.5, 2.0), turn, DVec3::new(5.0, -3.0, 2.0));
        Placement::new(map).expect("regular")
    }

    #[test]
    fn bodies_are_between() {
        let placement = stretched();
        for body in BODIES {
            let between = Polyhedra::of(&body, &placement).unwrap_or_else(|| panic!("{body:?}"));
            let placed = PlacedAnalytic::new(body, placement).expect("a body");
            let middle = between.outer.positions().iter().sum::<DVec3>() / between.outer.positions().len() as f64;
            for (face, u, v) in (0..body.face_count()).flat_map(|face| (0..200).map(move |k| (face, k / 15, k % 15))) {
                let [u, v] = [u, v].map(|t| f64::from(t) / 14.0);
                let Some(probe) = patch_probe(&placed, face, u.min(1.0), v) else { continue };
                assert!(holds(&between.outer, middle, probe.bounds.position), "{body:?}: {face} ({u}, {v}) is outside");
            }
            for &corner in between.inner.positions() {
                assert!(holds(&between.outer, middle, corner), "{body:?}: {corner} is outside");
                let lamp = LightSource::point(corner.to_array()).expect("a lamp");
                let is_inside = placed.light_side(&lamp) == Sign::Negative;
                assert!(is_inside || !body.is_closed(), "{body:?}: {corner} is not inside");
            }
            let gap = between.outer.bounds().size() - between.inner.bounds().size();
            assert!(gap.max_element() < 0.03 * between.outer.bounds().size().max_element(), "{body:?}: {gap}");
        }
    }

    /// A matrix whose columns are nearly parallel to each other, so that its inverse has no digit right when it is computed in floats.
    #[test]
    fn inner_corners_of_needles_are_inside_or_there_are_none() {
        let columns = [
            [0.9144652231682989, 0.7713461635755045, 1.3991075526609589],
            [0.94045245323253, 0.7932662431208143, 1.4388673285625195],
            [0.6853951105353164, 0.5781268394221618, 1.0486363543551827],
        ];
        let map = |share: f64| {
            let matrix3 = DMat3::from_cols_array_2d(&columns) + DMat3::IDENTITY * share;
            Placement::new(DAffine3 { matrix3, translation: DVec3::splat(8.0) }).expect("regular")
        };
        let mut bounded = 0;
        for placement in [0.0, 2f64.powi(-30), 2f64.powi(-20), 2f64.powi(-10), 1.0].map(map) {
            for body in BODIES.into_iter().filter(Analytic::is_closed) {
                let Some(between) = Polyhedra::of(&body, &placement) else { continue };
                bounded += 1;
                let placed = PlacedAnalytic::new(body, placement).expect("a body");
                for corner in between.inner.positions() {
                    let lamp = LightSource::point(corner.to_array()).expect("a lamp");
                    assert_eq!(placed.light_side(&lamp), Sign::Negative, "{body:?}: {corner} is not inside");
                }
            }
        }
        assert!(bounded >= 8, "{bounded}");
    }

    /// How often a closed surface winds about a point: the sum of the solid angles of its triangles (Van Oosterom and Strackee 1983), a sphere for one.
    fn winding(facets: &Facets, point: DVec3) -> f64 {
        let angle = |face: usize| {
            let numbers = facets.facet(face).corners();
            let [a, b, c] = [0, 1, 2].map(|k| facets.positions()[numbers[k] as usize] - point);
            let [x, y, z] = [a, b, c].map(|corner| corner.length());
            let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
            2.0 * a.dot(b.cross(c)).atan2(below)
        };
        ((0..facets.len()).map(angle).sum::<f64>() / (4.0 * PI)).abs()
    }

    #[test]
    fn a_hyperboloid_is_between() {
        let placement = stretched();
        for [waist_radius, end_radius, height] in [[0.5, 1.0, 2.0], [0.1, 1.0, 0.5], [0.9, 1.0, 4.0]] {
            let body = Analytic::Hyperboloid { waist_radius, end_radius, height };
            let between = Polyhedra::of(&body, &placement).unwrap_or_else(|| panic!("{body:?}"));
            let placed = PlacedAnalytic::new(body, placement).expect("a body");
            for (face, u, v) in (0..body.face_count()).flat_map(|face| (0..64).map(move |k| (face, k / 8, k % 8))) {
                let [u, v] = [u, v].map(|t| f64::from(t) / 7.0);
                let Some(probe) = patch_probe(&placed, face, u, v) else { continue };
                let at = probe.bounds.position;
                let [outer, inner] = [&between.outer, &between.inner].map(|facets| winding(facets, at));
                // Whole numbers, but for rounding, which is large where the point is within 2^-40 of a triangle.
                assert_eq!((outer.round(), inner.round()), (1.0, 0.0), "{body:?}: {face} ({u}, {v}): {outer} {inner}");
            }
            // Corners, edges and middles of the inner triangles are in the body.
            for face in 0..between.inner.len() {
                let numbers = between.inner.facet(face).corners();
                let [a, b, c] = [0, 1, 2].map(|k| between.inner.positions()[numbers[k] as usize]);
                for at in [a, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0] {
                    let lamp = LightSource::point(at.to_array()).expect("a lamp");
                    assert_eq!(placed.light_side(&lamp), Sign::Negative, "{body:?}: {at} is not inside");
                }
            }
            let gap = between.outer.bounds().size() - between.inner.bounds().size();
            assert!(gap.max_element() < 0.03 * between.outer.bounds().size().max_element(), "{body:?}: {gap}");
        }
    }

    #[test]
    fn what_rounding_moves_is_not_bounded() {
        let far = Placement::new(DAffine3::from_translation(DVec3::X * 1e15)).expect("regular");
        assert!(Polyhedra::of(&BODIES[0], &far).is_none());
        assert!(
            Polyhedra::of(&Analytic::Quadric { matrix: [[1.0; 4]; 4], within: [[0.0; 3], [1.0; 3]] }, &far).is_none()
        );
    }
}
