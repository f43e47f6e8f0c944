//! Many rays against eight boxes at once, by what bounds all of them.
//!
//! *A packet's segments to a light.* As in the crate's `shaft.rs`, for a parameter m along the segments and the box B of the origins, a
//! box A is met only if m(B⁺ − L) ≥ A⁻ − L and m(B⁻ − L) ≤ A⁺ − L on each axis. B and L are moved outward by their errors;
//! factors that are nearly zero are moved outward to 2^-40; each bound is off by a factor of little more than 1 ± 4u.
//!
//! *Rays of a bundle.* Those that are t along, each by its own t ≥ 0, lie between o⁻ + t d⁻ and o⁺ + t d⁺ with the extremes of their
//! origins and directions. So A is met only if t d⁺ ≥ A⁻ − o⁺ and t d⁻ ≤ A⁺ − o⁻: the same form, and the same roundings.

use umbriel_geometry::simd::{F8, Float, M8, Mask, Simd};

use super::{
    bundle::Lines,
    layout::Node,
    packet::{LocalLight, Packet},
    ray::{LEAST_SLOPE, OUTWARD, SLOPE_SLACK, U},
};

/// What bounds all the rays, made ready for boxes.
pub(super) struct Shaft {
    axes: [ShaftAxis; 3],
    /// Where the last of them ends.
    pub(super) end: f32,
}

/// One axis: what is taken from a box's least coordinate and what the difference is multiplied by, whether that bounds
/// the parameter from below; the same for its greatest coordinate.
struct ShaftAxis {
    from: [f32; 2],
    factor: [f32; 2],
    is_lower: [bool; 2],
}

impl ShaftAxis {
    /// What is taken from the least and the greatest coordinates, and the greatest and the least factor.
    fn new(from: [f32; 2], [up, down]: [f32; 2]) -> Self {
        let up = if up.abs() < LEAST_SLOPE { LEAST_SLOPE } else { up };
        let down = if down.abs() < LEAST_SLOPE { -LEAST_SLOPE } else { down };
        Self { from, factor: [1.0 / up, 1.0 / down], is_lower: [up > 0.0, down < 0.0] }
    }
}

impl Shaft {
    /// From a packet's box to the light.
    #[inline(always)]
    pub(super) fn towards(packet: &Packet, light: &LocalLight) -> Self {
        let (low, high) = (packet.middle - packet.half, packet.middle + packet.half);
        let axis = |axis: usize| {
            let (at, slack) = (light.xyz[axis], light.error + 4.0 * U * light.xyz[axis].abs());
            // The rounding of `low` and `high` is within the slack of the half size, that of the light within its own.
            if light.is_sun {
                let slope = if at.abs() < LEAST_SLOPE { LEAST_SLOPE } else { at };
                ShaftAxis::new([high[axis] + SLOPE_SLACK, low[axis] - SLOPE_SLACK], [slope; 2])
            } else {
                let factors = [high[axis] - (at - slack), low[axis] - (at + slack)];
                ShaftAxis::new([at + slack, at - slack], factors)
            }
        };
        let end = if light.is_sun { f32::MAX } else { 1.0 };
        Self { axes: [axis(0), axis(1), axis(2)], end }
    }

    /// Around the first lanes of a bundle, which end at `end`.
    pub(super) fn around(lines: &Lines, count: usize, end: f32) -> Self {
        let least =
            |lanes: &[f32]| lanes.iter().fold(f32::INFINITY, |least, &lane| if lane < least { lane } else { least });
        let most =
            |lanes: &[f32]| lanes.iter().fold(f32::NEG_INFINITY, |most, &lane| if lane > most { lane } else { most });
        let axis = |axis: usize| {
            let directions = &lines.directions[axis][..count];
            let from = [most(&lines.raised[axis][..count]), least(&lines.lowered[axis][..count])];
            ShaftAxis::new(from, [most(directions), least(directions)])
        };
        Self { axes: [axis(0), axis(1), axis(2)], end }
    }

    /// Which of the boxes the shaft may meet, a bit each.
    #[inline(always)]
    pub(super) fn boxes_met<S: Simd>(&self, simd: S, node: &Node) -> u32 {
        self.box_spans(simd, node).1.bits()
    }

    /// Before where no ray enters the boxes, and which of them some ray may meet.
    #[inline(always)]
    pub(super) fn box_spans<S: Simd>(&self, simd: S, node: &Node) -> (F8<S>, M8<S>) {
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
        (lower, lower.le(upper * simd.splat8(OUTWARD)))
    }
}
