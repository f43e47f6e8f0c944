//! What time and memory buy: settings of the bake and the rivals, judged by the same exact answers.
//!
//! A [`Judge`] knows the truth at points all over the surface. [`measure`] runs one [`Setting`] and tells its time, its memory and its [`Score`];
//! [`pareto`] finds the settings that no other beats in both, and [`recommend`] the soonest one that is good enough. Stored answers (cells, samples)
//! are looked up at the judged points after the clock has stopped; a rival's clock stops when it has answered them.

mod judge;
mod lookup;
mod nearest;
#[cfg(test)]
mod tests;

use std::time::Instant;

use rayon::prelude::*;
use umbriel_geometry::LightSource;
use umbriel_scene::Scene;

use self::lookup::{CellLookup, SampleLookup};
use crate::{
    Cancelled, Cell, Detail, FacePoint, Points, Progress, Queries, Report, Request, SamplePoint, Sampling, Verdict,
    bake,
    bodies::Bodies,
    for_each_sample,
    rivals::{PointRays, Polygons, Rival, RivalPoint, RivalRefusal},
    spacing::spacing,
};

pub use judge::{Judge, Score};

/// A way to find shadows, with its settings.
pub enum Setting {
    /// A bake of cells with proofs.
    Bake(Detail),
    /// A bake of about this many samples, each answer standing for the surface round it.
    Samples(u64),
    /// One ray a sample for about as many samples, in the same places.
    RaySamples(u64),
    /// Exact answers at the judged points themselves, by face and parameters: for every scene.
    Points,
    /// The same where it is known which meshes bound solids ([`Queries::find_solids`]).
    PointsOfSolids,
    /// A rival that is asked at the judged points themselves.
    Rival(Box<dyn Rival>),
}

/// Settings that go together in a chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// Cells with proofs.
    Bake,
    /// Cells with proofs, divided where it tells most.
    Limit,
    /// Exact samples.
    Samples,
    /// Exact answers at the judged points.
    Points,
    /// Rays at samples.
    RaySamples,
    /// Rays at the judged points.
    Rays,
    /// Shadow volumes.
    ShadowVolume,
    /// Shadow maps.
    ShadowMap,
    /// The source's words.
    Literal,
}

/// What a setting took and gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The setting in words.
    pub name: String,
    /// What it is one of.
    pub family: Family,
    /// Wall seconds for what is made beforehand because it is the same for all lights, where that is made for this setting alone.
    pub ready_seconds: f64,
    /// Wall seconds for what comes first: the coarse step, a tree, a map, shadow volumes.
    pub first_seconds: f64,
    /// Wall seconds for the rest: the fine step, the points.
    pub second_seconds: f64,
    /// Points decided one by one.
    pub rays: u64,
    /// What was made: cells examined, triangles of a tree, texels, polygons of volumes, marks.
    pub pieces: u64,
    /// Bytes of what is stored, as far as it is counted.
    pub bytes: u64,
    /// How far it is from the truth.
    pub score: Score,
}

impl Measurement {
    /// All wall seconds after loading, but for what is made beforehand.
    pub fn seconds(&self) -> f64 {
        self.first_seconds + self.second_seconds
    }
}

/// Why there is no measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeasureDefect {
    /// The rival did not take it.
    #[error(transparent)]
    Refused(#[from] RivalRefusal),
    /// Somebody cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Answers to samples are kept for flat objects that no curved body may shadow.
    #[error("samples are not kept for curved bodies and what they may shadow")]
    NoAnswers,
}

impl Setting {
    /// Which family it belongs to; a rival is told by its name.
    fn family(&self) -> Family {
        match self {
            Self::Bake(Detail::MaxUndecided { .. } | Detail::Time { .. } | Detail::Memory { .. }) => Family::Limit,
            Self::Bake(_) => Family::Bake,
            Self::Points | Self::PointsOfSolids => Family::Points,
            Self::Samples(_) => Family::Samples,
            Self::RaySamples(_) => Family::RaySamples,
            Self::Rival(rival) => match rival.name().as_str() {
                "rays" => Family::Rays,
                "shadow volume" => Family::ShadowVolume,
                name if name.starts_with("literal") => Family::Literal,
                _ => Family::ShadowMap,
            },
        }
    }

