//! Exact sums of floats: a determinant of differences without big numbers.
//!
//! After Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates" (Discrete &
//! Computational Geometry 18, 1997): a number is a sum of floats, its *parts*, smallest first, of which none overlaps another
//! in its bits. Sums and products of such numbers are again such numbers, without any rounding, so the last part has the
//! exact sign. Zeros are left out: where coordinates are round or shared, one or two parts remain.
//!
//! Parts never overlap by more than round-to-even allows ("strongly nonoverlapping" there), which both operations keep.
//!
//! Guarantee: exact as long as no product underflows. Accepted coordinates are multiples of 2^-252, so products of three
//! differences are multiples of 2^-756, far above the least float. Cost: some 100 ns for round numbers, below a microsecond
//! at worst; nothing is allocated.

use crate::approx::Approx;

/// A sum of at most N floats that do not overlap, smallest first; no parts are zero.
#[derive(Clone, Copy, Debug)]
struct Expansion<const N: usize> {
    parts: [f64; N],
    len: usize,
}

/// The determinant of three rows of pairs: each entry is the exact sum of a float and what rounding took away from it. An
/// exact zero has no error; otherwise the bound is below half the value.
pub(crate) fn determinant(rows: &[[[f64; 2]; 3]; 3]) -> Approx {
    let entry = |i: usize, j: usize| Expansion::<2>::new(rows[i][j]);
    let product = |a: Expansion<2>, b: Expansion<2>| -> Expansion<8> { a.times(&b) };
    let minor = |i: usize, j: usize| -> Expansion<16> {
        product(entry(1, i), entry(2, j)).plus(&product(entry(1, j), entry(2, i)).negated())
    };
    let term = |k: usize, minor: Expansion<16>| -> Expansion<64> { minor.times(&entry(0, k)) };
    let first: Expansion<128> = term(0, minor(1, 2)).plus(&term(1, minor(2, 0)));
    let sum: Expansion<192> = first.plus(&term(2, minor(0, 1)));
    sum.to_approx()
}

/// a − b as a float and what its rounding took away (Knuth, "The Art of Computer Programming" 2, section 4.2.2).
pub(crate) fn difference(a: f64, b: f64) -> [f64; 2] {
    two_sum(a, -b)
}

impl<const N: usize> Expansion<N> {
    const ZERO: Self = Self { parts: [0.0; N], len: 0 };

    /// A float and the rest that its rounding left.
    fn new([value, rest]: [f64; 2]) -> Self {
        let mut sum = Self::ZERO;
        sum.push(rest);
        sum.push(value);
        sum
    }

    /// Adds a part above all others.
    fn push(&mut self, part: f64) {
        if part != 0.0 {
            self.parts[self.len] = part;
            self.len += 1;
        }
    }

    fn parts(&self) -> &[f64] {
        &self.parts[..self.len]
    }

    fn negated(mut self) -> Self {
        self.parts[..self.len].iter_mut().for_each(|part| *part = -*part);
        self
    }

    /// The sum; K is at least N + M. Parts are taken by size and added up with what is carried (figure 13 there).
    fn plus<const M: usize, const K: usize>(&self, other: &Expansion<M>) -> Expansion<K> {
        let (mut a, mut b) = (self.parts().iter().peekable(), other.parts().iter().peekable());
        let mut next = || match (a.peek(), b.peek()) {
            (Some(x), Some(y)) if x.abs() < y.abs() => a.next(),
            (_, Some(_)) => b.next(),
            _ => a.next(),
        };
        let mut sum = Expansion::ZERO;
        let Some(&first) = next() else { return sum };
        let mut carried = first;
        while let Some(&part) = next() {
            let [upper, rest] = two_sum(carried, part);
            sum.push(rest);
            carried = upper;
        }
        sum.push(carried);
        sum
    }

    /// The product with a number of few parts; K is at least 2·N·M.
    fn times<const M: usize, const K: usize>(&self, other: &Expansion<M>) -> Expansion<K> {
        other.parts().iter().fold(Expansion::ZERO, |sum: Expansion<K>, &factor| sum.plus(&self.scaled::<K>(factor)))
    }

