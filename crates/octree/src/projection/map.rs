//! A map of a face: which packs of leaves are seen where.
//!
//! The square [−1, 1]² is a grid of tiles, and each tile a grid of cells of its own fineness, 2^k a side. A cell holds the
//! numbers of all packs whose projection meets it, ascending, as a run of one flat array; packs are numbered leaf by leaf, so of a
//! leaf with many triangles a cell names what is seen in it, not all. *Fineness by cost*: halving the
//! cells of a tile saves each ray through it the packs that fewer cells share, and costs time and memory for each number
//! stored; it goes on while the rays that are expected there save more than it costs ([`VISITS_A_NUMBER`]). So cells are fine
//! where projections overlap and coarse where they do not.
//!
//! How many numbers finer cells would hold is not counted but expected, from the rectangles and areas of what packs show
//! ([`fineness`]); so each pack's outline is gone through once a tile. What is stored goes in each row from the first column that a triangle of the
//! pack reaches to the last one. So gaps between triangles beside each other are stored and not expected (cells become finer than pays), and
//! triangles behind each other are expected as often as they are there, at most as the rectangle (cells stay coarser than pays). Answers do not depend on it,
//! nor does the memory that is allowed: it counts what is stored. Which cells a pack meets: [`grid`](super::grid), where nothing is missed.
//! O(packs × rows of cells that they meet); a look-up is O(1).

use std::ops::Range;

use super::{
    budget::Budget,
    footprint::Footprint,
    grid::{Around, Finder, Span, cells_between},
    tasks,
};

/// Halvings of a tile at most.
pub(super) const MAX_FINENESS: u8 = 6;

/// How many visits of packs cost as much as storing a number: both measured on the models of the project's benchmark.
const VISITS_A_NUMBER: f64 = 1.5;

/// Packs that a tile is meant to see where each is seen in one tile.
const PACKS_A_TILE: usize = 8;

/// Tiles along a side at most.
const MAX_TILES: u32 = 1 << 9;

/// Packs that one task sorts.
const CHUNK: usize = 1 << 12;

/// Places of packs in tiles at most.
const MOST_PLACES: usize = 1 << 29;

/// Bytes that a place takes while places are sorted: found, and where it belongs.
const PLACE: usize = size_of::<(u32, u32)>() + size_of::<u32>();

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
    /// Packs that are seen.
    packs: usize,
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
    /// Once it is spent tiles stay empty, but for those of the least maps.
    pub(super) budget: &'a Budget,
}

/// What has become of the packs of a map.
pub(super) struct Changes<'a> {
    /// The new number of each pack that is still there.
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

impl Map {
    /// Of packs with their numbers, in the order that the runs are to have.
    pub(super) fn new(packs: &[(u32, Footprint)], plan: &Plan) -> Self {
        let mut side = side_for(packs.len()).min(plan.max_side);
        // Lists of the packs that each tile sees are as many places, and with many packs that are seen everywhere too many.
        let most = (plan.budget.limit() / PLACE).min(MOST_PLACES);
        let lists = loop {
            if let Some(lists) = TileLists::new(packs, side, if side > 1 { most } else { usize::MAX }) {
                break lists;
            }
            side /= 2;
        };
        let filled = tasks::map((0..side * side).collect(), |tile| fill(&lists.of(packs, tile), tile, side, plan));
        Self::joined(side, packs.len(), filled)
    }

    /// Puts the tiles behind each other.
    fn joined(side: u32, packs: usize, filled: Vec<Filled>) -> Self {
        let mut map = Self { side, packs, tiles: Vec::new(), starts: Vec::new(), numbers: Vec::new() };
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

    /// Which tiles see a pack that is gone, or a new one; `None` where there are other tiles than before.
    pub(super) fn touched(&self, changes: &Changes, plan: &Plan) -> Option<Vec<bool>> {
        let mut touched = vec![false; self.tiles.len()];
        let mut finder = Finder::default();
        for (_, pack) in changes.gone.iter().chain(changes.made) {
            for_each_tile(&mut finder, pack, self.side, |tile| touched[tile] = true);
        }
        (side_for(self.packs_after(changes)).min(plan.max_side) == self.side).then_some(touched)
    }

    /// Whether a pack is seen in one of the touched tiles.
    pub(super) fn meets_any(&self, pack: &Footprint, touched: &[bool]) -> bool {
        let mut is_met = false;
        for_each_tile(&mut Finder::default(), pack, self.side, |tile| is_met |= touched[tile]);
        is_met
    }

    /// The map after changes, and how many cells were filled; `near` are all packs that touched tiles see, ascending.
    pub(super) fn renewed(
        &self,
        changes: &Changes,
        near: &[(u32, Footprint)],
        touched: &[bool],
        plan: &Plan,
    ) -> (Self, usize) {
        let lists = TileLists::new(near, self.side, usize::MAX).unwrap_or_default();
        let filled = tasks::map((0..self.side * self.side).collect(), |tile| {
            if touched[tile as usize] {
                fill(&lists.of(near, tile), tile, self.side, plan)
            } else {
                self.renumbered(tile, changes.numbers)
            }
        });
        let made = filled.iter().zip(touched).filter(|(_, is_touched)| **is_touched);
        let made = made.map(|(tile, _)| tile.counts.len()).sum();
        (Self::joined(self.side, self.packs_after(changes), filled), made)
    }

    /// How many packs are seen after changes.
    fn packs_after(&self, changes: &Changes) -> usize {
        self.packs + changes.made.len() - changes.gone.len()
    }

    /// A tile as it is, its packs by other numbers.
    fn renumbered(&self, tile: u32, numbers: &[u32]) -> Filled {
        let Tile { first, fineness } = self.tiles[tile as usize];
        let runs = (first..first + (1 << (2 * fineness))).map(|cell| self.run(cell));
        Filled {
            fineness,
            counts: runs.clone().map(|run| run.len() as u32).collect(),
            numbers: runs.flatten().map(|&pack| numbers[pack as usize]).collect(),
        }
    }

    /// Tiles along a side.
    pub(super) fn side(&self) -> u32 {
        self.side
    }

    /// Whether its tiles are fewer than its packs ask for, to save memory.
    pub(super) fn is_coarser(&self) -> bool {
        self.side < side_for(self.packs)
    }

    /// Bytes that the map takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.tiles) + size_of_val(&*self.starts) + size_of_val(&*self.numbers)
    }

