//! `cargo xtask calibrate`: the coefficients of the cost models by which rays choose their way, and what the choice costs.
//!
//! Times of all ways on meshes of several sizes, with few rays and with many, are fitted by least squares of relative
//! errors over coefficients that are not negative (coordinate descent, which converges for a convex problem). Rays of the eye have the BVH
//! ready; points that ask for a light have nothing. Building counts, in processor time. Then the choices that the library makes, by the coefficients
//! that it has, are held against the times.

use std::sync::Arc;

use anyhow::Result;
use glam::DVec3;
use umbriel_bvh::{Ray, Steps, TriangleBvh};
use umbriel_geometry::{LightSource, Placement};
use umbriel_octree::{Projection, ProjectionOptions};
use umbriel_scene::{Object, Scene, Shape, Sides};
use umbriel_shadow::{Clutter, Expected, Place, Points, Queries, Search, SearchChoice, SearchCosts, Silent};
use umbriel_visibility::{Acceleration, Choice, CostModel, LookupCost, Sampled, StepCost};

use super::{
    measure::{Method, Questions, Rays, by_bvh, by_projection, quickest},
    models::{Model, model},
};
use crate::bench::clock::timed;

/// What asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Nearest hits of a picture.
    Eye,
    /// Points of faces, to a lamp or a sun.
    Places,
    /// Points by coordinates.
    Loose,
}

/// Seconds of all ways for so many rays through so many triangles, building included.
struct Sample {
    name: String,
    kind: Kind,
    rays: u64,
    triangles: usize,
    /// Of the eye's rays: what some looked at in the BVH.
    sampled: Sampled,
    /// Places of triangles in an octree's leaves, as expected.
    items: f64,
    /// Direct, BVH, octree, maps; of the eye's rays the direct way is the BVH.
    seconds: [f64; 4],
    /// Which of them the library takes.
    chosen: usize,
}

/// Rays along a side of the pictures, and how many points ask.
const SIDES: [u64; 5] = [64, 256, 512, 1024, 2048];
const POINTS: [u64; 4] = [1 << 10, 1 << 14, 1 << 17, 1 << 19];

/// About so many rays of a picture are sent through the BVH to see what they look at.
const SENT: usize = 512;

/// Larger models take too long to build so often.
const MOST_TRIANGLES: usize = 1 << 18;

/// Rounds of the descent: far more than three unknowns need.
const ROUNDS: usize = 20_000;

const WAYS: [&str; 4] = ["direct", "BVH", "octree", "maps"];

pub(super) fn run(names: impl Iterator<Item = &'static str>) -> Result<()> {
    let mut samples = Vec::new();
    for name in names {
        let Some(model) = model(name)?.filter(|model| model.mesh.triangles().len() <= MOST_TRIANGLES) else { continue };
        let bvh = TriangleBvh::build(Arc::clone(&model.mesh));
        for side in SIDES {
            samples.push(eye(&model, &bvh, side)?);
        }
        let scene = alone(&model)?;
        for count in POINTS {
            samples.push(points(&model, &scene, ("lamp", model.lamp_source()?), Kind::Places, count));
            samples.push(points(&model, &scene, ("sun", model.sun_source()?), Kind::Places, count));
            samples.push(points(&model, &scene, ("lamp", model.lamp_source()?), Kind::Loose, count));
        }
    }
    let of = |kind: Kind| samples.iter().filter(|sample| sample.kind == kind).collect::<Vec<_>>();
    tell_eye(&of(Kind::Eye));
    tell_points(&of(Kind::Places), &of(Kind::Loose));
    println!(
        "| rays | count | direct | BVH | octree | maps | `auto` takes | over the best |\n|---|---|---|---|---|---|---|---|"
    );
    let worst = samples.iter().map(judge).fold(1.0, f64::max);
    println!("at worst {worst:.2} times the best");
    Ok(())
}

/// Fits and prints the model of costs of pictures.
fn tell_eye(samples: &[&Sample]) {
    let looked = |sample: &Sample| {
        let Sampled { steps, sent, .. } = sample.sampled;
        let each = sample.rays as f64 / sent.max(1) as f64;
        [
            sample.rays as f64,
            each * f64::from(steps.nodes),
            each * f64::from(steps.packs),
            each * f64::from(steps.triangles),
        ]
    };
    let [ray, node, pack, triangle] = fit(samples.iter().map(|sample| (looked(sample), sample.seconds[1])));
    let bvh = StepCost { ray, node, pack, triangle };
    println!(
        "CostModel:\n    bvh: StepCost {{ ray: {ray:.1}, node: {node:.1}, pack: {pack:.1}, triangle: {triangle:.1} }},"
    );
    for (name, way) in [("octree", 2), ("projection", 3)] {
        let terms = |sample: &Sample| {
            let rays = sample.rays as f64;
            let one = bvh.nanoseconds(sample.sampled.steps, sample.sampled.sent);
            [rays, rays * one, rays * LookupCost::doublings_beyond(sample.items), sample.items]
        };
        let [base, share, beyond, item] = fit(samples.iter().map(|sample| (terms(sample), sample.seconds[way])));
        println!(
            "    {name}: LookupCost {{ base: {base:.1}, share: {share:.2}, beyond: {beyond:.1}, item: {item:.1} }},"
        );
    }
}

