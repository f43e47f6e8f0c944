//! The lit share of undecided cells: the winding at 16 points of each.
//!
//! It is that at the cell's middle, changed by every segment that the straight way to the point crosses; only segments that
//! touch the cell can be. In f32 from the middle of the cell; an estimate, not a proof. About 20 ns for a segment and cell.

use umbriel_octree::Quadrant;

use super::{
    chain::Segment,
    tile::{TILE, Tile},
};
use crate::fine::pattern;

/// Points a cell.
const POINTS: usize = 16;

/// An undecided cell.
struct OpenCell {
    /// From the cell's middle, in cells.
    x: [f32; POINTS],
    y: [f32; POINTS],
    winding: [i32; POINTS],
}

/// The undecided cells of a tile, in the order of rows and columns.
pub(crate) struct Estimate {
    /// How many cells come before each row.
    before: [usize; TILE],
    cells: Vec<OpenCell>,
}

impl Estimate {
    /// For the cells `open` of a tile, of which `halves` keep their lower half only; `carry` is the winding at the left
    /// of the tile's rows, `level` that of the cells.
    pub(crate) fn new(tile: &Tile, open: &[u64; TILE], halves: &[u64; TILE], carry: &[i32; TILE], level: u8) -> Self {
        let mut estimate = Self { before: [0; TILE], cells: Vec::new() };
        for (row, &bits) in open.iter().enumerate() {
            estimate.before[row] = estimate.cells.len();
            if bits == 0 {
                continue;
            }
            let windings = tile.windings(row, carry[row]);
            for column in (0..TILE).filter(|column| bits >> column & 1 == 1) {
                let place = [tile.place.column + column as i64, tile.place.row + row as i64].map(|k| k as u32);
                if let Some(cell) = Quadrant::at(level, place) {
                    estimate.cells.push(OpenCell::new(cell, halves[row] >> column & 1 == 1, windings[column]));
                }
            }
        }
        estimate
    }

    /// Takes a segment's crossings into account.
    pub(crate) fn add(&mut self, tile: &Tile, open: &[u64; TILE], segment: &Segment) {
        let net = segment.net;
        tile.for_each_touched(segment, open, |[row, column], middle, is_left| {
            let place = self.before[row] + (open[row] & ((1u64 << column) - 1)).count_ones() as usize;
            let local = |point: [f64; 2]| [0, 1].map(|k| (point[k] - middle[k]) as f32);
            self.cells[place].cross(local(segment.from), local(segment.to), if is_left { -net } else { net });
        });
    }

    /// How many of the points of each cell are lit, in the order of rows and columns.
    pub(crate) fn lit_points(&self) -> impl Iterator<Item = u64> + '_ {
        self.cells.iter().map(|cell| cell.winding.iter().filter(|&&winding| winding <= 0).count() as u64)
    }
}

impl OpenCell {
    fn new(cell: Quadrant, is_half: bool, winding: i32) -> Self {
        let mut open = Self { x: [0.0; POINTS], y: [0.0; POINTS], winding: [winding; POINTS] };
        for (k, point) in pattern::points(cell).enumerate() {
            // On a half cell, points beyond the long side are turned back into it.
            let [s, t] = if is_half && point[0] + point[1] > 1.0 { point.map(|c| 1.0 - c) } else { point };
            (open.x[k], open.y[k]) = ((s - 0.5) as f32, (t - 0.5) as f32);
        }
        open
    }

    /// Changes the windings where the segment from a to b comes between the middle and the point. The change is negative
    /// where the middle is on its left.
    fn cross(&mut self, a: [f32; 2], b: [f32; 2], change: i32) {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let left = dy * a[0] - dx * a[1];
        let is_left = change < 0;
        for k in 0..POINTS {
            let (x, y) = (self.x[k], self.y[k]);
            let is_other_side = is_left != (left + dx * y - dy * x > 0.0);
            let is_between = (x * a[1] - y * a[0] > 0.0) != (x * b[1] - y * b[0] > 0.0);
            self.winding[k] += if is_other_side & is_between { change } else { 0 };
        }
    }
}
