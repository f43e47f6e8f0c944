//! Cells and portals by names and extras.

use umbriel_geometry::Placement;
use umbriel_scene::{CellGraph, Region, Scene, Sides};

use super::*;
use crate::ledger::Ledger;

/// Mesh 0 a plate in the plane x = 1 over y and z from 0 to 1, mesh 1 the cube from 0 to 1.
fn document(nodes: &Value) -> (Value, Data) {
    let mut data = Data::default();
    let plate = data.floats(&[[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]]);
    let corner = |i: u32, bit: u32| (i >> bit & 1) as f32;
    let cube: Vec<[f32; 3]> = (0..8).map(|i| [corner(i, 0), corner(i, 1), corner(i, 2)]).collect();
    let cube = data.floats(&cube);
    let index = |data: &mut Data, sides: &[[u8; 4]]| {
        let corners: Vec<u8> = sides.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
        data.add(&corners, 5121, "SCALAR", corners.len(), false)
    };
    let plate_index = index(&mut data, &[[0, 1, 2, 3]]);
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let cube_index = index(&mut data, &sides);
    let primitive = |positions: usize, indices: usize| json!({ "primitives": [{ "attributes": { "POSITION": positions }, "indices": indices }] });
    let meshes = [primitive(plate, plate_index), primitive(cube, cube_index)];
    (json!({ "asset": { "version": "2.0" }, "nodes": nodes, "meshes": meshes }), data)
}

fn scene(nodes: &Value) -> Result<Scene, LoadProblem> {
    parse(document(nodes))?.into_scene(glam::DAffine3::IDENTITY, Sides::Auto, &Ledger::default())
}

fn described(graph: &CellGraph) -> Vec<(&str, bool, usize)> {
    let cells = graph.cells().iter().enumerate();
    cells.map(|(n, cell)| (&*cell.name, cell.region == Region::Outdoors, graph.objects_in(n).len())).collect()
}

#[test]
fn nodes_are_cells_and_portals_by_name_or_extras() {
    let box_in = |x: f64| json!({ "name": "box", "mesh": 1, "translation": [x, 0.25, 0.25], "scale": [0.5, 0.5, 0.5] });
    let by_name = json!([
        { "name": "cell:one", "mesh": 1 }, { "name": "cell:other", "mesh": 1, "translation": [1, 0, 0] },
        { "name": "cell:garden" }, { "name": "portal:one|other", "mesh": 0 },
        { "name": "portal:garden|other", "mesh": 0, "translation": [1, 0, 0] }, box_in(0.25), box_in(0.75),
    ]);
    let by_extras = json!([
        { "name": "one", "mesh": 1, "extras": { "cell": true } },
        { "name": "other", "mesh": 1, "translation": [1, 0, 0], "extras": { "cell": true, "remark": [1, null] } },
        { "name": "garden", "extras": { "cell": true } },
        { "name": "door", "mesh": 0, "extras": { "portal": ["one", "other"] } },
        { "mesh": 0, "translation": [1, 0, 0], "extras": { "portal": ["garden", "other"] } }, box_in(0.25), box_in(0.75),
    ]);
    for nodes in [by_name, by_extras] {
        let scene = scene(&nodes).expect("two rooms");
        assert_eq!(scene.objects.len(), 2, "cells and portals are no objects");
        assert_eq!(described(&scene.cells), [("one", false, 2), ("other", false, 1), ("garden", true, 0)]);
        assert_eq!(scene.cells.portals().len(), 2);
        assert_eq!(scene.cells.portals_of(1), [0, 1]);
    }
    let plain = scene(&json!([{ "name": "a", "mesh": 1, "extras": { "cell": 7, "portal": "x" } }])).expect("a box");
    assert!(plain.cells.is_empty() && plain.objects.len() == 1, "other extras mean nothing here");
}

