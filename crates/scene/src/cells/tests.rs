use std::sync::Arc;

use umbriel_geometry::{Cuboid, Mesh, Placement};

use super::*;
use crate::{Shape, Sides};

fn room(name: &str, min: [f64; 3], max: [f64; 3]) -> SceneCell {
    let ends = [DVec3::from_array(min), DVec3::from_array(max)];
    let corner = |i: usize| DVec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2 & 1].z);
    SceneCell { name: name.into(), region: Region::Convex(Brep::hull((0..8).map(corner)).expect("a box")), slack: 0.0 }
}

fn outdoors() -> SceneCell {
    SceneCell { name: "outdoors".into(), region: Region::Outdoors, slack: 0.0 }
}

/// A door in the plane x = 4.
fn door(cells: [usize; 2]) -> Portal {
    let corners = [[4.0, 0.0, 1.0], [4.0, 0.0, 2.0], [4.0, 2.0, 2.0], [4.0, 2.0, 1.0]];
    Portal { name: "door".into(), cells, corners: corners.map(DVec3::from_array).to_vec(), slack: 0.0 }
}

fn rooms() -> Vec<SceneCell> {
    vec![room("west", [0.0; 3], [4.0, 3.0, 4.0]), room("east", [4.0, 0.0, 0.0], [8.0, 3.0, 4.0]), outdoors()]
}

fn cube(name: &str, size: [f64; 3], center: [f64; 3]) -> Object {
    let placement = Placement::new(glam::DAffine3::from_translation(center.into())).expect("regular");
    Object::new(name.into(), Shape::Cuboid(Cuboid { size }), placement, Sides::Auto).expect("a box")
}

fn refused(cells: Vec<SceneCell>, portal: Portal) -> CellDefect {
    CellGraph::new(cells, vec![portal], &[]).expect_err("a defect").1
}

#[test]
fn the_first_cell_of_a_portal_is_in_front_of_it() {
    for cells in [[0, 1], [1, 0]] {
        let graph = CellGraph::new(rooms(), vec![door(cells)], &[]).expect("rooms");
        let Portal { cells, corners, .. } = &graph.portals()[0];
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        assert_eq!(normal.x < 0.0, cells[0] == 0, "it looks at the first cell");
        assert_eq!((graph.portals_of(0), graph.portals_of(1), graph.portals_of(2)), (&[0][..], &[0][..], &[][..]));
    }
}

#[test]
fn objects_are_in_every_cell_that_they_meet() {
    let wall = cube("wall", [0.25, 3.0, 4.0], [4.0, 1.5, 2.0]);
    let table = cube("table", [1.0; 3], [1.0, 0.75, 1.0]);
    let shelf = cube("shelf", [0.5, 1.0, 1.0], [4.25, 1.0, 2.0]);
    let front = cube("front", [8.0, 3.0, 0.25], [4.0, 1.5, 0.0]);
    let far = cube("far", [1.0; 3], [20.0, 0.0, 0.0]);
    let objects = [wall, table, shelf, front, far];
    let graph = CellGraph::new(rooms(), Vec::new(), &objects).expect("rooms");
    // The shelf touches the plane between the rooms.
    assert_eq!(graph.objects_in(0), [0, 1, 2, 3]);
    assert_eq!(graph.objects_in(1), [0, 2, 3]);
    // The wall between the rooms touches the floor and the ceiling of the building.
    assert_eq!(graph.objects_in(2), [0, 3, 4]);
    assert_eq!(graph.loose_objects(), 0);
    let without = CellGraph::new(rooms()[..2].to_vec(), Vec::new(), &objects).expect("rooms");
    assert_eq!(without.loose_objects(), 1);
}

