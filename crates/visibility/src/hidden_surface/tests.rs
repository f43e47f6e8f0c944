use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use umbriel_geometry::{Analytic, Cuboid, Dyadic, Mesh, Placement, Rectangle, Ring, Sign, decisions::Decisions};
use umbriel_scene::{Camera, Object, Projection, Scene, Shape, Sides};

use super::*;
use crate::View;

fn object(shape: Shape, map: DAffine3) -> Object {
    let placement = Placement::new(map).expect("regular");
    Object::new("o".into(), shape, placement, Sides::Auto).expect("a body")
}

fn scene(objects: Vec<Object>) -> Scene {
    Scene { objects: objects.into(), ..Default::default() }
}

fn mesh(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Shape {
    Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh")))
}

/// A parallel camera over the plane z = 0 whose pixel centres are the integers from 0 to 7, in both directions.
fn over_lattice() -> View {
    let (eye, target) = (DVec3::new(3.5, 3.5, 8.0), DVec3::new(3.5, 3.5, 0.0));
    let camera = Camera { eye, target, up: DVec3::Y, projection: Projection::Orthographic { height: 8.0 } };
    View { camera, width: 8, height: 8 }
}

/// All methods, some with several window sizes.
fn methods(shot: &Shot) -> Vec<Box<dyn HiddenSurface>> {
    vec![
        Box::new(RayCasting::new(shot, RayTree::Boxes)),
        Box::new(RayCasting::new(shot, RayTree::Octree)),
        Box::new(DepthBuffer::default()),
        Box::new(DepthBuffer { tile: [u32::MAX, 1] }),
        Box::new(ScanLine::default()),
        Box::new(Warnock::default()),
        Box::new(Warnock { root: 7 }),
        Box::new(DepthSort::default()),
        Box::new(DepthSort { window: 64 }),
    ]
}

/// What all methods show; they must not differ in a pixel.
fn common_picture(scene: &Scene, view: &View) -> (Shot, FacePicture) {
    let shot = Shot::new(scene, view).expect("a shot");
    let methods = methods(&shot);
    let (first, _) = draw(methods[0].as_ref(), &shot);
    for method in &methods[1..] {
        let (picture, _) = draw(method.as_ref(), &shot);
        let pixels = (0..view.height).flat_map(|row| (0..view.width).map(move |column| [column, row]));
        let differing =
            pixels.filter(|&pixel| picture.seen(&shot, pixel) != first.seen(&shot, pixel)).collect::<Vec<_>>();
        let sample: Vec<_> =
            differing.iter().take(5).map(|&p| (p, first.seen(&shot, p), picture.seen(&shot, p))).collect();
        assert!(differing.is_empty(), "{}: {} pixels differ, {sample:?}", method.name(), differing.len());
    }
    (shot, first)
}

/// A ray through an edge, and one on which two faces are met at one depth: floats leave both open.
#[test]
fn what_footprints_and_floats_leave_open_is_told_exactly() {
    let triangle = |height: f64| {
        let corners = vec![[1.0, 1.0, 0.0], [5.0, 1.0, 0.0], [1.0, 5.0, height]];
        object(mesh(corners, vec![[0, 1, 2]]), DAffine3::IDENTITY)
    };
    let before = Decisions::of_thread();
    let (shot, picture) = common_picture(&scene(vec![triangle(0.0)]), &over_lattice());
    let edges = Decisions::of_thread() - before;
    assert!(edges.exact > 0, "{edges:?}");
    assert_eq!(picture.seen(&shot, [3, 4]).map(|seen| seen.object), Some(0), "on the slanted edge");
    // Both hold the edge from (1, 1) to (5, 1), and the second one is nearer everywhere else.
    let (shot, picture) = common_picture(&scene(vec![triangle(0.0), triangle(1.0)]), &over_lattice());
    let depths = Decisions::of_thread() - before - edges;
    assert!(depths.exact > edges.exact, "{depths:?}");
    assert_eq!(picture.seen(&shot, [3, 6]).map(|seen| seen.object), Some(0), "at one depth");
    assert_eq!(picture.seen(&shot, [2, 5]).map(|seen| seen.object), Some(1), "before it");
}

#[test]
fn edges_and_corners_belong_to_the_lower_face() {
    // Two triangles of a square whose corners, sides and diagonal run through pixel centres.
    let square =
        mesh(vec![[1.0, 1.0, 0.0], [5.0, 1.0, 0.0], [5.0, 5.0, 0.0], [1.0, 5.0, 0.0]], vec![[0, 1, 2], [0, 2, 3]]);
    let (shot, picture) = common_picture(&scene(vec![object(square, DAffine3::IDENTITY)]), &over_lattice());
    for row in 0..8 {
        for column in 0..8 {
            let (x, y) = (column, 7 - row);
            let inside = (1..=5).contains(&x) && (1..=5).contains(&y);
            let expected = inside.then_some(usize::from(y > x));
            assert_eq!(picture.seen(&shot, [column, row]).map(|seen| seen.face), expected, "at ({x}, {y})");
        }
    }
    let hit = picture.hit(&shot, [2, 3]).expect("the square");
    assert_eq!((hit.distance, hit.u, hit.v, hit.normal), (8.0, 0.25, 0.5, DVec3::Z));
}

#[test]
fn of_equal_depths_the_lower_object_is_seen() {
    let floor = |size| Shape::Rectangle(Rectangle { size: [size; 2] });
    let upright = DAffine3::from_translation(DVec3::new(3.0, 3.0, 0.0))
        * DAffine3::from_quat(DQuat::from_xyzw(1.0, 0.0, 0.0, 1.0).normalize());
    // The quarter turn is not exact; the planes of both are the same, whatever it is.
    let (shot, picture) =
        common_picture(&scene(vec![object(floor(2.0), upright), object(floor(6.0), upright)]), &over_lattice());
    let objects = |object| picture_of(&shot, &picture).filter(|seen| seen.object == object).count();
    assert_eq!((objects(0) + objects(1), objects(0) >= 1), (picture.covered(), true));
    let (shot, picture) =
        common_picture(&scene(vec![object(floor(6.0), upright), object(floor(2.0), upright)]), &over_lattice());
    assert!(picture_of(&shot, &picture).all(|seen| seen.object == 0));
}

fn picture_of<'a>(shot: &'a Shot, picture: &'a FacePicture) -> impl Iterator<Item = Seen> + 'a {
    let Window { right, bottom, .. } = *picture.window();
    (0..bottom).flat_map(move |row| (0..right).filter_map(move |column| picture.seen(shot, [column, row])))
}

#[test]
fn what_is_edge_on_behind_the_eye_or_in_its_plane_is_not_seen() {
    let upright = mesh(vec![[1.0, 1.0, 0.0], [5.0, 1.0, 0.0], [5.0, 1.0, 3.0]], vec![[0, 1, 2]]);
    let behind = mesh(vec![[1.0, 1.0, 9.0], [5.0, 1.0, 9.0], [5.0, 5.0, 9.0]], vec![[0, 1, 2]]);
    let level = mesh(vec![[1.0, 1.0, 8.0], [5.0, 1.0, 8.0], [5.0, 5.0, 8.0]], vec![[0, 1, 2]]);
    for shape in [upright, behind, level] {
        let (_, picture) = common_picture(&scene(vec![object(shape, DAffine3::IDENTITY)]), &over_lattice());
        assert_eq!(picture.covered(), 0);
    }
    // A face through the eye's plane is seen where it is ahead: for x up to 3, where its depth is below 8.
    let through =
        mesh(vec![[0.0, 0.0, 5.0], [7.0, 0.0, 12.0], [7.0, 7.0, 12.0], [0.0, 7.0, 5.0]], vec![[0, 1, 2], [0, 2, 3]]);
    let (_, picture) = common_picture(&scene(vec![object(through, DAffine3::IDENTITY)]), &over_lattice());
    assert_eq!(picture.covered(), 3 * 8);
}

#[test]
fn a_ball_is_as_round_as_its_formula() {
    let ball = Shape::from(Analytic::Sphere { radius: 3.0 });
    let at = DAffine3::from_translation(DVec3::new(3.0, 3.0, 0.0));
    let (shot, picture) = common_picture(&scene(vec![object(ball, at)]), &over_lattice());
    for row in 0..8u32 {
        for column in 0..8u32 {
            let (x, y) = (f64::from(column) - 3.0, 4.0 - f64::from(row));
            let hit = picture.hit(&shot, [column, row]);
            assert_eq!(hit.is_some(), x * x + y * y <= 9.0, "({x}, {y}): touching counts");
            if let Some(hit) = hit {
                assert!((hit.distance - (8.0 - (9.0 - x * x - y * y).sqrt())).abs() < 1e-12);
            }
        }
    }
}

/// Bodies that run through each other, stand on each other, share planes, edges and corners, in perspective.
fn tangle() -> Scene {
    let turned =
        |x, y, z, angle: f64| DAffine3::from_rotation_translation(DQuat::from_rotation_y(angle), DVec3::new(x, y, z));
    let cuboid = |size| Shape::Cuboid(Cuboid { size });
    let curved = |body: Analytic| Shape::from(body);
    let long = |turn: f64| {
        // One of three boards in a ring, each over the next.
        DAffine3::from_rotation_y(turn)
            * DAffine3::from_rotation_translation(DQuat::from_rotation_x(0.12), DVec3::new(1.6, 3.0, 0.0))
    };
    let third = std::f64::consts::TAU / 3.0;
    scene(vec![
        object(Shape::Rectangle(Rectangle { size: [12.0, 12.0] }), DAffine3::IDENTITY),
        object(cuboid([2.0, 2.0, 2.0]), turned(0.0, 1.0, 0.0, 0.0)),
        object(cuboid([2.0, 2.0, 2.0]), turned(0.5, 1.0, 0.5, 0.7)),
        object(cuboid([2.0, 1.0, 2.0]), turned(2.0, 0.5, 0.0, 0.0)),
        object(curved(Analytic::Sphere { radius: 1.2 }), turned(-2.0, 1.0, 1.0, 0.0)),
        object(curved(Analytic::Cone { radius: 1.0, height: 3.0 }), turned(-2.5, 1.5, 1.5, 0.0)),
        object(
            curved(Analytic::Hyperboloid { waist_radius: 0.3, end_radius: 0.8, height: 2.0 }),
            turned(3.0, 1.0, 3.0, 0.2),
        ),
        object(curved(Analytic::Capsule { radius: 0.4, height: 1.0 }), turned(-1.0, 0.8, 3.5, 0.2)),
        object(cuboid([0.6, 0.1, 6.0]), long(0.0)),
        object(cuboid([0.6, 0.1, 6.0]), long(third)),
        object(cuboid([0.6, 0.1, 6.0]), long(2.0 * third)),
    ])
}

#[test]
fn all_methods_agree_on_a_tangle_from_everywhere() {
    let scene = tangle();
    for (turn, elevation) in [(30.0, 35.0), (0.0, 0.0), (-100.0, 12.0), (180.0, 80.0)] {
        common_picture(&scene, &View::around(&scene, turn, elevation, 90, 70));
    }
    // From inside, and with the eye on faces and edges.
    for eye in [[0.0, 1.0, 0.3], [1.0, 1.5, 0.0], [1.0, 2.0, 1.0], [-2.0, 1.1, 1.0], [0.0, 0.0, 7.0]] {
        let camera = Camera {
            eye: DVec3::from_array(eye),
            target: DVec3::new(0.5, 0.75, -0.25),
            up: DVec3::Y,
            projection: Projection::Perspective { vertical_degrees: 70.0 },
        };
        common_picture(&scene, &View { camera, width: 64, height: 48 });
    }
}

#[test]
fn cameras_that_look_almost_along_their_up_are_as_exact() {
    let scene = tangle();
    for tilt in [0.0, 1e-12, 1e-6] {
        let camera = Camera {
            eye: DVec3::new(0.0, 9.0, 0.0),
            target: DVec3::new(tilt, 0.0, 0.0),
            up: DVec3::Y,
            projection: Projection::Perspective { vertical_degrees: 60.0 },
        };
        common_picture(&scene, &View { camera, width: 40, height: 40 });
    }
}

#[test]
fn back_faces_of_convex_bodies_are_left_out_and_the_picture_stays() {
    // Seen along an axis: the outline's edges and corners lie on pixel centres, and faces turned away tie with those seen.
    let cuboid = Shape::Cuboid(Cuboid { size: [4.0, 4.0, 4.0] });
    let turned = DAffine3::from_translation(DVec3::new(3.0, 3.0, 0.0));
    let (shot, picture) = common_picture(&scene(vec![object(cuboid.clone(), turned)]), &over_lattice());
    assert_eq!((shot.faces(), picture.covered()), (6, 25));
    let scene = scene(vec![object(cuboid, DAffine3::IDENTITY)]);
    let shot = Shot::new(&scene, &View::of(&scene, 64, 64)).expect("a shot");
    assert!(shot.back_faces_removed() > 0);
    // From inside nothing is left out.
    let camera = Camera {
        eye: DVec3::ZERO,
        target: DVec3::X,
        up: DVec3::Y,
        projection: Projection::Perspective { vertical_degrees: 90.0 },
    };
    let view = View { camera, width: 16, height: 16 };
    let (shot, picture) = common_picture(&scene, &view);
    assert_eq!((shot.back_faces_removed(), picture.covered()), (0, 256));
}

/// The judge by brute force: every face asked at every pixel, with exact numbers only.
#[test]
fn pictures_are_what_exact_rays_see() {
    let scene = tangle();
    let view = View::around(&scene, 20.0, 30.0, 24, 18);
    let (shot, picture) = common_picture(&scene, &view);
    for row in 0..view.height {
        for column in 0..view.width {
            let ray = view.ray(f64::from(column) + 0.5, f64::from(row) + 0.5);
            let exact = exact_nearest(&scene, ray.origin, ray.direction);
            let seen = picture.seen(&shot, [column, row]).map(|seen| (seen.object, seen.face));
            assert_eq!(seen, exact, "at ({column}, {row})");
        }
    }
}

/// The flat faces by the parameters of Cramer's rule in big numbers, the curved ones by their exact crossing.
fn exact_nearest(scene: &Scene, origin: DVec3, direction: DVec3) -> Option<(usize, usize)> {
    let mut best: Option<(usize, usize, umbriel_geometry::analytic::Root<Dyadic>)> = None;
    for (index, object) in scene.objects.iter().enumerate() {
        let mut met = Vec::new();
        if let Some(body) = object.analytic() {
            met.extend(body.first_exact_crossing(origin, direction).map(|crossing| (0, crossing.distance)));
        } else if let Some(facets) = object.facets() {
            met.extend(
                (0..facets.len()).filter_map(|face| Some((face, exact_distance(&facets, face, origin, direction)?))),
            );
        }
        for (face, distance) in met {
            let wins =
                best.as_ref().is_none_or(|(.., other)| distance.sign_of_difference(other) == Some(Sign::Negative));
            if wins {
                best = Some((index, face, distance));
            }
        }
    }
    best.map(|(object, face, _)| (object, face))
}

fn exact_distance(
    facets: &umbriel_geometry::Facets,
    face: usize,
    origin: DVec3,
    direction: DVec3,
) -> Option<umbriel_geometry::analytic::Root<Dyadic>> {
    let numbers = facets.facet(face).corners();
    let corner = |k: usize| facets.point(numbers[k]).to_exact::<Dyadic>().xyz;
    let [a, b, d] = [corner(0), corner(1), corner(numbers.len() - 1)];
    let of = |vector: DVec3| vector.to_array().map(Dyadic::new);
    let minus =
        |p: &[Dyadic; 3], q: &[Dyadic; 3]| -> [Dyadic; 3] { std::array::from_fn(|k| p[k].clone() - q[k].clone()) };
    let det = |p: &[Dyadic; 3], q: &[Dyadic; 3], r: &[Dyadic; 3]| {
        let m = |i: usize, j: usize| q[i].clone() * r[j].clone() - q[j].clone() * r[i].clone();
        p[0].clone() * m(1, 2) + p[1].clone() * m(2, 0) + p[2].clone() * m(0, 1)
    };
    let (u, v, f, w) = (minus(&b, &a), minus(&d, &a), minus(&of(origin), &a), of(direction));
    // a + s·u + t·v = o + r·w, each unknown over −det(u, v, w).
    let divisor = -det(&u, &v, &w);
    let sign = divisor.sign();
    if sign == Sign::Zero {
        return None;
    }
    let (s, t, r) = (-det(&f, &v, &w), -det(&u, &f, &w), det(&u, &v, &f));
    let is_at_least_zero = |value: &Dyadic| value.sign().times(sign) != Sign::Negative;
    let rest = if numbers.len() == 3 {
        vec![divisor.clone() - s.clone() - t.clone()]
    } else {
        vec![divisor.clone() - s.clone(), divisor.clone() - t.clone()]
    };
    let inside = [s, t].iter().chain(&rest).all(is_at_least_zero) && r.sign().times(sign) == Sign::Positive;
    if inside { umbriel_geometry::analytic::Root::quotient(r, divisor) } else { None }
}

#[test]
fn rows_are_those_of_the_whole_picture() {
    let scene = tangle();
    let shot = Shot::new(&scene, &View::of(&scene, 50, 40)).expect("a shot");
    for method in methods(&shot) {
        let (whole, _) = draw(method.as_ref(), &shot);
        let (part, _) = draw_rows(method.as_ref(), &shot, 13..30);
        for row in 13..30 {
            for column in 0..50 {
                assert_eq!(part.seen(&shot, [column, row]), whole.seen(&shot, [column, row]));
            }
        }
    }
}

#[test]
fn pictures_without_pixels_or_eyes_are_refused() {
    let scene = tangle();
    let view = View::of(&scene, 8, 8);
    assert!(matches!(Shot::new(&scene, &View { width: 0, ..view }), Err(ShotDefect::Size { .. })));
    let far = Camera { eye: DVec3::splat(f64::INFINITY), ..view.camera };
    assert!(Shot::new(&scene, &View { camera: far, ..view }).is_err());
    let blind = Camera { projection: Projection::Orthographic { height: 0.0 }, ..view.camera };
    assert!(matches!(Shot::new(&scene, &View { camera: blind, ..view }), Err(ShotDefect::Projection)));
}
