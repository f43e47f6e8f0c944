//! A run of a row in the depth buffer: blocks of eight depths at a time.
//!
//! The nearness of a face is affine in the column, and columns are multiples of ½, so x₀ + k is exact and every lane computes what a loop with x + 1 would: the
//! same bits at every SIMD level; so does the least depth of a row. A block in which all depths are apart is stored as a whole; the others, and what is left of a run, go pixel by pixel.
//! Cost: a compare and two blends for eight pixels; runs shorter than a block are not dispatched.

use umbriel_geometry::simd::{Kernel, Simd, dispatch};

/// Depths of a block: what an AVX-512 register holds, two of AVX2.
const BLOCK: usize = 8;

/// A run of pixels that a face covers.
pub(super) struct Run<'a> {
    pub(super) face: u32,
    /// The face's nearness at the first pixel is start + slope·x, at the next start + slope·(x + 1).
    pub(super) start: f64,
    pub(super) slope: f64,
    pub(super) x: f64,
    /// Depths that differ by more are apart.
    pub(super) apart: f64,
    /// Depths and faces of the run's pixels.
    pub(super) nearness: &'a mut [f64],
    pub(super) pixels: &'a mut [u32],
    /// Takes the numbers in the run of pixels whose depths are not apart.
    pub(super) doubtful: &'a mut Vec<u32>,
}

impl Run<'_> {
    /// Draws the run; returns how many pixels were written.
    pub(super) fn draw(self) -> u64 {
        if self.pixels.len() < BLOCK { self.fill() } else { dispatch(self) }
    }

    #[inline(always)]
    fn fill(self) -> u64 {
        let Run { face, start, slope, x, apart, nearness, pixels, doubtful } = self;
        let mut written = 0;
        let (blocks, rest) = nearness.as_chunks_mut::<BLOCK>();
        let (faces, faces_of_rest) = pixels.as_chunks_mut::<BLOCK>();
        let mut first = x;
        let mut number = 0;
        for (held, shown) in blocks.iter_mut().zip(faces) {
            let mut values = [0.0; BLOCK];
            for (k, value) in values.iter_mut().enumerate() {
                *value = start + slope * (first + k as f64);
            }
            match fill_block(&values, apart, face, held, shown) {
                Some(count) => written += count,
                None => {
                    for ((k, value), pixel) in (number..).zip(values).zip(held.iter_mut().zip(shown)) {
                        written += fill_one(value, (apart, face), pixel, || doubtful.push(k));
                    }
                }
            }
            first += BLOCK as f64;
            number += BLOCK as u32;
        }
        for (k, (held, shown)) in (0u32..).zip(rest.iter_mut().zip(faces_of_rest)) {
            let value = start + slope * (first + f64::from(k));
            written += fill_one(value, (apart, face), (held, shown), || doubtful.push(number + k));
        }
        written
    }
}

impl Kernel for Run<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> u64 {
        self.fill()
    }
}

/// A block of pixels; `None`, with nothing changed, where some depths are not apart.
#[inline(always)]
fn fill_block(
    values: &[f64; BLOCK],
    apart: f64,
    face: u32,
    held: &mut [f64; BLOCK],
    shown: &mut [u32; BLOCK],
) -> Option<u64> {
    let mut is_settled = true;
    for (value, held) in values.iter().zip(held.iter()) {
        // A depth that is not known is not apart from any.
        let ahead = value - held;
        is_settled &= (ahead > apart) | (ahead < -apart);
    }
    if !is_settled {
        return None;
    }
    let mut written = 0;
    for (value, (held, shown)) in values.iter().zip(held.iter_mut().zip(shown)) {
        let wins = value - *held > apart;
        *held = if wins { *value } else { *held };
        *shown = if wins { face } else { *shown };
        written += u64::from(wins);
    }
    Some(written)
}

/// The least depth of a row; −∞ where one is not known.
pub(super) fn least(nearness: &[f64]) -> f64 {
    dispatch(Least { nearness })
}

