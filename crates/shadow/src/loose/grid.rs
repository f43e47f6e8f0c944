//! One view of a light, cut into tiles; each tile is made when the first point falls into it.
//!
//! Cost: some tens of nanoseconds a triangle to find its tiles.

use std::sync::{
    OnceLock,
    atomic::{AtomicU32, Ordering},
};

use crate::{
    light_space::{CornerError, View, greater, lesser},
    loose::{
        listed::{Window, see_listed},
        occupancy::Occupancy,
        order::in_order,
        pieces::Pieces,
        placed::{NOWHERE, Placed, see_all, union},
        tile::{Tile, side_for},
    },
};
use rayon::prelude::*;

/// About as many pieces share a tile.
const PIECES_A_TILE: f64 = 2048.0;
/// So many have one for themselves where no more points than this fall on each (what many points go through should lie together in memory) and the view is no longer than so many times its width.
const ONE_TILE: usize = 8192;
const POINTS_OF_ONE: f64 = 64.0;
const LONGEST: f64 = 4.0;
/// A tile that is made by several threads is made of parts of so many, eight to a group.
const PIECES_A_PART: usize = 1024;
/// Cells of a lamp's view that are wider than this have no sheets: less than twice the 16th by which a window is wider than where points may be.
const WIDEST_CELL: f64 = 1.0 / 10.0;
/// Points a triangle that pay for one more times as many cells; and where only triangles with points behind them are kept.
const POINTS_A_TRIANGLE: f64 = 16.0;
const POINTS_A_KEPT_TRIANGLE: f64 = 4.0;
/// This much of a tile lies beside all pieces on each side: more than the places of points are off by that are known well enough for tiles.
const BESIDE: f64 = 1.0 / 32.0;
/// At most so many tiles along a side.
const MAX_TILES: f64 = 256.0;
/// Pieces are given to tiles that they come this near, in tiles: more than cells are widened by, and than corners are off.
const TILE_MARGIN: f64 = 1.0 / 32.0;

/// Added to a number below 2^51 in size it leaves a whole number, the nearest one, in the low bits.
pub(super) const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;

/// The whole number, after [`WHOLE`] was added.
#[inline(always)]
pub(super) fn low_bits(sum: f64) -> u32 {
    sum.to_bits() as u32
}

/// One view, cut into tiles.
pub(super) struct Grid<'a> {
    pub(super) pieces: &'a Pieces<'a>,
    pub(super) view: View,
    pub(super) tiling: Tiling,
    /// Errors of corners in units of half a tile.
    error: CornerError,
    /// The pieces over each tile; those of a part before those of the next one.
    lists: Vec<List>,
    /// Cells along a side of each tile.
    sides: Vec<u32>,
    tiles: Vec<OnceLock<Tile>>,
}

/// How a view's plane is cut: numbers that a loop over points can keep in registers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tiling {
    /// Place of the first tile's corner.
    corner: [f64; 2],
    /// Tiles over a unit of u and v.
    pub(super) density: f64,
    /// Tiles along u and v.
    size: [usize; 2],
    /// Number of the first tile, and of what lies beside the tiles of all views: known once all views are cut.
    first: u32,
    beside: u32,
}

/// All views of a light: one of a sun, six of a lamp. The cells of all their tiles are numbered through, and so are the tiles.
pub(super) struct Grids<'a> {
    pub(super) grids: Vec<Grid<'a>>,
    /// The cells of each tile; behind all others one more, for what lies beside.
    places: Vec<TilePlace>,
    /// How many cells there are.
    pub(super) cells: u32,
    /// The greatest magnitude of a coordinate of the pieces.
    pub(super) size: f64,
    /// How often it was begun to look through all tiles.
    begun: AtomicU32,
}

impl<'a> Grids<'a> {
    /// Finds the tiles of all pieces in all views of a light, for so many points; where few of them fall may be known. `None` when 31 bits cannot number the cells.
    pub(super) fn of(
        pieces: &'a Pieces<'a>,
        views: Vec<View>,
        points: usize,
        occupancies: Option<&[Occupancy]>,
    ) -> Option<Self> {
        // The views of a lamp differ in their axes only.
        let error = views[0].error(pieces.slack, views[0].reach(&pieces.bounds));
        let seen = see_all(pieces, &views, error, occupancies);
        let pays = match occupancies {
            Some(_) => {
                let kept: usize = seen.iter().flatten().map(Vec::len).sum();
                points as f64 / (kept.max(1) as f64 * POINTS_A_KEPT_TRIANGLE)
            }
            None => points as f64 / (f64::from(pieces.len().max(1)) * POINTS_A_TRIANGLE),
        };
        let views = views.into_iter().zip(seen);
        let grid = |(view, seen)| Grid::of(pieces, view, seen, error, points, pays);
        let mut grids: Vec<Grid> = views.map(grid).collect();
        let (mut places, mut cells) = (Vec::new(), 0u32);
        for grid in &mut grids {
            grid.tiling.first = places.len() as u32;
            for &side in &grid.sides {
                let place = TilePlace { first: cells, side };
                places.push(place);
                cells = cells.checked_add(place.cells()).filter(|&cells| cells < 1 << 31)?;
            }
        }
        grids.iter_mut().for_each(|grid| grid.tiling.beside = places.len() as u32);
        places.push(TilePlace { first: cells, side: 1 });
        if let [Grid { tiles, .. }] = &*grids
            && let [tile] = &**tiles
        {
            // All points fall into it. Here all threads make it; where it is asked for they would wait.
            let _ = tile.set(grids[0].make(0, PIECES_A_PART));
        }
        Some(Self { grids, places, cells, size: pieces.bounds.magnitude(), begun: AtomicU32::new(0) })
    }