    /// The product with a float; K is at least 2·N (figure 15 there).
    fn scaled<const K: usize>(&self, factor: f64) -> Expansion<K> {
        let mut product = Expansion::ZERO;
        let mut carried = 0.0;
        for &part in self.parts() {
            let [upper, lower] = two_product(part, factor);
            let [sum, rest] = two_sum(carried, lower);
            product.push(rest);
            // |upper| is the larger of the two.
            let above = upper + sum;
            product.push(sum - (above - upper));
            carried = above;
        }
        product.push(carried);
        product
    }

    /// The nearest float, ties to even, whatever the parts it is the sum of; exact where it is the sum.
    ///
    /// From the largest part down: what lies below a part is less than that part's last bit, so once a sum is rounded, it only
    /// says which way a tie goes.
    fn to_approx(self) -> Approx {
        let mut parts = self.parts().iter().rev();
        let (mut value, mut rest) = (0.0, 0.0);
        while rest == 0.0 {
            let Some(&part) = parts.next() else { return Approx::exact(value) };
            [value, rest] = two_sum(value, part);
        }
        let beyond = value + 2.0 * rest;
        let is_tie = beyond - value == 2.0 * rest;
        let goes_beyond = parts.next().is_some_and(|part| (*part > 0.0) == (rest > 0.0));
        let value = if is_tie && goes_beyond { beyond } else { value };
        Approx { value, error: value.abs() * f64::EPSILON }
    }
}

/// a + b rounded, and what the rounding took away (Knuth).
pub(crate) fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    let b_seen = sum - a;
    [sum, (a - (sum - b_seen)) + (b - b_seen)]
}

/// a·b rounded, and what the rounding took away.
pub(crate) fn two_product(a: f64, b: f64) -> [f64; 2] {
    let product = a * b;
    [product, a.mul_add(b, -product)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dyadic, Ring, ring};
    use proptest::prelude::*;

    fn exact(rows: &[[[f64; 2]; 3]; 3]) -> Dyadic {
        let entry = |[value, rest]: [f64; 2]| Dyadic::new(value) + Dyadic::new(rest);
        ring::determinant(&rows.map(|row| row.map(entry)))
    }

    /// The result is the exact number as far as its bound says, with the exact sign.
    fn check(rows: &[[[f64; 2]; 3]; 3]) {
        let (found, exact) = (determinant(rows), exact(rows));
        assert_eq!(found.sign(), Some(exact.sign()), "{rows:?}");
        assert_eq!((found.value, found.error == 0.0), (exact.to_nearest(), exact.to_approx().error == 0.0), "{rows:?}");
        let off = Dyadic::new(found.value) - exact;
        let off = if off.sign() == crate::Sign::Negative { -off } else { off };
        assert_ne!((off - Dyadic::new(found.error)).sign(), crate::Sign::Positive, "{rows:?}");
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
        fn determinants_are_exact(numbers in proptest::collection::vec(number(), 18)) {
            let row = |i: usize| std::array::from_fn(|j| difference(numbers[6 * i + 2 * j], numbers[6 * i + 2 * j + 1]));
            check(&[row(0), row(1), row(2)]);
        }

        #[test]
        fn near_zero_too(p in proptest::array::uniform9(-1e3..1e3f64), s in -2.0..2.0f64, t in -2.0..2.0f64, ulps in -2i64..=2) {
            // A point within some ulps of the plane of three others.
            let mut x: [f64; 3] = std::array::from_fn(|k| p[k] + s * (p[3 + k] - p[k]) + t * (p[6 + k] - p[k]));
            x[0] = f64::from_bits(x[0].to_bits().wrapping_add_signed(ulps));
            let row = |i: usize| std::array::from_fn(|k| difference(p[3 * i + k], x[k]));
            check(&[row(0), row(1), row(2)]);
        }
    }

    #[test]
    fn the_ends_of_the_range_are_exact() {
        let (least, most) = (2f64.powi(-200), 2f64.powi(200));
        let ulp = difference(least.next_up(), least);
        check(&[[ulp, [0.0; 2], [0.0; 2]], [[0.0; 2], ulp, [0.0; 2]], [[0.0; 2], [0.0; 2], ulp]]);
        let wide = difference(most, -least);
        check(&[[wide, ulp, wide], [ulp, wide, ulp], [wide, ulp, difference(most, least)]]);
        check(&[[wide, wide, ulp], [wide, wide, ulp], [ulp, wide, wide]]);
    }
}
