//! Exact arithmetic is the rare path: on ordinary scenes floats, or pairs of them, settle all but a few decisions.
//!
//! One test alone, for decisions are counted over the whole process.

use std::path::{Path, PathBuf};

use umbriel_geometry::{LightSource, decisions::Decisions};
use umbriel_io::{LoadOptions, load};
use umbriel_scene::{Light, Scene};
use umbriel_shadow::{Detail, Request, Sampling, Silent, bake};

/// The scenes of the repository and, where they are at hand, of public collections.
#[expect(clippy::print_stderr, reason = "what is skipped is said")]
fn scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let fixtures = root.join("fixtures").read_dir().expect("fixtures").map(|entry| entry.expect("an entry").path());
    let is_scene = |path: &PathBuf| {
        path.extension().is_some_and(|extension| ["toml", "obj", "gltf", "glb"].iter().any(|known| extension == *known))
    };
    let mut scenes: Vec<PathBuf> = fixtures.filter(is_scene).collect();
    assert!(scenes.len() >= 15, "the fixtures are there");
    for name in ["delft-city/delft.obj", "spot/spot.obj", "bunny/stanford-bunny.obj", "cornell/cornell_box.obj"] {
        let path = root.join("../shared/data").join(name);
        if path.exists() {
            scenes.push(path);
        } else {
            eprintln!("skipped: the collection with {name} is not here");
        }
    }
    scenes
}

fn read(path: &Path) -> Scene {
    let mut scene = load(path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}")).scene;
    let sun = LightSource::sun([0.24, -0.7, 0.66]).expect("a sun");
    scene.lights.push(Light::new("one more sun", sun));
    scene
}

/// Samples asked for.
const SAMPLES: u64 = 20_000;

/// What a bake decides.
fn decisions_of(scene: &Scene, request: &Request) -> Decisions {
    let before = Decisions::of_process();
    bake(scene, request, &Silent).expect("not cancelled");
    Decisions::of_process() - before
}

/// Fewer than one of 10,000.
fn is_rare(number: u64, all: u64) -> bool {
    number * 10_000 < all.max(10_000)
}

#[test]
fn exact_arithmetic_settles_fewer_than_one_decision_of_ten_thousand() {
    let mut wrong = Vec::new();
    for path in scenes() {
        let scene = read(&path);
        let cells = Request::everything(&scene, Detail::Depth { interior: 5, boundary: 5 });
        let samples =
            Request { sampling: Some(Sampling::Count(SAMPLES)), ..Request::everything(&scene, Detail::Faces) };
        let (cells, samples) = (decisions_of(&scene, &cells), decisions_of(&scene, &samples));
        let exact = |of: Decisions| of.expansion + of.exact;
        if ![cells, samples].into_iter().all(|of| is_rare(exact(of), of.all())) {
            wrong.push(format!("{}: cells {cells:?}, samples {samples:?}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
