//! Sums over the cells of an object, exact, so that no order changes them.

use umbriel_geometry::Approx;

use super::{
    bake::{AreaBounds, SoftCell, SoftObject},
    cell::CellBounds,
};
use crate::{report::LitArea, sums::ExactSum};

/// Areas of cells.
#[derive(Clone, Debug, Default)]
pub(super) struct SoftSums {
    area: ExactSum,
    lit: ExactSum,
    not_lit: ExactSum,
    umbra: ExactSum,
    not_umbra: ExactSum,
    penumbra: ExactSum,
    whole: ExactSum,
    lower: ExactSum,
    upper: ExactSum,
    estimate: ExactSum,
    pub(super) cells: Vec<SoftCell>,
    pub(super) examined: u64,
}

impl SoftSums {
    /// Of a cell that was examined, and no more.
    pub(super) fn one_examined() -> Self {
        Self { examined: 1, ..Self::default() }
    }

    /// Adds a cell.
    pub(super) fn add(&mut self, area: Approx, bounds: CellBounds) {
        let (least, most) = (area.lower().max(0.0), area.upper());
        self.area.add(area.value);
        self.whole.add(most);
        if bounds.lower >= 1.0 {
            self.lit.add(least);
        }
        if bounds.upper < 1.0 {
            self.not_lit.add(least);
        }
        if bounds.upper <= 0.0 {
            self.umbra.add(least);
        }
        if bounds.lower > 0.0 {
            self.not_umbra.add(least);
        }
        if bounds.lower > 0.0 && bounds.upper < 1.0 {
            self.penumbra.add(least);
        }
        self.lower.add((least * bounds.lower).next_down().max(0.0));
        self.upper.add((most * bounds.upper).next_up());
        self.estimate.add(area.value * bounds.estimate);
    }

    /// Both; cells of `other` after the own ones.
    pub(super) fn joined(mut self, mut other: Self) -> Self {
        self.area.append(other.area);
        self.whole.append(other.whole);
        self.lit.append(other.lit);
        self.not_lit.append(other.not_lit);
        self.umbra.append(other.umbra);
        self.not_umbra.append(other.not_umbra);
        self.penumbra.append(other.penumbra);
        self.lower.append(other.lower);
        self.upper.append(other.upper);
        self.estimate.append(other.estimate);
        self.cells.append(&mut other.cells);
        self.examined += other.examined;
        self
    }

    /// With bounds, rounded outward.
    pub(super) fn report(self, object: usize) -> SoftObject {
        let whole = self.whole.rounded_up();
        let at_most = |others: f64| (whole - others).next_up().max(0.0);
        let [lit, not_lit, umbra, not_umbra, penumbra] =
            [&self.lit, &self.not_lit, &self.umbra, &self.not_umbra, &self.penumbra].map(ExactSum::rounded_down);
        let (lower, upper) = (self.lower.rounded_down(), self.upper.rounded_up());
        SoftObject {
            object,
            area: self.area.nearest(),
            lit: AreaBounds { lower: lit, upper: at_most(not_lit) },
            penumbra: AreaBounds { lower: penumbra, upper: at_most((lit + umbra).next_down().max(0.0)) },
            umbra: AreaBounds { lower: umbra, upper: at_most(not_umbra) },
            visible: LitArea { lower, upper, estimate: self.estimate.nearest().clamp(lower, upper) },
            cells: self.cells,
        }
    }
}
