//! Points on sheets against single queries, where closed surfaces go through each other, lie in each other, are inside out, mirrored, doubled or open.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use umbriel_geometry::{Analytic, Cuboid, LightSource, Mesh, Placement};
use umbriel_scene::{Object, Scene, Shape, Sides};

use super::super::{grid::Grids, *};
use crate::{light_space::View, progress::Silent};

const RINGS: u32 = 14;
const SECTORS: u32 = 24;

/// A closed surface round a middle, with bumps; stretched along each axis. Without its last ring of triangles where it is open.
fn bumpy(middle: [f64; 3], stretch: [f64; 3], is_open: bool) -> Mesh {
    let at = |ring: u32, sector: u32| 1 + (ring - 1) * SECTORS + sector % SECTORS;
    let last = 1 + (RINGS - 1) * SECTORS;
    let place = |ring: u32, sector: u32| {
        let (a, b) = (f64::from(ring) / f64::from(RINGS), f64::from(sector) / f64::from(SECTORS));
        let (a, b) = (a * std::f64::consts::PI, b * std::f64::consts::TAU);
        let bump = 1.0 + 0.25 * libm::sin(3.0 * b) * libm::sin(a) * libm::sin(a) + 0.2 * libm::cos(5.0 * a);
        let unit = DVec3::new(libm::sin(a) * libm::cos(b), libm::cos(a), libm::sin(a) * libm::sin(b));
        (DVec3::from_array(middle) + DVec3::from_array(stretch) * unit * bump).to_array()
    };
    let mut positions = vec![place(0, 0)];
    positions.extend((1..RINGS).flat_map(|ring| (0..SECTORS).map(move |sector| place(ring, sector))));
    positions.push(place(RINGS, 0));
    let mut triangles: Vec<[u32; 3]> = (0..SECTORS).map(|sector| [0, at(1, sector), at(1, sector + 1)]).collect();
    for (ring, sector) in (1..RINGS - 1).flat_map(|ring| (0..SECTORS).map(move |sector| (ring, sector))) {
        let [a, b, c, d] = [at(ring, sector), at(ring, sector + 1), at(ring + 1, sector + 1), at(ring + 1, sector)];
        triangles.extend([[a, d, c], [a, c, b]]);
    }
    if !is_open {
        triangles.extend((0..SECTORS).map(|sector| [at(RINGS - 1, sector + 1), at(RINGS - 1, sector), last]));
    }
    Mesh::new(positions, triangles).expect("a mesh")
}

fn inside_out(mesh: &Mesh) -> Mesh {
    let positions = mesh.positions().iter().map(|position| position.to_array()).collect();
    Mesh::new(positions, mesh.triangles().iter().map(|&[a, b, c]| [a, c, b]).collect()).expect("a mesh")
}

fn scene_of(meshes: Vec<(Mesh, bool)>, sides: Sides) -> Scene {
    let mirror = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)));
    let object = |(number, (mesh, is_mirrored)): (usize, (Mesh, bool))| {
        let placement = if is_mirrored { Placement::new(mirror).expect("a mirror") } else { Placement::IDENTITY };
        Object::new(format!("{number}"), Shape::Mesh(mesh.into()), placement, sides).expect("an object")
    };
    Scene { objects: meshes.into_iter().enumerate().map(object).collect(), ..Scene::default() }
}

/// Scenes of which each breaks another sentence of the proof when it is left out.
fn scenes() -> Vec<Scene> {
    let [round, flat, thin] = [[1.0; 3], [1.4, 0.5, 1.2], [0.9, 0.08, 0.9]];
    let closed = |middle, stretch| (bumpy(middle, stretch, false), false);
    let all = |meshes: Vec<(Mesh, bool)>| scene_of(meshes, Sides::Two);
    vec![
        all(vec![closed([0.0; 3], round)]),
        all(vec![closed([0.0; 3], round), closed([0.5, 0.3, 0.1], round), closed([-0.2, 0.9, 0.3], flat)]),
        all(vec![closed([0.0; 3], [2.0, 1.5, 2.0]), closed([0.1, 0.2, 0.0], round), closed([0.0, 2.0, 0.0], thin)]),
        all(vec![(inside_out(&bumpy([0.0; 3], round, false)), false), closed([0.3, 0.2, 0.0], flat)]),
        all(vec![(bumpy([-0.2, 0.1, 0.0], round, false), true), closed([0.4, 0.3, 0.2], round)]),
        all(vec![closed([0.0; 3], round), closed([0.0; 3], round)]),
        all(vec![(bumpy([0.0; 3], round, true), false), (inside_out(&bumpy([0.1, 1.1, 0.0], flat, true)), false)]),
        scene_of(vec![closed([0.0; 3], round), (bumpy([0.4, 0.9, 0.1], flat, true), false)], Sides::Auto),
        with_bodies(all(vec![closed([0.0; 3], round)])),
    ]
}

