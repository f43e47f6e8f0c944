//! A scene file and a mesh, read; what was found about them; an error with its place; and the mesh written again, with
//! colours. Everything happens in a temporary folder.

use std::{error::Error, fs};

use umbriel_io::{
    LoadOptions, load, surface_findings,
    write::{ColoredMesh, Staged, write_glb},
};
use umbriel_scene::Shape;

/// A tent of two sides over a square: three openings.
const TENT: &str = "\
o tent
v -2 0 -2
v 2 0 -2
v 2 0 2
v -2 0 2
v 0 2 -2
v 0 2 2
f 1 4 6 5
f 3 2 5 6
";

const CAMP: &str = r#"
[[object]]
name = "meadow"
rectangle = { size = [20.0, 20.0] }

[[object]]
name = "tent"
mesh = "tent.obj"
translation = [3.0, 0.0, 0.0]

[[object]]
name = "fire"
cone = { radius = 0.5, height = 0.75 }
translation = [-2.0, 0.375, 1.0]

[[light]]
name = "morning"
sun = { azimuth = 95.0, elevation = 12.0, angular_diameter = 0.53 }

[[light]]
name = "lantern"
point = { position = [3.0, 1.5, 0.0] }
"#;

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let camp = folder.path().join("camp.toml");
    fs::write(folder.path().join("tent.obj"), TENT)?;
    fs::write(&camp, CAMP)?;

    let loaded = load(&camp, &LoadOptions::default())?;
    for object in &loaded.scene.objects {
        println!("{}: {} faces", object.name, object.face_count());
    }
    for light in &loaded.scene.lights {
        println!("{}: {}", light.name, if light.source.is_sun() { "a sun" } else { "a lamp" });
    }
    for finding in loaded.scene.findings.iter().chain(&surface_findings(&loaded.scene)) {
        println!("found about {}: {} {}", finding.subject, finding.count, finding.kind.name());
    }

    // What is refused, is refused by its place.
    let wrong = folder.path().join("wrong.toml");
    fs::write(&wrong, CAMP.replace("height = 0.75", "length = 0.75"))?;
    if let Err(error) = load(&wrong, &LoadOptions::default()) {
        println!("{}", error.problem);
    }

    // A mesh with colours that tell its height, whole or not at all.
    let meshes: Vec<ColoredMesh> = loaded.scene.objects.iter().filter_map(by_height).collect();
    let target = folder.path().join("height.glb");
    Staged::new(&target, |out| write_glb(&meshes, out))?.commit()?;
    let again = load(&target, &LoadOptions::default())?;
    println!("{} bytes of glb hold {} triangles", fs::metadata(&target)?.len(), again.scene.objects[0].face_count());
    Ok(())
}

/// Blue at the ground, red at 2 m.
fn by_height(object: &umbriel_scene::Object) -> Option<ColoredMesh> {
    let Shape::Mesh(mesh) = &object.shape else { return None };
    let positions: Vec<[f64; 3]> =
        mesh.positions().iter().map(|&local| object.placement.round(local).to_array()).collect();
    let shade = |height: f64| (127.5 * height).clamp(0.0, 255.0) as u8;
    let colors = positions.iter().map(|position| [shade(position[1]), 0, 255 - shade(position[1]), 255]).collect();
    Some(ColoredMesh { name: object.name.clone(), positions, colors, triangles: mesh.triangles().to_vec() })
}
