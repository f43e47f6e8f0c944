//! A small face by the images of its corners, from which its samples are found without leaving f32.
//!
//! Under a sun images are affine in (u, v). Before a lamp, homogeneous coordinates are: the images are weighted by z, which
//! is −1 over the depth. Weights of a triangle's points are not negative, so a sample is off by no more than its corners
//! and some roundings of the face's own size.

use umbriel_geometry::simd::{F8, Simd};

use super::{
    pack::Samples,
    soup::{Area, Receiver},
};

/// The corner from which the lattice is counted, and the next two.
pub(super) struct Corners {
    x: [f32; 3],
    y: [f32; 3],
    /// Depths under a sun, −1/depth before a lamp.
    along: [f32; 3],
    is_sun: bool,
}

impl Corners {
    /// Relative to the area's middle.
    pub(super) fn new(receiver: &Receiver, first: u8, area: &Area, is_sun: bool) -> Self {
        let middle = area.center.map(|x| x as i32);
        let image = |k: usize| &receiver.corners[(usize::from(first) + k) % 3];
        let along = |depth: f32| if is_sun { depth } else { -1.0 / depth };
        Self {
            x: [0, 1, 2].map(|k| (image(k).x - middle[0]) as f32),
            y: [0, 1, 2].map(|k| (image(k).y - middle[1]) as f32),
            along: [0, 1, 2].map(|k| along(image(k).depth)),
            is_sun,
        }
    }

    /// Eight samples at (u, v).
    #[inline(always)]
    pub(super) fn at_eight<S: Simd>(&self, simd: S, u: F8<S>, v: F8<S>) -> Samples<F8<S>> {
        let one = simd.splat8(1.0);
        let weights = [one - u - v, u, v];
        if self.is_sun {
            let sum = |values: &[f32; 3]| {
                simd.splat8(values[0]) * weights[0]
                    + simd.splat8(values[1]) * weights[1]
                    + simd.splat8(values[2]) * weights[2]
            };
            return Samples { x: sum(&self.x), y: sum(&self.y), depth: sum(&self.along) };
        }
        let [a, b, c] = [
            weights[0] * simd.splat8(self.along[0]),
            weights[1] * simd.splat8(self.along[1]),
            weights[2] * simd.splat8(self.along[2]),
        ];
        let inverse = one / (a + b + c);
        let sum = |values: &[f32; 3]| {
            (simd.splat8(values[0]) * a + simd.splat8(values[1]) * b + simd.splat8(values[2]) * c) * inverse
        };
        Samples { x: sum(&self.x), y: sum(&self.y), depth: -inverse }
    }

    /// The sample at (u, v).
    #[inline(always)]
    pub(super) fn at(&self, u: f32, v: f32) -> Samples<f32> {
        let weights = [1.0 - u - v, u, v];
        let sum = |values: &[f32; 3], weights: &[f32; 3]| {
            values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2]
        };
        if self.is_sun {
            return Samples { x: sum(&self.x, &weights), y: sum(&self.y, &weights), depth: sum(&self.along, &weights) };
        }
        let weights = [0, 1, 2].map(|k| weights[k] * self.along[k]);
        let inverse = 1.0 / (weights[0] + weights[1] + weights[2]);
        Samples { x: sum(&self.x, &weights) * inverse, y: sum(&self.y, &weights) * inverse, depth: -inverse }
    }
}
