use proptest::prelude::*;

use super::*;

/// Every operation of one width on the same lanes, as bits.
struct Everything<'a, const N: usize> {
    a: &'a [f32; N],
    b: &'a [f32; N],
    ints: &'a [i32; N],
    bytes: &'a [u8; N],
    bits: u32,
}

/// A number's bits, with all NaNs alike.
fn plain(value: f32) -> u32 {
    if value.is_nan() { f32::NAN.to_bits() } else { value.to_bits() }
}

impl<const N: usize> Everything<'_, N> {
    #[inline(always)]
    fn floats<S: Lanes<N>>(&self, simd: S) -> Vec<u32> {
        let (a, b, mask) = (simd.load(self.a), simd.load(self.b), simd.mask(self.bits));
        let ordered = [a.min(b), b.min(a), a.max(b), b.max(a)];
        let single = [a.abs(), a.sqrt(), a.floor(), -a, a.select(mask, b), a.flip_sign(b), simd.splat(self.a[0])];
        let all = [a + b, a - b, a * b, a / b, a + b * b].into_iter().chain(ordered).chain(single);
        all.flat_map(|vector| vector.to_array()).map(plain).collect()
    }

    #[inline(always)]
    fn integers<S: Lanes<N>>(&self, simd: S) -> Vec<u32> {
        let (a, b) = (simd.load_int(self.ints), simd.load_bytes(self.bytes));
        let (mask, whole) = (simd.mask(self.bits), simd.load(self.a).to_int());
        let all = [a, b, a + b, a - b, a.min(b), a.max(b), a.select(mask, b), simd.splat_int(self.ints[0]), whole];
        let small = b - simd.splat_int(3);
        let bits = [a & b, a | b, a.without(b), a.bits_from(), small.bits_from(), b.bits_from()];
        let floats = [a.to_float(), b.to_float()].into_iter().flat_map(Float::to_array).map(f32::to_bits);
        all.into_iter().chain(bits).flat_map(Int::to_array).map(|value| value as u32).chain(floats).collect()
    }

    #[inline(always)]
    fn masks<S: Lanes<N>>(&self, simd: S) -> Vec<u32> {
        let (a, b, mask) = (simd.load(self.a), simd.load(self.b), simd.mask(self.bits));
        let (i, j) = (simd.load_int(self.ints), simd.load_bytes(self.bytes));
        let floats = [a.lt(b), a.le(b), a.eq(b), a.gt(b), a.ge(b)];
        let joined = [mask, !mask, mask & a.lt(b), mask | a.lt(b), i.lt(j), j.lt(i), i.eq(j), i.eq(i)];
        let all = floats.into_iter().chain(joined);
        all.flat_map(|mask| [mask.bits(), mask.count(), u32::from(mask.any())]).collect()
    }
}

impl Kernel for &Everything<'_, 8> {
    type Output = [Vec<u32>; 3];
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        [self.floats(simd), self.integers(simd), self.masks(simd)]
    }
}

impl Kernel for &Everything<'_, 16> {
    type Output = [Vec<u32>; 3];
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        [self.floats(simd), self.integers(simd), self.masks(simd)]
    }
}

fn a_float() -> impl Strategy<Value = f32> {
    let special = [0.0, -0.0, 1.0, f32::MIN_POSITIVE, f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1e-45, 3e9];
    prop_oneof![prop::sample::select(special.to_vec()), -2.0..2.0f32, any::<u32>().prop_map(f32::from_bits)]
}

fn an_int() -> impl Strategy<Value = i32> {
    prop_oneof![0..256, any::<i32>(), Just(i32::MIN), Just(i32::MAX), Just((1 << 24) + 1)]
}

proptest! {
    #[test]
    fn all_levels_give_the_same_bits(
        a in proptest::array::uniform16(a_float()), b in proptest::array::uniform16(a_float()),
        ints in proptest::array::uniform16(an_int()), bytes in any::<[u8; 16]>(), bits in any::<u32>(),
    ) {
        let wide = Everything { a: &a, b: &b, ints: &ints, bytes: &bytes, bits };
        let [low_a, low_b] = [pair::halves(&a)[0], pair::halves(&b)[0]];
        let narrow = Everything { a: low_a, b: low_b, ints: pair::halves(&ints)[0], bytes: pair::halves(&bytes)[0], bits };
        for level in Level::ALL {
            prop_assert_eq!(dispatch_at(level, &wide), dispatch_at(Level::Scalar, &wide), "{:?}", level);
            prop_assert_eq!(dispatch_at(level, &narrow), dispatch_at(Level::Scalar, &narrow), "{:?}", level);
        }
    }
}

/// The level that a kernel runs at.
struct WhichLevel;

impl Kernel for WhichLevel {
    type Output = Level;
    fn run<S: Simd>(self, _: S) -> Level {
        S::LEVEL
    }
}

#[test]
fn a_kernel_runs_at_the_level_asked_for_or_at_the_next_below() {
    for level in Level::ALL {
        let expected = Level::ALL.into_iter().rfind(|other| *other <= level && other.is_available());
        assert_eq!(Some(dispatch_at(level, WhichLevel)), expected);
    }
    // No other test of this program asks for what `dispatch` chooses.
    for level in Level::ALL {
        level.limit();
        assert_eq!(dispatch(WhichLevel), Level::best());
        assert!(Level::best() <= level);
    }
}

#[test]
fn the_scalar_twin_does_what_the_traits_say() {
    let simd = Scalar;
    let a = simd.load(&[1.0, f32::NAN, -0.0, -2.5, 3e9, f32::INFINITY, 0.0, -7.0]);
    let b = simd.load(&[2.0, 1.0, 0.0, -2.5, 1.0, 1.0, f32::NAN, 7.0]);
    assert_eq!(a.lt(b).bits(), 0b1000_0001);
    assert_eq!(a.le(b).bits(), 0b1000_1101);
    assert_eq!(a.eq(b).bits(), 0b0000_1100);
    assert_eq!(a.min(b).to_array().map(plain), [1.0, 1.0, 0.0, -2.5, 1.0, 1.0, f32::NAN, -7.0].map(plain));
    assert_eq!(a.max(b).to_array().map(plain), [2.0, 1.0, 0.0, -2.5, 3e9, f32::INFINITY, f32::NAN, 7.0].map(plain));
    assert_eq!(a.to_int().to_array(), [1, i32::MIN, 0, -2, i32::MIN, i32::MIN, 0, -7]);
    assert_eq!(a.floor().to_array()[3], -3.0);
    assert_eq!(simd.mask8(u32::MAX).bits(), 0xff);
    assert_eq!(a.flip_sign(b).to_array()[7], -7.0);
    assert_eq!(b.flip_sign(a).to_array()[7], -7.0);
}
