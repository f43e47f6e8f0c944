//! One tile of a view's plane: groups of eight triangles that lie together, and square cells with the groups over them,
//! nearest to the light first.
//!
//! Cost: some tens of nanoseconds a triangle. Cells are about the size of the tile's triangles; they hold numbers of groups only, so
//! a triangle is stored once a tile. A cell that one triangle covers as a whole needs nothing that lies farther: what is
//! behind that triangle is in its shadow.

use umbriel_geometry::simd::{Kernel, Simd, dispatch};

use crate::loose::{
    group::{Extent, Group, whole},
    listed::{Listed, keys},
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
/// Points a triangle that pay for one more times as many cells, and how many times at most.
const POINTS_A_TRIANGLE: f64 = 16.0;
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
}

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
}

impl Tile {
    /// `side` cells along each side for pieces in units of half the tile. `unit` is 1 for a sun, whose nearness may have any sign, 0 for a lamp.
    pub(super) fn of(listed: &[Listed], side: u32, unit: f32) -> Self {
        let mut tile = Self { cells: Vec::new(), entries: Vec::new(), groups: Vec::new(), faces: Vec::new() };
        let extents = tile.group(listed);
        let (found, covered) = dispatch(Spread { groups: &tile.groups, extents: &extents, side, unit });
        tile.list(&found, &covered, unit);
        tile
    }

    /// Puts triangles that lie together into groups, by counting how many there are of each key.
    fn group(&mut self, listed: &[Listed]) -> Vec<Extent> {
        let lanes = |met: u8| (0..8).filter(move |lane| met >> lane & 1 == 1);
        let mut next = vec![0u32; keys(listed.len())];
        for listed in listed {
            lanes(listed.met).for_each(|lane| next[listed.keys[lane] as usize] += 1);
        }
        let mut count = 0;
        for number in &mut next {
            (*number, count) = (count, count + *number);
        }
        let groups = (count as usize).div_ceil(8);
        let mut extents = vec![Extent::EMPTY; groups];
        self.groups = vec![Group::EMPTY; groups];
        self.faces = vec![[0; 8]; groups];
        for listed in listed {
            for lane in lanes(listed.met) {
                let next = &mut next[listed.keys[lane] as usize];
                let (group, to) = (*next as usize / 8, *next as usize % 8);
                *next += 1;
                self.groups[group].take(to, &listed.group, lane);
                extents[group].take(to, &listed.extent, lane);
                self.faces[group][to] = listed.faces[lane];
            }
        }
        extents
    }

    /// What covers a cell, and its list.
    #[inline(always)]
    pub(super) fn list_of(&self, cell: usize) -> (f32, &[Entry]) {
        let [here, next] = [self.cells[cell], self.cells[cell + 1]];
        (here.covered, &self.entries[here.first as usize..next.first as usize])
    }

    /// Sorts what was found into the cells' lists: nearest first, without what is hidden by what covers its cell.
    fn list(&mut self, found: &[Found], covered: &[f32], unit: f32) {
        let is_seen = |found: &&Found| {
            let limit = covered[found.cell as usize];
            found.entry.nearest >= limit - (limit.abs() + unit) * (4.0 * HEIGHT_LIMIT)
        };
        let mut next = vec![0u32; covered.len() + 1];
        for found in found.iter().filter(is_seen) {
            next[found.cell as usize + 1] += 1;
        }
        for cell in 0..covered.len() {
            next[cell + 1] += next[cell];
        }
        let starts = || next.iter().copied();
        let ends = covered.iter().copied().chain([f32::NEG_INFINITY]);
        self.cells = starts().zip(ends).map(|(first, covered)| Cell { first, covered }).collect();
        self.entries = vec![Entry { nearest: 0.0, group: 0, lanes: 0, vague: 0 }; next[covered.len()] as usize];
        for found in found.iter().filter(is_seen) {
            let place = &mut next[found.cell as usize];
            self.entries[*place as usize] = found.entry;
            *place += 1;
        }
        for ends in self.cells.windows(2) {
            self.entries[ends[0].first as usize..ends[1].first as usize]
                .sort_unstable_by(|a, b| b.nearest.total_cmp(&a.nearest));
        }
    }
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
        let mut found = Vec::with_capacity(self.groups.len() * 16);
        for (number, (group, extent)) in self.groups.iter().zip(self.extents).enumerate() {
            let [u0, v0, u1, v1] = extent.bounds().map(f64::from);
            let columns = cell_index(u0, -WIDENED, side)..=cell_index(u1, WIDENED, side);
            for row in cell_index(v0, -WIDENED, side)..=cell_index(v1, WIDENED, side) {
                let Some(strip) = group.strip(simd, middle(row), half * (1.0 + WIDENED), extent) else { continue };
                for column in columns.clone() {
                    let Some(over) = group.over(simd, &strip, middle(column), extent, self.unit) else { continue };
                    let cell = row * side + column;
                    let entry =
                        Entry { nearest: over.nearest, group: number as u32, lanes: over.lanes, vague: extent.vague };
                    found.push(Found { cell, entry });
                    let covered = &mut covered[cell as usize];
                    *covered = if over.covered > *covered { over.covered } else { *covered };
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

/// About a triangle's size a cell, and smaller where many points will be asked for each triangle.
pub(super) fn side_for(count: usize, points_a_triangle: f64) -> u32 {
    let times = (points_a_triangle / POINTS_A_TRIANGLE).clamp(1.0, MOST_TIMES);
    (count as f64 * CELLS_A_TRIANGLE * times).sqrt().round().clamp(1.0, MAX_SIDE) as u32
}
