//! The source's table of soft shadows redone: the robot under three lights in three sizes of pictures, all methods.
//!
//! Duan, "A Fast Soft Shadows Algorithm for Dynamic Scene in MMOG" (2009): square lights from 4×4 to 12×12 over a robot of 100 units, a depth map of 2048².
//! Each row is a run of `umbriel soft` compiled for release; all methods of a row shade the same points one after the other.

use std::{fs, path::Path, process::Command};

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::workspace::{cargo, output_of, root, succeed};

/// Edges of the square light, in units of a robot a hundred units high.
const LIGHTS: [f64; 3] = [4.0, 8.0, 12.0];

const PICTURES: [&str; 3] = ["800x600", "1024x768", "1280x1024"];

const METHODS: [&str; 6] = ["pcf", "pcss", "average-depth", "boxes-fixed", "boxes", "boxes-refined"];

/// The fixture's light, which is 8×8.
const LIGHT: &str = "u = [2.8657, -2.5224, 1.194], v = [-1.5385, 0.0, 3.6923]";

/// Options of the task.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Threads
    #[arg(long, value_name = "N", default_value = "2")]
    threads: u32,
}

/// Prints the table.
///
/// # Errors
/// If a run fails.
pub(crate) fn run(options: &Options) -> Result<()> {
    succeed(&mut cargo(&["build", "--quiet", "--release", "--package", "umbriel"]))?;
    let folder = root().join("target/soft");
    fs::create_dir_all(&folder)?;
    let fixtures = root().join("fixtures");
    fs::copy(fixtures.join("robot-parts.obj"), folder.join("robot-parts.obj"))?;
    let robot = fs::read_to_string(fixtures.join("robot.toml"))?;
    println!(
        "Milliseconds of {} threads (RMSE), depth map 2048 x 2048; the last columns are quotients of times.\n",
        options.threads
    );
    println!("| light | picture | {} | pcss/boxes | average-depth/boxes |", METHODS.join(" | "));
    println!("|---|---|{}---|---|", "---|".repeat(METHODS.len()));
    for light in LIGHTS {
        let scene = folder.join("robot.toml");
        fs::write(&scene, with_light(&robot, light)?)?;
        for picture in PICTURES {
            println!("| {light} x {light} | {picture} | {} |", row(&scene, picture, options.threads)?);
        }
    }
    Ok(())
}

/// The scene with a light of this edge.
fn with_light(robot: &str, edge: f64) -> Result<String> {
    ensure!(robot.contains(LIGHT), "the robot's light is another than expected");
    let scale = edge / 8.0;
    let scaled = |v: [f64; 3]| v.map(|value| value * scale);
    let (u, v) = (scaled([2.8657, -2.5224, 1.194]), scaled([-1.5385, 0.0, 3.6923]));
    Ok(robot.replace(LIGHT, &format!("u = {u:?}, v = {v:?}")))
}

fn row(scene: &Path, picture: &str, threads: u32) -> Result<String> {
    let mut command = Command::new(root().join("target/release/umbriel"));
    command.arg("soft").arg(scene).args(["--size", picture, "--json", "-", "--quiet", "--receiver", "floor"]);
    command.args(["--boundary-depth", "2", "--threads", &threads.to_string()]);
    command.args(METHODS.iter().flat_map(|method| ["--method", method]));
    let document: Value = serde_json::from_str(&output_of(&mut command)?)?;
    let methods = document["pictures"]["methods"].as_array().context("methods")?;
    let number = |method: &str, key: &str| {
        let entry = methods.iter().find(|entry| entry["name"] == method);
        entry.and_then(|entry| entry[key].as_f64()).with_context(|| format!("{key} of {method}"))
    };
    let mut cells = Vec::new();
    for method in METHODS {
        cells.push(format!("{:.1} ({:.3})", 1e3 * number(method, "seconds")?, number(method, "rmse")?));
    }
    for rival in ["pcss", "average-depth"] {
        cells.push(format!("{:.1}", number(rival, "seconds")? / number("boxes", "seconds")?));
    }
    Ok(cells.join(" | "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fixture_has_the_light_that_is_scaled() {
        let robot = fs::read_to_string(root().join("fixtures/robot.toml")).expect("a fixture");
        let scaled = with_light(&robot, 4.0).expect("a light");
        assert!(scaled.contains("u = [1.43285, -1.2612, 0.597]"), "{scaled}");
    }
}
