//! `bake --json`: names and order of the fields are a contract.

use std::time::Instant;

use serde::Serialize;
use umbriel_geometry::decisions::Decisions;
use umbriel_io::peak_memory_bytes;
use umbriel_scene::{Finding, Scene, Shape};
use umbriel_shadow::{Detail, HourBounds, LitArea, ObjectReport, Report, Request, hours};

use crate::output::hours::{Day, Row};

const SCHEMA: u32 = 1;

/// The whole document.
#[derive(Debug, Serialize)]
pub(crate) struct Document<'a> {
    schema: u32,
    umbriel: &'static str,
    scene: SceneCounts,
    detail: DetailUsed,
    lights: Vec<LightResult<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    suns: Option<SunsResult<'a>>,
    findings: Vec<FindingEntry<'a>>,
    work: Work,
    time: Time,
    peak_memory_bytes: Option<u64>,
}

#[derive(Debug, Serialize)]
struct SceneCounts {
    objects: usize,
    triangles: usize,
    analytic: usize,
    lights: usize,
}

#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(crate) enum DetailUsed {
    Depth { interior_depth: u8, boundary_depth: u8 },
    Cell { cell: f64 },
    MaxUndecided { max_undecided: f64 },
    Time { time: f64 },
    Memory { memory_bytes: u64 },
    Pixel { pixel_eye: [f64; 3], pixel_width: f64 },
    Faces { faces: &'static str },
    Other {},
}

#[derive(Debug, Serialize)]
struct LightResult<'a> {
    name: &'a str,
    objects: Vec<ObjectResult<'a>>,
}

#[derive(Debug, Serialize)]
struct ObjectResult<'a> {
    name: &'a str,
    /// Of its own, where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    detail: Option<DetailUsed>,
    area: f64,
    /// By how much the true area may differ; nothing where that is not known.
    area_error: Option<f64>,
    undecided: f64,
    lit_area: Bounds,
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lit_samples: Option<u64>,
}

#[derive(Debug, Default, Serialize)]
struct Bounds {
    lower: f64,
    upper: f64,
    estimate: f64,
}

/// The answer to a table of suns.
#[derive(Debug, Serialize)]
struct SunsResult<'a> {
    /// Rows of the table, night included.
    count: usize,
    below_horizon: usize,
    hours: f64,
    objects: Vec<HoursResult<'a>>,
    rows: Vec<SunResult<'a>>,
}

#[derive(Debug, Serialize)]
struct HoursResult<'a> {
    name: &'a str,
    area: f64,
    lit_hours: Bounds,
    lit_area_hours: Bounds,
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sampled_hours: Option<f64>,
}

/// One row of the table.
#[derive(Debug, Serialize)]
struct SunResult<'a> {
    line: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<&'a str>,
    hours: f64,
    lit_area: Bounds,
}

#[derive(Debug, Serialize)]
struct FindingEntry<'a> {
    kind: &'static str,
    object: &'a str,
    count: usize,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    places: &'a [String],
}

#[derive(Debug, Serialize)]
struct Work {
    pairs_tested: u64,
    pairs_registered: u64,
    pairs_excluded: u64,
    octrees_built: u64,
    cells: u64,
    rays: u64,
    exact_fallbacks: u64,
    /// Only in scenes with cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    portals: Option<Portals>,
    decisions: DecisionCounts,
}

/// What the lights reach through portals, added up over the lights.
#[derive(Debug, Serialize)]
struct Portals {
    cells: u64,
    passages: u64,
    objects: u64,
    objects_left_out: u64,
    receivers_left_out: u64,
    lights_left_out: u64,
    lights_outside: u64,
}

impl Portals {
    fn of(work: umbriel_shadow::PortalWork) -> Option<Self> {
        let umbriel_shadow::PortalWork { cells, passages, objects, objects_left_out, .. } = work;
        let umbriel_shadow::PortalWork { receivers_left_out, lights_left_out, lights_outside, .. } = work;
        (work != umbriel_shadow::PortalWork::default()).then_some(Self {
            cells,
            passages,
            objects,
            objects_left_out,
            receivers_left_out,
            lights_left_out,
            lights_outside,
        })
    }
}

