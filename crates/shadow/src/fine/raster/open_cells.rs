//! The cells of a tile that its marks leave open: what the segments through each make of it.
//!
//! While segments are drawn it is noted which cells they touch ([`Touches`]). An open cell whose regions are all covered is shadowed
//! ([`lowest`](super::lowest)); of each other one 16 points say how much is likely lit ([`estimate`](super::estimate)).

use super::{
    Raster,
    estimate::OpenCell,
    lowest::{MOST_SEGMENTS, Met, Surroundings},
    tile::{TILE, Tile, columns},
};

/// Touches of a tile that are noted at most, 8 bytes each: where there are more, hardly any cell could be told by its regions.
const MOST_TOUCHES: usize = 1 << 18;

/// What is found out about the open cells of a tile.
pub(super) struct Found {
    /// Open cells that are shadowed after all.
    pub(super) shadowed: [u64; TILE],
    /// How many points of each of the others are lit, in the order of rows and columns.
    pub(super) lit_points: Vec<u8>,
}

/// Which segments touch which cells of a tile.
#[derive(Debug, Default)]
pub(super) struct Touches {
    /// Cells, row by row, and what touches them.
    all: Vec<(u16, Touch)>,
    are_too_many: bool,
    /// Those of open cells, cell by cell, and where those of each cell stop.
    by_cell: Vec<Touch>,
    stops: Vec<u32>,
}

/// A segment by its number in the tile, and in the lowest bit whether it has the cell's middle on its left, as the windings count it.
#[derive(Clone, Copy, Debug, Default)]
struct Touch(u32);

/// Some cells of a tile in the order of rows and columns.
struct Places {
    cells: [u64; TILE],
    /// How many cells come before each row.
    before: [usize; TILE],
}

impl Touch {
    fn segment(self) -> usize {
        (self.0 >> 1) as usize
    }

    fn is_left(self) -> bool {
        self.0 & 1 == 1
    }
}

impl Found {
    /// No more than how many points are lit.
    pub(super) fn points(lit_points: Vec<u8>) -> Self {
        Self { shadowed: [0; TILE], lit_points }
    }
}

impl Touches {
    /// None yet.
    pub(super) fn clear(&mut self) {
        self.all.clear();
        self.are_too_many = false;
    }

    /// Notes that a segment touches the cell at a row and a column.
    #[inline]
    pub(super) fn add(&mut self, segment: u32, [row, column]: [usize; 2], is_left: bool) {
        if self.all.len() == MOST_TOUCHES {
            self.are_too_many = true;
        } else {
            self.all.push(((row * TILE + column) as u16, Touch(segment << 1 | u32::from(is_left))));
        }
    }

    /// Whether some are not noted.
    pub(super) fn are_too_many(&self) -> bool {
        self.are_too_many
    }

    /// Brings those of open cells into the order of these. A counting sort.
    fn sort(&mut self, open: &[u64; TILE]) {
        let Self { all, by_cell, stops, .. } = self;
        let places = Places::of(open);
        let of_open = all.iter().filter_map(|&(cell, touch)| Some((places.of_cell(usize::from(cell))?, touch)));
        stops.clear();
        stops.resize(places.count() + 1, 0);
        of_open.clone().for_each(|(place, _)| stops[place + 1] += 1);
        for place in 1..stops.len() {
            stops[place] += stops[place - 1];
        }
        by_cell.clear();
        by_cell.resize(stops[stops.len() - 1] as usize, Touch::default());
        for (place, touch) in of_open {
            // Each start moves to its stop.
            by_cell[stops[place] as usize] = touch;
            stops[place] += 1;
        }
    }

    /// Those of each open cell.
    fn of_cells(&self) -> impl Iterator<Item = &[Touch]> {
        let starts = std::iter::once(0).chain(self.stops.iter().copied());
        starts.zip(&self.stops).map(|(start, &stop)| &self.by_cell[start as usize..stop as usize])
    }
}

impl Places {
    fn of(cells: &[u64; TILE]) -> Self {
        let mut places = Self { cells: *cells, before: [0; TILE] };
        for row in 1..TILE {
            places.before[row] = places.before[row - 1] + cells[row - 1].count_ones() as usize;
        }
        places
    }

    /// How many there are.
    fn count(&self) -> usize {
        self.before[TILE - 1] + self.cells[TILE - 1].count_ones() as usize
    }

    /// Which of them a cell is, if it is one.
    #[inline]
    fn of_cell(&self, cell: usize) -> Option<usize> {
        let (row, column) = (cell / TILE, cell % TILE);
        let is_among = self.cells[row] >> column & 1 == 1;
        is_among.then(|| self.before[row] + (self.cells[row] & ((1 << column) - 1)).count_ones() as usize)
    }
}

/// Looks at the cells `open` of a tile; `carry` is the winding at the left of its rows. Where these are all `segments`, regions are asked, else points alone.
pub(super) fn look(
    raster: &Raster,
    tile: &Tile,
    (open, carry): (&[u64; TILE], &[i32; TILE]),
    (segments, touches): (&[Met], &mut Touches),
    are_all: bool,
) -> Found {
    touches.sort(open);
    let mut found = Found::points(Vec::new());
    let mut surroundings = Surroundings::default();
    let mut of_cells = touches.of_cells();
    for (row, &bits) in open.iter().enumerate().filter(|(_, bits)| **bits != 0) {
        let windings = tile.windings(row, carry[row]);
        for (column, touches) in columns(bits).zip(&mut of_cells) {
            let (cell, winding) = ([row, column], windings[column]);
            let Some(mut open_cell) = OpenCell::new(raster, tile.place, cell, winding) else { continue };
            let (middle, of_cell) = (tile.place.middle(cell), touches.iter().map(|touch| segments[touch.segment()]));
            for (touch, (segment, _)) in touches.iter().zip(of_cell.clone()) {
                open_cell.cross(middle, segment, touch.is_left());
            }
            let lit_points = open_cell.lit_points();
            // A lit point is not proved, but there is little hope then.
            let is_hopeful = are_all && lit_points == 0 && (2..=MOST_SEGMENTS).contains(&touches.len());
            if is_hopeful && surroundings.are_covered(middle, winding, of_cell) {
                found.shadowed[row] |= 1 << column;
            } else {
                found.lit_points.push(lit_points);
            }
        }
    }
    found
}
