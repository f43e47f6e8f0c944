//! A ball over a floor under the sun: how much of the floor is lit, with bounds.

#![expect(clippy::print_stdout, reason = "an example shows its results")]

use std::error::Error;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, LightSource, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Detail, Request, Silent, bake};

fn main() -> Result<(), Box<dyn Error>> {
    let floor = Shape::Rectangle(Rectangle { size: [10.0, 10.0] });
    let ball = Shape::from(Analytic::Sphere { radius: 1.0 });
    let above = Placement::new(DAffine3::from_translation(DVec3::new(0.0, 2.0, 0.0)))?;
    let scene = Scene {
        objects: [
            Object::new("floor".into(), floor, Placement::IDENTITY, Sides::Auto)?,
            Object::new("ball".into(), ball, above, Sides::Auto)?,
        ]
        .into(),
        lights: vec![Light::new("sun", LightSource::sun([0.5, -1.0, 0.0])?)],
        ..Scene::default()
    };
    for boundary in [4, 6, 8, 10] {
        let report = bake(&scene, &Request::everything(&scene, Detail::Depth { interior: 4, boundary }), &Silent)?;
        for object in &report.lights[0].objects {
            let name = &scene.objects[object.object].name;
            println!(
                "depth {boundary}, {name}: lit {:.5}..{:.5} of {:.5} m², about {:.5}",
                object.lit.lower, object.lit.upper, object.area, object.lit.estimate
            );
        }
    }
    Ok(())
}
