//! Faces that reach beyond the view of a lamp, cut to what the view needs.
//!
//! A lamp inside the scene has faces behind it and faces beside its six windows. They are cut at the planes of a
//! pyramid a little wider than the window (Sutherland and Hodgman 1974): the cuts lie outside of the window, so no
//! sample is near them, and only the images of the true edges count. Corners at a cut are rounded; where that could move
//! an image by more than half a quantum, near the lamp itself, the face is not bounded at all.

use super::view::{Image, View};

/// Where faces are cut, in half windows from the middle.
const CUT: f64 = 1.5;

/// The images of a convex polygon's corners (homogeneous, quanta, coordinates off by `slack` metres), cut; empty when the view
/// sees nothing of it for certain, `None` when no rounded corner can stand for a cut.
pub(super) fn clip(mut polygon: Vec<[f64; 3]>, slack: f64, view: &View) -> Option<Vec<Image>> {
    let wide = CUT * view.half[0];
    let size = polygon.iter().flatten().fold(0.0, |size: f64, x| size.max(x.abs()));
    let farthest = polygon.iter().fold(0.0, |most: f64, point| most.max(point[2].abs()));
    // What rounded corners and rounded cuts say of sides is off by less: a polygon that nearly meets the lamp is not lost.
    let off = 64.0 * f64::EPSILON * (size + wide * farthest) + 8.0 * (view.in_quanta(slack) + wide * slack);
    let sides: [fn([f64; 3], f64) -> f64; 4] =
        [|p, w| w * p[2] - p[0], |p, w| w * p[2] + p[0], |p, w| w * p[2] - p[1], |p, w| w * p[2] + p[1]];
    for side in sides {
        polygon = cut(&polygon, |point| side(point, wide) + off);
        if polygon.len() < 3 {
            return Some(Vec::new());
        }
    }
    let images = polygon.into_iter().map(|[x, y, z]| {
        // A cut corner is off by some roundings of the greatest number that went into it.
        let is_sharp = z > 0.0 && off <= 0.5 * z;
        let depth = view.depth_before_lamp(z);
        let image = || Image { x: (x / z).round_ties_even() as i32, y: (y / z).round_ties_even() as i32, depth };
        is_sharp.then(image)
    });
    images.collect()
}

/// The part of a polygon where `side` is not negative.
fn cut(polygon: &[[f64; 3]], side: impl Fn([f64; 3]) -> f64) -> Vec<[f64; 3]> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &from) in polygon.iter().enumerate() {
        let to = polygon[(k + 1) % polygon.len()];
        let (a, b) = (side(from), side(to));
        if a >= 0.0 {
            kept.push(from);
        }
        if (a >= 0.0) != (b >= 0.0) {
            let t = a / (a - b);
            kept.push([0, 1, 2].map(|i| from[i] + t * (to[i] - from[i])));
        }
    }
    kept
}
