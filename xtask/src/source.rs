//! `cargo xtask source`: the claims of the source (Xie et al. 2001) about shadow volumes, redone. Figures and pictures go to `docs/source`.
//!
//! The source says that on the same polygon models its method takes a third of the time of traditional shadow volumes at most, at equal or smaller error, and shows
//! one scene with smallest cells of 0.1, 0.02 and 0.001. Here both are run on the same picture and machine by `umbriel compare`.

use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use serde_json::Value;
use umbriel_shadow::tradeoff::Setting;

use crate::{
    tradeoff::polygon_scenes,
    workspace::{output_of, root, umbriel},
};

/// The source's smallest cells, and the edge of the scene that they are parts of: it gives no units.
const CELLS: [f64; 3] = [0.1, 0.02, 0.001];

/// Models alone, which pictures see whole: there a pixel has the fewest triangles before it. With suns from three sides, of which the last shows the cow's dark side, and from small pictures to large ones.
const MODELS: [(&str, &str); 4] = [
    ("cow", "spot/spot.obj"),
    ("bunny", "bunny/stanford-bunny.obj"),
    ("cannon", "cannon/cannon_01.gltf"),
    ("flight helmet", "flighthelmet/FlightHelmet.gltf"),
];
const SUNS: [&str; 3] = ["135,40", "215,35", "315,20"];
const SIZES: [&str; 3] = ["300x200", "600x400", "1200x800"];

/// What is measured.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Options {
    /// Measure with this program instead of building one
    #[arg(long, value_name = "FILE")]
    umbriel: Option<PathBuf>,
    /// How often each picture is made; the quickest counts
    #[arg(long, value_name = "N", default_value = "5")]
    runs: u32,
    /// Width and height of the pictures of scenes
    #[arg(long, value_name = "WxH", default_value = "600x400")]
    size: String,
    /// Where figures and pictures go
    #[arg(long, value_name = "FOLDER", default_value = "docs/source")]
    folder: PathBuf,
}

/// What one way took and missed.
#[derive(Clone, Debug)]
struct Row {
    name: String,
    /// What is made beforehand, for this way and for all rivals.
    ready: f64,
    polygons: f64,
    milliseconds: f64,
    wrong: u64,
    undecided: u64,
}

pub(crate) fn run(options: &Options) -> Result<()> {
    let folder = root().join(&options.folder);
    fs::create_dir_all(&folder).with_context(|| format!("{}", folder.display()))?;
    let mut text = String::from(
        "# The source's claims about shadow volumes\n\nWritten by `cargo xtask source`: the points that the pixels of one picture see, each way asked about them on the \
         same machine. Milliseconds after loading, the best of some runs; wrong and undecided pixels by exact answers. What is the same for all lights and pictures is made \
         beforehand and not counted: the polygons that shadow volumes work on, with their edges, and which meshes bound solids, where that is known.\n\n\
         | scene | way | ms | wrong | undecided | part of the shadow volume's time |\n|---|---|---|---|---|---|\n",
    );
    for scene in polygon_scenes()?.into_iter().filter(|scene| scene.file.exists()) {
        let ways = ["--method", "points", "--method", "volume", "--method", "bake"];
        let rows = best(options, &scene.file, &[scene.more, &ways, &["--size", &options.size]].concat(), None)?;
        for Row { name, milliseconds, wrong, undecided, .. } in &rows {
            let part = milliseconds / time_of(&rows, "shadow volume");
            // Writing to a string cannot fail.
            let _ =
                writeln!(text, "| {} | {name} | {milliseconds:.1} | {wrong} | {undecided} | {part:.2} |", scene.name);
        }
    }
    text.push_str(
        "\n## Models alone\n\nExact points as a part of the shadow volume's time, on one thread and on all.\n",
    );
    models(options, &Setting::Points.name(), &mut text)?;
    text.push_str("\nThe same where it is known which meshes bound solids, so that half of their faces are looked at; found once in so long, while the rivals' polygons take the other.\n");
    models(options, &Setting::PointsOfSolids.name(), &mut text)?;
    text.push_str("\n## The smallest cell\n\nThe boxes of the first scene, cells no larger than these edges in metres:\n\n| cell | ms | wrong | undecided |\n|---|---|---|---|\n");
    for scene in polygon_scenes()?.iter().take(1) {
        for edge in CELLS {
            let picture = folder.join(format!("cell-{edge}.png"));
            let cell = edge.to_string();
            let asked = [scene.more, &["--method", "bake", "--cell", &cell, "--size", &options.size]].concat();
            for Row { milliseconds, wrong, undecided, .. } in best(options, &scene.file, &asked, Some(&picture))? {
                let _ = writeln!(text, "| {edge} | {milliseconds:.1} | {wrong} | {undecided} |");
            }
        }
    }
    for edge in CELLS {
        let _ = write!(text, "\n![The truth, and cells of {edge} m](cell-{edge}.png)\n");
    }
    print!("{text}");
    fs::write(folder.join("README.md"), text)?;
    Ok(())
}

