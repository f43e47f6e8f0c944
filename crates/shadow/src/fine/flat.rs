//! The fine step on one flat face: its parameter square, divided where blockers are still in question.
//!
//! A quadtree over (u, v); each part inherits the blockers that its parent could not settle. Cost: proportional to the
//! length of the shadow borders in cells, times the blockers that meet there.

use glam::DVec3;
use umbriel_geometry::{
    Point,
    blocking::Probe,
    decisions::{Level, count as count_decisions},
};
use umbriel_octree::{Face, Quadrant};

use super::{
    classify::{Blockers, Entry, Hull},
    field::Weights,
    lattice::Lattice,
    outline::ParamBox,
    pattern::{self, POINTS},
    tally::{Measure, Tally, Units, cell_units},
};
use crate::{
    effort::{PARTS, Spend},
    levels::length,
    report::{Cell, Verdict},
};

/// Corners of a flat receiver: first, second, (third or a repeat), last.
pub(crate) const FLAT: usize = 4;

/// From this many blockers in question, the parts of a cell are divided on several threads.
const PARALLEL_ENTRIES: usize = 256;

/// From this many blockers in question, it is sooner to look up those over a sample than to ask each.
const LOOK_UP_ENTRIES: usize = 256;

/// How deep to go on one face, and what to keep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Levels {
    /// Where cells stay undecided.
    pub(crate) finest: u8,
    /// The finest level at which decided cells are kept, if any are.
    pub(crate) interior: u8,
    /// Whether cells are kept, or sums only.
    pub(crate) keep_cells: bool,
    /// Where cells that are not yet at the finest level are small enough, too.
    pub(crate) pixel: Option<PixelStop>,
}

impl Levels {
    /// Whether a cell is kept.
    pub(crate) fn keeps(&self, place: Quadrant, verdict: Verdict) -> bool {
        self.keep_cells && (place.level() <= self.interior || verdict == Verdict::Undecided)
    }
}

/// Cells as small as a pixel are not divided.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelStop {
    pub(crate) eye: DVec3,
    /// Of a pixel at a distance of one metre.
    pub(crate) width: f64,
    /// Greatest distance of two points of a cell of level 0.
    pub(crate) reach: f64,
}

impl PixelStop {
    /// Whether the halves of a cell at this distance would be smaller than a pixel.
    pub(crate) fn is_met_at(&self, level: u8, distance: f64) -> bool {
        0.5 * self.reach_at(level) < self.width * distance
    }

    /// The same for a cell that holds this point, where it is farthest from the eye: so none of its points is in a cell smaller than a pixel there.
    pub(crate) fn is_met(&self, level: u8, point: DVec3) -> bool {
        self.is_met_at(level, length(point - self.eye) + self.reach_at(level))
    }

    fn reach_at(&self, level: u8) -> f64 {
        self.reach * 0.5f64.powi(i32::from(level))
    }
}

/// One face and all that may shadow it.
pub(crate) struct FlatFace<'a> {
    pub(crate) shape: FaceShape,
    pub(crate) corners: [Point<'a>; FLAT],
    pub(crate) blockers: Blockers<'a, FLAT>,
    pub(crate) levels: Levels,
    pub(crate) lattice: Option<Lattice>,
    /// The exact answer for one point: whether blocker `entry` blocks it.
    pub(crate) blocks_exactly: &'a (dyn Fn(&Blockers<FLAT>, Entry, &Probe) -> bool + Sync),
    /// The same for all blockers at once, by looking them up.
    pub(crate) is_blocked: &'a (dyn Fn(f64, f64) -> bool + Sync),
    pub(crate) spend: Spend<'a>,
}

/// Which face, and how its parameters run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceShape {
    pub(crate) face: u32,
    /// What its parameters run over.
    pub(crate) domain: Face,
    /// The corner from which the parameters are counted.
    pub(crate) corner: u8,
}

