//! The linear octree against a plain octree with pointers: times and their ratio, the best of several runs in turn.
//!
//! `cargo bench -p umbriel-octree`. The pointer octree casts rays in plain floats, which may miss leaves at borders; the
//! linear one is exact. Both build over the same exact region; the pointer octree asks it about every cell off the surface.

#[path = "../tests/bodies/mod.rs"]
#[allow(dead_code, reason = "tests use the rest")]
mod bodies;
#[path = "../tests/pointer/mod.rs"]
#[allow(dead_code, reason = "tests use the rest")]
mod pointer;

use std::{
    hint::black_box,
    time::{Duration, Instant},
};

use glam::DVec3;
use umbriel_geometry::{Region, Relation};
use umbriel_octree::{Cube, Octant, Ray, SolidOctree};

use bodies::torus;
use pointer::Node;

const RUNS: usize = 5;

fn timed(work: impl FnOnce()) -> Duration {
    let begun = Instant::now();
    work();
    begun.elapsed()
}

/// The best of several runs of each, in turn.
fn compare(name: &str, mut linear: impl FnMut(), mut pointers: impl FnMut()) {
    let times: Vec<_> = (0..RUNS).map(|_| (timed(&mut linear), timed(&mut pointers))).collect();
    let best = |pick: fn(&(Duration, Duration)) -> Duration| times.iter().map(pick).min().unwrap_or_default();
    let (linear, pointers) = (best(|pair| pair.0), best(|pair| pair.1));
    let ratio = linear.as_secs_f64() / pointers.as_secs_f64();
    report(&format!("{name:<16} linear {linear:>10.2?}  pointers {pointers:>10.2?}  linear/pointers {ratio:.2}"));
}

#[expect(clippy::print_stdout, reason = "a benchmark shows its figures")]
fn report(line: &str) {
    println!("{line}");
}

/// Points of the cube in a fixed pattern of low discrepancy (Roberts' R3 sequence).
fn points(cube: &Cube, count: u32) -> Vec<DVec3> {
    let steps = DVec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2);
    (1..=count).map(|n| cube.min() + (steps * f64::from(n)).fract() * cube.edge()).collect()
}

fn compare_builds(region: &dyn Region, cube: Cube, depth: u8) {
    compare(
        "build, depth 7",
        || {
            let _ = black_box(SolidOctree::build_in(cube, region, depth));
        },
        || {
            black_box(Node::of(region, &cube, depth));
        },
    );
}

/// A solid and its complement.
fn compare_unions(tree: &SolidOctree, rival: &Node) {
    let other = tree.complement();
    let other_rival = rival.combined(rival, |own, _| match own {
        Relation::Inside => Relation::Outside,
        Relation::Outside => Relation::Inside,
        Relation::Boundary => own,
    });
    compare(
        "union",
        || {
            let _ = black_box(tree.union(&other));
        },
        || {
            black_box(rival.combined(&other_rival, Ord::max));
        },
    );
}

fn main() {
    let (region, depth) = (torus(64), 7);
    let cube = Cube::on_grid(&region.bounds(), depth).expect("a torus has an extent");
    let whole = cube.bounds_of(Octant::ROOT);
    compare_builds(&region, cube, depth);
    let tree = SolidOctree::build_in(cube, &region, depth).expect("on the grid");
    let rival = Node::of(&region, &cube, depth);
    let points = points(&cube, 100_000);
    compare(
        "point location",
        || {
            black_box(points.iter().filter(|&&at| tree.relation_at(at) == Some(Relation::Inside)).count());
        },
        || {
            black_box(points.iter().filter(|&&at| rival.at(whole, at) == Relation::Inside).count());
        },
    );
    let pairs = || points.windows(2).step_by(10).map(|pair| (pair[0], pair[1] - pair[0]));
    compare(
        "10,000 rays",
        || {
            black_box(
                pairs()
                    .map(|(from, along)| tree.cast(&Ray::new(from, along).expect("in range")).count())
                    .sum::<usize>(),
            );
        },
        || {
            black_box(pairs().map(|(from, along)| rival.cast(whole, from, along.recip())).sum::<usize>());
        },
    );
    compare_unions(&tree, &rival);
    let (cells, bytes) =
        (tree.relations().len(), tree.relations().len() * (size_of::<Octant>() + size_of::<Relation>()));
    report(&format!("{} triangles, {cells} leaves, {bytes} bytes of leaves", region.parts()));
    let large = torus(224);
    report(&format!(
        "{} triangles, depth 8: {:.2?}",
        large.parts(),
        timed(|| {
            let _ = black_box(SolidOctree::build(&large, 8));
        })
    ));
}
