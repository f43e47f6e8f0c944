//! The benchmark as a check: the bake must not collapse, and in a release no vector operation may be a call.
//!
//! It is compared with single rays through the workspace's own tree in the same process, in turn, so the speed of the
//! machine and the settings of the compiler cancel. The limits are far below what is usual: they catch a lost order of
//! magnitude, not a bad day.

use std::{env, process::Command};

use anyhow::{Result, ensure};
use umbriel_scene::Scene;

use super::{
    duel::{bake_once, request},
    rays::Soup,
    rivals::{OWN_TREE, Starts},
    scenes::{city, knot},
};

const SAMPLES: u64 = 1 << 17;
const ROUNDS: usize = 3;
/// How many times as fast as the rival the bake must be.
const LEAST_CITY: f64 = 0.2;
const LEAST_KNOT: f64 = 0.1;

/// Fails if some ratio to the rival is below its limit, or if this program has vector operations as functions of their own.
pub(crate) fn run() -> Result<()> {
    no_calls_for_operations()?;
    let cases: [(&str, Scene, f64); 2] = [("city", city(400)?, LEAST_CITY), ("knot", knot(300, 60)?, LEAST_KNOT)];
    for (name, scene, least) in cases {
        for light in 0..scene.lights.len() {
            let ratio = ratio(&scene, light)?;
            let light = &scene.lights[light].name;
            println!("{name} under the {light}: {ratio:.2} times as fast as single rays, {least} at least");
            ensure!(ratio >= least, "{name} under the {light}: the bake has become slow");
        }
    }
    Ok(())
}

/// A helper of a kernel that is not inlined is compiled without the processor's features, and each of its vector operations becomes a call: right, and many times slower. Then this
/// program's table of symbols names the operations.
pub(super) fn no_calls_for_operations() -> Result<()> {
    // Unoptimised programs, and those optimised a little, are not made for speed.
    if cfg!(debug_assertions) {
        return Ok(());
    }
    let Ok(symbols) = Command::new("nm").arg(env::current_exe()?).output() else {
        println!("no nm here: whether vector operations are calls is not looked at");
        return Ok(());
    };
    let symbols = String::from_utf8_lossy(&symbols.stdout);
    let called: Vec<&str> =
        symbols.lines().filter(|name| name.contains("core_arch3x86") && name.contains("_mm")).collect();
    ensure!(
        called.is_empty(),
        "vector operations that are calls, from a closure or a helper that is not inline:\n{}",
        called.join("\n")
    );
    Ok(())
}

/// How many times as long the rival takes.
fn ratio(scene: &Scene, light: usize) -> Result<f64> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let (request, soup) = (request(scene, &[light], SAMPLES), Soup::of(scene)?);
    let starts = Starts::of(&soup, scene, &request);
    let (mut own, mut rival) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..ROUNDS {
        own = own.min(bake_once(scene, &request, &pool)?.seconds.cpu);
        rival = rival.min(starts.run(&OWN_TREE, &soup, &scene.lights[light].source)?.0.cpu);
    }
    Ok(rival / own)
}
