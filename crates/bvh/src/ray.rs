//! Rays for nearest-hit queries: pictures, not proofs.

use glam::DVec3;
use umbriel_geometry::Aabb;

/// 1 + 16u: the slab bounds carry three roundings each, as derived in the header of `shaft.rs`.
const OUTWARD: f64 = 1.0 + 8.0 * f64::EPSILON;

/// A ray prepared for tests against many boxes: the points `origin + t direction`, t ≥ 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// World coordinates, metres.
    pub origin: DVec3,
    /// Any length but zero.
    pub direction: DVec3,
    inverse: DVec3,
}

impl Ray {
    /// The ray from `origin` along `direction`. A ray without a direction meets every box that holds its origin.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        // Adding zero makes −0 a +0: both mean that the ray keeps its coordinate on that axis.
        Self { origin, direction, inverse: (direction + DVec3::ZERO).recip() }
    }

    /// The parameters (t of entry, t of exit) between which the ray is in the closed box, or `None` where it misses.
    ///
    /// Never misses in vain: each bound is a difference times a reciprocal, three roundings, and the comparison
    /// allows for more. Monotone: a larger box is entered no later and left no earlier.
    #[inline]
    pub fn span(&self, bounds: &Aabb) -> Option<(f64, f64)> {
        let (low, high) = ((bounds.min - self.origin) * self.inverse, (bounds.max - self.origin) * self.inverse);
        let (mut enter, mut exit) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            // NaN arises only where the ray runs inside the plane of a side; `min` and `max` pass over it.
            let forward = self.inverse[axis] > 0.0;
            let (near, far) = if forward { (low[axis], high[axis]) } else { (high[axis], low[axis]) };
            enter = enter.max(near);
            exit = exit.min(far);
        }
        (enter <= exit * OUTWARD).then_some((enter, exit))
    }
}
