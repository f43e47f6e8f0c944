//! Separating axes of a patch: what lies beside all of its samples along one of them is not over any.
//!
//! A box across the image holds three or four times as much as a slanted triangle. On a dense mesh most of what meets it are the
//! triangle's own neighbours, which share an edge or a corner with it and hide nothing of it: along a normal of the shared edge they lie beside it.
//! Source: separating axes (Gottschalk, Lin and Manocha 1996), of the one of both triangles that many are asked about.
//! Guarantee: NUMERICS.md, "Samples by scan conversion", "What is left out". Cost: some nanoseconds for eight occluders.

use umbriel_geometry::simd::{Float, Mask, Simd};

use super::pack::{Corners, ROUNDOFF, Triangles};

/// A direction across the image, and between which values along it the samples lie; coordinates are relative to the patch's middle.
#[derive(Clone, Copy, Debug)]
struct Axis {
    direction: [f32; 2],
    low: f32,
    high: f32,
}

/// The axes of a patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    all: [Axis; 3],
    count: usize,
    /// What coordinates of samples and occluders may be off by together.
    slack: f32,
}

impl Axes {
    /// Of a patch of which nothing is known.
    pub(super) const NONE: Self =
        Self { all: [Axis { direction: [0.0; 2], low: 0.0, high: 0.0 }; 3], count: 0, slack: 0.0 };

    /// Across the sides of a patch: its rows, its columns, and the third side of a triangle. The samples lie in the hull of `hull`.
    #[inline(always)]
    pub(super) fn across(sides: &[[f32; 2]], hull: &[[f32; 3]], slack: f32) -> Self {
        let mut axes = Self { slack, count: sides.len(), ..Self::NONE };
        for (axis, side) in axes.all.iter_mut().zip(sides) {
            let direction = [-side[1], side[0]];
            let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
            for corner in hull {
                let value = direction[0] * corner[0] + direction[1] * corner[1];
                (low, high) = (low.min(value), high.max(value));
            }
            *axis = Axis { direction, low, high };
        }
        axes
    }

    /// The lanes of triangles that lie beside all samples of the patch with this middle.
    #[inline(always)]
    pub(super) fn beside<S: Simd>(&self, simd: S, triangles: &Triangles<S>, center: [i32; 2]) -> u32 {
        if self.count == 0 {
            return 0;
        }
        let Corners { x, y, reach } = triangles.corners_from(simd, center);
        let slack = simd.splat8(self.slack) + simd.splat8(8.0 * ROUNDOFF) * reach;
        let mut beside = simd.mask8(0);
        for Axis { direction: [a, b], low, high } in &self.all[..self.count] {
            let off = simd.splat8(a.abs() + b.abs()) * slack;
            let (a, b) = (simd.splat8(*a), simd.splat8(*b));
            let values = [a * x[0] + b * y[0], a * x[1] + b * y[1], a * x[2] + b * y[2]];
            let most = values[0].max(values[1]).max(values[2]);
            let least = values[0].min(values[1]).min(values[2]);
            // What is no number is not beside.
            beside = beside | (most + off).lt(simd.splat8(*low)) | (least - off).gt(simd.splat8(*high));
        }
        beside.bits()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use umbriel_geometry::simd::{Kernel, dispatch};

    use super::{super::tree::WIDTH, *};

    const MIDDLE: [i32; 2] = [1 << 28, -(1 << 27)];

    type Triangle = [[i32; 2]; 3];

    struct Asked<'a>(&'a Axes, Triangle);

    impl Kernel for Asked<'_> {
        type Output = u32;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> u32 {
            let of = |axis: usize| self.1.map(|corner| simd.splat_int8(corner[axis] + MIDDLE[axis]));
            let triangles = Triangles { x: of(0), y: of(1), depth: [simd.splat8(0.0); 3], holed: simd.mask8(0) };
            self.0.beside(simd, &triangles, MIDDLE)
        }
    }

    /// Whether a triangle is beside samples in a smaller one, which has the same middle and this share of the sides.
    fn is_beside([a, b, c]: Triangle, share: f32, slack: f32, other: Triangle) -> bool {
        let along = |to: [i32; 2]| [0, 1].map(|k| (to[k] - a[k]) as f32);
        let third = [0, 1].map(|k| (c[k] - b[k]) as f32);
        let middle = [0, 1].map(|k| (a[k] + b[k] + c[k]) as f32 / 3.0);
        let toward = |to: [i32; 2], k: usize| middle[k] + share * (to[k] as f32 - middle[k]);
        let at = |to: [i32; 2]| [toward(to, 0), toward(to, 1), 0.0];
        let axes = Axes::across(&[along(b), along(c), third], &[at(a), at(b), at(c)], slack);
        let lanes = dispatch(Asked(&axes, other));
        assert!(lanes == 0 || lanes == (1 << WIDTH) - 1, "all lanes are the same triangle");
        lanes != 0
    }

    fn turn([ax, ay]: [i32; 2], [bx, by]: [i32; 2], [cx, cy]: [i32; 2]) -> i64 {
        let away = |to: i32, from: i32| i64::from(to) - i64::from(from);
        away(bx, ax) * away(cy, ay) - away(by, ay) * away(cx, ax)
    }

    fn holds([a, b, c]: Triangle, point: [i32; 2]) -> bool {
        let turns = [turn(a, b, point), turn(b, c, point), turn(c, a, point)];
        // What is flat has all of its line on no side.
        let is_within = |k: usize| a[k].min(b[k]).min(c[k]) <= point[k] && point[k] <= a[k].max(b[k]).max(c[k]);
        let is_on_one_side = turns.iter().all(|&turn| turn >= 0) || turns.iter().all(|&turn| turn <= 0);
        is_on_one_side && is_within(0) && is_within(1)
    }

    #[test]
    fn neighbours_that_share_an_edge_or_a_corner_are_beside() {
        let own = [[0, 0], [4000, 1000], [1000, 3000]];
        let (opposite, beyond) = ([5000, 4000], [-3000, 500]);
        for other in [[own[1], opposite, own[2]], [own[0], own[2], beyond], [own[2], opposite, [900, 7000]]] {
            assert!(is_beside(own, 0.9, 3.0, other), "{other:?}");
            assert!(!is_beside(own, 0.9, 3000.0, other), "{other:?} is less than the slack away");
        }
        assert!(!is_beside(own, 0.9, 3.0, own));
    }

    fn corners() -> impl Strategy<Value = Triangle> {
        [[-40i32..40, -40i32..40], [-40i32..40, -40i32..40], [-40i32..40, -40i32..40]]
    }

    proptest! {
        #[test]
        fn what_is_beside_holds_no_sample(
            own in corners(), other in corners(), step in prop_oneof![Just(1), Just(1 << 20)],
        ) {
            let [own, other] = [own, other].map(|corners| corners.map(|corner| corner.map(|x| x * step)));
            let lies_beside = is_beside(own, 1.0, 0.01 * step as f32, other);
            let has_common = own.iter().any(|&point| holds(other, point)) || other.iter().any(|&point| holds(own, point));
            prop_assert!(!lies_beside || !has_common, "{:?} {:?}", own, other);
        }
    }
}
