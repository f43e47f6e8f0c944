//! How much memory a bake takes: each case in a process of its own, this program again.
//!
//! In one process the memory that one case freed would be what the next one takes.

#![allow(clippy::print_stdout, reason = "figures are what these tests tell")]

use std::{env, process::Command, sync::Arc};

use glam::{DAffine3, DQuat, DVec3};
use umbriel_geometry::{Cuboid, LightSource, Mesh, Placement, Rectangle};
use umbriel_io::MemoryPeak;
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Detail, ObjectReport, Request, Silent, bake};

/// Which case a process is for.
const CASE: &str = "UMBRIEL_MEMORY_CASE";

/// What is said before the figure.
const FIGURE: &str = "bytes held at most: ";

fn placed(name: String, shape: Shape, map: DAffine3) -> Object {
    Object::new(name, shape, Placement::new(map).expect("regular"), Sides::Auto).expect("an object")
}

fn floor(size: f64) -> Object {
    placed("floor".into(), Shape::Rectangle(Rectangle { size: [size; 2] }), DAffine3::IDENTITY)
}

fn lit(objects: Vec<Object>) -> Scene {
    let sun = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
    Scene { objects: objects.into(), lights: vec![Light::new("sun", sun)], ..Scene::default() }
}

/// A floor with a hundred boxes over it, and `far` boxes that cannot shadow it.
fn boxes(far: u32) -> Scene {
    let cuboid = |name: String, at: DVec3| {
        placed(name, Shape::Cuboid(Cuboid { size: [1.0; 3] }), DAffine3::from_translation(at))
    };
    let place =
        |k: u32, height: f64| DVec3::new(3.0 * f64::from(k % 10) - 15.0, height, 3.0 * f64::from(k / 10) - 15.0);
    let near = (0..100).map(|k| cuboid(format!("near {k}"), place(k, 1.5)));
    let far = (0..far).map(|k| cuboid(format!("far {k}"), place(k, 1.5) + DVec3::new(0.0, -100.0, 5000.0)));
    lit(std::iter::once(floor(40.0)).chain(near).chain(far).collect())
}

/// A globe of 4,000 triangles, as fine as a common teapot.
fn globe() -> Mesh {
    let (rings, sides) = (41u32, 50u32);
    let point = |k: u32| {
        let (ring, side) = (k / sides, k % sides);
        let (up, turn) = (f64::from(ring) / f64::from(rings - 1), f64::from(side) / f64::from(sides));
        // A circle by its rational parameters, quarter by quarter.
        let quarter = (turn * 4.0).floor();
        let t = turn * 4.0 - quarter;
        let (x, z) = ((1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t));
        let (x, z) = [(x, z), (-z, x), (-x, -z), (z, -x)][quarter as usize];
        let width = 0.05 + (4.0 * up * (1.0 - up)).sqrt();
        [width * x, 2.0 * up - 1.0, width * z]
    };
    let square = |k: u32| {
        let (ring, side) = (k / sides, k % sides);
        let [a, b] = [side, (side + 1) % sides].map(|side| ring * sides + side);
        [[a, a + sides, b], [b, a + sides, b + sides]]
    };
    let triangles = (0..(rings - 1) * sides).flat_map(square).collect();
    Mesh::new((0..rings * sides).map(point).collect(), triangles).expect("a mesh")
}

/// Instances of one mesh, each turned and of its own size, over a floor.
fn globes(count: u32) -> Scene {
    let mesh = Arc::new(globe());
    let instance = |k: u32| {
        let part = |step: f64| (f64::from(k) * step).fract();
        let turn = DQuat::from_xyzw(part(0.618), part(0.414), part(0.732), 0.5 + part(0.236)).normalize();
        let at = DVec3::new(40.0 * part(0.754_877), 2.0 + 10.0 * part(0.302_775), 40.0 * part(0.569_840));
        let map = DAffine3::from_scale_rotation_translation(DVec3::splat(0.5 + part(0.192)), turn, at);
        placed(format!("globe {k}"), Shape::Mesh(Arc::clone(&mesh)), map)
    };
    lit(std::iter::once(floor(250.0)).chain((0..count).map(instance)).collect())
}

fn request(scene: &Scene, case: &str) -> Request {
    let receivers = if case.starts_with("boxes") { vec![0] } else { (0..scene.objects.len()).collect() };
    let (interior, boundary) = if case.starts_with("shallow") { (2, 3) } else { (4, 6) };
    Request { receivers, ..Request::everything(scene, Detail::Depth { interior, boundary }) }
}

/// The one that the other tests run: a case by its name and number.
#[test]
fn a_case() {
    let Ok(case) = env::var(CASE) else { return };
    let count = |name: &str| case.strip_prefix(name).and_then(|count| count.parse().ok());
    let scene = match (count("boxes "), count("globes ").or(count("shallow globes "))) {
        (Some(far), _) => boxes(far),
        (_, Some(instances)) => globes(instances),
        _ => panic!("{case}"),
    };
    let request = request(&scene, &case);
    let peak = MemoryPeak::start();
    let report = bake(&scene, &request, &Silent).expect("nobody cancels");
    assert_eq!(report.lights[0].objects.len(), request.receivers.len());
    if let Some(bytes) = peak.bytes() {
        println!("{FIGURE}{bytes}");
    }
}

/// The bytes that a case takes beside its scene; `None` where the system does not tell.
fn bytes_of(case: &str) -> Option<u64> {
    let mut own = Command::new(env::current_exe().expect("this program"));
    own.env("MALLOC_MMAP_THRESHOLD_", "65536").env("MALLOC_TRIM_THRESHOLD_", "65536").env(CASE, case);
    let output = own.args(["--exact", "a_case", "--nocapture"]).output().expect("this program runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("words");
    let bytes = text.lines().find_map(|line| line.split_once(FIGURE))?.1;
    Some(bytes.parse().expect("a number"))
}

#[test]
fn objects_without_influence_take_their_boxes() {
    let Some([alone, crowded]) = bytes_of("boxes 0").zip(bytes_of("boxes 10000")).map(<[u64; 2]>::from) else { return };
    let each = crowded.saturating_sub(alone) as f64 / 1e4;
    println!("{alone} bytes alone, {crowded} beside 10,000 without influence: {each:.0} bytes each");
    // A box is 48 bytes, marks and numbers of faces take nine, and places for what would be built of 64 objects 16 in each of four lists.
    assert!(each < 100.0, "{each} bytes an object");
}

#[test]
fn instances_are_placed_for_a_while() {
    let Some([one, all]) = bytes_of("globes 1").zip(bytes_of("globes 200")).map(<[u64; 2]>::from) else { return };
    let [results, placed] = [size_of::<Object>() + size_of::<ObjectReport>(), size_of_val(globe().positions())]
        .map(|bytes| 200 * bytes as u64);
    let [one_mb, all_mb, results_mb, placed_mb] = [one, all, results, placed].map(|bytes| bytes as f64 / 1e6);
    println!("one globe {one_mb:.1} MB, 200 of them {all_mb:.1} MB; {results_mb:.1} MB are objects and results");
    println!("the vertices of all of them would be {placed_mb:.1} MB");
    assert!(all < one + results + placed / 4, "{all} bytes beside {one}");
    // Few cells want no more: the floor has 800,000 triangles over it.
    let Some(shallow) = bytes_of("shallow globes 200") else { return };
    println!("with few cells {:.1} MB", shallow as f64 / 1e6);
    assert!(shallow < one + results + placed / 4, "{shallow} bytes beside {one}");
}
