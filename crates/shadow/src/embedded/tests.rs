use std::cell::Cell;

use proptest::{prelude::*, test_runner::TestRunner};
use umbriel_geometry::{Mesh, Placement, Point, predicates::side};

use super::*;
use crate::test_bodies::{BOX, bipyramid, box_corners};

/// A ring of `round` sections with `across` corners each.
fn ring(round: u32, across: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let turn = |k: u32, of: u32| std::f64::consts::TAU * f64::from(k) / f64::from(of);
    let positions = (0..round * across).map(|k| {
        let (a, b) = (turn(k / across, round), turn(k % across, across));
        let radius = 2.0 + libm::cos(b);
        [radius * libm::cos(a), libm::sin(b), radius * libm::sin(a)]
    });
    let at = |i: u32, j: u32| (i % round) * across + j % across;
    let squares = (0..round).flat_map(|i| (0..across).map(move |j| (i, j)));
    let triangles = squares.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        [[a, b, c], [a, c, d]]
    });
    (positions.collect(), triangles.collect())
}

fn facets((positions, triangles): (Vec<[f64; 3]>, Vec<[u32; 3]>)) -> Facets {
    Facets::of_mesh(Mesh::new(positions, triangles).expect("a mesh"), &Placement::IDENTITY)
}

fn told(facets: &Facets) -> Option<(Vec<Sign>, bool)> {
    let boxes: Vec<Aabb> = (0..facets.len()).map(|face| facets.facet_bounds(face)).collect();
    let tree = BoxTree::build(&boxes);
    Embedded::of(facets, || &tree).map(|embedded| (embedded.outward, embedded.are_apart))
}

#[test]
fn boxes_and_rings_bound_solids_whichever_way_they_are_turned() {
    let turned = |triangles: &[[u32; 3]]| triangles.iter().map(|&[a, b, c]| [a, c, b]).collect::<Vec<_>>();
    let (positions, triangles) = ring(12, 7);
    for (positions, triangles) in [(box_corners([0.1, 7.3, -0.2], 0.7), BOX.to_vec()), (positions, triangles)] {
        let count = triangles.len();
        let inward = told(&facets((positions.clone(), turned(&triangles))));
        assert_eq!(told(&facets((positions, triangles))), Some((vec![Sign::Positive; count], true)));
        assert_eq!(inward, Some((vec![Sign::Negative; count], false)), "fronts look inward");
    }
}

#[test]
fn components_count_each_for_itself() {
    let two = |low: [f64; 3], second: &[[u32; 3]]| {
        let (mut positions, mut triangles) = (box_corners([0.0; 3], 1.0), BOX.to_vec());
        positions.extend(box_corners(low, 1.0));
        triangles.extend(second.iter().map(|triangle| triangle.map(|corner| corner + 8)));
        told(&facets((positions, triangles)))
    };
    assert_eq!(two([2.0; 3], &BOX), Some((vec![Sign::Positive; 24], true)));
    assert_eq!(two([0.5; 3], &BOX), Some((vec![Sign::Positive; 24], false)), "they meet");
    assert_eq!(two([1.0, 0.25, 0.25], &BOX), Some((vec![Sign::Positive; 24], false)), "they touch");
    let open = two([2.0; 3], &BOX[1..]).expect("one solid");
    assert!(
        open.0[..12].iter().all(|&sign| sign == Sign::Positive) && open.0[12..].iter().all(|&sign| sign == Sign::Zero)
    );
    assert!(!open.1, "one is open");
}

#[test]
fn what_meets_itself_bounds_none() {
    let (mut positions, triangles) = ring(12, 7);
    positions[0] = positions[6 * 7].map(|x| 1.1 * x);
    assert_eq!(told(&facets((positions, triangles))), None, "a corner through the other side");
    assert_eq!(told(&facets(bipyramid(5, 2, 1.0))), None, "wound twice");
    // Two boxes with a corner in common, and with an edge.
    for low in [[1.0; 3], [1.0, 1.0, 0.0]] {
        let (mut positions, mut triangles) = (box_corners([0.0; 3], 1.0), BOX.to_vec());
        positions.extend(box_corners(low, 1.0));
        triangles.extend(BOX.map(|triangle| triangle.map(|corner| corner + 8)));
        assert_eq!(told(&facets((positions, triangles))), None);
    }
}

#[test]
fn too_many_round_one_corner_are_given_up() {
    assert!(told(&facets(bipyramid(100, 1, 1.0))).is_some());
    assert_eq!(told(&facets(bipyramid(1000, 1, 1.0))), None);
}

#[test]
fn sizes_at_both_ends_of_the_range_are_told_alike() {
    for power in [-195, 0, 195] {
        let scale = 2f64.powi(power);
        let (positions, triangles) = ring(12, 7);
        let scaled =
            positions.into_iter().map(|position| position.map(|x| if x.abs() < 1e-9 { 0.0 } else { x * scale }));
        assert!(told(&facets((scaled.collect(), triangles))).is_some(), "2^{power}");
    }
}

/// Whether an edge of one triangle passes through the inside of the other; exact.
fn cross(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    let sign = |p: DVec3, q: DVec3, r: DVec3, x: DVec3| {
        let [p, q, r, x] = [p, q, r, x].map(Point::exact);
        side(&p, &q, &r, &x)
    };
    let passes = |[p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]| {
        let ends = [sign(a, b, c, p), sign(a, b, c, q)];
        let round = [sign(p, q, a, b), sign(p, q, b, c), sign(p, q, c, a)];
        ends[0] != Sign::Zero
            && ends[0] == ends[1].flipped()
            && round[0] != Sign::Zero
            && round.iter().all(|&sign| sign == round[0])
    };
    let edges = |[a, b, c]: [DVec3; 3]| [[a, b], [b, c], [c, a]];
    edges(a).into_iter().any(|edge| passes(edge, b)) || edges(b).into_iter().any(|edge| passes(edge, a))
}

#[test]
fn solids_have_no_triangles_that_cross() {
    let (positions, triangles) = ring(6, 4);
    let strategy =
        (prop::collection::vec(prop::array::uniform3(-1.0..1.0), positions.len()), prop_oneof![0.05..1.0, 0.3..3.0]);
    let config = ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() };
    let (solids, crossed) = (Cell::new(0), Cell::new(0));
    TestRunner::new(config)
        .run(&strategy, |(moves, reach)| {
            let moved =
                positions.iter().zip(&moves).map(|(position, by)| [0, 1, 2].map(|k| position[k] + reach * by[k]));
            let facets = facets((moved.collect(), triangles.clone()));
            let corners = |face: usize| triangles[face].map(|corner| facets.positions()[corner as usize]);
            let pairs = (0..facets.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
            let is_crossed = pairs.into_iter().any(|(a, b)| cross(corners(a), corners(b)));
            let is_solid = told(&facets).is_some();
            prop_assert!(!(is_solid && is_crossed));
            solids.set(solids.get() + usize::from(is_solid));
            crossed.set(crossed.get() + usize::from(is_crossed));
            Ok(())
        })
        .expect("no solid that meets itself");
    let (solids, crossed) = (solids.get(), crossed.get());
    assert!(solids > 50 && crossed > 50, "{solids} solids, {crossed} that meet themselves");
}
