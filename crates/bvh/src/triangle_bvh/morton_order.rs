//! Points along Morton's curve (Morton, "A computer oriented geodetic data base", IBM 1966), so that neighbours in the
//! list are neighbours in space: 256 cells on each axis of the points' box, by a radix sort of two passes. O(n); points of
//! one cell keep their order.

use glam::DVec3;
use umbriel_geometry::Aabb;

/// Bits on an axis.
const BITS: u32 = 8;
/// Bits of a pass.
const DIGIT: u32 = 12;
const BUCKETS: usize = 1 << DIGIT;

/// The points' indices in that order.
///
/// There must be at most 2^32 points.
pub(super) fn morton_order(points: &[DVec3]) -> Vec<u32> {
    let bounds = Aabb::of(points.iter().copied());
    let cells = f64::from(1u32 << BITS) * (1.0 - f64::EPSILON);
    let factor = bounds.size().map(|size| if size > 0.0 { cells / size } else { 0.0 });
    let code = |point: &DVec3| {
        let cell = (*point - bounds.min) * factor;
        spread(cell.x as u32) | spread(cell.y as u32) << 1 | spread(cell.z as u32) << 2
    };
    let (mut low, mut high) = (vec![0u32; BUCKETS], vec![0u32; BUCKETS]);
    let codes: Vec<u32> = points.iter().map(code).collect();
    for &code in &codes {
        low[low_digit(code)] += 1;
        high[high_digit(code)] += 1;
    }
    starts(&mut low);
    starts(&mut high);
    let mut by_low = vec![(0u32, 0u32); points.len()];
    for (index, &code) in codes.iter().enumerate() {
        by_low[place(&mut low, low_digit(code))] = (code, index as u32);
    }
    let mut order = codes;
    for (code, index) in by_low {
        order[place(&mut high, high_digit(code))] = index;
    }
    order
}

fn low_digit(code: u32) -> usize {
    code as usize % BUCKETS
}

fn high_digit(code: u32) -> usize {
    (code >> DIGIT) as usize % BUCKETS
}

/// From how many there are to where they begin.
fn starts(counts: &mut [u32]) {
    let mut sum = 0;
    for count in counts {
        (*count, sum) = (sum, sum + *count);
    }
}

/// The next place of a bucket.
fn place(starts: &mut [u32], bucket: usize) -> usize {
    let place = starts[bucket];
    starts[bucket] += 1;
    place as usize
}

/// The bits of an 8-bit number, two zeros between them. What is larger counts as the largest.
fn spread(number: u32) -> u32 {
    let number = number.min((1 << BITS) - 1);
    let number = (number | number << 8) & 0x00f00f;
    let number = (number | number << 4) & 0x0c30c3;
    (number | number << 2) & 0x249249
}
