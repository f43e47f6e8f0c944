//! Truncated Taylor series over intervals, for rigorous remainders of quadrature (Moore, "Interval Analysis", 1966).
//!
//! Loops are written out: arrays made by closures are not inlined, and take half the time of an area.

use std::ops::{Add, Mul, Sub};

use crate::approx::Approx;

/// The Taylor coefficients f, f', f''/2, … of a function of one variable at every point of an interval: each holds the
/// coefficient's whole range.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jet<const K: usize>(pub(crate) [Approx; K]);

impl<const K: usize> Jet<K> {
    /// A number.
    pub(crate) fn constant(value: Approx) -> Self {
        let mut coefficients = [Approx::exact(0.0); K];
        coefficients[0] = value;
        Self(coefficients)
    }

    /// The variable itself, somewhere in `value`.
    pub(crate) fn variable(value: Approx) -> Self {
        let mut jet = Self::constant(value);
        if K > 1 {
            jet.0[1] = Approx::exact(1.0);
        }
        jet
    }

    /// A number times this.
    pub(crate) fn scaled(mut self, factor: Approx) -> Self {
        for coefficient in &mut self.0 {
            *coefficient = *coefficient * factor;
        }
        self
    }

    /// Above this all coefficients are exactly zero: those of lines and parabolas need not be gone through.
    fn degree(&self) -> usize {
        self.0.iter().rposition(|coefficient| coefficient.value != 0.0 || coefficient.error != 0.0).unwrap_or(0)
    }

    /// The quotient; of no use where the divisor may be zero.
    pub(crate) fn divided_by(self, divisor: Self) -> Self {
        let mut quotient = [Approx::exact(0.0); K];
        let degree = divisor.degree();
        for k in 0..K {
            let carried = (1..=k.min(degree)).fold(self.0[k], |rest, j| rest - divisor.0[j] * quotient[k - j]);
            quotient[k] = carried.divided_by(divisor.0[0]);
        }
        Self(quotient)
    }

    /// The square; its value is never below zero, whatever the interval.
    pub(crate) fn squared(self) -> Self {
        let mut square = self * self;
        square.0[0] = self.0[0].squared();
        square
    }

    /// The root; of no use where this may be zero.
    pub(crate) fn square_root(self) -> Self {
        let mut root = [Approx::exact(0.0); K];
        root[0] = self.0[0].square_root();
        let twice = root[0] + root[0];
        for k in 1..K {
            // Each product but the middle one comes twice.
            let half = (1..k.div_ceil(2)).fold(Approx::exact(0.0), |sum, j| sum + root[j] * root[k - j]);
            let middle = if k % 2 == 0 { root[k / 2].squared() } else { Approx::exact(0.0) };
            root[k] = (self.0[k] - (half + half + middle)).divided_by(twice);
        }
        Self(root)
    }
}

impl<const K: usize> Default for Jet<K> {
    fn default() -> Self {
        Self::constant(Approx::exact(0.0))
    }
}

impl<const K: usize> Add for Jet<K> {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        for (own, others) in self.0.iter_mut().zip(&other.0) {
            *own = *own + *others;
        }
        self
    }
}

impl<const K: usize> Sub for Jet<K> {
    type Output = Self;
    fn sub(mut self, other: Self) -> Self {
        for (own, others) in self.0.iter_mut().zip(&other.0) {
            *own = *own - *others;
        }
        self
    }
}

impl<const K: usize> Mul for Jet<K> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (own, others) = (self.degree(), other.degree());
        let mut product = [Approx::exact(0.0); K];
        for (k, coefficient) in product.iter_mut().enumerate().take(own + others + 1) {
            let first = k.saturating_sub(others);
            let mut sum = self.0[first] * other.0[k - first];
            for j in first + 1..=k.min(own) {
                sum = sum + self.0[j] * other.0[k - j];
            }
            *coefficient = sum;
        }
        Self(product)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_of_known_functions() {
        // 1/√(1 + x) at 0: 1, −1/2, 3/8, −5/16, 35/128.
        let x = Jet::<5>::variable(Approx::exact(0.0));
        let one = Jet::constant(Approx::exact(1.0));
        let series = one.divided_by((one + x).square_root());
        for (coefficient, expected) in series.0.iter().zip([1.0, -0.5, 0.375, -0.3125, 0.273_437_5]) {
            assert!((coefficient.value - expected).abs() <= coefficient.error + 1e-300, "{coefficient:?} {expected}");
            assert!(coefficient.error < 1e-14);
        }
    }
}
