use num_rational::Ratio;

use super::*;

fn half_space(normal: [i64; 3], offset: i64) -> HalfSpace {
    HalfSpace { normal: normal.map(|n| n as f64), offset: offset as f64 }
}

fn box_of(half: i64) -> Vec<HalfSpace> {
    (0..6)
        .map(|side| {
            let mut normal = [0; 3];
            normal[side / 2] = if side % 2 == 0 { -1 } else { 1 };
            half_space(normal, half)
        })
        .collect()
}

/// All corners by trying every three planes, over quotients of integers.
fn brute_force(planes: &[([i64; 3], i64)]) -> Vec<[Ratio<i64>; 3]> {
    let dot = |a: [i64; 3], b: [i64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross =
        |a: [i64; 3], b: [i64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let mut corners = Vec::new();
    for i in 0..planes.len() {
        for j in 0..i {
            for k in 0..j {
                let [(a, p), (b, q), (c, r)] = [i, j, k].map(|plane| planes[plane]);
                let w = dot(a, cross(b, c));
                if w == 0 {
                    continue;
                }
                let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
                let x: [Ratio<i64>; 3] = std::array::from_fn(|t| Ratio::new(p * bc[t] + q * ca[t] + r * ab[t], w));
                let inside = |&(n, d): &([i64; 3], i64)| x[0] * n[0] + x[1] * n[1] + x[2] * n[2] <= Ratio::from(d);
                if planes.iter().all(inside) {
                    corners.push(x);
                }
            }
        }
    }
    corners
}

/// Each coordinate rounded once, by a division.
fn rounded(corners: &[[Ratio<i64>; 3]]) -> Vec<DVec3> {
    let round = |t: &Ratio<i64>| *t.numer() as f64 / *t.denom() as f64 + 0.0;
    corners.iter().map(|x| DVec3::from_array([0, 1, 2].map(|axis| round(&x[axis])))).collect()
}

/// Whether exact points lie in one plane. Rounding may lift them out of it.
fn are_flat(corners: &[[Ratio<i64>; 3]]) -> bool {
    let Some(first) = corners.first() else { return true };
    let away: Vec<[Ratio<i64>; 3]> = corners.iter().map(|x| [0, 1, 2].map(|axis| x[axis] - first[axis])).collect();
    let minor = |a: [Ratio<i64>; 3], b: [Ratio<i64>; 3], i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
    away.iter().all(|&a| {
        away.iter().all(|&b| {
            let normal = [minor(a, b, 1, 2), minor(a, b, 2, 0), minor(a, b, 0, 1)];
            away.iter().all(|c| normal[0] * c[0] + normal[1] * c[1] + normal[2] * c[2] == Ratio::from(0))
        })
    })
}

proptest! {
    #[test]
    fn the_planes_of_a_body_give_it_back(cloud in lattice_cloud(), middle in lattice_point(100)) {
        // Away from the origin, so that the origin is not inside.
        let Ok(body) = Brep::hull(cloud.into_iter().map(|x| x + middle)) else { return Ok(()) };
        let half_spaces: Vec<HalfSpace> = (0..body.face_count())
            .map(|face| {
                let [a, b, c] = body.plane(face).map(|corner| corner.position);
                let normal = (b - a).cross(c - a); // exact: small integers
                HalfSpace { normal: normal.to_array(), offset: normal.dot(a) }
            })
            .collect();
        prop_assert_eq!(Brep::of_half_spaces(&half_spaces), Ok(body.clone()));
        // Without one of them it is another body, or none.
        prop_assert_ne!(Brep::of_half_spaces(&half_spaces[1..]), Ok(body));
    }

    #[test]
    fn corners_agree_with_brute_force(
        cuts in proptest::collection::vec((proptest::array::uniform3(-3..=3_i64), -6..12_i64), 0..12), half in 1..5_i64,
    ) {
        let mut planes: Vec<([i64; 3], i64)> = cuts.into_iter().filter(|cut| cut.0 != [0; 3]).collect();
        planes.extend((0..6).map(|side| {
            let mut normal = [0; 3];
            normal[side / 2] = if side % 2 == 0 { -1 } else { 1 };
            (normal, half)
        }));
        let given: Vec<HalfSpace> = planes.iter().map(|&(normal, offset)| half_space(normal, offset)).collect();
        let corners = brute_force(&planes);
        match Brep::of_half_spaces(&given) {
            Ok(body) => {
                prop_assert!(!are_flat(&corners));
                prop_assert_eq!(Ok(body), Brep::hull(rounded(&corners)));
            }
            Err(HalfSpaceDefect::Empty { .. }) => prop_assert!(are_flat(&corners)),
            Err(defect) => prop_assert!(false, "{}", defect),
        }
    }
}

#[test]
fn closed_forms() {
    let cube = Brep::of_half_spaces(&box_of(3)).expect("a cube");
    assert_eq!(cube, Brep::hull(Cuboid { size: [6.0; 3] }.corners()).expect("a cube"));
    let signs = [-1, 1];
    let octants = signs.iter().flat_map(|&x| signs.iter().flat_map(move |&y| signs.map(|z| [x, y, z])));
    let octahedron: Vec<HalfSpace> = octants.map(|normal| half_space(normal, 2)).collect();
    assert_eq!(counts(&Brep::of_half_spaces(&octahedron).expect("a body")), (6, 12, 8));
    // Twelve pentagons with corners such as (2, 2, 2) and (3, 3/2, 0), all floats.
    let pentagons: Vec<HalfSpace> = (0..3)
        .flat_map(|axis| signs.map(|s| (axis, s)))
        .flat_map(|(axis, s)| signs.map(|t| (axis, s, t)))
        .map(|(axis, s, t)| {
            let mut normal = [0; 3];
            (normal[axis], normal[(axis + 1) % 3]) = (s, 2 * t);
            half_space(normal, 6)
        })
        .collect();
    let body = Brep::of_half_spaces(&pentagons).expect("a body");
    assert_eq!(counts(&body), (20, 30, 12));
    check_structure(&body);
}

#[test]
fn what_has_no_body_is_named() {
    let body = |half_spaces: &[HalfSpace]| Brep::of_half_spaces(half_spaces).expect_err("no body");
    assert_eq!(body(&[]), HalfSpaceDefect::Unbounded { toward: "-x" });
    assert_eq!(body(&box_of(1)[..5]), HalfSpaceDefect::Unbounded { toward: "+z" });
    let mut touching = box_of(1);
    touching.push(half_space([1, 1, 1], -3));
    assert_eq!(body(&touching), HalfSpaceDefect::Empty { half_space: 6 }, "one point is left");
    touching[6] = half_space([0, 0, 0], 1);
    assert_eq!(body(&touching), HalfSpaceDefect::NoDirection { half_space: 6 });
    touching[6].offset = f64::NAN;
    assert!(matches!(body(&touching), HalfSpaceDefect::Number { half_space: 6, index: 3, .. }));
    touching[6] = HalfSpace { normal: [2.0, 2.0_f64.powi(-200), 0.0], offset: 0.0 };
    assert!(matches!(body(&touching), HalfSpaceDefect::Corner { axis: 0, .. }), "a corner at x = 2^-201, y = -1");
    // Thinner than half an ulp of its distance.
    let thin = [([1.0, 0.0, 0.0], 1.0), ([-1.0, 0.0, 0.0], -1.0), ([0.0, 1.0, 0.0], 1.0), ([0.0, -1.0, 0.0], 1.0)];
    let mut thin: Vec<HalfSpace> = thin.iter().map(|&(normal, offset)| HalfSpace { normal, offset }).collect();
    thin[0] = HalfSpace { normal: [2.0_f64.powi(100), 2.0_f64.powi(40), 0.0], offset: 2.0_f64.powi(100) };
    thin.extend([half_space([0, 0, 1], 1), half_space([0, 0, -1], 1)]);
    assert_eq!(body(&thin), HalfSpaceDefect::Thin(HullDefect::Flat(Flatness::Plane)));
}

#[test]
fn extreme_sizes_are_decided() {
    // A needle that ends at x = 2^150: bounded, although its sides are almost parallel.
    let slope = 2.0_f64.powi(-150);
    let needle = [[slope, 1.0, 0.0], [slope, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]];
    let needle = needle.map(|normal| HalfSpace { normal, offset: 1.0 });
    let body = Brep::of_half_spaces(&needle).expect("a needle");
    assert_eq!(body.bounds().max.x, 2.0_f64.powi(150));
    let mut open = needle;
    (open[0].normal[0], open[1].normal[0]) = (0.0, 0.0);
    assert_eq!(Brep::of_half_spaces(&open), Err(HalfSpaceDefect::Unbounded { toward: "+x" }));
}
