//! Vectors of 8 and 16 floats or integers, at the widest level that the processor has, with the same bits at all levels.
//!
//! A [`Kernel`] is written once against [`Simd`]; [`dispatch`] runs it at the best level ([`Level::best`]), with the
//! processor's features switched on for the whole kernel. Guarantee: every operation is one rounding of IEEE 754 or
//! exact, and none is fused with another, so a kernel gives the same bits at every level ([`dispatch_at`] lets tests
//! compare them); only the payloads of NaNs are left open. Cost: one indirect step a dispatch, so dispatch loops, not
//! single operations. What breaks the speed (never the result): a helper of a kernel that is not `#[inline(always)]`
//! is compiled without the features, and each of its operations becomes a call. That includes closures, above all those
//! handed to `array::map` and `from_fn`: use loops and functions where vectors are concerned.
//!
//! The values of [`Avx2`] and [`Avx512`] are proofs that the processor has the features: only the dispatch makes
//! them, after it has asked. Vectors are made from such a value or from other vectors, so safe code cannot reach an
//! instruction that the processor lacks.
//!
//! ```
//! use umbriel_geometry::simd::{Float, Kernel, Lanes, Mask, Simd, dispatch};
//!
//! /// How many of the numbers are greater than their neighbours to the left.
//! struct Rises<'a>(&'a [f32]);
//!
//! impl Kernel for Rises<'_> {
//!     type Output = u32;
//!     #[inline(always)]
//!     fn run<S: Simd>(self, simd: S) -> u32 {
//!         let (left, right) = (self.0.as_chunks::<8>().0, self.0[1..].as_chunks::<8>().0);
//!         let pairs = left.iter().zip(right);
//!         pairs.map(|(left, right)| simd.load(right).gt(simd.load(left)).count()).sum()
//!     }
//! }
//!
//! let numbers: Vec<f32> = (0..17).map(|n| (n % 4) as f32).collect();
//! assert_eq!(dispatch(Rises(&numbers)), 12);
//! ```

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod pair;
mod scalar;
#[cfg(test)]
mod tests;

use std::{
    fmt::Debug,
    ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub},
    sync::{
        OnceLock,
        atomic::{AtomicU8, Ordering},
    },
};

#[cfg(target_arch = "x86_64")]
pub use {avx2::Avx2, avx512::Avx512};

pub use {
    pair::Pair,
    scalar::{Scalar, ScalarFloat, ScalarInt, ScalarMask},
};

/// The widest level that may be used, as its place in [`Level::ALL`].
static LIMIT: AtomicU8 = AtomicU8::new(2);

/// A family of instructions, from narrow to wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Plain loops over arrays, on every processor.
    Scalar,
    /// 8 lanes a register.
    Avx2,
    /// 16 lanes a register, masks of their own.
    Avx512,
}

impl Level {
    /// All levels, narrow to wide.
    pub const ALL: [Self; 3] = [Self::Scalar, Self::Avx2, Self::Avx512];

    /// Whether this processor has the level.
    pub fn is_available(self) -> bool {
        match self {
            Self::Scalar => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => Avx2::new().is_some(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => Avx512::new().is_some(),
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// The widest level that this processor has, but none above [`Level::limit`].
    pub fn best() -> Self {
        static WIDEST: OnceLock<Level> = OnceLock::new();
        let widest =
            *WIDEST.get_or_init(|| Self::ALL.into_iter().rfind(|level| level.is_available()).unwrap_or(Self::Scalar));
        Self::ALL[usize::from(LIMIT.load(Ordering::Relaxed))].min(widest)
    }

    /// From now on [`dispatch`] uses no level above this one in the whole process. The answers are the same: for tests
    /// that show it, and for measurements.
    pub fn limit(self) {
        LIMIT.store(self as u8, Ordering::Relaxed);
    }
}

/// Work to be done at some level.
pub trait Kernel {
    /// What comes out.
    type Output;

    /// Does the work. Mark it, and what it calls with vectors, `#[inline(always)]`; see the module's header.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Runs the kernel at the best level of this processor that [`Level::limit`] leaves. Cost: two loads and a jump.
#[inline]
pub fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    // The widest for each limit: asking the processor every time would cost more than small kernels do.
    static WIDEST: OnceLock<[Proof; Level::ALL.len()]> = OnceLock::new();
    let widest = WIDEST.get_or_init(|| Level::ALL.map(Proof::at));
    widest[usize::from(LIMIT.load(Ordering::Relaxed))].run(kernel)
}

/// Runs the kernel at this level, or at the widest below it that the processor has. The result is the same.
pub fn dispatch_at<K: Kernel>(level: Level, kernel: K) -> K::Output {
    Proof::at(level).run(kernel)
}

/// That the processor has a level.
#[derive(Clone, Copy)]
enum Proof {
    Scalar(Scalar),
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

impl Proof {
    /// Of the widest level that the processor has, up to `level`.
    fn at(level: Level) -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if level == Level::Avx512
                && let Some(token) = Avx512::new()
            {
                return Self::Avx512(token);
            }
            if level >= Level::Avx2
                && let Some(token) = Avx2::new()
            {
                return Self::Avx2(token);
            }
        }
        let _ = level;
        Self::Scalar(Scalar)
    }

    #[inline]
    fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            Self::Scalar(token) => kernel.run(token),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(token) => token.run(kernel),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(token) => token.run(kernel),
        }
    }
}

/// A level: makes vectors of 8 and of 16 lanes. The methods here are those of [`Lanes`] with the width in the name,
/// where the arguments do not tell it.
pub trait Simd: Lanes<8> + Lanes<16> {
    /// Which one.
    const LEVEL: Level;

