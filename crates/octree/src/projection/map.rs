//! A map of a face: which leaves are seen where.
//!
//! The square [−1, 1]² is a grid of tiles, and each tile a grid of cells of its own fineness, 2^k a side. A cell holds the
//! numbers of all leaves whose projection meets it, ascending, as a run of one flat array. *Fineness by cost*: halving the
//! cells of a tile saves each ray through it the leaves that fewer cells share, and costs time and memory for each number
//! stored; it goes on while the rays that are expected there save more than it costs ([`VISITS_A_NUMBER`]). So cells are fine
//! where projections overlap and coarse where they do not.
//!
//! *Nothing is missed.* A number u of the square is in the cell ⌊(u + 1)/2·n⌋, in floats a monotone function, and borders count as
//! the last cell inside. A leaf is written from the cell of its least u (rounded down) to that of its greatest (rounded up), so
//! any u between has its cell among them; a ray is looked up from the cell of the least u that it may have to that of the
//! greatest. Rows are the same. O(leaves × cells that they meet); a look-up is O(1).

use std::ops::Range;

use super::{budget::Budget, footprint::Footprint, tasks};

/// Halvings of a tile at most.
pub(super) const MAX_FINENESS: u8 = 6;

/// How many visits of leaves cost as much as storing a number: both measured on the models of the project's benchmark.
const VISITS_A_NUMBER: f64 = 1.5;

/// Leaves that a tile is meant to see where each is seen in one tile.
const LEAVES_A_TILE: usize = 8;

/// Tiles along a side at most.
const MAX_TILES: u32 = 1 << 9;

/// Places of leaves in tiles at most.
const MOST_PLACES: usize = 1 << 29;

/// A tile: where its cells begin, and how often it is halved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Tile {
    first: u32,
    fineness: u8,
}

/// A map.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// Tiles along a side: a power of two.
    side: u32,
    /// Leaves that are seen.
    leaves: usize,
    tiles: Vec<Tile>,
    /// Where the run of each cell begins; one more at the end.
    starts: Vec<u32>,
    numbers: Vec<u32>,
}

/// How a map is made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan<'a> {
    /// Rays that are expected through the face.
    pub(super) rays: f64,
    pub(super) max_fineness: u8,
    /// Tiles along a side at most.
    pub(super) max_side: u32,
    /// Once it is spent cells stay empty.
    pub(super) budget: &'a Budget,
}

/// What has become of the leaves of a map.
pub(super) struct Changes<'a> {
    /// The new number of each leaf that is still there.
    pub(super) numbers: &'a [u32],
    /// Seen before, no longer there.
    pub(super) gone: &'a [(u32, Footprint)],
    /// Seen now, not there before.
    pub(super) made: &'a [(u32, Footprint)],
}

/// The cells of a tile and their runs.
#[derive(Clone, Debug, Default)]
struct Filled {
    fineness: u8,
    /// Numbers in each cell.
    counts: Vec<u32>,
    numbers: Vec<u32>,
}

/// The cell of a coordinate among `cells` in a row.
#[inline]
fn cell_of(coordinate: f64, cells: u32) -> u32 {
    // Negative numbers, just outside, become zero.
    ((coordinate * 0.5 + 0.5) * f64::from(cells)) as u32
}

/// The cells from one coordinate to another.
fn cells_between([low, high]: [f64; 2], cells: u32) -> Range<u32> {
    cell_of(low, cells).min(cells - 1)..cell_of(high, cells).min(cells - 1) + 1
}

/// The borders of a row of cells; the outermost rows hold the rim too. Exact, as the number of cells is a power of two.
fn strip(row: u32, cells: u32) -> [f64; 2] {
    let border = |row: u32| f64::from(row) / f64::from(cells) * 2.0 - 1.0;
    let low = if row == 0 { -2.0 } else { border(row) };
    let high = if row + 1 == cells { 2.0 } else { border(row + 1) };
    // Rounding the coordinate of a cell may carry a number over the border below it.
    [low - f64::EPSILON, high + f64::EPSILON]
}