    /// The cells of a tile, as [`Tiling::locate`] numbers it.
    #[inline(always)]
    pub(super) fn place(&self, tile: u32) -> TilePlace {
        self.places[tile as usize]
    }

    /// The cells of each tile of a view.
    pub(super) fn places_of(&self, grid: &Grid) -> &[TilePlace] {
        &self.places[grid.tiling.first as usize..][..grid.tiles.len()]
    }

    /// Where to begin looking through all tiles, as a part of 2^32: each time far from where others are that began a little earlier, so that they do not wait
    /// for each other's tiles to be made (van der Corput's sequence).
    pub(super) fn begin(&self) -> u32 {
        self.begun.fetch_add(1, Ordering::Relaxed).reverse_bits()
    }
}

/// The cells of a tile: `side` along each side, from `first` on.
#[derive(Clone, Copy, Debug)]
pub(super) struct TilePlace {
    pub(super) first: u32,
    pub(super) side: u32,
}

impl TilePlace {
    /// How many.
    pub(super) fn cells(self) -> u32 {
        self.side * self.side
    }
}

impl Tiling {
    /// The number of the tile at (u, v), and where in it that is, from −1 to 1; where there is no tile, the number of what lies
    /// beside. Without branches.
    #[inline(always)]
    pub(super) fn locate(&self, u: f64, v: f64) -> (u32, [f32; 2]) {
        let place = |x: f64, axis: usize| (x - self.corner[axis]) * self.density - 0.5;
        let (x, y) = (place(u, 0), place(v, 1));
        // Rounded to whole numbers; what is too large for that lies beside, like NaN.
        let (column, row) = (x + WHOLE, y + WHOLE);
        let (along, across) = (column - WHOLE, row - WHOLE);
        let [columns, rows] = self.size.map(|size| size as f64);
        let (s, t) = ((2.0 * (x - along)) as f32, (2.0 * (y - across)) as f32);
        let is_inside = (along >= 0.0) & (across >= 0.0) & (along < columns) & (across < rows);
        let tile =
            low_bits(row).wrapping_mul(self.size[0] as u32).wrapping_add(low_bits(column)).wrapping_add(self.first);
        (if is_inside { tile } else { self.beside }, [s, t])
    }
}

/// Which of some pieces each tile has.
struct List {
    placed: Vec<Placed>,
    /// The first entry of each tile in `numbers`, and the end.
    starts: Vec<u32>,
    /// Which of the placed.
    numbers: Vec<u32>,
}

impl List {
    fn numbers(&self, tile: usize) -> &[u32] {
        &self.numbers[self.starts[tile] as usize..self.starts[tile + 1] as usize]
    }

    fn of_tile(&self, tile: usize) -> impl Iterator<Item = &Placed> {
        self.numbers(tile).iter().map(|&number| &self.placed[number as usize])
    }
}

impl<'a> Grid<'a> {
    /// Finds the tiles of what a view sees; `error` is that of corners. Points pay for so many times as many cells.
    fn of(pieces: &'a Pieces<'a>, view: View, seen: Vec<Vec<Placed>>, error: f64, points: usize, pays: f64) -> Self {
        let bounds = seen.iter().flatten().fold(NOWHERE, |all, placed| union(all, placed.bounds));
        let count: usize = seen.iter().map(Vec::len).sum();
        let (width, height) = ((bounds[2] - bounds[0]).max(0.0), (bounds[3] - bounds[1]).max(0.0));
        let largest = width.max(height);
        let are_few = count <= ONE_TILE && points as f64 <= POINTS_OF_ONE * count as f64;
        let is_one = are_few && largest <= LONGEST * width.min(height);
        let tiles = if is_one { 1.0 } else { (count as f64 / PIECES_A_TILE).clamp(1.0, MAX_TILES * MAX_TILES) };
        // One tile's side; when the view is a line, its length is cut.
        let side = (width * height / tiles).sqrt().max(largest / tiles.min(MAX_TILES));
        let side = if side > 0.0 { side / (1.0 - 2.0 * BESIDE) } else { 1.0 };
        let density = 1.0 / side;
        // A little less than what lies beside: the longest side of one tile must not round to two.
        let along = |length: f64| (length * density + 1.9 * BESIDE).floor() as usize + 1;
        let grid_size = if count == 0 { [0; 2] } else { [along(width), along(height)] };
        let corner = [bounds[0] - BESIDE * side, bounds[1] - BESIDE * side];
        let scale = if view.is_sun() { density } else { density.max(1.0) };
        let error = CornerError { place: 8.0 * scale * error, height: error * view.nearness_scale() };
        let mut grid = Self {
            pieces,
            view,
            tiling: Tiling { corner, density, size: grid_size, first: 0, beside: 0 },
            error,
            lists: Vec::new(),
            sides: Vec::new(),
            tiles: Vec::new(),
        };
        // Cells of a tile that has nothing on a part of it are as small as if it had.
        let area = width * height;
        let more = if is_one && area > 0.0 { side * side / area } else { 1.0 };
        grid.list(seen, pays, more);
        grid
    }

