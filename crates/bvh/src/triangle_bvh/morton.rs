//! Morton's curve (Morton, "A computer oriented geodetic data base", IBM 1966): neighbours on it are neighbours in space.
//!
//! Codes have 8 or 10 bits an axis; they are sorted by a radix sort, 12 bits a pass, O(n). What has the same code keeps
//! its order.

use glam::DVec3;
use umbriel_geometry::Aabb;

/// Bits of a pass.
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
    let sorted = sorted(points.iter().map(code).zip(0..).collect(), 3 * POINT_BITS);
    sorted.into_iter().map(|(_, index)| index).collect()
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

/// Codes of so many bits, with what belongs to them, in rising order.
pub(super) fn sorted(mut pairs: Vec<(u32, u32)>, bits: u32) -> Vec<(u32, u32)> {
    let mut other = vec![(0, 0); pairs.len()];
    for shift in (0..bits).step_by(DIGIT as usize) {
        let digit = |code: u32| (code >> shift) as usize % BUCKETS;
        let mut places = [0u32; BUCKETS];
        pairs.iter().for_each(|&(code, _)| places[digit(code)] += 1);
        let mut sum = 0;
        for count in &mut places {
            (*count, sum) = (sum, sum + *count);
        }
        for &pair in &pairs {
            let place = &mut places[digit(pair.0)];
            other[*place as usize] = pair;
            *place += 1;
        }
        std::mem::swap(&mut pairs, &mut other);
    }
    pairs
}
