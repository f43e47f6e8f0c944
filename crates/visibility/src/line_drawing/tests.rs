use std::sync::Arc;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Cuboid, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Camera, Object, Projection, Scene, Shape, Sides};

use super::*;

fn scene(shapes: Vec<(Shape, DVec3)>) -> Scene {
    let object = |(shape, at): (Shape, DVec3)| {
        let placement = Placement::new(DAffine3::from_translation(at)).expect("regular");
        Object::new("o".into(), shape, placement, Sides::Auto).expect("a body")
    };
    Scene { objects: shapes.into_iter().map(object).collect(), ..Default::default() }
}

fn cuboid(size: [f64; 3]) -> Shape {
    Shape::Cuboid(Cuboid { size })
}

/// Ten pixels a metre, the middle of the picture at the origin, seen along −direction in parallel.
fn view(direction: DVec3) -> View {
    let up = if direction.y.abs() > 0.9 { DVec3::NEG_Z } else { DVec3::Y };
    let projection = Projection::Orthographic { height: 20.0 };
    View {
        camera: Camera { eye: 50.0 * direction.normalize(), target: DVec3::ZERO, up, projection },
        width: 200,
        height: 200,
    }
}

fn length(drawing: &Drawing, ink: Ink) -> f64 {
    let of = |stroke: &Stroke| {
        let [[a, b], [c, d]] = stroke.ends;
        (c - a).hypot(d - b)
    };
    drawing.strokes.iter().filter(|stroke| stroke.ink == ink).map(of).sum()
}

fn drawn(scene: &Scene, view: &View) -> Drawing {
    draw_lines(scene, view, &LineOptions { keeps_hidden: true, ..LineOptions::default() }).expect("a drawing")
}

#[test]
fn a_cube_from_a_corner_shows_nine_edges_and_hides_three() {
    let cube = scene(vec![(cuboid([6.0; 3]), DVec3::ZERO)]);
    let drawing = drawn(&cube, &view(DVec3::ONE));
    // Seen along its diagonal, every edge is √(2/3) of its length.
    let edge = 60.0 * (2.0f64 / 3.0).sqrt();
    assert!((length(&drawing, Ink::Visible) - 9.0 * edge).abs() < 1e-9, "{}", length(&drawing, Ink::Visible));
    assert!((length(&drawing, Ink::Hidden) - 3.0 * edge).abs() < 1e-9);
}

#[test]
fn a_board_hides_what_is_behind_it() {
    // A board of 4 m × 8 m before a post that reaches 3 m out on either side of it.
    let objects = vec![(cuboid([4.0, 8.0, 1.0]), DVec3::ZERO), (cuboid([10.0, 1.0, 1.0]), DVec3::new(0.0, 0.0, -4.0))];
    let drawing = drawn(&scene(objects), &view(DVec3::Z));
    // Back edges lie exactly behind front ones, and do not count; edges along the view are points.
    let (board, post) = (2.0 * (40.0 + 80.0), 4.0 * 30.0 + 2.0 * 10.0);
    let visible = length(&drawing, Ink::Visible);
    assert!((visible - (board + post)).abs() < 1e-9, "{visible}");
}

#[test]
fn bodies_that_cross_have_a_line_where_they_do() {
    // A post through the middle of a floor, seen from 45 degrees above.
    let floor = Shape::Rectangle(Rectangle { size: [10.0, 10.0] });
    let objects = vec![(floor, DVec3::ZERO), (cuboid([2.0, 4.0, 2.0]), DVec3::ZERO)];
    let drawing = drawn(&scene(objects), &view(DVec3::new(0.0, 1.0, 1.0)));
    let shrink = 0.5f64.sqrt();
    // The floor's border; the post's top, its front edges above the floor, and the crossing with its front.
    let floor = 200.0 + 200.0 * shrink;
    let post = 2.0 * 20.0 + 2.0 * 20.0 * shrink + 2.0 * 20.0 * shrink + 20.0;
    let visible = length(&drawing, Ink::Visible);
    assert!((visible - (floor + post)).abs() < 1e-9, "{visible}");
}

#[test]
fn smooth_meshes_show_outlines_and_borders_only() {
    // An open fan around +z, bent by little: its creases are below the limit, its rim is a border.
    let count = 12u32;
    let rim = |k: u32| {
        let angle = f64::from(k) / f64::from(count) * std::f64::consts::TAU;
        [5.0 * angle.cos(), 5.0 * angle.sin(), 0.0]
    };
    let positions = std::iter::once([0.0, 0.0, 0.2]).chain((0..count).map(rim)).collect();
    let triangles = (0..count).map(|k| [0, 1 + k, 1 + (k + 1) % count]).collect();
    let fan = Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh")));
    let drawing = drawn(&scene(vec![(fan, DVec3::ZERO)]), &view(DVec3::Z));
    let chord = 100.0 * (std::f64::consts::PI / f64::from(count)).sin();
    assert!((length(&drawing, Ink::Visible) - f64::from(count) * chord).abs() < 1e-9);
    assert_eq!(length(&drawing, Ink::Hidden), 0.0);
}

#[test]
fn hatches_cover_the_shadow_and_nothing_else() {
    let objects = vec![
        (Shape::Rectangle(Rectangle { size: [16.0, 16.0] }), DVec3::ZERO),
        (Shape::Rectangle(Rectangle { size: [4.0, 4.0] }), DVec3::new(0.0, 3.0, 0.0)),
    ];
    let sun = LightSource::sun([1.0, -1.0, 0.0]).expect("a sun");
    let options = LineOptions { lights: vec![sun], hatch_spacing: 0.5, ..LineOptions::default() };
    let drawing = draw_lines(&scene(objects), &view(DVec3::Y), &options).expect("a drawing");
    // The shadow of the upper square lies 3 m to the east, 4 m × 4 m, and one of them is hidden below it.
    let area = length(&drawing, Ink::Shadow) * 0.5;
    assert!((area - 30.0 * 40.0).abs() < 0.02 * 30.0 * 40.0, "{area}");
    let is_inside = |[x, y]: [f64; 2]| (119.9..=150.1).contains(&x) && (79.9..=120.1).contains(&y);
    let outside =
        drawing.strokes.iter().filter(|stroke| stroke.ink == Ink::Shadow && !stroke.ends.into_iter().all(is_inside));
    assert_eq!(outside.collect::<Vec<_>>(), Vec::<&Stroke>::new());
}

#[test]
fn gaps_are_what_is_left() {
    assert_eq!(gaps(&[[0.2, 0.3], [0.5, 0.9]], [0.0, 0.8]), [[0.0, 0.2], [0.3, 0.5]]);
    assert_eq!(gaps(&[[0.0, 1.0]], [0.25, 0.5]), Vec::<[f64; 2]>::new());
    assert_eq!(gaps(&[], [0.25, 0.5]), [[0.25, 0.5]]);
}
