//! Faces that hang together: neighbours that do not shadow each other, and sheets that shadow what is behind them, whatever else is there.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use umbriel_geometry::{LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Detail, ObjectReport, Request, Silent, bake};

fn placed(shape: Shape, map: DAffine3) -> Object {
    Object::new("object".into(), shape, Placement::new(map).expect("regular"), Sides::Two).expect("an object")
}

fn mesh(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Shape {
    Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh")))
}

/// What is told of the first object.
fn first(objects: Vec<Object>, light: LightSource, depth: u8) -> ObjectReport {
    let scene = Scene { objects: objects.into(), lights: vec![Light::new("light", light)], ..Scene::default() };
    let detail = Detail::Depth { interior: depth, boundary: depth };
    let request = Request { receivers: vec![0], ..Request::everything(&scene, detail) };
    bake(&scene, &request, &Silent).expect("nobody cancels").lights.remove(0).objects.remove(0)
}

/// A crumpled sheet: triangles round a point, with corners above and below it in turn.
fn crumpled() -> Shape {
    let rim = [[2.0, 0.0], [1.5, 1.0], [0.0, 2.0], [-1.0, 1.5], [-2.0, 0.25], [-1.5, -1.0], [0.0, -2.0], [1.0, -1.5]];
    let around = rim.into_iter().zip([0.5, -0.5].into_iter().cycle()).map(|([x, z], y)| [x, y, z]);
    let positions = [[0.0; 3]].into_iter().chain(around).collect();
    mesh(positions, (0..8).map(|k| [0, 1 + (k + 1) % 8, 1 + k]).collect())
}

/// Under the light each face has others before its plane and behind it, along its sides and at the corner that all share.
#[test]
fn faces_of_a_crumpled_sheet_are_lit_without_doubt() {
    let turn = DQuat::from_xyzw(0.1, 0.2, 0.3, 0.9).normalize();
    let turned = DAffine3::from_rotation_translation(turn, DVec3::new(0.3, 0.1, 0.7));
    for map in [DAffine3::IDENTITY, turned] {
        let down = map.transform_vector3(DVec3::new(0.1, -1.0, 0.05));
        let above = map.transform_point3(DVec3::new(0.25, 5.0, -0.125));
        let lights = [LightSource::sun(down.into()), LightSource::point(above.into())];
        for light in lights.map(|light| light.expect("a light")) {
            for depth in [0, 4] {
                let report = first(vec![placed(crumpled(), map)], light, depth);
                let least = report.area - 2.0 * report.area_error;
                assert!(report.lit.lower >= least, "{light:?} at depth {depth}: {:?}", report.lit);
            }
        }
    }
}

/// A roof of two triangles hides a floor; under it are squares, of the same mesh or others, of which each hides a corner or a part of a side.
#[test]
fn a_roof_hides_what_is_under_it_whatever_is_between() {
    let square = |[x, z]: [f64; 2], y: f64, half: f64| {
        let at = [[-half, -half], [half, -half], [half, half], [-half, half]];
        at.map(|[along, across]| [x + along, y, z + across])
    };
    let roof = square([0.0, 0.0], 3.0, 2.0);
    let places = [[-0.5, -0.5], [0.0, -0.5], [0.5, -0.5], [-0.5, 0.0], [0.5, 0.25], [-0.5, 0.5], [0.5, 0.5]];
    let between = places.into_iter().zip(1..).map(|(place, k)| square(place, 0.25 * f64::from(k), 0.2));
    let squares: Vec<[[f64; 3]; 4]> = between.chain([roof]).collect();
    let mesh_of = |squares: &[[[f64; 3]; 4]]| {
        let corners = squares.iter().flatten().copied().collect();
        let triangles = (0..squares.len() as u32).map(|k| 4 * k).flat_map(|k| [[k, k + 2, k + 1], [k, k + 3, k + 2]]);
        placed(mesh(corners, triangles.collect()), DAffine3::IDENTITY)
    };
    let (one, many) = (vec![mesh_of(&squares)], squares.chunks(1).map(mesh_of).collect());
    let sun = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
    for over in [one, many] {
        let floor = placed(Shape::Rectangle(Rectangle { size: [1.0; 2] }), DAffine3::IDENTITY);
        let report = first(std::iter::once(floor).chain(over).collect(), sun, 0);
        assert_eq!((report.lit.lower, report.lit.upper), (0.0, 0.0));
    }
}
