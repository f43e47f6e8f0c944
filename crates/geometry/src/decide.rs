//! Numbers whose signs can be told, or not: so that one code serves filters ([`Approx`]) and exact numbers.

use std::ops::{Add, Mul, Neg, Sub};

use crate::{
    approx::Approx,
    ring::{Ring, Sign},
};

/// Numbers whose signs can be told, or not.
pub trait Decide: Clone + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self> {
    /// The exact value of a float.
    fn number(value: f64) -> Self;

    /// The sum; rounded alike whatever the order of the terms.
    fn sum_of_three([a, b, c]: [Self; 3]) -> Self {
        a + b + c
    }

    /// The sign, if it is known.
    fn decide(&self) -> Option<Sign>;

    /// About self / divisor, as a first guess; `None` where that is dear.
    fn about_ratio(&self, _divisor: &Self) -> Option<f64> {
        None
    }

    /// The sign of α + β·√d, d ≥ 0, if it is known.
    fn decide_with_root(alpha: Self, beta: Self, d: Self) -> Option<Sign> {
        let (a, b) = (alpha.decide()?, beta.decide()?.times(d.decide()?));
        Some(match (a, b) {
            (a, Sign::Zero) => a,
            (Sign::Zero, b) => b,
            (a, b) if a == b => a,
            // Opposite signs: the larger magnitude wins.
            _ => match (alpha.clone() * alpha - beta.clone() * beta * d).decide()? {
                Sign::Positive => a,
                Sign::Negative => b,
                Sign::Zero => Sign::Zero,
            },
        })
    }

    /// The sign of α + β·√d + γ·√e, d and e ≥ 0, if it is known.
    fn decide_with_roots(alpha: Self, [beta, d]: [Self; 2], [gamma, e]: [Self; 2]) -> Option<Sign> {
        let first = Self::decide_with_root(alpha.clone(), beta.clone(), d.clone())?;
        let last = gamma.decide()?.times(e.decide()?);
        Some(match (first, last) {
            (first, Sign::Zero) => first,
            (Sign::Zero, last) => last,
            (first, last) if first == last => first,
            // Opposite signs: the larger square wins, (α + β·√d)² − γ²·e = (α² + β²·d − γ²·e) + 2αβ·√d.
            _ => {
                let product = alpha.clone() * beta.clone();
                let squares = alpha.clone() * alpha + beta.clone() * beta * d.clone() - gamma.clone() * gamma * e;
                match Self::decide_with_root(squares, product.clone() + product, d)? {
                    Sign::Positive => first,
                    Sign::Negative => last,
                    Sign::Zero => Sign::Zero,
                }
            }
        })
    }
}

impl<R: Ring> Decide for R {
    fn number(value: f64) -> Self {
        R::from_f64(value)
    }

    fn decide(&self) -> Option<Sign> {
        Some(self.sign())
    }
}

impl Decide for Approx {
    fn number(value: f64) -> Self {
        Self::exact(value)
    }

    fn sum_of_three(terms: [Self; 3]) -> Self {
        Approx::sum_of_three(terms)
    }

    fn about_ratio(&self, divisor: &Self) -> Option<f64> {
        Some(self.value / divisor.value)
    }

    fn decide(&self) -> Option<Sign> {
        self.sign()
    }

    fn decide_with_root(alpha: Self, beta: Self, d: Self) -> Option<Sign> {
        (alpha + beta * d.square_root()).sign()
    }

    fn decide_with_roots(alpha: Self, [beta, d]: [Self; 2], [gamma, e]: [Self; 2]) -> Option<Sign> {
        (alpha + beta * d.square_root() + gamma * e.square_root()).sign()
    }
}
