use std::collections::HashSet;

use super::*;
use proptest::prelude::*;

fn area(corners: &[DVec3], triangles: &[[usize; 3]]) -> DVec3 {
    triangles.iter().map(|t| (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]) * 0.5).sum()
}

fn triangulate(corners: &[DVec3]) -> Triangulation {
    Triangulator::default().cut(corners)
}

/// n − 2 triangles, all turned as the polygon, together as large as it.
fn check(corners: &[DVec3]) {
    let Triangulation { triangles, crosses } = triangulate(corners);
    assert_eq!((triangles.len(), crosses), (corners.len() - 2, false));
    let whole = newell_normal(corners) * 0.5;
    let sum = area(corners, &triangles);
    assert!((sum - whole).length() <= 1e-12 * whole.length(), "{sum} {whole}");
    let absolute: f64 = triangles.iter().map(|&t| area(corners, &[t]).length()).sum();
    assert!((absolute - whole.length()).abs() <= 1e-12 * whole.length(), "a triangle overlaps another one");
    for &triangle in &triangles {
        assert!(area(corners, &[triangle]).dot(whole) >= 0.0, "a triangle is turned over");
    }
}

fn flat(points: &[[f64; 2]]) -> Vec<DVec3> {
    points.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect()
}

#[test]
fn an_arrow_head_has_no_triangle_outside() {
    let arrow = flat(&[[0.0, 0.0], [2.0, -1.0], [0.0, 3.0], [-2.0, -1.0]]);
    for first in 0..4 {
        let mut corners = arrow.clone();
        corners.rotate_left(first);
        check(&corners);
        corners.reverse();
        check(&corners);
    }
}

#[test]
fn corners_in_straight_sides_are_kept() {
    let square = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0], [0.0, 1.0]];
    check(&flat(&square));
    let triangles = triangulate(&flat(&square)).triangles;
    assert!(triangles.iter().all(|&t| area(&flat(&square), &[t]).length() > 0.0), "{triangles:?}");
    for corner in 0..8 {
        assert!(triangles.iter().any(|t| t.contains(&corner)));
    }
}

#[test]
fn a_corner_an_ulp_off_a_straight_side_is_turned_exactly() {
    // The side runs between these two floats; their cross products are some 2^-55.
    let (a, b) = ([0.1, 0.3], [0.7, 2.1]);
    let beside = 0.4f64.next_down();
    for (x, turn) in [(beside.next_down(), 1.0), (beside, -1.0)] {
        let [from, to, middle] = [a, b, [x, 1.2]].map(|[x, y]| Coord { x, y });
        assert_eq!(orient2d(from, to, middle).signum(), turn);
        check(&flat(&[a, [2.0, 0.5], b, [x, 1.2]]));
    }
}

#[test]
fn a_hole_joined_to_its_border_stays_open() {
    let ring = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 4.0],
        [0.0, 4.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [3.0, 3.0],
        [3.0, 1.0],
        [1.0, 1.0],
    ];
    check(&flat(&ring));
}

