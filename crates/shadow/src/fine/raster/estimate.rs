//! The lit share of undecided cells: the winding at 16 points of each.
//!
//! It is that at the cell's middle, changed by every segment that the straight way to the point crosses; only segments that
//! touch the cell can be. In f32 from the middle of the cell; an estimate, not a proof. About 20 ns for a segment and cell.

use umbriel_octree::Quadrant;

use super::{
    Raster,
    blocks::Blocks,
    segments::Segment,
    tile::{TILE, Tile, TilePlace, columns},
};
use crate::fine::pattern;

/// Points a cell.
const POINTS: usize = 16;

/// The points of a cell, from its middle, in cells.
struct CellPoints {
    x: [f32; POINTS],
    y: [f32; POINTS],
}

/// The windings at the points of a cell.
type Windings = [i32; POINTS];

/// An undecided cell.
pub(super) struct OpenCell {
    points: CellPoints,
    windings: Windings,
}

/// The crossings in the cells of a tile, of segments that are forgotten.
pub(crate) struct Crossings {
    /// Which of `cells` each cell is, row by row; [`NONE`] where no segment touches it.
    places: Vec<u16>,
    cells: Changes,
}

/// Changes from the winding of the middle, cell by cell. Points are found anew for each segment: they would take eight times as much memory.
enum Changes {
    /// As long as a byte holds each: so it is but where very much is crowded over a cell.
    Narrow(Blocks<[i8; POINTS], BLOCK>),
    Wide(Blocks<Windings, BLOCK>),
}

/// Cells of a block.
const BLOCK: usize = 64;

/// No cell of a tile has this number.
const NONE: u16 = u16::MAX;

impl Crossings {
    /// No segment yet.
    pub(crate) fn new() -> Self {
        Self { places: vec![NONE; TILE * TILE], cells: Changes::Narrow(Blocks::default()) }
    }

    /// Takes the crossings of a segment in a cell that it touches into account; the cell's middle is on its left or not.
    pub(crate) fn add(
        &mut self,
        raster: &Raster,
        place: TilePlace,
        cell: [usize; 2],
        segment: &Segment,
        is_left: bool,
    ) {
        let Some(points) = CellPoints::new(raster, place, cell) else { return };
        let number = &mut self.places[cell[0] * TILE + cell[1]];
        if *number == NONE {
            *number = self.cells.push();
        }
        let mut changes = [0; POINTS];
        points.cross_about(place.middle(cell), (segment, is_left), &mut changes);
        self.cells.add(*number, &changes);
    }

    /// How many of the points of each cell of `open` are lit, in the order of rows and columns; `carry` is the winding at the left of the tile's rows.
    pub(crate) fn lit_points(&self, tile: &Tile, open: &[u64; TILE], carry: &[i32; TILE]) -> Vec<u8> {
        let mut lit = Vec::new();
        for (row, &bits) in open.iter().enumerate().filter(|(_, bits)| **bits != 0) {
            let windings = tile.windings(row, carry[row]);
            let windings_at = |column: usize| self.of(row, column).map(|change| windings[column] + change);
            lit.extend(columns(bits).map(|column| lit_of(&windings_at(column))));
        }
        lit
    }

    /// The changes in a cell; none where nothing touches it.
    fn of(&self, row: usize, column: usize) -> Windings {
        match self.places[row * TILE + column] {
            NONE => [0; POINTS],
            place => self.cells.get(place),
        }
    }
}

fn lit_of(windings: &Windings) -> u8 {
    windings.iter().filter(|&&winding| winding <= 0).count() as u8
}

impl Changes {
    /// One more cell; answers its place.
    fn push(&mut self) -> u16 {
        let place = match self {
            Self::Narrow(cells) => cells.push([0; POINTS]),
            Self::Wide(cells) => cells.push([0; POINTS]),
        };
        place as u16
    }

    fn get(&self, place: u16) -> Windings {
        match self {
            Self::Narrow(cells) => cells[usize::from(place)].map(i32::from),
            Self::Wide(cells) => cells[usize::from(place)],
        }
    }