/// Calls `visit` with each row of cells that the leaf meets among `rows`, and the columns.
fn for_each_row(leaf: &Footprint, cells: u32, rows: Range<u32>, mut visit: impl FnMut(u32, Range<u32>)) {
    let Some(reach) = leaf.rows() else { return };
    let met = cells_between(reach, cells);
    for row in met.start.max(rows.start)..met.end.min(rows.end) {
        if let Some(columns) = leaf.columns(strip(row, cells)) {
            visit(row, cells_between(columns, cells));
        }
    }
}

impl Map {
    /// Of leaves with their numbers, in the order that the runs are to have.
    pub(super) fn new(leaves: &[(u32, Footprint)], plan: &Plan) -> Self {
        let mut side = side_for(leaves.len()).min(plan.max_side);
        // Lists of the leaves that each tile sees are as many places, and with many leaves that are seen everywhere too many.
        while side > 1 && places_in_tiles(leaves, side) > plan.budget.limit().min(MOST_PLACES) {
            side /= 2;
        }
        let lists = sort_into_tiles(leaves, side);
        let filled = tasks::map((0..side * side).collect(), |tile| fill(lists.of(leaves, tile), tile, side, plan));
        Self::joined(side, leaves.len(), filled)
    }

    /// Puts the tiles behind each other.
    fn joined(side: u32, leaves: usize, filled: Vec<Filled>) -> Self {
        let mut map = Self { side, leaves, tiles: Vec::new(), starts: Vec::new(), numbers: Vec::new() };
        for tile in filled {
            map.tiles.push(Tile { first: map.starts.len() as u32, fineness: tile.fineness });
            let mut start = map.numbers.len() as u32;
            for count in tile.counts {
                map.starts.push(start);
                start += count;
            }
            map.numbers.extend(tile.numbers);
        }
        map.starts.push(map.numbers.len() as u32);
        map
    }

    /// Which tiles see a leaf that is gone, or a new one; `None` where there are other tiles than before.
    pub(super) fn touched(&self, changes: &Changes, plan: &Plan) -> Option<Vec<bool>> {
        let mut touched = vec![false; self.tiles.len()];
        for (_, leaf) in changes.gone.iter().chain(changes.made) {
            for_each_tile(leaf, self.side, &mut |tile| touched[tile] = true);
        }
        (side_for(self.leaves_after(changes)).min(plan.max_side) == self.side).then_some(touched)
    }

    /// Whether a leaf is seen in one of the touched tiles.
    pub(super) fn meets_any(&self, leaf: &Footprint, touched: &[bool]) -> bool {
        let mut is_met = false;
        for_each_tile(leaf, self.side, &mut |tile| is_met |= touched[tile]);
        is_met
    }

    /// The map after changes, and how many cells were filled; `near` are all leaves that touched tiles see, ascending.
    pub(super) fn renewed(
        &self,
        changes: &Changes,
        near: &[(u32, Footprint)],
        touched: &[bool],
        plan: &Plan,
    ) -> (Self, usize) {
        let lists = sort_into_tiles(near, self.side);
        let filled = tasks::map((0..self.side * self.side).collect(), |tile| {
            if touched[tile as usize] {
                fill(lists.of(near, tile), tile, self.side, plan)
            } else {
                self.renumbered(tile, changes.numbers)
            }
        });
        let made = filled.iter().zip(touched).filter(|(_, is_touched)| **is_touched);
        let made = made.map(|(tile, _)| tile.counts.len()).sum();
        (Self::joined(self.side, self.leaves_after(changes), filled), made)
    }

    /// How many leaves are seen after changes.
    fn leaves_after(&self, changes: &Changes) -> usize {
        self.leaves + changes.made.len() - changes.gone.len()
    }

    /// A tile as it is, its leaves by other numbers.
    fn renumbered(&self, tile: u32, numbers: &[u32]) -> Filled {
        let Tile { first, fineness } = self.tiles[tile as usize];
        let runs = (first..first + (1 << (2 * fineness))).map(|cell| self.run(cell));
        Filled {
            fineness,
            counts: runs.clone().map(|run| run.len() as u32).collect(),
            numbers: runs.flatten().map(|&leaf| numbers[leaf as usize]).collect(),
        }
    }

