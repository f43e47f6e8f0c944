//! `cargo xtask projection`: rays looked up in projected octrees against ordinary traversal and the BVH.
//!
//! The experiment of Wei, Geng and Zhang (2015) on other models: for each model, kind and number of rays, each method at its
//! best depth, time of building apart. One thread, processor time, the quickest run; the same octree and the same
//! triangle tests for maps and traversal, so that only the way to the leaves differs.

mod calibrate;
mod judge;
mod measure;
mod models;
mod report;

use std::{fs, path::PathBuf, sync::Arc};

use anyhow::{Context, Result, ensure};
use umbriel_bvh::TriangleBvh;

use crate::{
    bench::clock::timed,
    workspace::{cargo, succeed},
};
use measure::{Rays, Row};
use models::{model, names};

/// What is measured.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Options {
    /// Only these models
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    model: Vec<String>,
    /// Rays along a side of the picture
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "256,512,1024,2048")]
    side: Vec<u64>,
    /// Depths among which each method has its best
    #[arg(long, value_name = "LEVEL", value_delimiter = ',', default_value = "4,5,6,7,8,9,10")]
    levels: Vec<u8>,
    /// Compare answers instead of times: so many rays of each kind a model
    #[arg(long, value_name = "RAYS")]
    judge: Option<u64>,
    /// Write all figures
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draw them
    #[arg(long, value_name = "FILE.svg")]
    chart: Option<PathBuf>,
}

pub(crate) fn run(options: &Options) -> Result<()> {
    if cfg!(debug_assertions) {
        return again_for_release();
    }
    for asked in &options.model {
        ensure!(names().any(|name| name == asked), "no model is named {asked}");
    }
    if let Some(rays) = options.judge {
        return judge::run(asked(options), rays);
    }
    let mut rows: Vec<Row> = Vec::new();
    println!("{}", report::heading());
    for name in asked(options) {
        let Some(model) = model(name)? else { continue };
        let (bvh, build) = timed(|| TriangleBvh::build(Arc::clone(&model.mesh)));
        let bvh = (bvh, build.cpu);
        for rays in Rays::ALL {
            for &side in &options.side {
                let row = measure::row(&model, &bvh, rays, side, &options.levels)?;
                println!("{}", report::line(&row));
                rows.push(row);
            }
        }
        store(options, &rows)?;
    }
    print!("{}", report::claims(&rows));
    Ok(())
}

/// Measures what the model of costs needs to know.
pub(crate) fn calibrate() -> Result<()> {
    if cfg!(debug_assertions) { again_for_release() } else { calibrate::run() }
}

/// The same command, compiled for release.
fn again_for_release() -> Result<()> {
    let mut command = cargo(&["run", "--quiet", "--release", "--package", "xtask", "--"]);
    succeed(command.args(std::env::args_os().skip(1)))
}

/// The models that are asked for.
fn asked(options: &Options) -> impl Iterator<Item = &'static str> {
    names().filter(|name| options.model.is_empty() || options.model.iter().any(|asked| asked == name))
}

/// Writes the files that are asked for.
fn store(options: &Options, rows: &[Row]) -> Result<()> {
    if let Some(file) = &options.json {
        fs::write(file, serde_json::to_string_pretty(rows)?)
            .with_context(|| format!("cannot write {}", file.display()))?;
    }
    if let Some(file) = &options.chart {
        fs::write(file, report::chart(rows)).with_context(|| format!("cannot write {}", file.display()))?;
    }
    Ok(())
}
