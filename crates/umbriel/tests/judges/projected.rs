//! Segments looked up in projected octrees answer what the definition says: all fixtures' meshes against the oracle, under lights
//! that are in line with corners, edges and faces, single segments and whole queries. `UMBRIEL_CASES` sets the number of segments.

use std::sync::Arc;

use crate::oracle::{Oracle, cases, dice::Dice, fixtures};
use glam::DVec3;
use umbriel_geometry::Mesh;
use umbriel_octree::{Layout, Numbering, Projection, ProjectionOptions, Viewpoint};
use umbriel_scene::Scene;
use umbriel_shadow::{Expected, Place, Points, Precision, Queries, SearchCosts, Silent};
use umbriel_visibility::Acceleration;

/// Segments under one light.
const A_LIGHT: u64 = 40;

/// The triangles of a scene as one mesh; boxes and rectangles are cut.
fn joined(scene: &Scene) -> Option<Mesh> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for facets in scene.objects.iter().filter_map(|object| object.facets()) {
        let first = positions.len() as u32;
        positions.extend(facets.positions().iter().map(|position| position.to_array()));
        let own = facets.triangles().unwrap_or_default();
        triangles.extend(own.iter().map(|triangle| triangle.map(|corner| corner + first)));
    }
    (!triangles.is_empty()).then(|| Mesh::new(positions, triangles).expect("placed numbers"))
}

#[test]
fn segments_to_a_viewpoint_agree_with_the_definition() {
    let scenes = fixtures::all();
    let meshes: Vec<_> = scenes.iter().filter_map(|(name, scene)| Some((name, joined(scene)?))).collect();
    assert!(!meshes.is_empty(), "some fixtures have triangles");
    let share = cases(6_000).div_ceil(meshes.len() as u64);
    let mut blocked = 0;
    for (name, mesh) in &meshes {
        let corners: Vec<[f64; 3]> = mesh.positions().iter().map(|position| position.to_array()).collect();
        let object = fixtures::object("all", fixtures::mesh(&corners, mesh.triangles()), fixtures::at(0.0, 0.0, 0.0));
        let oracle = Oracle::of_objects(std::slice::from_ref(&object));
        let mesh = Arc::new(mesh.clone());
        for case in 0..share / A_LIGHT + 1 {
            let mut dice = Dice::new("projected", case);
            let anywhere = dice.grid_point(16, 0.25);
            let light = fixtures::tricky_light(&mut dice, anywhere, &corners);
            let options = ProjectionOptions {
                max_level: dice.below(7) as u8,
                leaf_items: 1 + dice.index(8),
                numbering: dice.pick(&[Numbering::FrontToBack, Numbering::Sections]),
                layout: dice.pick(&[Layout::OneMap, Layout::MapPerSection]),
                ..ProjectionOptions::default()
            };
            let viewpoint = Viewpoint::of_light(&light);
            let projection = Projection::build(Arc::clone(&mesh), viewpoint, &options).expect("a light");
            let mut descents = projection.segments_by_descent();
            for _ in 0..A_LIGHT {
                let x = match dice.below(3) {
                    0 => dice.grid_point(16, 0.25),
                    1 => dice.pick(&corners),
                    _ => dice.grid_point(40, 0.1).map(|x| dice.nudged(x)),
                };
                let truth = !oracle.lit_in_space(x, &light);
                let x = DVec3::from_array(x);
                assert_eq!(projection.any_hit(x), truth, "{name}: {x} under {light:?}, {options:?}");
                assert_eq!(descents.any_hit(x), truth, "{name}, descent: {x} under {light:?}, {options:?}");
                blocked += u64::from(truth);
            }
        }
    }
    assert!(blocked > 100, "{blocked}");
}

/// The ways that queries may be told to go.
const WAYS: [Acceleration; 3] = [Acceleration::Bvh, Acceleration::Octree, Acceleration::Projection];

