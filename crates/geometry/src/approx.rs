//! A float that says how far off it may be: the filter of every exact decision.

use std::ops::{Add, Mul, Neg, Sub};

use crate::ring::Sign;

/// Unit roundoff of f64, 2^-53.
pub(crate) const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// Covers the rounding of the error terms themselves: each is a sum of at most four non-negative products, so three
/// additions and two multiplications in a row, below (1 + u)^5 (NUMERICS.md, "Running error bounds").
const ERROR_PADDING: f64 = 1.0 + 8.0 * UNIT_ROUNDOFF;

/// The error of a product above this is a normal number: 2^-969, 2^53 times the least normal number.
pub(crate) const UNDERFLOW_LIMIT: f64 = f64::MIN_POSITIVE / f64::EPSILON * 2.0;

/// A value with a bound: the exact number lies in [`value − error`, `value + error`]; what is told of a number below all floats
/// ([`Dyadic::to_approx`](crate::Dyadic::to_approx)) ends 2^-1074 too early, and [`Approx::lower`] and sums make up for that.
///
/// The bounds hold as long as nothing overflows; where a product may underflow the error has an absolute part. Inside the
/// accepted range of coordinates neither happens up to degree four (NUMERICS.md).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Approx {
    /// The middle of the interval.
    pub value: f64,
    /// Half its width; not negative. Infinite when nothing is known.
    pub error: f64,
}

impl Approx {
    /// A number that is known exactly.
    pub fn exact(value: f64) -> Self {
        Self { value, error: 0.0 }
    }

    /// Nothing known.
    pub const UNKNOWN: Self = Self { value: 0.0, error: f64::INFINITY };

    /// Below every number of the interval; exactly `value` when the error is zero.
    pub fn lower(self) -> f64 {
        if self.error == 0.0 { self.value } else { (self.value - self.error).next_down() }
    }

    /// Above every number of the interval; exactly `value` when the error is zero.
    pub fn upper(self) -> f64 {
        if self.error == 0.0 { self.value } else { (self.value + self.error).next_up() }
    }

    /// The sign of the exact number, where the bound allows to tell.
    pub fn sign(self) -> Option<Sign> {
        if self.value.abs() > self.error || self.error == 0.0 { Some(Sign::of(self.value)) } else { None }
    }

    /// The square. Of an interval round zero it begins at zero, where the product of two equal intervals would not.
    #[must_use]
    pub fn squared(self) -> Self {
        let size = self.value.abs();
        if self.error <= 0.25 * size || !self.error.is_finite() {
            return self * self;
        }
        let [least, greatest] = [(size - self.error).max(0.0), size + self.error];
        let (low, high) =
            (least * least * (1.0 - 4.0 * UNIT_ROUNDOFF), greatest * greatest * (1.0 + 4.0 * UNIT_ROUNDOFF));
        let value = 0.5 * (low + high);
        Self { value, error: (high - value).max(value - low) * ERROR_PADDING + f64::MIN_POSITIVE }
    }

    /// The square root of a number that is known not to be negative.
    #[must_use]
    pub fn square_root(self) -> Self {
        let value = self.value.max(0.0).sqrt();
        let is_square_exact =
            value.to_bits().trailing_zeros() >= 27 && value * value >= f64::MIN_POSITIVE || value == 0.0;
        if self.error == 0.0 && value * value == self.value && is_square_exact {
            return Self::exact(value); // 26 digits: the square has no more than 52
        }
        // |√x − √y| ≤ |x − y|/√x, and never more than √|x − y|.
        let carried = if self.value > self.error { self.error / value } else { self.error.sqrt() * 2.0 };
        Self { value, error: (carried + value * UNIT_ROUNDOFF * 2.0) * ERROR_PADDING }
    }

    /// The quotient; [`Approx::UNKNOWN`] when the divisor may be zero.
    #[must_use]
    pub fn divided_by(self, divisor: Self) -> Self {
        let least = divisor.value.abs() - divisor.error;
        if least.is_nan() || least <= 0.0 || !self.error.is_finite() {
            return Self::UNKNOWN;
        }
        if self.is_zero() {
            return self;
        }
        let value = self.value / divisor.value;
        let error = (self.error + value.abs() * divisor.error) / least * (1.0 + 8.0 * f64::EPSILON);
        let error = (error + value.abs() * UNIT_ROUNDOFF * 2.0) * ERROR_PADDING;
        Self { value, error: if value.abs() < UNDERFLOW_LIMIT { error + f64::MIN_POSITIVE } else { error } }
    }

    /// The sum of three: least, greatest, then the one between, so that the order in which they are given changes no bit, nor does
    /// changing all signs.
    pub fn sum_of_three(terms: [Self; 3]) -> Self {
        let [least, middle, greatest] = sorted(terms.map(|term| term.value));
        let [small, medium, large] = sorted(terms.map(|term| term.error));
        let outer = least + greatest;
        let value = outer + middle;
        let rounding = (outer.abs() + value.abs()) * UNIT_ROUNDOFF;
        Self { value, error: (small + medium + large + rounding) * ERROR_PADDING }
    }

