//! The tight world box of a placed body, by its support function: the greatest n·x over the body.

use glam::DVec3;

use super::Analytic;
use crate::{aabb::Aabb, placement::Placement};

/// Roundings of a support value: squares, sums, a root, a quotient and products of numbers of the reach's size.
const PADDING: f64 = 8.0 * f64::EPSILON;

/// The box, rounded outward.
pub(crate) fn of(body: &Analytic, placement: &Placement) -> Aabb {
    let map = placement.map();
    let extent = DVec3::from_array(body.half_extent());
    let mut bounds = Aabb { min: map.translation, max: map.translation };
    for axis in 0..3 {
        let row = map.matrix3.row(axis);
        let reach = row.abs().dot(extent) * PADDING;
        bounds.max[axis] = (map.translation[axis] + (support(body, row) + reach)).next_up();
        bounds.min[axis] = (map.translation[axis] - (support(body, -row) + reach)).next_down();
    }
    bounds
}

/// The greatest n·x over the body, rounded.
fn support(body: &Analytic, n: DVec3) -> f64 {
    let across = n.x.hypot(n.z);
    let disk = |radius: f64, y: f64| across * radius + n.y * y;
    match *body {
        Analytic::Sphere { radius } => radius * n.length(),
        Analytic::Ellipsoid { radii } => (DVec3::from_array(radii) * n).length(),
        Analytic::Cylinder { radius, height } | Analytic::Hyperboloid { end_radius: radius, height, .. } => {
            disk(radius, 0.5 * height).max(disk(radius, -0.5 * height))
        }
        Analytic::Cone { radius, height } => disk(0.0, 0.5 * height).max(disk(radius, -0.5 * height)),
        Analytic::Frustum { bottom_radius, top_radius, height } => {
            disk(top_radius, 0.5 * height).max(disk(bottom_radius, -0.5 * height))
        }
        Analytic::Capsule { radius, height } => radius * n.length() + 0.5 * height * n.y.abs(),
        Analytic::Disk { radius } => disk(radius, 0.0),
        Analytic::Paraboloid { radius, height } => {
            // On the outline (radius·w, height·(½ − w²)), w in 0..=1, the slope vanishes at w = across·radius/(2·n.y·height).
            let (sideways, upward) = (across * radius, n.y * height);
            let w = if upward > 0.0 && sideways < 2.0 * upward { sideways / (2.0 * upward) } else { 1.0 };
            sideways * w + upward * (0.5 - w * w)
        }
        Analytic::Quadric { within: [low, high], .. } => (0..3).map(|k| (n[k] * low[k]).max(n[k] * high[k])).sum(),
    }
}
