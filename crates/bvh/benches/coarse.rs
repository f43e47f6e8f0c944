//! What the coarse step costs beside a loop over all pairs: times of the quickest of some runs, and their ratios.

#[path = "../examples/city/mod.rs"]
mod city;

use std::{hint::black_box, time::Instant};

use city::{Plan, lights, plans};
use umbriel_bvh::{Exclusion, ObjectTree, cannot_shadow, influences_with, may_shadow};
use umbriel_geometry::{Aabb, LightSource};

/// Runs of which the quickest counts.
const RUNS: usize = 5;
/// Every so many of the receivers are asked in the loop, whose time is that many times the measured one.
const STEP: usize = 100;

#[expect(clippy::print_stdout, reason = "a benchmark shows what it measured")]
fn main() {
    println!("ms and ratios                              build   with  without/with   loop/with");
    for plan in plans() {
        let build = || ObjectTree::build(&plan.boxes, &plan.families).expect("the plan's families are a forest");
        let (tree, built) = (build(), quickest(build));
        for (name, light) in lights().expect("the lights of the plans are in range") {
            println!("{:<22} {name:<16} {built:>8.1} {}", plan.name, row(&plan, &tree, &light));
        }
    }
}

fn row(plan: &Plan, tree: &ObjectTree, light: &LightSource) -> String {
    let of = |exclusion| quickest(|| influences_with(tree, light, |_receiver| true, exclusion));
    let (with, without) = (of(Exclusion::Planes), of(Exclusion::Off));
    let looped = quickest(|| pairs_in_a_loop(&plan.boxes, light)) * STEP as f64;
    format!("{with:>6.1} {:>13.2} {:>11.1}", without / with, looped / with)
}

/// How many pairs a loop finds for some of the receivers.
fn pairs_in_a_loop(boxes: &[Aabb], light: &LightSource) -> usize {
    let may = |a: &Aabb, b: &Aabb| !cannot_shadow(a, b, light) && may_shadow(a, b, light);
    boxes.iter().step_by(STEP).map(|receiver| boxes.iter().filter(|occluder| may(occluder, receiver)).count()).sum()
}

/// Milliseconds of the quickest run.
fn quickest<T>(mut run: impl FnMut() -> T) -> f64 {
    let time = |_| {
        let begun = Instant::now();
        black_box(run());
        begun.elapsed().as_secs_f64() * 1e3
    };
    (0..RUNS).map(time).fold(f64::INFINITY, f64::min)
}