#[test]
fn what_extras_state_and_is_no_cell_is_refused_with_its_node() {
    let refused = |nodes: Value| scene(&nodes).expect_err("a defect").to_string();
    let with_box = |node: Value| json!([{ "name": "box", "mesh": 1 }, { "name": "cell:a", "mesh": 1 }, node]);
    let cell = |name: &str, mesh: u32| json!({ "name": name, "mesh": mesh, "extras": { "cell": true } });
    let portal = |one: &str, other: &str| json!({ "mesh": 0, "extras": { "portal": [one, other] } });
    let mut bare = portal("a", "b");
    bare.as_object_mut().expect("a node").remove("mesh");
    for (node, parts) in [
        (cell("flat", 0), &["node 2", "cell \"flat\"", "flat"][..]),
        (portal("a", "b"), &["node 2", "no cell \"b\""]),
        (portal("a", "a"), &["node 2", "two different cells"]),
        (bare, &["node 2", "flat mesh"]),
    ] {
        let message = refused(with_box(node));
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    }
    let twice = json!([{ "name": "box", "mesh": 1 }, cell("a", 1), cell("a", 1)]);
    let twice = refused(twice);
    assert!(twice.contains("node 2") && twice.contains("another cell"), "{twice}");
}

#[test]
fn names_alone_refuse_no_file() {
    let with_box = |node: Value| json!([{ "name": "box", "mesh": 1 }, { "name": "cell:a", "mesh": 1 }, node]);
    for (node, fault) in [
        (
            json!({ "name": "cell:3", "mesh": 0 }),
            "node 2 (\"cell:3\"): it is no cell or portal: its mesh is no convex body",
        ),
        (json!({ "name": "cell:a", "mesh": 1 }), "another cell has this name"),
        (json!({ "name": "cell:b", "mesh": 1, "scale": [1, 1, 0] }), "singular"),
        (json!({ "name": "portal:a|b", "mesh": 0 }), "there is no cell \"b\""),
        (json!({ "name": "portal:a|a", "mesh": 0 }), "two different cells"),
        (json!({ "name": "portal:main", "mesh": 0 }), "portal:ONE|OTHER"),
        (json!({ "mesh": 0, "extras": { "portal": ["a"] } }), "its extras name a portal without two cells"),
        (json!({ "mesh": 0, "extras": { "portal": [1, 2] } }), "its extras name a portal without two cells"),
    ] {
        let scene = scene(&with_box(node.clone())).unwrap_or_else(|problem| panic!("{node}: {problem}"));
        assert_eq!(scene.objects.len(), 2, "{node} is an object");
        assert_eq!((scene.cells.cells().len(), scene.cells.portals().len()), (1, 0));
        let told: Vec<_> = scene.findings.iter().map(|finding| &*finding.subject).collect();
        assert!(matches!(told[..], [told] if told.contains(fault)), "{told:?}");
    }
    // Without a mesh nothing is left of them; of two outdoors the first is one.
    for node in [json!({ "name": "portal:a|b" }), json!({ "name": "cell:second" })] {
        let scene = scene(&json!([{ "name": "box", "mesh": 1 }, { "name": "cell:first" }, node])).expect("a box");
        assert_eq!((scene.objects.len(), scene.cells.cells().len(), scene.findings.len()), (1, 1, 1));
    }
    // A portal in mid-air between two sound rooms, and one whose cell is none.
    let nodes = json!([
        { "name": "cell:one", "mesh": 1 }, { "name": "cell:other", "mesh": 1, "translation": [1, 0, 0] }, { "name": "cell:flat", "mesh": 0 },
        { "name": "portal:one|other", "mesh": 0, "translation": [0.5, 0, 0] }, { "name": "portal:one|flat", "mesh": 0 },
    ]);
    let scene = scene(&nodes).expect("two rooms");
    assert_eq!((scene.objects.len(), scene.cells.cells().len(), scene.cells.portals().len()), (3, 2, 0));
    let told: Vec<_> = scene.findings.iter().map(|finding| &*finding.subject).collect();
    assert!(told[1].contains("corner") && told[2].contains("no cell \"flat\""), "{told:?}");
}

