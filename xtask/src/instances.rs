//! `cargo xtask instances`: what instances of a mesh take beside a single one, by the peak memory of bakes.
//!
//! The scene is `teapots-instanced` of `../shared/data`; the other one is the same file without the node that has the instances. Pages of the program that are mapped
//! count, too, and differ from run to run by half a megabyte: the middle of some runs is taken.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::workspace::{output_of, root, umbriel};

/// Where the scene lies, from the workspace.
const SCENE: &str = "../shared/data/teapots-instanced/teapots_galore.gltf";

/// What is measured.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Options {
    /// Measure with this program instead of building one
    #[arg(long, value_name = "FILE")]
    umbriel: Option<PathBuf>,
    /// How often each scene is baked
    #[arg(long, value_name = "N", default_value = "3")]
    runs: usize,
}

pub(crate) fn run(options: &Options) -> Result<()> {
    let scene = root().join(SCENE);
    if !scene.exists() {
        println!("skipped: {SCENE} is not here");
        return Ok(());
    }
    let alone = without_instances(&scene)?;
    let [alone, all] = [&alone, &scene].map(|scene| baked(options, scene));
    let ([alone, _], [all, objects]) = (alone?, all?);
    let beyond = all - 1.2 * alone;
    println!("one of the mesh          {:5.1} MB", alone / 1e6);
    println!("{:<24} {:5.1} MB, {:.2} times that", format!("{objects} objects"), all / 1e6, all / alone);
    println!(
        "beyond 1.2 times         {:5.1} MB, {:.0} bytes an object: boxes and results",
        beyond / 1e6,
        beyond / objects
    );
    Ok(())
}

/// Writes the scene without its instances.
fn without_instances(scene: &Path) -> Result<PathBuf> {
    let mut file: Value = serde_json::from_slice(&fs::read(scene)?)?;
    let nodes = file["nodes"].as_array_mut().context("a scene without nodes")?;
    for node in nodes.iter_mut().filter(|node| node.pointer("/extensions/EXT_mesh_gpu_instancing").is_some()) {
        node["extensions"] = serde_json::json!({});
    }
    let folder = root().join("target/instances");
    fs::create_dir_all(&folder)?;
    for buffer in file["buffers"].as_array().context("a scene without buffers")? {
        let Some(uri) = buffer["uri"].as_str() else { bail!("a buffer without a file") };
        fs::copy(scene.with_file_name(uri), folder.join(uri))?;
    }
    let alone = folder.join("alone.gltf");
    fs::write(&alone, serde_json::to_vec(&file)?)?;
    Ok(alone)
}

/// The middle of the peaks of some bakes, bytes, and how many objects there are.
fn baked(options: &Options, scene: &Path) -> Result<[f64; 2]> {
    let mut peaks = Vec::new();
    let mut objects = 0;
    for _ in 0..options.runs.max(1) {
        let mut bake = umbriel(options.umbriel.as_deref());
        bake.arg("bake").arg(scene).args(["--sun", "135,40", "--quiet", "--json", "-"]);
        let result: Value = serde_json::from_str(&output_of(&mut bake)?)?;
        objects = result["lights"][0]["objects"].as_array().map_or(0, Vec::len);
        peaks.push(result["peak_memory_bytes"].as_f64().context("the peak memory is not known here")?);
    }
    peaks.sort_by(f64::total_cmp);
    Ok([peaks[peaks.len() / 2], objects as f64])
}
