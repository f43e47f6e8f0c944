//! Affine functions over a receiver cell, known at the corners of the face (or of a hull round a curved cell).
//!
//! Every question about an occluder is the sign of a function that is affine in the receiver's point: on which side of
//! an edge's shadow plane, before or behind the occluder's plane. Such a function is the weighted mean of its values at
//! the face's corners, with the point's barycentric (bilinear) weights, all of them ≥ 0. So a sign that is exact at the
//! corners is exact where the weights say so: an edge that runs through a corner of the face keeps its exact zero.

use umbriel_geometry::Approx;

/// Weights of one point, one for each of the N corners; they sum to one.
pub(crate) type Weights<const N: usize> = [f64; N];

/// Covers the roundings of a weighted sum of at most eight terms, and of a product of weights: 12 units roundoff of
/// the magnitudes (NUMERICS.md, "Functions along a face").
const SUM_PADDING: f64 = 12.0 * f64::EPSILON / 2.0;

/// Covers the roundings of the error's own weighted sum.
const ERROR_PADDING: f64 = 1.0 + 32.0 * f64::EPSILON;

/// An affine function by its values at N corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Field<const N: usize> {
    value: [f64; N],
    error: [f64; N],
}

/// Least and greatest value over a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    pub(crate) min: f64,
    pub(crate) max: f64,
}

impl<const N: usize> Field<N> {
    /// From bounded values at the corners. A corner that is exactly zero stays exactly zero.
    pub(crate) fn new(corners: [Approx; N]) -> Self {
        Self {
            value: corners.map(|corner| corner.value),
            error: corners.map(|corner| (corner.error + SUM_PADDING * corner.value.abs()) * ERROR_PADDING),
        }
    }

    /// The value at a point.
    #[inline]
    pub(crate) fn at(&self, weights: &Weights<N>) -> Approx {
        let (mut value, mut error) = (0.0, 0.0);
        for (k, weight) in weights.iter().enumerate() {
            value += weight * self.value[k];
            error += weight * self.error[k];
        }
        Approx { value, error }
    }

    /// Over a flat face (corners: first, second, …, last) as constant + along_u·u + along_v·v, rounded.
    #[inline]
    pub(crate) fn along_parameters(&self) -> [f64; 3] {
        let [constant, at_u, at_v] = [0, 1, N - 1].map(|k| self.value[k]);
        [constant, at_u - constant, at_v - constant]
    }

    /// The value at corner k, as given.
    pub(crate) fn corner(&self, k: usize) -> Approx {
        Approx { value: self.value[k], error: self.error[k] }
    }

    /// The value at a point whose weights are rounded: each may be off by two units roundoff of one.
    pub(crate) fn near(&self, weights: &Weights<N>) -> Approx {
        let Approx { value, error } = self.at(weights);
        let spread: f64 = self.value.iter().map(|v| v.abs()).sum();
        Approx { value, error: error + spread * (4.0 * f64::EPSILON) }
    }

    /// Bounds over the hull of `corners`.
    pub(crate) fn range(&self, corners: &[Weights<N>]) -> Range {
        let mut range = Range { min: f64::INFINITY, max: f64::NEG_INFINITY };
        for weights in corners {
            let Approx { value, error } = self.at(weights);
            let (low, high) = (value - error, value + error);
            if low.is_nan() || high.is_nan() {
                return Range { min: f64::NEG_INFINITY, max: f64::INFINITY };
            }
            range.min = range.min.min(low);
            range.max = range.max.max(high);
        }
        range
    }
}
