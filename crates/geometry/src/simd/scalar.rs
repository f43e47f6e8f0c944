//! The scalar twin: plain loops over arrays. What these loops compute is what every other level must compute.

use std::{
    array,
    ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub},
};

use super::{Float, Int, Lanes, Level, Mask, Simd};

/// The level that every processor has.
#[derive(Clone, Copy, Debug)]
pub struct Scalar;

/// `N` floats.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct ScalarFloat<const N: usize>([f32; N]);

/// `N` integers.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct ScalarInt<const N: usize>([i32; N]);

/// `N` truth values, one bit each.
#[derive(Clone, Copy, Debug)]
pub struct ScalarMask<const N: usize>(u32);

impl Simd for Scalar {
    const LEVEL: Level = Level::Scalar;
}

impl<const N: usize> Lanes<N> for Scalar {
    type Float = ScalarFloat<N>;
    type Int = ScalarInt<N>;
    type Mask = ScalarMask<N>;

    #[inline(always)]
    fn splat(self, value: f32) -> ScalarFloat<N> {
        ScalarFloat([value; N])
    }
    #[inline(always)]
    fn load(self, values: &[f32; N]) -> ScalarFloat<N> {
        ScalarFloat(*values)
    }
    #[inline(always)]
    fn splat_int(self, value: i32) -> ScalarInt<N> {
        ScalarInt([value; N])
    }
    #[inline(always)]
    fn load_int(self, values: &[i32; N]) -> ScalarInt<N> {
        ScalarInt(*values)
    }
    #[inline(always)]
    fn load_bytes(self, values: &[u8; N]) -> ScalarInt<N> {
        ScalarInt(values.map(i32::from))
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> ScalarMask<N> {
        ScalarMask(bits & all::<N>())
    }
}

/// One bit for each lane.
const fn all<const N: usize>() -> u32 {
    u32::MAX >> (32 - N)
}

#[inline(always)]
fn mask_of<const N: usize>(is_true: impl Fn(usize) -> bool) -> ScalarMask<N> {
    ScalarMask((0..N).fold(0, |bits, lane| bits | u32::from(is_true(lane)) << lane))
}

impl<const N: usize> ScalarFloat<N> {
    #[inline(always)]
    fn map2(self, other: Self, operation: impl Fn(f32, f32) -> f32) -> Self {
        Self(array::from_fn(|lane| operation(self.0[lane], other.0[lane])))
    }
}

impl<const N: usize> ScalarInt<N> {
    #[inline(always)]
    fn map2(self, other: Self, operation: impl Fn(i32, i32) -> i32) -> Self {
        Self(array::from_fn(|lane| operation(self.0[lane], other.0[lane])))
    }
}

impl<const N: usize> Float<N> for ScalarFloat<N> {
    type Int = ScalarInt<N>;
    type Mask = ScalarMask<N>;

    #[inline(always)]
    fn to_array(self) -> [f32; N] {
        self.0
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.map2(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.map2(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self(self.0.map(f32::floor))
    }
    #[inline(always)]
    fn to_int(self) -> ScalarInt<N> {
        // 2^31 is the first float that is too large; −2^31 is an i32.
        const LIMIT: f32 = 2_147_483_648.0;
        ScalarInt(self.0.map(|value| if (-LIMIT..LIMIT).contains(&value) { value as i32 } else { i32::MIN }))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> ScalarMask<N> {
        mask_of(|lane| self.0[lane] < other.0[lane])
    }
    #[inline(always)]
    fn le(self, other: Self) -> ScalarMask<N> {
        mask_of(|lane| self.0[lane] <= other.0[lane])
    }
    #[inline(always)]
    fn eq(self, other: Self) -> ScalarMask<N> {
        mask_of(|lane| self.0[lane] == other.0[lane])
    }
    #[inline(always)]
    fn select(self, mask: ScalarMask<N>, other: Self) -> Self {
        Self(array::from_fn(|lane| if mask.0 >> lane & 1 == 1 { self.0[lane] } else { other.0[lane] }))
    }
    #[inline(always)]
    fn flip_sign(self, signs: Self) -> Self {
        const SIGN: u32 = 1 << 31;
        self.map2(signs, |a, b| f32::from_bits(a.to_bits() ^ b.to_bits() & SIGN))
    }
}

impl<const N: usize> Int<N> for ScalarInt<N> {
    type Float = ScalarFloat<N>;
    type Mask = ScalarMask<N>;

    #[inline(always)]
    fn to_array(self) -> [i32; N] {
        self.0
    }
    #[inline(always)]
    fn to_float(self) -> ScalarFloat<N> {
        ScalarFloat(self.0.map(|value| value as f32))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.map2(other, Ord::min)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.map2(other, Ord::max)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> ScalarMask<N> {
        mask_of(|lane| self.0[lane] < other.0[lane])
    }
    #[inline(always)]
    fn eq(self, other: Self) -> ScalarMask<N> {
        mask_of(|lane| self.0[lane] == other.0[lane])
    }
    #[inline(always)]
    fn select(self, mask: ScalarMask<N>, other: Self) -> Self {
        Self(array::from_fn(|lane| if mask.0 >> lane & 1 == 1 { self.0[lane] } else { other.0[lane] }))
    }
    #[inline(always)]
    fn bits_from(self) -> Self {
        Self(self.0.map(|first| u32::MAX.checked_shl(first as u32).unwrap_or(0) as i32))
    }
    #[inline(always)]
    fn without(self, other: Self) -> Self {
        self.map2(other, |a, b| a & !b)
    }
}

impl<const N: usize> Mask for ScalarMask<N> {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0
    }
}

impl<const N: usize> Add for ScalarFloat<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.map2(other, |a, b| a + b)
    }
}

impl<const N: usize> Sub for ScalarFloat<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.map2(other, |a, b| a - b)
    }
}

impl<const N: usize> Mul for ScalarFloat<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.map2(other, |a, b| a * b)
    }
}

impl<const N: usize> Div for ScalarFloat<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.map2(other, |a, b| a / b)
    }
}

impl<const N: usize> Neg for ScalarFloat<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|value| -value))
    }
}

impl<const N: usize> Add for ScalarInt<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.map2(other, i32::wrapping_add)
    }
}

impl<const N: usize> Sub for ScalarInt<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.map2(other, i32::wrapping_sub)
    }
}

impl<const N: usize> BitAnd for ScalarInt<N> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        self.map2(other, |a, b| a & b)
    }
}

impl<const N: usize> BitOr for ScalarInt<N> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        self.map2(other, |a, b| a | b)
    }
}

impl<const N: usize> BitAnd for ScalarMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl<const N: usize> BitOr for ScalarMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl<const N: usize> Not for ScalarMask<N> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0 & all::<N>())
    }
}