    /// How many pieces are listed in some tile.
    #[cfg(test)]
    pub(super) fn listed(&self) -> usize {
        let pieces = self.lists.iter().flat_map(|list| &list.placed).map(|placed| placed.piece);
        pieces.collect::<std::collections::HashSet<_>>().len()
    }

    /// A tile.
    pub(super) fn tile(&self, index: usize) -> &Tile {
        self.tiles[index].get_or_init(|| self.make(index, usize::MAX))
    }

    /// The tiles under a rectangle: first and last column, first and last row; there are [`MAX_TILES`] along a side, and two more.
    #[inline(always)]
    fn tiles_under(&self, bounds: &[f64; 4]) -> [u16; 4] {
        let Tiling { corner, density, size, .. } = self.tiling;
        let index = |k: usize, wide: f64| {
            let last = size[k % 2] as f64 - 1.0;
            lesser(greater((bounds[k] - corner[k % 2]) * density + wide, 0.0), last) as u16
        };
        [index(0, -TILE_MARGIN), index(2, TILE_MARGIN), index(1, -TILE_MARGIN), index(3, TILE_MARGIN)]
    }

    /// Which pieces each tile has; points pay for so many times as many cells.
    fn list(&mut self, seen: Vec<Vec<Placed>>, pays: f64, factor: f64) {
        let tiles = self.tiling.size[0] * self.tiling.size[1];
        self.lists = seen.into_par_iter().map(|placed| self.list_of(placed, tiles)).collect();
        let side = |tile: usize| {
            let count: usize = self.lists.iter().map(|list| list.numbers(tile).len()).sum();
            side_for(count as f64 * factor, pays)
        };
        self.sides = (0..tiles).map(side).collect();
        self.tiles = (0..tiles).map(|_| OnceLock::new()).collect();
    }

    /// The same of some pieces, by counting.
    fn list_of(&self, placed: Vec<Placed>, tiles: usize) -> List {
        if tiles == 1 {
            let count = placed.len() as u32;
            return List { placed, starts: vec![0, count], numbers: (0..count).collect() };
        }
        let under: Vec<[u16; 4]> = placed.iter().map(|placed| self.tiles_under(&placed.bounds)).collect();
        let mut starts = vec![0u32; tiles + 1];
        under.iter().for_each(|&under| self.for_each_tile(under, |tile| starts[tile + 1] += 1));
        for tile in 0..tiles {
            starts[tile + 1] += starts[tile];
        }
        let (mut next, mut numbers) = (starts.clone(), vec![0; starts[tiles] as usize]);
        for (number, &under) in under.iter().enumerate() {
            self.for_each_tile(under, |tile| {
                numbers[next[tile] as usize] = number as u32;
                next[tile] += 1;
            });
        }
        List { placed, starts, numbers }
    }

    #[inline(always)]
    fn for_each_tile(&self, under: [u16; 4], mut visit: impl FnMut(usize)) {
        let [left, right, low, high] = under.map(usize::from);
        for row in low..=high {
            for column in left..=right {
                visit(row * self.tiling.size[0] + column);
            }
        }
    }

    /// Cells of one tile, by threads that take so many pieces at a time.
    fn make(&self, index: usize, at_a_time: usize) -> Tile {
        let placed: Vec<&Placed> = self.lists.iter().flat_map(|list| list.of_tile(index)).collect();
        let side = self.sides[index];
        let Tiling { corner, density, size: [columns, _], .. } = self.tiling;
        let window = Window {
            view: &self.view,
            corner,
            density: 2.0 * density,
            middle: [index % columns, index / columns].map(|index| (2 * index + 1) as f64),
            error: self.error,
            cells: 0.5 * side as f32,
            // A lamp's view ends soon behind its points: no middle of a cell with points may lie beyond.
            with_surfaces: self.view.is_sun() || density * f64::from(side) >= 1.0 / WIDEST_CELL,
        };
        let order = in_order(&placed, &window);
        let parts = order.par_chunks(at_a_time).map(|list| see_listed(window, self.pieces, list));
        Tile::of(parts.collect(), side, self.view.unit())
    }
}