impl FaceShape {
    /// A cell as the hull of its corners.
    pub(crate) fn hull(&self, place: Quadrant) -> Hull<FLAT> {
        let mut parameters = ParamBox::EMPTY;
        let corners = self.domain.corners(place).map(|[u, v]| {
            parameters = parameters.with([u, v, u + v]);
            self.weights(u, v)
        });
        let [u, v] = self.middle(place);
        let mut hull = Hull::new(corners, self.weights(u, v));
        hull.parameters = Some(parameters);
        hull
    }

    /// The middle of a square; inside a half it is a dyadic too, so that weights stay exact.
    pub(crate) fn middle(&self, place: Quadrant) -> [f64; 2] {
        let inward = place.edge() * if self.domain.halves(place) { 0.25 } else { 0.5 };
        place.low_corner().map(|low| low + inward)
    }

    /// The weights of the corners at (u, v).
    pub(crate) fn weights(&self, u: f64, v: f64) -> Weights<FLAT> {
        if self.domain == Face::Triangle {
            [1.0 - u - v, u, 0.0, v]
        } else {
            [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v]
        }
    }
}

impl FlatFace<'_> {
    /// Classifies the whole face.
    pub(crate) fn run(&self) -> Tally<Units> {
        let mut tally = Tally::new();
        self.divide(Quadrant::ROOT, &self.blockers.entries(), &mut tally);
        tally
    }

    /// A face that is decided as a whole without looking at any blocker.
    pub(crate) fn decided(
        shape: FaceShape,
        verdict: Verdict,
        levels: Levels,
        lattice: Option<Lattice>,
    ) -> Tally<Units> {
        let mut tally = Tally::new();
        count(&mut tally, shape, Quadrant::ROOT, verdict, levels);
        count_samples(&mut tally, lattice, Quadrant::ROOT, verdict);
        tally
    }

    /// Classifies a cell, given the blockers in question over one that holds it.
    pub(crate) fn divide(&self, place: Quadrant, parent: &[Entry], tally: &mut Tally<Units>) {
        let levels = 1 + usize::from(self.levels.finest.saturating_sub(place.level()));
        self.divide_with(place, parent, &mut vec![Vec::new(); levels], tally);
    }

    /// The same with a list for each level from the cell's down to the finest, to be used again and again.
    fn divide_with(&self, place: Quadrant, parent: &[Entry], lists: &mut [Vec<Entry>], tally: &mut Tally<Units>) {
        tally.examined += 1;
        let (entries, deeper) = lists.split_first_mut().expect("a list for each level");
        entries.clear();
        let verdict = self.blockers.classify(&self.shape.hull(place), parent, entries);
        if verdict != Verdict::Undecided {
            count(tally, self.shape, place, verdict, self.levels);
            count_samples(tally, self.lattice, place, verdict);
        } else if self.is_finest(place) {
            count(tally, self.shape, place, verdict, self.levels);
            self.estimate(place, entries, tally);
            self.decide_samples(place, entries, tally);
            let work = self.blockers.work_of_points(entries);
            if work > 0 {
                // What is spent in vain ends at the next division.
                (self.spend)(work);
            }
        } else if !(self.spend)(PARTS * (1 + self.blockers.work(entries))) {
            // Nobody takes what is found.
        } else if entries.len() >= PARALLEL_ENTRIES {
            self.divide_in_parallel(place, entries, tally);
        } else {
            for part in self.shape.domain.children(place) {
                self.divide_with(part, entries, deeper, tally);
            }
        }
    }

    /// Whether an undecided cell stays so.
    pub(crate) fn is_finest(&self, place: Quadrant) -> bool {
        let is_a_pixel = |stop: PixelStop| {
            let [u, v] = place.low_corner();
            let corners = self.shape.weights(u, v).into_iter().zip(&self.corners);
            stop.is_met(place.level(), corners.map(|(weight, corner)| weight * corner.position).sum())
        };
        place.level() == self.levels.finest || self.levels.pixel.is_some_and(is_a_pixel)
    }

    fn divide_in_parallel(&self, place: Quadrant, entries: &[Entry], tally: &mut Tally<Units>) {
        use rayon::prelude::*;
        let parts: Vec<Quadrant> = self.shape.domain.children(place).collect();
        let parts: Vec<Tally<Units>> = parts
            .into_par_iter()
            .map(|part| {
                let mut tally = Tally::new();
                self.divide(part, entries, &mut tally);
                tally
            })
            .collect();
        parts.into_iter().for_each(|part| tally.append(part));
    }

    /// Looks at some points of an undecided cell.
    pub(crate) fn estimate(&self, place: Quadrant, entries: &[Entry], tally: &mut Tally<Units>) {
        let ([u, v], edge) = (place.low_corner(), place.edge());
        let is_half = self.shape.domain.halves(place);
        let mut points = [[0.0; POINTS]; 2];
        for (k, [s, t]) in pattern::points(place).enumerate() {
            // On a half cell, points beyond the long side are turned back into it.
            let [s, t] = if is_half && s + t > 1.0 { [1.0 - s, 1.0 - t] } else { [s, t] };
            [points[0][k], points[1][k]] = [u + s * edge, v + t * edge];
        }
        let weights = |k: usize| self.shape.weights(points[0][k], points[1][k]);
        let mut blocked = 0;
        for &entry in entries {
            blocked |= self.blockers.probably_blocked(entry, (&points, !blocked), weights);
            if blocked == u16::MAX {
                break;
            }
        }
        let lit = u64::from(blocked.count_zeros());
        tally.points += POINTS as u64;
        tally.likely += cell_units(place.level(), is_half).part(lit);
    }

    fn decide_samples(&self, place: Quadrant, entries: &[Entry], tally: &mut Tally<Units>) {
        let Some(lattice) = &self.lattice else { return };
        for [u, v] in lattice.points(place) {
            let blocked = match entries.len() {
                0..LOOK_UP_ENTRIES => entries.iter().any(|&entry| self.blocks(entry, u, v)),
                _ => (self.is_blocked)(u, v),
            };
            tally.samples.samples += 1;
            tally.samples.lit += u64::from(!blocked);
            tally.points += 1;
        }
    }

    /// Decides the samples of a cell by looking up what blocks them.
    pub(crate) fn look_samples_up(&self, place: Quadrant, tally: &mut Tally<Units>) {
        for [u, v] in self.lattice.iter().flat_map(|lattice| lattice.points(place)) {
            tally.samples.samples += 1;
            tally.samples.lit += u64::from(!(self.is_blocked)(u, v));
            tally.points += 1;
        }
    }

    fn blocks(&self, entry: Entry, u: f64, v: f64) -> bool {
        if let Some(blocks) = self.blockers.blocks(entry, &self.shape.weights(u, v)) {
            count_decisions(Level::Double, 1);
            return blocks;
        }
        (self.blocks_exactly)(&self.blockers, entry, &flat_probe(&self.corners, u, v))
    }
}

