//! `cargo xtask calibrate`: the coefficients of the cost models by which rays choose their way, and what the choice costs.
//!
//! Times of all ways on meshes of several sizes, with few rays and with many, are fitted by least squares of relative
//! errors over coefficients that are not negative (coordinate descent, which converges for a convex problem). Rays of the eye have the BVH
//! ready; points that ask for a light have nothing. Building counts, in processor time.

use std::sync::Arc;

use anyhow::Result;
use glam::DVec3;
use umbriel_bvh::TriangleBvh;
use umbriel_geometry::{LightSource, Placement};
use umbriel_octree::{Projection, ProjectionOptions};
use umbriel_scene::{Object, Scene, Shape, Sides};
use umbriel_shadow::{Expected, Place, Points, Queries, SearchCosts, Silent};
use umbriel_visibility::{Acceleration, RayCost};

use super::{
    measure::{Method, Questions, Rays, by_bvh, by_projection, quickest},
    models::{Model, model, names},
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
    /// Direct, BVH, octree, maps; of the eye's rays the direct way is the BVH.
    seconds: [f64; 4],
}

/// Rays along a side of the pictures, and how many points ask.
const SIDES: [u64; 4] = [64, 256, 512, 1024];
const POINTS: [u64; 4] = [1 << 10, 1 << 14, 1 << 17, 1 << 19];

/// Larger models take too long to build so often.
const MOST_TRIANGLES: usize = 1 << 18;

/// As the library has it: something is built where it should need less than this share of the time without.
const CLEARLY: f64 = 0.9;

/// Rounds of the descent: far more than three unknowns need.
const ROUNDS: usize = 20_000;

const WAYS: [&str; 4] = ["direct", "BVH", "octree", "maps"];

pub(crate) fn run() -> Result<()> {
    let mut samples = Vec::new();
    for name in names() {
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
    let of = |kinds: &[Kind]| samples.iter().filter(|sample| kinds.contains(&sample.kind)).collect::<Vec<_>>();
    let (eye, both) = (of(&[Kind::Eye]), of(&[Kind::Places, Kind::Loose]));
    let eye_costs = [1, 1, 2, 3].map(|way| fit(&eye, way));
    let tree_costs = [1, 2, 3].map(|way| fit(&both, way));
    let [bvh, octree, projection] = tree_costs;
    let [places, loose] = [Kind::Places, Kind::Loose].map(|kind| fit(&of(&[kind]), 0));
    tell("CostModel", &[("bvh", eye_costs[1]), ("octree", eye_costs[2]), ("projection", eye_costs[3])]);
    let points = [("places", places), ("loose", loose), ("bvh", bvh), ("octree", octree), ("projection", projection)];
    tell("SearchCosts", &points);
    let costs_of = |kind| match kind {
        Kind::Eye => eye_costs,
        Kind::Places => [places, bvh, octree, projection],
        Kind::Loose => [loose, bvh, octree, projection],
    };
    println!(
        "| rays | count | direct | BVH | octree | maps | `auto` takes | over the best |\n|---|---|---|---|---|---|---|---|"
    );
    let worst = samples.iter().map(|sample| judge(sample, &costs_of(sample.kind))).fold(1.0, f64::max);
    println!("at worst {worst:.2} times the best");
    Ok(())
}

/// Prints coefficients as the library has them.
fn tell(model: &str, costs: &[(&str, RayCost)]) {
    println!("{model}:");
    for (name, RayCost { base, doubling, triangle }) in costs {
        println!("    {name}: RayCost {{ base: {base:.1}, doubling: {doubling:.1}, triangle: {triangle:.1} }},");
    }
}

/// What is chosen by these costs, as a row; how many times the best it takes.
fn judge(sample: &Sample, costs: &[RayCost; 4]) -> f64 {
    let expected = costs.map(|cost| cost.nanoseconds(sample.rays, sample.triangles));
    let best = (1..4).fold(1, |best, way| if expected[way] < expected[best] { way } else { best });
    let chosen = if expected[best] < CLEARLY * expected[0] { best } else { 0 };
    let ratio = sample.seconds[chosen] / sample.seconds.into_iter().fold(f64::INFINITY, f64::min);
    let told = sample.seconds.map(|seconds| format!("{:.1} ms", seconds * 1e3)).join(" | ");
    println!("| {} | {} | {told} | {} | {ratio:.2} |", sample.name, sample.rays, WAYS[chosen]);
    ratio
}

/// Eye rays of a picture.
fn eye(model: &Model, bvh: &TriangleBvh, side: u64) -> Result<Sample> {
    let questions = Questions::new(model, bvh, Rays::Eye, side);
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
    let seconds = [ready, ready, by(Method::Octree, 0)?, by(Method::Maps, questions.len() as u64)?];
    let name = format!("{} ({triangles}), eye", model.name);
    Ok(Sample { name, kind: Kind::Eye, rays: questions.len() as u64, triangles, seconds })
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
    let form = if kind == Kind::Loose { "loose points" } else { "points of faces" };
    Sample { name: format!("{} ({triangles}), {form}, {name}", model.name), kind, rays: count, triangles, seconds }
}

/// A point over a face, by a thousandth of its longest edge.
fn beside(model: &Model, face: usize, [u, v]: [f64; 2]) -> DVec3 {
    let [a, b, c] = model.mesh.triangles()[face].map(|corner| model.mesh.positions()[corner as usize]);
    let over = (b - a).cross(c - a).normalize_or_zero() * ((b - a).length().max((c - a).length()) / 1024.0);
    a + (b - a) * u + (c - a) * v + over
}

/// The coefficients of one way.
fn fit(samples: &[&Sample], way: usize) -> RayCost {
    // Each row over its own time: relative errors count.
    let rows: Vec<[f64; 3]> = samples
        .iter()
        .map(|sample| {
            let nanoseconds = sample.seconds[way] * 1e9;
            let triangles = sample.triangles as f64;
            [sample.rays as f64, sample.rays as f64 * triangles.log2(), triangles].map(|term| term / nanoseconds)
        })
        .collect();
    let mut x = [0.0; 3];
    for _ in 0..ROUNDS {
        for j in 0..3 {
            let rest = |row: &[f64; 3]| 1.0 - (0..3).filter(|&k| k != j).map(|k| row[k] * x[k]).sum::<f64>();
            let along = rows.iter().map(|row| row[j] * rest(row)).sum::<f64>();
            let square = rows.iter().map(|row| row[j] * row[j]).sum::<f64>();
            x[j] = (along / square).max(0.0);
        }
    }
    RayCost { base: x[0], doubling: x[1], triangle: x[2] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_that_is_one_is_found() {
        let truth = RayCost { base: 100.0, doubling: 20.0, triangle: 3000.0 };
        let sample = |(rays, triangles): (u64, usize)| Sample {
            name: String::new(),
            kind: Kind::Eye,
            rays,
            triangles,
            seconds: [truth.nanoseconds(rays, triangles) / 1e9; 4],
        };
        let cases =
            [1 << 12, 1 << 16, 1 << 20].into_iter().flat_map(|rays| [(rays, 100), (rays, 5_000), (rays, 300_000)]);
        let samples: Vec<Sample> = cases.map(sample).collect();
        let found = fit(&samples.iter().collect::<Vec<_>>(), 1);
        assert!((found.base - 100.0).abs() < 5.0 && (found.triangle - 3000.0).abs() < 30.0, "{found:?}");
        assert!((found.doubling - 20.0).abs() < 1.0, "{found:?}");
    }
}
