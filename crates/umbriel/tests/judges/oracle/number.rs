//! The oracle's numbers: binary fractions m·2^e of any size, and sums a + b·√n of them.
//!
//! Every input is a float, so every sum and product of inputs is a binary fraction: nothing is ever rounded, nothing is
//! ever reduced. Points of a sphere bring one square root; the sign of a + b·√n is found by comparing a² with b²·n.

use std::ops::{Add, Mul, Neg, Sub};

use num_bigint::{BigInt, Sign};
use num_traits::{Signed, ToPrimitive, Zero};

/// The number `mantissa`·2^`exponent`, exact.
#[derive(Clone, Debug)]
pub(crate) struct Binary {
    mantissa: BigInt,
    exponent: i64,
}

impl Binary {
    /// The value of a finite float.
    pub(crate) fn new(value: f64) -> Self {
        assert!(value.is_finite(), "{value} is no number");
        let bits = value.to_bits();
        let (field, fraction) = ((bits >> 52 & 0x7ff) as i64, (bits & ((1 << 52) - 1)) as i64);
        let (whole, exponent) = if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
        if whole == 0 {
            return Self::zero();
        }
        // Whole numbers stay small: trailing zeros go into the exponent.
        let zeros = whole.trailing_zeros();
        let magnitude = BigInt::from(whole >> zeros);
        Self { mantissa: if value < 0.0 { -magnitude } else { magnitude }, exponent: exponent + i64::from(zeros) }
    }

    /// 2^`exponent`.
    pub(crate) fn power_of_two(exponent: i64) -> Self {
        Self { mantissa: BigInt::from(1), exponent }
    }

    /// Zero.
    pub(crate) fn zero() -> Self {
        Self { mantissa: BigInt::zero(), exponent: 0 }
    }

    /// −1, 0 or 1.
    pub(crate) fn sign(&self) -> i8 {
        match self.mantissa.sign() {
            Sign::Minus => -1,
            Sign::NoSign => 0,
            Sign::Plus => 1,
        }
    }

    /// The nearest float, ties to even, for results in the normal range.
    pub(crate) fn to_nearest(&self) -> f64 {
        self.to_nearest_of(53)
    }

    /// The nearest number with `digits` binary digits, ties to even.
    pub(crate) fn to_nearest_of(&self, digits: u64) -> f64 {
        let magnitude = self.mantissa.abs();
        let excess = magnitude.bits().saturating_sub(digits);
        let mut kept = &magnitude >> excess;
        let rest = &magnitude - (&kept << excess);
        let doubled: BigInt = rest << 1;
        let half = BigInt::from(1) << excess;
        let is_odd = kept.bit(0);
        if excess > 0 && (doubled > half || (doubled == half && is_odd)) {
            kept += 1;
        }
        let value = kept.to_u64().expect("at most 2^53") as f64;
        // Two steps, so that no power of two leaves the range of floats before the product does.
        let power = self.exponent + excess as i64;
        let scaled = value * 2f64.powi((power / 2) as i32) * 2f64.powi((power - power / 2) as i32);
        if self.mantissa.is_negative() { -scaled } else { scaled }
    }

    fn aligned(&self, other: &Self) -> (BigInt, BigInt, i64) {
        let exponent = self.exponent.min(other.exponent);
        let shift = |n: &Self| &n.mantissa << (n.exponent - exponent) as u64;
        (shift(self), shift(other), exponent)
    }
}

impl Add for &Binary {
    type Output = Binary;
    fn add(self, other: Self) -> Binary {
        if self.mantissa.is_zero() {
            return other.clone();
        }
        if other.mantissa.is_zero() {
            return self.clone();
        }
        let (a, b, exponent) = self.aligned(other);
        Binary { mantissa: a + b, exponent }
    }
}

impl Sub for &Binary {
    type Output = Binary;
    fn sub(self, other: Self) -> Binary {
        self + &-other
    }
}