/// Signs and orders that were decided, by what settled them: in the whole command, reading included.
#[derive(Debug, Serialize)]
struct DecisionCounts {
    f32: u64,
    f64: u64,
    pair: u64,
    expansion: u64,
    exact: u64,
}

impl DecisionCounts {
    fn of_process() -> Self {
        let Decisions { single, double, pair, expansion, exact } = Decisions::of_process();
        Self { f32: single, f64: double, pair, expansion, exact }
    }
}

#[derive(Debug, Serialize)]
struct Time {
    load: f64,
    coarse: f64,
    fine: f64,
    /// Of the first sun of a table, and of a further one in the mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    first_sun: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    further_sun: Option<f64>,
    total: f64,
}

/// When the command began, and how long reading the scene took, seconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    pub(crate) begun: Instant,
    pub(crate) load: f64,
}

impl<'a> Document<'a> {
    /// Of a bake, light by light.
    pub(crate) fn new(
        scene: &'a Scene,
        request: &Request,
        report: &'a Report,
        findings: &'a [Finding],
        clock: Clock,
    ) -> Self {
        let own = |light: usize, object: usize| {
            let own = request.own.objects.get(&object).or(request.own.lights.get(&light));
            own.filter(|_| request.detail != Detail::Faces).copied().map(DetailUsed::of)
        };
        let result = |light: usize, object: &'a ObjectReport| ObjectResult {
            detail: own(light, object.object),
            ..ObjectResult::new(scene, object)
        };
        let lights = report.lights.iter().map(|light| LightResult {
            name: &scene.lights[light.light].name,
            objects: light.objects.iter().map(|object| result(light.light, object)).collect(),
        });
        let (work, time) = (Work::of(&report.work), Time::of(&report.time, clock));
        Self { lights: lights.collect(), ..Self::frame(scene, request.detail, findings, (work, time)) }
    }

    /// Of a day of suns.
    pub(crate) fn of_day(day: &'a Day, detail: Detail, findings: &'a [Finding], clock: Clock) -> Self {
        let (work, mut time) = (Work::of(&day.report.work), Time::of(&day.report.time, clock));
        if let Some((first, further)) = day.report.lights.split_first() {
            time.first_sun = Some(first.seconds);
            let seconds: f64 = further.iter().map(|light| light.seconds).sum();
            time.further_sun = (!further.is_empty()).then(|| seconds / further.len() as f64);
        }
        let suns = Some(SunsResult::new(day));
        Self { suns, ..Self::frame(day.scene, detail, findings, (work, time)) }
    }

    /// Everything but the answer.
    fn frame(scene: &Scene, detail: Detail, findings: &'a [Finding], (work, time): (Work, Time)) -> Self {
        let findings = findings.iter().map(|finding| FindingEntry {
            kind: finding.kind.name(),
            object: &finding.subject,
            count: finding.count,
            places: &finding.places,
        });
        Self {
            schema: SCHEMA,
            umbriel: env!("CARGO_PKG_VERSION"),
            scene: SceneCounts::of(scene),
            detail: DetailUsed::of(detail),
            lights: Vec::new(),
            suns: None,
            findings: findings.collect(),
            work,
            time,
            peak_memory_bytes: peak_memory_bytes(),
        }
    }

    pub(crate) fn to_text(&self) -> String {
        // Plain structs with string keys: serialising them has no way to fail.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

impl Work {
    fn of(work: &umbriel_shadow::Work) -> Self {
        Self {
            pairs_tested: work.pairs_tested,
            pairs_registered: work.pairs_registered,
            pairs_excluded: work.pairs_excluded,
            octrees_built: work.octrees_built,
            cells: work.cells,
            rays: work.rays,
            exact_fallbacks: work.exact_fallbacks,
            portals: Portals::of(work.portals),
            decisions: DecisionCounts::of_process(),
        }
    }
}

impl Time {
    fn of(time: &umbriel_shadow::Time, clock: Clock) -> Self {
        Self {
            load: clock.load,
            coarse: time.coarse,
            fine: time.fine,
            first_sun: None,
            further_sun: None,
            total: clock.begun.elapsed().as_secs_f64(),
        }
    }
}

impl From<HourBounds> for Bounds {
    fn from(HourBounds { lower, upper, estimate }: HourBounds) -> Self {
        Self { lower, upper, estimate }
    }
}

impl From<LitArea> for Bounds {
    fn from(LitArea { lower, upper, estimate }: LitArea) -> Self {
        Self { lower, upper, estimate }
    }
}

impl<'a> SunsResult<'a> {
    fn new(day: &'a Day) -> Self {
        let objects = day.report.objects.iter().map(|object| HoursResult {
            name: day.name(object),
            area: object.area,
            lit_hours: object.lit_hours.into(),
            lit_area_hours: object.lit_area_hours.into(),
            samples: object.samples.map(|samples| samples.samples),
            sampled_hours: object.samples.map(|samples| samples.mean),
        });
        let rows = day.rows.iter().map(|Row { row, light }| SunResult {
            line: row.line,
            time: row.time.as_deref(),
            hours: hours(row.duration),
            lit_area: light.map(|light| day.report.lights[light].lit.into()).unwrap_or_default(),
        });
        Self {
            count: day.rows.len(),
            below_horizon: day.below_horizon(),
            hours: day.hours(),
            objects: objects.collect(),
            rows: rows.collect(),
        }
    }
}

impl SceneCounts {
    fn of(scene: &Scene) -> Self {
        let triangles = scene.objects.iter().map(|object| match &object.shape {
            Shape::Mesh(mesh) => mesh.triangles().len(),
            _ => 0,
        });
        let meshes = scene.objects.iter().filter(|object| matches!(object.shape, Shape::Mesh(_))).count();
        Self {
            objects: scene.objects.len(),
            triangles: triangles.sum(),
            analytic: scene.objects.len() - meshes,
            lights: scene.lights.len(),
        }
    }
}

impl DetailUsed {
    pub(crate) fn of(detail: Detail) -> Self {
        match detail {
            Detail::Depth { interior, boundary } => Self::Depth { interior_depth: interior, boundary_depth: boundary },
            Detail::Cell { edge } => Self::Cell { cell: edge },
            Detail::MaxUndecided { share } => Self::MaxUndecided { max_undecided: share },
            Detail::Time { limit } => Self::Time { time: limit.as_secs_f64() },
            Detail::Memory { bytes } => Self::Memory { memory_bytes: bytes },
            Detail::Pixel { eye, width } => Self::Pixel { pixel_eye: eye.to_array(), pixel_width: width },
            Detail::Faces => Self::Faces { faces: "whole" },
            _ => Self::Other {},
        }
    }
}

impl<'a> ObjectResult<'a> {
    fn new(scene: &'a Scene, object: &ObjectReport) -> Self {
        Self {
            name: &scene.objects[object.object].name,
            detail: None,
            area: object.area,
            area_error: object.area_error.is_finite().then_some(object.area_error),
            undecided: object.undecided(),
            lit_area: object.lit.into(),
            samples: object.samples.map(|count| count.samples),
            lit_samples: object.samples.map(|count| count.lit),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fields_stand_in_the_order_of_the_contract() {
        let (scene, report) = (Scene::default(), Report::default());
        let clock = Clock { begun: Instant::now(), load: 0.25 };
        let text =
            Document::new(&scene, &Request::everything(&scene, Detail::default()), &report, &[], clock).to_text();
        let keys = ["schema", "umbriel", "scene", "detail", "lights", "findings", "work", "time", "peak_memory_bytes"];
        let places: Vec<usize> = keys.iter().map(|key| text.find(&format!("\n  \"{key}\":")).expect(key)).collect();
        assert!(places.is_sorted(), "{text}");
        assert!(text.contains("\"interior_depth\": 4,\n    \"boundary_depth\": 8"));
        assert!(!text.contains("lit_samples"));
    }
}
