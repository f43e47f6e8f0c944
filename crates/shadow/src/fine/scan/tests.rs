//! Every sample against the exact answer to its point.

use std::{collections::HashMap, sync::Arc};

use glam::{DAffine3, DQuat, DVec3};
use proptest::{
    prelude::*,
    test_runner::{Config, TestRunner},
};
use umbriel_geometry::{Analytic, Cuboid, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};

use crate::{
    Detail, Request, Sampling, Silent, bake,
    bodies::{Bodies, Body},
    exact::{Own, face_blocks, flat_face_is_turned_to},
    fine::flat::flat_probe,
    receivers::flat_corners,
    sample_points::for_each_on_flat,
    spacing::spacing,
};

/// Samples lit of the samples asked, each compared.
fn check(objects: Vec<Object>, light: LightSource, samples: u64) -> (u64, u64) {
    let lights = vec![Light::new("light", light)];
    let scene = Scene { objects: objects.into(), lights, ..Scene::default() };
    let sampling = Some(Sampling::Count(samples));
    let request = Request { sampling, keep_cells: true, ..Request::everything(&scene, Detail::Faces) };
    let report = bake(&scene, &request, &Silent).expect("nobody cancels");
    let bodies = Bodies::new(&scene);
    let spacing = spacing(&bodies, &request).expect("samples are asked for");
    let mut next = vec![0; scene.objects.len()];
    let (mut lit, mut all) = (0, 0);
    for (number, object) in report.lights[0].objects.iter().enumerate() {
        let Body::Flat(facets) = bodies.get(number) else { continue };
        for_each_on_flat(facets, spacing, |face, corner, point| {
            let ours = object.answers.as_ref().expect("answers are kept").is_lit(next[number]);
            let truth = is_lit_by_definition(&bodies, (number, face), corner, point, &light);
            assert_eq!(ours, truth, "object {number}, face {face}, {point:?} from corner {corner}, {light:?}");
            next[number] += 1;
            lit += u64::from(ours);
            all += 1;
        });
    }
    let flat = |number: usize| !bodies.is_analytic(number);
    let mut counted_lit = 0;
    for (number, (object, &samples)) in report.lights[0].objects.iter().zip(&next).enumerate() {
        if !flat(number) {
            continue;
        }
        let counted = object.samples.expect("samples were asked for");
        assert_eq!((counted.samples, object.answers.as_ref().map(|answers| answers.len())), (samples, Some(samples)));
        counted_lit += counted.lit;
    }
    assert_eq!(counted_lit, lit);
    (lit, all)
}

/// Whether a point of a flat face, counted from one of its corners, is lit: each face is asked, exactly.
fn is_lit_by_definition(
    bodies: &Bodies,
    (object, face): (usize, usize),
    corner: u8,
    [u, v]: [f64; 2],
    light: &LightSource,
) -> bool {
    let Body::Flat(facets) = bodies.get(object) else { panic!("samples are of flat faces") };
    let corners = flat_corners(facets, face, corner);
    let probe = flat_probe(&corners, u, v);
    let own = Own::Face { object, face };
    let blocks = |object: usize, face: usize| face_blocks(bodies, (object, face), &probe, own, light);
    flat_face_is_turned_to(bodies, object, face, light)
        && !(0..bodies.scene.objects.len()).any(|other| (0..bodies.face_count(other)).any(|face| blocks(other, face)))
}

fn object(shape: Shape, map: DAffine3, sides: Sides) -> Object {
    Object::new("object".into(), shape, Placement::new(map).expect("regular"), sides).expect("an object")
}

