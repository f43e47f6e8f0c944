//! `cargo xtask projection`: rays looked up in projected octrees against ordinary traversal and the BVH.
//!
//! The experiment of Wei, Geng and Zhang (2015) on other models: for each model, kind and number of rays, each method at its
//! best depth, time of building apart. One thread, processor time, the quickest run; the same octree and the same
//! triangle tests for maps and traversal, so that only the way to the leaves differs. What blocked the last shadow ray is tried first where that is
//! asked for: it settles most of them before leaves are looked for.

mod calibrate;
mod chart;
mod judge;
mod measure;
mod models;
mod moving;
mod report;

use std::{fs, path::PathBuf, sync::Arc};

use anyhow::{Context, Result, bail};
use umbriel_bvh::TriangleBvh;

use crate::{
    bench::clock::timed,
    workspace::{cargo, succeed},
};
use measure::{Rays, Row};
use models::{Model, model, names};

/// What is measured.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Options {
    /// Only these models
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    model: Vec<String>,
    /// Rays along a side of the picture
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "256,512,1024,2048")]
    side: Vec<u64>,
    /// Let shadow rays try first what blocked the one before, as the library's queries do; without it octree and maps are asked for each ray by
    /// itself, as in the source
    #[arg(long)]
    last_blocker: bool,
    /// Compare answers instead of times: so many rays of each kind a model, of all fixtures and models
    #[arg(long, value_name = "RAYS")]
    judge: Option<u64>,
    /// Measure instead what a projection costs to renew after a part of the model moved
    #[arg(long, conflicts_with = "judge")]
    moving: bool,
    /// Rows written by --json before: table, chart and claims count them too; unless models are named, nothing else is measured
    #[arg(long, value_name = "FILE", value_delimiter = ',')]
    with: Vec<PathBuf>,
    /// Write the figures as a table in Markdown
    #[arg(long, value_name = "FILE.md")]
    table: Option<PathBuf>,
    /// Write all figures
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draw them
    #[arg(long, value_name = "FILE.svg")]
    chart: Option<PathBuf>,
}

/// What models of costs are fitted to.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct CalibrateOptions {
    /// Only these models
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    model: Vec<String>,
    /// Write what was counted and measured
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Go through all of it so many times, and let the least times count
    #[arg(long, value_name = "N", default_value_t = 1)]
    rounds: u32,
    /// Threads; 0 takes what there is. Building and casting share them alike, so the models are fitted on one
    #[arg(long, value_name = "N", default_value_t = 1)]
    threads: usize,
}

pub(crate) fn run(options: &Options) -> Result<()> {
    if cfg!(debug_assertions) {
        return again_for_release();
    }
    check(&options.model)?;
    if let Some(rays) = options.judge {
        return judge::run(judged(options), rays);
    }
    if options.moving {
        return moving::run(asked(&options.model));
    }
    let mut rows: Vec<Row> = Vec::new();
    for file in &options.with {
        let text = fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
        rows.extend(serde_json::from_str::<Vec<Row>>(&text).with_context(|| format!("{}", file.display()))?);
    }
    let is_measured = options.with.is_empty() || !options.model.is_empty();
    println!("{}", report::heading());
    for name in asked(&options.model).take_while(|_| is_measured) {
        let Some(model) = model(name)? else { continue };
        let (bvh, build) = timed(|| TriangleBvh::build(Arc::clone(&model.mesh)));
        let bvh = (bvh, build.cpu);
        for rays in Rays::ALL {
            for &side in &options.side {
                let row = measure::row(&model, &bvh, (rays, options.last_blocker), side)?;
                println!("{}", report::line(&row));
                rows.push(row);
            }
        }
        store(options, &rows)?;
    }
    store(options, &rows)?;
    print!("{}", report::claims(&rows));
    Ok(())
}

/// Measures what the models of costs need to know.
pub(crate) fn calibrate(options: &CalibrateOptions) -> Result<()> {
    if cfg!(debug_assertions) {
        return again_for_release();
    }
    check(&options.model)?;
    calibrate::run(&asked(&options.model).collect::<Vec<_>>(), options)
}

fn check(models: &[String]) -> Result<()> {
    match models.iter().find(|asked| !names().any(|name| name == *asked)) {
        Some(unknown) => bail!("no model is named {unknown}"),
        None => Ok(()),
    }
}

/// The same command, compiled for release.
fn again_for_release() -> Result<()> {
    let mut command = cargo(&["run", "--quiet", "--release", "--package", "xtask", "--"]);
    succeed(command.args(std::env::args_os().skip(1)))
}

/// The models that are asked for; all, where none is.
fn asked(models: &[String]) -> impl Iterator<Item = &'static str> {
    names().filter(|name| models.is_empty() || models.iter().any(|asked| asked == name))
}

/// The models whose answers are compared: those asked for, else every scene there is.
fn judged(options: &Options) -> Box<dyn Iterator<Item = Result<Option<Model>>> + '_> {
    if !options.model.is_empty() {
        return Box::new(asked(&options.model).map(model));
    }
    let files = models::scene_files().into_iter().map(|file| Ok(models::model_of(&file)));
    Box::new(files.chain(models::made().map(model)))
}

/// Writes the files that are asked for.
fn store(options: &Options, rows: &[Row]) -> Result<()> {
    if let Some(file) = &options.table {
        fs::write(file, report::markdown(rows)).with_context(|| format!("cannot write {}", file.display()))?;
    }
    if let Some(file) = &options.json {
        fs::write(file, serde_json::to_string_pretty(rows)?)
            .with_context(|| format!("cannot write {}", file.display()))?;
    }
    if let Some(file) = &options.chart {
        fs::write(file, chart::draw(rows)).with_context(|| format!("cannot write {}", file.display()))?;
    }
    Ok(())
}
