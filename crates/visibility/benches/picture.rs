//! Pictures: nanoseconds a pixel of a scene of boxes and balls, by the size of the picture; and milliseconds of the depth buffer, by SIMD level.
//! `cargo bench -p umbriel-visibility`.

use std::{hint::black_box, time::Instant};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, Placement, Rectangle, simd::Level};
use umbriel_scene::{Object, Scene, Shape, Sides};
use umbriel_visibility::{
    RayCaster, View,
    hidden_surface::{DepthBuffer, Shot, draw},
};

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
    depth_buffer();
}

/// The depth buffer on boxes whose faces cover long runs of pixels, levels in turns.
#[expect(clippy::print_stdout, reason = "a benchmark shows what it measured")]
fn depth_buffer() {
    const ROUNDS: usize = 15;
    let mut scene = scene();
    scene.objects.retain(|object| object.facets().is_some());
    for (edge, tile) in [(1024, [64, 32]), (4096, [64, 32]), (4096, [4096, 1])] {
        let shot = Shot::new(&scene, &View::of(&scene, edge, edge)).expect("a view");
        let levels: Vec<Level> = Level::ALL.into_iter().filter(|level| level.is_available()).collect();
        let mut best = vec![f64::INFINITY; levels.len()];
        for _ in 0..ROUNDS {
            for (level, best) in levels.iter().zip(&mut best) {
                level.limit();
                let begun = Instant::now();
                black_box(draw(&DepthBuffer { tile }, &shot));
                *best = best.min(begun.elapsed().as_secs_f64());
            }
        }
        for (level, seconds) in levels.iter().zip(&best) {
            let [columns, rows] = tile;
            let gain = best[0] / seconds;
            println!(
                "{edge:>4} pixels across, tiles {columns} x {rows}: {level:?} {:.2} ms, gain {gain:.2}",
                seconds * 1e3
            );
        }
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
