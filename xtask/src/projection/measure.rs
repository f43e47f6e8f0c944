//! What a method needs for the rays of a model, at its best depth.

use std::sync::Arc;

use anyhow::Result;
use glam::DVec3;
use serde::Serialize;
use umbriel_bvh::{Hit, TriangleBvh};
use umbriel_octree::{Projection, ProjectionOptions, Viewpoint};

use super::models::Model;
use crate::bench::clock::timed;

/// How the nearest hits of a picture, or the lit points of a light, are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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
#[derive(Clone, Debug, Serialize)]
pub(super) struct Figure {
    pub(super) method: Method,
    /// Level of the octree that was quickest; none for the BVH.
    pub(super) depth: Option<u8>,
    /// Seconds of processor time for all rays, on one thread.
    pub(super) seconds: f64,
    /// Seconds of building, on one thread.
    pub(super) build: f64,
    /// Bytes of what the method uses.
    pub(super) bytes: Option<usize>,
    /// How many rays hit, or points are blocked: the same for all methods.
    pub(super) hits: u64,
}

/// The figures of a set of rays.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    pub(super) model: &'static str,
    pub(super) triangles: usize,
    pub(super) rays: Rays,
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

/// For how many times the rays maps are built: time of building stands apart, so finer ones may be the better ones.
const FINENESS: [u64; 2] = [1, 16];

/// Runs of which the quickest counts.
const RUNS: usize = 2;

/// The three methods on one set of rays.
pub(super) fn row(model: &Model, bvh: &(TriangleBvh, f64), rays: Rays, side: u64, levels: &[u8]) -> Result<Row> {
    let questions = Questions::new(model, &bvh.0, rays, side);
    let mut best: [Option<Figure>; 2] = [None, None];
    let variants = levels.iter().flat_map(|&level| FINENESS.map(|times| (level, times)));
    for (max_level, times) in variants {
        let expected = questions.len() as u64 * times;
        let options = ProjectionOptions { max_level, rays: expected, ..ProjectionOptions::default() };
        let viewpoint = rays.viewpoint(model);
        let (projection, build) = timed(|| Projection::build(Arc::clone(&model.mesh), viewpoint, &options));
        let projection = projection?;
        let report = projection.report();
        let methods = if times == FINENESS[0] { &[Method::Maps, Method::Octree][..] } else { &[Method::Maps] };
        for (&method, best) in methods.iter().zip(&mut best) {
            let (seconds, hits) = quickest(|| by_projection(&projection, method, &questions));
            if best.as_ref().is_none_or(|known| seconds < known.seconds) {
                let maps = if method == Method::Maps { report.map_bytes } else { 0 };
                let bytes = Some(report.tree_bytes + maps);
                *best = Some(Figure { method, depth: Some(max_level), seconds, build: build.cpu, bytes, hits });
            }
        }
    }
    let (seconds, hits) = quickest(|| by_bvh(&bvh.0, model, rays, &questions));
    let figure = Figure { method: Method::Bvh, depth: None, seconds, build: bvh.1, bytes: None, hits };
    let figures = best.into_iter().flatten().chain([figure]).collect();
    let (triangles, count) = (model.mesh.triangles().len(), questions.len());
    Ok(Row { model: model.name, triangles, rays, side, count, figures })
}

/// Seconds of processor time of the quickest run, and what it answered.
pub(super) fn quickest(run: impl Fn() -> u64) -> (f64, u64) {
    (0..RUNS).fold((f64::INFINITY, 0), |(best, _), _| {
        let (answer, seconds) = timed(&run);
        (best.min(seconds.cpu), answer)
    })
}

pub(super) fn by_projection(projection: &Projection, method: Method, questions: &Questions) -> u64 {
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
            let mut segments = if is_maps { projection.segments() } else { projection.segments_by_descent() };
            points.iter().filter(|&&x| segments.any_hit(x)).count() as u64
        }
    }
}

pub(super) fn by_bvh(bvh: &TriangleBvh, model: &Model, rays: Rays, questions: &Questions) -> u64 {
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