fn mesh(triangles: &[[[f64; 3]; 3]]) -> Shape {
    let corners = (0..triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    Shape::Mesh(Arc::new(Mesh::new(triangles.concat(), corners).expect("a mesh")))
}

/// A sphere of triangles that share corners, 8·4^level of them.
fn ball(level: u32) -> Shape {
    let mut triangles = Vec::new();
    for sides in 0..8 {
        let sign = |k: u32| if sides >> k & 1 == 0 { 1.0 } else { -1.0 };
        let corners = [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
        let is_turned = sign(0) * sign(1) * sign(2) < 0.0;
        let mut part = vec![if is_turned { [corners[0], corners[2], corners[1]] } else { corners }];
        for _ in 0..level {
            part = part
                .into_iter()
                .flat_map(|[a, b, c]| {
                    let [ab, bc, ca] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                })
                .collect();
        }
        triangles.extend(part.into_iter().map(|corners| corners.map(|corner| corner.to_array())));
    }
    mesh(&triangles)
}

fn floor(size: f64, y: f64) -> Object {
    object(Shape::Rectangle(Rectangle { size: [size; 2] }), DAffine3::from_translation(DVec3::Y * y), Sides::Auto)
}

#[test]
fn a_ball_over_a_floor() {
    let over = DAffine3::from_translation(DVec3::new(0.3, 1.5, -0.2));
    let sun = LightSource::sun([0.5, -1.0, 0.25]).expect("a sun");
    let lamp = LightSource::point([1.5, 4.0, 0.5]).expect("a lamp");
    for light in [sun, lamp] {
        // Few samples a face, some, many; dense and coarse meshes.
        for (level, samples) in [(4, 3_000), (2, 20_000), (0, 40_000)] {
            let (lit, all) = check(vec![object(ball(level), over, Sides::Auto), floor(8.0, 0.0)], light, samples);
            assert!(lit * 5 > all && lit * 20 < all * 19, "{lit} of {all}");
        }
    }
}

/// More than a group of the order holds, each from another corner: one half of a square, the other half, which has the same box, and one below both.
#[test]
fn triangles_given_very_often() {
    let [a, b, c, d] = [[-1.0, 1.0, -1.0], [1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]];
    let low = [a, b, c].map(|[x, _, z]| [x, 0.5, z]);
    let mut triangles = Vec::new();
    for k in 0..200 {
        for mut corners in [[a, b, c], [a, c, d], low] {
            corners.rotate_left(k % 3);
            triangles.push(corners);
        }
    }
    let lights = [LightSource::sun([0.5, -1.0, 0.25]), LightSource::point([1.5, 4.0, 0.5])];
    for light in lights.map(|light| light.expect("a light")) {
        let pile = object(mesh(&triangles), DAffine3::IDENTITY, Sides::Auto);
        let (lit, all) = check(vec![pile, floor(6.0, 0.0)], light, 1_500);
        assert!(lit * 3 > all && lit * 20 < all * 19, "{lit} of {all}");
    }
}

/// Two tetrahedra with one box, each of them more often than a pile of volumes needs, and with vertices of its own, so that it is a solid.
#[test]
fn solids_given_very_often() {
    let corner = |bits: u32| [0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { 1.0 } else { -1.0 });
    let positions = [0, 3, 5, 6, 7, 4, 2, 1].map(corner).repeat(200);
    let faces = |first: u32| [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|face| face.map(|corner| first + corner));
    let triangles = (0..400).flat_map(|solid| faces(4 * solid)).collect();
    let pile = Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh")));
    let lights = [LightSource::sun([0.5, -1.0, 0.25]), LightSource::point([1.5, 4.0, 0.5])];
    for light in lights.map(|light| light.expect("a light")) {
        let pile = object(pile.clone(), DAffine3::from_translation(DVec3::Y * 1.5), Sides::Auto);
        let (lit, all) = check(vec![pile, floor(6.0, 0.0)], light, 3_000);
        assert!(lit * 8 > all && lit * 20 < all * 19, "{lit} of {all}");
    }
}

#[test]
fn curved_bodies_are_in_the_way_of_flat_ones() {
    let body = |body: Analytic, map: DAffine3| object(Shape::from(body), map, Sides::Two);
    let at = |x: f64, y: f64, z: f64| DAffine3::from_translation(DVec3::new(x, y, z));
    let turned = DAffine3::from_rotation_translation(
        DQuat::from_xyzw(0.3, 0.1, -0.5, 0.8).normalize(),
        DVec3::new(-2.0, 1.2, 1.5),
    );
    let scene = || {
        vec![
            floor(8.0, 0.0),
            object(ball(1), at(2.2, 0.8, 2.0), Sides::Auto),
            // Half of it is below the floor.
            body(Analytic::Sphere { radius: 0.9 }, at(0.4, 0.1, -1.5)),
            body(Analytic::Cylinder { radius: 0.5, height: 1.8 }, turned),
            body(Analytic::Disk { radius: 0.8 }, at(-1.5, 1.5, -2.0)),
            body(Analytic::Sphere { radius: 0.6 }, at(2.0, 2.6, 1.6)),
        ]
    };
    let sun = |x: f64, y: f64, z: f64| LightSource::sun([x, y, z]).expect("a sun");
    let lamp = |x: f64, y: f64, z: f64| LightSource::point([x, y, z]).expect("a lamp");
    // Aslant, along an axis, along the disk; far off, in the box of a sphere beside it, in a sphere, on the side of a box.
    let lights = [
        sun(0.5, -1.0, 0.25),
        sun(0.0, -1.0, 0.0),
        sun(1.0, -0.01, 0.0),
        lamp(1.5, 5.0, 0.5),
        lamp(1.2, 0.9, -0.8),
        lamp(0.4, 0.5, -1.5),
        lamp(2.0, 3.2, 1.2),
    ];
    for light in lights {
        let (lit, all) = check(scene(), light, 6_000);
        assert!(lit > 0 && lit < all, "{lit} of {all} under {light:?}");
    }
}

/// The same triangles by common corners.
fn welded(triangles: &Shape) -> Shape {
    let Shape::Mesh(mesh) = triangles else { panic!("a mesh") };
    let (mut positions, mut numbers) = (Vec::new(), HashMap::new());
    let mut number = |corner: u32| {
        // Adding zero makes −0 and 0 one number.
        let position = mesh.positions()[corner as usize].to_array().map(|x| x + 0.0);
        *numbers.entry(position.map(f64::to_bits)).or_insert_with(|| {
            positions.push(position);
            positions.len() as u32 - 1
        })
    };
    let triangles = mesh.triangles().iter().map(|triangle| triangle.map(&mut number)).collect();
    Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh")))
}

#[test]
fn dense_solids_before_and_in_each_other() {
    // Free, half before another, half in another, wholly in another.
    let ball = welded(&ball(3));
    let at = [[-3.0, 1.2, 0.0], [1.0, 1.1, 0.0], [1.3, 3.4, 0.4], [2.2, 1.3, 0.5], [2.1, 1.2, 0.4]];
    let balls = at.iter().enumerate().map(|(k, &at)| {
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::splat(if k == 4 { 0.25 } else { 1.0 }),
            DQuat::from_rotation_y(0.3 * k as f64),
            DVec3::from_array(at),
        );
        object(ball.clone(), map, Sides::One)
    });
    let objects: Vec<Object> = balls.chain([floor(9.0, 0.0)]).collect();
    let lights =
        [LightSource::sun([0.2, -1.0, 0.1]), LightSource::point([1.0, 7.0, 0.5]), LightSource::point([-3.2, 1.4, 0.1])];
    for light in lights {
        let (lit, all) = check(objects.clone(), light.expect("a light"), 2_000);
        assert!(lit * 20 < all * 19, "{lit} of {all}");
    }
}

#[test]
fn a_lamp_in_the_middle_of_things() {
    let boxes = (0..12).map(|k| {
        let angle = f64::from(k) * 0.55;
        let map = DAffine3::from_rotation_translation(
            DQuat::from_rotation_y(angle),
            DVec3::new(2.0 * angle.cos(), 0.4, 2.0 * angle.sin()),
        );
        object(Shape::Cuboid(Cuboid { size: [0.4, 0.8, 0.3] }), map, Sides::Auto)
    });
    let room =
        object(Shape::Cuboid(Cuboid { size: [9.0, 3.0, 7.0] }), DAffine3::from_translation(DVec3::Y * 1.5), Sides::Two);
    let walls =
        [[[-4.0, 0.0, -3.0], [4.0, 0.0, -3.0], [0.0, 3.0, -2.0]], [[-4.0, 0.0, 3.0], [0.0, 2.0, 2.0], [4.0, 0.5, 2.5]]];
    let panels = object(mesh(&walls), DAffine3::IDENTITY, Sides::Two);
    let lamp = LightSource::point([0.1, 0.9, -0.2]).expect("a lamp");
    let (lit, all) = check(boxes.chain([room, panels]).collect(), lamp, 20_000);
    assert!(lit * 5 > all && lit * 20 < all * 19, "{lit} of {all}");
}

#[test]
fn contact_and_coincidence() {
    // Boxes that stand on a floor and side by side, a doubled triangle, a light in the plane of faces.
    let cuboid = |x: f64| {
        object(
            Shape::Cuboid(Cuboid { size: [1.0; 3] }),
            DAffine3::from_translation(DVec3::new(x, 0.5, 0.0)),
            Sides::Auto,
        )
    };
    let doubled = [[[-2.0, 1.0, -2.0], [2.0, 1.0, -2.0], [0.0, 1.0, 2.0]]; 2];
    for light in [
        LightSource::sun([0.0, -1.0, 0.0]),
        LightSource::sun([1.0, -1.0, 0.0]),
        LightSource::sun([1.0, 0.0, 0.0]),
        LightSource::point([0.5, 1.0, 3.0]),
        LightSource::point([0.0, 0.5, 0.0]),
        LightSource::point([1.0, 2.0, 0.0]),
    ] {
        let objects =
            vec![cuboid(0.0), cuboid(1.0), floor(6.0, 0.0), object(mesh(&doubled), DAffine3::IDENTITY, Sides::Two)];
        check(objects, light.expect("a light"), 6_000);
    }
}

#[test]
fn faces_that_all_but_lie_in_one_plane() {
    // Tiles of a slanted plane, one over the other and edge to edge, with corners some roundings off it.
    let nudge = |k: u32| f64::from(k * 7919 % 5) - 2.0;
    let corner = move |x: u32, z: u32, k: u32| {
        let [x, z] = [f64::from(x) - 2.0, f64::from(z) - 2.0];
        [x, (0.3 * x - 0.7 * z) + nudge(k) * 2f64.powi(-50), z]
    };
    for (shared, step) in [(true, 1), (false, 1), (false, 2)] {
        let tiles = (0..16u32).flat_map(|tile| {
            let (x, z) = (tile % 4, tile / 4);
            let at = |i: u32, j: u32| {
                let [x, z] = [(x + i).min(4), (z + j).min(4)];
                corner(x, z, if shared { 5 * x + z } else { 31 * tile + 5 * i + j })
            };
            [[at(0, 0), at(0, step), at(step, 0)], [at(step, 0), at(0, step), at(step, step)]]
        });
        let tiles: Vec<_> = tiles.collect();
        for light in [
            LightSource::sun([0.3, -1.0, 0.2]),
            LightSource::sun([1.0, 0.29, 0.0]),
            LightSource::point([0.5, 3.0, -0.25]),
            LightSource::point([0.5, 0.150_000_1, 0.0]),
        ] {
            let tiles = object(mesh(&tiles), DAffine3::IDENTITY, Sides::Two);
            check(vec![tiles, floor(8.0, -4.0)], light.expect("a light"), 4_000);
        }
    }
}

#[test]
fn a_lamp_half_an_ulp_before_a_wall() {
    // No float is the wall's place, and the nearest one is the lamp's.
    let size = [1.0 - f64::EPSILON, 1.0, 1.0];
    let wall =
        object(Shape::Cuboid(Cuboid { size }), DAffine3::from_translation(DVec3::new(1.5, 0.5, 0.5)), Sides::Auto);
    let lamp = LightSource::point([1.0, 0.5, 0.5]).expect("a lamp");
    let (lit, all) = check(vec![floor(8.0, 0.0), wall], lamp, 3_000);
    assert!(lit * 3 > all && lit * 3 < all * 2, "{lit} of {all}");
}

/// A body whose triangles share corners: a tetrahedron, a box under a random map, or a star with dents.
fn solid(kind: usize, [at, u, v, w]: [[f64; 3]; 4], is_turned: bool) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let [at, u, v, w] = [at, u, v, w].map(DVec3::from);
    let (positions, mut triangles) = match kind {
        0 => (vec![at, at + u, at + v, at + w], vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]),
        1 => {
            let corner =
                |k: usize| at + [u, v, w].iter().enumerate().map(|(j, &x)| x * (k >> j & 1) as f64).sum::<DVec3>();
            let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
            ((0..8).map(corner).collect(), sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
        }
        _ => {
            let ring = (0..6).map(|k| {
                let (sine, cosine) = (f64::from(k) * std::f64::consts::FRAC_PI_3).sin_cos();
                at + (u * cosine + v * sine) * if k % 2 == 0 { 1.0 } else { 0.4 }
            });
            let sides = (0..6u32).map(|k| [2 + k, 2 + (k + 1) % 6]);
            (
                [at + w, at - w].into_iter().chain(ring).collect(),
                sides.flat_map(|[a, b]| [[a, b, 0], [b, a, 1]]).collect(),
            )
        }
    };
    if is_turned {
        triangles.iter_mut().for_each(|triangle: &mut [u32; 3]| triangle.swap(0, 1));
    }
    (positions.into_iter().map(|p| p.to_array()).collect(), triangles)
}

