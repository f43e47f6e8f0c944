//! Morton's curve (Morton, "A computer oriented geodetic data base", IBM 1966): neighbours on it are neighbours in space.
//!
//! Codes have 8 or 10 bits an axis; they are sorted by a radix sort, up to 12 bits a pass, O(n). What has the same code keeps
//! its order.

use glam::DVec3;
use umbriel_geometry::Aabb;

/// Bits of a pass, at most.
const DIGIT: u32 = 12;
const BUCKETS: usize = 1 << DIGIT;

/// Bits an axis for points: sixteen of a million on a surface share a cell.
const POINT_BITS: u32 = 8;

/// The indices of points along the curve through their box. There must be at most 2^32 points.
pub(super) fn morton_order(points: &[DVec3]) -> Vec<u32> {
    let bounds = Aabb::of(points.iter().copied());
    let cells = f64::from(1u32 << POINT_BITS);
    let factor = bounds.size().map(|size| if size > 0.0 { cells / size } else { 0.0 });
    let code = |point: &DVec3| {
        let cell = (*point - bounds.min) * factor;
        code([cell.x as u32, cell.y as u32, cell.z as u32], POINT_BITS)
    };
    let mut pairs: Vec<(u32, u32)> = points.iter().map(code).zip(0..).collect();
    sort(&mut pairs, &mut vec![(0, 0); points.len()], 3 * POINT_BITS);
    pairs.into_iter().map(|(_, index)| index).collect()
}

/// The code of a cell; `bits` are 10 at most, and greater coordinates count as the greatest.
#[inline(always)]
pub(super) fn code([x, y, z]: [u32; 3], bits: u32) -> u32 {
    let most = (1 << bits) - 1;
    spread(x.min(most)) | spread(y.min(most)) << 1 | spread(z.min(most)) << 2
}

/// The bits of a 10-bit number, two zeros between them.
#[inline(always)]
fn spread(number: u32) -> u32 {
    let number = (number | number << 16) & 0x0300_00ff;
    let number = (number | number << 8) & 0x0300_f00f;
    let number = (number | number << 4) & 0x030c_30c3;
    (number | number << 2) & 0x0924_9249
}

/// Puts codes, with what belongs to them, in rising order of their low `bits`. `other` is as long, and of no meaning.
pub(super) fn sort<'a>(mut pairs: &'a mut [(u32, u32)], mut other: &'a mut [(u32, u32)], bits: u32) {
    let mut ends = [0; BUCKETS];
    let passes = bits.div_ceil(DIGIT);
    let digit_bits = bits.div_ceil(passes.max(1));
    for pass in 0..passes {
        let shift = pass * digit_bits;
        let mask = (1 << digit_bits.min(bits - shift)) - 1;
        let ends = &mut ends[..=mask as usize];
        ends.fill(0);
        scatter(pairs, other, ends, |code| (code >> shift & mask) as usize);
        std::mem::swap(&mut pairs, &mut other);
    }
    if passes % 2 == 1 {
        other.copy_from_slice(pairs);
    }
}

/// Copies the pairs in rising order of their codes' digits. `ends` are zeros, and become the ends of the digits' ranges.
pub(super) fn scatter(pairs: &[(u32, u32)], sorted: &mut [(u32, u32)], ends: &mut [u32], digit: impl Fn(u32) -> usize) {
    pairs.iter().for_each(|&(code, _)| ends[digit(code)] += 1);
    let mut sum = 0;
    for count in ends.iter_mut() {
        (*count, sum) = (sum, sum + *count);
    }
    for &pair in pairs {
        let end = &mut ends[digit(pair.0)];
        sorted[*end as usize] = pair;
        *end += 1;
    }
}
