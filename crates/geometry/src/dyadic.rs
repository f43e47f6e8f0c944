//! Exact dyadic rationals m·2^e: every float, and every sum, difference and product of floats.

use std::ops::{Add, Mul, Neg, Sub};

use num_bigint::{BigInt, Sign as BigSign};
use num_traits::Zero;

use crate::{
    approx::Approx,
    ring::{Ring, Sign},
};

/// m·2^e with a big integer m. Sums, differences and products are exact; there is no division.
#[derive(Clone, Debug)]
pub struct Dyadic {
    mantissa: BigInt,
    exponent: i64,
}

impl Dyadic {
    /// The exact value of a finite float.
    ///
    /// # Panics
    /// If `value` is NaN or infinite.
    pub fn new(value: f64) -> Self {
        assert!(value.is_finite(), "only finite numbers have an exact value");
        let bits = value.to_bits();
        let biased = ((bits >> 52) & 0x7ff) as i64;
        let fraction = bits & ((1 << 52) - 1);
        let (mantissa, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | (1 << 52), biased - 1075) };
        if mantissa == 0 {
            return Self::zero();
        }
        let shift = mantissa.trailing_zeros();
        let magnitude = BigInt::from(mantissa >> shift);
        let mantissa = if value < 0.0 { -magnitude } else { magnitude };
        Self { mantissa, exponent: exponent + i64::from(shift) }
    }

    /// Zero.
    pub fn zero() -> Self {
        Self { mantissa: BigInt::zero(), exponent: 0 }
    }

    /// 2^power.
    pub(crate) fn power_of_two(power: i64) -> Self {
        Self { mantissa: BigInt::from(1), exponent: power }
    }

    /// The power of the largest power of two that is not above the magnitude; `None` of zero.
    pub(crate) fn magnitude(&self) -> Option<i64> {
        (!self.mantissa.is_zero()).then(|| self.mantissa.bits() as i64 - 1 + self.exponent)
    }

    /// The float nearest to the exact value with a bound on the difference; exact when it is a float. The sign of the float is the exact sign, also
    /// of a number beyond the normal floats: the least or the greatest of these stands for it.
    pub fn to_approx(&self) -> Approx {
        let value = self.to_nearest();
        if self.is_float() {
            return Approx::exact(value);
        }
        match self.magnitude() {
            // The interval from the least float on: its lower end, rounded outward, is zero.
            Some(..-1022) => {
                let least = f64::MIN_POSITIVE;
                Approx { value: least.copysign(value), error: least.next_down() }
            }
            _ if value.is_infinite() => Approx { value: f64::MAX.copysign(value), error: f64::INFINITY },
            _ => Approx { value, error: value.abs() * f64::EPSILON },
        }
    }

    fn is_float(&self) -> bool {
        let spare = self.mantissa.trailing_zeros().unwrap_or(0);
        let is_in_range = |power| power < 1024 && self.exponent + spare as i64 >= -1074;
        self.mantissa.bits() - spare <= 53 && self.magnitude().is_none_or(is_in_range)
    }

    /// The float nearest to the exact value, ties to even; below the normal floats one of the two beside it.
    pub fn to_nearest(&self) -> f64 {
        let bits = self.mantissa.bits();
        if bits <= 53 {
            return scale_by_power_of_two(big_to_f64(&self.mantissa), self.exponent);
        }
        let surplus = bits - 53;
        let magnitude = self.mantissa.magnitude();
        let mut head = magnitude >> surplus;
        let half = (magnitude >> (surplus - 1)).bit(0);
        let below = magnitude.trailing_zeros().unwrap_or(0) < surplus - 1;
        if half && (below || head.bit(0)) {
            head += 1u32;
        }
        let value = scale_by_power_of_two(big_to_f64(&BigInt::from(head)), self.exponent + surplus as i64);
        if self.mantissa.sign() == BigSign::Minus { -value } else { value }
    }
}

/// The value of an integer of at most 54 bits, exactly (a 54-bit integer here is a power of two).
fn big_to_f64(integer: &BigInt) -> f64 {
    let magnitude = integer.magnitude().iter_u64_digits().next().unwrap_or(0) as f64;
    if integer.sign() == BigSign::Minus { -magnitude } else { magnitude }
}

