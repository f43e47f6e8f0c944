//! Decisions of this layer that floats cannot settle, one smallest scene each. NUMERICS.md, section 4, names these tests.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use umbriel_geometry::{Analytic, LightSource, Mesh, Placement, Rectangle, decisions::Decisions};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{
    CellMethod, Detail, Place, Points, Queries, Request, Sampling, Silent, bake,
    doctor::{DefectKind, examine},
};

fn object(name: &str, shape: Shape, map: DAffine3) -> Object {
    Object::new(name.into(), shape, Placement::new(map).expect("regular"), Sides::Auto).expect("an object")
}

fn mesh(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Shape {
    Shape::Mesh(Arc::new(Mesh::new(positions, triangles).expect("a mesh")))
}

fn scene(objects: Vec<Object>) -> Scene {
    let source = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
    Scene { objects: objects.into(), lights: vec![Light::new("sun", source)], ..Scene::default() }
}

/// Runs on one thread, which counts for itself.
fn counted<T: Send>(work: impl FnOnce() -> T + Send) -> (T, Decisions) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| {
        let before = Decisions::of_thread();
        let answer = work();
        (answer, Decisions::of_thread() - before)
    })
}

/// What the cells of object 0 prove lit at least and at most, square metres.
fn lit_area(scene: &Scene, method: CellMethod) -> ([f64; 2], Decisions) {
    let detail = Detail::Depth { interior: 4, boundary: 4 };
    let request = Request { method, receivers: vec![0], ..Request::everything(scene, detail) };
    let (report, decisions) = counted(|| bake(scene, &request, &Silent).expect("not cancelled"));
    let lit = report.lights[0].objects[0].lit;
    ([lit.lower, lit.upper], decisions)
}

/// Cells and borders agree as far as both know.
fn assert_overlap(a: [f64; 2], b: [f64; 2]) {
    assert!(a[0] <= b[1] && b[0] <= a[1], "{a:?} and {b:?}");
}

/// Four triangles of one slanted plane, rounded: they are in one plane but for an ulp or two.
fn nearly_flat_roof() -> Scene {
    let height = |x: f64, z: f64| 1.0 + x / 3.0 + z / 7.0;
    let point = |x: f64, z: f64| [x, height(x, z), z];
    let positions = vec![point(0.1, 0.1), point(0.9, 0.2), point(0.8, 0.7), point(0.2, 0.9), point(0.45, 0.55)];
    let roof = |triangles| mesh(positions.clone(), triangles);
    let half = object("half", roof(vec![[0, 4, 1], [1, 4, 2]]), DAffine3::IDENTITY);
    let rest = object("rest", roof(vec![[2, 4, 3], [3, 4, 0]]), DAffine3::IDENTITY);
    scene(vec![half, rest])
}

#[test]
fn neighbours_in_one_plane_are_told_by_pairs() {
    let roof = nearly_flat_roof();
    let (cells, decisions) = lit_area(&roof, CellMethod::Quadtree);
    assert!(decisions.pair > 0 && decisions.expansion + decisions.exact == 0, "quadtree: {decisions:?}");
    let (borders, decisions) = lit_area(&roof, CellMethod::Borders);
    assert!(decisions.pair > 0 && decisions.expansion + decisions.exact == 0, "borders: {decisions:?}");
    assert_overlap(cells, borders);
}

#[test]
fn a_body_that_stands_on_a_tilted_floor_is_in_contact_exactly() {
    let turned = DAffine3::from_quat(DQuat::from_xyzw(0.05, 0.2, 0.1, 0.9).normalize());
    let floor = object("floor", Shape::Rectangle(Rectangle { size: [4.0, 4.0] }), turned);
    let body = Shape::from(Analytic::Cylinder { radius: 0.5, height: 1.0 });
    let up = DAffine3::from_translation(DVec3::new(0.0, 0.5, 0.0));
    let composed = DAffine3 { matrix3: turned.matrix3, translation: turned.transform_point3(up.translation) };
    // The middle is rounded, so the body stands in the floor's plane or an ulp off it: only big numbers can tell.
    let (lit, decisions) = lit_area(&scene(vec![floor, object("body", body, composed)]), CellMethod::Auto);
    assert!(decisions.exact > 0, "{decisions:?}");
    assert!(lit[0] > 10.0 && lit[1] < 16.0, "{lit:?}");
}

