//! `cargo xtask calibrate`: the coefficients of the cost models by which rays choose their way, and what the choice costs.
//!
//! Pictures are cast by [`RayCaster`] and points asked of [`Queries`], as commands do it: with each way asked for, and with `auto`, which has to choose first.
//! Rays of the eye have the BVH ready; points that ask for a light have nothing. Building counts. Least times of all ways, on meshes of several sizes, with few
//! rays and with many, are fitted by least squares of relative errors, which count less the farther a way is from the best, over coefficients that are not negative, those of an
//! octree's lookups not less than those of its maps (coordinate descent, which converges for a convex problem). Then `auto` is held against the best way, and so is what it would choose by the coefficients
//! just fitted, and for each model by those fitted to the others.

use std::{fs, sync::Arc};

use anyhow::{Context, Result};
use glam::DVec3;
use rayon::{ThreadPoolBuilder, prelude::*};
use umbriel_bvh::Steps;
use umbriel_geometry::{LightSource, Placement};
use umbriel_octree::ProjectionOptions;
use umbriel_scene::{Object, Scene, Shape, Sides};
use umbriel_shadow::{
    Clutter, Expected, Place, PointCost, Points, Queries, Search, SearchChoice, SearchCosts, Silent, WayCosts,
};
use umbriel_visibility::{Acceleration, CostModel, LookupCost, RayCaster, Sampled, StepCost};

use super::{
    CalibrateOptions,
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

/// Least seconds of all ways for so many rays through so many triangles, building included.
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
    /// What `auto` took, and which way: an index into [`WAYS`].
    auto: f64,
    chosen: usize,
    /// Of the eye's rays: leaves, places in them, cells and numbers of the maps.
    built: [usize; 4],
}

/// Pixels along a side of the pictures, and how many points ask.
const SIDES: [u32; 5] = [64, 256, 512, 1024, 2048];
const POINTS: [u64; 4] = [1 << 10, 1 << 14, 1 << 17, 1 << 19];

/// Rays of pictures that say what they cost: as many as a choice may be in question for.
const MANY: u64 = 30_000;

/// Larger models take too long to build so often.
const MOST_TRIANGLES: usize = 1 << 18;

/// Rounds of the descent: far more than five unknowns need.
const ROUNDS: usize = 20_000;

const WAYS: [&str; 4] = ["direct", "BVH", "octree", "maps"];

