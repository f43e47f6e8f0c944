use glam::{DAffine3, DQuat};

use super::*;
use crate::{Facets, LightSource, Placement};

fn placement(map: DAffine3) -> Placement {
    Placement::new(map).expect("regular")
}

fn octahedron() -> Convex {
    let mut points = vec![[0.0; 3]; 7];
    for (i, point) in points.iter_mut().take(6).enumerate() {
        point[i / 2] = if i % 2 == 0 { 1.0 } else { -1.0 };
    }
    Convex::new(points).expect("a body around its seventh point")
}

/// Six times the volume behind the triangles, in floats.
fn sixfold_volume(facets: &Facets) -> f64 {
    facets
        .iter()
        .map(|facet| {
            let [a, b, c] = [0, 1, 2].map(|i| facets.positions()[facet.corners()[i] as usize]);
            a.dot(b.cross(c))
        })
        .sum()
}

#[test]
fn facets_look_outward_under_any_placement() {
    let turn = DQuat::from_xyzw(0.1, 0.7, 0.2, 0.3).normalize();
    for scale in [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0), DVec3::new(-2.0, -3.0, -0.5)] {
        for rotation in [DQuat::IDENTITY, turn] {
            let map = DAffine3::from_scale_rotation_translation(scale, rotation, DVec3::new(3.0, -1.0, 0.25));
            let facets = Facets::of_convex(&octahedron(), &placement(map)).expect("a body");
            assert_eq!((facets.len(), facets.positions().len()), (8, 6));
            assert_eq!(facets.is_mirrored(), scale.x * scale.y * scale.z < 0.0);
            assert!((0..8).all(|facet| facets.is_closed(facet)));
            assert_eq!(facets.topology().components.len(), 1);
            let volume = 8.0 * (scale.x * scale.y * scale.z).abs();
            let outward = if facets.is_mirrored() { -1.0 } else { 1.0 };
            assert!((sixfold_volume(&facets) / volume - outward).abs() < 1e-12);
            let above = LightSource::point([3.0, 50.0, 0.25]).expect("a lamp");
            let below = LightSource::point([3.0, -50.0, 0.25]).expect("a lamp");
            let lit = |light| (0..8).filter(|&f| facets.light_side(f, light) == Sign::Positive).count();
            assert_eq!(lit(&above) + lit(&below), 8, "each facet looks up or down");
        }
    }
}

#[test]
fn faces_are_fans_in_the_order_of_the_points() {
    let mut points: Vec<[f64; 3]> = Cuboid { size: [2.0; 3] }.corners().iter().map(|c| c.to_array()).collect();
    let facets = |points: &[[f64; 3]], map: DAffine3| {
        Facets::of_convex(&Convex::new(points.to_vec()).expect("a cube"), &placement(map)).expect("a cube")
    };
    let plain = facets(&points, DAffine3::IDENTITY);
    assert!(plain.positions().iter().map(|p| p.to_array()).eq(points.iter().copied()));
    assert_eq!(plain.len(), 12);
    for pair in 0..6 {
        let [first, second] = [2 * pair, 2 * pair + 1].map(|facet| plain.facet(facet).corners());
        assert_eq!((first[0], first[2]), (second[0], second[1]), "a fan from the first corner");
    }
    // Where it lies, turned round or mirrored, and what lies inside of it changes no number.
    points.extend([points[3], [0.0; 3]]);
    let axes = DAffine3::from_cols_array(&[0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 3.0, 1.0, -2.0]);
    for map in [axes, DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0)), DAffine3::from_translation(DVec3::splat(0.5))] {
        let moved = facets(&points, map);
        let turned = map.matrix3.determinant() < 0.0;
        assert_eq!(moved.is_mirrored(), turned);
        assert!(moved.iter().eq(plain.iter()), "{map:?}");
    }
}

#[test]
fn placing_may_flatten_or_leave_the_range() {
    let body = octahedron();
    let thin = DAffine3::from_scale(DVec3::new(1.0, 2.0_f64.powi(-60), 1.0));
    assert!(Facets::of_convex(&body, &placement(thin)).is_ok());
    let mut far = thin;
    far.translation.y = 1.0;
    let flat = Facets::of_convex(&body, &placement(far)).expect_err("rounded to a plane");
    assert_eq!(flat, HullDefect::Flat(Flatness::Plane));
    let points = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 2.0_f64.powi(150)]];
    let tall = Convex::new(points).expect("accepted as given");
    let huge = Facets::of_convex(&tall, &placement(DAffine3::from_scale(DVec3::splat(2.0_f64.powi(60)))));
    assert!(matches!(huge, Err(HullDefect::Coordinate { point: 3, axis: 2, .. })));
}