/// value·2^power in steps that stay in the range of normal numbers.
fn scale_by_power_of_two(mut value: f64, mut power: i64) -> f64 {
    while power != 0 && value != 0.0 && value.is_finite() {
        let step = power.clamp(-1000, 1000);
        value *= f64::from_bits(((1023 + step) as u64) << 52);
        power -= step;
    }
    value
}

impl Ring for Dyadic {
    fn sign(&self) -> Sign {
        match self.mantissa.sign() {
            BigSign::Minus => Sign::Negative,
            BigSign::NoSign => Sign::Zero,
            BigSign::Plus => Sign::Positive,
        }
    }
}

impl Default for Dyadic {
    fn default() -> Self {
        Self::zero()
    }
}

impl From<f64> for Dyadic {
    fn from(value: f64) -> Self {
        Self::new(value)
    }
}

fn aligned(a: Dyadic, b: Dyadic) -> (BigInt, BigInt, i64) {
    let exponent = a.exponent.min(b.exponent);
    (a.mantissa << (a.exponent - exponent), b.mantissa << (b.exponent - exponent), exponent)
}

impl Add for Dyadic {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        if self.mantissa.is_zero() {
            return other;
        }
        if other.mantissa.is_zero() {
            return self;
        }
        let (a, b, exponent) = aligned(self, other);
        Self { mantissa: a + b, exponent }
    }
}

impl Sub for Dyadic {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Dyadic {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self { mantissa: self.mantissa * other.mantissa, exponent: self.exponent + other.exponent }
    }
}

impl Neg for Dyadic {
    type Output = Self;
    fn neg(self) -> Self {
        Self { mantissa: -self.mantissa, exponent: self.exponent }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair::Pair;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_float_survives_the_round_trip(value in proptest::num::f64::NORMAL | proptest::num::f64::ZERO) {
            prop_assert_eq!(Dyadic::new(value).to_nearest(), value);
            prop_assert_eq!(Dyadic::new(value).to_approx(), Approx::exact(value));
        }

        #[test]
        fn a_product_rounds_like_the_hardware(a in -1e100..1e100, b in -1e100..1e100) {
            let product = Dyadic::new(a) * Dyadic::new(b);
            prop_assert_eq!(product.to_nearest(), a * b);
            let approx = product.to_approx();
            prop_assert!((approx.value - a * b).abs() <= approx.error);
        }

        #[test]
        fn a_sum_rounds_like_the_hardware(a in -1e30..1e30, b in -1e-10..1e10) {
            prop_assert_eq!((Dyadic::new(a) + Dyadic::new(b)).to_nearest(), a + b);
            prop_assert_eq!((Dyadic::new(a) - Dyadic::new(b)).to_nearest(), a - b);
        }
    }

    #[test]
    fn signs_are_exact_where_floats_cancel() {
        let (big, small) = (Dyadic::new(1e200), Dyadic::new(1e-200));
        let sum = big.clone() + small.clone() - big;
        assert_eq!(sum.sign(), Sign::Positive, "the small part survives");
        assert_eq!((sum - small).sign(), Sign::Zero);
    }

    #[test]
    fn beyond_the_normal_floats_signs_are_right_and_bounds_hold() {
        for power in [-1023, -1074, -1075, -1200, -5000] {
            let tiny = Dyadic::power_of_two(power) + Dyadic::power_of_two(power - 3);
            for number in [tiny.clone(), -tiny] {
                let approx = number.to_approx();
                assert_eq!(approx.sign(), Some(number.sign()), "2^{power}");
                let beyond = |end: f64| (number.clone() - Dyadic::new(end)).sign();
                assert_ne!(beyond(approx.lower()), Sign::Negative, "2^{power}");
                assert_ne!(beyond(approx.upper()), Sign::Positive, "2^{power}");
                let pair = Pair::from(&number);
                assert!(pair.sign().is_none_or(|sign| sign == number.sign()), "2^{power}");
            }
        }
        let huge = -Dyadic::power_of_two(1024);
        assert_eq!((Sign::of(huge.to_approx().value), huge.to_approx().sign()), (Sign::Negative, None));
        assert_eq!(Pair::from(&huge).sign(), None);
        assert_eq!(Dyadic::power_of_two(-1074).to_approx(), Approx::exact(f64::from_bits(1)));
    }
}
