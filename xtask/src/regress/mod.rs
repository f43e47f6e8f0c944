//! Every fixture through the library, compared with stored results bit for bit.
//!
//! A difference is shown light by light and object by object. What a formula or another part of the library can tell is
//! checked as well, before anything is compared or stored.

mod closed_forms;
mod result;
mod sanity;

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    time::Instant,
};

use anyhow::{Context, Result, anyhow, bail, ensure};
use umbriel_geometry::{Aabb, LightSource};
use umbriel_io::{DetailSetting, LoadOptions, LoadedScene, load};
use umbriel_scene::{Light, Object};
use umbriel_shadow::{Detail, Report, Request, Silent, bake, reached_receivers};

use crate::fixtures::folder;
use result::SceneResult;
use sanity::Sanity;

/// The sun of scenes without lights, degrees.
const SUN: (f64, f64) = (200.0, 45.0);

/// A fixture, loaded and baked.
struct Baked {
    name: String,
    loaded: LoadedScene,
    report: Report,
}

/// Fails where a result is not the stored one, or cannot be right.
pub(crate) fn compare() -> Result<()> {
    let mut changed = Vec::new();
    for path in scenes()? {
        let (baked, result) = run(&path)?;
        let file = expected(&baked.name);
        let Ok(text) = fs::read_to_string(&file) else {
            println!("  no stored result");
            changed.push(baked.name);
            continue;
        };
        let stored: SceneResult =
            serde_json::from_str(&text).with_context(|| format!("{} is damaged", file.display()))?;
        let differences = result.differences(&stored);
        differences.iter().for_each(|line| println!("  changed: {line}"));
        if !differences.is_empty() {
            changed.push(baked.name);
        }
    }
    let orphans = orphans()?;
    ensure!(orphans.is_empty(), "results without a fixture: {}", orphans.join(", "));
    ensure!(
        changed.is_empty(),
        "{} changed; if that is right: cargo xtask regress --bless \"why they changed\"",
        changed.join(", ")
    );
    Ok(())
}

/// Stores the new results and the reason.
pub(crate) fn bless(reason: &str) -> Result<()> {
    ensure!(!reason.trim().is_empty() && !reason.contains('\n'), "the reason must be one line of text");
    // All of them first: where one cannot be right, nothing is stored.
    let results = scenes()?.iter().map(|path| run(path)).collect::<Result<Vec<_>>>()?;
    let mut changed = Vec::new();
    fs::create_dir_all(folder().join("expected"))?;
    for (baked, result) in results {
        let text = serde_json::to_string_pretty(&result)? + "\n";
        let file = expected(&baked.name);
        if fs::read_to_string(&file).ok().as_deref() != Some(&text) {
            fs::write(&file, text).with_context(|| format!("cannot write {}", file.display()))?;
            changed.push(baked.name);
        }
    }
    for orphan in orphans()? {
        fs::remove_file(expected(&orphan))?;
        changed.push(orphan);
    }
    if changed.is_empty() {
        println!("nothing changed");
        return Ok(());
    }
    let log = folder().join("expected/BLESSED.md");
    let before = fs::read_to_string(&log).unwrap_or_else(|_| "# Why stored results changed\n\n".to_owned());
    fs::write(&log, format!("{before}- {}: {}\n", changed.join(", "), reason.trim()))?;
    Ok(())
}

/// Whether some lit area of a fixture is known by formula.
pub(crate) fn has_closed_form(fixture: &str) -> bool {
    closed_forms::all().iter().any(|form| form.fixture == fixture)
}

/// Bakes a fixture, shows its line of the table, and fails if something in it cannot be right.
fn run(path: &Path) -> Result<(Baked, SceneResult)> {
    let begun = Instant::now();
    let baked = bake_fixture(path)?;
    let result = SceneResult::of(&baked.loaded.scene, &baked.report);
    let sanity = Sanity::of(&baked)?;
    println!("{:<16} {:6.2} s  {}", baked.name, begun.elapsed().as_secs_f64(), sanity.summary());
    if let Some(first) = sanity.complaints.first() {
        bail!("{}: {first} (and {} more)", baked.name, sanity.complaints.len() - 1);
    }
    Ok((baked, result))
}

fn bake_fixture(path: &Path) -> Result<Baked> {
    let name = stem(path);
    let mut loaded = load(path, &LoadOptions::default()).with_context(|| format!("cannot load {name}"))?;
    if loaded.scene.lights.is_empty() {
        add_lights(&mut loaded)?;
    }
    let detail = match loaded.detail {
        None => Detail::default(),
        Some(DetailSetting::Cell { edge }) => Detail::Cell { edge },
        Some(DetailSetting::MaxUndecided { share }) => Detail::MaxUndecided { share },
        Some(DetailSetting::Depth { interior, boundary }) => {
            Detail::Depth { interior: interior.unwrap_or(boundary.min(4)), boundary }
        }
        Some(DetailSetting::Memory { bytes }) => Detail::Memory { bytes },
        Some(other) => bail!("{name}: the detail {other:?} is not known here"),
    };
    let everything = Request::everything(&loaded.scene, detail);
    let receivers = reached_receivers(&loaded.scene, &everything.lights);
    let request = Request { keep_cells: true, receivers, ..everything };
    let report = bake(&loaded.scene, &request, &Silent).map_err(|_| anyhow!("{name}: cancelled"))?;
    Ok(Baked { name, loaded, report })
}

/// A sun, and a lamp above the scene, a little off its middle.
fn add_lights(loaded: &mut LoadedScene) -> Result<()> {
    let sun = LightSource::sun(loaded.sun_from_angles(SUN.0, SUN.1))?;
    let bounds = loaded.scene.objects.iter().map(Object::bounds).fold(Aabb::EMPTY, Aabb::union);
    let size = bounds.size();
    let above = [bounds.min.x + 0.375 * size.x, bounds.max.y + 0.5 * size.max_element(), bounds.min.z + 0.625 * size.z];
    let lamp = LightSource::point(above)?;
    loaded.scene.lights = vec![Light::new("sun", sun), Light::new("lamp", lamp)];
    Ok(())
}

/// All scenes in the folder of the fixtures, sorted by name.
fn scenes() -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder()).context("there are no fixtures")?;
    let mut scenes = entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<PathBuf>>>()?;
    // In a folder of its own, with a file that is no scene by itself.
    scenes.push(folder().join("office/office.toml"));
    let is_scene =
        |path: &PathBuf| path.extension().is_some_and(|e| ["toml", "obj", "gltf", "glb"].iter().any(|x| e == *x));
    scenes.retain(is_scene);
    scenes.sort();
    let names: BTreeSet<String> = scenes.iter().map(|path| stem(path)).collect();
    ensure!(names.len() == scenes.len(), "two fixtures differ in their ending only; their results would overwrite");
    ensure!(!scenes.is_empty(), "there are no fixtures; cargo xtask fixtures writes them");
    Ok(scenes)
}

fn stem(path: &Path) -> String {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}

fn expected(name: &str) -> PathBuf {
    folder().join("expected").join(format!("{name}.json"))
}

/// Stored results whose fixture is gone.
fn orphans() -> Result<Vec<String>> {
    let names: BTreeSet<String> = scenes()?.iter().map(|path| stem(path)).collect();
    let Ok(entries) = fs::read_dir(folder().join("expected")) else { return Ok(Vec::new()) };
    let mut orphans = Vec::new();
    for entry in entries {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "json") && !names.contains(&stem(&path)) {
            orphans.push(stem(&path));
        }
    }
    Ok(orphans)
}
