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
    for level in ["f32", "f64", "pair", "expansion", "exact"] {
        assert!(bake["work"]["decisions"][level].is_u64(), "{level}");
    }
    assert!(bake["work"]["decisions"]["f64"].as_u64() > Some(0), "a bake decides something");
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
    for (object, whole, truth) in [(0, 64.0, 64.0 - pi), (1, 4.0 * pi, 2.0 * pi)] {
        let area = |name: &str| number(&bake, &format!("/lights/0/objects/{object}/{name}"));
        let (lower, upper) = (area("lit_area/lower"), area("lit_area/upper"));
        assert!(lower <= truth && truth <= upper, "{truth} is not in {lower}..{upper}");
        assert!((lower..=upper).contains(&area("lit_area/estimate")));
        assert_eq!(area("undecided"), upper - lower);
        let error = area("area_error");
        assert!((area("area") - whole).abs() <= error && error < 1e-12 * whole, "{} within {error}", area("area"));
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
    assert!(table.stdout().ends_with(" exactly\n") && table.stdout().contains(" decisions: "), "{}", table.stdout());
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

#[test]
fn cells_are_a_table_that_queries_understand() {
    let workspace = Workspace::noon();
    workspace.run("bake noon.toml --boundary-depth 4 --csv cells -o cells.csv").succeeds();
    let text = workspace.text("cells.csv");
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let header = ["light", "object", "face", "level", "u", "v", "x", "y", "z", "area", "lit_lower", "lit_upper"];
    assert_eq!((&rows[0][..12], rows[0][12]), (&header[..], "verdict"));
    let sum = |object: &str, column: usize| -> f64 {
        let chosen = rows[1..].iter().filter(|row| row[1] == object);
        chosen.map(|row| row[column].parse::<f64>().expect("a number")).sum()
    };
    let pi = std::f64::consts::PI;
    for (object, area, lit) in [("floor", 64.0, 64.0 - pi), ("ball", 4.0 * pi, 2.0 * pi)] {
        assert!((sum(object, 9) - area).abs() < 1e-4 * area, "{object}");
        assert!(sum(object, 10) <= lit && lit <= sum(object, 11), "{object}");
    }
    // The middles of decided cells are what exact queries say.
    let points: Vec<String> = rows[1..].iter().map(|row| [row[1], row[2], row[4], row[5]].join(",")).collect();
    let workspace = Workspace::with(&[
        ("noon.toml", crate::workspace::NOON),
        ("points.csv", &format!("object,face,u,v\n{}\n", points.join("\n"))),
    ]);
    let answers = workspace.run("query noon.toml --points points.csv").succeeds().stdout();
    for (row, answer) in rows[1..].iter().zip(answers.lines().skip(1)) {
        let lit = answer.ends_with(",1");
        assert!(row[12] == "undecided" || (row[12] == "lit") == lit, "{row:?}: {answer}");
    }
}

/// The values of an array of a .vtu file, `N` bytes each.
fn array<const N: usize>(text: &str, name: &str) -> Vec<[u8; N]> {
    use base64::Engine;
    let (_, rest) = text.split_once(&format!("Name=\"{name}\"")).unwrap_or_else(|| panic!("no {name}"));
    let content = rest.split(['>', '<']).nth(1).expect("content");
    let bytes = base64::engine::general_purpose::STANDARD.decode(content).expect("base64");
    assert_eq!(bytes[..8], (bytes.len() as u64 - 8).to_le_bytes());
    bytes[8..].chunks_exact(N).map(|bytes| bytes.try_into().expect("N bytes")).collect()
}

fn floats(text: &str, name: &str) -> Vec<f64> {
    array(text, name).into_iter().map(f64::from_le_bytes).collect()
}

#[test]
fn a_grid_holds_all_lights() {
    let workspace = Workspace::noon();
    let run = |threads: u32, file: &str| {
        let lights = "--point 0,0.5,0 --boundary-depth 4";
        workspace.run(&format!("bake noon.toml {lights} --threads {threads} -o {file}")).succeeds();
        workspace.text(file)
    };
    let text = run(1, "a.vtu");
    assert_eq!(text, run(3, "b.vtu"), "threads do not change the file");
    let whole = |name: &str| array(&text, name).into_iter().map(u32::from_le_bytes).collect::<Vec<u32>>();
    let (points, corners, ends) = (floats(&text, "Points"), whole("connectivity"), whole("offsets"));
    let count = ends.len();
    assert!(text.contains(&format!("NumberOfPoints=\"{}\" NumberOfCells=\"{count}\"", points.len() / 3)));
    assert!(corners.iter().all(|&corner| (corner as usize) < points.len() / 3));
    assert_eq!(array::<1>(&text, "types"), vec![[9]; count], "squares only");
    assert_eq!(ends, (1..=count as u32).map(|polygon| 4 * polygon).collect::<Vec<_>>());
    let (object, area) = (whole("object"), floats(&text, "area"));
    let sum = |values: &[f64], wanted: u32| -> f64 {
        values.iter().zip(&object).filter(|&(_, &object)| object == wanted).map(|(value, _)| value).sum()
    };
    let pi = std::f64::consts::PI;
    assert_eq!(sum(&area, 0), 64.0);
    assert!((sum(&area, 1) - 4.0 * pi).abs() < 1e-4);
    // The lamp stands between the floor and the ball: it lights all of the floor, and the ball's cap below y = 4/3.
    for (light, lit) in [("noon", [64.0 - pi, 2.0 * pi]), ("point", [64.0, 2.0 * pi / 3.0])] {
        for (index, lit) in [0, 1].into_iter().zip(lit) {
            let bound = |name: &str| sum(&floats(&text, &format!("{name} {light}")), index);
            let (lower, upper) = (bound("lit_lower"), bound("lit_upper"));
            assert!(lower <= lit * (1.0 + 1e-9) && lit <= upper, "{light}, {index}: {lit} is not in {lower}..{upper}");
        }
        let verdicts = array::<1>(&text, &format!("verdict {light}"));
        assert!(verdicts.len() == count && verdicts.iter().all(|&[verdict]| verdict < 3));
    }
    assert_eq!(array::<1>(&text, "object_names").concat(), b"floor\nball");
}

#[test]
fn models_are_coloured_by_cell_face_or_vertex() {
    let workspace = Workspace::noon();
    let vertices = |by: &str| {
        workspace
            .run(&format!("bake noon.toml --receiver floor --boundary-depth 4 --color {by} -o {by}.glb"))
            .succeeds();
        let bytes = workspace.read(&format!("{by}.glb"));
        let length = u32::from_le_bytes(bytes[12..16].try_into().expect("4 bytes")) as usize;
        let json: Value = serde_json::from_slice(&bytes[20..20 + length]).expect("JSON");
        number(&json, "/accessors/0/count") as usize
    };
    let (cells, shared) = (vertices("cell"), vertices("vertex"));
    assert_eq!(vertices("face"), 4);
    assert!(cells.is_multiple_of(4) && shared > 4 && shared < cells / 2, "{cells} and {shared}");
}

/// A square of 2 × 2 metres in the xz plane, on the whole of its light map, and the same once more above it.
const SQUARES: &str = "v -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nv 0 1 1\nv 2 1 1\nv 2 1 -1\nv 0 1 -1\n\
    vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\no low/floor\nf 1/1 2/2 3/3 4/4\no roof\nf 5/1 6/2 7/3 8/4\n";

#[test]
fn light_maps_hold_what_is_lit() {
    let workspace = Workspace::with(&[("squares.obj", SQUARES)]);
    let bake = "bake squares.obj --sun 0,90 --lightmap-size 8 --boundary-depth 4";
    workspace.run(&format!("{bake} --receiver low/* -o one.png")).succeeds();
    workspace.run(&format!("{bake} -o all.png")).succeeds();
    assert_eq!(workspace.files(), ["all-low_floor.png", "all-roof.png", "one.png", "squares.obj"]);
    assert_eq!(workspace.read("one.png"), workspace.read("all-low_floor.png"));
    let pixels = |file: &str| image::open(workspace.path(file)).expect("a picture").into_luma8();
    let floor = pixels("one.png");
    assert_eq!(floor.dimensions(), (8, 8));
    // The roof covers the half with x > 0, the right one.
    assert!(floor.enumerate_pixels().all(|(column, _, pixel)| pixel.0 == [if column < 4 { 255 } else { 0 }]));
    assert!(pixels("all-roof.png").pixels().all(|pixel| pixel.0 == [255]));
}

#[test]
fn light_maps_need_a_layout_and_a_place() {
    let workspace = Workspace::noon();
    workspace.run("bake noon.toml -o a.png").fails(1, &["noon.toml", "light map", "TEXCOORD_1", "umbriel render"]);
    let workspace = Workspace::with(&[("squares.obj", SQUARES)]);
    let arguments = "bake squares.obj --sun 0,90 --lightmap-size 8 -o a.png -o ./a.png";
    workspace.run(arguments).fails(2, &["a.png", "twice"]);
    assert_eq!(workspace.files(), ["squares.obj"]);
}

/// Disks that all but coincide: nothing can be told of them at any depth.
#[test]
fn without_a_detail_there_is_an_end_that_is_told() {
    let disk = |k: u32| {
        format!("[[object]]\nname = \"{k}\"\ndisk = {{ radius = 1.0 }}\ntranslation = [{k}e-9, {k}e-9, {k}e-9]\n")
    };
    let scene: String = (0..500).map(disk).collect();
    let workspace = Workspace::with(&[("disks.toml", &scene)]);
    let run = workspace.run("bake disks.toml --sun 130,50 --json -").succeeds();
    assert!(run.stderr().contains("more than the typical effort"), "{}", run.stderr());
    let bake: Value = serde_json::from_str(&run.stdout()).expect("JSON");
    let finding = bake["findings"].as_array().expect("findings").last().expect("one");
    assert_eq!((&finding["kind"], &finding["count"]), (&"cut_short".into(), &1.into()));
    // A detail is kept.
    let run = workspace.run("bake disks.toml --sun 130,50 --boundary-depth 3").succeeds();
    assert!(!run.stderr().contains("effort"), "{}", run.stderr());
}
