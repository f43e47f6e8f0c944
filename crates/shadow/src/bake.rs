//! The pipeline: coarse step, fine step, sums.

use std::{
    sync::atomic::{AtomicU64, Ordering},
    time::Instant,
};

use rayon::prelude::*;
use umbriel_bvh::ObjectTree;
use umbriel_geometry::{LightSource, predicates::exact_fallbacks};
use umbriel_scene::Scene;

use crate::{
    bodies::Bodies,
    coarse::{coarse_step, object_tree},
    progress::{Cancelled, Progress},
    receivers::{FaceSums, Receivers},
    report::{Cell, LightReport, ObjectReport, Report, SampleCount, Work},
    request::{Detail, Request},
    sums::AreaSums,
};

/// Computes the shadows that `request` asks for. Deterministic: the same bits for any number of threads.
///
/// Cost: proportional to the shadow borders' length in cells, plus a look at every face.
///
/// # Errors
/// [`Cancelled`] when `progress` says so.
///
/// # Panics
/// If the request names a light or an object that the scene does not have.
pub fn bake(scene: &Scene, request: &Request, progress: &dyn Progress) -> Result<Report, Cancelled> {
    let bodies = Bodies::new(scene);
    let fallbacks = exact_fallbacks();
    let start = Instant::now();
    let tree = object_tree(&bodies);
    let mut report = Report::default();
    report.time.coarse = start.elapsed().as_secs_f64();
    for &light in &request.lights {
        let objects = bake_light(&bodies, &tree, request, &scene.lights[light].source, progress, &mut report)?;
        report.lights.push(LightReport { light, objects });
    }
    report.work.exact_fallbacks = exact_fallbacks() - fallbacks;
    Ok(report)
}

fn bake_light(
    bodies: &Bodies,
    tree: &ObjectTree,
    request: &Request,
    light: &LightSource,
    progress: &dyn Progress,
    report: &mut Report,
) -> Result<Vec<ObjectReport>, Cancelled> {
    let start = Instant::now();
    let influences = coarse_step(tree, &request.receivers, light);
    let counts = influences.counts();
    report.work.pairs_tested += counts.tested;
    report.work.pairs_registered += counts.registered;
    report.work.pairs_excluded += counts.excluded;
    report.time.coarse += start.elapsed().as_secs_f64();
    let start = Instant::now();
    let Detail::MaxUndecided { share } = request.detail else {
        let receivers = Receivers::new(bodies, light, request, request.detail, &influences);
        let objects = run(&receivers, progress, &mut report.work)?;
        report.time.fine += start.elapsed().as_secs_f64();
        return Ok(objects);
    };
    for boundary in 1..=crate::levels::MAX_DEPTH {
        let detail = Detail::Depth { interior: boundary, boundary };
        let receivers = Receivers::new(bodies, light, request, detail, &influences);
        let objects = run(&receivers, progress, &mut report.work)?;
        let area: f64 = objects.iter().map(|object| object.area).sum();
        let undecided: f64 = objects.iter().map(ObjectReport::undecided).sum();
        if undecided <= share * area || boundary == crate::levels::MAX_DEPTH {
            report.time.fine += start.elapsed().as_secs_f64();
            return Ok(objects);
        }
    }
    Ok(Vec::new())
}

/// Runs all jobs and adds them up per object.
fn run(receivers: &Receivers, progress: &dyn Progress, work: &mut Work) -> Result<Vec<ObjectReport>, Cancelled> {
    let jobs = receivers.jobs();
    let done = AtomicU64::new(0);
    let is_cancelled = || progress.is_cancelled();
    let sums: Vec<FaceSums> = jobs
        .par_iter()
        .map(|job| {
            let sums = receivers.run(job, &is_cancelled);
            progress.advance("shadows", done.fetch_add(1, Ordering::Relaxed) + 1, jobs.len() as u64);
            sums
        })
        .collect();
    if progress.is_cancelled() {
        return Err(Cancelled);
    }
    let mut objects = Vec::with_capacity(receivers.request.receivers.len());
    let mut rest = jobs.iter().zip(sums).peekable();
    for (receiver, &object) in receivers.request.receivers.iter().enumerate() {
        let mut total = ObjectSums::default();
        while let Some((_, sums)) = rest.next_if(|(job, _)| job.receiver == receiver) {
            total.add(sums, work);
        }
        objects.push(total.report(object, receivers.request, work));
    }
    Ok(objects)
}

/// The sums over one object; exact, so the order of faces does not matter.
#[derive(Default)]
struct ObjectSums {
    areas: AreaSums,
    cells: Vec<Cell>,
    samples: SampleCount,
    divided: bool,
}

impl ObjectSums {
    fn add(&mut self, mut sums: FaceSums, work: &mut Work) {
        self.areas.append(sums.areas);
        self.cells.append(&mut sums.cells);
        self.samples.samples += sums.samples.samples;
        self.samples.lit += sums.samples.lit;
        self.divided |= sums.divided;
        work.cells += sums.examined;
        work.rays += sums.points;
    }

    fn report(self, object: usize, request: &Request, work: &mut Work) -> ObjectReport {
        work.octrees_built += u64::from(self.divided);
        let AreaSums { area, lower, upper, estimate } = self.areas;
        let (lower, upper) = (lower.rounded_down(), upper.rounded_up());
        ObjectReport {
            object,
            area: area.nearest(),
            lit: crate::report::LitArea { lower, upper, estimate: estimate.nearest().clamp(lower, upper) },
            cells: self.cells,
            samples: request.sampling.map(|_| self.samples),
        }
    }
}
