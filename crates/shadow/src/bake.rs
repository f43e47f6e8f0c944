//! The pipeline: coarse step, fine step, sums.

use std::{
    sync::{
        OnceLock,
        atomic::{AtomicU64, Ordering},
    },
    time::Instant,
};

use rayon::prelude::*;
use umbriel_bvh::{Influences, ObjectTree};
use umbriel_geometry::{LightSource, predicates::exact_fallbacks};
use umbriel_scene::Scene;

use crate::{
    bodies::Bodies,
    coarse::{coarse_step, object_tree},
    fine::{lattice::Spacing, scan::Layout},
    progress::{Cancelled, Progress},
    receivers::{FaceSums, Receivers, spacing},
    report::{Cell, LightReport, ObjectReport, Report, SampleCount, Time, Work},
    request::{Detail, Request},
    samples::Samples,
    solids::Solids,
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
    let stage = Stage::new(scene, request);
    let mut effort = stage.effort();
    let mut lights = Vec::with_capacity(request.lights.len());
    for &light in &request.lights {
        let objects = stage.bake(&scene.lights[light].source, progress, &mut effort)?;
        lights.push(LightReport { light, objects });
    }
    Ok(Report { lights, work: effort.work, time: effort.time })
}

/// What was done for some lights, and how long it took.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Effort {
    pub(crate) work: Work,
    pub(crate) time: Time,
}

/// All of a bake that no light changes: made once.
pub(crate) struct Stage<'a> {
    pub(crate) bodies: Bodies<'a>,
    pub(crate) request: &'a Request,
    /// How far apart samples are.
    pub(crate) spacing: Option<Spacing>,
    /// The samples of each object's flat faces, each made when it is first asked for.
    pub(crate) layouts: Vec<OnceLock<Layout>>,
    /// The solids of each object, each made when it is first asked for.
    pub(crate) solids: Vec<OnceLock<Solids>>,
    tree: ObjectTree,
    /// Seconds that making it took.
    seconds: f64,
}

impl<'a> Stage<'a> {
    /// The object tree and the sample spacing; bodies are placed when they are first asked for.
    pub(crate) fn new(scene: &'a Scene, request: &'a Request) -> Self {
        let start = Instant::now();
        let bodies = Bodies::new(scene);
        let (tree, spacing) = (object_tree(&bodies), spacing(&bodies, request));
        let layouts = scene.objects.iter().map(|_| OnceLock::new()).collect();
        let solids = scene.objects.iter().map(|_| OnceLock::new()).collect();
        Self { bodies, request, spacing, layouts, solids, tree, seconds: start.elapsed().as_secs_f64() }
    }

    /// The account to which lights are added.
    pub(crate) fn effort(&self) -> Effort {
        Effort { time: Time { coarse: self.seconds, ..Time::default() }, ..Effort::default() }
    }

    /// Computes the shadows of one light: a report for each receiver.
    pub(crate) fn bake(
        &self,
        light: &LightSource,
        progress: &dyn Progress,
        effort: &mut Effort,
    ) -> Result<Vec<ObjectReport>, Cancelled> {
        let (start, fallbacks) = (Instant::now(), exact_fallbacks());
        let influences = coarse_step(&self.tree, &self.request.receivers, light);
        let counts = influences.counts();
        effort.work.pairs_tested += counts.tested;
        effort.work.pairs_registered += counts.registered;
        effort.work.pairs_excluded += counts.excluded;
        effort.time.coarse += start.elapsed().as_secs_f64();
        let start = Instant::now();
        let objects = self.refine(light, &influences, progress, &mut effort.work)?;
        effort.time.fine += start.elapsed().as_secs_f64();
        effort.work.exact_fallbacks += exact_fallbacks() - fallbacks;
        Ok(objects)
    }

    /// The fine step; once, or depth by depth until little enough is undecided.
    fn refine(
        &self,
        light: &LightSource,
        influences: &Influences,
        progress: &dyn Progress,
        work: &mut Work,
    ) -> Result<Vec<ObjectReport>, Cancelled> {
        let receivers = |detail| Receivers::new(self, light, detail, influences);
        if self.request.detail == Detail::Faces && self.spacing.is_some() {
            let samples = Samples::new(self, light, influences);
            let mut objects = run(&receivers(Detail::Faces), |receiver| !samples.takes(receiver), progress, work)?;
            work.rays += samples.run(&mut objects, progress)?;
            return Ok(objects);
        }
        let all = |_| true;
        let Detail::MaxUndecided { share } = self.request.detail else {
            return run(&receivers(self.request.detail), all, progress, work);
        };
        let mut boundary = 0;
        loop {
            boundary += 1;
            let objects = run(&receivers(Detail::Depth { interior: boundary, boundary }), all, progress, work)?;
            let area: f64 = objects.iter().map(|object| object.area).sum();
            let undecided: f64 = objects.iter().map(ObjectReport::undecided).sum();
            if undecided <= share * area || boundary == crate::levels::MAX_DEPTH {
                return Ok(objects);
            }
        }
    }
}

/// Runs the jobs of the receivers that are `asked`, and adds them up per object.
fn run(
    receivers: &Receivers,
    asked: impl Fn(usize) -> bool,
    progress: &dyn Progress,
    work: &mut Work,
) -> Result<Vec<ObjectReport>, Cancelled> {
    let jobs = receivers.jobs(asked);
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
        let (area, area_error) = self.areas.area();
        let AreaSums { lower, upper, estimate, .. } = self.areas;
        let (lower, upper) = (lower.rounded_down(), upper.rounded_up());
        ObjectReport {
            object,
            area,
            area_error,
            lit: crate::report::LitArea { lower, upper, estimate: estimate.nearest().clamp(lower, upper) },
            cells: self.cells,
            samples: request.sampling.map(|_| self.samples),
            answers: None,
        }
    }
}
