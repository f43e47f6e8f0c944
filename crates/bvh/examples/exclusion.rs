//! What exclusion saves in scenes of 10,000 bodies: how many of all pairs a plane excludes, and how many pairs of boxes
//! the coarse step tests with exclusion and without. The influences found must be the same.

mod city;

use std::{
    error::Error,
    time::{Duration, Instant},
};

use city::{Plan, lights, plans};
use umbriel_bvh::{Exclusion, Influences, ObjectTree, cannot_shadow, influences_with};
use umbriel_geometry::{Aabb, LightSource};

/// Runs of which the quickest counts.
const RUNS: usize = 5;

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    for plan in plans() {
        let begun = Instant::now();
        let tree = ObjectTree::build(&plan.boxes, &plan.families)?;
        let built = begun.elapsed().as_secs_f64() * 1e3;
        println!("\n{}: {} boxes, {} nodes, built in {built:.1} ms", plan.name, plan.boxes.len(), tree.boxes());
        println!("                    of all pairs        tested in the tree                    time, ms");
        println!("                   excluded    may     without        with   saved     without    with");
        for (name, light) in lights()? {
            println!("{name:<16} {}", row(&plan, &tree, &light)?);
        }
    }
    Ok(())
}

/// A row of the table.
fn row(plan: &Plan, tree: &ObjectTree, light: &LightSource) -> Result<String, String> {
    let (with, time_with) = quickest(tree, light, Exclusion::Planes);
    let (without, time_without) = quickest(tree, light, Exclusion::Off);
    if (0..plan.boxes.len() as u32).any(|object| with.occluders_of(object) != without.occluders_of(object)) {
        return Err(format!("{}: exclusion changes what is found", plan.name));
    }
    let (with, without) = (with.counts(), without.counts());
    let saved = percent(without.tested - with.tested, without.tested);
    let pairs = (plan.boxes.len() * (plan.boxes.len() - 1)) as u64;
    let excluded = percent(excluded_in_a_loop(&plan.boxes, light), pairs);
    let may = 100.0 * with.registered as f64 / pairs as f64;
    let [time_without, time_with] = [time_without, time_with].map(|time| time.as_secs_f64() * 1e3);
    Ok(format!(
        "{excluded} {may:>6.3} % {:>9} {:>11} {saved} {time_without:>11.1} {time_with:>7.1}",
        without.tested, with.tested
    ))
}

fn percent(part: u64, whole: u64) -> String {
    format!("{:>6.1} %", 100.0 * part as f64 / whole as f64)
}

/// How many of all pairs of different boxes a plane excludes.
fn excluded_in_a_loop(boxes: &[Aabb], light: &LightSource) -> u64 {
    let excluded_of =
        |receiver: &Aabb| boxes.iter().filter(|occluder| cannot_shadow(occluder, receiver, light)).count();
    boxes.iter().map(|receiver| excluded_of(receiver) as u64).sum()
}

fn quickest(tree: &ObjectTree, light: &LightSource, exclusion: Exclusion) -> (Influences, Duration) {
    let run = || {
        let begun = Instant::now();
        let found = influences_with(tree, light, |_receiver| true, exclusion);
        (found, begun.elapsed())
    };
    let first = run();
    (1..RUNS).map(|_| run()).fold(first, |best, next| if next.1 < best.1 { next } else { best })
}
