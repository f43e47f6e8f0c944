//! In which order a tile takes its pieces: eight that follow each other make a group, so they should lie together.
//!
//! Triangles of like size come together, then those of one facing, then along a Morton curve; by counting, without a comparison. Cost: some nanoseconds a piece.

use umbriel_geometry::simd::{Kernel, Simd, dispatch};

use crate::loose::{group::whole, listed::Window, placed::Placed};

/// The numbers of the pieces in that order.
pub(super) fn in_order(placed: &[&Placed], window: &Window) -> Vec<u32> {
    let place_bits = place_bits(placed.len());
    let keys = dispatch(Keys { placed, window, place_bits });
    let mut next = vec![0u32; 6 << (2 * place_bits)];
    keys.iter().for_each(|&key| next[key as usize] += 1);
    let mut count = 0;
    for number in &mut next {
        (*number, count) = (count, count + *number);
    }
    let mut pieces = vec![0; placed.len()];
    for (placed, &key) in placed.iter().zip(&keys) {
        let next = &mut next[key as usize];
        pieces[*next as usize] = placed.piece;
        *next += 1;
    }
    pieces
}

/// Places along a side that keys tell apart, as a power of two: about as many in all as there are pieces.
fn place_bits(pieces: usize) -> u32 {
    (pieces.max(1).ilog2() / 2).clamp(4, 8)
}

/// Finds the keys: three sizes, two facings, and the places.
struct Keys<'a> {
    placed: &'a [&'a Placed],
    window: &'a Window<'a>,
    place_bits: u32,
}

impl Kernel for Keys<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Vec<u32> {
        let Self { placed, window, place_bits } = self;
        let mut keys = Vec::with_capacity(placed.len());
        for placed in placed.chunks(8) {
            let (mut bounds, mut reversed, mut found) = ([[0.0; 8]; 4], [0; 8], [0; 8]);
            for (lane, placed) in placed.iter().enumerate() {
                (0..4).for_each(|k| bounds[k][lane] = placed.bounds[k]);
                reversed[lane] = u32::from(placed.is_reversed);
            }
            let [u0, v0, u1, v1] = &bounds;
            for lane in 0..8 {
                let u = [window.along(u0[lane], 0), window.along(u1[lane], 0)];
                let v = [window.along(v0[lane], 1), window.along(v1[lane], 1)];
                found[lane] = key(u, v, reversed[lane], window.cells, place_bits);
            }
            keys.extend_from_slice(&found[..placed.len()]);
        }
        keys
    }
}

/// The key of a piece that reaches so far along u and v; `cells` lie over half the tile.
#[inline(always)]
fn key([u0, u1]: [f32; 2], [v0, v1]: [f32; 2], reversed: u32, cells: f32, place_bits: u32) -> u32 {
    let (u0, v0, u1, v1) = (within(u0), within(v0), within(u1), within(v1));
    let (wide, high) = (u1 - u0, v1 - v0);
    let longer = if wide > high { wide } else { high };
    let extent = longer * cells;
    let class = u32::from(extent >= 2.0) + u32::from(extent >= 6.0);
    let last = ((1u32 << place_bits) - 1) as f32;
    let place = |low: f32, high: f32| whole(((low + high) * 0.25 + 0.5) * last);
    let morton = spread_bits(place(u0, u1)) | spread_bits(place(v0, v1)) << 1;
    (class << 1 | reversed) << (2 * place_bits) | morton
}

/// The nearest place of the tile.
#[inline(always)]
fn within(bound: f32) -> f32 {
    let bound = if bound > -1.0 { bound } else { -1.0 };
    if bound < 1.0 { bound } else { 1.0 }
}

/// Eight bits with gaps between them.
#[inline(always)]
fn spread_bits(x: u32) -> u32 {
    let x = (x | x << 4) & 0x0f0f;
    let x = (x | x << 2) & 0x3333;
    (x | x << 1) & 0x5555
}
