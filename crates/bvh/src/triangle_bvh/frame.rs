//! The tree's own coordinates: f32 numbers between −1 and 1 for all of the mesh, with a known error.
//!
//! A point p of the world is at (p − origin)·scale, scale a power of two. The origin is zero unless the mesh lies far
//! from it: then coordinates that are f32 numbers in the file stay exact.

use glam::DVec3;
use umbriel_geometry::Aabb;

use super::bounds::Bounds;

/// Of f64.
const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// From the world's f64 to the tree's f32.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    origin: DVec3,
    scale: f64,
    /// Relative error of a localised coordinate: one rounding, or none where the origin is zero.
    rounding: f64,
}

impl Frame {
    /// A frame in which all of `bounds` lies between −1 and 1.
    pub(super) fn around(bounds: &Aabb) -> Self {
        if bounds.is_empty() {
            return Self { origin: DVec3::ZERO, scale: 1.0, rounding: 0.0 };
        }
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        let half = bounds.size().max_element() * 0.5;
        let (origin, extent) = if reach <= 4.0 * half { (DVec3::ZERO, reach) } else { (bounds.center(), half) };
        // The middle and the size are rounded; the power of two above them leaves room, but not where they are equal.
        let room = extent * (1.0 + 4.0 * f64::EPSILON) + 4.0 * f64::EPSILON * reach * f64::from(origin != DVec3::ZERO);
        let rounding = if origin == DVec3::ZERO { 0.0 } else { UNIT_ROUNDOFF };
        Self { origin, scale: reciprocal_power_of_two(room), rounding }
    }

    /// The point in the frame, with an error of at most [`Frame::error`].
    #[inline(always)]
    pub(super) fn localise(&self, point: DVec3) -> DVec3 {
        (point - self.origin) * self.scale
    }

    /// What a length of the world is multiplied by; a power of two.
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

    /// How far a localised coordinate of size `size` may be off.
    #[inline(always)]
    pub(super) fn error(&self, size: f64) -> f64 {
        size * self.rounding
    }

    /// The box of a triangle, rounded outward.
    #[inline(always)]
    pub(super) fn bounds_of(&self, [a, b, c]: [DVec3; 3]) -> Bounds {
        let (a, b, c) = (self.localise(a), self.localise(b), self.localise(c));
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        Bounds::new([below(min.x), below(min.y), below(min.z)], [above(max.x), above(max.y), above(max.z)])
    }
}

/// A power of two by which `extent` comes to lie in (1/2, 1]; 1 for zero.
fn reciprocal_power_of_two(extent: f64) -> f64 {
    if extent == 0.0 {
        return 1.0;
    }
    // 2^-ceil(log2 extent) from the exponent's bits; the accepted range is far from the subnormal numbers.
    let exponent = (extent.to_bits() >> 52) as i64 - 1023;
    let is_power = extent.to_bits() << 12 == 0;
    f64::from_bits(((1023 - exponent - i64::from(!is_power)) as u64) << 52)
}

/// A great f32 that is not above any number within 2^-52 of `value`.
#[inline(always)]
pub(super) fn below(value: f64) -> f32 {
    let nearest = value as f32;
    let certain = value - value.abs() * f64::EPSILON;
    if value == 0.0 || f64::from(nearest) < certain { nearest } else { nearest.next_down() }
}

/// A small f32 that is not below any number within 2^-52 of `value`.
#[inline(always)]
pub(super) fn above(value: f64) -> f32 {
    -below(-value)
}