#[test]
fn a_crossing_or_flat_polygon_still_gives_its_triangles() {
    let cut = |corners: &[[f64; 2]]| {
        let cut = triangulate(&flat(corners));
        (cut.triangles.len(), cut.crosses)
    };
    assert_eq!(cut(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]]), (2, true), "a bow tie");
    assert_eq!(cut(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]), (2, true), "one of no area");
    assert_eq!(cut(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]), (2, false), "a needle");
    let doubled = flat(&[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    check(&doubled);
    assert!(triangulate(&[]).triangles.is_empty());
}

#[test]
fn a_polygon_that_runs_through_few_places_is_given_up() {
    // Each of some 10^4 searches would meet all corners.
    let places: [[f64; 2]; 10] = std::array::from_fn(|i| [(i * 7 % 10) as f64, (i * i * 3 % 11) as f64]);
    for (count, crosses_itself) in [(4, false), (10, true)] {
        let ring: Vec<_> = (0..26_000).map(|i| places[(i * i + i / 3) % count]).collect();
        let Triangulation { triangles, crosses } = Triangulator { work_left: 0 }.cut(&flat(&ring));
        assert_eq!((triangles.len(), crosses), (ring.len() - 2, crosses_itself));
    }
}

#[test]
fn an_account_that_is_used_up_ends_the_searches() {
    let square = flat(&[[0.0, 0.0], [1.0, 0.0], [0.2, 0.2], [0.0, 1.0]]);
    let mut account = Triangulator { work_left: 0 };
    assert!(!account.cut(&square).crosses, "corners bring an account with them");
    let mut work_left = 0;
    let given_up = EarClipping::new(project(&square), &mut work_left).run();
    assert_eq!((given_up.triangles.len(), given_up.crosses), (2, true));
}

#[test]
fn many_corners_are_quick() {
    let star: Vec<_> = (0..20_000)
        .map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / 20_000.0;
            let radius = if i % 2 == 0 { 1.0 } else { 0.5 };
            DVec3::new(radius * angle.cos(), 0.0, radius * angle.sin())
        })
        .collect();
    check(&star);
}

#[test]
fn a_round_polygon_does_not_become_a_fan() {
    let n = 1024;
    let angle = |i: i32| f64::from(i) * std::f64::consts::TAU / f64::from(n);
    let corners: Vec<_> = (0..n).map(|i| DVec3::new(angle(i).cos(), angle(i).sin(), 0.0)).collect();
    check(&corners);
    let mut uses = vec![0; corners.len()];
    triangulate(&corners).triangles.iter().flatten().for_each(|&corner| uses[corner] += 1);
    // Rounds halve the polygon: a corner has two triangles of each of ten rounds at most.
    assert!(uses.iter().all(|&uses| uses <= 20), "{:?}", uses.iter().max());
}

#[test]
fn planar_means_as_written_decimals_say() {
    let mut corners = flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert!(is_planar(&corners));
    corners[2].z = 1e-6;
    assert!(is_planar(&corners));
    corners[2].z = 1e-2;
    assert!(!is_planar(&corners));
}

/// All triangles turned as the polygon, together as large as it: none lies on another one or outside.
fn check_touching(outline: &[[f64; 2]], area_of_it: f64) {
    let mut corners = flat(outline);
    for step in 0..2 * corners.len() {
        corners.rotate_left(1);
        if step == outline.len() {
            corners.reverse();
        }
        let Triangulation { triangles, crosses } = triangulate(&corners);
        let absolute: f64 = triangles.iter().map(|&t| area(&corners, &[t]).length()).sum();
        let signed = area(&corners, &triangles).length();
        assert_eq!((absolute, signed, crosses), (area_of_it, area_of_it, false), "{corners:?}");
    }
}

#[test]
fn equal_corners_in_a_row_enclose_nothing() {
    let bent = [[0.0, 0.0], [0.0, 3.0], [2.0, 3.0], [2.0, 3.0], [2.0, 1.0], [4.0, 1.0], [4.0, 1.0], [4.0, 0.0]];
    check_touching(&bent, 8.0);
    let thrice = [[0.0, 0.0], [0.0, 0.0], [-0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [3.0, 2.0], [0.0, 2.0], [0.0, 0.0]];
    check_touching(&thrice, 6.0);
    check_touching(&[[1.0, 1.0]; 7], 0.0);
}

#[test]
fn an_outline_may_touch_itself() {
    let squares = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [4.0, 2.0], [4.0, 4.0], [2.0, 4.0], [2.0, 2.0], [0.0, 2.0]];
    check_touching(&squares, 8.0);
    let lenses = [[0.0, 0.0], [2.0, 2.0], [4.0, 0.0], [2.0, -2.0], [0.0, 0.0], [2.0, -1.0], [4.0, 0.0], [2.0, 1.0]];
    check_touching(&lenses, 4.0);
    let hole_at_a_corner = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0], [1.0, 2.0], [2.0, 1.0]];
    check_touching(&hole_at_a_corner, 14.5);
    check_touching(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 0.0], [0.0, 4.0]], 8.0);
}

