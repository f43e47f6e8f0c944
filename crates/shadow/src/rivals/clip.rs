//! Polygons cut by planes, in floats.

use glam::DVec3;

/// Keeps the part of a convex polygon where `value`, a linear function, is not negative (Sutherland and Hodgman 1974).
pub(super) fn keep_positive(polygon: &mut Vec<DVec3>, value: impl Fn(DVec3) -> f64) {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &corner) in polygon.iter().enumerate() {
        let next = polygon[(k + 1) % polygon.len()];
        let (here, there) = (value(corner), value(next));
        if here >= 0.0 {
            kept.push(corner);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            kept.push(corner + (next - corner) * (here / (here - there)));
        }
    }
    *polygon = kept;
}
