//! Pictures: nanoseconds a pixel of a scene of boxes and balls, by the size of the picture.
//! `cargo bench -p umbriel-visibility`.

use std::{hint::black_box, time::Instant};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, Placement, Rectangle};
use umbriel_scene::{Object, Scene, Shape, Sides};
use umbriel_visibility::{RayCaster, View};

/// Runs of which the quickest counts.
const RUNS: usize = 3;

#[expect(clippy::print_stdout, reason = "a benchmark shows what it measured")]
fn main() {
    let scene = scene();
    let begun = Instant::now();
    let caster = RayCaster::new(&scene);
    println!("{} bodies, prepared in {:.2} ms", scene.objects.len(), begun.elapsed().as_secs_f64() * 1e3);
    for edge in [128, 512] {
        let view = View::of(&scene, edge, edge);
        let time = |_| {
            let begun = Instant::now();
            black_box(caster.picture(&view));
            begun.elapsed().as_secs_f64()
        };
        let seconds = (0..RUNS).map(time).fold(f64::INFINITY, f64::min);
        let pixels = f64::from(edge * edge);
        println!("{edge:>4} pixels across {:>8.1} ms {:>8.1} ns a pixel", seconds * 1e3, seconds * 1e9 / pixels);
    }
}

/// Boxes and balls in turn on a floor.
fn scene() -> Scene {
    let mut objects = Vec::new();
    let mut add = |name: String, shape, at: DVec3| {
        let placement = Placement::new(DAffine3::from_translation(at)).expect("a translation is regular");
        objects.push(Object::new(name, shape, placement, Sides::One).expect("sizes are positive"));
    };
    add("floor".into(), Shape::Rectangle(Rectangle { size: [44.0, 44.0] }), DVec3::ZERO);
    for number in 0..400 {
        let at = DVec3::new(f64::from(number % 20) * 2.0 - 19.0, 0.75, f64::from(number / 20) * 2.0 - 19.0);
        let shape = match number % 2 {
            0 => Shape::Cuboid(Cuboid { size: [1.0, 1.5, 1.0] }),
            _ => Shape::Analytic(Analytic::Sphere { radius: 0.75 }),
        };
        add(format!("body {number}"), shape, at);
    }
    Scene { objects, ..Scene::default() }
}
