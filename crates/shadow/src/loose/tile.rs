//! One tile of a view's plane: groups of eight triangles that lie together, and square cells with the groups over them,
//! nearest to the light first.
//!
//! Cost: some tens of nanoseconds a triangle. Cells are about the size of the tile's triangles; they hold numbers of groups only, so
//! a triangle is stored once a tile. A cell that one triangle covers as a whole needs nothing that lies farther: what is
//! behind that triangle is in its shadow.

use rayon::prelude::*;
use umbriel_geometry::simd::{Kernel, Simd, dispatch};

use crate::loose::{
    group::{Extent, Group, Over, whole},
    listed::Listed,
    surface::{self, Share},
};

/// Cells hold what meets them when they are this much wider on each side, units of half a cell. So a point within
/// [`PLACE_LIMIT`] beside its cell needs no other cell.
const WIDENED: f32 = 1.0 / 64.0;
/// Points that are off by more, in units of half a cell, cannot be told by cells.
pub(super) const PLACE_LIMIT: f32 = 1.0 / 128.0;
/// Points whose nearness is off by more, in parts of it (a sun's: of the scene), cannot be told by what covers a cell.
pub(super) const HEIGHT_LIMIT: f32 = 1.0 / (1u32 << 17) as f32;
/// At most so many cells along a tile's side.
const MAX_SIDE: f64 = 256.0;
/// Cells a triangle where points are few; more cells make shorter lists and more of them.
const CELLS_A_TRIANGLE: f64 = 3.0 / 16.0;
/// So many times as many at most, where points pay for more.
const MOST_TIMES: f64 = 32.0;

/// A tile's cells.
#[derive(Debug)]
pub(super) struct Tile {
    /// Row by row, and one more that ends the last.
    pub(super) cells: Vec<Cell>,
    /// The cells' lists.
    pub(super) entries: Vec<Entry>,
    pub(super) groups: Vec<Group>,
    /// The faces that each group's triangles are of, by the first piece of each.
    pub(super) faces: Vec<[i32; 8]>,
}

/// One cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// The first of its entries; they end where the next cell's begin.
    pub(super) first: u32,
    /// What is certainly less near than this is certainly in shadow.
    pub(super) covered: f32,
    /// A point of a face that is certainly as near as this is certainly lit.
    pub(super) surface: f32,
}

const _: () = assert!(size_of::<Entry>() == 16);

/// A group over a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// None of its triangles is nearer over the cell.
    pub(super) nearest: f32,
    pub(super) group: u32,
    /// Which of them meet the cell, a bit each.
    pub(super) lanes: u8,
    /// Which of the group's hide nothing for certain.
    pub(super) vague: u8,
    /// What these that meet the cell may be to a sheet over it.
    pub(super) share: Share,
    /// None of them is less near over the cell.
    pub(super) farthest: f32,
}

impl Tile {
    /// `side` cells along each side for pieces in units of half the tile, which come in parts. `unit` is 1 for a sun, whose nearness may have any sign, 0 for a lamp.
    pub(super) fn of(parts: Vec<Listed>, side: u32, unit: f32) -> Self {
        let mut first = 0;
        let mut spreads = Vec::new();
        for Listed { groups, extents, .. } in &parts {
            spreads.push(Spread { groups, extents, first, side, unit });
            first += groups.len();
        }
        let (found, of_parts): (Vec<Vec<Found>>, Vec<Vec<f32>>) = spreads.into_par_iter().map(dispatch).unzip();
        let mut covered = vec![f32::NEG_INFINITY; (side * side) as usize];
        for of_part in of_parts {
            covered.iter_mut().zip(of_part).for_each(|(most, covered)| *most = most.max(covered));
        }
        let mut tile = Self { cells: Vec::new(), entries: Vec::new(), groups: Vec::new(), faces: Vec::new() };
        tile.list(&found, &covered, unit);
        for Listed { groups, faces, .. } in parts {
            tile.groups = joined(tile.groups, groups);
            tile.faces = joined(tile.faces, faces);
        }
        tile
    }

    /// A cell, and its list.
    #[inline(always)]
    pub(super) fn list_of(&self, cell: usize) -> (Cell, &[Entry]) {
        let [here, next] = [self.cells[cell], self.cells[cell + 1]];
        (here, &self.entries[here.first as usize..next.first as usize])
    }