#[test]
fn queries_answer_by_definition_whichever_way_they_look() {
    let scenes = fixtures::all();
    let share = cases(3_000).div_ceil(scenes.len() as u64);
    let (mut lit, mut asked) = (0, 0u64);
    for (name, scene) in &scenes {
        let (oracle, features) = (Oracle::new(scene), fixtures::features(scene));
        for case in 0..share / A_LIGHT + 1 {
            let mut dice = Dice::new("ways", case);
            let anywhere = dice.grid_point(16, 0.25);
            let light = fixtures::tricky_light(&mut dice, anywhere, &features);
            let direct = Queries::new(scene);
            let ways = WAYS.map(|way| {
                let mut queries = Queries::new(scene);
                queries.prepare(&light, Expected::Places(A_LIGHT), way, &SearchCosts::MEASURED);
                queries
            });
            for _ in 0..A_LIGHT {
                let object = dice.index(scene.objects.len());
                let is_mesh = fixtures::has_triangles(&scene.objects[object].shape);
                let (face, [u, v]) = (dice.index(scene.objects[object].face_count()), dice.parameters(is_mesh));
                let in_space = dice.grid_point(16, 0.25);
                let oriented =
                    Place::Oriented { position: in_space, normal: [0.0, 1.0, 0.0], precision: Precision::Double };
                for place in [Place::Surface { object, face, u, v }, Place::Free { position: in_space }, oriented] {
                    let truth = match place {
                        Place::Surface { .. } if !oracle.has_point(object, face, [u, v]) => continue,
                        Place::Surface { .. } => oracle.lit(object, face, [u, v], &light),
                        Place::Free { .. } => oracle.lit_in_space(in_space, &light),
                        // Either answer may be right where a surface is near: only the same one is asked for.
                        Place::Oriented { .. } => direct.lit(&place, &light).expect("a place").lit,
                    };
                    for (way, queries) in WAYS.iter().zip(&ways) {
                        let answer = queries.lit(&place, &light).expect("a place").lit;
                        assert_eq!(answer, truth, "{name}, {way:?}: {place:?} under {light:?}");
                    }
                    (lit, asked) = (lit + u64::from(truth), asked + 1);
                }
            }
        }
    }
    assert!(lit * 20 > asked && lit * 20 < 19 * asked, "{lit} of {asked}");
}

#[test]
fn many_points_and_moved_scenes_are_answered_alike() {
    for (name, scene) in &fixtures::all() {
        let mut dice = Dice::new("many ways", 0);
        let features = fixtures::features(scene);
        let anywhere = dice.grid_point(16, 0.25);
        let light = fixtures::tricky_light(&mut dice, anywhere, &features);
        let points: Vec<[f64; 3]> = (0..400).map(|_| dice.grid_point(40, 0.1)).collect();
        let lit = |queries: &Queries| queries.lit_many(Points::FreeDouble(&points), &light, &Silent).expect("points");
        // The last object is moved up by its own height.
        let mut moved = scene.clone();
        if let Some(object) = moved.objects.pop() {
            let lift = DVec3::Y * object.bounds().size().y.max(0.5);
            let map = glam::DAffine3::from_translation(lift) * object.placement.map();
            let placement = umbriel_geometry::Placement::new(map).expect("a place");
            moved.objects.push(
                umbriel_scene::Object::new(object.name.clone(), object.shape.clone(), placement, object.sides)
                    .expect("a body"),
            );
        }
        let (truth, truth_moved) = (lit(&Queries::new(scene)), lit(&Queries::new(&moved)));
        for way in WAYS {
            let (mut queries, mut after) = (Queries::new(scene), Queries::new(&moved));
            queries.prepare(&light, Expected::Loose(400), way, &SearchCosts::MEASURED);
            assert_eq!(lit(&queries), truth, "{name}, {way:?}");
            let renewals = after.prepare_after(&queries);
            assert_eq!(renewals.len(), usize::from(way != Acceleration::Bvh));
            assert_eq!(lit(&after), truth_moved, "{name}, {way:?}, moved: {renewals:?}");
        }
    }
}
