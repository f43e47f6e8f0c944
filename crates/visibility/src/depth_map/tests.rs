use std::f64::consts::FRAC_PI_4;

use glam::{DAffine3, DVec2, DVec3};
use umbriel_geometry::{Analytic, Facets, Placement, Rectangle};
use umbriel_scene::{Object, Scene, Shape, Sides};

use super::*;

fn plate(edge: f64, height: f64) -> Facets {
    let placement = Placement::new(DAffine3::from_translation(DVec3::Y * height)).expect("regular");
    Facets::of_rectangle(&Rectangle { size: [edge; 2] }, &placement)
}

fn corners_of(facets: &[Facets]) -> Vec<DVec3> {
    facets.iter().flat_map(|facets| facets.positions().to_vec()).collect()
}

#[test]
fn the_map_holds_the_depths_of_what_is_nearest() {
    let faces = [plate(20.0, 0.0), plate(4.0, 5.0)];
    let space = LightSpace::round(DVec3::Y * 10.0, DVec3::NEG_Y, corners_of(&faces), 512);
    let map = DepthMap::new(space, &faces, &CurvedBodies::default());
    for (point, depth) in [(DVec3::ZERO, 5.0), (DVec3::new(3.5, 0.0, 3.5), 5.0), (DVec3::new(4.5, 0.0, 0.0), 10.0)] {
        let place = map.space.to_texels(map.space.to_light(point));
        let found = map.row(place.y as usize)[place.x as usize];
        assert!((f64::from(found) - depth).abs() < 1e-5, "{point}: {found}");
    }
    assert!((map.nearest() - 5.0).abs() < 1e-5);
}

#[test]
fn a_tilted_face_has_its_depths_at_the_texels_middles() {
    let placement = Placement::new(DAffine3::from_rotation_x(FRAC_PI_4)).expect("regular");
    let faces = [Facets::of_rectangle(&Rectangle { size: [4.0; 2] }, &placement)];
    let space = LightSpace::round(DVec3::Y * 10.0, DVec3::NEG_Y, corners_of(&faces), 64);
    let map = DepthMap::new(space, &faces, &CurvedBodies::default());
    let [a, b, _, d] = [0, 1, 2, 3].map(|k| space.to_light(faces[0].positions()[k]));
    let normal = (b - a).cross(d - a);
    let mut checked = 0;
    for (row, column) in (0..64).flat_map(|row| (0..64).map(move |column| (row, column))) {
        let depth = f64::from(map.row(row)[column]);
        if depth.is_finite() {
            // The ray through the texel's middle meets the plane.
            let probe = (0..2).map(|k| k as f64);
            let slopes: Vec<DVec2> = probe.map(|z| space.to_texels(DVec3::new(z, z, 1.0))).collect();
            let slope = (DVec2::new(column as f64 + 0.5, row as f64 + 0.5) - slopes[0]) / (slopes[1] - slopes[0]);
            let expected = normal.dot(a) / normal.dot(slope.extend(1.0));
            assert!((depth - expected).abs() < 1e-5 * expected, "{row} {column}: {depth} {expected}");
            checked += 1;
        }
    }
    assert!(checked > 1000, "{checked}");
}

