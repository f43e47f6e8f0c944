//! What exclusion saves in scenes of 10,000 bodies: pairs of boxes tested with it and without, and the time of both.

mod city;

use std::{
    error::Error,
    time::{Duration, Instant},
};

use city::{Plan, lights, plans};
use umbriel_bvh::{Exclusion, Influences, ObjectTree, influences_with};
use umbriel_geometry::LightSource;

/// Runs of which the quickest counts.
const RUNS: usize = 3;

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    for plan in plans() {
        let begun = Instant::now();
        let tree = ObjectTree::build(&plan.boxes, &plan.families)?;
        let built = begun.elapsed();
        println!("{}: {} boxes, {} nodes, built in {built:.1?}", plan.name, plan.boxes.len(), tree.boxes());
        println!("                   registered  tested without  tested with   saved     without        with");
        for (name, light) in lights()? {
            println!("  {name:<16} {}", row(&plan, &tree, &light)?);
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
    let saved = 100.0 * (1.0 - with.tested as f64 / without.tested as f64);
    Ok(format!(
        "{:>12} {:>15} {:>12} {saved:>6.1} % {time_without:>11.1?} {time_with:>11.1?}",
        with.registered, without.tested, with.tested
    ))
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
