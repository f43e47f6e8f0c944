//! Numbers p + q·√n: coordinates of points of curved bodies.

use std::ops::{Add, Mul, Neg, Sub};

use crate::{
    decide::Decide,
    dyadic::Dyadic,
    pair::Pair,
    ring::{Ring, Sign},
};

/// p + q·√n with p, q and n > 0 in `T`: exact numbers, or pairs of floats with their bounds. Two surds that meet in an operation
/// must have the same n, unless one of them has no root.
#[derive(Clone, Debug)]
pub struct Surd<T = Dyadic> {
    rational: T,
    /// The factor q and the radicand n; `None` is q = 0.
    root: Option<(T, T)>,
}

impl<T: Decide> Surd<T> {
    /// The part without the root.
    pub fn rational(&self) -> &T {
        &self.rational
    }

    /// q·√n; n must be positive.
    pub fn root(factor: T, radicand: T) -> Self {
        debug_assert!(radicand.decide().is_none_or(|sign| sign == Sign::Positive), "the root of a positive number");
        Self { rational: T::number(0.0), root: Some((factor, radicand)) }
    }

    /// A number without a root.
    pub(crate) fn plain(rational: T) -> Self {
        Self { rational, root: None }
    }

    /// The sign, if those that it follows from are known.
    fn known_sign(&self) -> Option<Sign> {
        let rational = self.rational.decide()?;
        let Some((factor, radicand)) = &self.root else { return Some(rational) };
        let irrational = factor.decide()?;
        if irrational == Sign::Zero || rational == irrational {
            return Some(rational);
        }
        if rational == Sign::Zero {
            return Some(irrational);
        }
        let rational_square = self.rational.clone() * self.rational.clone();
        let root_square = factor.clone() * factor.clone() * radicand.clone();
        // Opposite signs: the larger magnitude wins.
        Some(match (rational_square - root_square).decide()? {
            Sign::Positive => rational,
            Sign::Negative => irrational,
            Sign::Zero => Sign::Zero,
        })
    }
}

impl<T: Decide> Default for Surd<T> {
    fn default() -> Self {
        Self::plain(T::number(0.0))
    }
}

impl From<Dyadic> for Surd {
    fn from(rational: Dyadic) -> Self {
        Self::plain(rational)
    }
}

impl Ring for Surd {
    fn sign(&self) -> Sign {
        // Signs of exact numbers are always known.
        self.known_sign().unwrap_or(Sign::Zero)
    }
}

impl Decide for Surd<Pair> {
    fn number(value: f64) -> Self {
        Self::plain(Pair::number(value))
    }

    fn decide(&self) -> Option<Sign> {
        self.known_sign()
    }
}

impl<T: Decide> Add for Surd<T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let root = match (self.root, other.root) {
            (Some((a, n)), Some((b, _))) => Some((a + b, n)),
            (a, b) => a.or(b),
        };
        Self { rational: self.rational + other.rational, root }
    }
}

impl<T: Decide> Sub for Surd<T> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<T: Decide> Mul for Surd<T> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let mut rational = self.rational.clone() * other.rational.clone();
        let root = match (self.root, other.root) {
            (Some((a, n)), Some((b, _))) => {
                rational = rational + a.clone() * b.clone() * n.clone();
                Some((self.rational * b + other.rational * a, n))
            }
            (Some((a, n)), None) => Some((a * other.rational, n)),
            (None, Some((b, n))) => Some((self.rational * b, n)),
            (None, None) => None,
        };
        Self { rational, root }
    }
}

impl<T: Decide> Neg for Surd<T> {
    type Output = Self;
    fn neg(self) -> Self {
        Self { rational: -self.rational, root: self.root.map(|(factor, radicand)| (-factor, radicand)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surd(p: f64, q: f64, n: f64) -> Surd {
        Surd::from(Dyadic::new(p)) + Surd::root(Dyadic::new(q), Dyadic::new(n))
    }

    #[test]
    fn signs_at_and_beside_zero() {
        assert_eq!(surd(3.0, -1.0, 9.0).sign(), Sign::Zero);
        assert_eq!(surd(3.0_f64.next_up(), -1.0, 9.0).sign(), Sign::Positive);
        assert_eq!(surd(3.0_f64.next_down(), -1.0, 9.0).sign(), Sign::Negative);
        assert_eq!(surd(-1.5, 1.0, 2.0).sign(), Sign::Negative);
        assert_eq!(surd(0.0, -1.0, 2.0).sign(), Sign::Negative);
    }

    #[test]
    fn products_multiply_out() {
        // (1 + √2)² = 3 + 2√2
        let square = surd(1.0, 1.0, 2.0) * surd(1.0, 1.0, 2.0);
        assert_eq!((square - surd(3.0, 2.0, 2.0)).sign(), Sign::Zero);
    }
}