    /// Tiles along a side.
    pub(super) fn side(&self) -> u32 {
        self.side
    }

    /// Bytes that the map takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.tiles) + size_of_val(&*self.starts) + size_of_val(&*self.numbers)
    }

    /// Cells, and numbers in them.
    pub(super) fn len(&self) -> [usize; 2] {
        [self.starts.len() - 1, self.numbers.len()]
    }

    /// The run of the cell that holds a place, if all within `spread` of it lies in one cell.
    #[inline]
    pub(super) fn run_at(&self, [u, v]: [f64; 2], spread: f64) -> Option<&[u32]> {
        let finest = self.side << MAX_FINENESS;
        let column = cell_of(u - spread, finest).min(finest - 1);
        let row = cell_of(v - spread, finest).min(finest - 1);
        let other = [cell_of(u + spread, finest).min(finest - 1), cell_of(v + spread, finest).min(finest - 1)];
        let (x, y) = (column >> MAX_FINENESS, row >> MAX_FINENESS);
        let tile = self.tiles[(y * self.side + x) as usize];
        let coarser = MAX_FINENESS - tile.fineness;
        if [column >> coarser, row >> coarser] != other.map(|cell| cell >> coarser) {
            return None;
        }
        let mask = (1 << tile.fineness) - 1;
        let cell = tile.first + (((row >> coarser) & mask) << tile.fineness) + ((column >> coarser) & mask);
        Some(self.run(cell))
    }

    /// The runs of all cells within `spread` of a place.
    pub(super) fn runs_near(&self, [u, v]: [f64; 2], spread: f64) -> Vec<&[u32]> {
        let columns = |cells| cells_between([u - spread, u + spread], cells);
        let rows = |cells| cells_between([v - spread, v + spread], cells);
        let mut runs = Vec::new();
        for y in rows(self.side) {
            for x in columns(self.side) {
                let tile = self.tiles[(y * self.side + x) as usize];
                let (within, cells) = (1 << tile.fineness, self.side << tile.fineness);
                let inside =
                    |range: Range<u32>, tile: u32| range.start.max(tile * within)..range.end.min((tile + 1) * within);
                for row in inside(rows(cells), y) {
                    for column in inside(columns(cells), x) {
                        runs.push(self.run(tile.first + (row - y * within) * within + column - x * within));
                    }
                }
            }
        }
        runs
    }

    #[inline]
    fn run(&self, cell: u32) -> &[u32] {
        let cell = cell as usize;
        &self.numbers[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }
}

/// Tiles along a side for so many leaves.
fn side_for(leaves: usize) -> u32 {
    let tiles = (leaves / LEAVES_A_TILE).max(1) as f64;
    (tiles.sqrt() as u32).next_power_of_two().clamp(1, MAX_TILES)
}

/// Places of leaves in a list, by tiles.
struct TileLists {
    starts: Vec<u32>,
    leaves: Vec<u32>,
}

impl TileLists {
    fn of<'a>(&self, leaves: &'a [(u32, Footprint)], tile: u32) -> Vec<&'a (u32, Footprint)> {
        let places = &self.leaves[self.starts[tile as usize] as usize..self.starts[tile as usize + 1] as usize];
        places.iter().map(|&place| &leaves[place as usize]).collect()
    }
}

/// Calls `visit` with the tiles that a leaf meets.
fn for_each_tile(leaf: &Footprint, side: u32, visit: &mut dyn FnMut(usize)) {
    for_each_row(leaf, side, 0..side, |row, columns| {
        columns.for_each(|column| visit((row * side + column) as usize));
    });
}

/// How many leaves the tiles see, all together.
fn places_in_tiles(leaves: &[(u32, Footprint)], side: u32) -> usize {
    let mut places = 0;
    for (_, leaf) in leaves {
        for_each_row(leaf, side, 0..side, |_, columns| places += columns.len());
    }
    places
}

