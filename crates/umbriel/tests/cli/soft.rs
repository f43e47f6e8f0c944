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
    let methods = json["methods"].as_array().expect("methods");
    assert_eq!(methods.len(), 6);
    for method in methods {
        let number = |key: &str| method[key].as_f64().expect("a number");
        assert!(number("seconds") > 0.0 && number("rmse") <= number("largest"), "{method}");
        assert!(number("rmse") < 0.12, "{method}");
    }
    assert_eq!(json["boxes"]["outline_corners"], serde_json::json!([4]));
    let one = workspace.run("soft plate.toml --size 40x30 --map 64 --method boxes --json -").succeeds();
    assert!(one.stdout().contains("\"name\": \"boxes\"") && !one.stdout().contains("pcss"), "{}", one.stdout());
}

#[test]
fn what_has_no_depth_map_is_refused() {
    let curved = format!("{PLATE}[[object]]\nname = \"ball\"\nsphere = {{ radius = 1 }}\n");
    let workspace = Workspace::with(&[("plate.toml", PLATE), ("ball.toml", &curved)]);
    workspace.run("soft plate.toml --light noon").fails(1, &["no chosen light is a rectangle"]);
    workspace.run("soft ball.toml --size 8x8").fails(1, &["ball", "curved"]);
    workspace.run("soft plate.toml --map 3").fails(2, &["between 16 and 8192"]);
}