    /// Sorts what was found into the cells' lists: nearest first, without what is hidden by what covers its cell.
    fn list(&mut self, found: &[Vec<Found>], covered: &[f32], unit: f32) {
        let is_seen = |found: &&Found| {
            let limit = covered[found.cell as usize];
            found.entry.nearest >= limit - (limit.abs() + unit) * (4.0 * HEIGHT_LIMIT)
        };
        let mut next = vec![0u32; covered.len() + 1];
        for found in found.iter().flatten().filter(is_seen) {
            next[found.cell as usize + 1] += 1;
        }
        for cell in 0..covered.len() {
            next[cell + 1] += next[cell];
        }
        let ends = covered.iter().copied().chain([f32::NEG_INFINITY]);
        let cell = |(&first, covered)| Cell { first, covered, surface: f32::INFINITY };
        self.cells = next.iter().zip(ends).map(cell).collect();
        self.entries = vec![Entry::EMPTY; next[covered.len()] as usize];
        for found in found.iter().flatten().filter(is_seen) {
            let place = &mut next[found.cell as usize];
            self.entries[*place as usize] = found.entry;
            *place += 1;
        }
        for (cell, &covered) in covered.iter().enumerate() {
            let [first, end] = [self.cells[cell].first as usize, self.cells[cell + 1].first as usize];
            let entries = &mut self.entries[first..end];
            entries.sort_unstable_by(|a, b| b.nearest.total_cmp(&a.nearest));
            self.cells[cell].surface = surface::from(entries, covered);
        }
    }
}

impl Entry {
    const EMPTY: Self = Self { nearest: 0.0, group: 0, lanes: 0, vague: 0, share: Share::NONE, farthest: 0.0 };
}

/// One after the other; the first is not moved unless it must be.
fn joined<T>(mut first: Vec<T>, then: Vec<T>) -> Vec<T> {
    if first.is_empty() {
        return then;
    }
    first.extend(then);
    first
}

/// A group and a cell that meet.
struct Found {
    cell: u32,
    entry: Entry,
}

/// Which groups meet which cells, and what covers each cell.
struct Spread<'a> {
    groups: &'a [Group],
    extents: &'a [Extent],
    /// The number of the first group.
    first: usize,
    side: u32,
    unit: f32,
}

impl Kernel for Spread<'_> {
    type Output = (Vec<Found>, Vec<f32>);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let side = self.side;
        let half = 1.0 / side as f32;
        let middle = |cell: u32| (2 * cell + 1) as f32 * half - 1.0;
        let mut covered = vec![f32::NEG_INFINITY; (side * side) as usize];
        let mut found = Vec::with_capacity(self.groups.len() * 8);
        for (number, (group, extent)) in (self.first..).zip(self.groups.iter().zip(self.extents)) {
            let [u0, v0, u1, v1] = extent.bounds().map(f64::from);
            let columns = cell_index(u0, -WIDENED, side)..=cell_index(u1, WIDENED, side);
            for row in cell_index(v0, -WIDENED, side)..=cell_index(v1, WIDENED, side) {
                let Some(strip) = group.strip(simd, middle(row), half * (1.0 + WIDENED), extent) else { continue };
                for column in columns.clone() {
                    let Some(over) = group.over(simd, &strip, middle(column), extent, self.unit) else { continue };
                    let cell = row * side + column;
                    let Over { nearest, covered: most, lanes, share, farthest } = over;
                    let (group, vague) = (number as u32, extent.vague);
                    let entry = Entry { nearest, group, lanes, vague, share, farthest };
                    found.push(Found { cell, entry });
                    let covered = &mut covered[cell as usize];
                    *covered = if most > *covered { most } else { *covered };
                }
            }
        }
        (found, covered)
    }
}

/// Which cell along a side, the cells widened.
#[inline(always)]
fn cell_index(bound: f64, wide: f32, side: u32) -> u32 {
    let count = f64::from(side);
    (((bound + 1.0) * count + f64::from(wide)) * 0.5).clamp(0.0, count - 1.0) as u32
}

/// Which cell along a side a place from −1 to 1 belongs to, of two neighbours either at their border; `scale` is the number of
/// cells.
#[inline(always)]
pub(super) fn cell_along(place: f32, scale: f32) -> u32 {
    let middle = (place + 1.0) * 0.5 * scale - 0.5;
    let last = scale - 1.0;
    let middle = if middle < last { middle } else { last };
    let middle = if middle > 0.0 { middle } else { 0.0 };
    whole(middle)
}

/// About a triangle's size a cell, and smaller where points pay for so many times as many.
pub(super) fn side_for(count: f64, pays: f64) -> u32 {
    (count * CELLS_A_TRIANGLE * pays.clamp(1.0, MOST_TIMES)).sqrt().round().clamp(1.0, MAX_SIDE) as u32
}
