//! `umbriel tradeoff`: settings, judged by exact answers.

use crate::workspace::Workspace;

const BOX: &str = "[[object]]\nname = \"floor\"\nrectangle = { size = [8, 8] }\n\
                   [[object]]\nname = \"block\"\nbox = { size = [1, 1, 1] }\ntranslation = [0, 1.5, 0]\n\
                   [[light]]\nname = \"noon\"\nsun = { direction = [0.3, -1, 0.2] }\n";

#[test]
fn settings_are_measured_and_charted() {
    let workspace = Workspace::with(&[("box.toml", BOX)]);
    let options = "--points 5000 --max-depth 5 --runs 1 --limit 0.05 --error 0.05";
    let command = format!("tradeoff box.toml {options} -o out.csv -o out.svg -o out.png -o out.json");
    let run = workspace.run(&command).succeeds();
    assert!(run.stdout().contains("with bounds that say so themselves: bake, "), "{}", run.stdout());
    let json: serde_json::Value = serde_json::from_str(&workspace.text("out.json")).expect("JSON");
    let settings = json["settings"].as_array().expect("settings");
    let bakes: Vec<_> = settings.iter().filter(|one| one["family"] == "umbriel, cells with proofs").collect();
    let depths = bakes.iter().filter(|bake| bake["name"].as_str().is_some_and(|name| name.starts_with("bake, depth")));
    assert_eq!(depths.count(), 5);
    assert!(bakes.iter().all(|bake| bake["wrong"] == 0.0), "proofs");
    for name in ["bake, undecided 0.1", "bake, 10 ms", "bake, 0.1 MB", "bake, cells of 0.8 m", "points"] {
        assert!(settings.iter().any(|one| one["name"] == name && one["wrong"] == 0.0), "{name}");
    }
    assert!(settings.iter().any(|one| one["on_time_front"] == true));
    assert_eq!(workspace.text("out.csv").lines().count(), settings.len() + 1);
    assert!(workspace.text("out.svg").contains("milliseconds"));
    assert!(workspace.path("out.png").is_file());
    if cfg!(target_os = "linux") {
        let peak =
            |name: &str| settings.iter().find(|one| one["name"] == name).and_then(|one| one["peak_bytes"].as_u64());
        assert!(settings.iter().all(|one| one["peak_bytes"].is_u64()), "each setting has a process of its own");
        // A texel is a float; the largest map comes after many settings that freed as much.
        if let [Some(small), Some(large)] = ["shadow map 256", "shadow map 1024"].map(peak) {
            assert!(large > small + (3 << 20), "{small} and {large} bytes");
        }
    }
}
