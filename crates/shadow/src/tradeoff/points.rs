//! Exact answers at the judged points: what a picture or a light map asks for. They are there for every scene, curved bodies included.
//!
//! Time counts what is made for the points of the one light: trees, a BVH or light space, whichever the model of costs takes, and the points.

use std::time::Instant;

use rayon::prelude::*;
use umbriel_visibility::Acceleration;

use super::{Course, MeasureDefect, Measured, verdict};
use crate::{Expected, Place, Points, Progress, Queries, SamplePoint, SearchCosts, rivals::RivalPoint};

/// By face and parameters: each answer is that of the definition.
pub(super) fn measure_places(course: &Course) -> Measured {
    let (samples, light) = (course.judge.samples(), course.source());
    let begun = Instant::now();
    let mut queries = Queries::new(course.scene);
    let expected = Expected::Places(samples.len() as u64);
    queries.prepare(light, expected, Acceleration::Auto, &SearchCosts::MEASURED);
    let first = begun.elapsed().as_secs_f64();
    let lit = |&SamplePoint { object, face, u, v, .. }: &SamplePoint| {
        queries.lit(&Place::Surface { object, face, u, v }, light).is_ok_and(|answer| answer.lit)
    };
    let lit: Vec<bool> = samples.par_iter().map(lit).collect();
    measured(lit, first, begun.elapsed().as_secs_f64() - first)
}

/// By coordinates: each answer is that of the slack box that the rounded point stands for.
pub(super) fn measure_loose(course: &Course, progress: &dyn Progress) -> Result<Measured, MeasureDefect> {
    let light = course.source();
    let row = |point: &RivalPoint| {
        let to_light = light.xyz() - light.w() * point.position;
        let is_back = !point.is_one_sided && point.normal.dot(to_light) < 0.0;
        let normal = if is_back { -point.normal } else { point.normal };
        let ([x, y, z], [a, b, c]) = (point.position.to_array(), normal.to_array());
        [x, y, z, a, b, c]
    };
    let rows: Vec<[f64; 6]> = course.judge.points().iter().map(row).collect();
    let begun = Instant::now();
    let queries = Queries::new(course.scene);
    let first = begun.elapsed().as_secs_f64();
    let lit = queries.lit_many(Points::OrientedDouble(&rows), light, progress)?;
    Ok(measured(lit, first, begun.elapsed().as_secs_f64() - first))
}

fn measured(lit: Vec<bool>, first: f64, second: f64) -> Measured {
    let (rays, bytes) = (lit.len() as u64, lit.len().div_ceil(8) as u64);
    Measured { first, second, rays, pieces: 0, bytes, stated: lit.into_iter().map(verdict).collect() }
}
