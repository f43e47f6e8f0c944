//! One tile of a view's plane: square cells, and for each the triangles over it, nearest to the light first.
//!
//! Cost: about 50 ns a triangle and 20 ns for each cell that it meets. Cells are about the size of the tile's triangles.
//!
//! A cell that one triangle covers as a whole needs nothing that lies farther: what is behind that triangle is in its shadow.

use crate::{
    light_space::{Affine, Footprint},
    loose::group::{EDGE_LIMIT, EDGE_MARGIN, Group, NEARNESS_MARGIN},
};

/// Cells hold what meets them when they are this much wider on each side, units of half a cell. So a point within
/// [`PLACE_LIMIT`] beside its cell needs no other cell.
const WIDENED: f64 = 1.0 / 64.0;
/// Points that are off by more, in units of half a cell, cannot be told by cells.
pub(super) const PLACE_LIMIT: f32 = 1.0 / 128.0;
/// Points whose nearness is off by more, in parts of it (a sun's: of the scene), cannot be told by what covers a cell.
pub(super) const HEIGHT_LIMIT: f32 = 1.0 / (1u32 << 17) as f32;
/// At most 2^8 cells along a tile's side.
const MAX_LEVEL: u32 = 8;

/// A tile's cells.
#[derive(Debug)]
pub(super) struct Tile {
    /// 2^level cells along each side.
    pub(super) level: u32,
    /// Row by row, and one more that ends the last.
    pub(super) cells: Vec<Cell>,
    pub(super) groups: Vec<Group>,
}

/// One cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// The first of its groups; they end where the next cell's begin.
    pub(super) first: u32,
    /// What is certainly less near than this is certainly in shadow.
    pub(super) covered: f32,
}

/// A triangle over a cell.
#[derive(Clone, Copy)]
struct Over {
    cell: u32,
    footprint: u32,
    /// It is nowhere nearer in the cell.
    nearest: f32,
}

impl Tile {
    /// Cells for footprints in units of half the tile, with their pieces' numbers. `unit` is 1 for a sun, whose nearness may
    /// have any sign, 0 for a lamp.
    pub(super) fn of(footprints: &mut [(u32, Footprint)], unit: f32) -> Self {
        let level = level_for(footprints.len());
        let half = 1.0 / f64::from(1u32 << level);
        for (_, footprint) in footprints.iter_mut() {
            if footprint.edge_error > half * f64::from(EDGE_MARGIN) * 0.5 {
                footprint.edges = [[0.0; 3]; 3];
            }
        }
        let mut covered = vec![f32::NEG_INFINITY; 1 << (2 * level)];
        let mut over = Vec::with_capacity(4 * footprints.len());
        for (number, (_, footprint)) in footprints.iter().enumerate() {
            spread(footprint, number as u32, level, &mut over, &mut covered);
        }
        let over = by_cell(&over, &covered, unit);
        let mut tile = Self { level, cells: Vec::with_capacity(covered.len() + 1), groups: Vec::new() };
        let mut rest = over.as_slice();
        for (cell, covered) in covered.into_iter().enumerate() {
            tile.cells.push(Cell { first: tile.groups.len() as u32, covered });
            let count = rest.iter().take_while(|over| over.cell == cell as u32).count();
            let (here, later) = rest.split_at(count);
            tile.fill(cell as u32, here, footprints);
            rest = later;
        }
        tile.cells.push(Cell { first: tile.groups.len() as u32, covered: f32::NEG_INFINITY });
        tile
    }

    /// Appends the groups of one cell.
    fn fill(&mut self, cell: u32, here: &[Over], footprints: &[(u32, Footprint)]) {
        let middle = middle(cell, self.level);
        let half = 1.0 / f64::from(1u32 << self.level);
        for eight in here.chunks(8) {
            let mut group = Group::EMPTY;
            group.nearest = eight[0].nearest;
            for (lane, over) in eight.iter().enumerate() {
                let (piece, footprint) = &footprints[over.footprint as usize];
                group.pieces[lane] = *piece;
                group.set(lane, footprint, middle, half);
            }
            self.groups.push(group);
        }
    }
}

impl Group {
    /// Puts a triangle into a lane, in the coordinates of the cell with this middle.
    #[inline]
    fn set(&mut self, lane: usize, footprint: &Footprint, middle: [f64; 2], half: f64) {
        for (edge, to) in footprint.edges.iter().zip(&mut self.edges) {
            to[0][lane] = edge[0] as f32;
            to[1][lane] = edge[1] as f32;
            to[2][lane] = (at(edge, middle) / half).min(EDGE_LIMIT) as f32;
        }
        let [p, q, _] = footprint.plane;
        self.plane[0][lane] = (p * half) as f32;
        self.plane[1][lane] = (q * half) as f32;
        self.plane[2][lane] = at(&footprint.plane, middle) as f32;
        // A vague plane is constant and a bound: there is nothing to be off.
        let off = if footprint.plane_error < f64::INFINITY { footprint.plane_error } else { 0.0 };
        let slope = (p.abs() + q.abs()) * half + off / f64::from(NEARNESS_MARGIN);
        self.slope[lane] = (slope as f32).next_up();
    }
}

