//! From the proofs of tiles to the verdicts of a quadtree: equal neighbours are joined upward.
//!
//! Four parts that are all lit make a lit cell, so the cells that are counted and stored are the largest that the proofs
//! give, in Morton order, as the division of faces would find them. Sums are whole numbers; the order does not matter.

use umbriel_octree::Quadrant;

use super::{
    Raster,
    tile::{Proofs, TILE, TilePlace, columns},
};
use crate::{
    fine::{
        flat::{count, count_samples},
        tally::{Measure, Tally, Units, cell_units},
    },
    report::Verdict,
};

/// What is known of a tile.
#[derive(Debug)]
pub(super) enum Outcome {
    /// No part of the face.
    Off,
    /// One verdict everywhere.
    Whole(Verdict),
    Mixed(Box<Tally<Units>>),
}

impl Outcome {
    /// A tile without borders and veils and with one winding.
    pub(super) fn clear(winding: i32) -> Self {
        match winding {
            0 => Self::Whole(Verdict::Lit),
            1.. => Self::Whole(Verdict::Shadowed),
            // Does not occur: windings count facets.
            _ => Self::Whole(Verdict::Undecided),
        }
    }
}

/// The cells of a tile by verdict; bit k of a row is column k.
pub(super) struct TileMasks {
    place: TilePlace,
    lit: [u64; TILE],
    shadowed: [u64; TILE],
    /// Undecided cells.
    pub(super) open: [u64; TILE],
    /// Cells of which only the lower half is on the face.
    pub(super) halves: [u64; TILE],
    /// Cells that are on the face.
    on_face: [u64; TILE],
}

impl TileMasks {
    pub(super) fn new(raster: &Raster, place: TilePlace, proofs: &Proofs) -> Self {
        let none = [0; TILE];
        let mut masks = Self { place, lit: none, shadowed: none, open: none, halves: none, on_face: none };
        for row in 0..place.size as usize {
            // Columns before this one are whole; on a triangle the next is a half.
            let whole = if raster.is_triangle() {
                (raster.cells() - 1 - place.row - row as i64 - place.column).clamp(-1, place.size)
            } else {
                place.size
            };
            let below = |end: i64| if end >= 64 { u64::MAX } else { (1u64 << end.max(0)) - 1 };
            masks.on_face[row] = below((whole + 1).min(place.size));
            masks.halves[row] = masks.on_face[row] & !below(whole);
            masks.lit[row] = proofs.lit[row] & masks.on_face[row];
            masks.shadowed[row] = proofs.shadowed[row] & masks.on_face[row];
            masks.open[row] = masks.on_face[row] & !masks.lit[row] & !masks.shadowed[row];
        }
        masks
    }

    /// Open cells turn out to be shadowed.
    pub(super) fn add_shadowed(&mut self, cells: &[u64; TILE]) {
        for (row, cells) in cells.iter().enumerate() {
            self.shadowed[row] |= cells & self.open[row];
            self.open[row] &= !cells;
        }
    }

    /// The outcome where one verdict is proved everywhere.
    pub(super) fn whole(&self) -> Option<Outcome> {
        let verdict = self.verdict([0, 0], self.place.size as usize)?;
        (verdict != Verdict::Undecided).then_some(Outcome::Whole(verdict))
    }

    /// The verdict that all cells of a square have that are on the face.
    fn verdict(&self, [column, row]: [usize; 2], edge: usize) -> Option<Verdict> {
        let columns = if edge == TILE { u64::MAX } else { ((1u64 << edge) - 1) << column };
        let all_in = |mask: &[u64; TILE]| (row..row + edge).all(|r| self.on_face[r] & columns & !mask[r] == 0);
        if all_in(&self.lit) {
            Some(Verdict::Lit)
        } else if all_in(&self.shadowed) {
            Some(Verdict::Shadowed)
        } else if edge == 1 {
            Some(Verdict::Undecided)
        } else {
            None
        }
    }

    /// Counts all cells; of the undecided ones it is known how many points are lit.
    pub(super) fn tally(&self, raster: &Raster, lit_points: &[u8]) -> Tally<Units> {
        let mut tally = Tally::new();
        let level = raster.levels.finest;
        let mut lit_points = lit_points.iter().map(|&points| u64::from(points));
        for row in 0..self.place.size as usize {
            tally.examined += u64::from(self.on_face[row].count_ones());
            for column in columns(self.open[row]) {
                let is_half = self.halves[row] >> column & 1 == 1;
                tally.points += 16;
                tally.likely += cell_units(level, is_half).part(lit_points.next().unwrap_or(0));
            }
        }
        if raster.levels.keep_cells || raster.lattice.is_some() {
            let up = (self.place.size as u64).trailing_zeros() as u8;
            let at = [self.place.column, self.place.row].map(|k| (k / self.place.size) as u32);
            if let Some(place) = Quadrant::at(level - up, at) {
                self.count_cells(raster, place, [0, 0], &mut tally);
            }
        } else {
            let units = |mask: &[u64; TILE]| {
                let ones = |row: usize| u64::from(mask[row].count_ones());
                let halves = |row: usize| u64::from((mask[row] & self.halves[row]).count_ones());
                (0..TILE)
                    .map(|row| {
                        (ones(row) - halves(row)) * cell_units(level, false) + halves(row) * cell_units(level, true)
                    })
                    .sum::<u64>()
            };
            (tally.lit, tally.shadowed, tally.undecided) = (units(&self.lit), units(&self.shadowed), units(&self.open));
        }
        tally
    }

