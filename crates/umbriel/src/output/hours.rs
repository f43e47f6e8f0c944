//! A day of suns as all its files see it.

use umbriel_io::SunRow;
use umbriel_scene::Scene;
use umbriel_shadow::{Cell, HourCell, HoursReport, ObjectHours, Verdict, hours};

/// The answer to a table of suns.
pub(crate) struct Day<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) report: &'a HoursReport,
    /// All rows, night included.
    pub(crate) rows: Vec<Row<'a>>,
}

/// A row of the table, and the light of the report that it is; none at night.
pub(crate) struct Row<'a> {
    pub(crate) row: &'a SunRow,
    pub(crate) light: Option<usize>,
}

impl Day<'_> {
    pub(crate) fn name(&self, object: &ObjectHours) -> &str {
        &self.scene.objects[object.object].name
    }

    /// For how long the sun shines.
    pub(crate) fn hours(&self) -> f64 {
        hours(self.report.duration)
    }

    /// How many rows are night.
    pub(crate) fn below_horizon(&self) -> usize {
        self.rows.iter().filter(|row| row.light.is_none()).count()
    }

    /// See [`share`].
    pub(crate) fn share(&self, cell: &HourCell) -> f64 {
        share(cell, self.report)
    }
}

/// The middle of a cell's bounds, as a share of all hours.
pub(crate) fn share(cell: &HourCell, report: &HoursReport) -> f64 {
    let ([lower, upper], all) = (bounds(cell), hours(report.duration));
    if all > 0.0 { (0.5 * (lower + upper) / all).min(1.0) } else { 0.0 }
}

/// For how many hours every point of a cell is lit, at least and at most.
pub(crate) fn bounds(cell: &HourCell) -> [f64; 2] {
    [hours(cell.lower), hours(cell.upper)]
}

/// Where the cell lies; the verdict means nothing.
pub(crate) fn place(cell: &HourCell) -> Cell {
    let HourCell { face, corner, level, i, j, .. } = *cell;
    Cell { face, corner, level, i, j, verdict: Verdict::Undecided }
}
