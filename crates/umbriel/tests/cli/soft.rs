//! `umbriel soft`: methods side by side.

use std::{fs, path::Path};

use crate::workspace::Workspace;

const PLATE: &str = "[[object]]\nname = \"floor\"\nrectangle = { size = [20, 20] }\n\
                     [[object]]\nname = \"block\"\nbox = { size = [4, 1, 4] }\ntranslation = [0, 5, 0]\n\
                     [[light]]\nname = \"panel\"\nrectangle = { center = [0, 12, 0], u = [0.5, 0, 0], v = [0, 0, 0.5] }\n\
                     [[light]]\nname = \"noon\"\nsun = { direction = [0, -1, 0] }\n";

#[test]
fn methods_are_compared_with_the_truth() {
    let workspace = Workspace::with(&[("plate.toml", PLATE)]);
    let run = workspace.run("soft plate.toml --size 80x60 --map 256 --json out.json -o out.png").succeeds();
    assert!(run.stdout().contains("pcss") && run.stdout().contains("boxes-refined"), "{}", run.stdout());
    let json: serde_json::Value = serde_json::from_str(&workspace.text("out.json")).expect("JSON");
    let methods = json["pictures"]["methods"].as_array().expect("methods");
    assert_eq!(methods.len(), 7);
    for method in methods {
        let number = |key: &str| method[key].as_f64().expect("a number");
        assert!(number("seconds") > 0.0 && number("rmse") <= number("largest"), "{method}");
        assert!(number("rmse") < 0.12, "{method}");
    }
    assert!(methods[6]["name"] == "cells" && methods[6]["rmse"].as_f64() < Some(0.02), "{}", methods[6]);
    assert_eq!(json["pictures"]["outline_corners"], serde_json::json!([4]));
    // The panel throws the block's shadow 12/7 and, about it, itself by 5/7 (6/7 and 1/2 from the bottom's edge up).
    let floor = &json["lights"][0]["objects"][0];
    let between =
        |key: &str| [&floor[key]["lower"], &floor[key]["upper"]].map(|bound| bound.as_f64().expect("a bound"));
    let [lower, upper] = between("umbra");
    assert!(lower > 20.0 && lower <= upper && upper < 60.0, "{floor}");
    let [least, most] = between("visible");
    assert!(least <= most && most < 400.0 - lower && between("lit")[0] > 300.0, "{floor}");
    let one = workspace.run("soft plate.toml --size 40x30 --map 64 --method boxes --json -").succeeds();
    assert!(one.stdout().contains("\"name\": \"boxes\"") && !one.stdout().contains("pcss"), "{}", one.stdout());
}

#[test]
fn limits_are_details() {
    let workspace = Workspace::with(&[("plate.toml", PLATE)]);
    for limit in ["--time 1s", "--memory 50kB", "--max-undecided 0.05"] {
        let run = workspace.run(&format!("soft plate.toml --size 16x12 --map 64 {limit} --json -")).succeeds();
        let json: serde_json::Value = serde_json::from_str(&run.stdout()).expect("JSON");
        let mean = &json["lights"][0]["objects"][0]["visible_fraction"];
        let [lower, upper] = ["lower", "upper"].map(|key| mean[key].as_f64().expect("a number"));
        assert!(lower > 0.8 && lower <= upper && upper < 1.0, "{limit}: {mean}");
    }
}

#[test]
fn lights_without_extent_are_refused() {
    let workspace = Workspace::with(&[("plate.toml", PLATE)]);
    workspace.run("soft plate.toml --light noon").fails(1, &["no chosen light has an extent"]);
    workspace.run("soft plate.toml --map 3").fails(2, &["between 16 and 8192"]);
}

/// Under each kind of area light, sheets and curved bodies shade and slabs do not shade themselves.
#[test]
fn every_light_and_body_has_its_picture() {
    let bodies = "[[object]]\nname = \"slab\"\nbox = { size = [20, 1, 20] }\ntranslation = [0, -0.5, 0]\n\
                  [[object]]\nname = \"sheet\"\nrectangle = { size = [4, 4] }\ntranslation = [0, 5, 0]\n\
                  [[object]]\nname = \"ball\"\nsphere = { radius = 1.5 }\ntranslation = [6, 3, 0]\n\
                  [camera]\neye = [0, 14, 22]\ntarget = [0, 0, 0]\n";
    for light in [
        "rectangle = { center = [0, 12, 0], u = [0.5, 0, 0], v = [0, 0, 0.5] }",
        "point = { position = [0, 12, 0], radius = 0.5 }",
        "sun = { direction = [0.1, -1, 0.1], angular_diameter = 4 }",
    ] {
        let scene = format!("{bodies}[[light]]\nname = \"wide\"\n{light}\n");
        let workspace = Workspace::with(&[("all.toml", &scene)]);
        let run = workspace.run("soft all.toml --size 80x60 --map 512 --boundary-depth 6 --json -").succeeds();
        let json: serde_json::Value = serde_json::from_str(&run.stdout()).expect("JSON");
        let pictures = &json["pictures"];
        assert_eq!(pictures["boxes"], 2, "the sheet and the ball block, the slab does not: {light}");
        for method in pictures["methods"].as_array().expect("methods") {
            let number = |key: &str| method[key].as_f64().expect("a number");
            // All lit would be off by the shadows, all touched by the slab itself.
            assert!(number("rmse") < 0.08, "{light}: {method}");
            assert!(number("touched") > 0.02 && number("touched") < 0.4, "{light}: {method}");
        }
    }
}

