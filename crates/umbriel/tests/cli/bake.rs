//! `umbriel bake`: tables, JSON by contract, coloured models.

use serde_json::Value;

use crate::workspace::Workspace;

fn json(workspace: &Workspace, arguments: &str) -> Value {
    serde_json::from_str(&workspace.run(arguments).succeeds().stdout()).expect("JSON")
}

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} in {value}"))
}

#[test]
fn json_has_the_fields_of_the_contract() {
    let bake = json(&Workspace::noon(), "bake noon.toml --json -");
    assert_eq!(number(&bake, "/schema"), 1.0);
    assert_eq!(bake["umbriel"], env!("CARGO_PKG_VERSION"));
    for (path, expected) in [
        ("/scene/objects", 2.0),
        ("/scene/triangles", 0.0),
        ("/scene/analytic", 2.0),
        ("/scene/lights", 1.0),
        ("/detail/interior_depth", 4.0),
        ("/detail/boundary_depth", 8.0),
        ("/lights/0/objects/0/area", 64.0),
    ] {
        assert_eq!(number(&bake, path), expected, "{path}");
    }
    assert_eq!(
        (&bake["lights"][0]["name"], &bake["lights"][0]["objects"][1]["name"]),
        (&"noon".into(), &"ball".into())
    );
    assert!(bake["findings"].as_array().is_some_and(Vec::is_empty));
    for work in
        ["pairs_tested", "pairs_registered", "pairs_excluded", "octrees_built", "cells", "rays", "exact_fallbacks"]
    {
        assert!(bake["work"][work].is_u64(), "{work}");
    }
    for time in ["load", "coarse", "fine", "total"] {
        assert!(number(&bake, &format!("/time/{time}")) >= 0.0);
    }
    assert!(bake["peak_memory_bytes"].is_u64() || bake["peak_memory_bytes"].is_null());
    assert!(bake["lights"][0]["objects"][0].get("samples").is_none());
}

#[test]
fn the_truth_lies_in_the_bounds() {
    let bake = json(&Workspace::noon(), "bake noon.toml --json - --boundary-depth 6");
    // The ball's shadow is the unit disk; half of the ball faces the sun.
    let pi = std::f64::consts::PI;
    for (object, truth) in [(0, 64.0 - pi), (1, 2.0 * pi)] {
        let area = |name: &str| number(&bake, &format!("/lights/0/objects/{object}/{name}"));
        let (lower, upper) = (area("lit_area/lower"), area("lit_area/upper"));
        assert!(lower <= truth && truth <= upper, "{truth} is not in {lower}..{upper}");
        assert!((lower..=upper).contains(&area("lit_area/estimate")));
        assert_eq!(area("undecided"), upper - lower);
    }
}

#[test]
fn samples_are_counted() {
    let bake = json(&Workspace::noon(), "bake noon.toml --json - --receiver fl??r --samples 400 --boundary-depth 3");
    let objects = bake["lights"][0]["objects"].as_array().expect("objects");
    assert_eq!(objects.len(), 1, "one receiver");
    let (samples, lit) = (number(&objects[0], "/samples"), number(&objects[0], "/lit_samples"));
    assert!(samples >= 300.0 && lit < samples && lit > 0.9 * samples, "{lit} of {samples}");
}

#[test]
fn lights_are_added_and_chosen() {
    let workspace = Workspace::noon();
    let names = |arguments: &str| -> Vec<String> {
        let bake = json(&workspace, &format!("bake noon.toml --json - --boundary-depth 2 {arguments}"));
        let lights = bake["lights"].as_array().expect("lights");
        lights.iter().map(|light| light["name"].as_str().expect("a name").to_owned()).collect()
    };
    assert_eq!(names("--sun -90,30 --sun 10,10 --point -1,5,-2"), ["noon", "sun", "sun_2", "point"]);
    assert_eq!(names("--sun -90,30 --light sun"), ["sun"]);
}

#[test]
fn details_are_told() {
    let workspace = Workspace::noon();
    let detail = |arguments: &str| json(&workspace, &format!("bake noon.toml --json - {arguments}"))["detail"].clone();
    assert_eq!(detail("--cell 0.5"), serde_json::json!({ "cell": 0.5 }));
    assert_eq!(detail("--max-undecided 0.2"), serde_json::json!({ "max_undecided": 0.2 }));
    assert_eq!(detail("--boundary-depth 3"), serde_json::json!({ "interior_depth": 3, "boundary_depth": 3 }));
}

#[test]
fn all_files_are_written() {
    let workspace = Workspace::noon();
    let table = workspace.run("bake noon.toml --boundary-depth 5 -o a.json -o a.csv -o a.glb --json b.json").succeeds();
    assert!(table.stdout().contains("light noon") && table.stdout().contains("ball"), "{}", table.stdout());
    assert_eq!(workspace.files(), ["a.csv", "a.glb", "a.json", "b.json", "noon.toml"]);
    let csv = workspace.text("a.csv");
    assert!(csv.starts_with("light,object,area,lit_lower,lit_upper,lit_estimate,undecided\nnoon,floor,64,"), "{csv}");
    assert_eq!(csv.lines().count(), 3);
    assert_eq!(&workspace.read("a.glb")[..4], b"glTF");
    // What was written is a scene again.
    assert!(workspace.run("info a.glb").succeeds().stdout().contains("ball"));
}

#[test]
fn threads_do_not_change_results() {
    let workspace = Workspace::noon();
    let lights = |threads| json(&workspace, &format!("bake noon.toml --json - --threads {threads}"))["lights"].clone();
    assert_eq!(lights(1), lights(3));
}

#[test]
fn the_detail_of_the_scene_file_counts_unless_one_is_typed() {
    let scene = format!("{}\n[detail]\nboundary_depth = 3\n", crate::workspace::NOON);
    let workspace = Workspace::with(&[("noon.toml", &scene)]);
    let depth = |arguments: &str| {
        number(&json(&workspace, &format!("bake noon.toml --json - {arguments}")), "/detail/boundary_depth")
    };
    assert_eq!((depth(""), depth("--boundary-depth 2")), (3.0, 2.0));
}
