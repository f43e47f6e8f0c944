use std::sync::Arc;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, Brep, Cuboid, LightSource, Mesh, Placement, Point, Rectangle, decisions::Decisions};
use umbriel_scene::{Camera, CellGraph, Object, Projection, Region, Scene, SceneCell, Shape, Sides};

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
fn what_is_given_again_is_drawn_once() {
    let board = || (cuboid([4.0, 8.0, 1.0]), DVec3::ZERO);
    let post = (cuboid([10.0, 1.0, 1.0]), DVec3::new(0.0, 0.0, -4.0));
    let once = drawn(&scene(vec![board(), post.clone()]), &view(DVec3::Z));
    let again = drawn(&scene(vec![board(), post, board(), board()]), &view(DVec3::Z));
    assert_eq!(once.strokes, again.strokes);
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

#[test]
fn bodies_of_one_object_have_a_line_where_they_cross() {
    // Two boxes of 2 × 8 × 2 and 8 × 2 × 2 crossed, as two objects and as one mesh.
    let (one, other) = (Cuboid { size: [2.0, 8.0, 2.0] }, Cuboid { size: [8.0, 2.0, 4.0] });
    let both = scene(vec![(Shape::Cuboid(one), DVec3::ZERO), (Shape::Cuboid(other), DVec3::ZERO)]);
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for cuboid in [one, other] {
        let first = positions.len() as u32;
        positions.extend(cuboid.corners().map(|corner| corner.to_array()));
        for [a, b, c, d] in Cuboid::FACES.map(|face| face.map(|corner| corner + first)) {
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let mesh = Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh")));
    let view = view(DVec3::new(1.0, 2.0, 3.0));
    let [apart, together] =
        [both, scene(vec![(mesh, DVec3::ZERO)])].map(|scene| length(&drawn(&scene, &view), Ink::Visible));
    assert!((apart - together).abs() < 1e-9, "{apart}, {together}");
    let uncrossed = [one, other].map(|cuboid| scene(vec![(Shape::Cuboid(cuboid), DVec3::ZERO)]));
    assert!(uncrossed.iter().all(|scene| length(&drawn(scene, &view), Ink::Visible) < together));
}

fn ball(radius: f64) -> Shape {
    Shape::from(Analytic::Sphere { radius })
}

#[test]
fn a_ball_is_a_circle_and_hides_what_is_behind_it() {
    let alone = drawn(&scene(vec![(ball(4.0), DVec3::ZERO)]), &view(DVec3::new(1.0, 2.0, 3.0)));
    let circumference = std::f64::consts::TAU * 40.0;
    let visible = length(&alone, Ink::Visible);
    assert!((visible - circumference).abs() < 0.005 * circumference, "{visible}, should be {circumference}");
    for stroke in alone.strokes.iter().filter(|stroke| stroke.ink == Ink::Visible) {
        let off = stroke.ends.map(|[x, y]| ((x - 100.0).hypot(y - 100.0) - 40.0).abs());
        assert!(off.iter().all(|&off| off <= 0.25), "{stroke:?}");
    }
    // A cube wholly behind it, and one beside.
    let hidden = drawn(&scene(vec![(ball(4.0), DVec3::ZERO), (cuboid([2.0; 3]), DVec3::Z * -8.0)]), &view(DVec3::Z));
    let seen = length(&hidden, Ink::Visible);
    assert!((seen - circumference).abs() < 0.005 * circumference, "{seen}");
    let beside = drawn(&scene(vec![(ball(4.0), DVec3::ZERO), (cuboid([2.0; 3]), DVec3::X * 8.0)]), &view(DVec3::Z));
    assert!((length(&beside, Ink::Visible) - circumference - 80.0).abs() < 1.5);
}

#[test]
fn rims_of_curved_bodies_are_drawn_and_their_facets_are_not() {
    // From the side a cylinder is a rectangle, a cone a triangle; from above a disk is a circle.
    let side = view(DVec3::Z);
    let of = |body: Analytic, view: &View| {
        length(&drawn(&scene(vec![(Shape::from(body), DVec3::ZERO)]), view), Ink::Visible)
    };
    // Front and back of a rim lie on each other, and only the front is visible.
    let cylinder = of(Analytic::Cylinder { radius: 3.0, height: 4.0 }, &side);
    assert!((cylinder - 200.0).abs() < 2.0, "{cylinder}");
    let cone = of(Analytic::Cone { radius: 3.0, height: 4.0 }, &side);
    assert!((cone - 160.0).abs() < 2.0, "{cone}");
    let disk = of(Analytic::Disk { radius: 3.0 }, &view(DVec3::Y));
    assert!((disk - std::f64::consts::TAU * 30.0).abs() < 1.0, "{disk}");
    let hyperboloid = of(Analytic::Hyperboloid { waist_radius: 1.0, end_radius: 3.0, height: 6.0 }, &side);
    // Two rims of 60, two branches of r = cosh t from −acosh 3 to acosh 3.
    let branch: f64 = (0..10_000)
        .map(|k| {
            let at = |k: i32| {
                let y = -3.0 + 6.0 * f64::from(k) / 10_000.0;
                DVec3::new((1.0 + 8.0 * (y / 3.0).powi(2)).sqrt(), y, 0.0)
            };
            (at(k + 1) - at(k)).length()
        })
        .sum();
    assert!((hyperboloid - 120.0 - 20.0 * branch).abs() < 5.0, "{hyperboloid}, {branch}");
    let quadric = ANY_QUADRIC;
    assert!(
        curved::flattened(
            &Object::new("quadric".into(), Shape::from(quadric), Placement::IDENTITY, Sides::Auto).expect("a body"),
            &Projector::new(&side).expect("a view")
        )
        .is_none()
    );
}

#[test]
fn sharp_tips_of_curved_bodies_have_no_edges() {
    // Slim bodies from above: the outline, or the rim, is a circle, whatever the tip in its middle bends.
    let above = view(DVec3::Y);
    let circle = std::f64::consts::TAU * 10.0;
    for body in [
        Analytic::Ellipsoid { radii: [1.0, 8.0, 1.0] },
        Analytic::Ellipsoid { radii: [1.0, 0.05, 1.0] },
        Analytic::Paraboloid { radius: 1.0, height: 8.0 },
        Analytic::Cone { radius: 1.0, height: 8.0 },
    ] {
        let visible = length(&drawn(&scene(vec![(Shape::from(body), DVec3::ZERO)]), &above), Ink::Visible);
        assert!((visible - circle).abs() < 0.01 * circle, "{body:?}: {visible}, should be {circle}");
    }
    // Rims are drawn where they hardly bend: a flat frustum, with circles of 10 and of 5 pixels.
    let flat = Analytic::Frustum { bottom_radius: 1.0, top_radius: 0.5, height: 0.05 };
    let visible = length(&drawn(&scene(vec![(Shape::from(flat), DVec3::ZERO)]), &above), Ink::Visible);
    assert!((visible - 1.5 * circle).abs() < 0.015 * circle, "{visible}");
}

#[test]
fn a_ball_casts_a_hatched_shadow_with_an_outline() {
    let objects = vec![(Shape::Rectangle(Rectangle { size: [16.0, 16.0] }), DVec3::ZERO), (ball(2.0), DVec3::Y * 3.0)];
    let sun = LightSource::sun([1.0, -1.0, 0.0]).expect("a sun");
    let options = LineOptions { lights: vec![sun], hatch_spacing: 0.5, ..LineOptions::default() };
    let drawing = draw_lines(&scene(objects), &view(DVec3::Y), &options).expect("a drawing");
    // An ellipse with half axes 2√2 and 2 about (3, 0); the ball, a circle about the origin, hides a part of it and has a dark half.
    let is_on_floor = |stroke: &&Stroke| stroke.ends.iter().all(|[x, y]| (x - 100.0).hypot(y - 100.0) > 20.5);
    let inside = |[x, y]: [f64; 2]| ((x - 130.0) / 28.284).powi(2) + ((y - 100.0) / 20.0).powi(2);
    let of = |ink: Ink| drawing.strokes.iter().filter(move |stroke| stroke.ink == ink).filter(is_on_floor);
    assert!(of(Ink::Shadow).count() > 50 && of(Ink::ShadowOutline).count() > 20);
    assert!(of(Ink::Shadow).flat_map(|stroke| stroke.ends).all(|end| inside(end) < 1.02));
    assert!(of(Ink::ShadowOutline).flat_map(|stroke| stroke.ends).all(|end| (inside(end) - 1.0).abs() < 0.05));
}

#[test]
fn hatches_are_equally_spaced_in_the_picture_near_and_far() {
    // A floor in the shade of a roof of the same size, seen flatly in perspective.
    let floor = Shape::Rectangle(Rectangle { size: [40.0, 200.0] });
    let objects = vec![(floor.clone(), DVec3::ZERO), (floor, DVec3::Y * 30.0)];
    let projection = Projection::Perspective { vertical_degrees: 50.0 };
    let camera =
        Camera { eye: DVec3::new(0.0, 3.0, 90.0), target: DVec3::new(0.0, 2.0, 0.0), up: DVec3::Y, projection };
    let noon = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
    for lights in [vec![noon], vec![noon; 3]] {
        let options = LineOptions { lights, hatch_spacing: 5.0, ..LineOptions::default() };
        let drawing = draw_lines(&scene(objects.clone()), &View { camera, width: 300, height: 200 }, &options)
            .expect("a drawing");
        let mut families = std::collections::BTreeSet::new();
        for stroke in drawing.strokes.iter().filter(|stroke| stroke.ink == Ink::Shadow) {
            let [[a, b], [c, d]] = stroke.ends;
            let (right, up) = (c - a, b - d);
            let family = (0..4).find(|&number| {
                let [x, y] = hatching::Hatch::of_light(number, 5.0).across;
                let place = |px: f64, py: f64| ((px - 150.0) * x + (100.0 - py) * y) / 5.0;
                (right * x + up * y).abs() < 1e-6 && (place(a, b) - place(a, b).round()).abs() < 1e-6
            });
            families.insert(family.expect("a line of a family"));
        }
        assert_eq!(families.len(), options.lights.len());
    }
}

#[test]
fn two_boards_shadows_have_outlines_inside_the_floor_only() {
    // The shadow of a square on the floor of two triangles: four edges, none along the diagonal or the border.
    let floor = Mesh::new(
        vec![[-8.0, 0.0, -8.0], [-8.0, 0.0, 8.0], [8.0, 0.0, 8.0], [8.0, 0.0, -8.0]],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let objects = vec![
        (Shape::Mesh(Arc::new(floor.expect("a floor"))), DVec3::ZERO),
        (Shape::Rectangle(Rectangle { size: [4.0, 4.0] }), DVec3::Y * 6.0),
    ];
    let sun = LightSource::sun([1.0, -1.0, 0.0]).expect("a sun");
    let drawing =
        draw_lines(&scene(objects), &view(DVec3::Y), &LineOptions { lights: vec![sun], ..LineOptions::default() });
    let outline = length(&drawing.expect("a drawing"), Ink::ShadowOutline);
    // From x = 4 to 8, the floor's border: three edges of 4 m.
    assert!((outline - 120.0).abs() < 1e-3, "{outline}");
}

#[test]
fn lights_hatch_what_they_reach_through_portals() {
    // A floor in one room, seen from above, and a lamp below its height in the next: its upper side is in shadow.
    let floor = Shape::Rectangle(Rectangle { size: [3.0, 3.0] });
    let mut scene = scene(vec![(floor, DVec3::new(2.0, 0.5, 2.0))]);
    let lamp = LightSource::point([6.0, 0.25, 2.0]).expect("a lamp");
    let options = LineOptions { lights: vec![lamp], ..LineOptions::default() };
    let hatched = |scene: &Scene| {
        let drawing = draw_lines(scene, &view(DVec3::Y), &options).expect("a drawing");
        assert!((length(&drawing, Ink::Visible) - 120.0).abs() < 1e-9);
        length(&drawing, Ink::Shadow)
    };
    assert!(hatched(&scene) > 100.0);
    // Rooms with no door between them.
    let room = |name: &str, west: f64| {
        let corner = |i: usize| DVec3::new([west, west + 4.0][i & 1], [0.0, 3.0][i >> 1 & 1], [0.0, 4.0][i >> 2 & 1]);
        let region = Region::Convex(Brep::hull((0..8).map(corner)).expect("a box"));
        SceneCell { name: name.into(), region, slack: 0.0 }
    };
    let cells = vec![room("west", 0.0), room("east", 4.0)];
    scene.cells = CellGraph::new(cells, Vec::new(), &scene.objects).expect("rooms");
    assert_eq!(hatched(&scene), 0.0);
}

/// What exact sums must have settled in part; on one thread, which counts for itself.
fn exactly<T: Send>(decide: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let (answer, decisions) = pool.install(|| {
        let before = Decisions::of_thread();
        (decide(), Decisions::of_thread() - before)
    });
    assert!(decisions.expansion > 0, "{decisions:?}");
    answer
}

fn triangle(corners: [DVec3; 3]) -> Facets {
    let mesh = Mesh::new(corners.map(|corner| corner.to_array()).to_vec(), vec![[0, 1, 2]]).expect("a mesh");
    Facets::of_mesh(Arc::new(mesh), &Placement::IDENTITY)
}

/// The float some places up or down.
fn beside(x: f64, places: i64) -> f64 {
    f64::from_bits(x.to_bits().wrapping_add_signed(places))
}

#[test]
fn a_line_behind_the_edge_of_a_face_is_hidden_exactly() {
    // The middle of the way from the eye to x is that of the edge ab, and a is the middle of the way to y: no difference rounds.
    let [a, b, x] = [[1.1, 1.7, 1.3], [1.9, 1.2, 1.6], [1.4, 1.5, 1.8]].map(DVec3::from_array);
    let face = triangle([a, b, DVec3::new(1.2, 1.1, 1.9)]);
    let hidden = |places: i64| {
        let mut eye = a + (b - x);
        let line = Line { ends: [x, a + (a - eye)].map(Point::exact), on: [None; 2] };
        eye.x = beside(eye.x, places);
        let eye = LightSource::point(eye.to_array()).expect("an eye");
        Hiders::new(&[(0, &face)], &eye, vec![0]).hidden(&line)
    };
    assert_eq!(exactly(|| hidden(0)), [[0.0, 1.0]], "closed at the edge");
    let beside = [hidden(1), hidden(-1)];
    assert!(beside[0].is_empty() != beside[1].is_empty(), "{beside:?}");
    assert!(beside.concat()[0][1] > 0.999, "{beside:?}");
}

#[test]
fn faces_that_stand_on_each_other_do_not_cross() {
    // Numbers of 45 digits, so that sums of some of them are floats: d and e are points of the face with corners p, p + 4s, p + 4t.
    let short = |x: f64| (x * 2f64.powi(44)).round() / 2f64.powi(44);
    for turn in 0..12 {
        let angle = 0.35 + f64::from(turn) * 0.7;
        let p = DVec3::new(1.1, 2.3, 0.7).map(short);
        let s = DVec3::new(angle.cos(), 0.3, angle.sin()).map(short);
        let t = DVec3::new(-angle.sin(), 0.1, angle.cos()).map(short);
        let floor = triangle([p, p + s * 4.0, p + t * 4.0]);
        let [d, e] = [p + s + t, p + s * 2.0 + t];
        let crossings = |places: i64| {
            let d = d.with_y(beside(d.y, places));
            let wall = triangle([d, e, d + DVec3::Y]);
            let (bodies, eye) = ([(0, &floor), (1, &wall)], LightSource::sun([0.0, -1.0, 0.0]).expect("a sun"));
            crossings::crossings(&Hiders::new(&bodies, &eye, vec![0, 1])).len()
        };
        assert_eq!(exactly(|| crossings(0)), 0, "{turn}: contact");
        assert_eq!([crossings(-1), crossings(1)], [1, 0], "{turn}: an ulp through it, an ulp off it");
    }
}

/// A ball, said in general.
const ANY_QUADRIC: Analytic = Analytic::Quadric {
    matrix: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, -1.0]],
    within: [[-1.0; 3], [1.0; 3]],
};
