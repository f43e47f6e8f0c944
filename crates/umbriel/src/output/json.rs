//! `bake --json`: names and order of the fields are a contract.

use std::{fs, time::Instant};

use serde::Serialize;
use umbriel_scene::{Finding, Scene, Shape};
use umbriel_shadow::{Detail, ObjectReport, Report};

const SCHEMA: u32 = 1;

/// The whole document.
#[derive(Debug, Serialize)]
pub(crate) struct Document<'a> {
    schema: u32,
    umbriel: &'static str,
    scene: SceneCounts,
    detail: DetailUsed,
    lights: Vec<LightResult<'a>>,
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

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum DetailUsed {
    Depth { interior_depth: u8, boundary_depth: u8 },
    Cell { cell: f64 },
    MaxUndecided { max_undecided: f64 },
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
    area: f64,
    undecided: f64,
    lit_area: LitArea,
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lit_samples: Option<u64>,
}

#[derive(Debug, Serialize)]
struct LitArea {
    lower: f64,
    upper: f64,
    estimate: f64,
}

#[derive(Debug, Serialize)]
struct FindingEntry<'a> {
    kind: &'static str,
    object: &'a str,
    count: usize,
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
}

#[derive(Debug, Serialize)]
struct Time {
    load: f64,
    coarse: f64,
    fine: f64,
    total: f64,
}

/// When the command began, and how long reading the scene took, seconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    pub(crate) begun: Instant,
    pub(crate) load: f64,
}

impl<'a> Document<'a> {
    pub(crate) fn new(
        scene: &'a Scene,
        detail: Detail,
        report: &'a Report,
        findings: &'a [Finding],
        clock: Clock,
    ) -> Self {
        let lights = report.lights.iter().map(|light| LightResult {
            name: &scene.lights[light.light].name,
            objects: light.objects.iter().map(|object| ObjectResult::new(scene, object)).collect(),
        });
        let findings = findings.iter().map(|finding| FindingEntry {
            kind: finding.kind.name(),
            object: &finding.subject,
            count: finding.count,
        });
        let (work, time) = (report.work, report.time);
        Self {
            schema: SCHEMA,
            umbriel: env!("CARGO_PKG_VERSION"),
            scene: SceneCounts::of(scene),
            detail: DetailUsed::of(detail),
            lights: lights.collect(),
            findings: findings.collect(),
            work: Work {
                pairs_tested: work.pairs_tested,
                pairs_registered: work.pairs_registered,
                pairs_excluded: work.pairs_excluded,
                octrees_built: work.octrees_built,
                cells: work.cells,
                rays: work.rays,
                exact_fallbacks: work.exact_fallbacks,
            },
            time: Time {
                load: clock.load,
                coarse: time.coarse,
                fine: time.fine,
                total: clock.begun.elapsed().as_secs_f64(),
            },
            peak_memory_bytes: peak_memory_bytes(),
        }
    }

    pub(crate) fn to_text(&self) -> String {
        // Plain structs with string keys: serialising them has no way to fail.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
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
    fn of(detail: Detail) -> Self {
        match detail {
            Detail::Depth { interior, boundary } => Self::Depth { interior_depth: interior, boundary_depth: boundary },
            Detail::Cell { edge } => Self::Cell { cell: edge },
            Detail::MaxUndecided { share } => Self::MaxUndecided { max_undecided: share },
            _ => Self::Other {},
        }
    }
}

impl<'a> ObjectResult<'a> {
    fn new(scene: &'a Scene, object: &ObjectReport) -> Self {
        let lit = &object.lit;
        Self {
            name: &scene.objects[object.object].name,
            area: object.area,
            undecided: object.undecided(),
            lit_area: LitArea { lower: lit.lower, upper: lit.upper, estimate: lit.estimate },
            samples: object.samples.map(|count| count.samples),
            lit_samples: object.samples.map(|count| count.lit),
        }
    }
}

/// The most memory this process has held, where the system tells (Linux).
fn peak_memory_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fields_stand_in_the_order_of_the_contract() {
        let (scene, report) = (Scene::default(), Report::default());
        let clock = Clock { begun: Instant::now(), load: 0.25 };
        let text = Document::new(&scene, Detail::default(), &report, &[], clock).to_text();
        let keys = ["schema", "umbriel", "scene", "detail", "lights", "findings", "work", "time", "peak_memory_bytes"];
        let places: Vec<usize> = keys.iter().map(|key| text.find(&format!("\n  \"{key}\":")).expect(key)).collect();
        assert!(places.is_sorted(), "{text}");
        assert!(text.contains("\"interior_depth\": 4,\n    \"boundary_depth\": 8"));
        assert!(!text.contains("lit_samples"));
    }
}
