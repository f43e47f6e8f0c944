//! Which points of a quadric belong to a sheet: those where the gradient along its axis is the largest.

use std::ops::{Add, Mul, Neg};

use crate::{analytic::forms::QuadricForm, approx::Approx, dyadic::Dyadic};

/// A linear form that is ≥ 0 (or > 0) where the gradient along a sheet's axis is the largest.
#[derive(Clone, Debug)]
pub(super) struct Slope<T> {
    pub(super) row: [T; 4],
    pub(super) is_strict: bool,
}

impl Slope<Dyadic> {
    pub(super) fn to_approx(&self) -> Slope<Approx> {
        Slope { row: self.row.each_ref().map(Dyadic::to_approx), is_strict: self.is_strict }
    }
}

/// The four conditions of a sheet; of equal gradients the first axis has the surface.
pub(super) fn slopes<T>(form: &QuadricForm<T>, axis: usize, across: [usize; 2], is_positive: bool) -> [Slope<T>; 4]
where
    T: Clone + Default + Add<Output = T> + Mul<Output = T> + Neg<Output = T>,
{
    let turned = |value: &T, is_positive: bool| if is_positive { value.clone() } else { -value.clone() };
    let own = form.row(axis);
    std::array::from_fn(|index| {
        let (other, is_minus) = (across[index / 2], index % 2 == 1);
        let beside = form.row(other);
        let row = std::array::from_fn(|k| turned(&own[k], is_positive) + turned(&beside[k], is_minus));
        Slope { row, is_strict: other < axis }
    })
}
