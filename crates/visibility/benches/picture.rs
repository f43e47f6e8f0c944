//! Pictures: nanoseconds a pixel of a scene of boxes and balls, by the size of the picture; and milliseconds of the depth buffer, by SIMD level.
//! `cargo bench -p umbriel-visibility`.

use std::{hint::black_box, time::Instant};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, Placement, Rectangle, simd::Level};
use umbriel_scene::{Camera, Object, Projection, Scene, Shape, Sides};
use umbriel_visibility::{
    RayCaster, View,
    hidden_surface::{DepthBuffer, HiddenSurface, Shot, Window, draw},
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

/// The depth buffer by SIMD levels, in turns: whole pictures of boxes, and a tile under many slanted sheets, where nearly all of the work is depths.
#[expect(clippy::print_stdout, reason = "a benchmark shows what it measured")]
fn depth_buffer() {
    let mut boxes = scene();
    boxes.objects.retain(|object| object.facets().is_some());
    let shot = Shot::new(&boxes, &View::of(&boxes, 1024, 1024)).expect("a view");
    let best = by_level(|| drop(black_box(draw(&DepthBuffer::default(), &shot))));
    best.iter().for_each(|(level, ms)| println!("1024 x 1024 pixels of boxes: {level:?} {ms:.2} ms"));

    let sheets = sheets();
    let camera = Camera {
        eye: DVec3::new(0.0, 8.0, 0.0),
        target: DVec3::ZERO,
        up: DVec3::NEG_Z,
        projection: Projection::Perspective { vertical_degrees: 40.0 },
    };
    let shot = Shot::new(&sheets, &View { camera, width: 1024, height: 32 }).expect("a view");
    let (window, faces) = (Window { left: 0, top: 0, right: 1024, bottom: 32 }, Vec::from_iter(0..SHEETS));
    let mut pixels = vec![0; window.area()];
    let best = by_level(|| {
        pixels.fill(u32::MAX);
        black_box(DepthBuffer { tile: [1024, 32] }.draw(&shot, &window, &faces, &mut pixels));
    });
    best.iter().for_each(|(level, ms)| println!("a tile of 1024 x 32 under {SHEETS} sheets: {level:?} {ms:.3} ms"));
}

/// The quickest of some runs at each level of this processor, milliseconds.
fn by_level(mut run: impl FnMut()) -> Vec<(Level, f64)> {
    const ROUNDS: usize = 40;
    let levels = Level::ALL.into_iter().filter(|level| level.is_available());
    let mut best: Vec<(Level, f64)> = levels.map(|level| (level, f64::INFINITY)).collect();
    for _ in 0..ROUNDS {
        for (level, best) in &mut best {
            level.limit();
            let begun = Instant::now();
            run();
            *best = best.min(begun.elapsed().as_secs_f64() * 1e3);
        }
    }
    best
}

const SHEETS: u32 = 64;

/// Sheets through each other, each all over the picture.
fn sheets() -> Scene {
    let sheet = |number: u32| {
        let turn =
            DAffine3::from_rotation_y(f64::from(number)) * DAffine3::from_rotation_x(0.01 * f64::from(number % 8 + 1));
        let placement = Placement::new(turn).expect("a rotation is regular");
        let shape = Shape::Rectangle(Rectangle { size: [400.0, 400.0] });
        Object::new(format!("sheet {number}"), shape, placement, Sides::Two).expect("sizes are positive")
    };
    Scene { objects: (0..SHEETS).map(sheet).collect(), ..Scene::default() }
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
            _ => Shape::from(Analytic::Sphere { radius: 0.75 }),
        };
        add(format!("body {number}"), shape, at);
    }
    Scene { objects: objects.into(), ..Scene::default() }
}