#[test]
fn curved_bodies_are_in_the_map() {
    let ball = Shape::from(Analytic::Sphere { radius: 1.0 });
    let placement = Placement::new(DAffine3::from_translation(DVec3::Y * 4.0)).expect("regular");
    let ball = Object::new("ball".into(), ball, placement, Sides::Auto).expect("a body");
    let scene = Scene { objects: [ball].into(), ..Scene::default() };
    let faces = [plate(8.0, 0.0)];
    let lamp = LightSpace::round(DVec3::Y * 10.0, DVec3::NEG_Y, corners_of(&faces), 256);
    let sun = LightSpace::parallel(DVec3::NEG_Y, corners_of(&faces), 256);
    for space in [lamp, sun] {
        let map = DepthMap::new(space, &faces, &CurvedBodies::new(&scene));
        for (row, column) in [(128, 128), (128, 140), (110, 128), (3, 200)] {
            let (origin, direction) = space.ray(column, row);
            // Along the ray to the ball's surface, or to the floor.
            let (to, length) = (DVec3::Y * 4.0 - origin, direction.length());
            let nearest = to.dot(direction) / length;
            let rest = 1.0 - (to.length_squared() - nearest * nearest);
            let at_floor = -origin.y / direction.y;
            let expected = if rest > 0.0 { (nearest - rest.sqrt()) / length } else { at_floor };
            let found = f64::from(map.row(row)[column]);
            assert!((found - expected).abs() < 1e-5 * expected.abs().max(1.0), "{row} {column}: {found} {expected}");
        }
    }
}

/// A lamp inside a box of six walls: each side of its cube sees one wall, at its distance.
#[test]
fn six_squares_see_all_round_a_lamp() {
    let wall = |forward: DVec3, distance: f64| {
        let (right, up) = forward.any_orthonormal_pair();
        let at = |x: f64, y: f64| forward * distance + (right * x + up * y) * distance;
        [[at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0)], [at(-1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]]
    };
    let sides = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let walls: Vec<[DVec3; 3]> = (1..).zip(sides).flat_map(|(k, side)| wall(side, f64::from(k))).collect();
    for (k, side) in (1..).zip(sides) {
        let space = LightSpace::square(DVec3::ZERO, side, walls.iter().flatten().copied(), 33);
        let map = DepthMap::of_triangles(space, walls.par_iter().copied(), &CurvedBodies::default());
        let depths = (0..33).flat_map(|row| map.row(row).to_vec());
        depths.for_each(|depth| assert!((depth - k as f32).abs() < 1e-5 * k as f32, "{k}: {depth}"));
    }
}

#[test]
fn threads_and_bands_draw_the_same_map() {
    // Many small triangles in all directions, some through the lamp's plane.
    let random = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24) - 0.5;
    let point = |k: u32| DVec3::new(random(3 * k), random(3 * k + 1), random(3 * k + 2));
    let triangles: Vec<[DVec3; 3]> = (0..400)
        .map(|k| {
            let middle = 8.0 * point(k);
            [0, 1, 2].map(|corner| middle + 5.0 * point(1_000 + 3 * k + corner))
        })
        .collect();
    let space = LightSpace::square(DVec3::ZERO, DVec3::X, triangles.iter().flatten().copied(), 100);
    let draw = || DepthMap::of_triangles(space, triangles.par_iter().copied(), &CurvedBodies::default());
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let [one, three] = [1, 3].map(|threads| pool(threads).install(draw));
    let mut covered = 0;
    for row in 0..100 {
        assert_eq!(one.row(row), three.row(row));
        for (column, &depth) in one.row(row).iter().enumerate() {
            // The ray through the texel's middle against all triangles, by signs of volumes.
            let (_, direction) = space.ray(column, row);
            let hits = triangles.iter().filter_map(|[a, b, c]| {
                let sides = [a.cross(*b), b.cross(*c), c.cross(*a)].map(|normal| normal.dot(direction));
                let is_inside = sides.iter().all(|&side| side > 0.0) || sides.iter().all(|&side| side < 0.0);
                let normal = (b - a).cross(c - a);
                let distance = normal.dot(*a) / normal.dot(direction);
                (is_inside && distance > 0.0).then_some(distance)
            });
            let nearest = hits.fold(f64::INFINITY, f64::min);
            if nearest.is_finite() {
                assert!((f64::from(depth) - nearest).abs() < 1e-4 * nearest, "{row} {column}: {depth} {nearest}");
                covered += 1;
            } else {
                assert_eq!(depth, f32::INFINITY, "{row} {column}");
            }
        }
    }
    assert!(covered > 1000, "{covered}");
}
