//! Which stored cell holds a point (u, v) of a face: binary search in a list sorted by face and Morton code.

use umbriel_octree::encode2;
use umbriel_shadow::{Cell, Verdict};

/// Depth of the grid on which cells are compared; cells finer than that cannot be told apart.
const DEPTH: u8 = 31;

/// The stored cells of one object, and what is known of each: its verdict under one light, or something else.
#[derive(Debug)]
pub(crate) struct CellMap<V = Verdict> {
    cells: Vec<Entry<V>>,
}

impl<V> Default for CellMap<V> {
    fn default() -> Self {
        Self { cells: Vec::new() }
    }
}

#[derive(Clone, Copy, Debug)]
struct Entry<V> {
    face: u32,
    corner: u8,
    level: u8,
    value: V,
    /// Morton code of the cell's first corner on the finest grid.
    code: u64,
}

impl CellMap {
    /// Cells with their verdicts.
    pub(crate) fn new(cells: &[Cell]) -> Self {
        Self::with(cells.iter().map(|cell| (*cell, cell.verdict)))
    }
}

impl<V: Copy> CellMap<V> {
    /// Cells must not overlap. O(n) for cells in Morton order, else O(n log n).
    pub(crate) fn with(cells: impl Iterator<Item = (Cell, V)>) -> Self {
        let entry = |(cell, value): (Cell, V)| {
            let shift = DEPTH.saturating_sub(cell.level);
            let code = encode2([cell.i << shift, cell.j << shift]);
            Entry { face: cell.face, corner: cell.corner, level: cell.level.min(DEPTH), value, code }
        };
        let mut cells: Vec<Entry<V>> = cells.map(entry).collect();
        cells.sort_by_key(|entry| (entry.face, entry.code));
        Self { cells }
    }

    /// What is known of the stored cell that holds (u, v), if one does. O(log n).
    pub(crate) fn at(&self, face: u32, u: f64, v: f64) -> Option<V> {
        let grid = f64::from(1u32 << DEPTH);
        // Casting saturates, and the far edge belongs to the last cell.
        let index = |t: f64| ((t * grid) as u32).min((1 << DEPTH) - 1);
        let first = self.cells.partition_point(|entry| entry.face < face);
        let [u, v] = match self.cells.get(first)?.corner {
            1 => [v, 1.0 - u - v],
            2 => [1.0 - u - v, u],
            _ => [u, v],
        };
        let code = encode2([index(u), index(v)]);
        let after = self.cells.partition_point(|entry| (entry.face, entry.code) <= (face, code));
        let entry = self.cells[..after].last().filter(|entry| entry.face == face)?;
        let covers = (code - entry.code) >> (2 * (DEPTH - entry.level)) == 0;
        covers.then_some(entry.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(face: u32, level: u8, i: u32, j: u32, verdict: Verdict) -> Cell {
        Cell { face, corner: 0, level, i, j, verdict }
    }

    #[test]
    fn points_find_their_cells() {
        use Verdict::{Lit, Shadowed, Undecided};
        let map = CellMap::new(&[
            cell(2, 0, 0, 0, Lit),
            cell(1, 1, 0, 0, Lit),
            cell(1, 1, 1, 0, Shadowed),
            cell(1, 2, 0, 2, Undecided),
            cell(1, 2, 1, 2, Lit),
            // Nothing is stored for the rest of the upper half.
        ]);
        for (face, u, v, expected) in [
            (1, 0.1, 0.1, Some(Lit)),
            (1, 0.75, 0.0, Some(Shadowed)),
            (1, 1.0, 0.25, Some(Shadowed)),
            (1, 0.1, 0.6, Some(Undecided)),
            (1, 0.3, 0.5, Some(Lit)),
            (1, 0.3, 0.8, None),
            (1, 0.9, 0.9, None),
            (2, 1.0, 1.0, Some(Lit)),
            (0, 0.5, 0.5, None),
            (3, 0.5, 0.5, None),
        ] {
            assert_eq!(map.at(face, u, v), expected, "face {face} at ({u}, {v})");
        }
    }
}
