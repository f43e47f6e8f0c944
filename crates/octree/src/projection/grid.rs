//! The square [−1, 1]² as rows of cells, and which of them a pack meets.
//!
//! *Nothing is missed.* A number u of the square is in the cell ⌊(u + 1)/2·n⌋, in floats a monotone function, and borders count as
//! the last cell inside. A pack is written from the cell of its least u (rounded down) to that of its greatest (rounded up), so
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

/// What is within a distance of a place, in 2^-32 of cells.
///
/// The cell of any of it, as [`cell_of`] has it, is among [`Around::cells`]: rounding moves a coordinate among at most 2^15 cells by less
/// than 2^-5 of these parts here and there, cutting off its fraction by less than one, and the distance is as much by less than two; it is taken 4 longer.
pub(super) struct Around {
    middle: [i64; 2],
    distance: i64,
    cells: u32,
}

impl Around {
    /// Of a place in the square or just outside.
    #[inline(always)]
    pub(super) fn new([u, v]: [f64; 2], distance: f64, cells: u32) -> Self {
        let half = f64::from(cells) * HALF;
        let middle = [(u * half + half) as i64, (v * half + half) as i64];
        Self { middle, distance: (distance * half) as i64 + 4, cells }
    }

    /// The first and the last cell on each axis.
    #[inline(always)]
    pub(super) fn cells(&self) -> [[u32; 2]; 2] {
        let Self { middle: [u, v], distance, cells } = *self;
        let cell = |part: i64| ((part >> 32).max(0) as u32).min(cells - 1);
        [[cell(u - distance), cell(u + distance)], [cell(v - distance), cell(v + distance)]]
    }
}

/// Parts of a cell, half.
const HALF: f64 = (1u64 << 31) as f64;

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

/// Finds the cells that packs meet; keeps room for rows between them.
#[derive(Default)]
pub(super) struct Finder {
    reaches: Vec<[f64; 2]>,
}

impl Finder {
    /// Calls `visit` with what the pack meets of each of some rows.
    pub(super) fn for_each_row(&mut self, pack: &Footprint, cells: u32, rows: Range<u32>, mut visit: impl FnMut(Span)) {
        let Some([_, reach]) = pack.reach() else { return };
        let met = cells_between(reach, cells);
        let rows = met.start.max(rows.start)..met.end.min(rows.end);
        if rows.is_empty() {
            return;
        }
        pack.columns(cells, rows.clone(), &mut self.reaches);
        for (row, &reach) in rows.zip(&self.reaches) {
            if reach[0] <= reach[1] {
                visit(Span { row, columns: cells_between(reach, cells) });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{super::tests::Dice, *};

    #[test]
    fn what_is_around_a_place_has_the_cells_of_all_of_it() {
        let mut dice = Dice(7);
        let mut unit = || dice.unit();
        let (mut tight, mut tried) = (0, 0);
        for cells in [1u32, 8, 1 << 9, 1 << 15] {
            for n in 0..20_000u32 {
                // Anywhere, and within some floats of a border.
                let border = f64::from(n % (cells + 1)) / f64::from(cells) * 2.0 - 1.0;
                let place = if n % 2 == 0 { 2.0 * unit() - 1.0 } else { border + (unit() - 0.5) * 4.0 * f64::EPSILON };
                let distance = [0.0, f64::EPSILON, 2.0 * f64::from(f32::EPSILON), 0.01][(n / 2 % 4) as usize] * unit();
                let [[first, last], _] = Around::new([place, 0.0], distance, cells).cells();
                for near in [place - distance, place, place + distance] {
                    let cell = cell_of(near, cells).min(cells - 1);
                    assert!((first..=last).contains(&cell), "{near} within {distance} of {place}, {cells} cells");
                }
                (tight, tried) = (tight + u32::from(first == last), tried + 1);
            }
        }
        assert!(2 * tight > tried, "{tight} of {tried} places are in one cell");
    }
}
