//! The source's tables of soft shadows redone, as docs/soft.md holds them: the robot under three lights in three sizes of pictures, and in motion, by all methods.
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

/// The robot's way from frame to frame, and how many frames there are.
const MOTION: [&str; 4] = ["--frames", "10", "--step", "0.5,0,0"];

/// Prints the tables.
///
/// # Errors
/// If a run fails, or if kernels from boxes are slower than PCSS in some row.
pub(crate) fn run(options: &Options) -> Result<()> {
    succeed(&mut cargo(&["build", "--quiet", "--release", "--package", "umbriel"]))?;
    let folder = root().join("target/soft");
    fs::create_dir_all(&folder)?;
    let fixtures = root().join("fixtures");
    fs::copy(fixtures.join("robot-parts.obj"), folder.join("robot-parts.obj"))?;
    let robot = fs::read_to_string(fixtures.join("robot.toml"))?;
    println!("| light | picture | {} | pcss/boxes | average-depth/boxes |", METHODS.join(" | "));
    println!("|---|---|{}---|---|", "---|".repeat(METHODS.len()));
    let mut slower = Vec::new();
    for light in LIGHTS {
        let scene = folder.join("robot.toml");
        fs::write(&scene, with_light(&robot, light)?)?;
        for picture in PICTURES {
            let pictures = Pictures::of(&scene, picture, options.threads, &[])?;
            println!("| {light} x {light} | {picture} | {} |", pictures.row()?);
            if pictures.seconds("pcss")? <= pictures.seconds("boxes")? {
                slower.push(format!("{light} x {light}, {picture}"));
            }
        }
    }
    println!("\n| frames | depth map | {} |", METHODS.join(" | "));
    println!("|---|---|{}", "---|".repeat(METHODS.len()));
    let moving = Pictures::of(&fixtures.join("robot.toml"), PICTURES[0], options.threads, &MOTION)?;
    println!("| {} | {} |", MOTION[1], moving.motion()?);
    ensure!(slower.is_empty(), "kernels from boxes are not faster than PCSS: {}", slower.join("; "));
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

/// What a run tells of its pictures.
struct Pictures(Value);

impl Pictures {
    /// All methods on a scene.
    fn of(scene: &Path, picture: &str, threads: u32, options: &[&str]) -> Result<Self> {
        let mut command = Command::new(root().join("target/release/umbriel"));
        command.arg("soft").arg(scene).args(["--size", picture, "--json", "-", "--quiet", "--receiver", "floor"]);
        command.args(["--boundary-depth", "2", "--threads", &threads.to_string()]).args(options);
        command.args(METHODS.iter().flat_map(|method| ["--method", method]));
        let document: Value = serde_json::from_str(&output_of(&mut command)?)?;
        Ok(Self(document["pictures"].clone()))
    }

    fn number(&self, method: &str, key: &str) -> Result<f64> {
        let methods = self.0["methods"].as_array().context("methods")?;
        let entry = methods.iter().find(|entry| entry["name"] == method);
        entry.and_then(|entry| entry[key].as_f64()).with_context(|| format!("{key} of {method}"))
    }

    fn seconds(&self, method: &str) -> Result<f64> {
        self.number(method, "seconds")
    }

    /// Milliseconds and RMSE of all methods, and what others take beside boxes.
    fn row(&self) -> Result<String> {
        let mut cells = Vec::new();
        for method in METHODS {
            cells.push(format!("{:.1} ({:.3})", 1e3 * self.seconds(method)?, self.number(method, "rmse")?));
        }
        for rival in ["pcss", "average-depth"] {
            cells.push(format!("{:.1}", self.seconds(rival)? / self.seconds("boxes")?));
        }
        Ok(cells.join(" | "))
    }

    /// Milliseconds a frame: the depth map's, and all methods'.
    fn motion(&self) -> Result<String> {
        let map = self.0["depth_map_seconds"].as_f64().context("the depth map's time")?;
        let mut cells = vec![format!("{:.1}", 1e3 * map)];
        for method in METHODS {
            cells.push(format!("{:.1}", 1e3 * self.seconds(method)?));
        }
        Ok(cells.join(" | "))
    }
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