    /// What it is called.
    pub fn name(&self) -> String {
        match self {
            Self::Bake(Detail::Depth { boundary, .. }) => format!("bake, depth {boundary}"),
            Self::Bake(Detail::Cell { edge }) => format!("bake, cells of {edge} m"),
            Self::Bake(Detail::MaxUndecided { share }) => format!("bake, undecided {share}"),
            Self::Bake(Detail::Time { limit }) => format!("bake, {} ms", limit.as_millis()),
            Self::Bake(Detail::Memory { bytes }) => format!("bake, {:.1} MB", *bytes as f64 / 1e6),
            Self::Bake(_) => "bake".into(),
            Self::Points => "points".into(),
            Self::PointsOfSolids => "points, solids known".into(),
            Self::Samples(count) => format!("{count} samples"),
            Self::RaySamples(count) => format!("{count} rays"),
            Self::Rival(rival) => rival.name(),
        }
    }
}

/// What a setting is measured on.
#[derive(Clone, Copy, Debug)]
pub struct Course<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The same as rivals take it.
    pub polygons: &'a Polygons<'a>,
    /// Which of its lights.
    pub light: usize,
    /// The truth.
    pub judge: &'a Judge,
}

/// Runs a setting once.
///
/// # Errors
/// [`MeasureDefect`].
///
/// # Panics
/// If there is no such light.
pub fn measure(course: &Course, setting: &Setting, progress: &dyn Progress) -> Result<Measurement, MeasureDefect> {
    measure_and_state(course, setting, progress).map(|(measurement, _)| measurement)
}

/// As [`measure`], with what was said of each judged point.
///
/// # Errors
/// [`MeasureDefect`].
///
/// # Panics
/// If there is no such light.
pub fn measure_and_state(
    course: &Course,
    setting: &Setting,
    progress: &dyn Progress,
) -> Result<(Measurement, Vec<Verdict>), MeasureDefect> {
    // All begin among the threads: none pays for the way there.
    let Measured { ready, first, second, rays, pieces, bytes, stated } =
        rayon::scope(|_| measure_unjudged(course, setting, progress))?;
    let (name, family) = (setting.name(), setting.family());
    let score = course.judge.score(|point| stated[point]);
    let measurement = Measurement {
        name,
        family,
        ready_seconds: ready,
        first_seconds: first,
        second_seconds: second,
        rays,
        pieces,
        bytes,
        score,
    };
    Ok((measurement, stated))
}

fn measure_unjudged(course: &Course, setting: &Setting, progress: &dyn Progress) -> Result<Measured, MeasureDefect> {
    Ok(match setting {
        Setting::Bake(detail) => measure_bake(course, *detail, progress)?,
        Setting::Samples(count) => measure_samples(course, *count, progress)?,
        Setting::RaySamples(count) => measure_rays(course, *count)?,
        Setting::Points => measure_points(course, false, progress)?,
        Setting::PointsOfSolids => measure_points(course, true, progress)?,
        Setting::Rival(rival) => {
            let answer = rival.answer(course.polygons, course.source(), course.judge.points())?;
            let stated = answer.lit.iter().map(|&is_lit| verdict(is_lit)).collect();
            let (first, second) = (answer.build_seconds, answer.points_seconds);
            Measured {
                ready: 0.0,
                first,
                second,
                rays: answer.rays,
                pieces: answer.pieces,
                bytes: answer.bytes,
                stated,
            }
        }
    })
}

