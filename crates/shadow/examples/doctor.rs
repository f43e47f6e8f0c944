//! A scene with three faults in it, and what they cost in square metres: a tent without floor, a rug laid twice, a lamp
//! inside a box.

use std::{error::Error, sync::Arc};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Cuboid, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{
    Detail, Silent,
    doctor::{Place, examine},
};

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    let scene = camp()?;
    let diagnosis = examine(&scene, &[0], Detail::default(), &Silent)?;
    println!("{} objects, {} flat faces of {:.2} m²", diagnosis.objects, diagnosis.faces, diagnosis.area);
    for total in diagnosis.totals() {
        let name = |place: &Place| match *place {
            Place::Object(object) => scene.objects[object].name.as_str(),
            Place::Light(light) => scene.lights[light].name.as_str(),
        };
        let places: Vec<&str> = total.places.iter().map(name).collect();
        println!("\n{}: {}, {:.3} m², at {}", total.kind.name(), total.count, total.area, places.join(", "));
        println!("  {}", total.kind.consequence());
    }
    Ok(())
}

fn camp() -> Result<Scene, Box<dyn Error>> {
    let corners = vec![[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 1.5, 0.0]];
    let tent = Mesh::new(corners, vec![[0, 4, 1], [1, 4, 2], [2, 4, 3], [3, 4, 0]])?;
    let rug = Shape::Rectangle(Rectangle { size: [2.0, 1.0] });
    let bodies = [
        ("tent", Shape::Mesh(Arc::new(tent)), DVec3::ZERO),
        ("rug", rug.clone(), DVec3::new(4.0, 0.0, 0.0)),
        ("rug again", rug, DVec3::new(4.5, 0.0, 0.0)),
        ("crate", Shape::Cuboid(Cuboid { size: [1.0; 3] }), DVec3::new(-4.0, 0.5, 0.0)),
    ];
    let placed = |(name, shape, at): (&str, Shape, DVec3)| -> Result<Object, Box<dyn Error>> {
        let placement = Placement::new(DAffine3::from_translation(at))?;
        Ok(Object::new(name.into(), shape, placement, Sides::Auto)?)
    };
    let lamp = Light::new("lamp", LightSource::point([-4.0, 0.6, 0.0])?);
    Ok(Scene {
        objects: bodies.into_iter().map(placed).collect::<Result<_, _>>()?,
        lights: vec![lamp],
        ..Scene::default()
    })
}
