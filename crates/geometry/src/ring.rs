//! Exact numbers: what the fallbacks of the predicates compute with.

use std::ops::{Add, Mul, Neg, Sub};

use crate::{decide::Decide, dyadic::Dyadic};

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

/// The determinant of three rows, as exact as its numbers; columns may change places without changing a bit but the sign.
pub(crate) fn determinant<T: Decide>(rows: &[[T; 3]; 3]) -> T {
    let term = |k: usize| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let minor = rows[1][i].clone() * rows[2][j].clone() - rows[1][j].clone() * rows[2][i].clone();
        rows[0][k].clone() * minor
    };
    T::sum_of_three([term(0), term(1), term(2)])
}

/// The dot product, as exact as its numbers.
pub(crate) fn dot<T: Decide>(a: &[T; 3], b: &[T; 3]) -> T {
    a[0].clone() * b[0].clone() + a[1].clone() * b[1].clone() + a[2].clone() * b[2].clone()
}
