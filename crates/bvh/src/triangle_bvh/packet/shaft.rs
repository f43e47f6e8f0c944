//! The shaft of a packet: all segments from the box of its origins to the light.
//!
//! As in the crate's `shaft.rs`, for a parameter m along the segments and the box B of the origins, a box A is met only
//! if m(B⁺ − L) ≥ A⁻ − L and m(B⁻ − L) ≤ A⁺ − L on each axis. B and L are moved outward by their errors; factors that are
//! nearly zero are moved outward to 2^-40; each bound is off by a factor of little more than 1 ± 4u.

use umbriel_geometry::simd::{Float, Mask, Simd};

use super::{
    super::{
        layout::Node,
        ray::{LEAST_SLOPE, OUTWARD, SLOPE_SLACK, U},
    },
    LocalLight, Packet,
};

/// The shaft from a packet's box to the light, made ready for boxes.
pub(super) struct Shaft {
    axes: [ShaftAxis; 3],
    end: f32,
}

/// One axis: what is taken from a box's least coordinate and what the difference is multiplied by, whether that bounds
/// the parameter from below; the same for its greatest coordinate.
struct ShaftAxis {
    from: [f32; 2],
    factor: [f32; 2],
    is_lower: [bool; 2],
}

impl Shaft {
    #[inline(always)]
    pub(super) fn new(packet: &Packet, light: &LocalLight) -> Self {
        let (low, high) = (packet.middle - packet.half, packet.middle + packet.half);
        let axis = |axis: usize| {
            let (at, slack) = (light.xyz[axis], light.error + 4.0 * U * light.xyz[axis].abs());
            // The rounding of `low` and `high` is within the slack of the half size, that of the light within its own.
            let (factors, from) = if light.is_sun {
                let slope = if at.abs() < LEAST_SLOPE { LEAST_SLOPE } else { at };
                ([slope; 2], [high[axis] + SLOPE_SLACK, low[axis] - SLOPE_SLACK])
            } else {
                let (up, down) = (high[axis] - (at - slack), low[axis] - (at + slack));
                let up = if up.abs() < LEAST_SLOPE { LEAST_SLOPE } else { up };
                let down = if down.abs() < LEAST_SLOPE { -LEAST_SLOPE } else { down };
                ([up, down], [at + slack, at - slack])
            };
            let is_lower = [factors[0] > 0.0, factors[1] < 0.0];
            ShaftAxis { from, factor: [1.0 / factors[0], 1.0 / factors[1]], is_lower }
        };
        let end = if light.is_sun { f32::MAX } else { 1.0 };
        Self { axes: [axis(0), axis(1), axis(2)], end }
    }

    /// Which of the boxes the shaft may meet, a bit each.
    #[inline(always)]
    pub(super) fn boxes_met<S: Simd>(&self, simd: S, node: &Node) -> u32 {
        let (mut lower, mut upper) = (simd.splat8(0.0), simd.splat8(self.end));
        for (axis, bounds) in self.axes.iter().enumerate() {
            for side in 0..2 {
                let row = simd.load(&node.planes[axis + 3 * side]);
                let bound = (row - simd.splat8(bounds.from[side])) * simd.splat8(bounds.factor[side]);
                if bounds.is_lower[side] {
                    lower = lower.max(bound);
                } else {
                    upper = upper.min(bound);
                }
            }
        }
        lower.le(upper * simd.splat8(OUTWARD)).bits()
    }
}