    /// One float in eight lanes.
    #[inline(always)]
    fn splat8(self, value: f32) -> F8<Self> {
        Lanes::<8>::splat(self, value)
    }
    /// One float in sixteen lanes.
    #[inline(always)]
    fn splat16(self, value: f32) -> F16<Self> {
        Lanes::<16>::splat(self, value)
    }
    /// One integer in eight lanes.
    #[inline(always)]
    fn splat_int8(self, value: i32) -> I8<Self> {
        Lanes::<8>::splat_int(self, value)
    }
    /// One integer in sixteen lanes.
    #[inline(always)]
    fn splat_int16(self, value: i32) -> I16<Self> {
        Lanes::<16>::splat_int(self, value)
    }
    /// Eight truth values from the low bits.
    #[inline(always)]
    fn mask8(self, bits: u32) -> M8<Self> {
        Lanes::<8>::mask(self, bits)
    }
    /// Sixteen truth values from the low bits.
    #[inline(always)]
    fn mask16(self, bits: u32) -> M16<Self> {
        Lanes::<16>::mask(self, bits)
    }
}

/// Eight floats at level `S`.
pub type F8<S> = <S as Lanes<8>>::Float;
/// Sixteen floats at level `S`.
pub type F16<S> = <S as Lanes<16>>::Float;
/// Eight integers at level `S`.
pub type I8<S> = <S as Lanes<8>>::Int;
/// Sixteen integers at level `S`.
pub type I16<S> = <S as Lanes<16>>::Int;
/// Eight truth values at level `S`.
pub type M8<S> = <S as Lanes<8>>::Mask;
/// Sixteen truth values at level `S`.
pub type M16<S> = <S as Lanes<16>>::Mask;

/// Makes vectors of `N` lanes.
pub trait Lanes<const N: usize>: Copy + Debug + Send + Sync + 'static {
    /// `N` numbers of type `f32`.
    type Float: Float<N, Int = Self::Int, Mask = Self::Mask>;
    /// `N` numbers of type `i32`.
    type Int: Int<N, Float = Self::Float, Mask = Self::Mask>;
    /// `N` truth values.
    type Mask: Mask;

    /// One float in all lanes.
    fn splat(self, value: f32) -> Self::Float;
    /// The floats of an array, lane by lane.
    fn load(self, values: &[f32; N]) -> Self::Float;
    /// One integer in all lanes.
    fn splat_int(self, value: i32) -> Self::Int;
    /// The integers of an array, lane by lane.
    fn load_int(self, values: &[i32; N]) -> Self::Int;
    /// Bytes as integers, lane by lane.
    fn load_bytes(self, values: &[u8; N]) -> Self::Int;
    /// Lane i is true where bit i is set; higher bits are not looked at.
    fn mask(self, bits: u32) -> Self::Mask;
}

/// `N` numbers of type `f32`. Every operation rounds once, to nearest, ties to even.
pub trait Float<const N: usize>:
    Copy + Debug + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The integers of this width.
    type Int;
    /// The truth values of this width.
    type Mask: Mask;

    /// The lanes as an array.
    fn to_array(self) -> [f32; N];
    /// The lesser of both: `self < other`, else `other`. So `other` where one is NaN, or both are zero.
    fn min(self, other: Self) -> Self;
    /// The greater of both: `self` where `self > other`, else `other`. So `other` where one is NaN, or both are zero.
    fn max(self, other: Self) -> Self;
    /// Without the sign.
    fn abs(self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The greatest whole number not above.
    fn floor(self) -> Self;
    /// Rounded towards zero; `i32::MIN` for what no `i32` can hold, NaN included.
    fn to_int(self) -> Self::Int;
    /// Less, lane by lane; false for NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// Less or equal; false for NaN.
    fn le(self, other: Self) -> Self::Mask;
    /// Equal; false for NaN, true for zeros of either sign.
    fn eq(self, other: Self) -> Self::Mask;
    /// Greater; false for NaN.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// Greater or equal; false for NaN.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// Where `mask` is true the lane of `self`, else that of `other`.
    fn select(self, mask: Self::Mask, other: Self) -> Self;
    /// `self` with the signs of `signs` flipped in: the exclusive or of the sign bits.
    fn flip_sign(self, signs: Self) -> Self;
}

/// `N` numbers of type `i32`; sums and differences wrap, `&` and `|` are those of the bits.
pub trait Int<const N: usize>:
    Copy + Debug + Add<Output = Self> + Sub<Output = Self> + BitAnd<Output = Self> + BitOr<Output = Self>
{
    /// The floats of this width.
    type Float;
    /// The truth values of this width.
    type Mask: Mask;

    /// The lanes as an array.
    fn to_array(self) -> [i32; N];
    /// The nearest floats, ties to even; exact below 2^24 in size.
    fn to_float(self) -> Self::Float;
    /// The lesser of both.
    fn min(self, other: Self) -> Self;
    /// The greater of both.
    fn max(self, other: Self) -> Self;
    /// Less, lane by lane.
    fn lt(self, other: Self) -> Self::Mask;
    /// Equal, lane by lane.
    fn eq(self, other: Self) -> Self::Mask;
    /// Where `mask` is true the lane of `self`, else that of `other`.
    fn select(self, mask: Self::Mask, other: Self) -> Self;
    /// Bits number `self` and higher are set; none for numbers that are not in 0..32.
    fn bits_from(self) -> Self;
    /// The bits of `self` that `other` has not.
    fn without(self, other: Self) -> Self;
}

/// One truth value a lane.
pub trait Mask: Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Bit i is that of lane i; bits beyond the lanes are zero.
    fn bits(self) -> u32;

    /// Whether any lane is true.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }

    /// How many lanes are true.
    #[inline(always)]
    fn count(self) -> u32 {
        self.bits().count_ones()
    }
}
