//! Reading and writing: megabytes a second for an OBJ and a GLB of the same mesh. `cargo bench -p umbriel-io`.

use std::{error::Error, fmt::Write, fs, hint::black_box, path::Path, time::Instant};

use umbriel_io::{
    LoadOptions, load,
    write::{ColoredMesh, write_glb},
};

/// Runs of which the quickest counts.
const RUNS: usize = 5;
/// Squares along an edge of the mesh, two triangles each.
const EDGE: u32 = 300;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let (obj, glb) = (folder.path().join("hills.obj"), folder.path().join("hills.glb"));
    let hills = hills();
    fs::write(&obj, obj_text(&hills)?)?;
    let mut bytes = Vec::new();
    write_glb(std::slice::from_ref(&hills), &mut bytes)?;
    fs::write(&glb, &bytes)?;
    show("read OBJ", fs::metadata(&obj)?.len(), quickest(|| read(&obj))?);
    show("read GLB", fs::metadata(&glb)?.len(), quickest(|| read(&glb))?);
    let written = || Ok(write_glb(std::slice::from_ref(&hills), &mut Vec::new())?);
    show("write GLB", bytes.len() as u64, quickest(written)?);
    Ok(())
}

/// A square of waves.
fn hills() -> ColoredMesh {
    let mut mesh = ColoredMesh { name: "hills".into(), ..ColoredMesh::default() };
    for i in 0..=EDGE {
        for j in 0..=EDGE {
            let (x, z) = (f64::from(i) / 16.0, f64::from(j) / 16.0);
            mesh.positions.push([x, (x * 1.7).sin() * (z * 1.3).cos(), z]);
            mesh.colors.push([255; 4]);
            if i < EDGE && j < EDGE {
                let at = |i: u32, j: u32| i * (EDGE + 1) + j;
                let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

fn obj_text(mesh: &ColoredMesh) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    for [x, y, z] in &mesh.positions {
        writeln!(text, "v {x} {y} {z}")?;
    }
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|corner| corner + 1);
        writeln!(text, "f {a} {b} {c}")?;
    }
    Ok(text)
}

fn read(path: &Path) -> Result<(), Box<dyn Error>> {
    black_box(load(path, &LoadOptions::default())?);
    Ok(())
}

/// Seconds of the quickest run.
fn quickest(mut run: impl FnMut() -> Result<(), Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    let mut best = f64::INFINITY;
    for _ in 0..RUNS {
        let begun = Instant::now();
        run()?;
        best = best.min(begun.elapsed().as_secs_f64());
    }
    Ok(best)
}

#[expect(clippy::print_stdout, reason = "a benchmark shows what it measured")]
fn show(name: &str, bytes: u64, seconds: f64) {
    let megabytes = bytes as f64 / 1e6;
    println!("{name:<10} {megabytes:>6.1} MB {:>8.1} ms {:>8.1} MB/s", seconds * 1e3, megabytes / seconds);
}
