//! However rays find their triangles, the picture is the same, to the bit.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use umbriel_geometry::{Analytic, Mesh, Placement};
use umbriel_scene::{Camera, Object, Projection, Scene, Shape, Sides};
use umbriel_visibility::{Acceleration, CostModel, RayCaster, View};

/// Triangles of all sizes, many with common corners, some without area.
fn shreds(count: u32, seed: u64) -> Arc<Mesh> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f64 / (1u64 << 23) as f64 - 1.0
    };
    let positions: Vec<[f64; 3]> = (0..count).map(|_| [next(), next(), next()]).collect();
    let near = |n: u32, step: u32| (n + step * step) % count;
    let triangles = (0..count).map(|n| [n, near(n, 1), near(n, n % 5)]).collect();
    Arc::new(Mesh::new(positions, triangles).expect("numbers in range"))
}

fn scene() -> Scene {
    let meshes = [shreds(300, 1), shreds(40, 2)];
    let shear = DMat3::from_cols(DVec3::new(1.0, 0.3, 0.0), DVec3::new(0.0, 0.7, 0.1), DVec3::new(-0.2, 0.0, 1.3));
    let maps = [
        DAffine3::IDENTITY,
        DAffine3::from_mat3_translation(shear, DVec3::new(2.5, 0.0, -1.0)),
        DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)) * DAffine3::from_translation(DVec3::new(2.0, 0.0, 0.0)),
    ];
    let placed = maps.into_iter().flat_map(|map| meshes.iter().map(move |mesh| (Shape::Mesh(Arc::clone(mesh)), map)));
    let sphere = (Shape::from(Analytic::Sphere { radius: 0.5 }), DAffine3::from_translation(DVec3::Y));
    let objects = placed.chain([sphere]).enumerate().map(|(number, (shape, map))| {
        let placement = Placement::new(map).expect("regular");
        Object::new(format!("object {number}"), shape, placement, Sides::Auto).expect("a body")
    });
    Scene { objects: objects.collect(), ..Scene::default() }
}

#[test]
fn pictures_do_not_depend_on_the_acceleration() {
    let scene = scene();
    let mut caster = RayCaster::new(&scene);
    let eyes = [DVec3::new(3.0, 2.0, 6.0), DVec3::new(0.1, 0.2, 0.3)];
    let projections = [Projection::Perspective { vertical_degrees: 60.0 }, Projection::Orthographic { height: 5.0 }];
    let mut hits = 0;
    for (eye, projection) in eyes.into_iter().flat_map(|eye| projections.map(|projection| (eye, projection))) {
        let camera = Camera { eye, target: DVec3::new(0.2, 0.0, 0.0), up: DVec3::Y, projection };
        let view = View { camera, width: 96, height: 64 };
        caster.prepare(&view, 1, Acceleration::Bvh, &CostModel::MEASURED);
        let truth = caster.picture(&view);
        hits += truth.iter().flatten().count();
        for acceleration in [Acceleration::Octree, Acceleration::Projection, Acceleration::Auto] {
            let choices = caster.prepare(&view, 1, acceleration, &CostModel::MEASURED);
            assert_eq!(choices.len(), 6, "one for each mesh");
            let is_as_asked = acceleration == Acceleration::Auto || choices.iter().all(|c| c.chosen == acceleration);
            assert!(is_as_asked && choices.iter().all(|choice| choice.chosen != Acceleration::Auto));
            assert!(caster.picture(&view) == truth, "{acceleration:?} of {view:?}");
        }
        // Rays of other views find their way too.
        let aside = View { camera: Camera { eye: eye + DVec3::X, ..camera }, ..view };
        let prepared = caster.picture(&aside);
        caster.prepare(&aside, 1, Acceleration::Bvh, &CostModel::MEASURED);
        assert!(caster.picture(&aside) == prepared);
    }
    assert!(hits > 4_000, "{hits}");
}

#[test]
fn pictures_of_few_rays_ask_nobody() {
    let mut caster = RayCaster::new(&scene());
    // Samples of few rays are some tiles between the middle and the corners.
    let projection = Projection::Orthographic { height: 2.0 };
    let camera = Camera { eye: DVec3::new(3.0, 2.0, 6.0), target: DVec3::ZERO, up: DVec3::Y, projection };
    let mut sent = |width, rays_a_pixel| {
        let view = View { camera, width, height: 64 };
        let choices = caster.prepare(&view, rays_a_pixel, Acceleration::Auto, &CostModel::MEASURED);
        choices.iter().map(|choice| choice.sampled.sent).sum::<usize>()
    };
    assert_eq!([sent(64, 1), sent(32, 2)], [0, 0]);
    let many = [sent(65, 1), sent(33, 2)];
    assert!(many.iter().all(|&sent| sent > 0), "{many:?}");
}
