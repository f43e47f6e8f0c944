//! Pairs of floats with a running bound: the filter between floats and exact arithmetic.
//!
//! After Dekker, "A floating-point technique for extending the available precision" (Numerische Mathematik 18, 1971), and the
//! cascaded sums of Ogita, Rump and Oishi, "Accurate sum and dot product" (SIAM Journal on Scientific Computing 26, 2005): a
//! number is a float and the rest that its rounding left, some 106 bits in all. Every operation takes its terms apart without
//! rounding and adds them up; what the pair does not hold at the end is not estimated but seen, so the bound is zero where nothing was lost.
//! Hence numbers of few digits keep exact zeros exact, and others are told from zero unless they are below 2^-100 of their terms.
//!
//! Guarantee: the exact result lies within `error` of the pair (NUMERICS.md, section 2). Cost: 20 to 100 flops an operation.

use std::ops::{Add, Mul, Neg, Sub};

use crate::{
    approx::{Approx, UNDERFLOW_LIMIT, UNIT_ROUNDOFF},
    decide::Decide,
    dyadic::Dyadic,
    expansion::{two_product, two_sum},
    point::Point,
    ring::Sign,
};

/// Covers the rounding of the error terms: non-negative numbers that go through fewer than twelve operations in a row.
const ERROR_PADDING: f64 = 1.0 + 16.0 * UNIT_ROUNDOFF;

/// `value + rest`, where `rest` is at most half an ulp of a `value` above 2^-969, with a bound.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pair {
    value: f64,
    rest: f64,
    error: f64,
}

impl Pair {
    /// A float.
    pub(crate) fn exact(value: f64) -> Self {
        Self { value, ..Self::default() }
    }

    /// The coordinates of a point.
    pub(crate) fn of_point(point: &Point) -> [Self; 3] {
        match point.exact {
            Some(exact) => exact.point().xyz.each_ref().map(Self::from),
            None => point.position.to_array().map(Self::exact),
        }
    }

    /// The sign of the exact number where the bound is below half of it.
    pub(crate) fn sign(self) -> Option<Sign> {
        (self.value.abs() * 0.5 > self.error || self.error == 0.0).then(|| Sign::of(self.value))
    }

    /// The float of the pair.
    pub(crate) fn to_approx(self) -> Approx {
        Approx { value: self.value, error: (self.rest.abs() + self.error) * ERROR_PADDING }
    }

    /// The number to about the nearest multiple of `grid`, a power of two, or to the nearest float where floats are farther apart. Where
    /// the bound is far below `grid`, the way that the number was computed does not show.
    ///
    /// `None` where the bound is above a quarter of `grid`, or the number too near to zero for its sign to be told.
    pub(crate) fn on_grid(self, grid: f64) -> Option<Approx> {
        if self.is_float() && self.value == 0.0 {
            return Some(Approx::exact(0.0));
        }
        let floats_are_farther_apart = self.value.abs() * UNIT_ROUNDOFF >= grid;
        if floats_are_farther_apart && self.error <= grid {
            return Some(Approx { value: self.value, error: self.value.abs() * f64::EPSILON });
        }
        // Floats of the size of the shift are multiples of the grid.
        let shift = 1.5 / f64::EPSILON * grid;
        let value = (self.value + shift) - shift;
        let is_told = (self.rest.abs() + self.error) * ERROR_PADDING <= 0.25 * grid && value.abs() > grid;
        is_told.then_some(Approx { value, error: grid })
    }

    /// The sum of at most eight floats, best from the smallest to the largest. Each `two_sum` is exact, so what the sum and
    /// its rest do not hold is the sum of what was lost.
    fn sum_of(terms: &[f64], error: f64) -> Self {
        let (mut sum, mut rest, mut lost) = (0.0, 0.0, 0.0);
        for &term in terms {
            let [upper, lower] = two_sum(sum, term);
            let [held, left] = two_sum(rest, lower);
            (sum, rest) = (upper, held);
            lost += f64::abs(left);
        }
        let [value, rest] = two_sum(sum, rest);
        Self { value, rest, error: if error + lost == 0.0 { 0.0 } else { (error + lost) * ERROR_PADDING } }
    }