/// Fits and prints the model of costs of points.
fn tell_points(places: &[&Sample], loose: &[&Sample]) {
    let both = || places.iter().chain(loose).copied();
    println!("SearchCosts:");
    tell("places", places.iter().copied(), 0);
    tell("loose", loose.iter().copied(), 0);
    tell("bvh", places.iter().copied(), 1);
    tell("loose_bvh", loose.iter().copied(), 1);
    tell("octree", both(), 2);
    tell("projection", both(), 3);
}

/// Fits and prints one way of points.
fn tell<'a>(name: &str, samples: impl Iterator<Item = &'a Sample>, way: usize) {
    let terms = |sample: &Sample| {
        let (points, triangles) = (sample.rays as f64, sample.triangles as f64);
        [points, points * triangles.log2(), triangles, sample.items]
    };
    let [base, doubling, triangle, item] = fit(samples.map(|sample| (terms(sample), sample.seconds[way])));
    println!(
        "    {name}: PointCost {{ base: {base:.1}, doubling: {doubling:.1}, triangle: {triangle:.1}, item: {item:.1} }},"
    );
}

/// What is chosen, as a row; how many times the best it takes.
fn judge(sample: &Sample) -> f64 {
    let ratio = sample.seconds[sample.chosen] / sample.seconds.into_iter().fold(f64::INFINITY, f64::min);
    let told = sample.seconds.map(|seconds| format!("{:.1} ms", seconds * 1e3)).join(" | ");
    println!("| {} | {} | {told} | {} | {ratio:.2} |", sample.name, sample.rays, WAYS[sample.chosen]);
    ratio
}

/// Eye rays of a picture: those that come near the model.
fn eye(model: &Model, bvh: &TriangleBvh, side: u64) -> Result<Sample> {
    let (eye, bounds) = (model.picture.eye, model.mesh.bounds());
    let all = (0..side * side).map(|pixel| model.picture.direction(pixel, side));
    let directions: Vec<DVec3> = all.filter(|&ray| Ray::new(eye, ray).span(&bounds).is_some()).collect();
    let some = directions.iter().step_by(directions.len().div_ceil(SENT).max(1));
    let (mut steps, mut sent) = (Steps::default(), 0);
    some.for_each(|&ray| (steps, sent) = (steps + bvh.nearest_steps(eye, ray, f64::INFINITY), sent + 1));
    let rays = directions.len() as u64;
    let sampled = Sampled { rays, steps, sent };
    let choice = Choice::new(0, Acceleration::Auto, &model.mesh, sampled.clone(), &CostModel::MEASURED);
    let questions = Questions::Directions { eye, directions };
    let triangles = model.mesh.triangles().len();
    let by = |method: Method, rays: u64| -> Result<f64> {
        let deeper = if method == Method::Octree { 2 } else { 0 };
        let max_level = ProjectionOptions::level_for(triangles) + deeper;
        let options = ProjectionOptions { max_level, rays, ..ProjectionOptions::default() };
        let viewpoint = Rays::Eye.viewpoint(model);
        let (built, build) = timed(|| Projection::build(Arc::clone(&model.mesh), viewpoint, &options));
        let built = built?;
        Ok(build.cpu + quickest(|| by_projection(&built, method, &questions)).0)
    };
    let ready = quickest(|| by_bvh(bvh, model, Rays::Eye, &questions)).0;
    let seconds = [ready, ready, by(Method::Octree, 0)?, by(Method::Maps, rays)?];
    let chosen = match choice.chosen {
        Acceleration::Octree => 2,
        Acceleration::Projection => 3,
        Acceleration::Auto | Acceleration::Bvh => 1,
    };
    let name = format!("{} ({triangles}), eye", model.name);
    let items = ProjectionOptions::expected_items(&model.mesh);
    Ok(Sample { name, kind: Kind::Eye, rays, triangles, sampled, items, seconds, chosen })
}

