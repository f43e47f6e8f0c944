//! `cargo xtask calibrate`: the coefficients of the cost models by which rays choose their way, and what the choice costs.
//!
//! Times of all ways on meshes of several sizes, with few rays and with many, are fitted by least squares of relative
//! errors over coefficients that are not negative, those of an octree's lookups not less than those of its maps (coordinate descent, which converges for a convex problem). Rays of the eye have the BVH
//! ready; points that ask for a light have nothing. Building counts, in processor time. Then choices are held against the times: those that the library
//! makes by the coefficients that it has, those by the coefficients just fitted, and those for each model by coefficients fitted to the others.

use std::{fs, path::Path, sync::Arc};

use anyhow::{Context, Result};
use glam::DVec3;
use umbriel_bvh::{Ray, Steps, TriangleBvh};
use umbriel_geometry::{LightSource, Placement};
use umbriel_octree::{Projection, ProjectionOptions};
use umbriel_scene::{Object, Scene, Shape, Sides};
use umbriel_shadow::{
    Clutter, Expected, Place, PointCost, Points, Queries, Search, SearchChoice, SearchCosts, Silent, WayCosts,
};
use umbriel_visibility::{Acceleration, CostModel, LookupCost, Sampled, StepCost};

use super::{
    measure::{Method, Questions, Rays, by_projection},
    models::{Model, model},
};
use crate::bench::clock::timed;

/// What asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Nearest hits of a picture.
    Eye,
    /// Points of faces, to a lamp.
    Lamp,
    /// Points of faces, to a sun.
    Sun,
    /// Points by coordinates.
    Loose,
}

/// Seconds of all ways for so many rays through so many triangles, building included.
struct Sample {
    model: &'static str,
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
    /// Of the eye's rays: leaves, places in them, cells and numbers of the maps.
    built: [usize; 4],
}

/// Rays along a side of the pictures, and how many points ask.
const SIDES: [u64; 5] = [64, 256, 512, 1024, 2048];
const POINTS: [u64; 4] = [1 << 10, 1 << 14, 1 << 17, 1 << 19];

/// Rays of pictures that say what they cost: as many as a choice may be in question for.
const MANY: u64 = 30_000;

/// About so many rays of a picture are sent through the BVH to see what they look at: no fewer, and about one of so many.
const SENT: usize = 512;
const EACH: usize = 128;

/// Rays that are made ready at once.
const AT_ONCE: usize = 1 << 12;

/// Larger models take too long to build so often.
const MOST_TRIANGLES: usize = 1 << 18;

/// Rounds of the descent: far more than three unknowns need.
const ROUNDS: usize = 20_000;

const WAYS: [&str; 4] = ["direct", "BVH", "octree", "maps"];

pub(super) fn run(names: impl Iterator<Item = &'static str>, csv: Option<&Path>) -> Result<()> {
    let mut samples = Vec::new();
    for name in names {
        let Some(model) = model(name)?.filter(|model| model.mesh.triangles().len() <= MOST_TRIANGLES) else { continue };
        let bvh = TriangleBvh::build(Arc::clone(&model.mesh));
        let near = model.seen_from_near();
        for side in SIDES {
            samples.push(eye(name, &model, &bvh, side)?);
            samples.push(eye(name, &near, &bvh, side)?);
        }
        let scene = alone(&model)?;
        for count in POINTS {
            samples.push(points(name, (&model, &scene), ("lamp", model.lamp_source()?), Kind::Lamp, count));
            samples.push(points(name, (&model, &scene), ("sun", model.sun_source()?), Kind::Sun, count));
            samples.push(points(name, (&model, &scene), ("lamp", model.lamp_source()?), Kind::Loose, count));
        }
    }
    if let Some(file) = csv {
        fs::write(file, counted(&samples)).with_context(|| format!("cannot write {}", file.display()))?;
    }
    let all: Vec<&Sample> = samples.iter().collect();
    let fitted = Costs::fitted(&all);
    println!("{:#.1?}\n{:#.1?}", fitted.pictures, fitted.points);
    println!(
        "| rays | count | direct | BVH | octree | maps | `auto` takes | over the best |\n|---|---|---|---|---|---|---|---|"
    );
    for sample in &samples {
        let chosen = Costs::MEASURED.choice(sample);
        let told = sample.seconds.map(|seconds| format!("{:.1} ms", seconds * 1e3)).join(" | ");
        println!("| {} | {} | {told} | {} | {:.2} |", sample.name, sample.rays, WAYS[chosen], sample.over_best(chosen));
    }
    tell_off("by the library's coefficients", &all, |_| Costs::MEASURED);
    tell_off("by those fitted now", &all, |_| fitted);
    tell_off("by those fitted to the other models", &all, |model| {
        Costs::fitted(&all.iter().copied().filter(|sample| sample.model != model).collect::<Vec<_>>())
    });
    Ok(())
}