/// The point A + u·(B − A) + v·(D − A) of a face with corners A, B, …, D.
pub(crate) fn flat_probe<'a>(corners: &[Point<'a>], u: f64, v: f64) -> Probe<'a> {
    Probe::on_face([corners[0], corners[1], corners[corners.len() - 1]], u, v)
}

/// Counts a cell, and keeps it if cells of its kind are asked for.
pub(crate) fn count(tally: &mut Tally<Units>, shape: FaceShape, place: Quadrant, verdict: Verdict, levels: Levels) {
    let units = cell_units(place.level(), shape.domain.halves(place));
    match verdict {
        Verdict::Lit => tally.lit += units,
        Verdict::Shadowed => tally.shadowed += units,
        Verdict::Undecided => tally.undecided += units,
    }
    if levels.keeps(place, verdict) {
        tally.cells.push(Cell::new(shape.face, shape.corner, place, verdict));
    }
}

/// Counts the samples of a decided cell.
pub(crate) fn count_samples(tally: &mut Tally<Units>, lattice: Option<Lattice>, place: Quadrant, verdict: Verdict) {
    let Some(lattice) = lattice else { return };
    let samples = lattice.points(place).count() as u64;
    tally.samples.samples += samples;
    tally.samples.lit += if verdict == Verdict::Lit { samples } else { 0 };
}
