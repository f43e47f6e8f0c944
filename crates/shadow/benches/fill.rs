//! Fill rates on one thread: points put to the polygons of shadow volumes, beside pixels put to faces by the depth buffer, and beside a pass over memory that
//! compares a depth and changes a count. Plates one over the other fill a picture of a floor; what many take more than few is the fill, without what is done once.
//! `cargo bench -p umbriel-shadow --bench fill`.

use std::{hint::black_box, time::Instant};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{LightSource, Placement, Rectangle};
use umbriel_scene::{Object, Scene, Shape, Sides};
use umbriel_shadow::rivals::{Polygons, Rival, RivalPoint, ShadowVolume};
use umbriel_visibility::{
    View,
    hidden_surface::{DepthBuffer, Shot, draw},
};

/// Runs of which the quickest counts.
const RUNS: usize = 7;
/// Plates over the floor, few and many.
const PLATES: [u32; 2] = [4, 48];
/// Edge of the floor and the plates, metres.
const EDGE: f64 = 40.0;
/// Pixels across.
const SIDE: u32 = 1024;
/// Places that a pass goes over which no cache holds: 192 MiB.
const VAST: u32 = 1 << 24;

#[expect(clippy::print_stdout, reason = "a benchmark shows what it measured")]
fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let [volumes, depths, memory, cache] = pool.install(|| [volumes(), depths(), memory(VAST), memory(SIDE * SIDE)]);
    println!("a point to a polygon of a shadow volume {volumes:>6.2} ns");
    println!("a pixel to a face in the depth buffer   {depths:>6.2} ns: {:.2} of its rate", depths / volumes);
    println!("a depth and a count in memory           {memory:>6.2} ns: {:.2} of its rate", memory / volumes);
    println!("the same of a picture, as caches hold   {cache:>6.2} ns: {:.2} of its rate", cache / volumes);
}

/// A floor, and plates over it in the order of their numbers, the lowest first.
fn scene(plates: u32) -> Scene {
    let plate = |number: u32| {
        let placement = Placement::new(DAffine3::from_translation(DVec3::Y * (0.01 * f64::from(number))));
        let shape = Shape::Rectangle(Rectangle { size: [EDGE; 2] });
        Object::new(format!("plate {number}"), shape, placement.expect("regular"), Sides::Auto).expect("an object")
    };
    Scene { objects: (0..=plates).map(plate).collect(), ..Scene::default() }
}

/// From above, so near that the floor fills the picture.
fn view() -> View {
    let points = [[-9.0, -9.0], [9.0, -9.0], [-9.0, 9.0], [9.0, 9.0]];
    View::framing(points.map(|[x, z]| DVec3::new(x, 0.0, z)), SIDE, SIDE)
}

/// Nanoseconds a look: what the quickest run with many plates takes more than that with few, over how much oftener it looks.
fn rate(run: impl Fn(u32) -> (f64, u64)) -> f64 {
    let quickest = |plates: u32| (0..RUNS).map(|_| run(plates)).min_by(|a, b| a.0.total_cmp(&b.0)).expect("some runs");
    let [(few, looks_of_few), (many, looks_of_many)] = PLATES.map(quickest);
    1e9 * (many - few) / (looks_of_many - looks_of_few) as f64
}

fn volumes() -> f64 {
    let view = view();
    let light = LightSource::sun([0.1, -1.0, 0.2]).expect("a sun");
    let pixels = (0..SIDE * SIDE).map(|pixel| [pixel % SIDE, pixel / SIDE]);
    let rays = pixels.map(|[x, y]| view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5));
    let on_the_floor = |origin: DVec3, direction: DVec3| {
        let position = origin - direction * (origin.y / direction.y);
        let is_there = direction.y < 0.0 && position.x.abs().max(position.z.abs()) < 0.5 * EDGE;
        is_there.then_some(RivalPoint { position, normal: DVec3::Y, ..RivalPoint::default() })
    };
    let points: Vec<RivalPoint> = rays.filter_map(|ray| on_the_floor(ray.origin, ray.direction)).collect();
    let rival = ShadowVolume { eye: Some(view.camera.eye) };
    rate(|plates| {
        let scene = scene(plates);
        let polygons = Polygons::new(&scene, 1);
        let answer = rival.answer(&polygons, &light, &points).expect("shadow volumes take any scene");
        (answer.points_seconds, answer.looked_at)
    })
}

fn depths() -> f64 {
    rate(|plates| {
        let shot = Shot::new(&scene(plates), &view()).expect("few faces");
        let begun = Instant::now();
        let (picture, statistics) = draw(&DepthBuffer::default(), &shot);
        black_box(picture);
        (begun.elapsed().as_secs_f64(), statistics.depths)
    })
}

/// Over so many places.
fn memory(places: u32) -> f64 {
    let depths: Vec<f64> = (0..places).map(|place| f64::from(place % 977)).collect();
    rate(|plates| {
        let mut counts = vec![0i32; depths.len()];
        let begun = Instant::now();
        for plate in 0..plates {
            let limit = black_box(f64::from(plate) * 20.0);
            counts.iter_mut().zip(&depths).for_each(|(count, &depth)| *count += i32::from(depth < limit));
        }
        black_box(&counts);
        (begun.elapsed().as_secs_f64(), u64::from(plates) * depths.len() as u64)
    })
}
