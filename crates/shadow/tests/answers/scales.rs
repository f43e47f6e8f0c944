//! The same scene in any unit has the same lit samples: parts of the work are done in 32 bits, whose range ends at 2^±126.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Detail, Request, Sampling, Silent, bake};

/// A tetrahedron over a floor, wound so that its inner sides can be lit: its own faces hide each other.
fn scene(scale: f64, light: DVec3, is_sun: bool) -> Scene {
    let corners = [[-0.3, 1.5, 0.1], [0.2, 0.25, 1.5], [-0.5, 0.6, 1.2], [-0.125, 1.4, 0.7]];
    let corners = corners.map(|corner| corner.map(|x: f64| x * scale)).to_vec();
    let solid = Mesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).expect("a mesh");
    let object = |name: &str, shape: Shape| {
        let placement = Placement::new(DAffine3::IDENTITY).expect("regular");
        Object::new(name.into(), shape, placement, Sides::Auto).expect("an object")
    };
    let source =
        if is_sun { LightSource::sun((-light).to_array()) } else { LightSource::point((light * scale).to_array()) };
    Scene {
        objects: [
            object("floor", Shape::Rectangle(Rectangle { size: [3.0 * scale; 2] })),
            object("solid", Shape::Mesh(Arc::new(solid))),
        ]
        .into(),
        lights: vec![Light::new("light", source.expect("a light"))],
        ..Scene::default()
    }
}

/// Lit samples of each object.
fn lit(scene: &Scene) -> Vec<u64> {
    let request = Request { sampling: Some(Sampling::Count(4000)), ..Request::everything(scene, Detail::Faces) };
    let report = bake(scene, &request, &Silent).expect("nobody cancels");
    report.lights[0].objects.iter().map(|object| object.samples.expect("samples").lit).collect()
}

#[test]
fn samples_are_the_same_in_any_unit() {
    for light in [DVec3::new(1.3, 4.4, 1.6), DVec3::new(-2.5, 3.9, 2.4)] {
        for is_sun in [true, false] {
            let here = lit(&scene(1.0, light, is_sun));
            assert!(here[0] > 500, "{here:?}");
            for exponent in [-180, -150, -133, -100, 100, 133, 150, 180] {
                assert_eq!(
                    lit(&scene(2f64.powi(exponent), light, is_sun)),
                    here,
                    "2^{exponent}, {light}, sun {is_sun}"
                );
            }
        }
    }
}
