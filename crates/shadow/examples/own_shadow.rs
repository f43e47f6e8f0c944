//! Every body given by formulas under one sun: how much of its own surface is lit, with bounds, and how the middles of
//! its faces answer. A convex body shadows itself only by turning away; a hyperboloid also stands in its own light.

use std::error::Error;

use umbriel_geometry::{Analytic, LightSource, Placement};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Detail, Place, Queries, Request, Silent, bake};

const BODIES: [Analytic; 9] = [
    Analytic::Sphere { radius: 1.0 },
    Analytic::Ellipsoid { radii: [1.0, 0.5, 2.0] },
    Analytic::Cylinder { radius: 0.5, height: 2.0 },
    Analytic::Cone { radius: 1.0, height: 2.0 },
    Analytic::Frustum { bottom_radius: 1.0, top_radius: 0.5, height: 2.0 },
    Analytic::Capsule { radius: 0.5, height: 1.0 },
    Analytic::Paraboloid { radius: 1.0, height: 2.0 },
    Analytic::Hyperboloid { waist_radius: 0.5, end_radius: 1.0, height: 2.0 },
    Analytic::Disk { radius: 1.0 },
];

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    let sun = LightSource::sun([0.25, -1.0, 0.5])?;
    println!("body          surface   lit, m²               faces with their middles in the light");
    for body in BODIES {
        let object = Object::new(body.name().into(), Shape::from(body), Placement::IDENTITY, Sides::Auto)?;
        let lights = vec![Light::new("sun", sun)];
        let scene = Scene { objects: [object].into(), lights, ..Scene::default() };

        let detail = Detail::Depth { interior: 4, boundary: 7 };
        let report = bake(&scene, &Request::everything(&scene, detail), &Silent)?;
        let answer = &report.lights[0].objects[0];

        let queries = Queries::new(&scene);
        let mut in_light = Vec::new();
        for face in 0..scene.objects[0].face_count() {
            if queries.lit(&Place::Surface { object: 0, face, u: 0.5, v: 0.5 }, &sun)?.lit {
                in_light.push(face.to_string());
            }
        }
        let (lower, upper) = (answer.lit.lower, answer.lit.upper);
        println!("{:<12} {:>8.4}   {lower:>7.4} to {upper:>7.4}    {}", body.name(), answer.area, in_light.join(" "));
    }
    Ok(())
}
