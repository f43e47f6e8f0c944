//! Faces that may be looked at more closely, in the order of what that is worth.

use std::cmp::{Ordering, Reverse};

use umbriel_geometry::Approx;

use crate::sums::FaceArea;

/// Looking at a face at all costs about as much as so many cells.
const CELLS_A_LOOK: u64 = 32;

/// How many levels deeper a face is divided at its next look.
pub(super) const NEXT_LEVELS: u8 = 2;

/// A face of a receiver, by its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct FaceId {
    pub(super) receiver: u32,
    pub(super) face: u32,
}

/// What the last look at a face found.
#[derive(Debug)]
pub(super) struct Known {
    pub(super) level: u8,
    pub(super) examined: u64,
    /// Cells that it keeps, at least those that it examined.
    pub(super) stored: u64,
    pub(super) area: FaceArea,
}

/// A face that may be looked at more closely.
#[derive(Debug)]
pub(super) struct Open {
    pub(super) id: FaceId,
    /// Undecided area for an expected cell, square metres.
    pub(super) worth: f64,
    /// `None` before the first look: nothing but its area is known.
    pub(super) known: Option<Box<Known>>,
}

impl Open {
    pub(super) fn unknown(id: FaceId, area: Approx) -> Self {
        Self { id, worth: area.value / CELLS_A_LOOK as f64, known: None }
    }

    pub(super) fn known(id: FaceId, known: Known) -> Self {
        let mut open = Self { id, worth: known.area.undecided(), known: Some(Box::new(known)) };
        open.worth /= open.expected() as f64;
        open
    }

    /// Cells that the next look is expected to cost: along borders, twice as many a level.
    pub(super) fn expected(&self) -> u64 {
        CELLS_A_LOOK + self.known.as_ref().map_or(0, |known| known.examined << NEXT_LEVELS)
    }
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        self.worth.total_cmp(&other.worth).then_with(|| Reverse(self.id).cmp(&Reverse(other.id)))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}
