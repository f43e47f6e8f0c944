//! The side of a plane, exactly: nanoseconds a decision beside the published predicate (`robust`), on points in general
//! position, on points within an ulp of the plane, and on points in it. `cargo bench -p umbriel-geometry`.

use std::{hint::black_box, time::Instant};

use glam::DVec3;
use umbriel_geometry::{Point, predicates::side};

/// Runs of which the quickest counts.
const RUNS: usize = 5;

#[expect(clippy::print_stdout, reason = "a benchmark shows what it measured")]
fn main() {
    let corners: Vec<DVec3> = (1..=20_000).map(scattered).collect();
    let near = |k: usize| {
        let [a, b, c] = [k, k + 1, k + 2].map(|k| corners[k]);
        a + (b - a) * 0.25 + (c - a) * 0.5
    };
    let level = |k: usize| DVec3::new(corners[k].x, corners[k].y, 0.0);
    println!("ns a decision                    own   robust   own/robust");
    let general = |k: usize| [k, k + 1, k + 2, k + 3].map(|k| corners[k]);
    compare("in general position", general);
    compare("within an ulp of the plane", |k| [corners[k], corners[k + 1], corners[k + 2], near(k)]);
    compare("in the plane", |k| [k, k + 1, k + 2, k + 3].map(level));
}

/// Points of a cube in a fixed pattern of low discrepancy (Roberts' R3 sequence).
fn scattered(number: u32) -> DVec3 {
    let steps = DVec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2);
    (steps * f64::from(number)).fract() - 0.5
}

#[expect(clippy::print_stdout, reason = "a benchmark shows what it measured")]
fn compare(name: &str, points: impl Fn(usize) -> [DVec3; 4]) {
    let cases: Vec<[DVec3; 4]> = (0..19_000).map(points).collect();
    let own = |[a, b, c, x]: [DVec3; 4]| {
        let [a, b, c, x] = [a, b, c, x].map(Point::exact);
        black_box(side(&a, &b, &c, &x));
    };
    let published = |case: [DVec3; 4]| {
        let [a, b, c, x] = case.map(|v| robust::Coord3D { x: v.x, y: v.y, z: v.z });
        black_box(robust::orient3d(a, b, c, x));
    };
    let (mut best_own, mut best_published) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..RUNS {
        best_own = best_own.min(nanoseconds(&cases, own));
        best_published = best_published.min(nanoseconds(&cases, published));
    }
    println!("{name:<27} {best_own:>9.1} {best_published:>8.1} {:>12.2}", best_own / best_published);
}

fn nanoseconds(cases: &[[DVec3; 4]], decide: impl Fn([DVec3; 4])) -> f64 {
    let begun = Instant::now();
    cases.iter().for_each(|&case| decide(case));
    begun.elapsed().as_secs_f64() * 1e9 / cases.len() as f64
}
