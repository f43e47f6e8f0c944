//! Details of single objects and lights, and cells as small as a camera's pixels.

use std::{sync::Arc, time::Duration};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Camera, Light, Object, Projection, Scene, Shape, Sides};
use umbriel_shadow::{Detail, ObjectReport, OwnDetails, Request, Silent, Verdict, bake};

fn placed(name: &str, shape: Shape, at: [f64; 3]) -> Object {
    let placement = Placement::new(DAffine3::from_translation(at.into())).expect("regular");
    Object::new(name.into(), shape, placement, Sides::Auto).expect("an object")
}

/// Two floors with a box and a ball over them, a sun and a lamp.
fn scene() -> Scene {
    let floor = || Shape::Rectangle(Rectangle { size: [8.0; 2] });
    let lights = vec![
        Light::new("sun", LightSource::sun([0.3, -1.0, 0.2]).expect("a sun")),
        Light::new("lamp", LightSource::point([1.0, 6.0, 2.0]).expect("a lamp")),
    ];
    let objects = vec![
        placed("floor", floor(), [0.0; 3]),
        placed("other floor", floor(), [9.0, 0.0, 0.0]),
        placed("box", Shape::Cuboid(Cuboid { size: [1.0, 2.0, 1.0] }), [2.5, 1.75, 0.0]),
        placed("ball", Shape::from(Analytic::Sphere { radius: 1.0 }), [7.0, 2.0, 0.0]),
    ];
    Scene { objects: objects.into(), lights, ..Scene::default() }
}

fn depth(boundary: u8) -> Detail {
    Detail::Depth { interior: boundary, boundary }
}

/// One report a light and object, with cells.
fn run(scene: &Scene, detail: Detail, own: &OwnDetails) -> Vec<Vec<ObjectReport>> {
    let request = Request { keep_cells: true, own: own.clone(), ..Request::everything(scene, detail) };
    let report = bake(scene, &request, &Silent).expect("nobody cancels");
    report.lights.into_iter().map(|light| light.objects).collect()
}

#[test]
fn own_details_are_those_of_a_bake_with_them() {
    let scene = scene();
    let own =
        OwnDetails { objects: [(1, depth(7)), (3, Detail::Cell { edge: 0.3 })].into(), lights: [(1, depth(3))].into() };
    let mixed = run(&scene, depth(5), &own);
    let none = OwnDetails::default();
    let with = |detail| run(&scene, detail, &none);
    let [coarse, plain, fine, cells] = [depth(3), depth(5), depth(7), Detail::Cell { edge: 0.3 }].map(with);
    for (light, others) in [&plain, &coarse].into_iter().enumerate() {
        for (object, from) in [others, &fine, others, &cells].into_iter().enumerate() {
            assert_eq!(mixed[light][object], from[light][object], "light {light}, object {object}");
        }
    }
    assert_ne!(plain[0][1], fine[0][1]);
}

/// A curved body that its box cuts into sheets and sides, whose cells at borders are counted by rules of their own.
#[test]
fn sums_are_the_same_whether_cells_are_kept() {
    let mut scene = scene();
    let saddle = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.5], [0.0, 0.0, -1.0, 0.0], [0.0, 0.5, 0.0, 0.0]];
    let within = [[-1.0; 3], [1.0; 3]];
    scene.objects.push(placed("saddle", Shape::from(Analytic::Quadric { matrix: saddle, within }), [0.0, 3.0, 0.0]));
    for detail in [Detail::Depth { interior: 2, boundary: 5 }, Detail::Cell { edge: 0.2 }] {
        let sums = |keep_cells: bool| {
            let request = Request { keep_cells, ..Request::everything(&scene, detail) };
            let report = bake(&scene, &request, &Silent).expect("nobody cancels");
            let without = |object: ObjectReport| ObjectReport { cells: Vec::new(), ..object };
            report.lights.into_iter().flat_map(|light| light.objects).map(without).collect::<Vec<_>>()
        };
        assert_eq!(sums(true), sums(false), "{detail:?}");
    }
}

#[test]
fn limits_divide_as_far_as_own_details_let_them() {
    let scene = scene();
    let own = OwnDetails { objects: [(0, depth(2))].into(), ..OwnDetails::default() };
    for limit in [Detail::MaxUndecided { share: 0.02 }, Detail::Time { limit: Duration::from_millis(60) }] {
        let reports = run(&scene, limit, &own);
        let finest = |object: usize| reports[0][object].cells.iter().map(|cell| cell.level).max();
        assert!(finest(0) <= Some(3), "the floor reaches no deeper than its own depth: {:?}", finest(0));
        // How far a time goes depends on what else the machine does.
        assert!(matches!(limit, Detail::Time { .. }) || finest(1) > Some(3), "{:?}", finest(1));
    }
    let samples = Request { own, ..Request::everything(&scene, Detail::Faces) };
    assert_eq!(bake(&scene, &samples, &Silent).expect("nobody cancels").work.octrees_built, 0, "faces stay whole");
}

