//! A small scene as characters, through a camera and from the sun. What a parallel camera in the sun's direction sees
//! is what the sun lights, so counted pixels measure the shadow of a ball, whose true area is known.

use std::error::Error;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, Placement, Rectangle};
use umbriel_scene::{Camera, Object, Projection, Scene, Shape, Sides};
use umbriel_visibility::{RayCaster, View};

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    let at = |x, y, z| Placement::new(DAffine3::from_translation(DVec3::new(x, y, z)));
    let bodies = [
        ("floor", Shape::Rectangle(Rectangle { size: [8.0, 8.0] }), at(0.0, 0.0, 0.0)?),
        ("ball", Shape::from(Analytic::Sphere { radius: 1.0 }), at(-2.0, 2.0, 0.0)?),
        ("cone", Shape::from(Analytic::Cone { radius: 1.0, height: 3.0 }), at(2.0, 1.5, 1.0)?),
    ];
    let object = |(name, shape, placement): (&str, _, _)| Object::new(name.into(), shape, placement, Sides::Auto);
    let scene = Scene { objects: bodies.into_iter().map(object).collect::<Result<_, _>>()?, ..Scene::default() };
    let caster = RayCaster::new(&scene);

    // Characters are about twice as high as wide.
    let wide = View::of(&scene, 72, 72);
    let picture = caster.picture(&wide);
    for row in picture.chunks(72).step_by(2) {
        let letter = |hit: &Option<umbriel_visibility::SurfaceHit>| hit.map_or(' ', |hit| ['.', 'O', 'A'][hit.object]);
        println!("{}", row.iter().map(letter).collect::<String>().trim_end());
    }

    // From straight above, 10 m by 10 m in the picture.
    let projection = Projection::Orthographic { height: 10.0 };
    let camera = Camera { eye: DVec3::Y * 20.0, target: DVec3::ZERO, up: DVec3::NEG_Z, projection };
    for edge in [50, 200, 800] {
        let seen = caster.coverage(&View { camera, width: edge, height: edge });
        let pixel = (10.0 / f64::from(edge)).powi(2);
        let areas: Vec<String> = seen.iter().map(|&pixels| format!("{:.4}", pixels as f64 * pixel)).collect();
        println!("{edge:>3} pixels across: floor, ball, cone seen from the noon sun, m²: {}", areas.join(", "));
    }
    let disk = std::f64::consts::PI;
    println!(
        "in truth:                                                     {:.4}, {disk:.4}, {disk:.4}",
        64.0 - 2.0 * disk
    );
    Ok(())
}