pub(super) fn run(names: &[&'static str], options: &CalibrateOptions) -> Result<()> {
    let pool = ThreadPoolBuilder::new().num_threads(options.threads).build()?;
    let mut samples = pool.install(|| measured(names))?;
    for _ in 1..options.rounds {
        let again = pool.install(|| measured(names))?;
        samples.iter_mut().zip(&again).for_each(|(least, again)| least.lower(again));
    }
    if let Some(file) = &options.csv {
        fs::write(file, counted(&samples)).with_context(|| format!("cannot write {}", file.display()))?;
    }
    let all: Vec<&Sample> = samples.iter().collect();
    let fitted = Costs::fitted(&all);
    println!("{:#.1?}\n{:#.1?}", fitted.pictures, fitted.points);
    println!("| rays | count | direct | BVH | octree | maps | `auto` | takes | over the best |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for sample in &samples {
        let Sample { name, rays, seconds: [direct, bvh, octree, maps], auto, chosen, .. } = sample;
        let told = [direct, bvh, octree, maps, auto].map(|seconds| format!("{:.1} ms", seconds * 1e3)).join(" | ");
        println!("| {name} | {rays} | {told} | {} | {:.2} |", WAYS[*chosen], sample.over_best(*auto));
    }
    tell_off("`auto` as measured", &all, |sample| sample.auto);
    tell_off("by the coefficients fitted now", &all, |sample| sample.seconds[fitted.choice(sample)]);
    for of_model in all.chunk_by(|a, b| a.model == b.model) {
        let model = of_model[0].model;
        let others = Costs::fitted(&all.iter().copied().filter(|sample| sample.model != model).collect::<Vec<_>>());
        tell_off(&format!("{model} by those fitted to the others"), of_model, |sample| {
            sample.seconds[others.choice(sample)]
        });
    }
    Ok(())
}

/// All models' rays, once.
fn measured(names: &[&'static str]) -> Result<Vec<Sample>> {
    let mut samples = Vec::new();
    for &name in names {
        let Some(model) = model(name)?.filter(|model| model.mesh.triangles().len() <= MOST_TRIANGLES) else { continue };
        let (scene, near) = (alone(&model)?, model.seen_from_near());
        let mut caster = RayCaster::new(&scene);
        for side in SIDES {
            samples.push(eye(name, &model, &mut caster, side));
            samples.push(eye(name, &near, &mut caster, side));
        }
        for count in POINTS {
            samples.push(points(name, (&model, &scene), ("lamp", model.lamp_source()?), Kind::Lamp, count));
            samples.push(points(name, (&model, &scene), ("sun", model.sun_source()?), Kind::Sun, count));
            samples.push(points(name, (&model, &scene), ("lamp", model.lamp_source()?), Kind::Loose, count));
        }
    }
    Ok(samples)
}

/// Says how far what some seconds were taken for is from the best ways.
fn tell_off(title: &str, samples: &[&Sample], seconds: impl Fn(&Sample) -> f64) {
    let over = samples.iter().map(|sample| (sample.over_best(seconds(sample)), sample));
    let mut off: Vec<(f64, &&Sample)> = over.filter(|(ratio, _)| *ratio > NEAR).collect();
    off.sort_by(|a, b| b.0.total_cmp(&a.0));
    println!("{title}: {} of {} take more than {NEAR} times the best", off.len(), samples.len());
    for (ratio, Sample { name, rays, .. }) in off {
        println!("    {ratio:.2} {name}, {rays}");
    }
}

impl Sample {
    /// How many times the best way's time so many seconds are.
    fn over_best(&self, seconds: f64) -> f64 {
        seconds / self.seconds.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// What these terms of the sample should be for one way. Where it takes twice the best way's time it counts half, since less is decided there.
    fn row<const K: usize>(&self, terms: [f64; K], way: usize) -> Row<K> {
        let seconds = self.seconds[way];
        Row { terms, seconds, weight: 1.0 / (1.0 + 2.0 * self.over_best(seconds).ln().powi(2)) }
    }

    /// Takes what was quicker when the same was measured again.
    fn lower(&mut self, again: &Self) {
        self.auto = self.auto.min(again.auto);
        self.seconds.iter_mut().zip(again.seconds).for_each(|(least, again)| *least = least.min(again));
    }
}

/// The coefficients of all models of costs.
#[derive(Clone, Copy)]
struct Costs {
    pictures: CostModel,
    points: SearchCosts,
}

impl Costs {
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
                return place_of(CostModel::quickest(expected));
            }
            Kind::Lamp => &self.points.lamp,
            Kind::Sun => &self.points.sun,
            Kind::Loose => &self.points.loose,
        };
        let clutter = Clutter { triangles: *triangles, items: *items };
        place_of_search(SearchChoice::new(Acceleration::Auto, *rays, clutter, costs).chosen)
    }
}

/// Where [`WAYS`] has what a picture's rays take.
fn place_of(way: Acceleration) -> usize {
    match way {
        Acceleration::Auto | Acceleration::Bvh => 1,
        Acceleration::Octree => 2,
        Acceleration::Projection => 3,
    }
}

/// Where [`WAYS`] has what points take.
fn place_of_search(way: Search) -> usize {
    match way {
        Search::Direct => 0,
        Search::Bvh => 1,
        Search::Octree => 2,
        Search::Projection => 3,
    }
}

/// So many times the best way's time is as good as the best.
const NEAR: f64 = 1.1;

/// What was counted and measured, a row a sample.
fn counted(samples: &[Sample]) -> String {
    let mut text =
        "name,rays,triangles,items,sent,nodes,packs,measured,hits,leaves,places,cells,numbers,direct,bvh,octree,maps,auto,chosen\n"
            .to_owned();
    for sample in samples {
        let Sample { name, rays, triangles, sampled: Sampled { steps, sent, .. }, items, .. } = sample;
        let Sample { seconds, auto, chosen, built, .. } = sample;
        let Steps { nodes, packs, triangles: measured, hits } = steps;
        let ([leaves, places, cells, numbers], [direct, bvh, octree, maps]) = (built, seconds);
        text += &format!(
            "\"{name}\",{rays},{triangles},{items},{sent},{nodes},{packs},{measured},{hits},{leaves},{places},{cells},{numbers},{direct},{bvh},{octree},{maps},{auto},{chosen}\n"
        );
    }
    text
}