/// A cell's corners in world coordinates, and the longer of its diagonals.
fn extent(at: impl Fn([f64; 2]) -> DVec3) -> ([DVec3; 4], f64) {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(at);
    (corners, corners[0].distance(corners[2]).max(corners[1].distance(corners[3])))
}

#[test]
fn cells_follow_the_pixels_to_the_horizon() {
    // A long floor with boxes on it, seen along it from a man's height.
    let mut objects = vec![placed("floor", Shape::Rectangle(Rectangle { size: [400.0, 4.0] }), [200.0, 0.0, 0.0])];
    objects.extend((0..20).map(|k| {
        let size = DVec3::splat(0.5 + f64::from(k % 3) * 0.25).to_array();
        placed(&format!("box {k}"), Shape::Cuboid(Cuboid { size }), [5.0 + f64::from(k * k), 1.0, 0.0])
    }));
    let sun = Light::new("sun", LightSource::sun([0.31, -1.0, 0.17]).expect("a sun"));
    let scene = Scene { objects: objects.into(), lights: vec![sun], ..Scene::default() };
    let projection = Projection::Perspective { vertical_degrees: 50.0 };
    let eye = DVec3::new(0.0, 1.7, 0.0);
    let camera = Camera { eye, target: DVec3::new(10.0, 1.0, 0.0), up: DVec3::Y, projection };
    let detail = Detail::of_pixel(&camera, 500);
    let Detail::Pixel { width, .. } = detail else { panic!("{detail:?}") };
    let floor = &run(&scene, detail, &OwnDetails::default())[0][0];
    let levels: Vec<u8> =
        floor.cells.iter().filter(|cell| cell.verdict == Verdict::Undecided).map(|cell| cell.level).collect();
    assert!(levels.iter().max() >= levels.iter().min().map(|level| level + 4).as_ref(), "{levels:?}");
    for cell in &floor.cells {
        let (corners, reach) = extent(|place| {
            let [u, v] = cell.point(place);
            DVec3::new(400.0 * u, 0.0, 4.0 * v - 2.0)
        });
        let distances = corners.map(|corner| corner.distance(eye));
        let [nearest, farthest] =
            [distances.into_iter().fold(f64::INFINITY, f64::min), distances.into_iter().fold(0.0, f64::max)];
        assert!(reach >= width * farthest * (1.0 - 1e-9), "a cell of {reach} m at {farthest} m");
        let is_small = 0.5 * reach <= width * (nearest + 2.0 * reach);
        assert!(is_small || cell.verdict != Verdict::Undecided, "a cell of {reach} m at {nearest} m");
    }
    // A parallel view has pixels of one size.
    let parallel = Camera { projection: Projection::Orthographic { height: 10.0 }, ..camera };
    assert_eq!(Detail::of_pixel(&parallel, 100), Detail::Cell { edge: 0.2 });
}

#[test]
fn surfaces_without_thickness_are_not_divided_to_the_end() {
    // x² ≤ 0, and less than a rounding of it: which way such a surface faces cannot be told of any cell.
    for constant in [0.0, -1e-40] {
        let mut matrix = [[0.0; 4]; 4];
        (matrix[0][0], matrix[3][3]) = (1.0, constant);
        let sheet = placed("sheet", Shape::from(Analytic::Quadric { matrix, within: [[-2.0; 3], [2.0; 3]] }), [0.0; 3]);
        let lights = vec![Light::new("sun", LightSource::sun([0.3, -1.0, 0.2]).expect("a sun"))];
        let scene = Scene { objects: [sheet].into(), lights, ..Scene::default() };
        // Finer levels add what lies along its borders, not four times as many.
        let [coarse, fine] = [8, 9].map(|level| run(&scene, depth(level), &OwnDetails::default())[0][0].cells.len());
        assert!(fine < 3 * coarse && coarse < 50_000, "{constant}: {coarse}, {fine}");
    }
}

