//! What a method needs for the rays of a model, at its best depth.

use std::sync::Arc;

use anyhow::{Result, ensure};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use umbriel_bvh::{Hit, TriangleBvh};
use umbriel_octree::{Projection, ProjectionOptions, Viewpoint};

use super::models::Model;
use crate::bench::clock::timed;

/// How the nearest hits of a picture, or the lit points of a light, are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Method {
    /// Leaves looked up in maps.
    Maps,
    /// Leaves found from the root down.
    Octree,
    /// No octree.
    Bvh,
}

/// Which rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Rays {
    /// From an eye: nearest hits.
    Eye,
    /// From what the eye sees to a lamp: any hit.
    Lamp,
    /// The same to a sun.
    Sun,
}

impl Rays {
    pub(super) const ALL: [Self; 3] = [Self::Eye, Self::Lamp, Self::Sun];

    pub(super) fn viewpoint(self, model: &Model) -> Viewpoint {
        match self {
            Self::Eye => model.picture.viewpoint(),
            Self::Lamp => Viewpoint::Point(model.lamp),
            Self::Sun => Viewpoint::Parallel(model.sun),
        }
    }
}

/// The quickest run of a method at its best depth.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Figure {
    pub(super) method: Method,
    /// Level of the octree that was quickest; none for the BVH.
    pub(super) depth: Option<u8>,
    /// Seconds of processor time for all rays, on one thread.
    pub(super) seconds: f64,
    /// Seconds of building, on one thread.
    pub(super) build: f64,
    /// Bytes of what the method uses.
    pub(super) bytes: usize,
    /// How many rays hit, or points are blocked: the same for all methods.
    pub(super) hits: u64,
}

/// The figures of a set of rays.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Row {
    pub(super) model: String,
    pub(super) triangles: usize,
    pub(super) rays: Rays,
    /// Whether shadow rays try first what blocked the one before.
    pub(super) last_blocker: bool,
    /// Rays along a side of the picture.
    pub(super) side: u64,
    /// How many rays that makes: of shadow rays, as many as the eye sees points.
    pub(super) count: usize,
    pub(super) figures: Vec<Figure>,
}

impl Row {
    pub(super) fn figure(&self, method: Method) -> Option<&Figure> {
        self.figures.iter().find(|figure| figure.method == method)
    }

    /// The time of one method over that of another.
    pub(super) fn ratio(&self, method: Method, other: Method) -> Option<f64> {
        Some(self.figure(method)?.seconds / self.figure(other)?.seconds)
    }
}

/// What is asked: directions from the eye, or points whose light is in question.
pub(super) enum Questions {
    Directions { eye: DVec3, directions: Vec<DVec3> },
    Points(Vec<DVec3>),
}

impl Questions {
    /// The rays of a picture of `side` × `side` pixels, or the points that it sees.
    pub(super) fn new(model: &Model, bvh: &TriangleBvh, rays: Rays, side: u64) -> Self {
        let directions = (0..side * side).map(|pixel| model.picture.direction(pixel, side));
        let eye = model.picture.eye;
        if rays == Rays::Eye {
            return Self::Directions { eye, directions: directions.collect() };
        }
        let seen = directions.filter_map(|direction| {
            let hit = bvh.nearest_hit(eye, direction, f64::INFINITY)?;
            // A little before the surface, so that a point's own face is not in question for every one.
            Some(eye + direction * (hit.t * OFF_THE_SURFACE))
        });
        Self::Points(seen.collect())
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Directions { directions, .. } => directions.len(),
            Self::Points(points) => points.len(),
        }
    }
}

/// How far along the way to the surface a point lies.
const OFF_THE_SURFACE: f64 = 1.0 - 1.0 / (1 << 16) as f64;

/// For how many times the rays maps are built: time of building stands apart, so finer ones are better ones.
const FINENESS: u64 = 4;

/// Runs of which the quickest counts while the best depth is searched.
const RUNS: usize = 2;

/// Runs in turn by which the methods are compared in the end.
const ROUNDS: usize = 3;

/// A projection, and the seconds that it took.
struct Built {
    level: u8,
    projection: Projection,
    seconds: f64,
}