/// Seconds that something takes: of the processor where one thread does it, which what else the machine does lengthens less.
fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let time = timed(work).1;
    if rayon::current_num_threads() == 1 { time.cpu } else { time.wall }
}

/// Least seconds of several ways, run in turn and the other way round, so that what else the machine does, and what is in its caches, meets all alike; quick ones more often.
fn in_turn<Way: Copy, const N: usize>(ways: [Way; N], mut run: impl FnMut(Way) -> f64) -> [f64; N] {
    let mut least = ways.map(&mut run);
    let total: f64 = least.iter().sum();
    for turn in 0..((SPENT / total) as usize).clamp(1, 24) {
        for place in 0..N {
            let place = if turn % 2 == 0 { N - 1 - place } else { place };
            if least[place] < SLOW {
                least[place] = least[place].min(run(ways[place]));
            }
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
    let [ray, node, pack, triangle] = fit([0.0; 4], samples.iter().map(|sample| sample.row(looked(sample), 1)));
    let lookup = |way: usize, least: [f64; 5]| {
        let counts = |sample: &Sample| LookupCost::counts(&sample.sampled, sample.items);
        let rows = samples.iter().map(|sample| sample.row(counts(sample), way));
        let [ray, node, hit, touch, item] = fit(least, rows);
        LookupCost { ray, node, hit, touch, item }
    };
    let projection = lookup(3, [0.0; 5]);
    // Going down from the root is no quicker than looking the leaves up.
    let LookupCost { ray: each, node: clutter, hit, touch, .. } = projection;
    let octree = lookup(2, [each, clutter, hit, touch, 0.0]);
    CostModel { bvh: StepCost { ray, node, pack, triangle }, octree, projection }
}

/// Fits the model of costs of a kind of points.
fn way_costs(samples: &[&Sample]) -> WayCosts {
    let terms = |sample: &Sample| {
        let (points, triangles) = (sample.rays as f64, sample.triangles as f64);
        [points, points * triangles.log2(), (points * sample.items).sqrt(), triangles, sample.items]
    };
    let way = |way: usize| {
        let rows = samples.iter().map(|sample| sample.row(terms(sample), way));
        let [base, doubling, touch, triangle, item] = fit([0.0; 5], rows);
        PointCost { base, doubling, touch, triangle, item }
    };
    WayCosts { direct: way(0), bvh: way(1), octree: way(2), projection: way(3) }
}

/// A picture of the scene of the model. Its BVH is ready; what else a way needs, and what choosing looks at, is not.
fn eye(name_of_model: &'static str, model: &Model, caster: &mut RayCaster, side: u32) -> Sample {
    let view = model.picture.view(side);
    let mut prepared = |way: Acceleration| caster.prepare(&view, 1, way, &CostModel::MEASURED).pop().expect("a mesh");
    let [by_maps, by_auto] = [Acceleration::Projection, Acceleration::Auto].map(&mut prepared);
    let report = by_maps.built.expect("views from outside can be projected");
    let ways = [Acceleration::Bvh, Acceleration::Octree, Acceleration::Projection, Acceleration::Auto];
    let [bvh, octree, maps, auto] = in_turn(ways, |way| {
        // What another way built is given back before the clock runs.
        caster.prepare(&view, 1, Acceleration::Bvh, &CostModel::MEASURED);
        seconds(|| {
            if way != Acceleration::Bvh {
                caster.prepare(&view, 1, way, &CostModel::MEASURED);
            }
            caster.coverage(&view)
        })
    });
    Sample {
        model: name_of_model,
        name: format!("{} ({}), eye", model.name, by_maps.triangles),
        kind: Kind::Eye,
        rays: by_maps.sampled.rays,
        triangles: by_maps.triangles,
        sampled: by_maps.sampled,
        items: ProjectionOptions::expected_items(&model.mesh),
        seconds: [bvh, bvh, octree, maps],
        auto,
        chosen: place_of(by_auto.chosen),
        built: [report.leaves, report.items, report.cells, report.numbers],
    }
}

/// The model as a scene of one object.
fn alone(model: &Model) -> Result<Scene> {
    let shape = Shape::Mesh(Arc::clone(&model.mesh));
    let object = Object::new(model.name.clone(), shape, Placement::IDENTITY, Sides::Auto)?;
    Ok(Scene { objects: [object].into(), ..Scene::default() })
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
    let expected = if kind == Kind::Loose { Expected::Loose(count) } else { Expected::Places(count) };
    let ask = |way: Option<Acceleration>| {
        let mut queries = Queries::new(scene);
        if let Some(way) = way {
            queries.prepare(&light, expected, way, &SearchCosts::MEASURED);
        }
        if kind == Kind::Loose {
            return queries.lit_many(Points::FreeDouble(&loose), &light, &Silent).map_or(0, |lit| lit.len());
        }
        let is_lit = |&&(face, [u, v]): &&(usize, [f64; 2])| {
            queries.lit(&Place::Surface { object: 0, face, u, v }, &light).is_ok_and(|answer| answer.lit)
        };
        places.par_iter().filter(is_lit).count()
    };
    let choice = Queries::new(scene).prepare(&light, expected, Acceleration::Auto, &SearchCosts::MEASURED);
    let ways = [Acceleration::Bvh, Acceleration::Octree, Acceleration::Projection, Acceleration::Auto].map(Some);
    let [direct, bvh, octree, maps, auto] =
        in_turn([None, ways[0], ways[1], ways[2], ways[3]], |way| seconds(|| ask(way)));
    let form = if kind == Kind::Loose { "loose points" } else { "points of faces" };
    Sample {
        model: name_of_model,
        name: format!("{} ({triangles}), {form}, {name}", model.name),
        kind,
        rays: count,
        triangles,
        sampled: Sampled::default(),
        items: ProjectionOptions::expected_items(&model.mesh),
        seconds: [direct, bvh, octree, maps],
        auto,
        chosen: place_of_search(choice.chosen),
        built: [0; 4],
    }
}

/// A point over a face, by a thousandth of its longest edge.
fn beside(model: &Model, face: usize, [u, v]: [f64; 2]) -> DVec3 {
    let [a, b, c] = model.mesh.triangles()[face].map(|corner| model.mesh.positions()[corner as usize]);
    let over = (b - a).cross(c - a).normalize_or_zero() * ((b - a).length().max((c - a).length()) / 1024.0);
    a + (b - a) * u + (c - a) * v + over
}

/// What a fit knows of a sample and a way.
struct Row<const K: usize> {
    terms: [f64; K],
    seconds: f64,
    /// How much it counts.
    weight: f64,
}

/// The coefficients, nanoseconds each and no less than `least`, of terms whose sums should be the rows' times.
fn fit<const K: usize>(least: [f64; K], samples: impl Iterator<Item = Row<K>>) -> [f64; K] {
    // Each row over its own time: relative errors count.
    let rows: Vec<([f64; K], f64)> =
        samples.map(|Row { terms, seconds, weight }| (terms.map(|term| term / (seconds * 1e9)), weight)).collect();
    let mut x = least;
    for _ in 0..ROUNDS {
        for j in 0..K {
            let rest = |row: &[f64; K]| 1.0 - (0..K).filter(|&k| k != j).map(|k| row[k] * x[k]).sum::<f64>();
            let along = rows.iter().map(|(row, weight)| weight * row[j] * rest(row)).sum::<f64>();
            let square = rows.iter().map(|(row, weight)| weight * row[j] * row[j]).sum::<f64>();
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
    fn a_model_that_is_one_is_found() {
        let truth = [100.0, 20.0, 3000.0];
        let cases = [1e3, 1e5, 1e6].into_iter().flat_map(|rays| [(rays, 100.0), (rays, 5e3), (rays, 3e5)]);
        let sample = |(rays, triangles): (f64, f64)| {
            let terms = [rays, rays * triangles.log2(), triangles];
            let seconds = terms.iter().zip(truth).map(|(term, cost)| term * cost).sum::<f64>() / 1e9;
            Row { terms, seconds, weight: 1.0 / (1.0 + rays.ln()) }
        };
        let found = fit([0.0; 3], cases.map(sample));
        assert!(found.iter().zip(truth).all(|(found, truth)| (found / truth - 1.0).abs() < 0.05), "{found:?}");
    }
}