    /// A float and its rest, unless an overflow left none.
    fn in_range([value, rest]: [f64; 2], error: f64) -> Self {
        Self { value, rest, error: if value.is_finite() { error } else { f64::INFINITY } }
    }

    /// Whether this is zero, exactly.
    fn is_zero(self) -> bool {
        self.value == 0.0 && self.is_float()
    }

    /// Whether something is known of the number.
    fn is_bounded(self) -> bool {
        self.value.is_finite() && self.error.is_finite()
    }

    fn is_float(self) -> bool {
        self.rest == 0.0 && self.error == 0.0
    }
}

impl From<&Dyadic> for Pair {
    fn from(number: &Dyadic) -> Self {
        let value = number.to_nearest();
        if value.is_infinite() {
            return Self { error: f64::INFINITY, ..Self::default() };
        }
        let left = number.clone() - Dyadic::new(value);
        let rest = left.to_nearest();
        let lost = (left - Dyadic::new(rest)).to_approx();
        Self { value, rest, error: (lost.value.abs() + lost.error) * ERROR_PADDING }
    }
}

impl Add for Pair {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        if self.is_float() && other.is_float() {
            return Self::in_range(two_sum(self.value, other.value), 0.0);
        }
        let (small, large) = if self.value.abs() <= other.value.abs() { (self, other) } else { (other, self) };
        Self::sum_of(&[small.rest, large.rest, small.value, large.value], self.error + other.error)
    }
}

impl Sub for Pair {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Pair {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self, other);
        if a.is_zero() && b.is_bounded() || b.is_zero() && a.is_bounded() {
            return Self::default();
        }
        let [upper, lower] = two_product(a.value, b.value);
        let absolute = |product: f64, x: f64, y: f64| {
            // What is below this may have lost its rest, or is lost itself.
            if product.abs() < UNDERFLOW_LIMIT && x != 0.0 && y != 0.0 { f64::MIN_POSITIVE } else { 0.0 }
        };
        if a.is_float() && b.is_float() {
            return Self::in_range([upper, lower], absolute(upper, a.value, b.value));
        }
        let [first, first_rest] = two_product(a.value, b.rest);
        let [second, second_rest] = two_product(a.rest, b.value);
        let [least, least_rest] = two_product(a.rest, b.rest);
        let underflow = absolute(upper, a.value, b.value)
            + absolute(first, a.value, b.rest)
            + absolute(second, a.rest, b.value)
            + absolute(least, a.rest, b.rest);
        let carried = a.value.abs() * b.error + b.value.abs() * a.error + a.error * b.error;
        let is_lost = carried < UNDERFLOW_LIMIT && a.error + b.error != 0.0;
        let error = carried + underflow + if is_lost { f64::MIN_POSITIVE } else { 0.0 };
        Self::sum_of(&[least_rest, first_rest, second_rest, least, first, second, lower, upper], error)
    }
}

impl Decide for Pair {
    fn number(value: f64) -> Self {
        Self::exact(value)
    }

    /// The two smaller ones first.
    fn sum_of_three(mut terms: [Self; 3]) -> Self {
        terms.sort_by(|a, b| a.value.abs().total_cmp(&b.value.abs()));
        let [small, medium, large] = terms;
        small + medium + large
    }

    fn decide(&self) -> Option<Sign> {
        self.sign()
    }
}

