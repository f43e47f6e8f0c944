//! Only what the question requires is built: counters and sizes that say so.

#![allow(clippy::print_stdout, reason = "figures are part of what these tests tell")]

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Cuboid, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Cell, Detail, Request, Silent, Work, bake};

fn placed(name: String, shape: Shape, at: DVec3) -> Object {
    let placement = Placement::new(DAffine3::from_translation(at)).expect("regular");
    Object::new(name, shape, placement, Sides::Auto).expect("an object")
}

fn cuboid(name: String, at: DVec3) -> Object {
    placed(name, Shape::Cuboid(Cuboid { size: [1.0; 3] }), at)
}

fn lit(objects: Vec<Object>) -> Scene {
    let sun = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
    Scene { objects: objects.into(), lights: vec![Light::new("sun", sun)], ..Scene::default() }
}

/// A floor with a hundred boxes over it, and `far` boxes that cannot shadow it.
fn with_far(far: u32) -> Scene {
    let mut objects = vec![placed("floor".into(), Shape::Rectangle(Rectangle { size: [40.0; 2] }), DVec3::ZERO)];
    let place =
        |k: u32, height: f64| DVec3::new(3.0 * f64::from(k % 10) - 15.0, height, 3.0 * f64::from(k / 10) - 15.0);
    objects.extend((0..100).map(|k| cuboid(format!("near {k}"), place(k, 1.5))));
    objects.extend((0..far).map(|k| cuboid(format!("far {k}"), place(k, 1.5) + DVec3::new(0.0, -100.0, 5000.0))));
    lit(objects)
}

#[test]
fn objects_without_influence_cost_their_boxes() {
    let (alone, crowded) = (with_far(0), with_far(10_000));
    let request = |scene: &Scene| Request {
        receivers: vec![0],
        ..Request::everything(scene, Detail::Depth { interior: 4, boundary: 10 })
    };
    let run = |scene: &Scene| bake(scene, &request(scene), &Silent).expect("nobody cancels");
    let (alone, crowded) = (run(&alone), run(&crowded));
    assert_eq!(crowded.lights[0].objects[0].lit, alone.lights[0].objects[0].lit);
    assert_eq!(crowded.work.cells, alone.work.cells, "the same cells are looked at");
    assert_eq!(crowded.work.octrees_built, 1);
    assert_eq!(crowded.work.pairs_registered, alone.work.pairs_registered);
    // The fine step does the same in both; what the others add to the coarse step, and to the time of some jobs, is told by the benchmark `idle`.
    let [boxes, fine] = [crowded.time.coarse, crowded.time.fine].map(|seconds| 1e3 * seconds);
    println!("beside 10,000 objects without influence: {boxes:.2} ms coarse, {fine:.2} ms fine");
    assert_eq!(crowded.work.rays, alone.work.rays);
    // Before any pair is tested they are left out, family by family or one by one.
    let looked_at = |work: &Work| work.pairs_tested + work.pairs_excluded;
    assert_eq!(looked_at(&crowded.work), looked_at(&alone.work));
}

#[test]
fn octrees_are_those_of_receivers_in_pairs() {
    // Three boxes in a row along the sun: the first one shadows the second; the third is far away.
    let along = DVec3::new(0.3, -1.0, 0.2);
    let objects =
        vec![cuboid("a".into(), DVec3::ZERO), cuboid("b".into(), 3.0 * along), cuboid("c".into(), DVec3::X * 50.0)];
    let scene = lit(objects);
    let report = bake(&scene, &Request::everything(&scene, Detail::Depth { interior: 0, boundary: 5 }), &Silent);
    let work = report.expect("nobody cancels").work;
    println!("{work:?}");
    assert_eq!(work.octrees_built, 1, "only b has a border of a shadow on it");
    let one = Request { receivers: vec![2], ..Request::everything(&scene, Detail::default()) };
    let work = bake(&scene, &one, &Silent).expect("nobody cancels").work;
    assert_eq!((work.octrees_built, work.rays), (0, 0), "nothing shadows c");
}

#[test]
fn stored_cells_are_small() {
    // A code is a face, a corner, a level and two coordinates; one byte is the verdict.
    let code = size_of::<(u32, u8, u8, u32, u32)>();
    println!("a cell takes {} bytes, its code {code}", size_of::<Cell>());
    assert!(size_of::<Cell>() <= code + 1);
    // And there is no room for cells that never came.
    let scene = with_far(0);
    let detail = Detail::Depth { interior: 8, boundary: 8 };
    let request = Request { keep_cells: true, ..Request::everything(&scene, detail) };
    let report = bake(&scene, &request, &Silent).expect("nobody cancels");
    let cells = report.lights.iter().flat_map(|light| &light.objects).map(|object| &object.cells);
    let [kept, room] = cells.fold([0; 2], |[kept, room], cells| [kept + cells.len(), room + cells.capacity()]);
    println!("{kept} cells in room for {room}: {} bytes each", (room * size_of::<Cell>()) as f64 / kept as f64);
    assert!(kept > 10_000 && room * size_of::<Cell>() <= kept * (code + 1));
}

#[test]
fn instances_share_one_mesh() {
    let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mesh = Arc::new(Mesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).expect("a mesh"));
    let at = |k: u32| DVec3::new(f64::from(k), 0.0, 0.0);
    let objects: Vec<Object> =
        (0..1000).map(|k| placed(format!("{k}"), Shape::Mesh(Arc::clone(&mesh)), at(k))).collect();
    let scene = lit(objects);
    assert_eq!(Arc::strong_count(&mesh), 1001);
    let copy = scene.clone();
    assert_eq!(Arc::strong_count(&mesh), 2001, "a copied scene copies no mesh");
    assert_eq!(copy.objects.len(), 1000);
}
