use super::*;

/// The faces of the hull by trying every plane through three points: O(n⁴).
fn brute_force(cloud: &[DVec3]) -> FaceSets {
    let mut planes: FaceSets = BTreeSet::new();
    for i in 0..cloud.len() as u32 {
        for j in 0..cloud.len() as u32 {
            for k in 0..cloud.len() as u32 {
                if crate::brep::seed::are_collinear(cloud[i as usize], cloud[j as usize], cloud[k as usize]) {
                    continue;
                }
                let [a, b, c] = points(cloud, [i, j, k]);
                let sides: Vec<Sign> = cloud.iter().map(|&x| side(&a, &b, &c, &Point::exact(x))).collect();
                if !sides.contains(&Sign::Positive) {
                    let on = cloud.iter().zip(&sides).filter(|(_, side)| **side == Sign::Zero);
                    planes.insert(on.map(|(&x, _)| key(x)).collect());
                }
            }
        }
    }
    // A point inside a face lies in one supporting plane, one inside an edge in two.
    let is_vertex = |x: &[i64; 3]| planes.iter().filter(|plane| plane.contains(x)).count() >= 3;
    planes.iter().map(|plane| plane.iter().copied().filter(is_vertex).collect()).collect()
}

proptest! {
    #[test]
    fn hulls_agree_with_brute_force(cloud in lattice_cloud()) {
        let expected = brute_force(&cloud);
        match Brep::hull(cloud.iter().copied()) {
            Ok(body) => {
                check_structure(&body);
                check_holds(&body, &cloud);
                prop_assert_eq!(face_sets(&body), expected);
            }
            // Flat clouds have at most the two sides of one plane, with no vertex in three planes.
            Err(_) => prop_assert!(expected.iter().all(BTreeSet::is_empty)),
        }
    }

    #[test]
    fn order_and_repetition_do_not_matter(cloud in lattice_cloud(), turn in 0..14_usize) {
        let mut other: Vec<DVec3> = cloud.iter().chain(&cloud).rev().copied().collect();
        let turn = turn.min(other.len());
        other.rotate_left(turn);
        prop_assert_eq!(Brep::hull(cloud), Brep::hull(other));
    }

    #[test]
    fn powers_of_two_do_not_matter(cloud in lattice_cloud(), power in -190..190) {
        let scale = 2.0_f64.powi(power);
        let scaled = Brep::hull(cloud.iter().map(|&x| x * scale));
        let expected = Brep::hull(cloud).map(|mut body| {
            body.vertices.iter_mut().for_each(|vertex| *vertex *= scale);
            body
        });
        prop_assert_eq!(scaled, expected);
    }

    #[test]
    fn rounded_clouds_are_held(seed in proptest::collection::vec(proptest::array::uniform3(-1.0..1.0f64), 4..60)) {
        // On a sphere, and once more almost in the planes of a cube.
        let cloud: Vec<DVec3> = seed.iter().map(|&v| DVec3::from_array(v)).filter(|v| *v != DVec3::ZERO).collect();
        let round: Vec<DVec3> = cloud.iter().map(|v| v.normalize()).collect();
        let cubic: Vec<DVec3> = cloud.iter().map(|v| glam::DQuat::from_rotation_y(0.3) * (*v / v.abs().max_element())).collect();
        for cloud in [cloud, round, cubic] {
            if let Ok(body) = Brep::hull(cloud.iter().copied()) {
                check_structure(&body);
                check_holds(&body, &cloud);
            }
        }
    }
}

#[test]
fn closed_forms() {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let octahedron = axes.iter().flat_map(|&axis| [axis, -axis]);
    assert_eq!(counts(&Brep::hull(octahedron).expect("a body")), (6, 12, 8));
    let cube = Cuboid { size: [1.0, 2.0, 3.0] };
    assert_eq!(counts(&Brep::hull(cube.corners()).expect("a body")), (8, 12, 6));
    // A prism over a polygon of lattice points, all extreme: (i, i²).
    let n = 40;
    let prism = (0..n).flat_map(|i| [0.0, 1.0].map(|y| DVec3::new(f64::from(i), y, f64::from(i * i))));
    assert_eq!(counts(&Brep::hull(prism).expect("a body")), (2 * n as usize, 3 * n as usize, n as usize + 2));
    // A cone over the same polygon; its apex sees all sides.
    let cone = (0..n).map(|i| DVec3::new(f64::from(i), 0.0, f64::from(i * i))).chain([DVec3::new(10.0, 5.0, 700.0)]);
    assert_eq!(counts(&Brep::hull(cone).expect("a body")), (n as usize + 1, 2 * n as usize, n as usize + 1));
}

