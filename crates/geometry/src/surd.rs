//! Exact numbers p + q·√n: coordinates of points of curved bodies.

use std::ops::{Add, Mul, Neg, Sub};

use crate::{
    dyadic::Dyadic,
    ring::{Ring, Sign},
};

/// p + q·√n with dyadic p, q and a dyadic n > 0. Two surds that meet in an operation must have the same n, unless
/// one of them is dyadic.
#[derive(Clone, Debug)]
pub struct Surd {
    rational: Dyadic,
    /// The factor q and the radicand n; `None` is q = 0.
    root: Option<(Dyadic, Dyadic)>,
}

impl Surd {
    /// q·√n; n must be positive.
    pub fn root(factor: Dyadic, radicand: Dyadic) -> Self {
        debug_assert!(radicand.sign() == Sign::Positive, "the root of a positive number");
        Self { rational: Dyadic::zero(), root: Some((factor, radicand)) }
    }
}

impl Surd {
    /// The part without the root.
    pub fn rational(&self) -> &Dyadic {
        &self.rational
    }
}

impl Default for Surd {
    fn default() -> Self {
        Self::from(Dyadic::zero())
    }
}

impl From<Dyadic> for Surd {
    fn from(rational: Dyadic) -> Self {
        Self { rational, root: None }
    }
}

impl Ring for Surd {
    fn sign(&self) -> Sign {
        let rational = self.rational.sign();
        let Some((factor, radicand)) = &self.root else { return rational };
        let irrational = factor.sign();
        if irrational == Sign::Zero || rational == irrational {
            return rational;
        }
        if rational == Sign::Zero {
            return irrational;
        }
        let rational_square = self.rational.clone() * self.rational.clone();
        let root_square = factor.clone() * factor.clone() * radicand.clone();
        // Opposite signs: the larger magnitude wins.
        match (rational_square - root_square).sign() {
            Sign::Positive => rational,
            Sign::Negative => irrational,
            Sign::Zero => Sign::Zero,
        }
    }
}

impl Add for Surd {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let root = match (self.root, other.root) {
            (Some((a, n)), Some((b, _))) => Some((a + b, n)),
            (a, b) => a.or(b),
        };
        Self { rational: self.rational + other.rational, root }
    }
}

impl Sub for Surd {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Surd {
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

impl Neg for Surd {
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
