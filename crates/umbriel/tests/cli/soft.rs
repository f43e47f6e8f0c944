//! `umbriel soft`: methods side by side.

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
fn what_has_no_depth_map_is_refused() {
    let curved = format!("{PLATE}[[object]]\nname = \"ball\"\nsphere = {{ radius = 1 }}\n");
    let workspace = Workspace::with(&[("plate.toml", PLATE), ("ball.toml", &curved)]);
    workspace.run("soft plate.toml --light noon").fails(1, &["no chosen light has an extent"]);
    workspace.run("soft ball.toml --size 8x8 --method pcss").fails(1, &["ball", "curved"]);
    let areas = workspace.run("soft ball.toml --receiver ball --boundary-depth 4").succeeds();
    assert!(areas.stdout().contains("penumbra %") && !areas.stdout().contains("pcss"), "{}", areas.stdout());
    workspace.run("soft plate.toml --map 3").fails(2, &["between 16 and 8192"]);
}

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
}