impl Mul for &Binary {
    type Output = Binary;
    fn mul(self, other: Self) -> Binary {
        if self.mantissa.is_zero() || other.mantissa.is_zero() {
            return Binary::zero();
        }
        Binary { mantissa: &self.mantissa * &other.mantissa, exponent: self.exponent + other.exponent }
    }
}

impl Neg for &Surd {
    type Output = Surd;
    fn neg(self) -> Surd {
        Surd { rational: -&self.rational, irrational: -&self.irrational }
    }
}

impl Neg for &Binary {
    type Output = Binary;
    fn neg(self) -> Binary {
        Binary { mantissa: -&self.mantissa, exponent: self.exponent }
    }
}

/// Three exact coordinates.
pub(crate) type Vector = [Binary; 3];

/// The exact value of three floats.
pub(crate) fn vector(values: [f64; 3]) -> Vector {
    values.map(Binary::new)
}

/// a + b.
pub(crate) fn plus(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|i| &a[i] + &b[i])
}

/// a − b.
pub(crate) fn minus(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|i| &a[i] - &b[i])
}

/// k·a.
pub(crate) fn times(k: &Binary, a: &Vector) -> Vector {
    std::array::from_fn(|i| k * &a[i])
}

/// a·b.
pub(crate) fn dot(a: &Vector, b: &Vector) -> Binary {
    &(&(&a[0] * &b[0]) + &(&a[1] * &b[1])) + &(&a[2] * &b[2])
}

/// a × b.
pub(crate) fn cross(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        &(&a[j] * &b[k]) - &(&a[k] * &b[j])
    })
}

/// Whether all coordinates are zero.
pub(crate) fn is_zero(a: &Vector) -> bool {
    a.iter().all(|coordinate| coordinate.sign() == 0)
}

/// The number rational + irrational·√n; n belongs to the point it came from.
#[derive(Clone, Debug)]
pub(crate) struct Surd {
    /// The part without the root.
    pub(crate) rational: Binary,
    /// What multiplies the root.
    pub(crate) irrational: Binary,
}

impl Surd {
    /// The sign, given n ≥ 0.
    pub(crate) fn sign(&self, radicand: &Binary) -> i8 {
        let (a, b) = (self.rational.sign(), if radicand.sign() == 0 { 0 } else { self.irrational.sign() });
        if a * b >= 0 {
            return (a + b).signum();
        }
        let (a_squared, b_squared) = (&self.rational * &self.rational, &self.irrational * &self.irrational);
        a * (&a_squared - &(&b_squared * radicand)).sign()
    }

    /// The square, given n.
    pub(crate) fn squared(&self, radicand: &Binary) -> Self {
        let (a, b) = (&self.rational, &self.irrational);
        let product = a * b;
        Self { rational: &(a * a) + &(&(b * b) * radicand), irrational: &product + &product }
    }

    /// A number without the root.
    pub(crate) fn plain(rational: Binary) -> Self {
        Self { rational, irrational: Binary::zero() }
    }

    /// The sum.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self { rational: &self.rational + &other.rational, irrational: &self.irrational + &other.irrational }
    }

    /// The product, given n.
    pub(crate) fn times(&self, other: &Self, radicand: &Binary) -> Self {
        let (a, b, c, d) = (&self.rational, &self.irrational, &other.rational, &other.irrational);
        Self { rational: &(a * c) + &(&(b * d) * radicand), irrational: &(a * d) + &(b * c) }
    }

    /// k times this.
    pub(crate) fn scaled(&self, k: &Binary) -> Self {
        Self { rational: &self.rational * k, irrational: &self.irrational * k }
    }

    /// This minus k·other.
    pub(crate) fn minus_scaled(&self, other: &Self, k: &Binary) -> Self {
        Self {
            rational: &self.rational - &(&other.rational * k),
            irrational: &self.irrational - &(&other.irrational * k),
        }
    }
}
