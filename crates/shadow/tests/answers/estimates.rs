//! Estimates beside exact samples, where nothing proves what a body hides: a lamp on the surface of a body that is not convex, a surface without thickness.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Detail, Request, Sampling, Silent, bake};

/// A quadric cut to a box over a floor of 8 × 8 m, 2 m below the origin.
fn over_floor(matrix: [[f64; 4]; 4], within: [[f64; 3]; 2], light: LightSource) -> Scene {
    let body = Shape::from(Analytic::Quadric { matrix, within });
    let floor = Shape::Rectangle(Rectangle { size: [8.0; 2] });
    let object = |shape, y: f64| {
        let placement = Placement::new(DAffine3::from_translation(DVec3::new(0.0, y, 0.0))).expect("regular");
        Object::new("object".to_owned(), shape, placement, Sides::Auto).expect("an object")
    };
    Scene {
        objects: [object(floor, -2.0), object(body, 0.0)].into(),
        lights: vec![Light::new("light", light)],
        ..Scene::default()
    }
}

#[test]
fn estimates_agree_with_samples_where_nothing_is_proved() {
    let diagonal = |x: f64, y: f64, z: f64, w: f64| {
        [[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, z, 0.0], [0.0, 0.0, 0.0, w]]
    };
    let saddle = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, -0.5], [0.0, 0.0, -1.0, 0.0], [0.0, -0.5, 0.0, 0.0]];
    let wedges = [[0.0, 0.5, 0.0, 0.0], [0.5, 1.0, 0.0, 0.0], [0.0; 4], [0.0; 4]];
    let unit = [[-1.0; 3], [1.0; 3]];
    let lamp = |position: [f64; 3]| LightSource::point(position).expect("a lamp");
    let above = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
    let scenes = [
        (
            "all round a ball",
            over_floor(diagonal(-1.0, -1.0, -1.0, 1.0), [[-2.0, -1.5, -2.0], [2.0; 3]], lamp([0.0, 1.0, 0.0])),
        ),
        ("a hyperboloid", over_floor(diagonal(4.0, -3.0, 4.0, -1.0), unit, lamp([0.5, 0.0, 0.0]))),
        ("a saddle", over_floor(saddle, unit, lamp([0.0; 3]))),
        ("wedges with a flap", over_floor(wedges, [[-1.0, 0.0, -1.0], [1.0; 3]], lamp([0.0, 3.0, 0.0]))),
        ("a plane counted twice", over_floor(diagonal(0.0, 1.0, 0.0, 0.0), unit, above)),
    ];
    for (name, scene) in scenes {
        let detail = Detail::Depth { interior: 5, boundary: 5 };
        let request = Request { sampling: Some(Sampling::Count(4096)), ..Request::everything(&scene, detail) };
        let floor = bake(&scene, &request, &Silent).expect("nobody cancels").lights[0].objects[0].clone();
        let samples = floor.samples.expect("samples");
        let [estimate, share] = [floor.lit.estimate / floor.area, samples.lit as f64 / samples.samples as f64];
        assert!((estimate - share).abs() < 0.02, "{name}: {estimate}, by samples {share}");
    }
}

/// A square of 40 × 40 m over ten thousand specks of a square millimetre: these have a sample each, most of all samples, and no area to speak of.
#[test]
fn samples_count_by_the_area_they_stand_for() {
    let mut positions: Vec<[f64; 3]> =
        vec![[-20.0, 0.0, -20.0], [-20.0, 0.0, 20.0], [20.0, 0.0, 20.0], [20.0, 0.0, -20.0]];
    let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
    for k in 0..10_000u32 {
        let [x, z] = [f64::from(k % 100) / 10.0 - 5.0, f64::from(k / 100) / 10.0 - 5.0];
        let first = positions.len() as u32;
        positions.extend([[x, -1.0, z], [x, -1.0, z + 1e-3], [x + 2e-3, -1.0, z]]);
        triangles.push([first, first + 1, first + 2]);
    }
    let mesh = Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh")));
    let object = Object::new("object".to_owned(), mesh, Placement::IDENTITY, Sides::Two).expect("an object");
    let sun = LightSource::sun([0.2, -1.0, 0.1]).expect("a sun");
    let scene = Scene { objects: [object].into(), lights: vec![Light::new("sun", sun)], ..Scene::default() };
    for count in [100, 10_000] {
        let request = Request { sampling: Some(Sampling::Count(count)), ..Request::everything(&scene, Detail::Faces) };
        let report = bake(&scene, &request, &Silent).expect("nobody cancels").lights[0].objects[0].clone();
        let samples = report.samples.expect("samples");
        assert!(samples.samples - samples.lit == 10_000 && samples.lit > 0, "{samples:?}");
        assert!((report.lit.estimate - 1600.0).abs() < 1e-3, "{} m² of {}", report.lit.estimate, report.area);
    }
}