/// The model as a scene of one object.
fn alone(model: &Model) -> Result<Scene> {
    let shape = Shape::Mesh(Arc::clone(&model.mesh));
    let object = Object::new(model.name.clone(), shape, Placement::IDENTITY, Sides::Auto)?;
    Ok(Scene { objects: vec![object], ..Scene::default() })
}

/// Points strewn over faces, or as far beside them as a light map's would be.
fn points(model: &Model, scene: &Scene, (name, light): (&str, LightSource), kind: Kind, count: u64) -> Sample {
    let triangles = model.mesh.triangles().len();
    let mut state = 1u64;
    let mut unit = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let places: Vec<(usize, [f64; 2])> =
        (0..count).map(|n| ((n as usize * triangles) / count as usize, [unit() * 0.5, unit() * 0.5])).collect();
    let loose: Vec<[f64; 3]> = places.iter().map(|&(face, uv)| beside(model, face, uv).to_array()).collect();
    let ask = |way: Option<Acceleration>| {
        let run = || {
            let mut queries = Queries::new(scene);
            if let Some(way) = way {
                queries.prepare(&light, Expected::Places(count), way, &SearchCosts::MEASURED);
            }
            if kind == Kind::Loose {
                return queries.lit_many(Points::FreeDouble(&loose), &light, &Silent).map_or(0, |lit| lit.len());
            }
            let is_lit = |&&(face, [u, v]): &&(usize, [f64; 2])| {
                queries.lit(&Place::Surface { object: 0, face, u, v }, &light).is_ok_and(|answer| answer.lit)
            };
            places.iter().filter(is_lit).count()
        };
        timed(run).1.cpu
    };
    let seconds = [None, Some(Acceleration::Bvh), Some(Acceleration::Octree), Some(Acceleration::Projection)].map(ask);
    let (form, expected) = match kind {
        Kind::Loose => ("loose points", Expected::Loose(count)),
        _ => ("points of faces", Expected::Places(count)),
    };
    let items = ProjectionOptions::expected_items(&model.mesh);
    let choice = SearchChoice::new(Acceleration::Auto, expected, Clutter { triangles, items }, &SearchCosts::MEASURED);
    let chosen = match choice.chosen {
        Search::Direct => 0,
        Search::Bvh => 1,
        Search::Octree => 2,
        Search::Projection => 3,
    };
    let name = format!("{} ({triangles}), {form}, {name}", model.name);
    Sample { name, kind, rays: count, triangles, sampled: Sampled::default(), items, seconds, chosen }
}

/// A point over a face, by a thousandth of its longest edge.
fn beside(model: &Model, face: usize, [u, v]: [f64; 2]) -> DVec3 {
    let [a, b, c] = model.mesh.triangles()[face].map(|corner| model.mesh.positions()[corner as usize]);
    let over = (b - a).cross(c - a).normalize_or_zero() * ((b - a).length().max((c - a).length()) / 1024.0);
    a + (b - a) * u + (c - a) * v + over
}

/// The coefficients, nanoseconds each, of terms whose sums should be these times, seconds.
fn fit<const K: usize>(samples: impl Iterator<Item = ([f64; K], f64)>) -> [f64; K] {
    // Each row over its own time: relative errors count.
    let rows: Vec<[f64; K]> = samples.map(|(terms, seconds)| terms.map(|term| term / (seconds * 1e9))).collect();
    let mut x = [0.0; K];
    for _ in 0..ROUNDS {
        for j in 0..K {
            let rest = |row: &[f64; K]| 1.0 - (0..K).filter(|&k| k != j).map(|k| row[k] * x[k]).sum::<f64>();
            let along = rows.iter().map(|row| row[j] * rest(row)).sum::<f64>();
            let square = rows.iter().map(|row| row[j] * row[j]).sum::<f64>();
            // A term that is nowhere counts nothing.
            x[j] = if square > 0.0 { (along / square).max(0.0) } else { 0.0 };
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_that_is_one_is_found() {
        let truth = [100.0, 20.0, 3000.0];
        let cases = [1e3, 1e5, 1e6].into_iter().flat_map(|rays| [(rays, 100.0), (rays, 5e3), (rays, 3e5)]);
        let sample = |(rays, triangles): (f64, f64)| {
            let terms = [rays, rays * triangles.log2(), triangles];
            (terms, terms.iter().zip(truth).map(|(term, cost)| term * cost).sum::<f64>() / 1e9)
        };
        let found = fit(cases.map(sample));
        assert!(found.iter().zip(truth).all(|(found, truth)| (found / truth - 1.0).abs() < 0.05), "{found:?}");
    }
}
