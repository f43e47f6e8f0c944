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
        pieces::Pieces,
        placed::{NOWHERE, Part, Placed, see_all, union},
        tile::{Tile, side_for},
    },
};
use rayon::prelude::*;

/// About as many pieces share a tile.
const PIECES_A_TILE: f64 = 2048.0;
/// At most so many tiles along a side.
const MAX_TILES: f64 = 256.0;
/// Pieces are given to tiles that they come this near, in tiles: more than cells are widened by, and than corners are off.
const TILE_MARGIN: f64 = 1.0 / 32.0;

/// Added to a number below 2^51 in size it leaves a whole number, the nearest one, in the low bits.
const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;

/// The whole number, after [`WHOLE`] was added.
#[inline(always)]
fn low_bits(sum: f64) -> u32 {
    sum.to_bits() as u32
}

/// One view, cut into tiles.
pub(super) struct Grid<'a> {
    pub(super) pieces: &'a Pieces<'a>,
    pub(super) view: View,
    /// Place of the first tile's corner.
    corner: [f64; 2],
    /// Tiles over a unit of u and v.
    pub(super) density: f64,
    /// Tiles along u and v.
    size: [usize; 2],
    /// Errors of corners in units of half a tile.
    error: CornerError,
    /// The pieces over each tile; those of a part before those of the next one.
    lists: Vec<List>,
    /// One a tile, and one more for what lies beside all.
    places: Vec<TilePlace>,
    tiles: Vec<OnceLock<Tile>>,
}

/// All views of a light: one of a sun, six of a lamp. The cells of all their tiles are numbered through.
pub(super) struct Grids<'a> {
    pub(super) grids: Vec<Grid<'a>>,
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
        let occupancy = |view: usize| occupancies.map(|of_views| &of_views[view]);
        let views = views.into_iter().enumerate();
        let mut grids: Vec<Grid> =
            views.map(|(number, view)| Grid::of(pieces, view, points, occupancy(number))).collect();
        let mut cells = 0u32;
        for grid in &mut grids {
            let (_, places) = grid.places.split_last_mut()?;
            for place in places {
                place.first = cells;
                cells = cells.checked_add(place.cells()).filter(|&cells| cells < 1 << 31)?;
            }
        }
        grids.iter_mut().filter_map(|grid| grid.places.last_mut()).for_each(|beside| beside.first = cells);
        Some(Self { grids, cells, size: pieces.bounds.magnitude(), begun: AtomicU32::new(0) })
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

/// Which of some pieces each tile has.
struct List {
    /// The first entry of each tile in `pieces`, and the end.
    starts: Vec<u32>,
    pieces: Vec<u32>,
}

impl List {
    fn of_tile(&self, tile: usize) -> &[u32] {
        &self.pieces[self.starts[tile] as usize..self.starts[tile + 1] as usize]
    }
}

impl<'a> Grid<'a> {
    /// Finds the tiles of all pieces, or of those over points.
    fn of(pieces: &'a Pieces<'a>, view: View, points: usize, occupancy: Option<&Occupancy>) -> Self {
        let error = view.error(pieces.slack, view.reach(&pieces.bounds));
        let seen = see_all(pieces, &view, error, occupancy);
        let bounds = seen.iter().fold(NOWHERE, |all, part| union(all, part.bounds));
        let count: usize = seen.iter().map(|part| part.placed.len()).sum();
        let (width, height) = ((bounds[2] - bounds[0]).max(0.0), (bounds[3] - bounds[1]).max(0.0));
        let tiles = (count as f64 / PIECES_A_TILE).clamp(1.0, MAX_TILES * MAX_TILES);
        let largest = width.max(height);
        // One tile's side; when the view is a line, its length is cut.
        let side = (width * height / tiles).sqrt().max(largest / tiles.min(MAX_TILES));
        let side = if side > 0.0 { side } else { 1.0 };
        let density = 1.0 / side;
        let along = |length: f64| (length * density + 1.0).floor() as usize + 1;
        let grid_size = if count == 0 { [0; 2] } else { [along(width), along(height)] };
        // Half a tile of nothing all round.
        let corner = [bounds[0] - 0.5 * side, bounds[1] - 0.5 * side];
        let scale = if view.is_sun() { density } else { density.max(1.0) };
        let error = CornerError { place: 8.0 * scale * error, height: error * view.nearness_scale() };
        let mut grid = Self {
            pieces,
            view,
            corner,
            density,
            size: grid_size,
            error,
            lists: Vec::new(),
            places: Vec::new(),
            tiles: Vec::new(),
        };
        grid.list(&seen, points as f64 / f64::from(pieces.len().max(1)));
        grid
    }

