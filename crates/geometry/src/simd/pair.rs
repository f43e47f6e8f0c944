//! Sixteen lanes as two vectors of eight, for levels whose registers hold eight.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::{Float, Int, Mask};

/// Lanes 0 to 7, and lanes 8 to 15.
#[derive(Clone, Copy, Debug)]
pub struct Pair<V>(pub(super) V, pub(super) V);

/// Two arrays, one behind the other.
#[inline(always)]
fn join<T: Copy + Default>(low: [T; 8], high: [T; 8]) -> [T; 16] {
    let mut joined = [T::default(); 16];
    joined[..8].copy_from_slice(&low);
    joined[8..].copy_from_slice(&high);
    joined
}

/// The halves of an array.
#[inline(always)]
pub(super) fn halves<T>(values: &[T; 16]) -> [&[T; 8]; 2] {
    let (chunks, _) = values.as_chunks::<8>();
    [&chunks[0], &chunks[1]]
}

impl<V: Float<8>> Float<16> for Pair<V> {
    type Int = Pair<V::Int>;
    type Mask = Pair<V::Mask>;

    #[inline(always)]
    fn to_array(self) -> [f32; 16] {
        join(self.0.to_array(), self.1.to_array())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.min(other.1))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self(self.0.floor(), self.1.floor())
    }
    #[inline(always)]
    fn to_int(self) -> Self::Int {
        Pair(self.0.to_int(), self.1.to_int())
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        Pair(self.0.lt(other.0), self.1.lt(other.1))
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        Pair(self.0.le(other.0), self.1.le(other.1))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Self::Mask {
        Pair(self.0.eq(other.0), self.1.eq(other.1))
    }
    #[inline(always)]
    fn select(self, mask: Self::Mask, other: Self) -> Self {
        Self(self.0.select(mask.0, other.0), self.1.select(mask.1, other.1))
    }
    #[inline(always)]
    fn flip_sign(self, signs: Self) -> Self {
        Self(self.0.flip_sign(signs.0), self.1.flip_sign(signs.1))
    }
}

impl<V: Int<8>> Int<16> for Pair<V> {
    type Float = Pair<V::Float>;
    type Mask = Pair<V::Mask>;

    #[inline(always)]
    fn to_array(self) -> [i32; 16] {
        join(self.0.to_array(), self.1.to_array())
    }
    #[inline(always)]
    fn to_float(self) -> Self::Float {
        Pair(self.0.to_float(), self.1.to_float())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.min(other.1))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        Pair(self.0.lt(other.0), self.1.lt(other.1))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Self::Mask {
        Pair(self.0.eq(other.0), self.1.eq(other.1))
    }
    #[inline(always)]
    fn select(self, mask: Self::Mask, other: Self) -> Self {
        Self(self.0.select(mask.0, other.0), self.1.select(mask.1, other.1))
    }
    #[inline(always)]
    fn bits_from(self) -> Self {
        Self(self.0.bits_from(), self.1.bits_from())
    }
    #[inline(always)]
    fn without(self, other: Self) -> Self {
        Self(self.0.without(other.0), self.1.without(other.1))
    }
}

impl<M: Mask> Mask for Pair<M> {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.bits() | self.1.bits() << 8
    }
}

impl<V: Add<Output = V>> Add for Pair<V> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0, self.1 + other.1)
    }
}

impl<V: Sub<Output = V>> Sub for Pair<V> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0, self.1 - other.1)
    }
}

impl<V: Mul<Output = V>> Mul for Pair<V> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0, self.1 * other.1)
    }
}

impl<V: Div<Output = V>> Div for Pair<V> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0, self.1 / other.1)
    }
}

impl<V: Neg<Output = V>> Neg for Pair<V> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl<M: BitAnd<Output = M>> BitAnd for Pair<M> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0, self.1 & other.1)
    }
}

impl<M: BitOr<Output = M>> BitOr for Pair<M> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0, self.1 | other.1)
    }
}

impl<M: Not<Output = M>> Not for Pair<M> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0, !self.1)
    }
}