/// Runs a setting once and judges nothing: what memory it takes is measured by it. `begun` is called when the points that a rival is asked at are there.
/// The judge needs no answers ([`Judge::without_answers`]).
///
/// # Errors
/// [`MeasureDefect`].
///
/// # Panics
/// If there is no such light.
pub fn run(
    course: &Course,
    setting: &Setting,
    progress: &dyn Progress,
    begun: &mut dyn FnMut(),
) -> Result<(), MeasureDefect> {
    let points = match setting {
        Setting::RaySamples(count) => ray_points(course, &course.samples_request(*count)).0,
        _ => Vec::new(),
    };
    begun();
    match setting {
        Setting::Bake(detail) => drop(bake(course.scene, &course.cells_request(*detail), progress)?),
        Setting::Samples(count) => drop(bake(course.scene, &course.samples_request(*count), progress)?),
        Setting::RaySamples(_) => drop(PointRays.answer(course.polygons, course.source(), &points)?),
        Setting::Points => drop(measure_points(course, false, progress)?),
        Setting::PointsOfSolids => drop(measure_points(course, true, progress)?),
        Setting::Rival(rival) => drop(rival.answer(course.polygons, course.source(), course.judge.points())?),
    }
    Ok(())
}

/// What a run gave, before it is judged.
struct Measured {
    ready: f64,
    first: f64,
    second: f64,
    rays: u64,
    pieces: u64,
    bytes: u64,
    stated: Vec<Verdict>,
}

impl Course<'_> {
    fn source(&self) -> &LightSource {
        &self.scene.lights[self.light].source
    }

    fn request(&self, detail: Detail, sampling: Option<Sampling>) -> Request {
        Request { sampling, lights: vec![self.light], keep_cells: true, ..Request::everything(self.scene, detail) }
    }

    /// Cells, all of them as fine as those along borders.
    fn cells_request(&self, detail: Detail) -> Request {
        let detail = match detail {
            Detail::Depth { boundary, .. } => Detail::Depth { interior: boundary, boundary },
            other => other,
        };
        self.request(detail, None)
    }

    fn samples_request(&self, count: u64) -> Request {
        self.request(Detail::Faces, Some(Sampling::Count(count)))
    }
}

fn verdict(is_lit: bool) -> Verdict {
    if is_lit { Verdict::Lit } else { Verdict::Shadowed }
}

fn measure_bake(course: &Course, detail: Detail, progress: &dyn Progress) -> Result<Measured, Cancelled> {
    let request = course.cells_request(detail);
    let begun = Instant::now();
    let report = bake(course.scene, &request, progress)?;
    let seconds = begun.elapsed().as_secs_f64();
    let cells: usize = report.lights[0].objects.iter().map(|object| object.cells.len()).sum();
    let lookup = CellLookup::new(course.scene.objects.len(), &report.lights[0]);
    let stated = course.judge.samples().par_iter().map(|sample| lookup.verdict(sample)).collect();
    Ok(measured(&report, seconds, cells * size_of::<Cell>(), stated))
}

fn measure_samples(course: &Course, count: u64, progress: &dyn Progress) -> Result<Measured, MeasureDefect> {
    let request = course.samples_request(count);
    let begun = Instant::now();
    let report = bake(course.scene, &request, progress)?;
    let seconds = begun.elapsed().as_secs_f64();
    let objects = &report.lights[0].objects;
    let answers = objects.iter().map(|object| object.answers.as_ref()).collect::<Option<Vec<_>>>();
    let answers = answers.ok_or(MeasureDefect::NoAnswers)?;
    let lookup = sample_lookup(course, &request).ok_or(MeasureDefect::NoAnswers)?;
    let stated = |sample: &SamplePoint| verdict(answers[sample.object].is_lit(lookup.nearest(sample)));
    let stated = course.judge.samples().par_iter().map(stated).collect();
    let bytes = answers.iter().map(|answers| answers.len().div_ceil(8)).sum::<u64>();
    Ok(measured(&report, seconds, bytes as usize, stated))
}

fn measured(report: &Report, seconds: f64, bytes: usize, stated: Vec<Verdict>) -> Measured {
    let first = report.time.coarse;
    let (rays, pieces) = (report.work.rays, report.work.cells);
    Measured { ready: 0.0, first, second: (seconds - first).max(0.0), rays, pieces, bytes: bytes as u64, stated }
}