/// A counting sort: tiles keep the leaves' order.
fn sort_into_tiles(leaves: &[(u32, Footprint)], side: u32) -> TileLists {
    let mut starts = vec![0u32; (side * side) as usize + 1];
    for (_, leaf) in leaves {
        for_each_tile(leaf, side, &mut |tile| starts[tile + 1] += 1);
    }
    for tile in 1..starts.len() {
        starts[tile] += starts[tile - 1];
    }
    let mut next = starts.clone();
    let mut sorted = vec![0; starts[starts.len() - 1] as usize];
    for (place, (_, leaf)) in (0u32..).zip(leaves) {
        for_each_tile(leaf, side, &mut |tile| {
            sorted[next[tile] as usize] = place;
            next[tile] += 1;
        });
    }
    TileLists { starts, leaves: sorted }
}

/// The cells of a tile, halved as long as it pays.
fn fill(leaves: Vec<&(u32, Footprint)>, tile: u32, side: u32, plan: &Plan) -> Filled {
    let (leaves, tile, max_fineness) = (&leaves[..], [tile % side, tile / side], plan.max_fineness);
    let rays = plan.rays / f64::from(side * side);
    let mut counts = vec![leaves.len() as u32];
    let mut fineness = 0;
    while fineness < max_fineness && counts.iter().any(|&count| count > 1) {
        let finer = count(leaves, tile, side, fineness + 1);
        let total = |counts: &[u32]| counts.iter().map(|&count| f64::from(count)).sum::<f64>();
        let (now, then) = (total(&counts), total(&finer));
        let saved = rays * (now / counts.len() as f64 - then / finer.len() as f64);
        if saved <= VISITS_A_NUMBER * (then - now + (finer.len() - counts.len()) as f64) {
            break;
        }
        (counts, fineness) = (finer, fineness + 1);
    }
    let total: usize = counts.iter().map(|&count| count as usize).sum();
    plan.budget.spend((total + counts.len()) * size_of::<u32>());
    // A map of one cell is the least there is.
    if plan.budget.is_over() && (side > 1 || max_fineness > 0) {
        return Filled { fineness: 0, counts: vec![0], numbers: Vec::new() };
    }
    let numbers = write(leaves, tile, side, fineness, &counts);
    Filled { fineness, counts, numbers }
}

/// Calls `visit` with the cells of a tile that a leaf meets.
fn for_each_cell(leaf: &Footprint, tile: [u32; 2], side: u32, fineness: u8, mut visit: impl FnMut(usize)) {
    let within = 1 << fineness;
    let [first_column, first_row] = tile.map(|place| place * within);
    for_each_row(leaf, side * within, first_row..first_row + within, |row, columns| {
        for column in columns.start.max(first_column)..columns.end.min(first_column + within) {
            visit(((row - first_row) * within + column - first_column) as usize);
        }
    });
}

/// How many leaves each cell of the tile sees.
fn count(leaves: &[&(u32, Footprint)], tile: [u32; 2], side: u32, fineness: u8) -> Vec<u32> {
    let mut counts = vec![0; 1 << (2 * fineness)];
    for (_, leaf) in leaves {
        for_each_cell(leaf, tile, side, fineness, |cell| counts[cell] += 1);
    }
    counts
}

/// The numbers of the leaves that each cell sees, cell by cell.
fn write(leaves: &[&(u32, Footprint)], tile: [u32; 2], side: u32, fineness: u8, counts: &[u32]) -> Vec<u32> {
    if fineness == 0 {
        return leaves.iter().map(|(number, _)| *number).collect();
    }
    let mut next: Vec<u32> = counts.iter().scan(0, |end, count| Some(std::mem::replace(end, *end + count))).collect();
    let mut numbers = vec![0; counts.iter().map(|&count| count as usize).sum()];
    for (number, leaf) in leaves {
        for_each_cell(leaf, tile, side, fineness, |cell| {
            numbers[next[cell] as usize] = *number;
            next[cell] += 1;
        });
    }
    numbers
}
