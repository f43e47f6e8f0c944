//! Convex polygons cut by planes, in floats.

use glam::DVec3;

/// The part of a convex polygon where values at its corners are not negative (Sutherland and Hodgman 1974).
pub(crate) fn cut(polygon: &[DVec3], values: &[f64]) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, (&corner, &value)) in polygon.iter().zip(values).enumerate() {
        let next = (k + 1) % polygon.len();
        if value >= 0.0 {
            kept.push(corner);
        }
        if (value > 0.0 && values[next] < 0.0) || (value < 0.0 && values[next] > 0.0) {
            kept.push(corner.lerp(polygon[next], value / (value - values[next])));
        }
    }
    kept
}
