//! The depth map of an area light: where it lies, and how wide the light is in it.

use std::f64::consts::PI;

use glam::DVec3;
use umbriel_scene::{Extent, Light};
use umbriel_visibility::depth_map::LightSpace;

/// The space of an area light with a window round `corners`, and its width: the edge of a square of the same area in metres, for a ball facing the
/// middle of the corners; of a sun twice the tangent of its radius. `None` for a point.
pub fn light_space(light: &Light, corners: &[DVec3], size: usize) -> Option<(LightSpace, f64)> {
    let points = || corners.iter().copied();
    let place = light.source.xyz();
    match light.extent {
        Extent::Rectangle { u, v } => {
            let normal = u.cross(v);
            let side: f64 = points().map(|corner| normal.dot(corner - place)).sum();
            let forward = if side < 0.0 { -normal } else { normal };
            Some((LightSpace::round(place, forward, points(), size), 2.0 * normal.length().sqrt()))
        }
        Extent::Sphere { radius } => {
            let low = points().fold(DVec3::INFINITY, DVec3::min);
            let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
            let space = LightSpace::round(place, 0.5 * (low + high) - place, points(), size);
            Some((space, PI.sqrt() * radius))
        }
        Extent::Disk { angular_diameter } => {
            let width = 2.0 * libm::tan(0.5 * angular_diameter.to_radians());
            Some((LightSpace::parallel(-place, points(), size), width))
        }
        _ => None,
    }
}