/// Exact points of models alone as parts of the shadow volume's time, on one thread and on all; and what is made beforehand.
fn models(options: &Options, way: &str, text: &mut String) -> Result<()> {
    let columns = SIZES.map(|size| [format!(" {size}, one |"), format!(" {size}, all |")].concat()).concat();
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "\n| model | sun |{columns} solids ms | polygons ms |\n|---|---|{}---|---|\n",
        "---|".repeat(2 * SIZES.len())
    );
    for (name, file) in MODELS {
        let file = root().join("../shared/data").join(file);
        if !file.exists() {
            println!("{name}: left out, {} is not there", file.display());
            continue;
        }
        for sun in SUNS {
            let _ = write!(text, "| {name} | {sun} |");
            let mut ready = [f64::INFINITY; 2];
            for size in SIZES {
                for threads in [&["--threads", "1"] as &[&str], &[]] {
                    let ways = ["--method", "points", "--method", "volume", "--sun", sun, "--size", size];
                    let rows = best(options, &file, &[&ways, threads].concat(), None)?;
                    let _ = write!(text, " {:.2} |", time_of(&rows, way) / time_of(&rows, "shadow volume"));
                    for row in rows.iter().filter(|row| row.name == way) {
                        ready = [ready[0].min(row.ready), ready[1].min(row.polygons)];
                    }
                }
            }
            let _ = writeln!(text, " {:.1} | {:.1} |", ready[0], ready[1]);
        }
    }
    Ok(())
}

/// Milliseconds of one way; not a number where it was not taken.
fn time_of(rows: &[Row], name: &str) -> f64 {
    rows.iter().find(|row| row.name == name).map_or(f64::NAN, |row| row.milliseconds)
}

/// The quickest of some runs for each way.
fn best(options: &Options, scene: &Path, more: &[&str], picture: Option<&Path>) -> Result<Vec<Row>> {
    let mut best: Vec<Row> = Vec::new();
    for _ in 0..options.runs.max(1) {
        for row in once(options, scene, more, picture)? {
            match best.iter_mut().find(|known| known.name == row.name) {
                Some(known) => {
                    known.milliseconds = known.milliseconds.min(row.milliseconds);
                    (known.ready, known.polygons) = (known.ready.min(row.ready), known.polygons.min(row.polygons));
                }
                None => best.push(row),
            }
        }
    }
    Ok(best)
}

fn once(options: &Options, scene: &Path, more: &[&str], picture: Option<&Path>) -> Result<Vec<Row>> {
    let mut command = umbriel(options.umbriel.as_deref());
    command.arg("compare").arg(scene).args(["--quiet", "--allow-outside", "--json", "-"]).args(more);
    if let Some(picture) = picture {
        command.arg("-o").arg(picture);
    }
    let document: Value = serde_json::from_str(&output_of(&mut command)?).context("the comparison is no JSON")?;
    let methods = document["methods"].as_array().context("the comparison has no methods")?;
    let polygons = 1e3 * document["polygons_seconds"].as_f64().context("a time is missing")?;
    let row = |method: &Value| {
        let seconds = |key: &str| method[key].as_f64().context("a time is missing");
        let count = |key: &str| method[key].as_u64().context("a count is missing");
        Ok(Row {
            name: method["name"].as_str().context("a name is missing")?.to_owned(),
            ready: 1e3 * seconds("ready_seconds")?,
            polygons,
            milliseconds: 1e3 * (seconds("first_seconds")? + seconds("second_seconds")?),
            wrong: count("wrong")?,
            undecided: count("undecided")?,
        })
    };
    methods.iter().map(row).collect()
}