/// Says how far choices are from the best ways; `costs` tells by which coefficients a model's are made.
fn tell_off(title: &str, samples: &[&Sample], costs: impl Fn(&'static str) -> Costs) {
    let mut off: Vec<(f64, &Sample)> = Vec::new();
    for of_model in samples.chunk_by(|a, b| a.model == b.model) {
        let costs = costs(of_model[0].model);
        off.extend(of_model.iter().map(|sample| (sample.over_best(costs.choice(sample)), *sample)));
    }
    off.retain(|(ratio, _)| *ratio > NEAR);
    off.sort_by(|a, b| b.0.total_cmp(&a.0));
    println!("{title}: {} of {} choices take more than {NEAR} times the best", off.len(), samples.len());
    for (ratio, Sample { name, rays, .. }) in off {
        println!("    {ratio:.2} {name}, {rays}");
    }
}

impl Sample {
    /// How many times the best way's time one takes.
    fn over_best(&self, way: usize) -> f64 {
        self.seconds[way] / self.seconds.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// The coefficients of all models of costs.
#[derive(Clone, Copy)]
struct Costs {
    pictures: CostModel,
    points: SearchCosts,
}

impl Costs {
    /// The library's.
    const MEASURED: Self = Self { pictures: CostModel::MEASURED, points: SearchCosts::MEASURED };

    fn fitted(samples: &[&Sample]) -> Self {
        let of = |kind: Kind| samples.iter().copied().filter(|sample| sample.kind == kind).collect::<Vec<_>>();
        Self {
            // For fewer rays nothing is worth building.
            pictures: picture_costs(&of(Kind::Eye).into_iter().filter(|s| s.rays >= MANY).collect::<Vec<_>>()),
            points: SearchCosts {
                lamp: way_costs(&of(Kind::Lamp)),
                sun: way_costs(&of(Kind::Sun)),
                loose: way_costs(&of(Kind::Loose)),
            },
        }
    }

    /// Which way is taken.
    fn choice(&self, Sample { kind, rays, triangles, sampled, items, .. }: &Sample) -> usize {
        let costs = match kind {
            Kind::Eye => {
                let expected = self.pictures.expected(sampled, *items);
                return match CostModel::quickest(expected) {
                    Acceleration::Octree => 2,
                    Acceleration::Projection => 3,
                    Acceleration::Auto | Acceleration::Bvh => 1,
                };
            }
            Kind::Lamp => &self.points.lamp,
            Kind::Sun => &self.points.sun,
            Kind::Loose => &self.points.loose,
        };
        let clutter = Clutter { triangles: *triangles, items: *items };
        match SearchChoice::new(Acceleration::Auto, *rays, clutter, costs).chosen {
            Search::Direct => 0,
            Search::Bvh => 1,
            Search::Octree => 2,
            Search::Projection => 3,
        }
    }
}

/// So many times the best way's time is as good as the best.
const NEAR: f64 = 1.1;

/// What was counted and measured, a row a sample.
fn counted(samples: &[Sample]) -> String {
    let mut text =
        "name,rays,triangles,items,sent,nodes,packs,measured,hits,leaves,places,cells,numbers,direct,bvh,octree,maps\n"
            .to_owned();
    for Sample { name, rays, triangles, sampled: Sampled { steps, sent, .. }, items, seconds, built, .. } in samples {
        let Steps { nodes, packs, triangles: measured, hits } = steps;
        let ([leaves, places, cells, numbers], [direct, bvh, octree, maps]) = (built, seconds);
        text += &format!(
            "\"{name}\",{rays},{triangles},{items},{sent},{nodes},{packs},{measured},{hits},{leaves},{places},{cells},{numbers},{direct},{bvh},{octree},{maps}\n"
        );
    }
    text
}

/// Least seconds of processor time of several ways, run in turn, so that what else the machine does meets all alike; quick ones more often.
fn in_turn<const N: usize>(runs: [&dyn Fn() -> f64; N]) -> [f64; N] {
    let mut least = runs.map(|run| run());
    let total: f64 = least.iter().sum();
    for _ in 0..((SPENT / total) as usize).clamp(1, 6) {
        for (least, run) in least.iter_mut().zip(runs).filter(|(least, _)| **least < SLOW) {
            *least = least.min(run());
        }
    }
    least
}

/// Seconds for which ways are run again, and above which they are not.
const SPENT: f64 = 0.5;
const SLOW: f64 = 2.0;

/// Fits the model of costs of pictures.
fn picture_costs(samples: &[&Sample]) -> CostModel {
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
    let lookup = |way: usize, least: [f64; 4]| {
        let counts = |sample: &Sample| LookupCost::counts(&sample.sampled, sample.items);
        let rows = samples.iter().map(|sample| (counts(sample), sample.seconds[way]));
        let [node, hit, touch, item] = fit_from(least, rows);
        LookupCost { node, hit, touch, item }
    };
    let projection = lookup(3, [0.0; 4]);
    // Going down from the root is no quicker than looking the leaves up.
    let octree = lookup(2, [projection.node, projection.hit, projection.touch, 0.0]);
    CostModel { bvh: StepCost { ray, node, pack, triangle }, octree, projection }
}

/// Fits the model of costs of a kind of points.
fn way_costs(samples: &[&Sample]) -> WayCosts {
    let terms = |sample: &Sample| {
        let (points, triangles) = (sample.rays as f64, sample.triangles as f64);
        [points, points * triangles.log2(), triangles, sample.items]
    };
    let way = |way: usize| {
        let [base, doubling, triangle, item] = fit(samples.iter().map(|sample| (terms(sample), sample.seconds[way])));
        PointCost { base, doubling, triangle, item }
    };
    WayCosts { direct: way(0), bvh: way(1), octree: way(2), projection: way(3) }
}

/// Eye rays of a picture, square by square as pictures are taken: those that come near the model.
fn eye(name_of_model: &'static str, model: &Model, bvh: &TriangleBvh, side: u64) -> Result<Sample> {
    let (eye, bounds) = (model.picture.eye, model.mesh.bounds());
    let all = (0..side * side).map(|n| model.picture.direction(in_squares(n, side), side));
    let directions: Vec<DVec3> = all.filter(|&ray| Ray::new(eye, ray).span(&bounds).is_some()).collect();
    let questions = Questions::Directions { eye, directions };
    let directions = questions.directions();
    let rays_of =
        |directions: &[DVec3]| directions.iter().map(|&ray| (Ray::new(eye, ray), f64::INFINITY)).collect::<Vec<_>>();
    // Odd, so that rows of the picture are met at other places in turn.
    let step = (directions.len() / SENT).clamp(1, EACH) | 1;
    let some = directions.chunks(TriangleBvh::BUNDLE).step_by(step);
    let (mut steps, mut sent) = (Steps::default(), 0);
    some.for_each(|some| (steps, sent) = (steps + bvh.nearest_hits_steps(&rays_of(some)), sent + some.len()));
    let by_bvh = || {
        let hits = directions.chunks(AT_ONCE).map(|some| bvh.nearest_hits(&rays_of(some)).iter().flatten().count());
        hits.sum::<usize>()
    };
    let rays = directions.len() as u64;
    let sampled = Sampled { rays, steps, sent };
    let triangles = model.mesh.triangles().len();
    let build = |method: Method, rays: u64| {
        let deeper = if method == Method::Octree { 2 } else { 0 };
        let max_level = ProjectionOptions::level_for(triangles) + deeper;
        let options = ProjectionOptions { max_level, rays, ..ProjectionOptions::default() };
        Projection::build(Arc::clone(&model.mesh), Rays::Eye.viewpoint(model), &options)
    };
    let report = build(Method::Maps, rays)?.report();
    let by = |method: Method, rays: u64| {
        timed(|| build(method, rays).map_or(0, |built| by_projection(&built, (method, true), &questions))).1.cpu
    };
    let [ready, octree, maps] =
        in_turn([&|| timed(by_bvh).1.cpu, &|| by(Method::Octree, 0), &|| by(Method::Maps, rays)]);
    let seconds = [ready, ready, octree, maps];
    let built = [report.leaves, report.items, report.cells, report.numbers];
    let name = format!("{} ({triangles}), eye", model.name);
    let items = ProjectionOptions::expected_items(&model.mesh);
    Ok(Sample { model: name_of_model, name, kind: Kind::Eye, rays, triangles, sampled, items, seconds, built })
}

/// The pixel that comes at place `n` where squares of four by four are gone through one by one.
fn in_squares(n: u64, side: u64) -> u64 {
    let (square, within) = (n / 16, n % 16);
    let [column, row] = [square % (side / 4) * 4 + within % 4, square / (side / 4) * 4 + within / 4];
    row * side + column
}

/// The model as a scene of one object.
fn alone(model: &Model) -> Result<Scene> {
    let shape = Shape::Mesh(Arc::clone(&model.mesh));
    let object = Object::new(model.name.clone(), shape, Placement::IDENTITY, Sides::Auto)?;
    Ok(Scene { objects: vec![object], ..Scene::default() })
}

/// Points strewn over faces, or as far beside them as a light map's would be.
fn points(
    name_of_model: &'static str,
    (model, scene): (&Model, &Scene),
    (name, light): (&str, LightSource),
    kind: Kind,
    count: u64,
) -> Sample {
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
    let seconds =
        in_turn([&|| ask(None), &|| ask(Some(Acceleration::Bvh)), &|| ask(Some(Acceleration::Octree)), &|| {
            ask(Some(Acceleration::Projection))
        }]);
    let form = if kind == Kind::Loose { "loose points" } else { "points of faces" };
    let name = format!("{} ({triangles}), {form}, {name}", model.name);
    let items = ProjectionOptions::expected_items(&model.mesh);
    let sampled = Sampled::default();
    Sample { model: name_of_model, name, kind, rays: count, triangles, sampled, items, seconds, built: [0; 4] }
}

/// A point over a face, by a thousandth of its longest edge.
fn beside(model: &Model, face: usize, [u, v]: [f64; 2]) -> DVec3 {
    let [a, b, c] = model.mesh.triangles()[face].map(|corner| model.mesh.positions()[corner as usize]);
    let over = (b - a).cross(c - a).normalize_or_zero() * ((b - a).length().max((c - a).length()) / 1024.0);
    a + (b - a) * u + (c - a) * v + over
}

/// The coefficients, nanoseconds each, of terms whose sums should be these times, seconds.
fn fit<const K: usize>(samples: impl Iterator<Item = ([f64; K], f64)>) -> [f64; K] {
    fit_from([0.0; K], samples)
}

/// The same with coefficients that are no less than these.
fn fit_from<const K: usize>(least: [f64; K], samples: impl Iterator<Item = ([f64; K], f64)>) -> [f64; K] {
    // Each row over its own time: relative errors count.
    let rows: Vec<[f64; K]> = samples.map(|(terms, seconds)| terms.map(|term| term / (seconds * 1e9))).collect();
    let mut x = least;
    for _ in 0..ROUNDS {
        for j in 0..K {
            let rest = |row: &[f64; K]| 1.0 - (0..K).filter(|&k| k != j).map(|k| row[k] * x[k]).sum::<f64>();
            let along = rows.iter().map(|row| row[j] * rest(row)).sum::<f64>();
            let square = rows.iter().map(|row| row[j] * row[j]).sum::<f64>();
            // A term that is nowhere counts nothing.
            x[j] = if square > 0.0 { (along / square).max(least[j]) } else { least[j] };
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_go_through_all_pixels() {
        let mut pixels: Vec<u64> = (0..64).map(|n| in_squares(n, 8)).collect();
        assert_eq!(pixels[..6], [0, 1, 2, 3, 8, 9]);
        pixels.sort_unstable();
        assert!(pixels.into_iter().eq(0..64));
    }

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
