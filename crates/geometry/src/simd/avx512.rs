//! AVX-512: sixteen lanes in a register, truth values in mask registers; eight lanes are those of AVX2.
//!
//! SAFETY, for every `unsafe` block of this file: the instructions need AVX-512F and DQ. An [`Avx512`] exists only
//! where [`Avx512::new`] found the features, and the vectors are made from one or from each other. Loads and stores go
//! through references to arrays of just the size that is moved, by instructions that need no alignment.

#![allow(unsafe_code, reason = "instructions that the compiler cannot know the processor to have")]

use std::{
    arch::x86_64::*,
    ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub},
};

use super::{Avx2, F8, Float, I8, Int, Kernel, Lanes, Level, M8, Mask, Simd};

/// The proof that the processor has AVX-512 (F, BW, DQ, VL), and AVX2.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

/// Sixteen floats in a register.
#[derive(Clone, Copy, Debug)]
pub struct Avx512Float(__m512);

/// Sixteen integers in a register.
#[derive(Clone, Copy, Debug)]
pub struct Avx512Int(__m512i);

/// Sixteen truth values, one bit each.
#[derive(Clone, Copy, Debug)]
pub struct Avx512Mask(__mmask16);

impl Avx512 {
    /// The proof, if there is one. Cost: a few loads; the processor is asked once.
    #[inline]
    pub(super) fn new() -> Option<Self> {
        let has_all = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl");
        (has_all && Avx2::new().is_some()).then_some(Self(()))
    }

    /// Runs the kernel with the features switched on.
    #[inline]
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,bmi1,bmi2,lzcnt,popcnt")]
        fn with_features<K: Kernel>(token: Avx512, kernel: K) -> K::Output {
            kernel.run(token)
        }
        // SAFETY: `self` is the proof that the processor has these features.
        unsafe { with_features(self, kernel) }
    }
}

impl Simd for Avx512 {
    const LEVEL: Level = Level::Avx512;
}

impl Lanes<8> for Avx512 {
    type Float = F8<Avx2>;
    type Int = I8<Avx2>;
    type Mask = M8<Avx2>;

    #[inline(always)]
    fn splat(self, value: f32) -> F8<Avx2> {
        Avx2::from(self).splat8(value)
    }
    #[inline(always)]
    fn load(self, values: &[f32; 8]) -> F8<Avx2> {
        Avx2::from(self).load(values)
    }
    #[inline(always)]
    fn splat_int(self, value: i32) -> I8<Avx2> {
        Avx2::from(self).splat_int8(value)
    }
    #[inline(always)]
    fn load_int(self, values: &[i32; 8]) -> I8<Avx2> {
        Avx2::from(self).load_int(values)
    }
    #[inline(always)]
    fn load_bytes(self, values: &[u8; 8]) -> I8<Avx2> {
        Avx2::from(self).load_bytes(values)
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> M8<Avx2> {
        Avx2::from(self).mask8(bits)
    }
}

impl Lanes<16> for Avx512 {
    type Float = Avx512Float;
    type Int = Avx512Int;
    type Mask = Avx512Mask;

    #[inline(always)]
    fn splat(self, value: f32) -> Avx512Float {
        Avx512Float(unsafe { _mm512_set1_ps(value) })
    }
    #[inline(always)]
    fn load(self, values: &[f32; 16]) -> Avx512Float {
        Avx512Float(unsafe { _mm512_loadu_ps(values.as_ptr()) })
    }
    #[inline(always)]
    fn splat_int(self, value: i32) -> Avx512Int {
        Avx512Int(unsafe { _mm512_set1_epi32(value) })
    }
    #[inline(always)]
    fn load_int(self, values: &[i32; 16]) -> Avx512Int {
        Avx512Int(unsafe { _mm512_loadu_si512(values.as_ptr().cast()) })
    }
    #[inline(always)]
    fn load_bytes(self, values: &[u8; 16]) -> Avx512Int {
        Avx512Int(unsafe { _mm512_cvtepu8_epi32(_mm_loadu_si128(values.as_ptr().cast())) })
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Avx512Mask {
        Avx512Mask(bits as u16)
    }
}

impl Float<16> for Avx512Float {
    type Int = Avx512Int;
    type Mask = Avx512Mask;

    #[inline(always)]
    fn to_array(self) -> [f32; 16] {
        let mut values = [0.0; 16];
        unsafe { _mm512_storeu_ps(values.as_mut_ptr(), self.0) };
        values
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(unsafe { _mm512_min_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(unsafe { _mm512_max_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm512_andnot_ps(_mm512_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm512_sqrt_ps(self.0) })
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self(unsafe { _mm512_roundscale_ps::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0) })
    }
    #[inline(always)]
    fn to_int(self) -> Avx512Int {
        Avx512Int(unsafe { _mm512_cvttps_epi32(self.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx512Mask {
        Avx512Mask(unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Avx512Mask {
        Avx512Mask(unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Avx512Mask {
        Avx512Mask(unsafe { _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn select(self, mask: Avx512Mask, other: Self) -> Self {
        Self(unsafe { _mm512_mask_blend_ps(mask.0, other.0, self.0) })
    }
    #[inline(always)]
    fn flip_sign(self, signs: Self) -> Self {
        Self(unsafe { _mm512_xor_ps(self.0, _mm512_and_ps(_mm512_set1_ps(-0.0), signs.0)) })
    }
}

impl Int<16> for Avx512Int {
    type Float = Avx512Float;
    type Mask = Avx512Mask;

    #[inline(always)]
    fn to_array(self) -> [i32; 16] {
        let mut values = [0; 16];
        unsafe { _mm512_storeu_si512(values.as_mut_ptr().cast(), self.0) };
        values
    }
    #[inline(always)]
    fn to_float(self) -> Avx512Float {
        Avx512Float(unsafe { _mm512_cvtepi32_ps(self.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(unsafe { _mm512_min_epi32(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(unsafe { _mm512_max_epi32(self.0, other.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx512Mask {
        Avx512Mask(unsafe { _mm512_cmplt_epi32_mask(self.0, other.0) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Avx512Mask {
        Avx512Mask(unsafe { _mm512_cmpeq_epi32_mask(self.0, other.0) })
    }
    #[inline(always)]
    fn select(self, mask: Avx512Mask, other: Self) -> Self {
        Self(unsafe { _mm512_mask_blend_epi32(mask.0, other.0, self.0) })
    }
    #[inline(always)]
    fn bits_from(self) -> Self {
        Self(unsafe { _mm512_sllv_epi32(_mm512_set1_epi32(-1), self.0) })
    }
    #[inline(always)]
    fn without(self, other: Self) -> Self {
        Self(unsafe { _mm512_andnot_si512(other.0, self.0) })
    }
}

impl Mask for Avx512Mask {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
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

operator!(Avx512Float, Add, add, _mm512_add_ps);
operator!(Avx512Float, Sub, sub, _mm512_sub_ps);
operator!(Avx512Float, Mul, mul, _mm512_mul_ps);
operator!(Avx512Float, Div, div, _mm512_div_ps);
operator!(Avx512Int, Add, add, _mm512_add_epi32);
operator!(Avx512Int, Sub, sub, _mm512_sub_epi32);
operator!(Avx512Int, BitAnd, bitand, _mm512_and_si512);
operator!(Avx512Int, BitOr, bitor, _mm512_or_si512);

impl Neg for Avx512Float {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(unsafe { _mm512_xor_ps(self.0, _mm512_set1_ps(-0.0)) })
    }
}

impl BitAnd for Avx512Mask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Avx512Mask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for Avx512Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}