#[test]
fn samples_on_a_border_are_told_by_pairs() {
    let floor = object("floor", Shape::Rectangle(Rectangle { size: [4.0, 4.0] }), DAffine3::IDENTITY);
    let corners = vec![[0.25, 1.0, -9.0], [0.25, 1.0, 9.0], [9.0, 1.0, 0.0]];
    let plate = object("plate", mesh(corners, vec![[0, 1, 2]]), DAffine3::IDENTITY);
    let mut scene = scene(vec![floor, plate]);
    scene.lights[0].source = LightSource::sun([0.25, -1.0, 0.125]).expect("a sun");
    // The border of the shadow runs through the samples at x = 0.5; closed faces take them.
    let sampling = Some(Sampling::Spacing(1.0));
    let request = Request { sampling, receivers: vec![0], ..Request::everything(&scene, Detail::Faces) };
    let (report, decisions) = counted(|| bake(&scene, &request, &Silent).expect("not cancelled"));
    let samples = report.lights[0].objects[0].samples.expect("samples");
    assert_eq!((samples.samples, samples.lit), (16, 8));
    assert!(decisions.pair >= 4 && decisions.expansion + decisions.exact == 0, "{decisions:?}");
}

#[test]
fn loose_points_on_a_border_are_told_exactly() {
    let plate = mesh(vec![[0.0, 1.0, 0.0], [0.5, 1.0, 0.0], [0.0, 1.0, 0.5]], vec![[0, 2, 1]]);
    let scene = scene(vec![object("plate", plate, DAffine3::IDENTITY)]);
    let light = LightSource::sun([0.25, -1.0, 0.125]).expect("a sun");
    let queries = Queries::new(&scene);
    let lit = |x: f64| {
        let points = [[x, 0.0, 0.25]];
        let (lit, decisions) =
            counted(|| queries.lit_many(Points::FreeDouble(&points), &light, &Silent).expect("accepted"));
        (lit[0], decisions)
    };
    let (is_lit, decisions) = lit(0.5);
    assert!(!is_lit && decisions.single == 1 && decisions.all() == 1, "clear: {decisions:?}");
    let (is_lit, decisions) = lit(0.625 + 0.5f64.powi(40));
    assert!(is_lit && decisions.double > 0 && decisions.exact == 0, "too near for 32 bits: {decisions:?}");
    let (is_lit, decisions) = lit(0.625);
    assert!(!is_lit && decisions.pair > 0 && decisions.exact == 0, "on the border: {decisions:?}");
}

/// A place just below a roof, rounded from a point of it: with a normal it means the roof, without one the space below.
#[test]
fn points_that_a_face_may_touch_are_asked_one_by_one() {
    let ulp = f64::EPSILON;
    // The roof is at 1 + x·2^-52, so a quarter of an ulp above the place; its box reaches half an ulp.
    let roof = mesh(vec![[0.0, 1.0, 0.0], [0.0, 1.0, 4.0], [4.0, 1.0 + 4.0 * ulp, 0.0]], vec![[0, 1, 2]]);
    let scene = scene(vec![object("roof", roof, DAffine3::IDENTITY)]);
    let (queries, noon) = (Queries::new(&scene), LightSource::sun([0.0, -1.0, 0.0]).expect("a sun"));
    let lit = |points: Points| queries.lit_many(points, &noon, &Silent).expect("accepted");
    let below = 1.0 - ulp;
    assert_eq!(lit(Points::FreeDouble(&[[0.25, 1.0, 0.5]])), [false]);
    let rows = [[0.25, 1.0, 0.5, 0.0, 1.0, 0.0], [0.25, below, 0.5, 0.0, 1.0, 0.0]];
    assert_eq!(lit(Points::OrientedDouble(&rows)), [true, false]);
}

