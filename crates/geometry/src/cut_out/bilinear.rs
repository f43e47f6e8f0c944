//! Least and greatest alpha of a picture read between its texels, over a small box of texture coordinates.
//!
//! Between the middles of four texels alpha is bilinear, so over a part of that square its ends are at the part's corners. The texels themselves
//! only say what it is over whole squares: near the cutoff they would leave a band undecided, half a texel wide, however small the box.
//! Guarantee: bounds are wider by what plain floats may be off (NUMERICS.md, "Cut-outs"). Cost: some 20 ns for each of at most [`MOST_SQUARES`] squares.

use super::{AlphaMap, CutOut};
use crate::approx::UNIT_ROUNDOFF;

/// What a mean of four texels may be off, and more: six roundings one after another of numbers up to 2^16.
const MEAN_ERROR: f64 = UNIT_ROUNDOFF * (1 << 19) as f64;

/// Squares that a box may meet; over more of them the texels' own ends are about as good.
const MOST_SQUARES: i64 = 9;

impl CutOut {
    /// Bounds of the map's alpha, 0 to [`AlphaMap::ONE`], where columns and rows of texture coordinates lie in two ranges, with linear filtering; `None` over too many squares.
    pub(super) fn bilinear_range(&self, map: &AlphaMap, ranges: [[f64; 2]; 2]) -> Option<[f64; 2]> {
        let [columns, rows] = [0, 1].map(|axis| self.texels(ranges[axis], map.size()[axis]));
        let squares = |[first, last]: [i64; 2]| last - first;
        if squares(columns).saturating_mul(squares(rows)) > MOST_SQUARES {
            return None;
        }
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for column in columns[0]..columns[1] {
            let across = part(ranges[0], map.size()[0], column);
            for row in rows[0]..rows[1] {
                let along = part(ranges[1], map.size()[1], row);
                let texels = self.square(map, [column, row]);
                for [x, y] in [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[i, j]| [across[i], along[j]]) {
                    let alpha = between([between(texels[0], x), between(texels[1], x)], y);
                    range = [range[0].min(alpha), range[1].max(alpha)];
                }
            }
        }
        Some([range[0] - MEAN_ERROR, range[1] + MEAN_ERROR])
    }
}

/// What a range of coordinates covers of the square from the middle of a texel of `count` to that of the next one, 0 to 1, rounded outward.
fn part([low, high]: [f64; 2], count: u32, texel: i64) -> [f64; 2] {
    let past = |place: f64, outward: f64| {
        let product = place * f64::from(count);
        let error = (product.abs() + 1.0) * (4.0 * UNIT_ROUNDOFF);
        (product - (texel as f64 + 0.5) + outward * error).clamp(0.0, 1.0)
    };
    [past(low, -1.0), past(high, 1.0)]
}

fn between([a, b]: [f64; 2], share: f64) -> f64 {
    a + (b - a) * share
}
