//! Faces that may be looked at more closely, in the order of what that is worth.

use std::cmp::{Ordering, Reverse};

use umbriel_geometry::Approx;

use crate::{fine::tally::Cost, sums::FaceArea};

/// Looking at a face at all costs about as much as so many cells.
const CELLS_A_LOOK: u64 = 32;

/// How many levels deeper a face is divided at its next look, at least.
const NEXT_LEVELS: u8 = 2;

/// A face of a receiver, by its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct FaceId {
    pub(super) receiver: u32,
    pub(super) face: u32,
}

/// What the last look at a face found.
#[derive(Debug)]
pub(super) struct Known {
    pub(super) cost: Cost,
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
        self.known.as_ref().map_or(CELLS_A_LOOK, |known| {
            known.cost.base.max(CELLS_A_LOOK) + (known.cost.cells << known.levels_ahead())
        })
    }
}

impl Known {
    /// How many levels deeper the next look goes: where cells cost less than the look does anyway, so deep that they cost as much.
    pub(super) fn levels_ahead(&self) -> u8 {
        let Cost { base, cells, .. } = self.cost;
        NEXT_LEVELS.max((base / cells.max(1)).checked_ilog2().unwrap_or(0) as u8)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn known(base: u64, cells: u64) -> Open {
        let cost = Cost { level: 4, base, cells };
        let area = FaceArea::unknown(Approx::exact(1.0));
        Open::known(FaceId { receiver: 0, face: 0 }, Known { cost, stored: 1, area })
    }

    #[test]
    fn a_look_that_costs_much_anyway_goes_deep() {
        for (base, cells, ahead) in [(0, 0, 2), (0, 500, 2), (500, 500, 2), (500, 60, 3), (4000, 4, 9)] {
            let open = known(base, cells);
            assert_eq!(open.known.as_ref().map(|known| known.levels_ahead()), Some(ahead), "{base} and {cells}");
            let dear = base.max(CELLS_A_LOOK) + (cells << ahead);
            assert_eq!(open.expected(), dear, "{base} and {cells}");
        }
    }

    #[test]
    fn of_equal_areas_the_one_that_is_cheaper_to_look_at_comes_first() {
        // Borders that are drawn cost a part of the cells that they prove.
        let (drawn, divided) = (known(100, 1000), known(100, 4000));
        assert!(drawn > divided && drawn.worth > 3.0 * divided.worth);
    }
}