    fn add(&mut self, place: u16, changes: &Windings) {
        let mut sums = self.get(place);
        sums.iter_mut().zip(changes).for_each(|(sum, change)| *sum += change);
        if let Self::Narrow(cells) = self {
            if sums.iter().all(|&sum| i8::try_from(sum).is_ok()) {
                cells[usize::from(place)] = sums.map(|sum| sum as i8);
                return;
            }
            *self = Self::Wide(cells.map(|cell| cell.map(i32::from)));
        }
        if let Self::Wide(cells) = self {
            cells[usize::from(place)] = sums;
        }
    }
}

impl OpenCell {
    /// At a row and a column of a tile, with the winding of its middle; without points off the face.
    pub(super) fn new(raster: &Raster, place: TilePlace, cell: [usize; 2], winding: i32) -> Option<Self> {
        CellPoints::new(raster, place, cell).map(|points| Self { points, windings: [winding; POINTS] })
    }

    /// Takes a segment's crossings into account, that has the cell's middle on its left or not.
    pub(super) fn cross(&mut self, middle: [f64; 2], segment: &Segment, is_left: bool) {
        self.points.cross_about(middle, (segment, is_left), &mut self.windings);
    }

    /// How many of its points are lit.
    pub(super) fn lit_points(&self) -> u8 {
        lit_of(&self.windings)
    }
}

impl CellPoints {
    /// Of the cell at a row and a column of a tile; `None` off the face.
    fn new(raster: &Raster, place: TilePlace, [row, column]: [usize; 2]) -> Option<Self> {
        let place = [place.column + column as i64, place.row + row as i64];
        let beyond = place[0] + place[1] - (raster.cells() - 1);
        if raster.is_triangle() && beyond > 0 {
            return None;
        }
        let is_half = raster.is_triangle() && beyond == 0;
        let cell = Quadrant::at(raster.levels.finest, place.map(|k| k as u32))?;
        let mut points = Self { x: [0.0; POINTS], y: [0.0; POINTS] };
        for (k, point) in pattern::points(cell).enumerate() {
            // On a half cell, points beyond the long side are turned back into it.
            let [s, t] = if is_half && point[0] + point[1] > 1.0 { point.map(|c| 1.0 - c) } else { point };
            (points.x[k], points.y[k]) = ((s - 0.5) as f32, (t - 0.5) as f32);
        }
        Some(points)
    }

    /// As [`CellPoints::cross`], by a segment of a face with the cell's middle on it.
    fn cross_about(&self, middle: [f64; 2], (segment, is_left): (&Segment, bool), windings: &mut Windings) {
        let local = |point: [f64; 2]| [0, 1].map(|k| (point[k] - middle[k]) as f32);
        let change = if is_left { -segment.net } else { segment.net };
        self.cross(local(segment.from), local(segment.to), change, windings);
    }

    /// Changes the windings where the segment from a to b comes between the middle and the point. The change is negative
    /// where the middle is on its left.
    fn cross(&self, a: [f32; 2], b: [f32; 2], change: i32, windings: &mut Windings) {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let left = dy * a[0] - dx * a[1];
        let is_left = change < 0;
        for (winding, (&x, &y)) in windings.iter_mut().zip(self.x.iter().zip(&self.y)) {
            let is_other_side = is_left != (left + dx * y - dy * x > 0.0);
            let is_between = (x * a[1] - y * a[0] > 0.0) != (x * b[1] - y * b[0] > 0.0);
            *winding += if is_other_side & is_between { change } else { 0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_that_a_byte_does_not_hold_are_kept_all_the_same() {
        let mut changes = Changes::Narrow(Blocks::default());
        let places = [changes.push(), changes.push()];
        let step: Windings = std::array::from_fn(|k| k as i32 - 8);
        for count in 1..=20 {
            changes.add(places[1], &step);
            assert_eq!(changes.get(places[1]), step.map(|change| change * count));
            // Eight times sixteen below nothing is the last that fits.
            assert_eq!(matches!(changes, Changes::Narrow(_)), count <= 16);
        }
        let last = changes.push();
        changes.add(last, &step);
        assert_eq!([places[0], last].map(|place| changes.get(place)), [[0; POINTS], step]);
    }
}