#[test]
fn the_faces_of_a_tetrahedron_are_canonical() {
    let body = Brep::hull([DVec3::Z, DVec3::Y, DVec3::ZERO, DVec3::X]).expect("a body");
    assert_eq!(body.vertices(), [DVec3::ZERO, DVec3::Z, DVec3::Y, DVec3::X]);
    let faces: Vec<Vec<u32>> = (0..4).map(|face| body.face(face).collect()).collect();
    assert_eq!(faces, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]);
}

#[test]
fn a_grid_is_a_cube() {
    let n = 24;
    let at = |i: i32| DVec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n)) * 0.1;
    let body = Brep::hull((0..n * n * n).map(at)).expect("a body");
    // Multiples of 0.1 are rounded, but equal ones alike: the planes are exact.
    assert_eq!(counts(&body), (8, 12, 6));
    check_structure(&body);
}

#[test]
fn lattice_points_of_a_sphere_are_all_extreme() {
    let reach = -31..=31_i32;
    let all = reach.clone().flat_map(|x| reach.clone().flat_map(move |y| (-31..=31).map(move |z| (x, y, z))));
    let on_sphere = |&(x, y, z): &(i32, i32, i32)| x * x + y * y + z * z == 1001;
    let cloud: Vec<DVec3> =
        all.filter(on_sphere).map(|(x, y, z)| DVec3::new(f64::from(x), f64::from(y), f64::from(z))).collect();
    assert!(cloud.len() > 100);
    let body = Brep::hull(cloud.iter().copied()).expect("a body");
    assert_eq!(body.vertices().len(), cloud.len());
    check_structure(&body);
    check_holds(&body, &cloud);
}

#[test]
fn flat_clouds_say_what_is_missing() {
    let flat = |cloud: &[DVec3]| match Brep::hull(cloud.iter().copied()) {
        Err(HullDefect::Flat(flatness)) => Some(flatness),
        _ => None,
    };
    assert_eq!(flat(&[]), Some(Flatness::Nothing));
    assert_eq!(flat(&[DVec3::X; 5]), Some(Flatness::Point));
    let line: Vec<DVec3> = (0..9).map(|i| DVec3::new(1.0, 2.0, 3.0) * f64::from(i)).collect();
    assert_eq!(flat(&line), Some(Flatness::Line));
    let plane: Vec<DVec3> = (0..9).map(|i| DVec3::new(f64::from(i % 3), f64::from(i / 3), f64::from(i % 3))).collect();
    assert_eq!(flat(&plane), Some(Flatness::Plane));
    let with_apex = || plane.iter().copied().chain([DVec3::new(1.0, 1.0, 1.0_f64.next_up())]);
    assert_eq!(counts(&Brep::hull(with_apex()).expect("one ulp makes a body")), (5, 8, 5));
    let nan = Brep::hull([DVec3::X, DVec3::NAN]);
    assert!(matches!(nan, Err(HullDefect::Coordinate { point: 1, axis: 0, .. })));
}

#[test]
fn many_points() {
    // Points of the unit sphere by stereographic projection from a lattice, rounded.
    let n = 140;
    let at = |i: i32| {
        let (a, b) = (f64::from(i % n) / 35.0 - 2.0, f64::from(i / n) / 35.0 - 2.0);
        DVec3::new(2.0 * a, 2.0 * b, a * a + b * b - 1.0) / (a * a + b * b + 1.0)
    };
    let body = Brep::hull((0..n * n).map(at)).expect("a body");
    assert_eq!(body.vertices().len(), (n * n) as usize);
    check_structure(&body);
}
