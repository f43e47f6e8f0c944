//! `umbriel doctor`: what about a scene limits the answers.

use std::{fs, path::PathBuf};

use serde_json::Value;
use umbriel_io::{LoadOptions, load, surface_findings};
use umbriel_shadow::{
    Detail, Silent,
    doctor::{Place, examine},
};

use crate::workspace::{DARK, Workspace};

/// A box on a floor, and a sheet that lies in it.
const CONTACT: &str = r#"
[[object]]
name = "floor"
rectangle = { size = [8.0, 8.0] }

[[object]]
name = "crate"
box = { size = [2.0, 1.0, 1.0] }
translation = [0.0, 0.5, 0.0]

[[object]]
name = "mat"
rectangle = { size = [2.0, 2.0] }
translation = [4.0, 0.0, 2.0]

[[light]]
name = "lamp"
point = { position = [0.25, 0.5, 0.125], radius = 0.1 }
"#;

#[test]
fn a_sound_scene() {
    let text = Workspace::noon().run("doctor noon.toml").succeeds().stdout();
    assert!(text.contains("2 objects, 1 flat face of 64.000 m²; 1 curved object"), "{text}");
    assert!(text.contains("nothing found"), "{text}");
    let dark = Workspace::with(&[("dark.toml", DARK)]);
    assert!(dark.run("doctor dark.toml").succeeds().stdout().contains("nothing found"));
    let level = dark.run("doctor dark.toml --sun 90,0 --sun 90,-30").succeeds().stdout();
    assert!(level.contains("sun below horizon") && level.contains("at: sun_2"), "{level}");
}

#[test]
fn a_table_with_areas_and_consequences() {
    let text = Workspace::with(&[("scene.toml", CONTACT)]).run("doctor scene.toml").succeeds().stdout();
    for words in
        ["contact                           2        4.0000 m²", "at: floor, crate", "coplanar overlap", "inside crate"]
    {
        assert!(text.contains(words), "\"{words}\" is missing in: {text}");
    }
    assert!(text.contains("while reading\n  1 lights with an extent"), "{text}");
}

#[test]
fn json_has_kinds_areas_shares_and_consequences() {
    let workspace = Workspace::with(&[("scene.toml", CONTACT)]);
    let text = workspace.run("doctor scene.toml --json -").succeeds().stdout();
    let told = workspace.run("doctor scene.toml --json found.json").succeeds().stdout();
    assert_eq!(workspace.text("found.json"), text);
    assert!(told.contains("coplanar overlap"), "the table is told all the same: {told}");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(
        (&json["schema"], &json["scene"]["faces"], &json["scene"]["area"]),
        (&1.into(), &8.into(), &78.0.into())
    );
    let of = |kind: &str, key: &str, name: &str| {
        let rows = json["findings"].as_array().expect("a list");
        rows.iter().find(|row| row["kind"] == kind && row[key] == name).unwrap_or(&Value::Null).clone()
    };
    let row = |row: Value| (row["count"].as_u64(), row["area"].as_f64(), row["share"].as_f64());
    assert_eq!(row(of("coplanar_overlap", "object", "mat")), (Some(1), Some(2.0), Some(0.5)));
    assert_eq!(row(of("contact", "object", "floor")), (Some(1), Some(2.0), Some(2.0 / 64.0)));
    assert_eq!(row(of("contact", "object", "crate")), (Some(1), Some(2.0), Some(0.2)));
    let lamp = of("lamp_inside_body", "light", "lamp");
    assert_eq!((&lamp["inside"], lamp["area"].as_f64()), (&"crate".into(), Some(10.0)));
    let read = of("area_light_as_point", "object", "lamp");
    assert!(read["area"].is_null() && read["consequence"].as_str().is_some_and(|text| text.contains("centre")));
    assert_eq!(json["totals"][0]["consequence"].as_str().map(str::is_empty), Some(false));
}

#[test]
fn what_cannot_be_written_is_refused_before_the_work() {
    let workspace = Workspace::with(&[("scene.toml", CONTACT)]);
    workspace.run("doctor scene.toml --json no/found.json").fails(2, &["folder does not exist"]);
    workspace.run("doctor scene.toml --json scene.toml").fails(2, &["is read"]);
    workspace.run("doctor nothing.toml").fails(2, &["nothing.toml"]);
}

/// Open edges, faces without area and repeated faces are counted twice in this workspace, in two ways.
#[test]
fn the_counts_of_all_fixtures_are_those_of_the_reader() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let mut scenes = 0;
    for entry in fs::read_dir(folder).expect("the fixtures") {
        let path = entry.expect("an entry").path();
        if !path.extension().is_some_and(|e| ["toml", "obj", "gltf", "glb"].iter().any(|known| e == *known)) {
            continue;
        }
        let scene = load(&path, &LoadOptions::default()).expect("a scene").scene;
        let lights: Vec<usize> = (0..scene.lights.len()).collect();
        let diagnosis = examine(&scene, &lights, Detail::default(), &Silent).expect("not cancelled");
        for name in ["open_edges", "zero_area_faces", "duplicate_faces"] {
            let ours = diagnosis.defects.iter().filter(|defect| defect.kind.name() == name).map(|defect| defect.count);
            let read = surface_findings(&scene).into_iter().filter(|f| f.kind.name() == name).map(|f| f.count);
            assert_eq!(ours.sum::<usize>(), read.sum::<usize>(), "{name} of {}", path.display());
        }
        for defect in &diagnosis.defects {
            let known = match defect.place {
                Place::Object(object) => object < scene.objects.len(),
                Place::Light(light) => light < scene.lights.len(),
            };
            assert!(known && defect.count > 0 && (0.0..=1.0).contains(&defect.share), "{defect:?}");
        }
        scenes += 1;
    }
    assert!(scenes > 10);
}