    /// Counts the largest cells with one verdict, and their samples.
    fn count_cells(&self, raster: &Raster, place: Quadrant, corner: [usize; 2], tally: &mut Tally<Units>) {
        let edge = 1usize << (raster.levels.finest - place.level());
        if let Some(verdict) = self.verdict(corner, edge) {
            count(tally, raster.shape, place, verdict, raster.levels);
            raster.count_samples(tally, place, verdict);
            return;
        }
        for part in place.children().filter(|&part| raster.shape.domain.has(part)) {
            let [i, j] = part.coordinates().map(|k| k as usize & 1);
            self.count_cells(raster, part, [corner[0] + i * edge / 2, corner[1] + j * edge / 2], tally);
        }
    }
}

impl Raster<'_> {
    fn count_samples(&self, tally: &mut Tally<Units>, place: Quadrant, verdict: Verdict) {
        if verdict != Verdict::Undecided {
            return count_samples(tally, self.lattice, place, verdict);
        }
        let Some(lattice) = &self.lattice else { return };
        for [u, v] in lattice.points(place) {
            tally.samples.samples += 1;
            tally.samples.lit += u64::from((self.is_lit_exactly)(u, v));
            tally.points += 1;
        }
    }
}

/// The tiles of a face, and above them what they have in common.
pub(super) struct TileGrid<'a> {
    raster: &'a Raster<'a>,
    /// The level of the tiles.
    level: u8,
    /// Row by row.
    outcomes: Vec<Outcome>,
    /// For each level above the tiles the common verdict of each cell, row by row.
    above: Vec<Vec<Option<Verdict>>>,
}

impl<'a> TileGrid<'a> {
    pub(super) fn new(raster: &'a Raster<'a>, size: i64, outcomes: Vec<Outcome>) -> Self {
        let level = raster.levels.finest - (size as u64).trailing_zeros() as u8;
        let mut grid = Self { raster, level, outcomes, above: vec![Vec::new(); usize::from(level)] };
        for level in (0..level).rev() {
            let edge = 1u32 << level;
            let places = (0..edge).flat_map(|row| (0..edge).map(move |column| [column, row]));
            let cells = places.filter_map(|at| Quadrant::at(level, at)).map(|place| grid.joined(place));
            grid.above[usize::from(level)] = cells.collect();
        }
        grid
    }

    /// The common verdict of the parts of a cell.
    fn joined(&self, place: Quadrant) -> Option<Verdict> {
        let mut parts = self.raster.shape.domain.children(place).map(|part| self.verdict(part));
        let first = parts.next()??;
        parts.all(|part| part == Some(first)).then_some(first)
    }

    fn index(place: Quadrant) -> usize {
        let [column, row] = place.coordinates().map(|k| k as usize);
        (row << place.level()) + column
    }

    fn verdict(&self, place: Quadrant) -> Option<Verdict> {
        if place.level() < self.level {
            return self.above[usize::from(place.level())][Self::index(place)];
        }
        match self.outcomes[Self::index(place)] {
            Outcome::Whole(verdict) => Some(verdict),
            Outcome::Off | Outcome::Mixed(_) => None,
        }
    }

    /// The sums over the face.
    pub(super) fn finish(mut self) -> Tally<Units> {
        let mut tally = Tally::new();
        self.count(Quadrant::ROOT, &mut tally);
        tally
    }

    fn count(&mut self, place: Quadrant, tally: &mut Tally<Units>) {
        let raster = self.raster;
        tally.examined += 1;
        if let Some(verdict) = self.verdict(place) {
            count(tally, raster.shape, place, verdict, raster.levels);
            raster.count_samples(tally, place, verdict);
        } else if place.level() < self.level {
            for part in raster.shape.domain.children(place) {
                self.count(part, tally);
            }
        } else if let Outcome::Mixed(mixed) = std::mem::replace(&mut self.outcomes[Self::index(place)], Outcome::Off) {
            tally.append(*mixed);
        }
    }
}
