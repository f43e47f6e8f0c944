//! Shadow rays over a town of boxes: what trees cost to build, and how many segments a second they answer, one by one, in
//! packets and in no order.

#[path = "../examples/city/mod.rs"]
mod city;

use std::{hint::black_box, sync::Arc, time::Instant};

use city::{lights, plans};
use glam::DVec3;
use umbriel_bvh::{BuildQuality, Segment, TriangleBvh};
use umbriel_geometry::{Aabb, LightSource, Mesh, MeshDefect, simd::Level};

/// Runs of which the quickest counts.
const RUNS: usize = 5;
/// Points on the upper side of each box, on each of its two axes.
const POINTS: u32 = 8;

/// The sides of a box by its corners, two triangles each; bit k of a corner's index is its side on axis k.
const SIDES: [[u32; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

#[expect(clippy::print_stdout, reason = "a benchmark shows what it measured")]
fn main() -> Result<(), MeshDefect> {
    println!("level {:?}; millions of segments a second", Level::best());
    for plan in plans().into_iter().filter(|plan| plan.families.roots.is_empty()) {
        let mesh = Arc::new(mesh_of(&plan.boxes)?);
        let origins = origins(&plan.boxes);
        let shuffled: Vec<DVec3> = (0..origins.len()).map(|n| origins[n * 7_919 % origins.len()]).collect();
        for quality in [BuildQuality::Fast, BuildQuality::Good] {
            let build = || TriangleBvh::build_with(Arc::clone(&mesh), quality);
            let (bvh, seconds) = (build(), quickest(build));
            println!("{} {quality:?}: {:.0} ns a triangle", plan.name, seconds * 1e9 / bvh.len() as f64);
            for (name, light) in lights().expect("the lights of the plans are in range") {
                println!("  {name:<16} {}", row(&bvh, &origins, &shuffled, light));
            }
        }
    }
    Ok(())
}

fn row(bvh: &TriangleBvh, origins: &[DVec3], shuffled: &[DVec3], light: LightSource) -> String {
    let rate = |seconds: f64| origins.len() as f64 / seconds / 1e6;
    let single = |origins: &[DVec3]| origins.iter().filter(|&&x| bvh.any_hit(&Segment::new(x, light))).count();
    let cached = |origins: &[DVec3]| {
        let mut towards = bvh.towards(light);
        origins.iter().filter(|&&x| towards.any_hit(x)).count()
    };
    format!(
        "single {:>5.1}  neighbours {:>5.1}  packets {:>5.1}  shuffled {:>5.1}  sorted packets {:>5.1}",
        rate(quickest(|| single(origins))),
        rate(quickest(|| cached(origins))),
        rate(quickest(|| bvh.towards(light).any_hits(origins))),
        rate(quickest(|| cached(shuffled))),
        rate(quickest(|| bvh.towards(light).any_hits_unordered(shuffled))),
    )
}

fn mesh_of(boxes: &[Aabb]) -> Result<Mesh, MeshDefect> {
    let corner = |bounds: &Aabb, n: u32| {
        let side = DVec3::new(f64::from(n & 1), f64::from(n >> 1 & 1), f64::from(n >> 2));
        (bounds.min + (bounds.max - bounds.min) * side).to_array()
    };
    let positions = boxes.iter().flat_map(|bounds| (0..8).map(|n| corner(bounds, n))).collect();
    let sides = (0..boxes.len() as u32).flat_map(|n| SIDES.map(|side| side.map(|corner| 8 * n + corner)));
    let triangles = sides.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh::new(positions, triangles)
}

/// Points a centimetre above the upper sides, row by row.
fn origins(boxes: &[Aabb]) -> Vec<DVec3> {
    let at = |n: u32| (f64::from(n) + 0.5) / f64::from(POINTS);
    let on = |bounds: &Aabb| {
        let (min, size) = (bounds.min.with_y(bounds.max.y), bounds.size());
        (0..POINTS * POINTS)
            .map(move |n| min + DVec3::new(at(n % POINTS), 0.0, at(n / POINTS)) * size.with_y(0.0) + DVec3::Y * 0.01)
    };
    boxes.iter().flat_map(on).collect()
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