/// Bodies of [`solid`] as the parts of one mesh.
fn one_mesh(solids: impl IntoIterator<Item = (usize, [[f64; 3]; 4], bool)>, sides: Sides) -> Object {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (kind, vectors, is_turned) in solids {
        let (corners, faces) = solid(kind, vectors, is_turned);
        let first = positions.len() as u32;
        triangles.extend(faces.into_iter().map(|face| face.map(|corner| corner + first)));
        positions.extend(corners);
    }
    object(Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh"))), DAffine3::IDENTITY, sides)
}

#[test]
fn random_solids_in_each_other() {
    let number = || prop_oneof![(-4i32..=4).prop_map(|n| f64::from(n) / 2.0), -2.0..2.0f64];
    let point = move || prop::array::uniform3(number());
    let solids = prop::collection::vec((0..3usize, prop::array::uniform4(point()), any::<bool>()), 1..8);
    let strategy = (solids, point(), any::<bool>(), prop_oneof![Just(Sides::One), Just(Sides::Two), Just(Sides::Auto)]);
    let mut runner = TestRunner::new(Config { failure_persistence: None, ..Config::with_cases(300) });
    let outcome = runner.run(&strategy, |(solids, light, is_sun, sides)| {
        let light = if is_sun { LightSource::sun(light) } else { LightSource::point(light) };
        let Ok(light) = light else { return Ok(()) };
        check(vec![one_mesh(solids, sides), floor(6.0, -1.0)], light, 1_500);
        Ok(())
    });
    outcome.expect("every sample is right");
}

#[test]
fn a_lamp_in_the_plane_of_a_face_and_a_sample_in_it() {
    // The way from the sample to the lamp lies in the floor's plane, though not if its parameters are rounded.
    let solids = [
        (
            1,
            [
                [0.0; 3],
                [0.0, 1.0, 0.0],
                [-1.9037435890147985, 1.3794121778185962, -1.0656271657621494],
                [2.0, 2.0, -1.0],
            ],
        ),
        (1, [[0.0, -2.0, 0.0], [0.0, 1.0, -0.6321698038352566], [-1.5444463758037477, 0.0, -2.0], [0.0, 1.5, 0.5]]),
        (0, [[0.0; 3], [-2.0, 0.0, 0.0], [0.0, 0.0, 1.4606548343317798], [0.0, 1.0, -2.0]]),
    ];
    let lamp = LightSource::point([-2.0, -1.0, 0.0]).expect("a lamp");
    check(
        vec![one_mesh(solids.map(|(kind, vectors)| (kind, vectors, false)), Sides::One), floor(6.0, -1.0)],
        lamp,
        1_500,
    );
}

#[test]
fn random_soups() {
    let number = || prop_oneof![(-8i32..=8).prop_map(|n| f64::from(n) / 4.0), -2.0..2.0f64];
    let point = move || prop::array::uniform3(number());
    let soup = prop::collection::vec(prop::array::uniform3(point()), 1..40);
    let strategy = (soup, point(), any::<bool>(), -40i32..40, -1e6..1e6f64);
    let mut runner = TestRunner::new(Config { failure_persistence: None, ..Config::with_cases(400) });
    let outcome = runner.run(&strategy, |(triangles, light, is_sun, scale, far)| {
        let scale = 2f64.powi(scale);
        let place = |p: [f64; 3]| [p[0] * scale + far * scale, p[1] * scale, p[2] * scale];
        let light = if is_sun { LightSource::sun(light) } else { LightSource::point(place(light)) };
        let Ok(light) = light else { return Ok(()) };
        let triangles: Vec<[[f64; 3]; 3]> = triangles.into_iter().map(|corners| corners.map(place)).collect();
        let Ok(object) = Object::new("soup".into(), mesh(&triangles), Placement::IDENTITY, Sides::Two) else {
            return Ok(());
        };
        check(vec![object], light, 1_500);
        Ok(())
    });
    outcome.expect("every sample is right");
}

/// A sheet of so many cells along each side, folded by what is added to its corners, whose triangles share these.
fn sheet(cells: usize, folds: &[[f64; 3]]) -> Vec<[[f64; 3]; 3]> {
    let at = |i: usize, j: usize| {
        let [x, y, z] = folds[(i * (cells + 1) + j) % folds.len()];
        [i as f64 / 4.0 + x, y, j as f64 / 4.0 + z]
    };
    let cell = |i: usize, j: usize| {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        [[a, b, c], [a, c, d]]
    };
    (0..cells).flat_map(|i| (0..cells).flat_map(move |j| cell(i, j))).collect()
}

/// Sheets of small faces with few samples each, which go sixteen at a time: `cases` of them.
fn check_sheets(cases: u32) {
    let number = || prop_oneof![3 => (-4i32..=4).prop_map(|n| f64::from(n) / 8.0), 1 => -0.6..0.6f64];
    let folds = prop::collection::vec(prop::array::uniform3(number()), 3..60);
    let place = prop::array::uniform3((-8i32..=24).prop_map(|n| f64::from(n) / 8.0));
    let strategy = ((4usize..12, folds), place, any::<[bool; 2]>(), (-30i32..30, -1e6..1e6f64), 0.5..5.0f64);
    let mut runner = TestRunner::new(Config { failure_persistence: None, ..Config::with_cases(cases) });
    let outcome = runner.run(&strategy, |((cells, folds), light, [is_sun, is_one_sided], (scale, far), samples)| {
        let scale = 2f64.powi(scale);
        let place = |p: [f64; 3]| [p[0] * scale + far * scale, p[1] * scale, p[2] * scale];
        let light = if is_sun { LightSource::sun(light) } else { LightSource::point(place(light)) };
        let Ok(light) = light else { return Ok(()) };
        let triangles: Vec<[[f64; 3]; 3]> =
            sheet(cells, &folds).into_iter().map(|corners| corners.map(place)).collect();
        let sides = if is_one_sided { Sides::One } else { Sides::Two };
        let Ok(object) = Object::new("sheet".into(), welded(&mesh(&triangles)), Placement::IDENTITY, sides) else {
            return Ok(());
        };
        check(vec![object], light, (samples * triangles.len() as f64) as u64);
        Ok(())
    });
    outcome.expect("every sample is right");
}

#[test]
fn sheets_of_small_faces() {
    check_sheets(200);
}

#[test]
fn a_solid_that_falls_on_one_place_of_the_image_hides_no_more_than_it_does() {
    // A prism of 32 vertices half a metre wide; a quantum of the image is 1.9 metres.
    let (sides, radius) = (16u32, 0.25);
    let ring = |y: f64| {
        (0..sides).map(move |k| {
            let angle = f64::from(k) / f64::from(sides) * std::f64::consts::TAU;
            [radius * libm::cos(angle), y, radius * libm::sin(angle)]
        })
    };
    let positions = ring(-0.25).chain(ring(0.25)).collect();
    let walls = (0..sides).flat_map(|k| {
        let (a, b) = (k, (k + 1) % sides);
        [[a, a + sides, b], [b, a + sides, b + sides]]
    });
    let caps = (1..sides - 1).flat_map(|k| [[0, k, k + 1], [sides, sides + k + 1, sides + k]]);
    let prism = Mesh::new(positions, walls.chain(caps).collect()).expect("a mesh");
    for height in [1.0, 1e6] {
        let floor = Shape::Rectangle(Rectangle { size: [2e9, 2e9] });
        let objects = vec![
            object(floor, DAffine3::IDENTITY, Sides::Two),
            object(Shape::Mesh(Arc::new(prism.clone())), DAffine3::from_translation(DVec3::Y * height), Sides::Auto),
        ];
        let (lit, all) = check(objects, LightSource::sun([0.0, -1.0, 0.0]).expect("a sun"), 1000);
        assert!(lit > all / 2, "{lit} of {all}");
    }
}