/// The three methods on one set of rays, those with an octree at their best depths.
/// With `last_blocker` shadow rays try first what blocked the one before; those through the BVH always do.
pub(super) fn row(
    model: &Model,
    bvh: &(TriangleBvh, f64),
    (rays, last_blocker): (Rays, bool),
    side: u64,
) -> Result<Row> {
    let questions = Questions::new(model, &bvh.0, rays, side);
    let usual = ProjectionOptions::level_for(model.mesh.triangles().len());
    let build = |level: u8, expected: u64| -> Result<Built> {
        let options = ProjectionOptions { max_level: level, rays: expected, ..ProjectionOptions::default() };
        let viewpoint = rays.viewpoint(model);
        let (built, time) = timed(|| Projection::build(Arc::clone(&model.mesh), viewpoint, &options));
        Ok(Built { level, projection: built?, seconds: time.cpu })
    };
    let expected = questions.len() as u64 * FINENESS;
    let measure = |method| {
        let questions = &questions;
        move |built: &Built| quickest(|| by_projection(&built.projection, (method, last_blocker), questions)).0
    };
    let maps = at_best(usual, &|level| build(level, expected), &measure(Method::Maps))?;
    let octree = at_best(usual + 2, &|level| build(level, 0), &measure(Method::Octree))?;
    // In turn, so that what else the machine does meets all alike.
    let mut best = [(f64::INFINITY, 0); 3];
    for _ in 0..ROUNDS {
        let runs: [&dyn Fn() -> u64; 3] = [
            &|| by_projection(&maps.projection, (Method::Maps, last_blocker), &questions),
            &|| by_projection(&octree.projection, (Method::Octree, last_blocker), &questions),
            &|| by_bvh(&bvh.0, model, rays, &questions),
        ];
        for (run, best) in runs.iter().zip(&mut best) {
            let (hits, time) = timed(run);
            *best = (best.0.min(time.cpu), hits);
        }
    }
    let reports = [maps.projection.report(), octree.projection.report()];
    let figure = |method, place: usize, depth, build, bytes| Figure {
        method,
        depth,
        seconds: best[place].0,
        build,
        bytes,
        hits: best[place].1,
    };
    let figures = vec![
        figure(Method::Maps, 0, Some(maps.level), maps.seconds, reports[0].tree_bytes + reports[0].map_bytes),
        figure(Method::Octree, 1, Some(octree.level), octree.seconds, reports[1].tree_bytes),
        figure(Method::Bvh, 2, None, bvh.1, bvh.0.bytes()),
    ];
    ensure!(best.iter().all(|(_, hits)| *hits == best[0].1), "{}: the methods answer differently", model.name);
    let (triangles, count) = (model.mesh.triangles().len(), questions.len());
    Ok(Row { model: model.name.clone(), triangles, rays, last_blocker, side, count, figures })
}

/// What is quickest among levels, uphill from one: time over the level has one valley.
fn at_best(start: u8, build: &dyn Fn(u8) -> Result<Built>, measure: &dyn Fn(&Built) -> f64) -> Result<Built> {
    let first = build(start)?;
    let mut seconds = measure(&first);
    let mut best = first;
    for step in [1i8, -1] {
        let mut has_moved = false;
        while let Some(level) = best.level.checked_add_signed(step).filter(|level| (1..=12).contains(level)) {
            let next = build(level)?;
            let time = measure(&next);
            if time >= seconds {
                break;
            }
            (best, seconds, has_moved) = (next, time, true);
        }
        if has_moved {
            break;
        }
    }
    Ok(best)
}

/// Seconds of processor time of the quickest run, and what it answered.
pub(super) fn quickest(run: impl Fn() -> u64) -> (f64, u64) {
    (0..RUNS).fold((f64::INFINITY, 0), |(best, _), _| {
        let (answer, seconds) = timed(&run);
        (best.min(seconds.cpu), answer)
    })
}

pub(super) fn by_projection(
    projection: &Projection,
    (method, last_blocker): (Method, bool),
    questions: &Questions,
) -> u64 {
    let is_maps = method == Method::Maps;
    match questions {
        Questions::Directions { eye, directions } => {
            let hit = |direction: &&DVec3| {
                let nearest: Option<Hit> = if is_maps {
                    projection.nearest_hit(*eye, **direction, f64::INFINITY).unwrap_or_default()
                } else {
                    projection.nearest_hit_by_descent(*eye, **direction, f64::INFINITY).unwrap_or_default()
                };
                nearest.is_some()
            };
            directions.iter().filter(hit).count() as u64
        }
        Questions::Points(points) => {
            let new = || if is_maps { projection.segments() } else { projection.segments_by_descent() };
            let mut segments = new();
            let is_blocked = |x: DVec3| if last_blocker { segments.any_hit(x) } else { new().any_hit(x) };
            points.iter().copied().map(is_blocked).filter(|&is_blocked| is_blocked).count() as u64
        }
    }
}

fn by_bvh(bvh: &TriangleBvh, model: &Model, rays: Rays, questions: &Questions) -> u64 {
    match questions {
        Questions::Directions { eye, directions } => {
            let hit = |direction: &&DVec3| bvh.nearest_hit(*eye, **direction, f64::INFINITY).is_some();
            directions.iter().filter(hit).count() as u64
        }
        Questions::Points(points) => {
            let light = if rays == Rays::Sun { model.sun_source() } else { model.lamp_source() };
            let Ok(light) = light else { return 0 };
            let mut towards = bvh.towards(light);
            points.iter().filter(|&&x| towards.any_hit(x)).count() as u64
        }
    }
}
