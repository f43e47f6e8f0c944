//! Thousands of triangles that all lie over each other: the work stays within reach, and what is proved of cells is right.
//!
//! One test, in a program of its own, because decisions are counted for all of a program.

#![allow(clippy::print_stdout, reason = "figures are part of what these tests tell")]

mod judged;

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use umbriel_geometry::{LightSource, Mesh, Placement, decisions::Decisions};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Detail, ObjectReport, Report, Request, Silent, bake};

use judged::{dice, judged};

/// Triangles from one corner to places all over a cube.
fn fan(count: u32) -> Mesh {
    let mut dice = dice();
    let positions = (0..count + 2).map(|_| [dice(), dice(), dice()]).collect();
    let triangles = (1..=count).map(|k| [0, k, k + 1]).collect();
    Mesh::new(positions, triangles).expect("a fan")
}

/// Some fans, each of them moved a little from the one before.
fn fans(times: u32, count: u32, light: LightSource) -> Scene {
    let mesh = Arc::new(fan(count));
    let object = |k: u32| {
        let placement = Placement::new(DAffine3::from_translation([0.0, 0.125 * f64::from(k), 0.0].into()));
        let shape = Shape::Mesh(Arc::clone(&mesh));
        Object::new(format!("fan {k}"), shape, placement.expect("regular"), Sides::Two).expect("an object")
    };
    Scene { objects: (0..times).map(object).collect(), lights: vec![Light::new("light", light)], ..Scene::default() }
}

/// Objects of one triangle all over a cube: each a mesh of its own, or all of them one mesh, turned and moved.
fn triangles(count: u32, is_one_mesh: bool, light: LightSource) -> Scene {
    let mut dice = dice();
    let mut corners = || [[(); 3]; 3].map(|corner| corner.map(|()| dice()));
    let mesh = |corners: [[f64; 3]; 3]| Arc::new(Mesh::new(corners.to_vec(), vec![[0, 1, 2]]).expect("a triangle"));
    let one = mesh(corners());
    let object = |k: u32| {
        let (mesh, map) = if is_one_mesh {
            let [axis, angles, place] = corners().map(DVec3::from_array);
            let axis = (axis - DVec3::splat(0.5)).normalize_or(DVec3::X);
            (Arc::clone(&one), DAffine3::from_rotation_translation(DQuat::from_axis_angle(axis, 6.0 * angles.x), place))
        } else {
            (mesh(corners()), DAffine3::IDENTITY)
        };
        let placement = Placement::new(map).expect("regular");
        Object::new(format!("{k}"), Shape::Mesh(mesh), placement, Sides::Two).expect("an object")
    };
    Scene { objects: (0..count).map(object).collect(), lights: vec![Light::new("light", light)], ..Scene::default() }
}

fn answers(scene: &Scene) -> Report {
    let detail = Detail::Depth { interior: 3, boundary: 8 };
    let request = Request { keep_cells: true, ..Request::everything(scene, detail) };
    bake(scene, &request, &Silent).expect("nobody cancels")
}

/// A mesh that is no longer alone is looked up otherwise, and the same is found.
fn a_second_instance_far_aside_changes_nothing(scene: &Scene, before: &Report) {
    let mut more = scene.clone();
    let aside = Placement::new(DAffine3::from_translation([64.0, 0.0, 64.0].into())).expect("regular");
    let shape = scene.objects[0].shape.clone();
    more.objects.push(Object::new("aside".to_owned(), shape, aside, Sides::Two).expect("an object"));
    let (before, after) = (&before.lights[0].objects, &answers(&more).lights[0].objects);
    assert!(before[..] == after[..before.len()]);
}

/// Beside eighty thousand triangles that nothing shadows all pairs are few; the crowd is one by itself then, and the same is proved of it.
fn a_sheet_far_aside_changes_nothing(scene: &Scene, before: &Report) {
    let corner = |k: u32| [64.0 + f64::from(k % 201) / 1024.0, 0.0, 64.0 + f64::from(k / 201) / 1024.0];
    let squares = (0..40_000).map(|k| k / 200 * 201 + k % 200);
    let triangles = squares.flat_map(|k| [[k, k + 201, k + 1], [k + 1, k + 201, k + 202]]).collect();
    let sheet = Mesh::new((0..201 * 201).map(corner).collect(), triangles).expect("a sheet");
    let mut more = scene.clone();
    let shape = Shape::Mesh(Arc::new(sheet));
    more.objects.push(Object::new("sheet".to_owned(), shape, Placement::IDENTITY, Sides::Two).expect("an object"));
    let (before, after) = (&before.lights[0].objects, &answers(&more).lights[0].objects);
    assert!(before[..] == after[..before.len()]);
}

