//! The setting of Duan, "A fast soft shadows algorithm for dynamic scene in MMOG" (2009): a robot of four boxes with finer geometry inside, a hundred units
//! high, over a floor under a square light. Object space against exact fractions, and what the source says of its boxes.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Extent, Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{
    Detail, Place, Queries, Silent, SoftRequest, soft_bake,
    soft_image::{LightSpace, OrientedBox, outlines},
};

/// Middles and half sizes of head, body and arms.
const PARTS: [(&str, [f64; 3], [f64; 3]); 4] = [
    ("head", [0.0, 81.0, 0.0], [11.0, 19.0, 11.0]),
    ("body", [0.0, 31.0, 0.0], [18.0, 31.0, 14.0]),
    ("left_arm", [20.5, 42.0, 0.0], [2.5, 14.0, 5.0]),
    ("right_arm", [-20.5, 42.0, 0.0], [2.5, 14.0, 5.0]),
];

/// A closed mesh half way between the cube −1..1 and its inscribed ball: it touches all sides of its box.
fn rounded() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    const CELLS: u32 = 6;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for side in 0..6u32 {
        let sign = if side % 2 == 0 { 1.0 } else { -1.0 };
        let first = positions.len() as u32;
        for (i, j) in (0..=CELLS).flat_map(|i| (0..=CELLS).map(move |j| (i, j))) {
            let at = |k: u32| f64::from(k) * (2.0 / f64::from(CELLS)) - 1.0;
            let on_cube = match side / 2 {
                0 => DVec3::new(sign, at(i), at(j)),
                1 => DVec3::new(at(j), sign, at(i)),
                _ => DVec3::new(at(i), at(j), sign),
            };
            positions.push(0.5 * (on_cube + on_cube.normalize()));
        }
        for (i, j) in (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| (i, j))) {
            let a = first + i * (CELLS + 1) + j;
            let [b, c, d] = [a + CELLS + 1, a + CELLS + 2, a + 1];
            let quad = if sign > 0.0 { [a, b, c, d] } else { [a, d, c, b] };
            triangles.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
        }
    }
    (positions, triangles)
}

fn part((name, center, half): (&str, [f64; 3], [f64; 3])) -> Object {
    let (positions, triangles) = rounded();
    let place = |p: DVec3| (p * DVec3::from_array(half) + DVec3::from_array(center)).to_array();
    let mesh = Mesh::new(positions.into_iter().map(place).collect(), triangles).expect("a mesh");
    Object::new(name.into(), Shape::Mesh(Arc::new(mesh)), Placement::IDENTITY, Sides::Auto).expect("a body")
}

/// The light is 8 x 8 and looks at the robot's middle.
fn robot() -> Scene {
    let floor = Shape::Rectangle(Rectangle { size: [400.0; 2] });
    let placement = Placement::new(DAffine3::IDENTITY).expect("regular");
    let mut objects = vec![Object::new("floor".into(), floor, placement, Sides::Auto).expect("a floor")];
    objects.extend(PARTS.map(part));
    let centre = LightSource::point([120.0, 210.0, 50.0]).expect("a point");
    let (u, v) = (DVec3::new(2.8657, -2.5224, 1.194), DVec3::new(-1.5385, 0.0, 3.6923));
    let light = Light::with_extent("panel", centre, Extent::Rectangle { u, v }).expect("a light");
    Scene { objects, lights: vec![light], ..Scene::default() }
}

#[test]
fn at_depth_8_the_floor_is_known_to_one_per_cent() {
    let scene = robot();
    let facets = scene.objects[1].facets().expect("flat");
    assert!((0..facets.len()).all(|face| facets.is_closed(face)));
    let detail = Detail::Depth { interior: 8, boundary: 8 };
    let request = SoftRequest { receivers: vec![0], keep_cells: true, ..SoftRequest::everything(&scene, detail) };
    let floor = soft_bake(&scene, &request, &Silent).expect("done").remove(0).objects.remove(0);
    let queries = Queries::new(&scene);
    let light = &scene.lights[0];
    let (mut squares, mut penumbra, mut count) = (0.0, 0, 0);
    // Every third cell, at a point that is not its middle, weighted by area.
    for cell in floor.cells.iter().step_by(3) {
        let area = 0.25f64.powi(i32::from(cell.level));
        let [u, v] = cell.point([0.171, 0.683]);
        let seen = queries.visible_fraction(&Place::Surface { object: 0, face: 0, u, v }, light).expect("a place");
        let (low, high) = (cell.lower - seen.max_error, cell.upper + seen.max_error);
        assert!(low <= seen.value && seen.value <= high, "{seen:?} {cell:?}");
        squares += 3.0 * area * (seen.value - cell.estimate).powi(2);
        penumbra += usize::from(seen.value > 0.0 && seen.value < 1.0);
        count += 1;
    }
    assert!(squares.sqrt() < 0.01, "RMSE {} of {count} points", squares.sqrt());
    assert!(penumbra > 300, "{penumbra} of {count}");
    assert!(floor.umbra.lower > 1_000.0 && floor.umbra.lower < floor.umbra.upper);
    assert!(floor.visible.upper - floor.visible.lower < 0.02 * floor.area, "{:?}", floor.visible);
}

#[test]
fn both_arms_vanish_the_head_keeps_three_corners_and_the_body_five() {
    let scene = robot();
    let origin = scene.lights[0].source.xyz();
    let boxes: Vec<OrientedBox> = scene.objects[1..].iter().filter_map(OrientedBox::of).collect();
    let corners = boxes.iter().flat_map(|oriented| oriented.corners);
    let space = LightSpace::round(origin, DVec3::Y * 50.0 - origin, corners, 64);
    let corners: Vec<usize> = outlines(&space, &boxes).iter().map(|outline| outline.corners.len()).collect();
    assert_eq!(corners, [3, 5]);
}
