//! The 16 points of an estimate: a fixed low-discrepancy pattern, shifted by a hash of the cell's code.
//!
//! The pattern is the additive recurrence with the plastic number ρ (ρ³ = ρ + 1): steps 1/ρ and 1/ρ² modulo one
//! (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018), in 24-bit fixed point, so every point is
//! an exact dyadic.

use umbriel_octree::Quadrant;

/// How many points an estimate looks at.
pub(crate) const POINTS: usize = 16;

const STEP: [u32; 2] = [12_664_746, 9_560_334];
const BITS: u32 = 24;

/// Points in the unit square, the same for the same code.
pub(crate) fn points(cell: Quadrant) -> impl Iterator<Item = [f64; 2]> {
    let seed = mix(cell.bits()) ^ mix(!u64::from(cell.level()));
    let start = [seed as u32, (seed >> 32) as u32];
    (0..POINTS as u32).map(move |k| {
        std::array::from_fn(|axis| {
            let place = start[axis].wrapping_add(STEP[axis].wrapping_mul(k)) & ((1 << BITS) - 1);
            (f64::from(place) + 0.5) / f64::from(1u32 << BITS)
        })
    })
}

/// A bijective scramble of 64 bits (the finaliser of SplitMix64, Steele, Lea & Flood 2014).
fn mix(mut bits: u64) -> u64 {
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_points_spread_over_the_cell() {
        for code in 0..64 {
            let mut quarters = [0; 4];
            for [u, v] in points(Quadrant::from_bits(3, code).expect("a cell")) {
                quarters[usize::from(u >= 0.5) + 2 * usize::from(v >= 0.5)] += 1;
            }
            assert!(quarters.iter().all(|&count| (2..=6).contains(&count)), "{quarters:?}");
        }
    }
}