/// Triangles from the last to the first, each begun with its second corner; `map` after the placement.
fn turned(object: &Object, map: DAffine3) -> Object {
    let Shape::Mesh(mesh) = &object.shape else { panic!("fans are meshes") };
    let positions = mesh.positions().iter().map(DVec3::to_array).collect();
    let triangles = mesh.triangles().iter().rev().map(|&[a, b, c]| [b, c, a]).collect();
    let shape = Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("the same triangles")));
    let placement = Placement::new(map * *object.placement.map()).expect("regular");
    Object::new(object.name.clone(), shape, placement, Sides::Two).expect("an object")
}

/// Objects, triangles, corners and axes in another order, an axis mirrored, and all larger by a power of two.
fn no_order_and_no_scale_changes_an_answer(scene: &Scene, before: &Report) {
    let matrix = 8.0 * DMat3::from_cols(DVec3::Z, -DVec3::Y, DVec3::X);
    let map = DAffine3::from_mat3(matrix);
    let xyz = matrix * scene.lights[0].source.xyz();
    let light = match scene.lights[0].source.is_sun() {
        true => LightSource::sun((-xyz).to_array()),
        false => LightSource::point(xyz.to_array()),
    };
    let lights = vec![Light::new("light", light.expect("a light"))];
    let objects = scene.objects.iter().rev().map(|object| turned(object, map)).collect();
    let mut after = answers(&Scene { objects, lights, ..Scene::default() });
    for (before, after) in before.lights[0].objects.iter().zip(after.lights[0].objects.iter_mut().rev()) {
        let last = scene.objects[before.object].face_count() as u32 - 1;
        for cell in &mut after.cells {
            (cell.face, cell.corner) = (last - cell.face, (cell.corner + 1) % 3);
        }
        after.cells.sort_by_key(|cell| cell.face);
        assert!(before.cells == after.cells, "object {}", before.object);
        let areas = |report: &ObjectReport| [report.area, report.lit.lower, report.lit.upper, report.lit.estimate];
        assert_eq!(areas(before).map(|area| 64.0 * area), areas(after), "object {}", before.object);
    }
}

#[test]
fn the_square_of_the_input_is_not_measured_and_proofs_are_right() {
    let sun = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
    let lamp = LightSource::point([0.5, 4.0, 0.25]).expect("a lamp");
    let [whole, twice] = [(1, 4000, sun), (2, 2500, lamp)].map(|(times, count, light)| fans(times, count, light));
    let [own, shared] = [(false, sun), (true, lamp)].map(|(is_one_mesh, light)| triangles(6000, is_one_mesh, light));
    for scene in [whole, twice, own, shared] {
        let before = Decisions::of_process().all();
        let report = answers(&scene);
        let decisions = Decisions::of_process().all() - before;
        let faces: u64 = scene.objects.iter().map(|object| object.face_count() as u64).sum();
        // Each face measured against what is over it would take seven decisions a pair.
        assert!(decisions < faces * faces, "{decisions} decisions for {faces} faces");
        let area: f64 = report.lights[0].objects.iter().map(|receiver| receiver.area).sum();
        let undecided: f64 = report.lights[0].objects.iter().map(|receiver| receiver.undecided()).sum();
        println!("{faces} faces, {decisions} decisions, {:.2} undecided", undecided / area);
        assert!(report.work.objects_crowded > 0 || undecided < 0.05 * area, "what stays undecided is told");
        // Smaller triangles cover fewer cells.
        let mean = area / faces as f64;
        assert!(
            undecided < if mean > 1.0 / 32.0 { 0.5 } else { 0.75 } * area,
            "{undecided} m² of {area} m², {mean} m² a face"
        );
        let [_, shadowed, _] = judged(&scene, &report, 251);
        assert!(shadowed > 100, "{shadowed} cells looked at");
        no_order_and_no_scale_changes_an_answer(&scene, &report);
        if scene.objects.len() == 1 {
            a_second_instance_far_aside_changes_nothing(&scene, &report);
            a_sheet_far_aside_changes_nothing(&scene, &report);
        }
    }
}