    /// How many pieces are listed in some tile.
    #[cfg(test)]
    pub(super) fn listed(&self) -> usize {
        let pieces = self.lists.iter().flat_map(|list| &list.pieces);
        pieces.collect::<std::collections::HashSet<_>>().len()
    }

    /// Where the cells of each tile are.
    pub(super) fn places(&self) -> &[TilePlace] {
        &self.places[..self.tiles.len()]
    }

    /// Where the cells of a tile are, as [`Self::locate`] numbers it.
    #[inline(always)]
    pub(super) fn place(&self, tile: u32) -> TilePlace {
        self.places[tile as usize]
    }

    /// A tile.
    pub(super) fn tile(&self, index: usize) -> &Tile {
        self.tiles[index].get_or_init(|| self.make(index))
    }

    /// The number of the tile at (u, v), and where in it that is, from −1 to 1; beside all tiles, where there is nothing, the number behind the
    /// last one. Without branches.
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
        let tile = low_bits(row).wrapping_mul(self.size[0] as u32).wrapping_add(low_bits(column));
        (if is_inside { tile } else { self.tiles.len() as u32 }, [s, t])
    }

    /// The tiles under a rectangle: first and last column, first and last row; there are [`MAX_TILES`] along a side, and two more.
    #[inline(always)]
    fn tiles_under(&self, bounds: &[f64; 4]) -> [u16; 4] {
        let index = |k: usize, wide: f64| {
            let last = self.size[k % 2] as f64 - 1.0;
            lesser(greater((bounds[k] - self.corner[k % 2]) * self.density + wide, 0.0), last) as u16
        };
        [index(0, -TILE_MARGIN), index(2, TILE_MARGIN), index(1, -TILE_MARGIN), index(3, TILE_MARGIN)]
    }

    /// Which pieces each tile has.
    fn list(&mut self, seen: &[Part], points_a_piece: f64) {
        let tiles = self.size[0] * self.size[1];
        self.lists = seen.par_iter().map(|part| self.list_of(&part.placed, tiles)).collect();
        let place = |tile: usize| {
            let count = self.lists.iter().map(|list| list.of_tile(tile).len()).sum();
            TilePlace { first: 0, side: side_for(count, points_a_piece) }
        };
        let beside = TilePlace { first: 0, side: 1 };
        self.places = (0..tiles).map(place).chain([beside]).collect();
        self.tiles = (0..tiles).map(|_| OnceLock::new()).collect();
    }

    /// The same of some pieces, by counting.
    fn list_of(&self, seen: &[Placed], tiles: usize) -> List {
        let under: Vec<[u16; 4]> = seen.iter().map(|placed| self.tiles_under(&placed.bounds)).collect();
        let mut starts = vec![0u32; tiles + 1];
        under.iter().for_each(|&under| self.for_each_tile(under, |tile| starts[tile + 1] += 1));
        for tile in 0..tiles {
            starts[tile + 1] += starts[tile];
        }
        let (mut next, mut pieces) = (starts.clone(), vec![0; starts[tiles] as usize]);
        for (placed, &under) in seen.iter().zip(&under) {
            self.for_each_tile(under, |tile| {
                pieces[next[tile] as usize] = placed.piece;
                next[tile] += 1;
            });
        }
        List { starts, pieces }
    }

    #[inline(always)]
    fn for_each_tile(&self, under: [u16; 4], mut visit: impl FnMut(usize)) {
        let [left, right, low, high] = under.map(usize::from);
        for row in low..=high {
            for column in left..=right {
                visit(row * self.size[0] + column);
            }
        }
    }

    /// Cells of one tile.
    fn make(&self, index: usize) -> Tile {
        let list: Vec<u32> = self.lists.iter().flat_map(|list| list.of_tile(index)).copied().collect();
        let side = self.places[index].side;
        let window = Window {
            view: &self.view,
            corner: self.corner,
            density: 2.0 * self.density,
            middle: [index % self.size[0], index / self.size[0]].map(|index| (2 * index + 1) as f64),
            error: self.error,
            margin: 2.0 * TILE_MARGIN,
            cells: 0.5 * side as f32,
        };
        let listed = see_listed(window, self.pieces, &list);
        Tile::of(&listed, side, self.view.unit())
    }
}
