//! A sum over a rectangle by parts, halved where most is missed and along the parameter that misses most.
//!
//! A density that bends along a line, as that of a flat body's rim, is so followed to the line by parts as long as the line: their number grows with the digits asked
//! for, where that of squares would with the inverse of their edge. Guarantee: the result bounds the sum if what is measured does; the order of halving
//! goes by the numbers alone. Cost: up to two measurements a part.

use std::{cmp::Reverse, collections::BinaryHeap};

use crate::approx::Approx;

/// A rectangle of parameters with edges that are powers of two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Its low corner.
    pub(super) at: [f64; 2],
    pub(super) edges: [f64; 2],
}

/// What is known of a part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured {
    pub(super) area: Approx,
    /// How much is unknown because of the extent along either parameter, in a common unit.
    pub(super) missed: [f64; 2],
}

impl Part {
    pub(super) fn square(at: [f64; 2], edge: f64) -> Self {
        Self { at, edges: [edge; 2] }
    }

    /// All values of a parameter.
    pub(super) fn range(&self, axis: usize) -> Approx {
        let half = 0.5 * self.edges[axis];
        Approx { value: self.at[axis] + half, error: half }
    }

    /// Both halves, along the parameter that misses more; along the longer edge where that is not known.
    fn halves(&self, [u, v]: [f64; 2]) -> [Self; 2] {
        let is_along_v = if u.is_finite() && v.is_finite() && u != v { u < v } else { self.edges[0] < self.edges[1] };
        let axis = usize::from(is_along_v);
        let mut first = *self;
        first.edges[axis] *= 0.5;
        let mut second = first;
        second.at[axis] += first.edges[axis];
        [first, second]
    }
}

/// The sum over a rectangle of at most so many parts, good to `good` of itself if they suffice.
pub(super) fn sum(whole: Part, most: usize, good: f64, mut measure: impl FnMut(&Part) -> Measured) -> Approx {
    let first = measure(&whole);
    let mut parts = vec![(whole, first)];
    let mut queue = BinaryHeap::from([rank(0, &first)]);
    let mut total = first.area;
    let is_good = |total: Approx| total.error <= total.value.abs() * good;
    while parts.len() < most && !is_good(total) {
        // A look at all of them now and then costs no more than one at each.
        let next = (parts.len() + parts.len().div_ceil(8)).min(most);
        while parts.len() < next {
            let Some((_, Reverse(worst))) = queue.pop() else { break };
            let (part, Measured { missed, .. }) = parts[worst];
            let [low, high] = part.halves(missed).map(|half| (half, measure(&half)));
            queue.extend([rank(worst, &low.1), rank(parts.len(), &high.1)]);
            parts[worst] = low;
            parts.push(high);
        }
        total = parts.iter().fold(Approx::exact(0.0), |sum, (_, measured)| sum + measured.area);
    }
    // The bound of the whole may be the better one where rounding dominates.
    if total.error < first.area.error || first.area.error.is_nan() { total } else { first.area }
}

/// Parts that are known less come first, of equal ones the first. Errors are not negative, so their bits are in their order.
fn rank(index: usize, measured: &Measured) -> (u64, Reverse<usize>) {
    let error = measured.area.error;
    (if error.is_nan() { u64::MAX } else { error.to_bits() }, Reverse(index))
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    /// ∫∫ |u − 1/3| over the unit square, by the range alone.
    #[test]
    fn a_bend_along_a_line_takes_parts_as_its_digits() {
        let asked = Cell::new(0);
        let measure = |part: &Part| {
            asked.set(asked.get() + 1);
            let offset = part.range(0) - Approx::exact(1.0 / 3.0);
            let area = part.edges[0] * part.edges[1];
            // Off the line the middle's value is exact.
            let error = if offset.value.abs() > offset.error { 0.0 } else { offset.error };
            let mean = Approx { value: offset.value.abs(), error: error + f64::EPSILON };
            Measured { area: mean * Approx::exact(area), missed: [error, 0.0] }
        };
        let total = sum(Part::square([0.0; 2], 1.0), 64, 1e-9, measure);
        assert!((total.value - 5.0 / 18.0).abs() <= total.error && total.error <= 1e-9 * total.value, "{total:?}");
        assert!(asked.get() < 64, "{}", asked.get());
    }

    #[test]
    fn what_is_not_known_is_halved_as_often_as_allowed() {
        let asked = Cell::new(0);
        let unknown = |_: &Part| {
            asked.set(asked.get() + 1);
            Measured { area: Approx::UNKNOWN, missed: [f64::NAN; 2] }
        };
        assert!(!sum(Part::square([0.0; 2], 1.0), 8, 1e-9, unknown).error.is_finite());
        assert_eq!(asked.get(), 15);
    }
}
