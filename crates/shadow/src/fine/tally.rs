//! What the cells of one face add up to, in whole numbers where a face is flat.
//!
//! A flat face's cells are fractions 4^-level of its parameter square, so shares are counted exactly in units of
//! 4^-[`UNIT_LEVEL`]; the area enters once, with its bound. Curved cells carry areas of their own.

use umbriel_geometry::Approx;

use crate::report::{Cell, SampleCount, Verdict};

/// The level of the unit; finer cells do not occur (21 levels of the octree, faces no larger than its root).
const UNIT_LEVEL: u32 = 29;

/// A measure of surface: whole units for flat faces, square metres for curved ones.
pub(crate) trait Measure: Clone + Send {
    /// Nothing.
    fn zero() -> Self;
    /// Adds another measure.
    fn add(&mut self, other: &Self);
    /// `sixteenths` of 16 parts.
    fn part(&self, sixteenths: u64) -> Self;
}

/// Units of 4^-UNIT_LEVEL of a parameter square.
pub(crate) type Units = u64;

/// The units of a square cell, or of the half cell at a triangle's long side.
pub(crate) fn cell_units(level: u8, is_half: bool) -> Units {
    (1 << (2 * (UNIT_LEVEL - u32::from(level)))) >> u32::from(is_half)
}

impl Measure for Units {
    fn zero() -> Self {
        0
    }
    fn add(&mut self, other: &Self) {
        *self += other;
    }
    fn part(&self, sixteenths: u64) -> Self {
        self / 16 * sixteenths
    }
}

impl Measure for Approx {
    fn zero() -> Self {
        Approx::exact(0.0)
    }
    fn add(&mut self, other: &Self) {
        *self = *self + *other;
    }
    fn part(&self, sixteenths: u64) -> Self {
        *self * Approx::exact(sixteenths as f64 / 16.0)
    }
}

/// The sums over a face, and its stored cells.
#[derive(Clone, Debug)]
pub(crate) struct Tally<M> {
    pub(crate) lit: M,
    pub(crate) shadowed: M,
    pub(crate) undecided: M,
    /// The part of `undecided` that is lit by the estimate.
    pub(crate) likely: M,
    pub(crate) cells: Vec<Cell>,
    pub(crate) samples: SampleCount,
    /// Cells examined.
    pub(crate) examined: u64,
    /// Points decided one by one.
    pub(crate) points: u64,
    /// What the look cost.
    pub(crate) cost: Cost,
    /// Whether some is undecided because only some of what is over the face was measured.
    pub(crate) is_crowded: bool,
}

/// How deep a look at a face went and what that cost, in cells of a quadtree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Cost {
    /// The finest level of its cells.
    pub(crate) level: u8,
    /// What it costs however deep it goes: measuring what may shadow the face.
    pub(crate) base: u64,
    /// What cells cost along the borders of shadows: twice as much a level.
    pub(crate) cells: u64,
}

impl<M: Measure> Tally<M> {
    /// All of it is in shadow after all: no light reaches the object.
    pub(crate) fn darken(&mut self) {
        let Self { lit, shadowed, undecided, .. } = self;
        shadowed.add(lit);
        shadowed.add(undecided);
        (self.lit, self.undecided, self.likely) = (M::zero(), M::zero(), M::zero());
        self.cells.iter_mut().for_each(|cell| cell.verdict = Verdict::Shadowed);
        self.samples.lit = 0;
    }

    /// Nothing counted yet.
    pub(crate) fn new() -> Self {
        Self {
            lit: M::zero(),
            shadowed: M::zero(),
            undecided: M::zero(),
            likely: M::zero(),
            cells: Vec::new(),
            samples: SampleCount::default(),
            examined: 0,
            points: 0,
            cost: Cost::default(),
            is_crowded: false,
        }
    }

    /// Appends what another tally counted after this one.
    pub(crate) fn append(&mut self, mut other: Self) {
        self.lit.add(&other.lit);
        self.shadowed.add(&other.shadowed);
        self.undecided.add(&other.undecided);
        self.likely.add(&other.likely);
        self.cells.append(&mut other.cells);
        self.samples.samples += other.samples.samples;
        self.samples.lit += other.samples.lit;
        self.examined += other.examined;
        self.points += other.points;
        self.is_crowded |= other.is_crowded;
    }
}
