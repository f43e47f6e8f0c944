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
    for count in [4, 10] {
        let ring: Vec<_> = (0..26_000).map(|i| places[(i * i + i / 3) % count]).collect();
        let Triangulation { triangles, crosses } = Triangulator { work_left: 0 }.cut(&flat(&ring));
        assert_eq!((triangles.len(), crosses), (ring.len() - 2, true));
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

proptest! {
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