#[test]
fn given_boxes_are_used_and_checked() {
    let workspace = Workspace::with(&[
        ("plate.toml", &PLATE.replace("translation = [0, 5, 0]\n", BOXES)),
        ("out.toml", &PLATE.replace("translation = [0, 5, 0]\n", &BOXES.replace("[1.0, 0, 0]", "[0.9, 0, 0]"))),
        ("flat.toml", &PLATE.replace("translation = [0, 5, 0]\n", &BOXES.replace("[1.0, 0, 0]", "[0, 2, 0]"))),
    ]);
    let run = workspace.run("soft plate.toml --size 40x30 --map 64 --method boxes --json -").succeeds();
    assert!(run.stdout().contains("\"boxes\": 2"), "{}", run.stdout());
    workspace.run("info out.toml").fails(1, &["block", "vertex", "none of its boxes"]);
    workspace.run("info flat.toml").fails(1, &["block", "box 0 has no volume"]);
}

/// Two halves of the block.
const BOXES: &str = "translation = [0, 5, 0]\nboxes = [{ center = [-1, 0, 0], half = [[1.0, 0, 0], [0, 0.5, 0], [0, 0, 2]] }, \
                     { center = [1, 0, 0], half = [[1.0, 0, 0], [0, 0.5, 0], [0, 0, 2]] }]\n";

#[test]
fn blockers_move_from_frame_to_frame() {
    let workspace = Workspace::with(&[("plate.toml", PLATE)]);
    let run = |rest: &str| -> serde_json::Value {
        let text = workspace.run(&format!("soft plate.toml --size 40x30 --map 64 --method boxes --json - {rest}"));
        serde_json::from_str(&text.succeeds().stdout()).expect("JSON")
    };
    let (still, moving) = (run(""), run("--frames 3 --step 1,0,0"));
    assert_eq!((&still["pictures"]["frames"], &moving["pictures"]["frames"]), (&1.into(), &3.into()));
    // The block's shadow leaves the picture's part that it touched.
    assert_ne!(still["pictures"]["methods"][0]["touched"], moving["pictures"]["methods"][0]["touched"]);
    // Areas are those of the scene as it stands in the file.
    assert_eq!(still["lights"], moving["lights"]);
    workspace.run("soft plate.toml --frames 0").fails(2, &["0"]);
    // A sheet moves, too.
    let sheet = PLATE.replace("box = { size = [4, 1, 4] }", "rectangle = { size = [4, 4] }");
    let workspace = Workspace::with(&[("plate.toml", &sheet)]);
    let touched = |rest: &str| {
        let text = workspace.run(&format!("soft plate.toml --size 40x30 --map 64 --method boxes --json - {rest}"));
        let json: serde_json::Value = serde_json::from_str(&text.succeeds().stdout()).expect("JSON");
        json["pictures"]["methods"][0]["touched"].as_f64().expect("a share")
    };
    let still = touched("");
    assert!(still > 0.0 && touched("--frames 2 --step 30,0,0") < still, "{still}");
}

/// Parts of boxes describe the robot at least as well as its four boxes, under lights of several sizes, and leave no hole in its shadow.
#[test]
fn parts_of_boxes_are_no_worse_than_boxes() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let [robot, parts] =
        ["robot.toml", "robot-parts.obj"].map(|file| fs::read_to_string(fixtures.join(file)).expect("a fixture"));
    let light = "u = [2.8657, -2.5224, 1.194], v = [-1.5385, 0.0, 3.6923]";
    assert!(robot.contains(light));
    for scale in [0.75, 1.25, 1.5, 3.0] {
        let scaled = |v: [f64; 3]| v.map(|value| value * scale);
        let (u, v) = (scaled([2.8657, -2.5224, 1.194]), scaled([-1.5385, 0.0, 3.6923]));
        let scene = robot.replace(light, &format!("u = {u:?}, v = {v:?}"));
        let workspace = Workspace::with(&[("robot.toml", &scene), ("robot-parts.obj", &parts)]);
        let run = workspace.run(
            "soft robot.toml --size 400x300 --map 1024 --receiver floor --boundary-depth 2 --method boxes \
             --method boxes-refined --json -",
        );
        let json: serde_json::Value = serde_json::from_str(&run.succeeds().stdout()).expect("JSON");
        let rmse = |method: usize| json["pictures"]["methods"][method]["rmse"].as_f64().expect("a number");
        assert!(rmse(1) < 1.1 * rmse(0), "{scale}: {} and {}", rmse(1), rmse(0));
    }
}