    /// Whether this is zero, exactly.
    fn is_zero(self) -> bool {
        self.value == 0.0 && self.error == 0.0
    }
}

/// Three numbers from the least to the greatest. NaN stays among them, wherever.
#[inline(always)]
pub(crate) fn sorted([a, b, c]: [f64; 3]) -> [f64; 3] {
    let ordered = |x: f64, y: f64| if y < x { (y, x) } else { (x, y) };
    let (a, b) = ordered(a, b);
    let (b, c) = ordered(b, c);
    let (a, b) = ordered(a, b);
    [a, b, c]
}

impl Add for Approx {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let value = self.value + other.value;
        Self { value, error: (self.error + other.error + value.abs() * UNIT_ROUNDOFF) * ERROR_PADDING }
    }
}

impl Sub for Approx {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Approx {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let value = self.value * other.value;
        let carried = self.value.abs() * other.error + other.value.abs() * self.error + self.error * other.error;
        let error = (carried + value.abs() * UNIT_ROUNDOFF) * ERROR_PADDING;
        // Below this the terms may have underflowed, each by less than the least subnormal number.
        let may_underflow = value.abs() < UNDERFLOW_LIMIT && !self.is_zero() && !other.is_zero();
        Self { value, error: if may_underflow { error + f64::MIN_POSITIVE } else { error } }
    }
}

impl Neg for Approx {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, error: self.error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dyadic, Ring};
    use proptest::prelude::*;

    fn inside(approx: Approx, exact: &Dyadic) -> bool {
        let below = exact.clone() - Dyadic::new(approx.lower());
        let above = Dyadic::new(approx.upper()) - exact.clone();
        below.sign() != Sign::Negative && above.sign() != Sign::Negative
    }

    proptest! {
        #[test]
        fn the_exact_result_stays_inside(a in -1e3..1e3, b in -1e3..1e3, c in -1e3..1e3, shift in 0i32..60) {
            let b = a + b * 2f64.powi(-shift);
            let (x, y, z) = (Approx::exact(a), Approx::exact(b), Approx::exact(c));
            let (p, q, r) = (Dyadic::new(a), Dyadic::new(b), Dyadic::new(c));
            let approx = (x - y) * z * (x * z - y * z);
            let exact = (p.clone() - q.clone()) * r.clone() * (p * r.clone() - q * r);
            prop_assert!(inside(approx, &exact), "{approx:?}");
        }

        #[test]
        fn quotients_hold_too(a in -1e3..1e3, b in 1e-3..1e3, ea in 0.0..1e-3, eb in 0.0..1e-4, s in -1.0..1.0, t in -1.0..1.0) {
            let quotient = Approx { value: a, error: ea }.divided_by(Approx { value: b, error: eb });
            let truth = (a + s * ea) / (b + t * eb);
            prop_assert!(quotient.lower() <= truth && truth <= quotient.upper());
        }
    }

    proptest! {
        #[test]
        fn squares_hold_and_are_not_negative(a in -1e3..1e3, e in 0.0..1e3, t in -1.0..1.0) {
            let x = Approx { value: a, error: e };
            let truth = Dyadic::new(a) + Dyadic::new(t * e);
            prop_assert!(inside(x.squared(), &(truth.clone() * truth)), "{:?}", x.squared());
            prop_assert!(e < 0.25 * a.abs() || x.squared().lower() >= -1e-9 * x.squared().value);
        }

        #[test]
        fn sums_of_three_hold_in_any_order(terms in proptest::array::uniform3((-1e3..1e3f64, 0.0..1e-9f64)), shift in 0i32..60) {
            let [a, b, c] = terms.map(|(value, error)| Approx { value, error });
            let b = Approx { value: b.value * 2f64.powi(-shift), ..b };
            let sum = Approx::sum_of_three([a, b, c]);
            let ends = |side: f64| [a, b, c].map(|x| Dyadic::new(x.value) + Dyadic::new(side * x.error));
            for side in [-1.0, 1.0] {
                let [a, b, c] = ends(side);
                prop_assert!(inside(sum, &(a + b + c)), "{sum:?}");
            }
            for order in [[b, c, a], [c, a, b], [a, c, b], [b, a, c], [c, b, a]] {
                prop_assert_eq!(Approx::sum_of_three(order), sum);
            }
            prop_assert_eq!(Approx::sum_of_three([-a, -b, -c]), -sum);
        }
    }

    #[test]
    fn what_is_no_number_stays_so() {
        for place in 0..3 {
            let mut terms = [1.0, 2.0, 3.0];
            terms[place] = f64::NAN;
            assert!(sorted(terms).iter().any(|term| term.is_nan()));
        }
        assert_eq!(Approx::sum_of_three([Approx::UNKNOWN, Approx::exact(1.0), Approx::exact(2.0)]).sign(), None);
    }

    #[test]
    fn no_error_means_exact() {
        let zero = Approx::exact(1.0) - Approx::exact(1.0);
        assert_eq!(zero.sign(), Some(Sign::Zero), "1 - 1 is zero without rounding");
        assert_eq!(Approx::UNKNOWN.sign(), None);
    }
}
