//! AVX2: eight lanes in a register, sixteen as a pair of registers.
//!
//! SAFETY, for every `unsafe` block of this file: the instructions need AVX2 (or AVX, which it includes). An [`Avx2`]
//! exists only where [`Avx2::new`] found the features, and the vectors are made from one or from each other. Loads and
//! stores go through references to arrays of just the size that is moved, by instructions that need no alignment.

#![allow(unsafe_code, reason = "instructions that the compiler cannot know the processor to have")]

use std::{
    arch::x86_64::*,
    ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub},
};

use super::{Float, Int, Kernel, Lanes, Level, Mask, Pair, Simd, pair::halves};

/// The proof that the processor has AVX2 and the bit instructions that came with it.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

/// Eight floats in a register.
#[derive(Clone, Copy, Debug)]
pub struct Avx2Float(__m256);

/// Eight integers in a register.
#[derive(Clone, Copy, Debug)]
pub struct Avx2Int(__m256i);

/// Eight truth values in a register: lanes of all ones or all zeros.
#[derive(Clone, Copy, Debug)]
pub struct Avx2Mask(__m256);

impl Avx2 {
    /// The proof, if there is one. Cost: a few loads; the processor is asked once.
    #[inline]
    pub(super) fn new() -> Option<Self> {
        let has_bits = is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        (is_x86_feature_detected!("avx2") && has_bits).then_some(Self(()))
    }

    /// Runs the kernel with the features switched on.
    #[inline]
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
        fn with_features<K: Kernel>(token: Avx2, kernel: K) -> K::Output {
            kernel.run(token)
        }
        // SAFETY: `self` is the proof that the processor has these features.
        unsafe { with_features(self, kernel) }
    }
}

impl From<super::Avx512> for Avx2 {
    /// AVX-512 is asked for together with AVX2.
    #[inline(always)]
    fn from(_: super::Avx512) -> Self {
        Self(())
    }
}

impl Simd for Avx2 {
    const LEVEL: Level = Level::Avx2;
}

impl Lanes<8> for Avx2 {
    type Float = Avx2Float;
    type Int = Avx2Int;
    type Mask = Avx2Mask;

    #[inline(always)]
    fn splat(self, value: f32) -> Avx2Float {
        Avx2Float(unsafe { _mm256_set1_ps(value) })
    }
    #[inline(always)]
    fn load(self, values: &[f32; 8]) -> Avx2Float {
        Avx2Float(unsafe { _mm256_loadu_ps(values.as_ptr()) })
    }
    #[inline(always)]
    fn splat_int(self, value: i32) -> Avx2Int {
        Avx2Int(unsafe { _mm256_set1_epi32(value) })
    }
    #[inline(always)]
    fn load_int(self, values: &[i32; 8]) -> Avx2Int {
        Avx2Int(unsafe { _mm256_loadu_si256(values.as_ptr().cast()) })
    }
    #[inline(always)]
    fn load_bytes(self, values: &[u8; 8]) -> Avx2Int {
        Avx2Int(unsafe { _mm256_cvtepu8_epi32(_mm_loadl_epi64(values.as_ptr().cast())) })
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Avx2Mask {
        let lanes = unsafe { _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128) };
        let set = unsafe { _mm256_and_si256(_mm256_set1_epi32(bits as i32), lanes) };
        Avx2Mask(unsafe { _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, lanes)) })
    }
}

impl Lanes<16> for Avx2 {
    type Float = Pair<Avx2Float>;
    type Int = Pair<Avx2Int>;
    type Mask = Pair<Avx2Mask>;

    #[inline(always)]
    fn splat(self, value: f32) -> Pair<Avx2Float> {
        let half = self.splat8(value);
        Pair(half, half)
    }
    #[inline(always)]
    fn load(self, values: &[f32; 16]) -> Pair<Avx2Float> {
        let [low, high] = halves(values);
        Pair(self.load(low), self.load(high))
    }
    #[inline(always)]
    fn splat_int(self, value: i32) -> Pair<Avx2Int> {
        let half = self.splat_int8(value);
        Pair(half, half)
    }
    #[inline(always)]
    fn load_int(self, values: &[i32; 16]) -> Pair<Avx2Int> {
        let [low, high] = halves(values);
        Pair(self.load_int(low), self.load_int(high))
    }
    #[inline(always)]
    fn load_bytes(self, values: &[u8; 16]) -> Pair<Avx2Int> {
        let [low, high] = halves(values);
        Pair(self.load_bytes(low), self.load_bytes(high))
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Pair<Avx2Mask> {
        Pair(self.mask8(bits), self.mask8(bits >> 8))
    }
}

impl Float<8> for Avx2Float {
    type Int = Avx2Int;
    type Mask = Avx2Mask;

