//! The method read literally: a scene for each fault that it has.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use umbriel_geometry::{Cuboid, Facets, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{
    rivals::{Faults, Literal, Polygons, Rival},
    tradeoff::Judge,
};

fn object(name: &str, shape: Shape, map: DAffine3) -> Object {
    Object::new(name.into(), shape, Placement::new(map).expect("regular"), Sides::Auto).expect("an object")
}

fn at(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

fn floor() -> Object {
    object("floor", Shape::Rectangle(Rectangle { size: [4.0; 2] }), at(0.0, 0.0, 0.0))
}

/// Boxes (middle, size) as one mesh.
fn boxes(name: &str, boxes: &[([f64; 3], [f64; 3])]) -> Object {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for &(middle, size) in boxes {
        let placement = Placement::new(DAffine3::from_translation(middle.into())).expect("regular");
        let facets = Facets::of_cuboid(&Cuboid { size }, &placement);
        let first = positions.len() as u32;
        positions.extend(facets.positions().iter().map(DVec3::to_array));
        for face in facets.iter() {
            let [a, b, c, d] = face.corners()[..] else { panic!("a side of a box has four corners") };
            triangles.extend([[a, b, c], [a, c, d]].map(|corners| corners.map(|corner| first + corner)));
        }
    }
    object(name, Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh"))), at(0.0, 0.0, 0.0))
}

/// The faults at points all over the scene, under a sun.
fn faults(objects: Vec<Object>, direction: [f64; 3], method: Literal) -> Faults {
    let sun = LightSource::sun(direction).expect("a sun");
    let scene = Scene { objects: objects.into(), lights: vec![Light::new("sun", sun)], ..Scene::default() };
    let polygons = Polygons::new(&scene, 1);
    let judge = Judge::new(&scene, &polygons, &sun, 20_000);
    let faults = method.faults(&polygons, &sun, judge.points(), judge.lit()).expect("faults");
    let stated = method.answer(&polygons, &sun, judge.points()).expect("answers").lit;
    let wrong = stated.iter().zip(judge.lit()).filter(|(stated, truth)| stated != truth).count();
    assert_eq!((faults.points, faults.wrong()), (judge.len() as u64, wrong as u64), "each wrong point has one reason");
    faults
}

const METHOD: Literal = Literal { interior: 3, boundary: 6, most_rays: u64::MAX };

#[test]
fn two_bars_shadow_all_corners_and_not_what_is_between() {
    let bars = boxes("bars", &[([0.0, 2.0, -1.9], [5.0, 0.2, 0.9]), ([0.0, 2.0, 1.9], [5.0, 0.2, 0.9])]);
    let faults = faults(vec![floor(), bars], [0.0, -1.0, 0.0], METHOD);
    assert!(faults.eight_hits > 1000, "{faults:?}");
}

#[test]
fn a_small_body_passes_between_the_rays() {
    let small = boxes("small", &[([0.27, 1.0, 0.27], [0.1, 0.1, 0.1])]);
    let faults = faults(vec![floor(), small], [0.0, -1.0, 0.0], METHOD);
    assert!(faults.eight_misses > 0 && faults.eight_hits == 0, "{faults:?}");
}

#[test]
fn a_tilted_plate_slips_between_corners() {
    let tilt = DAffine3::from_rotation_translation(DQuat::from_rotation_z(0.7), DVec3::ZERO);
    let plate = object("plate", Shape::Rectangle(Rectangle { size: [2.0; 2] }), tilt);
    let lid = boxes("lid", &[([0.0, 3.0, 0.0], [8.0, 0.2, 8.0])]);
    let faults = faults(vec![plate, lid], [0.0, -1.0, 0.0], METHOD);
    assert!(faults.membership > 50 && faults.membership == faults.wrong(), "{faults:?}");
}

#[test]
fn a_body_never_shadows_itself() {
    let table = boxes("table", &[([0.0, 2.0, 0.0], [2.0, 0.2, 2.0]), ([0.0, 0.0, 0.0], [3.0, 0.2, 3.0])]);
    let faults = faults(vec![table], [0.1, -1.0, 0.1], METHOD);
    assert!(faults.own_shadow > 1000 && faults.own_shadow == faults.wrong(), "{faults:?}");
}