/// About one cell for two triangles of a layer, and some layers.
fn level_for(count: usize) -> u32 {
    let wanted = (count as f64 * tune("C", CELLS_A_TRIANGLE)).max(1.0);
    ((wanted.log2() * 0.5).round() as u32).min(MAX_LEVEL)
}

/// Cells a triangle; more cells make shorter lists and more of them.
const CELLS_A_TRIANGLE: f64 = 0.5;
#[allow(missing_docs)]
pub(super) fn tune(name: &str, v: f64) -> f64 { std::env::var(name).map_or(v, |s| s.parse().unwrap()) }

/// The middle of a cell.
#[inline]
fn middle(cell: u32, level: u32) -> [f64; 2] {
    let (column, row) = (cell & ((1 << level) - 1), cell >> level);
    let half = 1.0 / f64::from(1u32 << level);
    [column, row].map(|index| f64::from(2 * index + 1) * half - 1.0)
}

#[inline(always)]
fn at(function: &Affine, [u, v]: [f64; 2]) -> f64 {
    function[0] * u + function[1] * v + function[2]
}

/// The cells that a footprint meets, and those that it covers.
fn spread(footprint: &Footprint, number: u32, level: u32, over: &mut Vec<Over>, covered: &mut [f32]) {
    let half = 1.0 / f64::from(1u32 << level);
    let end = f64::from(1u32 << level) - 1.0;
    let index = |bound: f64, wide: f64| (((bound + 1.0) / half + wide) * 0.5).clamp(0.0, end) as u32;
    let [u0, v0, u1, v1] = footprint.bounds;
    let columns = index(u0, -WIDENED)..=index(u1, WIDENED);
    let rows = index(v0, -WIDENED)..=index(v1, WIDENED);
    let [p, q, _] = footprint.plane;
    let slope = (p.abs() + q.abs()) * half * (1.0 + WIDENED);
    let off = if footprint.plane_error < f64::INFINITY { footprint.plane_error } else { 0.0 };
    // All edges are positive inside by at least this much in the middle when the whole cell is inside, and so on.
    let (missed, all) = (-half * (1.0 + WIDENED), half * (1.0 + 2.0 * WIDENED));
    for row in rows {
        for column in columns.clone() {
            let cell = row << level | column;
            let middle = middle(cell, level);
            let [e0, e1, e2] = footprint.edges.each_ref().map(|edge| at(edge, middle));
            let inside = e0.min(e1).min(e2);
            if inside < missed {
                continue;
            }
            let here = at(&footprint.plane, middle);
            let nearest = (here + slope + off).min(footprint.nearest);
            over.push(Over { cell, footprint: number, nearest: up(nearest) });
            if inside >= all {
                let farthest = down(here - slope - off);
                covered[cell as usize] = covered[cell as usize].max(farthest);
            }
        }
    }
}

/// Rounded up to a float, and past the rounding of the few operations that made the number.
fn up(value: f64) -> f32 {
    (value as f32).next_up().next_up()
}

fn down(value: f64) -> f32 {
    (value as f32).next_down().next_down()
}

/// In the order of cells, nearest first; without what is hidden by what covers its cell.
fn by_cell(over: &[Over], covered: &[f32], unit: f32) -> Vec<Over> {
    let hidden = |cell: u32| {
        let limit = covered[cell as usize];
        limit - (limit.abs() + unit) * (4.0 * HEIGHT_LIMIT)
    };
    let mut starts = vec![0u32; covered.len() + 1];
    let seen = || over.iter().filter(|over| over.nearest >= hidden(over.cell) || covered[over.cell as usize] == f32::NEG_INFINITY);
    for over in seen() {
        starts[over.cell as usize + 1] += 1;
    }
    for cell in 0..covered.len() {
        starts[cell + 1] += starts[cell];
    }
    let mut sorted = vec![Over { cell: 0, footprint: 0, nearest: 0.0 }; starts[covered.len()] as usize];
    let mut next = starts.clone();
    for over in seen() {
        let place = &mut next[over.cell as usize];
        sorted[*place as usize] = *over;
        *place += 1;
    }
    for ends in starts.windows(2) {
        sorted[ends[0] as usize..ends[1] as usize].sort_unstable_by(|a, b| b.nearest.total_cmp(&a.nearest));
    }
    sorted
}