    #[inline(always)]
    fn to_array(self) -> [f32; 8] {
        let mut values = [0.0; 8];
        unsafe { _mm256_storeu_ps(values.as_mut_ptr(), self.0) };
        values
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(unsafe { _mm256_min_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(unsafe { _mm256_max_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm256_sqrt_ps(self.0) })
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self(unsafe { _mm256_floor_ps(self.0) })
    }
    #[inline(always)]
    fn to_int(self) -> Avx2Int {
        Avx2Int(unsafe { _mm256_cvttps_epi32(self.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx2Mask {
        Avx2Mask(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Avx2Mask {
        Avx2Mask(unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Avx2Mask {
        Avx2Mask(unsafe { _mm256_cmp_ps::<_CMP_EQ_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn select(self, mask: Avx2Mask, other: Self) -> Self {
        Self(unsafe { _mm256_blendv_ps(other.0, self.0, mask.0) })
    }
    #[inline(always)]
    fn flip_sign(self, signs: Self) -> Self {
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_and_ps(_mm256_set1_ps(-0.0), signs.0)) })
    }
}

impl Int<8> for Avx2Int {
    type Float = Avx2Float;
    type Mask = Avx2Mask;

    #[inline(always)]
    fn to_array(self) -> [i32; 8] {
        let mut values = [0; 8];
        unsafe { _mm256_storeu_si256(values.as_mut_ptr().cast(), self.0) };
        values
    }
    #[inline(always)]
    fn to_float(self) -> Avx2Float {
        Avx2Float(unsafe { _mm256_cvtepi32_ps(self.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(unsafe { _mm256_min_epi32(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(unsafe { _mm256_max_epi32(self.0, other.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx2Mask {
        Avx2Mask(unsafe { _mm256_castsi256_ps(_mm256_cmpgt_epi32(other.0, self.0)) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Avx2Mask {
        Avx2Mask(unsafe { _mm256_castsi256_ps(_mm256_cmpeq_epi32(self.0, other.0)) })
    }
    #[inline(always)]
    fn select(self, mask: Avx2Mask, other: Self) -> Self {
        let chosen = unsafe { _mm256_blendv_ps(_mm256_castsi256_ps(other.0), _mm256_castsi256_ps(self.0), mask.0) };
        Self(unsafe { _mm256_castps_si256(chosen) })
    }
    #[inline(always)]
    fn bits_from(self) -> Self {
        Self(unsafe { _mm256_sllv_epi32(_mm256_set1_epi32(-1), self.0) })
    }
    #[inline(always)]
    fn without(self, other: Self) -> Self {
        Self(unsafe { _mm256_andnot_si256(other.0, self.0) })
    }
}

impl Mask for Avx2Mask {
    #[inline(always)]
    fn bits(self) -> u32 {
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }
}

/// An operator of two registers is one instruction.
macro_rules! operator {
    ($vector:ident, $trait:ident, $name:ident, $instruction:ident) => {
        impl $trait for $vector {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(unsafe { $instruction(self.0, other.0) })
            }
        }
    };
}

operator!(Avx2Float, Add, add, _mm256_add_ps);
operator!(Avx2Float, Sub, sub, _mm256_sub_ps);
operator!(Avx2Float, Mul, mul, _mm256_mul_ps);
operator!(Avx2Float, Div, div, _mm256_div_ps);
operator!(Avx2Int, Add, add, _mm256_add_epi32);
operator!(Avx2Int, Sub, sub, _mm256_sub_epi32);
operator!(Avx2Int, BitAnd, bitand, _mm256_and_si256);
operator!(Avx2Int, BitOr, bitor, _mm256_or_si256);
operator!(Avx2Mask, BitAnd, bitand, _mm256_and_ps);
operator!(Avx2Mask, BitOr, bitor, _mm256_or_ps);

impl Neg for Avx2Float {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_set1_ps(-0.0)) })
    }
}

impl Not for Avx2Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_castsi256_ps(_mm256_set1_epi32(-1))) })
    }
}
