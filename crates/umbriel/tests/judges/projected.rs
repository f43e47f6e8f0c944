//! Segments looked up in projected octrees answer what the definition says: all fixtures' meshes against the oracle, under lights
//! that are in line with corners, edges and faces. `UMBRIEL_CASES` sets the number of segments.

use std::sync::Arc;

use crate::oracle::{Oracle, cases, dice::Dice, fixtures};
use glam::DVec3;
use umbriel_geometry::Mesh;
use umbriel_octree::{Layout, Numbering, Projection, ProjectionOptions, Viewpoint};
use umbriel_scene::Scene;

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
