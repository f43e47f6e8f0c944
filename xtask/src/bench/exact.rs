//! `cargo xtask bench --exact`: what the exact levels of the filters take.
//!
//! A decision is settled by floats of 32 or 64 bits with their bounds, or else by pairs of floats, exact sums of floats, or big
//! numbers (`umbriel_geometry::decisions` counts them). What one decision takes at each of the last three levels is measured here, on
//! input that nothing before can settle; times the number of them it is the share of a job's time that exactness costs. The measured
//! decision includes the filters before it, so the share is rather too large.

use std::{hint::black_box, time::Instant};

use anyhow::Result;
use glam::DVec3;
use rayon::ThreadPool;
use umbriel_geometry::{
    Dyadic, LightSource, Point,
    blocking::{Probe, polygon_blocks},
    decisions::Decisions,
    predicates::side,
};
use umbriel_scene::Scene;
use umbriel_shadow::{Detail, Request};

use super::{
    contest::asked_lights,
    duel::{Own, ask_once, bake_once, request},
    options::Options,
    rays::Soup,
    scenes::CLASSES,
};
use crate::fixtures::SplitMix64;

/// Ordinary scenes.
const SCENES: [&str; 4] = ["bunny", "spot", "city", "delft"];
/// Runs of which the quickest counts, and decisions of one.
const RUNS: usize = 5;
const DECISIONS: usize = 20_000;

/// Prints a line for each scene, light and job.
pub(super) fn run(options: &Options) -> Result<()> {
    let costs = Costs::measure()?;
    let Costs { pair, expansion, exact } = costs;
    println!("one decision: {pair:.0} ns by pairs, {expansion:.0} ns by exact sums, {exact:.0} ns by big numbers");
    println!("scene    light      job        seconds       f32       f64   pairs    sums     big  exact levels");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    for class in CLASSES.iter().filter(|class| SCENES.contains(&class.name)) {
        if !options.scene.is_empty() && !options.scene.iter().any(|scene| scene == class.name) {
            continue;
        }
        let Some(scene) = (class.make)()? else {
            println!("{:<8} left out: its data is not there", class.name);
            continue;
        };
        for light in asked_lights(&scene, options) {
            for job in [Job::Samples, Job::Points, Job::Cells] {
                let (seconds, decisions) = job.run(&scene, light, options.samples[0], &pool)?;
                let share = costs.seconds(decisions) / seconds;
                println!(
                    "{:<8} {:<10} {:<8} {seconds:>9.3} {:>9} {:>9} {:>7} {:>7} {:>7} {:>8.3} %",
                    class.name,
                    scene.lights[light].name,
                    format!("{job:?}").to_lowercase(),
                    decisions.single,
                    decisions.double,
                    decisions.pair,
                    decisions.expansion,
                    decisions.exact,
                    100.0 * share
                );
            }
        }
    }
    Ok(())
}

/// What is asked of a scene.
#[derive(Clone, Copy, Debug)]
enum Job {
    Samples,
    Points,
    Cells,
}

impl Job {
    /// Processor time in seconds, and what was decided meanwhile.
    fn run(self, scene: &Scene, light: usize, samples: u64, pool: &ThreadPool) -> Result<(f64, Decisions)> {
        let sampled = request(scene, &[light], samples);
        let mut points = Vec::new();
        if let Self::Points = self {
            let (soup, source) = (Soup::of(scene)?, &scene.lights[light].source);
            soup.for_each_start(scene, &sampled, |_, start| points.push(start.point(source, soup.offset)));
        }
        let before = Decisions::of_process();
        let Own { seconds, .. } = match self {
            Self::Samples => bake_once(scene, &sampled, pool)?,
            Self::Points => ask_once(scene, &points, light, pool)?,
            Self::Cells => {
                let request = Request { lights: vec![light], ..Request::everything(scene, Detail::default()) };
                bake_once(scene, &request, pool)?
            }
        };
        Ok((seconds.cpu, Decisions::of_process() - before))
    }
}

/// Nanoseconds a decision.
struct Costs {
    pair: f64,
    expansion: f64,
    exact: f64,
}

impl Costs {
    fn measure() -> Result<Self> {
        let mut random = SplitMix64::new(1);
        // Numbers of 41 bits: means and sums of them are exact, products of three are too long for a pair of floats.
        let mut number = || (random.between(-1.0, 1.0) * GRID).round() / GRID;
        let mut point = || DVec3::from_array([0; 3].map(|_| number()));
        let cases: Vec<[DVec3; 5]> = (0..DECISIONS).map(|_| [0; 5].map(|_| point())).collect();
        let side_of = |[a, b, c, x]: [DVec3; 4]| {
            let [a, b, c, x] = [a, b, c, x].map(Point::exact);
            black_box(side(&a, &b, &c, &x));
        };
        let near_plane = |&[a, b, c, ..]: &[DVec3; 5]| side_of([a, b, c, a + (b - a) / 3.0 + (c - a) / 7.0]);
        let in_plane = |&[a, b, c, ..]: &[DVec3; 5]| side_of([a, b, c, within(a, b, c)]);
        // The way of a point of a face meets an edge exactly.
        let sun = LightSource::sun(point().to_array())?;
        let on_edge = |&[a, b, c, along, across]: &[DVec3; 5]| {
            let middle = within(a, b, c) + sun.xyz();
            let blocker = [middle - along, middle + along, middle + across].map(Point::exact);
            let probe: Probe<Dyadic> = Probe::on_face([a, b, c].map(Point::exact), 0.25, 0.5);
            black_box(polygon_blocks(&blocker, &probe, &sun));
        };
        Ok(Self {
            pair: nanoseconds(&cases, near_plane, |decisions| decisions.pair),
            expansion: nanoseconds(&cases, in_plane, |decisions| decisions.expansion),
            exact: nanoseconds(&cases, on_edge, |decisions| decisions.exact),
        })
    }

    /// What the exact levels of these decisions take.
    fn seconds(&self, decisions: Decisions) -> f64 {
        let Self { pair, expansion, exact } = self;
        let counted = [(pair, decisions.pair), (expansion, decisions.expansion), (exact, decisions.exact)];
        counted.iter().map(|&(cost, number)| 1e-9 * cost * number as f64).sum()
    }
}

/// Coordinates are multiples of one over this.
const GRID: f64 = (1u64 << 40) as f64;

/// A point of a triangle, without rounding.
fn within(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    a + (b - a) * 0.25 + (c - a) * 0.5
}

/// Nanoseconds over the number of decisions of one level.
fn nanoseconds(cases: &[[DVec3; 5]], decide: impl Fn(&[DVec3; 5]), level: impl Fn(Decisions) -> u64) -> f64 {
    let run = || {
        let (before, begun) = (Decisions::of_thread(), Instant::now());
        cases.iter().for_each(&decide);
        begun.elapsed().as_secs_f64() * 1e9 / level(Decisions::of_thread() - before).max(1) as f64
    };
    (0..RUNS).map(|_| run()).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_levels_have_a_cost() {
        let costs = Costs::measure().expect("a sun");
        // Were the cases settled by filters, one decision would be charged with the time of thousands.
        assert!([costs.pair, costs.expansion, costs.exact].iter().all(|cost| (1.0..1e6).contains(cost)));
        let decisions = Decisions { single: 9, double: 9, pair: 0, expansion: 2, exact: 1 };
        let known = 1e-9 * (2.0 * costs.expansion + costs.exact);
        assert!((costs.seconds(decisions) / known - 1.0).abs() < 1e-12);
    }
}
