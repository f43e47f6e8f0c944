//! Estimates beside exact samples, where nothing proves what a body hides: a lamp on the surface of a body that is not convex, a surface without thickness.

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, LightSource, Placement, Rectangle};
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
        objects: vec![object(floor, -2.0), object(body, 0.0)],
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