fn measure_rays(course: &Course, count: u64) -> Result<Measured, MeasureDefect> {
    let request = course.samples_request(count);
    let lookup = sample_lookup(course, &request).ok_or(MeasureDefect::NoAnswers)?;
    let (points, starts) = ray_points(course, &request);
    let answer = PointRays.answer(course.polygons, course.source(), &points)?;
    let stated = |sample: &SamplePoint| verdict(answer.lit[starts[sample.object] + lookup.nearest(sample) as usize]);
    let stated = course.judge.samples().par_iter().map(stated).collect();
    let bytes = answer.bytes + answer.lit.len().div_ceil(8) as u64;
    let (first, second) = (answer.build_seconds, answer.points_seconds);
    Ok(Measured { ready: 0.0, first, second, rays: answer.rays, pieces: answer.pieces, bytes, stated })
}

/// The samples of a request as a rival takes them, and where each object's begin.
fn ray_points(course: &Course, request: &Request) -> (Vec<RivalPoint>, Vec<usize>) {
    let mut points: Vec<RivalPoint> = Vec::new();
    let mut starts = vec![0; course.scene.objects.len()];
    for_each_sample(course.scene, request, |sample: SamplePoint| {
        // Places without a normal, the tips of cones, are kept so that numbers stay true; they are dark.
        points.push(course.polygons.point(&sample).unwrap_or_default());
        starts[sample.object] += 1;
    });
    let mut next = 0;
    for start in &mut starts {
        let count = std::mem::replace(start, next);
        next += count;
    }
    (points, starts)
}

/// Points of faces asked together look into light space, the soonest way for them. Places of points and faces are known beforehand, as rivals' are.
fn measure_points(course: &Course, knows_solids: bool, progress: &dyn Progress) -> Result<Measured, Cancelled> {
    let (samples, light) = (course.judge.samples(), course.source());
    let point = |sample: &SamplePoint| FacePoint::new(sample.object, sample.face, sample.u, sample.v);
    // A place that a picture found may lie, by rounding, just outside its face: it is dark, as the judge has it.
    let mut queries = Queries::new(course.scene);
    let places: Vec<bool> = samples.iter().map(|sample| queries.surface_defect(point(sample)).is_none()).collect();
    let accepted = samples.iter().zip(&places).filter(|(_, is_accepted)| **is_accepted);
    let points: Vec<FacePoint> = accepted.map(|(sample, _)| point(sample)).collect();
    let begun = Instant::now();
    if knows_solids {
        queries.find_solids();
    }
    let ready = begun.elapsed().as_secs_f64();
    let begun = Instant::now();
    let mut lit = queries.lit_many(Points::OnFaces(&points), light, progress).map_err(|_| Cancelled)?.into_iter();
    let second = begun.elapsed().as_secs_f64();
    let stated = places.into_iter().map(|is_accepted| verdict(is_accepted && lit.next().unwrap_or_default())).collect();
    let (rays, bytes) = (samples.len() as u64, samples.len().div_ceil(8) as u64);
    Ok(Measured { ready, first: 0.0, second, rays, pieces: 0, bytes, stated })
}

fn sample_lookup(course: &Course, request: &Request) -> Option<SampleLookup> {
    let bodies = Bodies::new(course.scene);
    SampleLookup::new(&bodies, spacing(&bodies, request)?)
}

/// Whether each setting is on the front: no other has less or equal `cost` and less or equal error, one of them less.
pub fn pareto(measured: &[Measurement], cost: impl Fn(&Measurement) -> f64) -> Vec<bool> {
    let beats = |a: &Measurement, b: &Measurement| {
        let (costs, errors) = ([cost(a), cost(b)], [a.score.error(), b.score.error()]);
        costs[0] <= costs[1] && errors[0] <= errors[1] && (costs[0] < costs[1] || errors[0] < errors[1])
    };
    measured.iter().map(|own| !measured.iter().any(|other| beats(other, own))).collect()
}

/// The soonest setting whose error is at most `error`; only those that know their error if `with_bounds`.
pub fn recommend(measured: &[Measurement], error: f64, with_bounds: bool) -> Option<&Measurement> {
    let is_taken = |one: &&Measurement| {
        let knows = !with_bounds || matches!(one.family, Family::Bake | Family::Limit);
        knows && one.score.error() <= error
    };
    measured.iter().filter(is_taken).min_by(|a, b| a.seconds().total_cmp(&b.seconds()))
}
