//! The account of one object: area by time, exact until it is reported.

use umbriel_geometry::Approx;

use super::{
    HourBounds, ObjectHours, SampledHours,
    grid::{HourCells, HourGrid},
};
use crate::{bake::Stage, bodies::Bodies, report::ObjectReport, sums::ExactSum};

/// Durations are counted in nanoseconds; a float holds this number exactly.
pub(super) const NANOSECONDS_AN_HOUR: f64 = 3.6e12;

/// What the lights so far did to an object.
pub(super) struct Account {
    object: usize,
    /// `None` before the first light.
    area: Option<Approx>,
    /// Lit area by time, square metres times nanoseconds.
    lower: ExactSum,
    upper: ExactSum,
    estimate: ExactSum,
    /// How many samples there are, and their lit nanoseconds together; `None` if none were asked for.
    samples: Option<(u64, u128)>,
    grid: Option<HourGrid>,
}

impl Account {
    /// Empty accounts of all receivers.
    pub(super) fn of_all(stage: &Stage) -> Vec<Self> {
        let request = stage.request;
        let open = |&object: &usize| Self {
            object,
            area: None,
            lower: ExactSum::default(),
            upper: ExactSum::default(),
            estimate: ExactSum::default(),
            samples: request.sampling.map(|_| (0, 0)),
            grid: request.keep_cells.then(|| HourGrid::new(&stage.bodies, object, request.detail)),
        };
        request.receivers.iter().map(open).collect()
    }

    /// Adds a light that shines for so many nanoseconds.
    pub(super) fn add(&mut self, bodies: &Bodies, report: &ObjectReport, nanoseconds: u64) {
        // Lights divide a curved face differently; the sharpest of their sums, whatever the order of the lights.
        let area = Approx { value: report.area, error: report.area_error };
        let is_sharper = |known: Approx| (area.error, area.value) < (known.error, known.value);
        if self.area.is_none_or(is_sharper) {
            self.area = Some(area);
        }
        self.lower.add_product(report.lit.lower, nanoseconds);
        self.upper.add_product(report.lit.upper, nanoseconds);
        self.estimate.add_product(report.lit.estimate, nanoseconds);
        if let (Some((samples, lit)), Some(count)) = (&mut self.samples, report.samples) {
            *samples = count.samples;
            *lit += u128::from(count.lit) * u128::from(nanoseconds);
        }
        if let Some(grid) = &mut self.grid {
            grid.fold(bodies, &report.cells, nanoseconds);
        }
    }

    /// The sums in hours, rounded outward; `total` nanoseconds is the most that anything can be lit.
    pub(super) fn report(self, total: u64) -> ObjectHours {
        let in_hours = |sum: &ExactSum| sum.bounded().divided_by(Approx::exact(NANOSECONDS_AN_HOUR));
        let [lower, upper, estimate] = [&self.lower, &self.upper, &self.estimate].map(in_hours);
        let lit_area_hours = bounds(lower.lower(), upper.upper(), estimate.value);
        let most = total as f64 / NANOSECONDS_AN_HOUR;
        let area = self.area.unwrap_or_default();
        // Unknown where the area may be nothing: between none of the hours and all of them.
        let mean = |sum: Approx| if area.value > 0.0 { sum.divided_by(area) } else { Approx::exact(0.0) };
        let likely = if area.value > 0.0 { estimate.value / area.value } else { 0.0 };
        let lit_hours = bounds(mean(lower).lower(), mean(upper).upper().min(most), likely);
        let samples = self.samples.map(|(samples, lit)| SampledHours {
            samples,
            mean: if samples > 0 { lit as f64 / samples as f64 / NANOSECONDS_AN_HOUR } else { 0.0 },
        });
        let cells = self.grid.map(HourCells::new).unwrap_or_default();
        ObjectHours { object: self.object, area: area.value, lit_hours, lit_area_hours, samples, cells }
    }
}

/// Bounds in order, none below zero.
fn bounds(lower: f64, upper: f64, estimate: f64) -> HourBounds {
    let upper = upper.max(0.0);
    let lower = lower.clamp(0.0, upper);
    HourBounds { lower, upper, estimate: estimate.clamp(lower, upper) }
}
