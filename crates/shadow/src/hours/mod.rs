//! Lit hours: many lights one after the other, each for some time; a day of suns.
//!
//! Problem: how long is each part of a surface in the sun? Rays to points know it for the points alone; here each light is
//! baked with proofs, as [`bake`](crate::bake) does, and folded into sums: area by time for objects, and intervals
//! of time for cells ([`grid`]). What no light changes (boxes, the object tree, placed faces) is made once.
//!
//! Guarantee: durations are whole nanoseconds, areas dyadics, sums of their products exact and rounded once, outward; the
//! order of the lights changes no bit. Cost: one bake a light and one walk over its cells. Memory: one light's cells and, if
//! cells are asked for, the leaves of [`grid`], which are no more for many lights than the finest grid has cells.

mod account;
mod grid;
#[cfg(test)]
mod tests;

use std::time::{Duration, Instant};

use rayon::prelude::*;
use umbriel_geometry::LightSource;
use umbriel_scene::Scene;

use crate::{
    bake::{Expense, Stage},
    progress::{Cancelled, Progress},
    report::{LitArea, ObjectReport, Time, Work},
    request::{OwnDetails, Request},
    sums::ExactSum,
};
use account::Account;

pub use grid::{HourCell, HourCells};

/// A light that shines for some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedLight {
    /// Where its light comes from.
    pub source: LightSource,
    /// For how long.
    pub duration: Duration,
}

/// Bounds on a quantity in hours, and an estimate of it: the truth lies in `lower..=upper`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HourBounds {
    /// Proved, rounded down.
    pub lower: f64,
    /// Not excluded by proof, rounded up.
    pub upper: f64,
    /// By the estimates of the single bakes.
    pub estimate: f64,
}

/// Hours by exact answers on the lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampledHours {
    /// How many samples.
    pub samples: u64,
    /// For how many hours they are lit, in the mean, each counted alike; the estimate of [`ObjectHours::lit_hours`] weighs by area.
    pub mean: f64,
}

/// One object under all lights.
#[derive(Clone, Debug)]
pub struct ObjectHours {
    /// Index into the scene's objects.
    pub object: usize,
    /// Surface area, square metres, each face once.
    pub area: f64,
    /// For how many hours its surface is lit, in the mean over its area; zero without area.
    pub lit_hours: HourBounds,
    /// Lit area by time, square metres times hours.
    pub lit_area_hours: HourBounds,
    /// Hours by samples, if asked for.
    pub samples: Option<SampledHours>,
    /// The hours of its cells, if asked for.
    pub cells: HourCells,
}

/// What one of the lights did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightSummary {
    /// Lit area over all receivers, square metres.
    pub lit: LitArea,
    /// Wall time, seconds; with the first light, also that of everything made once.
    pub seconds: f64,
}

/// The whole answer.
#[derive(Clone, Debug, Default)]
pub struct HoursReport {
    /// One report a receiver, in the order of the request.
    pub objects: Vec<ObjectHours>,
    /// One summary a light, in their order.
    pub lights: Vec<LightSummary>,
    /// For how long the lights shine together.
    pub duration: Duration,
    /// Counters over all lights.
    pub work: Work,
    /// Wall times over all lights.
    pub time: Time,
}

/// Why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum HoursError {
    /// Progress said so.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The durations add up to 2^64 nanoseconds or more.
    #[error("the lights shine for more than 584 years in all")]
    TooLong,
}

/// A duration in hours, the nearest float.
pub fn hours(duration: Duration) -> f64 {
    duration.as_nanos() as f64 / account::NANOSECONDS_AN_HOUR
}

/// Computes for how long the receivers of `request` are lit while `lights` shine one after the other. They take the place
/// of the request's lights, which are not looked at. With `keep_cells` the report has the hours of cells, none smaller
/// than the detail stores (for depths: the interior depth). Deterministic: the same bits for any number of threads and any
/// order of the lights.
///
/// Cost: as many bakes, without what no light changes.
///
/// # Errors
/// [`HoursError`].
///
/// # Panics
/// If the request names an object that the scene does not have.
pub fn bake_hours(
    scene: &Scene,
    request: &Request,
    lights: &[TimedLight],
    progress: &dyn Progress,
) -> Result<HoursReport, HoursError> {
    let begun = Instant::now();
    let total = total_nanoseconds(lights)?;
    let request = &Request { own: OwnDetails::default(), ..request.clone() };
    let stage = Stage::new(scene, request, None);
    let mut expense = stage.expense();
    let mut accounts = Account::of_all(&stage);
    let mut summaries = Vec::with_capacity(lights.len());
    // Areas are told even where no light ever shines: by a light that shines for no time.
    let idle = LightSource::sun([0.0, -1.0, 0.0]).map(|source| TimedLight { source, duration: Duration::ZERO });
    let idle = if lights.is_empty() { idle.ok() } else { None };
    let mut seconds_before = 0.0;
    for (index, light) in lights.iter().chain(&idle).enumerate() {
        let progress = OneOf { progress, index: index as u64, count: lights.len().max(1) as u64 };
        let lit = fold(&stage, light, &progress, &mut expense, &mut accounts)?;
        let seconds = begun.elapsed().as_secs_f64();
        summaries.push(LightSummary { lit, seconds: seconds - seconds_before });
        seconds_before = seconds;
    }
    summaries.truncate(lights.len());
    let objects = accounts.into_iter().map(|account| account.report(total)).collect();
    let duration = Duration::from_nanos(total);
    Ok(HoursReport { objects, lights: summaries, duration, work: expense.work, time: expense.time })
}

fn total_nanoseconds(lights: &[TimedLight]) -> Result<u64, HoursError> {
    let mut total = 0u64;
    for light in lights {
        let nanoseconds = u64::try_from(light.duration.as_nanos()).map_err(|_| HoursError::TooLong)?;
        total = total.checked_add(nanoseconds).ok_or(HoursError::TooLong)?;
    }
    Ok(total)
}

/// Bakes one light and adds it to the accounts; its lit area over all receivers.
fn fold(
    stage: &Stage,
    light: &TimedLight,
    progress: &dyn Progress,
    expense: &mut Expense,
    accounts: &mut [Account],
) -> Result<LitArea, Cancelled> {
    let reports = stage.bake(&light.source, None, progress, expense)?;
    let lit = total_lit(&reports);
    // Checked with the sum of all durations.
    let nanoseconds = light.duration.as_nanos() as u64;
    accounts.par_iter_mut().zip(reports).for_each(|(account, report)| account.add(&stage.bodies, &report, nanoseconds));
    Ok(lit)
}

fn total_lit(reports: &[ObjectReport]) -> LitArea {
    let sum = |area: fn(&LitArea) -> f64| {
        let mut sum = ExactSum::default();
        reports.iter().for_each(|report| sum.add(area(&report.lit)));
        sum
    };
    LitArea {
        lower: sum(|lit| lit.lower).rounded_down(),
        upper: sum(|lit| lit.upper).rounded_up(),
        estimate: sum(|lit| lit.estimate).nearest(),
    }
}

/// Progress of one light among several.
struct OneOf<'a> {
    progress: &'a dyn Progress,
    index: u64,
    count: u64,
}

impl Progress for OneOf<'_> {
    fn advance(&self, phase: &str, done: u64, total: u64) {
        // Lights may have different numbers of steps.
        const STEPS: u64 = 1000;
        let part = done.saturating_mul(STEPS) / total.max(1);
        self.progress.advance(phase, self.index * STEPS + part.min(STEPS), self.count * STEPS);
    }

    fn is_cancelled(&self) -> bool {
        self.progress.is_cancelled()
    }
}