    /// Cells, and numbers in them.
    pub(super) fn len(&self) -> [usize; 2] {
        [self.starts.len() - 1, self.numbers.len()]
    }

    /// The run of the cell that holds a place within [`RIM`](super::footprint::RIM) of the square, if all within `spread` of it lies in one cell.
    #[inline(always)]
    pub(super) fn run_at(&self, place: [f64; 2], spread: f64) -> Option<&[u32]> {
        let finest = self.side << MAX_FINENESS;
        let [[column, last_column], [row, last_row]] = Around::new(place, spread, finest).cells();
        let tile = self.tiles[((row >> MAX_FINENESS) * self.side + (column >> MAX_FINENESS)) as usize];
        let coarser = MAX_FINENESS - tile.fineness;
        // Numbers of cells that differ in their upper bits are those of other cells.
        if ((column ^ last_column) | (row ^ last_row)) >> coarser != 0 {
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

    #[inline(always)]
    fn run(&self, cell: u32) -> &[u32] {
        let cell = cell as usize;
        &self.numbers[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }
}

/// Tiles along a side for so many packs.
fn side_for(packs: usize) -> u32 {
    let tiles = (packs / PACKS_A_TILE).max(1) as f64;
    (tiles.sqrt() as u32).next_power_of_two().clamp(1, MAX_TILES)
}

/// Places of packs in a list, by tiles.
#[derive(Default)]
struct TileLists {
    starts: Vec<u32>,
    packs: Vec<u32>,
}

impl TileLists {
    /// A counting sort: tiles keep the packs' order. `None` where there are more places than `most`.
    fn new(packs: &[(u32, Footprint)], side: u32, most: usize) -> Option<Self> {
        let places = Budget::new(most);
        let parts = tasks::map(packs.chunks(CHUNK).collect(), |packs| {
            let (mut finder, mut met, mut spent) = (Finder::default(), Vec::with_capacity(2 * packs.len()), 0);
            for (place, (_, pack)) in (0u32..).zip(packs) {
                for_each_tile(&mut finder, pack, side, |tile| met.push((place, tile as u32)));
                // Not each pack by itself: threads would wait for each other.
                if met.len() - spent >= CHUNK {
                    places.spend(met.len() - spent);
                    spent = met.len();
                    if places.is_over() {
                        return Vec::new();
                    }
                }
            }
            places.spend(met.len() - spent);
            met
        });
        if places.is_over() {
            return None;
        }
        let mut starts = vec![0u32; (side * side) as usize + 1];
        parts.iter().flatten().for_each(|(_, tile)| starts[*tile as usize + 1] += 1);
        for tile in 1..starts.len() {
            starts[tile] += starts[tile - 1];
        }
        let mut next = starts.clone();
        let mut sorted = vec![0; starts[starts.len() - 1] as usize];
        for (first, part) in (0..).step_by(CHUNK).zip(&parts) {
            for (place, tile) in part {
                let at = &mut next[*tile as usize];
                sorted[*at as usize] = first + place;
                *at += 1;
            }
        }
        Some(Self { starts, packs: sorted })
    }

    fn of<'a>(&self, packs: &'a [(u32, Footprint)], tile: u32) -> Vec<&'a (u32, Footprint)> {
        let places = &self.packs[self.starts[tile as usize] as usize..self.starts[tile as usize + 1] as usize];
        places.iter().map(|&place| &packs[place as usize]).collect()
    }
}

/// Calls `visit` with the tiles that a pack meets.
fn for_each_tile(finder: &mut Finder, pack: &Footprint, side: u32, mut visit: impl FnMut(usize)) {
    finder.for_each_row(pack, side, 0..side, |Span { row, columns }| {
        columns.for_each(|column| visit((row * side + column) as usize));
    });
}

/// The cells of a tile, halved as long as it pays.
fn fill(packs: &[&(u32, Footprint)], tile: u32, side: u32, plan: &Plan) -> Filled {
    // Nothing is coarser than the least maps, so they are not made again.
    let is_least = plan.max_fineness == 0 && side == 1;
    if plan.budget.is_over() && !is_least {
        return Filled { fineness: 0, counts: vec![0], numbers: Vec::new() };
    }
    let tile = [tile % side, tile / side];
    let fineness = fineness(packs, tile, side, plan);
    if fineness == 0 {
        plan.budget.spend((packs.len() + 1) * size_of::<u32>());
        let numbers = packs.iter().map(|(number, _)| *number).collect();
        return Filled { fineness, counts: vec![packs.len() as u32], numbers };
    }
    let (within, mut finder) = (1 << fineness, Finder::default());
    let [first_column, first_row] = tile.map(|place| place * within);
    let mut counts = vec![0u32; (within * within) as usize];
    // The runs of cells that each pack meets.
    let mut met: Vec<(u32, Range<u32>)> = Vec::new();
    for (number, pack) in packs {
        finder.for_each_row(pack, side * within, first_row..first_row + within, |Span { row, columns }| {
            let start = (row - first_row) * within;
            let inside = columns.start.max(first_column)..columns.end.min(first_column + within);
            if !inside.is_empty() {
                let cells = start + inside.start - first_column..start + inside.end - first_column;
                counts[cells.start as usize..cells.end as usize].iter_mut().for_each(|count| *count += 1);
                met.push((*number, cells));
            }
        });
    }
    let total: usize = counts.iter().map(|&count| count as usize).sum();
    plan.budget.spend((total + counts.len()) * size_of::<u32>());
    if plan.budget.is_over() {
        return Filled { fineness: 0, counts: vec![0], numbers: Vec::new() };
    }
    let mut next: Vec<u32> = counts.iter().scan(0, |end, count| Some(std::mem::replace(end, *end + count))).collect();
    let mut numbers = vec![0; total];
    for (number, cells) in met {
        for at in &mut next[cells.start as usize..cells.end as usize] {
            numbers[*at as usize] = number;
            *at += 1;
        }
    }
    Filled { fineness, counts, numbers }
}

/// What a pack covers of a tile, for expecting how many of its cells it meets.
struct Cover {
    /// Columns and rows of the finest cells.
    cells: [Range<u32>; 2],
    /// The rectangle's sides, and what is covered of it; in tiles.
    size: [f64; 2],
    area: f64,
}

impl Cover {
    fn new(pack: &Footprint, tile: [u32; 2], side: u32) -> Option<Self> {
        let (reach, within) = (pack.reach()?, 1 << MAX_FINENESS);
        let cells = [0, 1].map(|axis| {
            let met = cells_between(reach[axis], side * within);
            let first = tile[axis] * within;
            met.start.clamp(first, first + within - 1) - first..met.end.clamp(first + 1, first + within) - first
        });
        let size = [0, 1].map(|axis| cells[axis].len() as f64 / f64::from(within));
        let whole = (reach[0][1] - reach[0][0]) * (reach[1][1] - reach[1][0]);
        let share = pack.area().map_or(1.0, |area| (area / whole).min(1.0));
        Some(Self { cells, size, area: share * size[0] * size[1] })
    }