impl Neg for Pair {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, rest: -self.rest, error: self.error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Ring, ring::determinant};
    use proptest::prelude::*;

    /// The pair holds the exact number, and tells its sign if any.
    fn check(pair: Pair, exact: &Dyadic) -> Pair {
        let off = Dyadic::new(pair.value) + Dyadic::new(pair.rest) - exact.clone();
        let off = if off.sign() == Sign::Negative { -off } else { off };
        assert_ne!((off - Dyadic::new(pair.error)).sign(), Sign::Positive, "{pair:?} {exact:?}");
        let is_normal = pair.value.abs() >= UNDERFLOW_LIMIT;
        assert!(!is_normal || pair.value == pair.value + pair.rest, "the rest is below half an ulp: {pair:?}");
        if let Some(sign) = pair.sign() {
            assert_eq!(sign, exact.sign(), "{pair:?} {exact:?}");
        }
        for fraction in [1.0, 2f64.powi(-30), 2f64.powi(-60), 2f64.powi(-110)] {
            let grid = f64::from_bits((pair.value * fraction).to_bits() & f64::INFINITY.to_bits());
            let Some(rounded) = pair.on_grid(grid) else { continue };
            let off = Dyadic::new(rounded.value) - exact.clone();
            let off = if off.sign() == Sign::Negative { -off } else { off };
            assert_ne!((off - Dyadic::new(rounded.error)).sign(), Sign::Positive, "{pair:?} {rounded:?}");
            assert_eq!(rounded.sign(), Some(exact.sign()), "{pair:?} {rounded:?}");
        }
        pair
    }

    /// Sums and products in which pairs of all lengths meet, up to degree four.
    fn terms<T>([a, b, c, d, e, f]: [T; 6]) -> [T; 4]
    where
        T: Clone + Add<Output = T> + Sub<Output = T> + Mul<Output = T>,
    {
        let (p, q) = (a - b.clone(), c.clone() + d);
        let area = p.clone() * q.clone() - q.clone() * f.clone();
        let volume = area.clone() * (e - f.clone()) + c.clone() * b * f.clone();
        [p * c, area, volume.clone(), volume * (q - f)]
    }

    fn check_terms(numbers: [f64; 6]) {
        let exact = terms(numbers.map(Dyadic::new));
        for (pair, exact) in terms(numbers.map(Pair::exact)).into_iter().zip(&exact) {
            check(pair, exact);
        }
    }

    /// Numbers of any size in the accepted range, few-digit ones among them.
    fn number() -> impl Strategy<Value = f64> {
        (-1.0..1.0f64, -200i32..199, 0u32..52).prop_map(|(fraction, power, cut)| {
            let bits = (fraction * 2f64.powi(power)).to_bits();
            f64::from_bits(bits >> cut << cut)
        })
    }

    proptest! {
        #[test]
        fn the_exact_result_stays_inside(numbers in proptest::array::uniform6(number())) {
            check_terms(numbers);
        }

        #[test]
        fn also_where_products_underflow(numbers in proptest::array::uniform6(number()), power in -800i32..-200) {
            check_terms(numbers.map(|number| number * 2f64.powi(power)));
        }

        #[test]
        fn points_near_a_plane_are_told(
            p in proptest::array::uniform9(-1e3..1e3f64), s in -2.0..2.0f64, t in -2.0..2.0f64, ulps in -2i64..=2,
        ) {
            let mut x: [f64; 3] = std::array::from_fn(|k| p[k] + s * (p[3 + k] - p[k]) + t * (p[6 + k] - p[k]));
            x[0] = f64::from_bits(x[0].to_bits().wrapping_add_signed(ulps));
            let pairs = [0, 1, 2].map(|i| [0, 1, 2].map(|k| Pair::exact(p[3 * i + k]) - Pair::exact(x[k])));
            let exact = [0, 1, 2].map(|i| [0, 1, 2].map(|k| Dyadic::new(p[3 * i + k]) - Dyadic::new(x[k])));
            let pair = check(determinant(&pairs), &determinant(&exact));
            prop_assert!(pair.sign().is_some(), "{pair:?}");
        }
    }

    #[test]
    fn few_digits_are_exact() {
        let [a, b] = [1.0 + f64::EPSILON, 1.0 - f64::EPSILON].map(Pair::exact);
        let zero = a * b + Pair::exact(f64::EPSILON) * Pair::exact(f64::EPSILON) - Pair::exact(1.0);
        assert_eq!(zero.sign(), Some(Sign::Zero));
    }

    #[test]
    fn big_numbers_are_held() {
        let long = Dyadic::new(1.0 / 3.0) * Dyadic::new(1.0 / 7.0) * Dyadic::new(0.1);
        let pair = check(Pair::from(&long), &long);
        assert!(pair.error > 0.0 && pair.rest != 0.0 && pair.error < pair.rest.abs() * f64::EPSILON);
    }

    #[test]
    fn nothing_is_said_beyond_the_range() {
        let most = Pair::exact(f64::MAX);
        for beyond in [most * most, most + most, most * most - most * most, most * most * Pair::exact(0.0)] {
            assert_eq!((beyond.sign(), (beyond - beyond).sign()), (None, None), "{beyond:?}");
        }
    }
}
