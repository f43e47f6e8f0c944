//! The square [−1, 1]² as rows of cells, and which of them a leaf meets.
//!
//! *Nothing is missed.* A number u of the square is in the cell ⌊(u + 1)/2·n⌋, in floats a monotone function, and borders count as
//! the last cell inside. A leaf is written from the cell of its least u (rounded down) to that of its greatest (rounded up), so
//! any u between has its cell among them; a ray is looked up from the cell of the least u that it may have to that of the
//! greatest. Rows are the same.

use std::ops::Range;

use super::footprint::Footprint;

/// The cell of a coordinate among `cells` in a row.
#[inline]
pub(super) fn cell_of(coordinate: f64, cells: u32) -> u32 {
    // Negative numbers, just outside, become zero.
    ((coordinate * 0.5 + 0.5) * f64::from(cells)) as u32
}

/// The cells from one coordinate to another.
#[inline]
pub(super) fn cells_between([low, high]: [f64; 2], cells: u32) -> Range<u32> {
    cell_of(low, cells).min(cells - 1)..cell_of(high, cells).min(cells - 1) + 1
}

/// The borders of a row of cells; the outermost rows hold the rim too. Exact, as the number of cells is a power of two.
#[inline]
pub(super) fn strip(row: u32, cells: u32) -> [f64; 2] {
    let width = 2.0 / f64::from(cells);
    let border = |row: u32| f64::from(row) * width - 1.0;
    let low = if row == 0 { -2.0 } else { border(row) };
    let high = if row + 1 == cells { 2.0 } else { border(row + 1) };
    // Rounding the coordinate of a cell may carry a number over the border below it.
    [low - f64::EPSILON, high + f64::EPSILON]
}

/// A part of a row of cells.
#[derive(Clone, Debug)]
pub(super) struct Span {
    pub(super) row: u32,
    pub(super) columns: Range<u32>,
}

/// Finds the cells that leaves meet; keeps room for rows between them.
#[derive(Default)]
pub(super) struct Finder {
    reaches: Vec<[f64; 2]>,
}

impl Finder {
    /// Calls `visit` with what the leaf meets of each of some rows.
    pub(super) fn for_each_row(&mut self, leaf: &Footprint, cells: u32, rows: Range<u32>, mut visit: impl FnMut(Span)) {
        let Some([_, reach]) = leaf.reach() else { return };
        let met = cells_between(reach, cells);
        let rows = met.start.max(rows.start)..met.end.min(rows.end);
        if rows.is_empty() {
            return;
        }
        leaf.columns(cells, rows.clone(), &mut self.reaches);
        for (row, &reach) in rows.zip(&self.reaches) {
            if reach[0] <= reach[1] {
                visit(Span { row, columns: cells_between(reach, cells) });
            }
        }
    }
}
