//! Exact numbers: what the fallbacks of the predicates compute with.

use std::ops::{Add, Mul, Neg, Sub};

use crate::dyadic::Dyadic;

/// The sign of an exactly known number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Sign {
    /// Below zero.
    Negative,
    /// Zero, exactly.
    Zero,
    /// Above zero.
    Positive,
}

impl Sign {
    /// The sign of a float that is known to carry the right sign.
    pub fn of(value: f64) -> Self {
        if value > 0.0 {
            Self::Positive
        } else if value < 0.0 {
            Self::Negative
        } else {
            Self::Zero
        }
    }

    /// The sign of the product.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        match (self, other) {
            (Self::Zero, _) | (_, Self::Zero) => Self::Zero,
            (a, b) if a == b => Self::Positive,
            _ => Self::Negative,
        }
    }

    /// The other sign.
    #[must_use]
    pub fn flipped(self) -> Self {
        self.times(Self::Negative)
    }
}

/// A ring of exact numbers with decidable signs: [`Dyadic`], or [`crate::Surd`] for points of curved bodies.
pub trait Ring:
    Clone + From<Dyadic> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// The exact sign.
    fn sign(&self) -> Sign;

    /// The exact value of a finite float.
    ///
    /// # Panics
    /// If `value` is NaN or infinite.
    fn from_f64(value: f64) -> Self {
        Self::from(Dyadic::new(value))
    }
}

/// The determinant of three rows, as exact as its numbers.
pub(crate) fn determinant<T>(rows: &[[T; 3]; 3]) -> T
where
    T: Clone + Add<Output = T> + Sub<Output = T> + Mul<Output = T>,
{
    let minor = |i: usize, j: usize| rows[1][i].clone() * rows[2][j].clone() - rows[1][j].clone() * rows[2][i].clone();
    rows[0][0].clone() * minor(1, 2) - rows[0][1].clone() * minor(0, 2) + rows[0][2].clone() * minor(0, 1)
}

/// The exact dot product.
pub(crate) fn dot<R: Ring>(a: &[R; 3], b: &[R; 3]) -> R {
    a[0].clone() * b[0].clone() + a[1].clone() * b[1].clone() + a[2].clone() * b[2].clone()
}