#[test]
fn lines_to_and_fro_enclose_nothing() {
    let slits_that_meet = [
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 2.0],
        [2.0, 0.0],
        [4.0, 0.0],
        [4.0, 2.0],
        [2.0, 2.0],
        [4.0, 2.0],
        [4.0, 4.0],
        [0.0, 4.0],
    ];
    check_touching(&slits_that_meet, 16.0);
    let spikes = [[0.0, 0.0], [2.0, 0.0], [5.0, 0.0], [2.0, 0.0], [2.0, 2.0], [3.0, 3.0], [2.0, 2.0], [0.0, 2.0]];
    check_touching(&spikes, 4.0);
    let bodies_on_a_bent_line = [
        [0.0, 0.0],
        [2.0, 0.0],
        [4.0, 0.0],
        [4.0, 2.0],
        [5.0, 3.0],
        [3.0, 3.0],
        [4.0, 2.0],
        [4.0, 0.0],
        [2.0, 0.0],
        [1.0, 1.0],
    ];
    check_touching(&bodies_on_a_bent_line, 2.0);
}

/// A ring round cells of a lattice, which touches itself and leaves slits; `choices` say how it grows. How many cells it encloses.
fn grown_outline(choices: &[(usize, u8)]) -> (Vec<[i32; 2]>, usize) {
    let mut cells = HashSet::from([[0, 0]]);
    let mut ring = vec![[0, 0], [1, 0], [1, 1], [0, 1]];
    for &(place, kind) in choices {
        let place = place % ring.len();
        let ([x, y], [to_x, to_y]) = (ring[place], ring[(place + 1) % ring.len()]);
        let (dx, dy) = (to_x - x, to_y - y);
        match kind {
            0 => ring.insert(place, [x, y]),
            1..4 => {
                // A cell that touches the ring in a corner.
                let cell = [x - i32::from(kind == 1), y - i32::from(kind != 2)];
                // Elsewhere the ring may come by: its edges would cross.
                let is_alone = ring.iter().filter(|&&corner| corner == [x, y]).count() == 1;
                if is_alone && cells.insert(cell) {
                    let mut round = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[right, up]| [cell[0] + right, cell[1] + up]);
                    let first = round.iter().position(|&corner| corner == [x, y]).unwrap();
                    round.rotate_left((first + 1) % 4);
                    ring.splice(place + 1..place + 1, round);
                }
            }
            _ if [dx, dy] == [0, 0] => {}
            _ => {
                // A cell on the other side of an edge; (x + dy, y − dx) is one step to the right.
                let cell = [x.min(to_x).min(x + dy).min(to_x + dy), y.min(to_y).min(y - dx).min(to_y - dx)];
                if cells.insert(cell) {
                    ring.splice(place + 1..place + 1, [[x + dy, y - dx], [to_x + dy, to_y - dx]]);
                }
            }
        }
    }
    (ring, cells.len())
}

proptest! {
    /// Rectilinear outlines that touch themselves in corners and edges, with corners doubled, sheared.
    #[test]
    fn outlines_that_touch_themselves_are_cut_exactly(
        choices in proptest::collection::vec((0..1000usize, 0..20u8), 0..40), shear in -2..3i32,
    ) {
        let (ring, count) = grown_outline(&choices);
        let sheared: Vec<_> = ring.iter().map(|&[x, y]| [f64::from(x + shear * y), f64::from(y)]).collect();
        check_touching(&sheared, count as f64);
    }

    /// Star-shaped polygons in any plane, far from the origin or not.
    #[test]
    fn star_shaped_polygons_are_cut_exactly(
        radii in proptest::collection::vec(0.1..10.0f64, 3..40), tilt in -3.0..3.0f64, turn in -3.0..3.0f64,
    ) {
        let n = radii.len() as f64;
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, tilt, turn, 0.0);
        let corners: Vec<_> = radii.iter().enumerate().map(|(i, radius)| {
            let angle = i as f64 * std::f64::consts::TAU / n;
            turn * DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
        }).collect();
        check(&corners);
    }
}
