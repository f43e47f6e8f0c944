//! A numerical second opinion on the oracle: signed margins of solids in floating point, looked at along a segment.
//!
//! Only clear cases are told: the margin changes its sign between samples, or stays far from zero compared with its
//! steps. Nothing here is used to judge the library; it judges the judge.

use glam::DVec3;

use super::solids::Solid;

/// Negative inside, positive outside, zero on the surface; `None` for a body without inside.
fn margin(solid: &Solid, p: DVec3) -> Option<f64> {
    let around = p.x.hypot(p.z);
    let (over, under) = (|height: f64| p.y - height / 2.0, |height: f64| -p.y - height / 2.0);
    let between = |height: f64, inside: f64| inside.max(over(height)).max(under(height));
    Some(match *solid {
        Solid::Ellipsoid(radii) => (p / DVec3::from_array(radii)).length() - 1.0,
        Solid::Cylinder(radius, height) => between(height, around - radius),
        Solid::Frustum(low, high, height) => between(height, around - (low + (high - low) * (p.y / height + 0.5))),
        Solid::Capsule(radius, height) => {
            let nearest = DVec3::Y * p.y.clamp(-height / 2.0, height / 2.0);
            p.distance(nearest) - radius
        }
        Solid::Paraboloid(radius, height) => between(height, around * around / (radius * radius) + p.y / height - 0.5),
        Solid::Hyperboloid(waist, end, height) => {
            let share = 2.0 * p.y / height;
            between(height, around * around - waist * waist - (end * end - waist * waist) * share * share)
        }
        Solid::Disk(_) => return None,
        Solid::Quadric(matrix, [low, high]) => {
            let x = [p.x, p.y, p.z, 1.0];
            let value: f64 = (0..16).map(|k| x[k / 4] * matrix[k / 4][k % 4] * x[k % 4]).sum();
            let beyond = (p - DVec3::from_array(high)).max(DVec3::from_array(low) - p);
            value.max(beyond.max_element())
        }
    })
}

/// Whether the way from x to a light (or for a sun: towards it) crosses the surface, where that is clear.
pub(crate) fn clearly_blocks(solid: &Solid, x: DVec3, light: DVec3, is_sun: bool) -> Option<bool> {
    let count = 3_000;
    let at = |i: u32| {
        let t = (f64::from(i) + 0.5) / f64::from(count);
        if is_sun { x + light * (t / (1.0 - t)) } else { x.lerp(light, t) }
    };
    let margins: Option<Vec<f64>> = (0..count).map(|i| margin(solid, at(i))).collect();
    let margins = margins?;
    let certain = |value: f64| value.abs() > 1e-9;
    let (inside, outside) = (
        margins.iter().any(|&value| value < 0.0 && certain(value)),
        margins.iter().any(|&value| value > 0.0 && certain(value)),
    );
    if inside && outside {
        return Some(true);
    }
    let steps_are_small = margins.windows(2).all(|pair| (pair[1] - pair[0]).abs() < pair[0].abs() / 2.0);
    steps_are_small.then_some(false)
}