#[test]
fn loose_points_on_a_border_with_all_its_digits_are_told_exactly() {
    // The middle of the way to the lamp is the middle of an edge: L = a + (b − x), without rounding.
    let (a, b, x) = ([1.1, 1.7, 1.3], [1.9, 1.2, 1.6], [1.4, 1.5, 1.8]);
    let scene = scene(vec![object("plate", mesh(vec![a, b, [1.2, 1.1, 1.9]], vec![[0, 1, 2]]), DAffine3::IDENTITY)]);
    let lamp = LightSource::point(std::array::from_fn(|k| a[k] + (b[k] - x[k]))).expect("a lamp");
    let queries = Queries::new(&scene);
    let (lit, decisions) = counted(|| queries.lit_many(Points::FreeDouble(&[x]), &lamp, &Silent).expect("accepted"));
    assert!(!lit[0] && decisions.exact > 0, "{decisions:?}");
}

#[test]
fn volumes_that_cancel_are_told_exactly() {
    // Two tetrahedra on one edge, equally large by a shear along it: the second is turned inside out.
    let positions =
        [[0, 0, 0], [1, 3, 2], [2, 1, 5], [1, 4, 1], [3, 4, 7], [2, 7, 3]].map(|point| point.map(f64::from));
    let faces = |[a, b, c, d]: [u32; 4]| [[a, c, b], [a, b, d], [a, d, c], [b, c, d]];
    let triangles = [faces([0, 1, 2, 3]), faces([1, 0, 4, 5])].concat();
    let scene = scene(vec![object("pair", mesh(positions.to_vec(), triangles), DAffine3::IDENTITY)]);
    let (diagnosis, decisions) = counted(|| examine(&scene, &[], Detail::default(), &Silent).expect("not cancelled"));
    assert!(decisions.exact > 0, "{decisions:?}");
    assert!(
        diagnosis.totals().iter().all(|total| total.kind != DefectKind::InsideOut),
        "no volume is not a negative one"
    );
}

#[test]
fn a_place_beyond_the_diagonal_by_less_than_an_ulp_is_refused() {
    let half = mesh(vec![[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]], vec![[0, 1, 2]]);
    let scene = scene(vec![object("half", half, DAffine3::IDENTITY)]);
    let (queries, light) = (Queries::new(&scene), scene.lights[0].source);
    let ask = |v: f64| counted(|| queries.lit(&Place::Surface { object: 0, face: 0, u: 0.5, v }, &light).is_ok());
    let (is_taken, decisions) = ask(0.5);
    assert!(is_taken && decisions.exact > 0, "on the side: {decisions:?}");
    // The sum of both is 1 + 2^-53, and rounds to 1.
    let (is_taken, decisions) = ask(0.5f64.next_up());
    assert!(!is_taken && decisions.exact > 0, "beyond it: {decisions:?}");
    assert!(ask(0.5f64.next_down()).0);
}

/// A fan of triangles whose corners lie on a line but for rounding: each lies over all others, and which side of each a point is on only exact numbers tell.
#[test]
fn needles_are_not_divided() {
    let corners = (0..400).map(|k| [0.1, 0.3, 0.7].map(|step| f64::from(k) * step)).collect();
    let scene =
        scene(vec![object("needles", mesh(corners, (1..399).map(|k| [0, k, k + 1]).collect()), DAffine3::IDENTITY)]);
    let request = Request::everything(&scene, Detail::Depth { interior: 5, boundary: 8 });
    let (report, decisions) = counted(|| bake(&scene, &request, &Silent).expect("not cancelled"));
    let needles = &report.lights[0].objects[0];
    assert!(needles.area > 0.0 && needles.lit.upper <= needles.area + needles.area_error && needles.lit.lower == 0.0);
    assert!(decisions.expansion + decisions.exact < 400, "{decisions:?}");
}