#[test]
fn quadrics_that_floats_tell_little_of_are_not_divided_to_the_end() {
    let diagonal = |[x, y, z, constant]: [f64; 4]| {
        let mut matrix = [[0.0; 4]; 4];
        [x, y, z, constant].into_iter().enumerate().for_each(|(k, factor)| matrix[k][k] = factor);
        matrix
    };
    let cube = [[-1.0; 3], [1.0; 3]];
    // Linear along each axis: -2xy + 2xz - 3yz - x + 2y - z.
    let bilinear = [[0.0, -1.0, 1.0, -0.5], [-1.0, 0.0, -1.5, 1.0], [1.0, -1.5, 0.0, -0.5], [-0.5, 1.0, -0.5, 0.0]];
    // Touches its box in the point x = 0 of an edge, and all but touches it along that.
    let mut touching = diagonal([1e-9, -0.5, 0.0, 1.0]);
    (touching[1][2], touching[2][1]) = (1.0, 1.0);
    let quadrics = [
        ("none", diagonal([1.0, 1.0, 1.0, 0.5]), cube),
        ("all of its box", diagonal([0.25, 0.0, 0.0, -1.0]), [[-2.0, -2.0, -1.0], [2.0, 0.25, 0.25]]),
        ("equal gradients", diagonal([-0.5, 0.5, 0.0, 0.0]), [[-0.5, -1.0, -1.0], [1.0, 0.25, 0.5]]),
        ("all but equal gradients", diagonal([-0.25, 0.25, 1e-20, 0.0]), [[-0.25, -0.5, -1.0], [0.25, 1.0, 1.0]]),
        ("edge-on", diagonal([1.5, 0.0, -0.5, 0.0]), [[-0.5, 0.0, -0.5], [1.0, 0.5, 2.0]]),
        ("bilinear", bilinear, [[-1.0, -1.0, 0.0], [1.0; 3]]),
        ("touching", touching, [[0.0, -1.0, 0.0], [1.0, 0.25, 0.25]]),
    ];
    for (name, matrix, within) in quadrics {
        let body = placed(name, Shape::from(Analytic::Quadric { matrix, within }), [0.0; 3]);
        let lights = vec![Light::new("sun", LightSource::sun([1.0, -1.5, 3f64.sqrt()]).expect("a sun"))];
        let scene = Scene { objects: [body].into(), lights, ..Scene::default() };
        let cells = run(&scene, depth(8), &OwnDetails::default())[0][0].cells.len();
        assert!(cells < 40_000, "{name}: {cells}");
    }
}

#[test]
fn the_inner_side_of_a_cut_quadric_is_dark() {
    // From its lower end an hourglass grows thinner: the way to the light goes on inside, though the form grows along it.
    let mut matrix = [[0.0; 4]; 4];
    (matrix[0][0], matrix[1][1], matrix[2][2], matrix[3][3]) = (1.0, -1.0, 1.0, -0.25);
    let shape = Shape::from(Analytic::Quadric { matrix, within: [[-1.0, -0.5, -1.0], [1.0, 0.5, 1.0]] });
    let body = Object::new("hourglass".into(), shape, Placement::IDENTITY, Sides::Two).expect("an object");
    let lights = vec![Light::new("sun", LightSource::sun([0.3, -1.0, 0.2]).expect("a sun"))];
    let scene = Scene { objects: [body].into(), lights, ..Scene::default() };
    let [coarse, fine] = [5, 7].map(|level| {
        let report = &run(&scene, depth(level), &OwnDetails::default())[0][0];
        (report.lit.upper - report.lit.lower) / report.area
    });
    assert!(fine < 0.5 * coarse && fine < 0.02, "{coarse}, {fine}");
}

#[test]
fn a_light_on_a_capsule_lights_its_inner_side() {
    for position in [[1.0, 0.25, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0]] {
        let shape = Shape::from(Analytic::Capsule { radius: 1.0, height: 2.0 });
        let body = Object::new("capsule".into(), shape, Placement::IDENTITY, Sides::Two).expect("an object");
        let lights = vec![Light::new("lamp", LightSource::point(position).expect("a lamp"))];
        let scene = Scene { objects: [body].into(), lights, ..Scene::default() };
        let report = &run(&scene, depth(6), &OwnDetails::default())[0][0];
        assert!(report.lit.lower > 0.98 * report.area, "{position:?}: {:?}", report.lit);
    }
}

/// Ends of curved bodies are flat, and their cells are estimated point by point.
#[test]
fn flat_faces_hide_a_disk_and_a_cap() {
    let disk = Shape::from(Analytic::Disk { radius: 1.0 });
    let cylinder = Shape::from(Analytic::Cylinder { radius: 1.0, height: 1.0 });
    let roof = Rectangle { size: [1.0; 2] };
    let triangles = Mesh::new(
        vec![[-0.5, 0.0, -0.5], [-0.5, 0.0, 0.5], [0.5, 0.0, 0.5], [0.5, 0.0, -0.5]],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let roofs = [Shape::Rectangle(roof), Shape::Mesh(Arc::new(triangles.expect("a mesh")))];
    for (body, roof) in [(&disk, &roofs[0]), (&disk, &roofs[1]), (&cylinder, &roofs[0]), (&cylinder, &roofs[1])] {
        let sun = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
        let objects = vec![placed("body", body.clone(), [0.0; 3]), placed("roof", roof.clone(), [0.0, 2.0, 0.0])];
        let scene = Scene { objects: objects.into(), lights: vec![Light::new("sun", sun)], ..Scene::default() };
        let lit = run(&scene, depth(6), &OwnDetails::default())[0][0].lit;
        let known = std::f64::consts::PI - 1.0;
        assert!(lit.lower <= known && known <= lit.upper, "{lit:?}");
        assert!((lit.estimate - known).abs() < 0.02, "{lit:?}");
    }
}