/// With a cuboid as it is, one whose corners are no floats, and a ball given by a formula.
fn with_bodies(mut scene: Scene) -> Scene {
    let turned = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.4), DVec3::new(-0.9, 0.8, 0.3));
    let cuboid = |size| Shape::Cuboid(Cuboid { size });
    let moved = DAffine3::from_translation(DVec3::new(0.5, 1.25, 0.0));
    let bodies = [
        (cuboid([1.0, 0.5, 0.75]), moved),
        (cuboid([0.7, 0.3, 0.9]), turned),
        (Shape::from(Analytic::Sphere { radius: 0.4 }), DAffine3::from_translation(DVec3::new(0.2, 1.9, -0.3))),
    ];
    scene.objects.extend(bodies.into_iter().map(|(shape, placement)| {
        let placement = Placement::new(placement).expect("a placement");
        Object::new("body".into(), shape, placement, Sides::Two).expect("an object")
    }));
    scene
}

/// Some points of every face, their places from multiples of irrational numbers; some on edges and at corners.
fn points(scene: &Scene) -> Vec<FacePoint> {
    let part = |number: usize, factor: f64| (number as f64 * factor).fract();
    let mut points = Vec::new();
    let is_flat = |body: &Object| !matches!(body.shape, Shape::Analytic(_));
    for (object, body) in scene.objects.iter().enumerate().filter(|(_, body)| is_flat(body)) {
        for face in 0..body.face_count() {
            for k in 0..8 {
                let number = (object * 911 + face) * 8 + k;
                let (u, v) = (part(number, 0.754_877_666), part(number, 0.569_840_291));
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                points.push(FacePoint::new(object, face, u, v));
            }
            points.extend([(0.0, part(face, 0.3)), (0.0, 0.0)].map(|(u, v)| FacePoint::new(object, face, u, v)));
        }
    }
    points
}

#[test]
fn points_on_sheets_are_answered_as_single_ones() {
    let sun = |x, y, z| LightSource::sun([x, y, z]).expect("a sun");
    let lamp = |x, y, z| LightSource::point([x, y, z]).expect("a lamp");
    let lights =
        [sun(0.3, -1.0, 0.2), sun(1.0, -0.05, 0.3), lamp(2.0, 4.0, 1.0), lamp(0.05, 0.1, 0.02), lamp(1.3, 0.9, -0.2)];
    let mut sheets = [0; 2];
    for (number, scene) in scenes().iter().enumerate() {
        let queries = Queries::new(scene);
        let points = points(scene);
        for light in &lights {
            let many = queries.lit_many(Points::OnFaces(&points), light, &Silent).expect("points of faces");
            for (point, many) in points.iter().zip(many) {
                let alone = queries.lit(&point.place(), light).expect("a point").lit;
                assert_eq!(many, alone, "{point:?} of scene {number} under {light:?}");
            }
            let mut pieces = Pieces::of(&queries.bodies).expect("few pieces");
            pieces.find_surfaces();
            let grids = Grids::of(&pieces, View::all(light, &pieces.bounds), points.len(), None).expect("few cells");
            let tiles =
                grids.grids.iter().flat_map(|grid| (0..grids.places_of(grid).len()).map(|tile| grid.tile(tile)));
            sheets[usize::from(light.is_sun())] +=
                tiles.flat_map(|tile| &tile.cells).filter(|cell| cell.surface < f32::INFINITY).count();
        }
    }
    assert!(sheets[0] > 100 && sheets[1] > 500, "{sheets:?} cells of lamps' and suns' views have a sheet");
}

#[test]
fn sheets_of_many_tiles_say_the_same() {
    let scene = scene_of(
        (0..5).map(|k| (bumpy([f64::from(k) * 1.1, 0.2 * f64::from(k), 0.0], [1.0, 0.9, 1.1], false), false)).collect(),
        Sides::Two,
    );
    let queries = Queries::new(&scene);
    let some = points(&scene);
    let repeated: Vec<FacePoint> = (0..8).flat_map(|_| &some).copied().collect();
    for light in
        [LightSource::sun([0.3, -1.0, 0.2]), LightSource::point([2.0, 6.0, 1.0])].map(|light| light.expect("a light"))
    {
        let views = View::all(&light, &Pieces::of(&queries.bodies).expect("few pieces").bounds);
        let pieces = Pieces::of(&queries.bodies).expect("few pieces");
        let grids = Grids::of(&pieces, views, repeated.len(), None).expect("few cells");
        assert!(grids.grids.iter().any(|grid| grids.places_of(grid).len() > 1), "under {light:?}");
        let many = queries.lit_many(Points::OnFaces(&repeated), &light, &Silent).expect("points of faces");
        for (point, many) in repeated.iter().zip(many).take(some.len()) {
            let alone = queries.lit(&point.place(), &light).expect("a point").lit;
            assert_eq!(many, alone, "{point:?} under {light:?}");
        }
    }
}