#[test]
fn many_names_that_mean_something_else_are_objects() {
    let nodes: Vec<_> = (0..200).map(|number| json!({ "name": format!("cell:{number}"), "mesh": 0 })).collect();
    let scene = scene(&nodes.into()).expect("plates");
    assert_eq!((scene.objects.len(), scene.findings.len()), (200, 200));
    let unseen = scene.findings.iter().filter(|finding| finding.subject.contains("so many others"));
    assert_eq!(unseen.count(), 136);
}

#[test]
fn a_placement_moves_cells_as_it_moves_objects() {
    let nodes = json!([{ "name": "house", "translation": [8, 0, 0], "children": [1, 2] },
        { "name": "cell:a", "mesh": 1 }, { "name": "box", "mesh": 1, "scale": [0.5, 0.5, 0.5] }]);
    let scene = scene(&nodes).expect("a house");
    assert_eq!(scene.cells.objects_in(0), [0]);
    let bounds = scene.objects[0].bounds();
    assert!(scene.objects[0].placement != Placement::IDENTITY && bounds.min.x == 8.0);
}

#[test]
fn rooms_that_were_turned_before_they_were_written_fit() {
    // Two boxes that share a wall, and a door in it, turned and moved in f64, then rounded to f32.
    let (corners, door) = (
        [[0.0, 0.0, 0.0], [4.0, 3.0, 5.0], [4.0, 0.0, 0.0], [8.0, 3.0, 5.0]],
        [[0.5, 1.0], [0.5, 2.0], [2.0, 2.0], [2.0, 1.0]],
    );
    let sides = [[0_u8, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices =
        |quads: &[[u8; 4]]| -> Vec<u8> { quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect() };
    for (angle, tilt, step) in [
        (0.3, 0.0, 0.0),
        (0.5, 0.1, 100.0),
        (std::f64::consts::FRAC_PI_4, 0.7, -30.0),
        (1.1, 0.0, 1000.0),
        (2.9, 0.4, 0.0),
    ] {
        for off in [0.0, 0.01] {
            let turn = glam::DQuat::from_euler(glam::EulerRot::YXZ, angle, tilt, 0.0);
            let placed =
                |point: [f64; 3]| (turn * glam::DVec3::from(point) + glam::DVec3::splat(step)).as_vec3().to_array();
            let mut data = Data::default();
            let mut meshes = Vec::new();
            let mut add = |points: Vec<[f32; 3]>, quads: &[[u8; 4]]| {
                let (positions, list) = (data.floats(&points), indices(quads));
                let list = data.add(&list, 5121, "SCALAR", list.len(), false);
                meshes.push(json!({ "primitives": [{ "attributes": { "POSITION": positions }, "indices": list }] }));
            };
            for ends in corners.chunks(2) {
                let corner = |i: usize| placed([ends[i & 1][0], ends[i >> 1 & 1][1], ends[i >> 2 & 1][2]]);
                add((0..8).map(corner).collect(), &sides);
            }
            add(door.map(|[y, z]| placed([4.0 + off, y, z])).to_vec(), &[[0, 1, 2, 3]]);
            let nodes = json!([{ "name": "cell:a", "mesh": 0 }, { "name": "cell:b", "mesh": 1 }, { "name": "portal:a|b", "mesh": 2 }, { "name": "block", "mesh": 0 }]);
            let document = (json!({ "asset": { "version": "2.0" }, "nodes": nodes, "meshes": meshes }), data);
            let scene = parse(document)
                .and_then(|model| model.into_scene(glam::DAffine3::IDENTITY, Sides::Auto, &Ledger::default()));
            let scene = scene.unwrap_or_else(|problem| panic!("{angle}: {problem}"));
            match scene.cells.portals() {
                [door] => {
                    assert_eq!(off, 0.0, "a door in mid-air, {angle}");
                    assert!(door.slack > 0.0 && door.slack <= (9.0 + step.abs()) * 2.0_f64.powi(-20), "{}", door.slack);
                }
                _ => assert!(
                    off > 0.0 && scene.findings[0].subject.contains("boundary"),
                    "{angle}: {:?}",
                    scene.findings
                ),
            }
        }
    }
}
