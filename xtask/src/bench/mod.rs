//! `cargo xtask bench`: the whole job against ray engines, from a loaded scene to stored answers.
//!
//! The unit is decisions a second at equal answers: the same surface points, the same light, builds included on both
//! sides, faces that look away free on both sides. Times are the quickest of several interleaved runs; on one thread
//! the processor time counts, which other work on the machine disturbs least. Programs are compiled for release.

mod by_definition;
mod chart;
pub(crate) mod clock;
mod contest;
mod duel;
mod embree;
mod exact;
mod guard;
mod judge;
mod law;
mod micro;
mod offsets;
mod options;
mod proofs;
mod rays;
mod rivals;
mod scaling;
mod scenes;
mod table;

use std::fs;

use anyhow::{Context, Result, ensure};
use umbriel_scene::Scene;

use crate::workspace::{cargo, succeed};
use contest::{Contest, Task, asked_lights, print_memory};
use embree::{Embree, Order};
use scenes::{CLASSES, Class};
use table::{Row, heading, json};

pub(crate) use {
    guard::run as guard,
    offsets::run as offsets,
    options::Options,
    scenes::{city, knot},
};

/// Measures what is asked for.
pub(crate) fn run(options: &Options) -> Result<()> {
    if options.micro {
        return micro::run();
    }
    if options.guard {
        return guard();
    }
    if cfg!(debug_assertions) {
        return again_for_release();
    }
    guard::no_calls_for_operations()?;
    let options = &options.clone().completed();
    if options.memory {
        return memory(options);
    }
    if options.proofs || options.exact {
        return if options.proofs { proofs::run(options) } else { exact::run(options) };
    }
    let mut embree = match Embree::start() {
        Ok(embree) => Some(embree),
        Err(error) => {
            println!("no Embree: {error:#}");
            None
        }
    };
    println!("{}", heading());
    if options.scaling {
        let series = scaling::run(options, embree.as_mut())?;
        series.iter().for_each(|series| println!("{}", law::describe(series)));
        return store(options, &[], &series);
    }
    let mut rows: Vec<Row> = Vec::new();
    for class in classes(options) {
        let Some(scene) = (class.make)()? else {
            println!("{:<8} left out: its data is not there ({})", class.name, class.purpose);
            continue;
        };
        rows.extend(contests((class.name, true), &scene, options, embree.as_mut())?);
        // Stored as it goes: a long run that is cut off keeps what it has.
        store(options, &rows, &[])?;
    }
    for file in &options.file {
        let name = file.file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
        rows.extend(contests((&name, false), &scenes::of_file(file)?, options, embree.as_mut())?);
        store(options, &rows, &[])?;
    }
    Ok(())
}

/// One scene, by its name and whether `--scene` makes it: its samples, or loose points in both orders.
fn contests(
    (name, is_class): (&str, bool),
    scene: &Scene,
    options: &Options,
    mut embree: Option<&mut Embree>,
) -> Result<Vec<Row>> {
    let lights: Vec<_> = asked_lights(scene, options).into_iter().map(|light| vec![light]).collect();
    ensure!(!lights.is_empty(), "{name} has none of the lights");
    let tasks = match options.points {
        true => &[Task::Points(Order::Coherent), Task::Points(Order::Shuffled)][..],
        false => &[Task::Samples],
    };
    let mut contest = Contest {
        name,
        scene,
        lights,
        samples: &options.samples,
        threads: &options.threads,
        task: Task::Samples,
        options,
        is_class,
    };
    let mut rows = Vec::new();
    for &task in tasks {
        contest.task = task;
        rows.extend(contest.run(embree.as_deref_mut())?);
    }
    Ok(rows)
}

/// What the first of the scenes takes.
fn memory(options: &Options) -> Result<()> {
    match classes(options).next().map(|class| (class.make)()).transpose()?.flatten() {
        Some(scene) => print_memory(&scene, options),
        None => Ok(()),
    }
}

/// The scenes that are asked for.
fn classes(options: &Options) -> impl Iterator<Item = &'static Class> {
    let all = options.scene.is_empty() && options.file.is_empty();
    let is_asked = move |class: &&Class| all || options.scene.iter().any(|scene| scene == class.name);
    CLASSES.iter().filter(is_asked)
}

/// The same command, compiled for release.
fn again_for_release() -> Result<()> {
    let mut command = cargo(&["run", "--quiet", "--release", "--package", "xtask"]);
    if cfg!(feature = "rivals") {
        command.args(["--features", "rivals"]);
    }
    succeed(command.arg("--").args(std::env::args_os().skip(1)))
}

/// Writes the files that are asked for.
fn store(options: &Options, rows: &[Row], series: &[scaling::Series]) -> Result<()> {
    if let Some(file) = &options.json {
        fs::write(file, json(rows, series)?).with_context(|| format!("cannot write {}", file.display()))?;
    }
    if let Some(file) = &options.chart {
        fs::write(file, chart::draw(rows, series)).with_context(|| format!("cannot write {}", file.display()))?;
    }
    Ok(())
}
