//! `umbriel compare`: hard shadows by several ways.

use crate::workspace::Workspace;

const BOX: &str = "[[object]]\nname = \"floor\"\nrectangle = { size = [8, 8] }\n\
                   [[object]]\nname = \"block\"\nbox = { size = [1, 1, 1] }\ntranslation = [0, 1.5, 0]\n\
                   [[object]]\nname = \"ball\"\nsphere = { radius = 0.5 }\ntranslation = [2, 1, 1]\n\
                   [[light]]\nname = \"noon\"\nsun = { direction = [0.3, -1, 0.2] }\n";

#[test]
fn ways_are_held_against_the_truth() {
    let workspace = Workspace::with(&[("box.toml", BOX)]);
    let run = workspace.run("compare box.toml --size 90x60 --map 128 --json out.json -o out.png").succeeds();
    let text = run.stdout();
    let names = ["bake, depth 8", "rays", "shadow volume", "shadow map 128", "literal 4/8"];
    assert!(names.iter().all(|name| text.contains(name)), "{text}");
    let json: serde_json::Value = serde_json::from_str(&workspace.text("out.json")).expect("JSON");
    let wrong = |name: &str| {
        let mut methods = json["methods"].as_array().expect("methods").iter();
        methods.find(|method| method["name"] == name).and_then(|method| method["wrong"].as_u64()).expect("a count")
    };
    assert_eq!([wrong("bake, depth 8"), wrong("points")], [0; 2], "proofs, and exact answers");
    assert!(wrong("shadow map 128") > 0, "a coarse map errs");
    let few = workspace.run("compare box.toml --size 90x60 --method points --method volume").succeeds();
    assert!(few.stdout().contains("points") && !few.stdout().contains("bake"), "{}", few.stdout());
    assert!(workspace.path("out.png").is_file());
    workspace.run("compare box.toml --map 3").fails(2, &["between 16 and 8192"]);
}

#[test]
fn a_bake_takes_the_time_it_is_given() {
    let workspace = Workspace::with(&[("box.toml", BOX)]);
    let run = workspace.run("bake box.toml --time 100ms --json -").succeeds();
    let json: serde_json::Value = serde_json::from_str(&run.stdout()).expect("JSON");
    assert_eq!(json["detail"]["time"], 0.1);
    let run = workspace.run("bake box.toml --memory 20kB --json -").succeeds();
    let json: serde_json::Value = serde_json::from_str(&run.stdout()).expect("JSON");
    assert_eq!(json["detail"]["memory_bytes"], 20_000);
    workspace.run("bake box.toml --time 5").fails(2, &["no unit among s, ms"]);
}
