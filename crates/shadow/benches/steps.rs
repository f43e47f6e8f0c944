//! What a bake and its parts take on boxes over a floor: cells by depth, samples by number, single queries.
//! Times are those of the quickest of some runs. `cargo bench -p umbriel-shadow`.

use std::{hint::black_box, time::Instant};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Cuboid, LightSource, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Detail, Place, Queries, Request, Sampling, Silent, bake, for_each_sample};

/// Runs of which the quickest counts.
const RUNS: usize = 3;
/// Boxes along an edge of the floor.
const ROW: i32 = 20;

fn main() {
    let scene = boxes();
    let (lights, receivers) = (scene.lights.len(), scene.objects.len());
    for depth in [4, 6, 8] {
        let request = Request::everything(&scene, Detail::Depth { interior: 0, boundary: depth });
        let seconds = quickest(|| bake(&scene, &request, &Silent));
        show(&format!("cells, depth {depth}"), seconds, (lights * receivers) as f64, "receiver and light");
    }
    for count in [1 << 14, 1 << 18] {
        let sampling = Some(Sampling::Count(count));
        let request = Request { sampling, ..Request::everything(&scene, Detail::Depth { interior: 0, boundary: 0 }) };
        let seconds = quickest(|| bake(&scene, &request, &Silent));
        show(&format!("{count} samples"), seconds, (count * lights as u64) as f64, "sample");
    }
    let sampling = Some(Sampling::Count(1 << 14));
    let request = Request { sampling, ..Request::everything(&scene, Detail::default()) };
    let mut places = Vec::new();
    for_each_sample(&scene, &request, |at| {
        places.push(Place::Surface { object: at.object, face: at.face, u: at.u, v: at.v });
    });
    let queries = Queries::new(&scene);
    for light in &scene.lights {
        let ask = || places.iter().filter(|place| queries.lit(place, &light.source).is_ok_and(|a| a.lit)).count();
        show(&format!("queries, {}", light.name), quickest(ask), places.len() as f64, "point");
    }
}

/// Boxes of several heights on a floor, under a sun and a lamp.
fn boxes() -> Scene {
    let mut objects = Vec::new();
    let mut add = |name: String, shape, at: DVec3| {
        let placement = Placement::new(DAffine3::from_translation(at)).expect("a translation is regular");
        objects.push(Object::new(name, shape, placement, Sides::One).expect("sizes are positive"));
    };
    let edge = 2.0 * f64::from(ROW) + 2.0;
    add("floor".into(), Shape::Rectangle(Rectangle { size: [edge, edge] }), DVec3::ZERO);
    for number in 0..ROW * ROW {
        let (i, j) = (number % ROW, number / ROW);
        let height = f64::from((7 * i + 5 * j) % 11 + 1) / 4.0;
        let at = DVec3::new(f64::from(2 * i - ROW + 1), 0.5 * height, f64::from(2 * j - ROW + 1));
        add(format!("box {number}"), Shape::Cuboid(Cuboid { size: [1.0, height, 0.75] }), at);
    }
    let sun = LightSource::sun([0.5, -1.0, 0.25]).expect("a direction");
    let lamp = LightSource::point([0.5, 9.0, 0.25]).expect("a position");
    let lights = [("sun", sun), ("lamp", lamp)].map(|(name, source)| Light::new(name, source));
    Scene { objects: objects.into(), lights: lights.to_vec(), ..Scene::default() }
}

/// Seconds of the quickest run.
fn quickest<T>(mut run: impl FnMut() -> T) -> f64 {
    let time = |_| {
        let begun = Instant::now();
        black_box(run());
        begun.elapsed().as_secs_f64()
    };
    (0..RUNS).map(time).fold(f64::INFINITY, f64::min)
}

#[expect(clippy::print_stdout, reason = "a benchmark shows what it measured")]
fn show(name: &str, seconds: f64, count: f64, what: &str) {
    println!("{name:<18} {:>9.1} ms {:>10.1} ns a {what}", seconds * 1e3, seconds * 1e9 / count);
}
