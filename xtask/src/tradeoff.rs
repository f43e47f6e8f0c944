//! `cargo xtask tradeoff`: what time and memory buy, on scenes of different kinds. Figures and charts go to `docs/tradeoff`.
//!
//! The command `umbriel tradeoff` does the work; here are its scenes: some generated, some from the repository, a city where its model is at hand.

use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, ensure};

use crate::{
    fixtures::SplitMix64,
    workspace::{output_of, root, umbriel},
};

/// What is measured.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Options {
    /// Only these scenes
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    scene: Vec<String>,
    /// Points that judge
    #[arg(long, value_name = "N", default_value = "1000000")]
    points: u64,
    /// How often each setting runs
    #[arg(long, value_name = "N", default_value = "3")]
    runs: u32,
    /// Measure with this program instead of building one
    #[arg(long, value_name = "FILE")]
    umbriel: Option<PathBuf>,
    /// Where figures and charts go
    #[arg(long, value_name = "FOLDER", default_value = "docs/tradeoff")]
    folder: PathBuf,
}

/// A scene and what is interesting about it.
pub(crate) struct Course {
    pub(crate) name: &'static str,
    about: &'static str,
    pub(crate) file: PathBuf,
    pub(crate) more: &'static [&'static str],
}

/// The scenes that are polygons alone, the boxes first.
pub(crate) fn polygon_scenes() -> Result<Vec<Course>> {
    Ok(courses()?.into_iter().filter(|course| course.name != "quadrics").collect())
}

pub(crate) fn run(options: &Options) -> Result<()> {
    let all = courses()?;
    for asked in &options.scene {
        ensure!(all.iter().any(|course| course.name == asked), "no scene is named {asked}");
    }
    let folder = root().join(&options.folder);
    fs::create_dir_all(&folder).with_context(|| format!("{}", folder.display()))?;
    let mut text = String::from(
        "# What time and memory buy\n\nWritten by `cargo xtask tradeoff`. Times are the best of some runs; \"first\" is the coarse step, a tree, a map or \
         shadow volumes, \"second\" the rest. Errors are shares of points all over the surface whose exact answers are known.\n",
    );
    for course in
        all.iter().filter(|course| options.scene.is_empty() || options.scene.iter().any(|name| name == course.name))
    {
        if !course.file.exists() {
            println!("{}: left out, {} is not there", course.name, course.file.display());
            continue;
        }
        let table = measure(course, options, &folder)?;
        print!("{table}");
        // Writing to a string cannot fail.
        let _ = write!(text, "\n## {}: {}\n\n![{0}]({0}.svg)\n\n```text\n{table}```\n", course.name, course.about);
    }
    fs::write(folder.join("README.md"), text)?;
    Ok(())
}

/// Runs the command on a scene, and answers its table.
fn measure(course: &Course, options: &Options, folder: &Path) -> Result<String> {
    let (points, runs) = (options.points.to_string(), options.runs.to_string());
    let chart = |extension: &str| folder.join(format!("{}.{extension}", course.name)).display().to_string();
    let file = course.file.display().to_string();
    let (svg, png, csv) = (chart("svg"), chart("png"), chart("csv"));
    let mut arguments = vec!["tradeoff", &file, "--quiet", "--allow-outside", "--points", &points, "--runs", &runs];
    arguments.extend(course.more);
    arguments.extend(["-o", &svg, "-o", &png, "-o", &csv]);
    let mut command = umbriel(options.umbriel.as_deref());
    output_of(command.args(arguments))
}

fn courses() -> Result<Vec<Course>> {
    let made = root().join("target/tradeoff");
    fs::create_dir_all(&made).with_context(|| format!("{}", made.display()))?;
    let write = |name: &str, text: String| -> Result<PathBuf> {
        let file = made.join(name);
        fs::write(&file, text).with_context(|| format!("{}", file.display()))?;
        Ok(file)
    };
    let data = |name: &str| root().join("../shared/data").join(name);
    let sun: &[&str] = &["--sun", "135,40"];
    Ok(vec![
        Course { name: "convex", about: "150 boxes over a plane", file: write("convex.toml", boxes(150))?, more: sun },
        Course {
            name: "concave",
            about: "a ring that shadows itself, over a plane",
            file: write("concave.toml", ring())?,
            more: sun,
        },
        Course {
            name: "quadrics",
            about: "one of each analytic body",
            file: root().join("fixtures/bodies.toml"),
            more: &["--light", "sun"],
        },
        Course { name: "city", about: "a part of Delft", file: data("delft-city/delft.obj"), more: sun },
        Course {
            name: "foliage",
            about: "20,000 leaves over a plane",
            file: write("foliage.obj", leaves(20_000))?,
            more: sun,
        },
    ])
}

const PLANE: &str = "[[object]]\nname = \"ground\"\nrectangle = { size = [60, 60] }\n";

/// Boxes of different sizes.
fn boxes(count: u32) -> String {
    let mut random = SplitMix64::new(11);
    let mut text = String::from(PLANE);
    for number in 0..count {
        let [x, z] = [0; 2].map(|_| random.between(-25.0, 25.0));
        let [a, b, c] = [0; 3].map(|_| random.between(0.5, 3.0));
        let height = 0.5 * b + random.between(0.0, 1.0);
        let _ = writeln!(
            text,
            "[[object]]\nname = \"box {number}\"\nbox = {{ size = [{a}, {b}, {c}] }}\ntranslation = [{x}, {height}, {z}]"
        );
    }
    text
}

/// The torus of the fixtures, larger, over a plane.
fn ring() -> String {
    let file = root().join("fixtures/torus.obj");
    format!(
        "{PLANE}[[object]]\nname = \"ring\"\nmesh = \"{}\"\ntranslation = [0, 6, 0]\nrotation = [0.5, 0, 0, 0.8660254037844386]\nscale = 4\n",
        file.display()
    )
}

/// Single triangles in all directions over a plane.
fn leaves(count: u32) -> String {
    let mut random = SplitMix64::new(3);
    let mut text = String::from("o ground\nv -5 0 -5\nv -5 0 45\nv 45 0 45\nv 45 0 -5\nf 1 2 3\nf 1 3 4\no leaves\n");
    for number in 0..count {
        let middle = [(0.0, 40.0), (2.0, 14.0), (0.0, 40.0)].map(|(from, to)| random.between(from, to));
        for _ in 0..3 {
            let [x, y, z] = middle.map(|at| at + random.between(-0.2, 0.2));
            let _ = writeln!(text, "v {x} {y} {z}");
        }
        let first = 5 + 3 * number;
        let _ = writeln!(text, "f {} {} {}", first, first + 1, first + 2);
    }
    text
}
