//! The shaft between a light and a box: what can shadow the box lies in it (Haines and Wallace, "Shaft culling for
//! efficient ray-traced radiosity", Eurographics Workshop on Rendering 1991, for one light point and exact intervals).
//!
//! Question: does any point of an occluder box A lie on the segment from some point of a receiver box B to the light?
//!
//! **Point light L.** The points between b and L are L + m (b − L) with 0 < m ≤ 1, so we ask for an m in (0, 1], an a
//! in A and a b in B with a − L = m (b − L). For a fixed m > 0 the axes are independent, because A and B are products
//! of intervals; on one axis the intervals \[A⁻ − L, A⁺ − L\] and m·\[B⁻ − L, B⁺ − L\] meet if and only if
//!
//! ```text
//! m (B⁺ − L) ≥ A⁻ − L   and   m (B⁻ − L) ≤ A⁺ − L.
//! ```
//!
//! **Sun with vector d towards it.** The points between b and the sun are b + s d with s ≥ 0; by the same argument
//! the answer on one axis is s d ≥ A⁻ − B⁺ and s d ≤ A⁺ − B⁻.
//!
//! Both are six inequalities linear in one parameter: each bounds it from below or from above, and the answer is yes
//! if and only if the greatest lower bound does not exceed the least upper bound. No axes of separation, no corners.
//!
//! **Rounding.** Every bound is a difference of two input numbers times the reciprocal of another difference (or of
//! an input number): four roundings, so a computed bound is its true value times a factor between (1 − u)⁴ and
//! (1 + u)⁴, and its sign is right (a rounded difference is zero only for equal numbers). If the true bounds satisfy
//! lower ≤ upper, the computed ones satisfy lower ≤ upper·((1 + u)/(1 − u))⁴ < upper·(1 + 9u). The test allows
//! 1 + 16u, which covers its own product too: it never says no in vain, and says yes in vain only when the bounds
//! miss each other by less than 25u of themselves. A factor is used, not a length, so scaling by powers of two
//! changes nothing. In the accepted range of coordinates no step overflows or underflows.
//!
//! Every step is monotone in the occluder's box, so a larger box never gets a no where a smaller one inside it gets a
//! yes: a tree of boxes answers exactly as a loop over its boxes. So is it in the receiver's: differences, reciprocals of one sign and products are
//! monotone as rounded, and where a difference from a lamp changes its sign, its bound goes from an upper one over none (NaN, −infinity) to a lower one.

mod columns;

use glam::DVec3;
use umbriel_geometry::{Aabb, LightSource};

/// 1 + 16u; see the header.
const OUTWARD: f64 = 1.0 + 8.0 * f64::EPSILON;

/// The open segment from a point to a light; for a sun it never ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Where it begins, world coordinates in metres.
    pub origin: DVec3,
    /// Where it ends.
    pub light: LightSource,
}

impl Segment {
    /// The segment from `origin` to `light`.
    pub fn new(origin: DVec3, light: LightSource) -> Self {
        Self { origin, light }
    }

    /// The test that finds the boxes on this segment.
    pub fn shaft(&self) -> Shaft {
        Shaft::new(&Aabb { min: self.origin, max: self.origin }, &self.light)
    }
}

impl From<Segment> for Shaft {
    fn from(segment: Segment) -> Self {
        segment.shaft()
    }
}

/// All segments from the points of a receiver box to a light, prepared for tests against many boxes.
///
/// The shaft includes the receiver box and is open at a point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaft {
    /// What is taken from an occluder's least coordinates: L, or the receiver's greatest coordinates for a sun.
    from_min: DVec3,
    /// What is taken from an occluder's greatest coordinates: L, or the receiver's least coordinates for a sun.
    from_max: DVec3,
    /// Reciprocal of the parameter's factor in the inequality of the occluder's least coordinates.
    inverse_min: DVec3,
    /// The same for the greatest coordinates.
    inverse_max: DVec3,
    /// Greatest value of the parameter: 1 for a point light, infinity for a sun.
    end: f64,
}

impl Shaft {
    /// The shaft from the closed box `receiver` to `light`. Cost: six divisions.
    ///
    /// The box must not be empty: the shaft of nothing is not defined, and its answers mean nothing.
    pub fn new(receiver: &Aabb, light: &LightSource) -> Self {
        // Adding zero makes −0 a +0, whose reciprocal is the +infinity that `may_meet` relies on.
        let inverse = |factor: DVec3| (factor + DVec3::ZERO).recip();
        let xyz = light.xyz();
        if light.is_sun() {
            let inverse = inverse(xyz);
            let end = f64::INFINITY;
            Self { from_min: receiver.max, from_max: receiver.min, inverse_min: inverse, inverse_max: inverse, end }
        } else {
            let (inverse_min, inverse_max) = (inverse(receiver.max - xyz), inverse(receiver.min - xyz));
            Self { from_min: xyz, from_max: xyz, inverse_min, inverse_max, end: 1.0 }
        }
    }

    /// Whether part of the closed box `occluder` may lie in the shaft: no is a proof, yes is exact up to rounding.
    ///
    /// Cost: 6 subtractions, 6 multiplications, 6 comparisons.
    #[inline]
    pub fn may_meet(&self, occluder: &Aabb) -> bool {
        let low = (occluder.min - self.from_min) * self.inverse_min;
        let high = (occluder.max - self.from_max) * self.inverse_max;
        let (mut lower, mut upper) = (0.0, self.end);
        for axis in 0..3 {
            // A factor of zero leaves 0 ≥ A⁻ − … or 0 ≤ A⁺ − …: its reciprocal +infinity turns the other side into
            // ±infinity of the right sign, and equality into NaN, which `min` and `max` pass over.
            bound(&mut lower, &mut upper, low[axis], self.inverse_min[axis] > 0.0);
            bound(&mut lower, &mut upper, high[axis], self.inverse_max[axis] < 0.0);
        }
        // At zero there is the light: a point light itself is no part of the shaft.
        lower <= upper * OUTWARD && (upper > 0.0 || self.end > 1.0)
    }
}

/// Takes one more bound of the parameter.
#[inline]
fn bound(lower: &mut f64, upper: &mut f64, value: f64, is_lower: bool) {
    // NaN bounds nothing.
    if is_lower && value > *lower {
        *lower = value;
    } else if !is_lower && value < *upper {
        *upper = value;
    }
}