#[test]
fn a_slanted_object_beside_a_cell_is_not_in_it() {
    // Its box meets the west room, the triangle itself passes the room's edge at x = 4, z = 4.
    let mesh = Mesh::new(vec![[3.5, 1.0, 6.0], [6.0, 1.0, 3.5], [6.0, 2.0, 6.0]], vec![[0, 1, 2]]).expect("a mesh");
    let object =
        Object::new("sail".into(), Shape::Mesh(Arc::new(mesh)), Placement::IDENTITY, Sides::Auto).expect("fine");
    let cells = vec![room("west", [0.0; 3], [4.0, 3.0, 4.0])];
    let graph = CellGraph::new(cells, Vec::new(), std::slice::from_ref(&object)).expect("a room");
    assert_eq!(graph.objects_in(0), [0], "planes of the room alone do not tell");
    let slanted = Brep::hull(
        [[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [0.0, 0.0, 8.0], [0.0, 3.0, 0.0], [8.0, 3.0, 0.0], [0.0, 3.0, 8.0]]
            .map(DVec3::from_array),
    );
    let cells = vec![SceneCell { name: "wedge".into(), region: Region::Convex(slanted.expect("a wedge")), slack: 0.0 }];
    let graph = CellGraph::new(cells, Vec::new(), &[object]).expect("a room");
    assert_eq!(graph.objects_in(0), [0; 0], "all of it lies beyond x + z = 8");
}

#[test]
fn points_are_in_the_cells_that_hold_them() {
    let graph = CellGraph::new(rooms(), vec![door([0, 1])], &[]).expect("rooms");
    let at = |x, y, z| graph.cells_at(DVec3::new(x, y, z));
    assert_eq!(at(1.0, 1.0, 1.0), [0]);
    assert_eq!(at(4.0, 1.0, 1.0), [0, 1], "on the common boundary, inside the building");
    assert_eq!(at(4.0, 3.0, 1.0), [0, 1, 2], "on the roof");
    assert_eq!(at(9.0, 1.0, 1.0), [2]);
}

#[test]
fn portals_lie_in_both_boundaries() {
    assert!(CellGraph::new(rooms(), vec![door([0, 1])], &[]).is_ok());
    assert_eq!(refused(rooms(), door([0, 0])), CellDefect::Ends);
    assert_eq!(refused(rooms(), door([0, 3])), CellDefect::Ends);
    let moved = |by: DVec3| {
        let mut portal = door([0, 1]);
        portal.corners.iter_mut().for_each(|corner| *corner += by);
        portal
    };
    assert_eq!(refused(rooms(), moved(DVec3::X * 0.5)), CellDefect::NotInBoundary { corner: 0, end: 0 });
    assert_eq!(refused(rooms(), moved(DVec3::Y * -1.0)), CellDefect::NotInBoundary { corner: 0, end: 0 });
    let mut bent = door([0, 1]);
    bent.corners[3].x = 3.5;
    assert_eq!(refused(rooms(), bent), CellDefect::NotPlanar { corner: 3 });
    let mut dent = door([0, 1]);
    dent.corners[2] = DVec3::new(4.0, 0.5, 1.25);
    assert!(matches!(refused(rooms(), dent), CellDefect::NotConvex { .. }));
    let mut star = door([0, 1]);
    star.corners.swap(1, 2);
    assert!(matches!(refused(rooms(), star), CellDefect::NotConvex { .. }));
    let mut line = door([0, 1]);
    line.corners.truncate(2);
    assert_eq!(refused(rooms(), line), CellDefect::Corners(2));
    let twice = vec![outdoors(), outdoors()];
    assert_eq!(
        CellGraph::new(twice, Vec::new(), &[]).expect_err("two"),
        (CellEntry::Cell(1), CellDefect::SecondOutdoors)
    );
    let nested = vec![room("a", [0.0; 3], [4.0, 3.0, 4.0]), room("b", [2.0, 0.0, 0.0], [4.0, 3.0, 4.0])];
    assert_eq!(refused(nested, door([0, 1])), CellDefect::SameSide);
    let mut endless = door([0, 1]);
    endless.corners[0].y = f64::NAN;
    assert!(matches!(refused(rooms(), endless), CellDefect::Coordinate { corner: 0, axis: 1, .. }));
}

#[test]
fn a_turned_house_is_taken_with_rounded_corners() {
    // Every angle rounds the corners otherwise; the door stays in the boundaries of both rooms.
    for step in 1..40 {
        let turn = glam::DQuat::from_euler(glam::EulerRot::YXZ, 0.1 * f64::from(step), 0.03 * f64::from(step), 0.7);
        let turned = |cell: SceneCell| {
            let Region::Convex(body) = &cell.region else { return cell };
            let body = Brep::hull(body.vertices().iter().map(|&vertex| turn * vertex)).expect("a box");
            SceneCell { region: Region::Convex(body), ..cell }
        };
        let cells = rooms().into_iter().map(turned).collect();
        let mut portal = door([0, 1]);
        portal.corners.iter_mut().for_each(|corner| *corner = turn * *corner);
        let graph = CellGraph::new(cells, vec![portal], &[]);
        assert!(graph.is_ok(), "step {step}: {:?}", graph.map(drop));
    }
}

#[test]
fn outlines_are_strictly_convex() {
    let points = [[4.0, 0.0, 1.0], [4.0, 2.0, 2.0], [4.0, 1.0, 1.5], [4.0, 0.0, 2.0], [4.0, 2.0, 1.0], [4.0, 0.0, 1.5]];
    let outline = Portal::outline_of(&points.map(DVec3::from_array));
    assert_eq!(outline.len(), 4);
    let portal = Portal { corners: outline, ..door([0, 1]) };
    assert!(CellGraph::new(rooms(), vec![portal], &[]).is_ok());
    assert!(Portal::outline_of(&[DVec3::ZERO, DVec3::X, DVec3::X * 2.0]).len() < 3);
}

#[test]
fn walls_that_rounding_bends_are_convex_within_their_slack() {
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mut bent = 0;
    for step in 1..40 {
        let turn = glam::DQuat::from_euler(glam::EulerRot::YXZ, 0.1 * f64::from(step), 0.05 * f64::from(step), 0.3);
        let corner = |i: u32| {
            let local = DVec3::new(4.0 * f64::from(i & 1), 3.0 * f64::from(i >> 1 & 1), 5.0 * f64::from(i >> 2));
            (turn * local).as_vec3().as_dvec3().to_array()
        };
        let mut positions: Vec<[f64; 3]> = (0..8).map(corner).collect();
        let mesh = Mesh::new(positions.clone(), triangles.clone()).expect("a mesh");
        bent += u32::from(Brep::of_mesh(&mesh).is_err());
        let body = convex_body(&mesh, 7.0 * f64::from(f32::EPSILON)).expect("convex but for rounding");
        assert_eq!(body.vertices().len(), 8);
        // A dent is a dent.
        positions[7] = [0, 1, 2].map(|axis| 0.2 * positions[7][axis] + 0.8 * positions[0][axis]);
        assert!(convex_body(&Mesh::new(positions, triangles.clone()).expect("a mesh"), 1e-6).is_err());
    }
    assert!(bent > 20, "{bent}");
}

#[test]
fn what_is_near_a_rounded_cell_is_in_it() {
    let rounded = |slack: f64| vec![SceneCell { slack, ..room("west", [0.0; 3], [4.0, 3.0, 4.0]) }];
    let near = DVec3::new(4.0 + 1e-6, 1.0, 1.0);
    let object = cube("beside", [1.0; 3], [4.5 + 1e-6, 1.0, 1.0]);
    for (slack, held) in [(0.0, false), (1e-7, false), (1e-5, true)] {
        let graph = CellGraph::new(rounded(slack), Vec::new(), std::slice::from_ref(&object)).expect("a room");
        assert_eq!((graph.cells_at(near).len() == 1, graph.objects_in(0).len() == 1), (held, held), "{slack}");
    }
}

#[test]
fn overlaps_of_cells_and_portals_are_found() {
    let graph = |cells: Vec<SceneCell>, portals: Vec<Portal>| CellGraph::new(cells, portals, &[]).expect("rooms");
    // Rooms that meet at a wall, an edge or a corner are apart, and so is one that is turned about its corner and rounded.
    let turned = |degrees: f64, by: f64| {
        let turn = glam::DMat3::from_rotation_y(degrees.to_radians());
        let corner = |i: usize| DVec3::new([by, by + 4.0][i & 1], [0.0, 3.0][i >> 1 & 1], [0.0, 4.0][i >> 2 & 1]);
        let body = Brep::hull((0..8).map(|i| turn * corner(i))).expect("a box");
        SceneCell { name: "turned".into(), region: Region::Convex(body), slack: 0.0 }
    };
    let mut apart = rooms();
    apart.extend([room("above", [0.0, 3.0, 0.0], [4.0, 6.0, 4.0]), room("corner", [8.0, 3.0, 4.0], [9.0; 3])]);
    assert_eq!(graph(apart, vec![door([0, 1])]).overlaps(9), []);
    for degrees in [10.0, 30.0, 77.0] {
        assert_eq!(graph(vec![turned(degrees, 0.0), turned(degrees, 4.0)], Vec::new()).overlaps(9), []);
        let near = graph(vec![turned(degrees, 0.0), turned(degrees, 3.9)], Vec::new()).overlaps(9);
        assert_eq!(near.len(), 1, "{degrees}");
    }
    // A room half a metre into another one, and two doors that share half of themselves.
    let mut cells = rooms();
    cells.push(room("cupboard", [3.5, 0.0, 3.0], [4.0, 2.0, 5.0]));
    let mut second = door([1, 0]);
    second.corners.iter_mut().for_each(|corner| corner.z += 0.5);
    let mut beside = door([0, 1]);
    beside.corners.iter_mut().for_each(|corner| corner.z += 1.5);
    let found = graph(cells, vec![door([0, 1]), second, beside]).overlaps(9);
    let cells = Overlap { entries: [0, 3].map(CellEntry::Cell), near: DVec3::new(3.75, 1.0, 3.5) };
    let portals = Overlap { entries: [0, 1].map(CellEntry::Portal), near: DVec3::new(4.0, 1.0, 1.75) };
    assert_eq!(found, [cells, portals]);
    assert_eq!(graph(vec![turned(0.0, 0.0); 5], Vec::new()).overlaps(3).len(), 3);
}

#[test]
fn windows_in_walls_that_face_each_other_do_not_overlap() {
    let window = |name: &str, corners: [[f64; 3]; 4]| {
        let corners = corners.map(DVec3::from_array).to_vec();
        Portal { name: name.into(), cells: [0, 1], corners, slack: 0.0 }
    };
    let along = |name: &str, z: f64| window(name, [[1.0, 1.0, z], [2.0, 1.0, z], [2.0, 2.0, z], [1.0, 2.0, z]]);
    // The fourth one touches the first at a corner of the room, in another wall.
    let beside = window("east", [[4.0, 1.0, 0.0], [4.0, 2.0, 0.0], [4.0, 2.0, 1.0], [4.0, 1.0, 1.0]]);
    let wide = window("wide", [[1.5, 1.0, 0.0], [4.0, 1.0, 0.0], [4.0, 2.0, 0.0], [1.5, 2.0, 0.0]]);
    let portals = vec![along("south", 0.0), along("north", 4.0), beside, wide];
    let graph =
        CellGraph::new(vec![room("room", [0.0; 3], [4.0, 3.0, 4.0]), outdoors()], portals, &[]).expect("a room");
    let near = DVec3::new(1.75, 1.5, 0.0);
    assert_eq!(graph.overlaps(9), [Overlap { entries: [0, 3].map(CellEntry::Portal), near }]);
}

/// Rooms side by side, and what is in the first and in the last: its box meets all.
#[test]
fn what_goes_through_too_many_cells_is_in_all_that_its_box_meets() {
    let count = 600;
    let wide = f64::from(count);
    let rooms = |count: u32| {
        let room = |k: u32| room(&format!("{k}"), [f64::from(k), 0.0, 0.0], [f64::from(k) + 1.0, 3.0, 4.0]);
        (0..count).map(room).chain([outdoors()]).collect::<Vec<_>>()
    };
    let sails = |k: u32| {
        let sail = |x: f64| [[x, 1.0, 1.0], [x + 0.5, 1.0, 1.0], [x, 2.0, 2.0]];
        let corners = [sail(0.25), sail(wide - 0.75)].concat();
        let mesh = Mesh::new(corners, vec![[0, 1, 2], [3, 4, 5]]).expect("a mesh");
        Object::new(format!("{k}"), Shape::Mesh(Arc::new(mesh)), Placement::IDENTITY, Sides::Auto).expect("two sails")
    };
    let inside = |objects: u32| {
        let objects: Vec<Object> = (0..objects).map(sails).collect();
        let graph = CellGraph::new(rooms(count), Vec::new(), &objects).expect("rooms");
        (0..=count as usize).map(|cell| graph.objects_in(cell).len()).collect::<Vec<_>>()
    };
    let (few, many) = (inside(2), inside(600));
    assert!(many.iter().all(|&objects| objects == 600), "each is in all of them, and outdoors");
    assert_eq!([0, 300, 599, 600].map(|cell: usize| few[cell]), [2, 0, 2, 0], "the last is outdoors");
}

/// Boards along and across: each part between two of either kind is looked at by itself, so there are as many as the square of the boards.
#[test]
fn a_box_over_a_grid_of_cells_is_given_up() {
    let count = 300;
    let wide = f64::from(count);
    let along = (0..count).map(|k| {
        let at = f64::from(k);
        room(&format!("along {k}"), [at + 0.25, 0.0, 0.0], [at + 0.75, 1.0, wide])
    });
    let across = (0..count).map(|k| {
        let at = f64::from(k);
        room(&format!("across {k}"), [0.0, 0.0, at], [wide, 1.0, at + 1.0])
    });
    let cells: Vec<SceneCell> = along.chain(across).chain([outdoors()]).collect();
    let floor = cube("floor", [wide - 2.0, 0.5, wide - 2.0], [0.5 * wide, 0.5, 0.5 * wide]);
    let small = cube("small", [2.0, 0.5, 2.0], [0.5 * wide, 0.5, 0.5 * wide]);
    let graph = CellGraph::new(cells, Vec::new(), &[floor, small]).expect("cells");
    assert_eq!(graph.objects_in(2 * count as usize), [0], "the small one is seen to be inside");
}