struct Least<'a> {
    nearness: &'a [f64],
}

impl Kernel for Least<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> f64 {
        let known = |value: f64| if value.is_nan() { f64::NEG_INFINITY } else { value };
        let (blocks, rest) = self.nearness.as_chunks::<BLOCK>();
        let mut least = [f64::INFINITY; BLOCK];
        for block in blocks {
            for (least, &value) in least.iter_mut().zip(block) {
                let value = known(value);
                *least = if value < *least { value } else { *least };
            }
        }
        least.into_iter().chain(rest.iter().map(|&value| known(value))).fold(f64::INFINITY, f64::min)
    }
}

/// One pixel; returns whether it was written, as a number.
#[inline(always)]
fn fill_one(value: f64, (apart, face): (f64, u32), (held, shown): (&mut f64, &mut u32), doubt: impl FnOnce()) -> u64 {
    let ahead = value - *held;
    if ahead > apart {
        (*held, *shown) = (value, face);
        return 1;
    }
    if ahead.is_nan() || ahead >= -apart {
        doubt();
    }
    0
}

#[cfg(test)]
mod tests {
    use umbriel_geometry::simd::{Level, dispatch_at};

    use super::*;

    #[test]
    fn the_least_depth_of_a_row_is_minus_infinity_where_one_is_not_known() {
        for length in 0..40 {
            let row: Vec<f64> = (0..length).map(|k| 1.0 + f64::from((k * 7 + 3) % 13)).collect();
            let plain = row.iter().copied().fold(f64::INFINITY, f64::min);
            for level in Level::ALL {
                assert_eq!(dispatch_at(level, Least { nearness: &row }), plain);
                for unknown in 0..row.len() {
                    let mut row = row.clone();
                    row[unknown] = f64::NAN;
                    assert_eq!(dispatch_at(level, Least { nearness: &row }), f64::NEG_INFINITY);
                }
            }
        }
    }

    #[test]
    fn every_level_draws_what_single_pixels_would() {
        for case in 0..200_u32 {
            let length = (case % 41) as usize;
            let random = |k: usize| {
                f64::from((case * 97 + k as u32 * 31).wrapping_mul(2_654_435_761) >> 12) / f64::from(1 << 20)
            };
            let before: Vec<f64> = (0..length)
                .map(|k| match (random(k) * 16.0) as u32 {
                    0 => f64::NEG_INFINITY,
                    1 => f64::NAN,
                    2 => 0.5 + 0.01 * k as f64,
                    _ => random(k + 64) + 0.02 * k as f64 * f64::from(case % 3),
                })
                .collect();
            let (start, slope, x, apart) = (0.25 + 0.01 * 7.5, 0.01, 25.0 - 7.5, 1e-3);
            let plain = {
                let (mut nearness, mut pixels, mut doubtful, mut written) =
                    (before.clone(), vec![7; length], Vec::new(), 0);
                for k in 0..length {
                    let value = start + slope * (x + k as f64);
                    let ahead = value - nearness[k];
                    if ahead > apart {
                        (nearness[k], pixels[k]) = (value, 9);
                        written += 1;
                    } else if ahead.is_nan() || ahead >= -apart {
                        doubtful.push(k as u32);
                    }
                }
                (nearness.iter().map(|value| value.to_bits()).collect::<Vec<_>>(), pixels, doubtful, written)
            };
            for level in Level::ALL {
                let (mut nearness, mut pixels, mut doubtful) = (before.clone(), vec![7; length], Vec::new());
                let run = Run {
                    face: 9,
                    start,
                    slope,
                    x,
                    apart,
                    nearness: &mut nearness,
                    pixels: &mut pixels,
                    doubtful: &mut doubtful,
                };
                let written = dispatch_at(level, run);
                let bits = nearness.iter().map(|value| value.to_bits()).collect();
                assert_eq!((bits, pixels, doubtful, written), plain, "case {case}, {level:?}");
            }
        }
    }
}
