//! A portal as an eye takes it: as it is where it is exact, else so much wider that what is meant is seen through it, too.
//!
//! Corners and walls are rounded, so the true opening lies a little off the plane of the corners, and from a flat angle a little height
//! is a long way in the plane. NUMERICS.md §18 has the derivation: with E the heights and slacks together, r the radius of a circle in the
//! polygon and c = h/D the eye's height by its distance (or the sine of a sun's angle), widening by 16E/c holds everything, if h is above 8E(1 + D/r).
//! Otherwise the eye counts as being in the plane.

use std::borrow::Cow;

use glam::DVec3;
use umbriel_geometry::LightSource;
use umbriel_scene::Portal;

use super::frustum::{EyeSide, side_of_eye};

/// How an eye lies to a portal, and the corners of what it sees through it.
pub(super) type Opening<'a> = (EyeSide, Cow<'a, [DVec3]>);

/// As an eye takes a portal.
pub(super) fn seen<'a>(eye: &LightSource, portal: &'a Portal) -> Opening<'a> {
    let corners = &portal.corners;
    if portal.slack == 0.0 {
        return (side_of_eye(eye, corners), Cow::Borrowed(corners));
    }
    match widened(eye, portal) {
        Some((side, wider)) => (side, Cow::Owned(wider)),
        None => (EyeSide::Within, Cow::Borrowed(corners)),
    }
}

/// The wider polygon; `None` if the eye is too near its plane, or the polygon too narrow.
fn widened(eye: &LightSource, portal: &Portal) -> Option<(EyeSide, Vec<DVec3>)> {
    let corners = &portal.corners;
    let count = corners.len();
    let middle = corners.iter().sum::<DVec3>() / count as f64;
    let doubled = (1..count - 1).map(|k| (corners[k] - corners[0]).cross(corners[k + 1] - corners[0]));
    let normal = doubled.sum::<DVec3>().normalize_or_zero();
    let to_edge = |k: usize| {
        let (from, to) = (corners[k], corners[(k + 1) % count]);
        normal.cross((to - from).normalize_or_zero()).dot(middle - from)
    };
    let radius = (0..count).map(to_edge).fold(f64::INFINITY, f64::min);
    let off = corners.iter().map(|&corner| normal.dot(corner - middle).abs()).fold(0.0, f64::max);
    // A slack is a coordinate's; the factor also holds the roundings here, some ulps where a slack is one at least.
    let error = 4.0 * (off + 2.0 * portal.slack);
    let (height, distance) = if eye.is_sun() {
        (normal.dot(eye.xyz().normalize_or_zero()), 1.0)
    } else {
        let far = corners.iter().map(|corner| corner.distance(eye.xyz())).fold(0.0, f64::max);
        (normal.dot(eye.xyz() - middle), far)
    };
    let at_the_eye = if eye.is_sun() { 0.0 } else { error };
    let wider = 16.0 * error * distance / height.abs() / radius;
    // Written so that what is no number is refused.
    let is_clear = height.abs() > 8.0 * (at_the_eye + error * distance / radius) && wider <= 1.0;
    let side = if height > 0.0 { EyeSide::Front } else { EyeSide::Behind };
    is_clear.then(|| (side, corners.iter().map(|&corner| corner + (corner - middle) * wider).collect()))
}
