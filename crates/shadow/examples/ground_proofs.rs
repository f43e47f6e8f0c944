//! Proofs on the ground of a generated city, by the borders of shadows and by a quadtree.
//!
//! `cargo run --release -p umbriel-shadow --example ground_proofs [BUILDINGS_ALONG_AN_EDGE [BOUNDARY_DEPTH [METHODS]]]`,
//! METHODS 1 for borders alone

#![expect(clippy::print_stdout, reason = "an example shows its results")]

use std::{sync::Arc, time::Instant};

use umbriel_geometry::{Cuboid, LightSource, Mesh, MeshDefect, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{CellMethod, Detail, Request, Silent, bake};

/// Buildings of different heights on a grid of streets, 20 m apart, as one mesh.
fn buildings(along: usize) -> Result<Mesh, MeshDefect> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for number in 0..along * along {
        // Any numbers that look irregular.
        let pick = |step: usize| (number * step % 997) as f64 / 997.0;
        let low =
            [(number % along) as f64 * 20.0 + pick(389) * 2.0, 0.0, (number / along) as f64 * 20.0 + pick(577) * 2.0];
        let size = [8.0 + 9.0 * pick(211), 5.0 + 40.0 * pick(739).powi(3), 8.0 + 9.0 * pick(83)];
        let first = positions.len() as u32;
        positions.extend(
            (0..8).map(|i| std::array::from_fn::<f64, 3, _>(|k| low[k] + if i >> k & 1 == 0 { 0.0 } else { size[k] })),
        );
        let corners = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        triangles.extend(Cuboid::FACES.iter().flat_map(|&face| corners(face.map(|corner| first + corner))));
    }
    Mesh::new(positions, triangles)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut numbers = std::env::args().skip(1).map(|text| text.parse::<usize>());
    let along = numbers.next().transpose()?.unwrap_or(30);
    let depth = numbers.next().transpose()?.unwrap_or(10) as u8;
    let methods = numbers.next().transpose()?.unwrap_or(2);
    let edge = along as f64 * 20.0;
    let middle = glam::DAffine3::from_translation(glam::DVec3::new(edge / 2.0, 0.0, edge / 2.0));
    let ground = Shape::Rectangle(Rectangle { size: [edge + 100.0; 2] });
    let city = Shape::Mesh(Arc::new(buildings(along)?));
    let lamp = [edge * 0.4, 80.0, edge * 0.45];
    let scene = Scene {
        objects: [
            Object::new("ground".into(), ground, Placement::new(middle)?, Sides::Auto)?,
            Object::new("city".into(), city, Placement::IDENTITY, Sides::Auto)?,
        ]
        .into(),
        lights: vec![
            Light::new("sun", LightSource::sun([0.5, -0.9, 0.3])?),
            Light::new("lamp", LightSource::point(lamp)?),
        ],
        ..Scene::default()
    };
    for light in 0..scene.lights.len() {
        let name = &scene.lights[light].name;
        for method in [CellMethod::Borders, CellMethod::Quadtree].into_iter().take(methods) {
            let detail = Detail::Depth { interior: 0, boundary: depth };
            let request =
                Request { receivers: vec![0], lights: vec![light], method, ..Request::everything(&scene, detail) };
            let start = Instant::now();
            let report = bake(&scene, &request, &Silent)?;
            let seconds = start.elapsed().as_secs_f64();
            let object = &report.lights[0].objects[0];
            let share = 100.0 * object.undecided() / object.area;
            println!(
                "{name}, {method:?}: {:.1} ms, {share:.3} % undecided, lit {:.1} m²",
                seconds * 1e3,
                object.lit.estimate
            );
        }
    }
    Ok(())
}