    /// Of the cells that its rectangle meets as many as a convex shape of its area would: one of area a and sides w and h meets a·n² + (w + h)·n + 1 cells of
    /// a grid with n to a tile on average, its rectangle (w·n + 1)(h·n + 1) (the area of the sum with a cell).
    fn expected(&self, fineness: u8) -> f64 {
        let coarser = MAX_FINENESS - fineness;
        let [columns, rows] = [0, 1].map(|axis| {
            let Range { start, end } = self.cells[axis];
            f64::from(((end - 1) >> coarser) - (start >> coarser) + 1)
        });
        let (n, [w, h]) = (f64::from(1u32 << fineness), self.size);
        columns * rows * (self.area * n * n + (w + h) * n + 1.0) / ((w * n + 1.0) * (h * n + 1.0))
    }
}

/// How often a tile is halved: as long as rays are expected to save more than that costs.
fn fineness(packs: &[&(u32, Footprint)], tile: [u32; 2], side: u32, plan: &Plan) -> u8 {
    let rays = plan.rays / f64::from(side * side);
    let covers: Vec<Cover> = packs.iter().filter_map(|(_, pack)| Cover::new(pack, tile, side)).collect();
    let mut now = packs.len() as f64;
    (0..plan.max_fineness)
        .find(|&fineness| {
            let cells = f64::from(1u32 << (2 * fineness));
            let then: f64 = covers.iter().map(|cover| cover.expected(fineness + 1)).sum();
            let saved = rays * (now - then / 4.0) / cells;
            let costs = VISITS_A_NUMBER * (then - now + 3.0 * cells);
            now = then;
            saved <= costs
        })
        .unwrap_or(plan.max_fineness)
}
