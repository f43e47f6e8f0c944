//! How much of a cell lies where some functions are not negative that are all but affine there.
//!
//! The lines where such a function, less or plus its error, is zero bound the part on both sides: a square cut by half planes
//! (Sutherland & Hodgman, "Reentrant polygon clipping", 1974). With functions that bend, the error of a cell goes with the square of its
//! edge, so the bound with the cube. Cost: some ten nanoseconds a function.

use crate::{approx::Approx, stretch::between};

/// Covers the roundings of a cut square's area as a share of the square: six cuts move its corners, of which there are ten at most, by some
/// units roundoff of its edge each, and the area by no more than that times the way round (NUMERICS.md, "Areas").
const ROUNDINGS: f64 = 1024.0 * f64::EPSILON;

/// Covers the roundings of a function's value at a point of the square, of the sum of its coefficients' sizes.
const VALUE_ROUNDINGS: f64 = 8.0 * f64::EPSILON;

/// A function on the square −1..1 × −1..1: constant + along · (s, t), off by no more than `error` at any point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Condition {
    pub(crate) constant: f64,
    pub(crate) along: [f64; 2],
    pub(crate) error: f64,
}

impl Condition {
    /// From bounded coefficients, and what the function may be off by.
    pub(crate) fn new(constant: Approx, along: [Approx; 2], bend: f64) -> Self {
        let errors = constant.error + along[0].error + along[1].error + bend;
        let sizes = constant.value.abs() + along[0].value.abs() + along[1].value.abs();
        let error = (errors + VALUE_ROUNDINGS * sizes) * (1.0 + 8.0 * f64::EPSILON);
        Self { constant: constant.value, along: along.map(|slope| slope.value), error }
    }

    /// Whether anything is known, and no value on the square overflows.
    pub(crate) fn is_finite(&self) -> bool {
        (self.constant.abs() + self.along[0].abs() + self.along[1].abs() + self.error).is_finite()
    }

    /// Whether the function is known not to be zero on the square.
    pub(crate) fn is_nowhere_zero(&self) -> bool {
        let reach = (self.along[0].abs() + self.along[1].abs() + self.error) * (1.0 + 8.0 * f64::EPSILON);
        self.constant.abs() > reach
    }

    fn at(&self, [s, t]: [f64; 2]) -> f64 {
        self.constant + self.along[0] * s + self.along[1] * t
    }
}

/// The share of the square where no function is negative.
pub(crate) fn share(conditions: &[Condition]) -> Approx {
    let cut = |margin: f64| {
        let square = vec![[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        area(&conditions.iter().fold(square, |left, condition| clip(&left, condition, margin))) * 0.25
    };
    let (least, most) = ((cut(-1.0) - ROUNDINGS).max(0.0), (cut(1.0) + ROUNDINGS).min(1.0));
    between(least, most)
}

/// The part of a convex polygon where a function plus `margin` times its error is not negative.
fn clip(polygon: &[[f64; 2]], condition: &Condition, margin: f64) -> Vec<[f64; 2]> {
    let value = |corner: [f64; 2]| condition.at(corner) + margin * condition.error;
    let mut left = Vec::with_capacity(polygon.len() + 1);
    for (k, &end) in polygon.iter().enumerate() {
        let start = polygon[(k + polygon.len() - 1) % polygon.len()];
        let (at_start, at_end) = (value(start), value(end));
        if (at_start < 0.0) != (at_end < 0.0) {
            let way = at_start / (at_start - at_end);
            left.push([0, 1].map(|axis| start[axis] + way * (end[axis] - start[axis])));
        }
        if at_end >= 0.0 {
            left.push(end);
        }
    }
    left
}

/// The area of a polygon, counter-clockwise.
fn area(polygon: &[[f64; 2]]) -> f64 {
    let corner = |k: usize| polygon[k % polygon.len()];
    let cross = |k: usize| corner(k)[0] * corner(k + 1)[1] - corner(k)[1] * corner(k + 1)[0];
    0.5 * (0..polygon.len()).map(cross).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn condition(constant: f64, along: [f64; 2], bend: f64) -> Condition {
        Condition::new(Approx::exact(constant), along.map(Approx::exact), bend)
    }

    /// Held against counting a grid's points in both.
    #[test]
    fn shares_hold_what_counting_says() {
        const SIDE: usize = 400;
        let mut state = 1u64;
        let mut number = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1u32 << 30) - 1.0
        };
        for count in [1, 2, 3, 6] {
            for _ in 0..40 {
                let conditions: Vec<Condition> =
                    (0..count).map(|_| condition(0.7 * number(), [number(), number()], 0.0)).collect();
                let at = |k: usize| (k as f64 + 0.5) * 2.0 / SIDE as f64 - 1.0;
                let holds = |i: usize, j: usize| conditions.iter().all(|f| f.at([at(i), at(j)]) >= 0.0);
                let inside = (0..SIDE * SIDE).filter(|k| holds(k / SIDE, k % SIDE)).count();
                let (counted, share) = (inside as f64 / (SIDE * SIDE) as f64, share(&conditions));
                assert!(share.error < 1e-11, "{share:?}");
                // A convex part's border runs through no more than 4·SIDE cells.
                assert!((share.value - counted).abs() < 4.0 / SIDE as f64, "{share:?} {counted}");
            }
        }
    }

    #[test]
    fn a_bent_function_bounds_the_share_on_both_sides() {
        // s ≥ 0.5 with a line that may be off by 0.25: between s ≥ 0.75 and s ≥ 0.25.
        let share = share(&[condition(-0.5, [1.0, 0.0], 0.25)]);
        assert!((share.lower() - 0.125).abs() < 1e-11 && (share.upper() - 0.375).abs() < 1e-11, "{share:?}");
    }

    #[test]
    fn nothing_and_all_are_shares() {
        assert!(super::share(&[condition(-3.0, [1.0, 1.0], 0.0)]).upper() < 1e-11);
        assert!(super::share(&[condition(3.0, [1.0, 1.0], 0.0)]).lower() > 1.0 - 1e-11);
        assert!(super::share(&[]).lower() > 1.0 - 1e-11);
    }
}
