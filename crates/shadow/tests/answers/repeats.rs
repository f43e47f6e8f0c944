//! Bodies that are given several times in one place: the answers are those of the body given once, and the work as well.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{
    Cell, CellMethod, Change, Detail, ObjectReport, OwnDetails, Report, Request, Sampling, Session, Silent, bake,
};

/// A roof: two slopes of four triangles in all, their fronts below.
fn roof(size: f64) -> Mesh {
    let positions =
        [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    let positions = positions.map(|position: [f64; 3]| position.map(|x| x * size)).to_vec();
    Mesh::new(positions, vec![[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]]).expect("a mesh")
}

fn body(name: String, shape: Shape, at: [f64; 3], scale: f64, sides: Sides) -> Object {
    let map = DAffine3::from_translation(at.into()) * DAffine3::from_scale(DVec3::splat(scale));
    Object::new(name, shape, Placement::new(map).expect("regular"), sides).expect("an object")
}

/// A floor under a roof, a ball, a plate and a box, each given `times` times, and a second plate beside the first in its plane. Where copies are not `alike`, each
/// has numbers of its own: sizes and scales that are powers of two apart make the same points.
fn scene(times: i32, alike: bool) -> Scene {
    let mesh = Arc::new(roof(1.0));
    let copies = |k: i32| {
        let scale = if alike { 1.0 } else { f64::powi(2.0, k) };
        let roof = if alike && k % 2 == 0 { Arc::clone(&mesh) } else { Arc::new(roof(1.0 / scale)) };
        let plate = Shape::Rectangle(Rectangle { size: [1.5 / scale, 1.0 / scale] });
        let ball = Shape::from(Analytic::Sphere { radius: 0.5 / scale });
        let cuboid = Shape::Cuboid(Cuboid { size: [0.5 / scale, 1.0 / scale, 0.5 / scale] });
        [
            body(format!("roof {k}"), Shape::Mesh(roof), [0.0, 1.0, 0.0], scale, Sides::Auto),
            body(format!("ball {k}"), ball, [1.5, 2.0, 0.0], scale, Sides::Auto),
            body(format!("plate {k}"), plate, [-1.0, 3.0, 0.5], scale, Sides::Auto),
            body(format!("box {k}"), cuboid, [-0.5, 0.5, 0.25], scale, Sides::Auto),
        ]
    };
    let floor = Shape::Rectangle(Rectangle { size: [8.0; 2] });
    let beside = Shape::Rectangle(Rectangle { size: [1.5, 1.0] });
    let mut objects = vec![
        body("floor".into(), floor, [0.0; 3], 1.0, Sides::Auto),
        body("beside".into(), beside, [-0.25, 3.0, 0.5], 1.0, Sides::Auto),
    ];
    objects.extend((0..times).flat_map(copies));
    let lights = [LightSource::sun([0.3, -1.0, 0.2]), LightSource::point([0.5, 4.0, 1.0])];
    let light = |source: LightSource| Light::new("light", source);
    Scene {
        objects: objects.into(),
        lights: lights.map(|source| light(source.expect("a light"))).into(),
        ..Scene::default()
    }
}

fn baked(scene: &Scene, request: &Request) -> Report {
    bake(scene, request, &Silent).expect("nobody cancels")
}

fn asking(scene: &Scene, detail: Detail, sampling: Option<Sampling>) -> Request {
    Request { keep_cells: true, sampling, ..Request::everything(scene, detail) }
}

/// Object 2 and its four kinds stand in the scene of each once as in that of many.
fn original(object: usize) -> usize {
    if object < 2 { object } else { 2 + (object - 2) % 4 }
}

const DEPTH: Detail = Detail::Depth { interior: 3, boundary: 4 };

#[test]
fn copies_change_no_answer() {
    let (once, many) = (scene(1, true), scene(3, true));
    for (detail, sampling) in [
        (DEPTH, None),
        (DEPTH, Some(Sampling::Spacing(0.2))),
        (Detail::Faces, Some(Sampling::Spacing(0.2))),
        (Detail::Cell { edge: 0.25 }, None),
    ] {
        let [expected, found] = [&once, &many].map(|scene| baked(scene, &asking(scene, detail, sampling)));
        for (expected, found) in expected.lights.iter().zip(&found.lights) {
            for report in &found.objects {
                let known = &expected.objects[original(report.object)];
                assert_eq!(*report, ObjectReport { object: report.object, ..known.clone() }, "{detail:?}");
            }
        }
        assert_eq!(expected.work.cells, found.work.cells, "{detail:?}");
        assert_eq!(expected.work.pairs_tested, found.work.pairs_tested, "{detail:?}");
    }
}

/// Where copies are not known to be such, every one is looked at beside all others: samples have the same exact answers, and bounds hold the same truth.
#[test]
fn copies_answer_as_if_nobody_knew() {
    let [known, unknown] = [true, false].map(|alike| scene(3, alike));
    let request = |scene: &Scene| asking(scene, DEPTH, Some(Sampling::Spacing(0.15)));
    let [known, unknown] = [known, unknown].map(|scene| baked(&scene, &request(&scene)));
    let mut lit = 0;
    for (known, unknown) in known.lights.iter().zip(&unknown.lights) {
        for (known, unknown) in known.objects.iter().zip(&unknown.objects) {
            assert_eq!(known.samples, unknown.samples, "object {}", known.object);
            assert!(known.lit.lower <= unknown.lit.upper && unknown.lit.lower <= known.lit.upper);
            lit += known.samples.expect("samples").lit;
        }
    }
    assert!(lit > 3000, "{lit}");
    assert_eq!(known.work.pairs_registered, unknown.work.pairs_registered, "pairs are those of all objects");
    // Copies have points in common, so most of their pairs are taken as blocks without being tested.
    assert!(known.work.pairs_tested < unknown.work.pairs_tested);
    assert!(known.work.cells < unknown.work.cells);
}

#[test]
fn limits_count_every_copy() {
    let many = scene(3, true);
    let found = baked(&many, &asking(&many, Detail::MaxUndecided { share: 0.02 }, None));
    let once = scene(1, true);
    let exact = baked(&once, &asking(&once, Detail::Depth { interior: 3, boundary: 6 }, None));
    for (exact, found) in exact.lights.iter().zip(&found.lights) {
        let area: f64 = found.objects.iter().map(|report| report.area).sum();
        let undecided: f64 = found.objects.iter().map(ObjectReport::undecided).sum();
        assert!(undecided <= 0.02 * area, "{undecided} of {area}");
        for report in &found.objects {
            let known = &exact.objects[original(report.object)];
            assert!(report.lit.lower <= known.lit.upper && known.lit.lower <= report.lit.upper);
        }
    }
}

/// Copies with sides or details of their own have answers of their own.
#[test]
fn sides_and_details_are_those_of_each_copy() {
    let mut many = scene(3, true);
    many.objects[6].sides = Sides::One;
    let fine = Detail::Depth { interior: 3, boundary: 6 };
    let own = OwnDetails { objects: [(10, fine)].into(), ..OwnDetails::default() };
    let found = baked(&many, &Request { own, ..asking(&many, DEPTH, None) });
    for light in &found.lights {
        let [both, one, finer] = [2, 6, 10].map(|object| &light.objects[object]);
        assert!(one.lit.upper == 0.0 && both.lit.lower > 0.0, "the fronts are below");
        assert!(finer.undecided() < both.undecided());
        assert!(finer.lit.lower <= both.lit.upper && both.lit.lower <= finer.lit.upper);
    }
}

/// Copies come, go and are moved together and apart.
#[test]
fn sessions_know_copies() {
    let first = scene(2, true);
    let request = asking(&first, DEPTH, None);
    let mut session = Session::new(first, request.clone());
    let moved = |object: usize, x: f64| {
        let placement = Placement::new(DAffine3::from_translation(DVec3::new(x, 1.0, 0.0))).expect("regular");
        Change::Move { object, placement }
    };
    let again = scene(1, true).objects.remove(5);
    let steps = [
        vec![],
        vec![moved(2, 0.5)],
        vec![Change::Remove(3), moved(2, 0.0)],
        vec![Change::Add(again), moved(5, 0.25)],
        vec![Change::Remove(2), Change::Remove(1)],
    ];
    for step in steps {
        step.into_iter().for_each(|change| session.change(change).expect("a sound change"));
        session.update(&Silent).expect("nobody cancels");
        let scene = session.scene();
        let everything = Request { receivers: (0..scene.objects.len()).collect(), ..request.clone() };
        assert!(session.lights().eq(&baked(scene, &everything).lights), "not what a bake answers");
    }
    assert_eq!(session.update(&Silent).expect("nobody cancels").redone, 0);
}

/// A thousand and one boxes in one place cost what one costs, but for a look at each.
#[test]
fn work_does_not_grow_with_copies() {
    let crowd = |count: usize| {
        let floor = body("floor".into(), Shape::Rectangle(Rectangle { size: [8.0; 2] }), [0.0; 3], 1.0, Sides::Auto);
        let cuboid = Shape::Cuboid(Cuboid { size: [1.0; 3] });
        let boxes = (0..count).map(|k| body(format!("{k}"), cuboid.clone(), [0.0, 1.0, 0.0], 1.0, Sides::Auto));
        let sun = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
        Scene {
            objects: std::iter::once(floor).chain(boxes).collect(),
            lights: vec![Light::new("sun", sun)],
            ..Scene::default()
        }
    };
    let [one, many] = [1, 1001].map(|count| {
        let scene = crowd(count);
        baked(&scene, &Request::everything(&scene, DEPTH))
    });
    assert_eq!((one.work.pairs_tested, one.work.pairs_registered), (many.work.pairs_tested, 1));
    assert_eq!(many.work.pairs_registered, 1001 + 1001 * 1000, "each shadows the floor and all others");
    let rest = |report: &Report| (report.work.cells, report.work.rays, report.work.octrees_built);
    assert_eq!(rest(&one), rest(&many));
    assert_eq!(one.lights[0].objects[0], many.lights[0].objects[0]);
    assert_eq!(one.lights[0].objects[1].lit, many.lights[0].objects[1001].lit);
}

/// A wavy sheet of 2 × 5² triangles a metre over the middle of a floor; all of them `times` times, turned and flipped, and half of them with vertices of
/// their own.
fn sheet_over_floor(times: u32) -> Scene {
    let height = |i: u32, j: u32| 1.0 + 0.125 * f64::from((i * 7 + j * 5) % 4);
    let place = |k: u32| 0.5 * f64::from(k) - 1.25;
    let vertices = || (0..36).map(|k| [place(k / 6), height(k / 6, k % 6), place(k % 6)]);
    let squares = (0..25).map(|k| k / 5 * 6 + k % 5);
    let triangles: Vec<[u32; 3]> = squares.flat_map(|k| [[k, k + 1, k + 7], [k, k + 7, k + 6]]).collect();
    let copy = |turn: u32| {
        let mut copy = triangles.clone();
        copy.iter_mut().for_each(|corners| corners.rotate_left(turn as usize % 3));
        if turn % 2 == 1 {
            copy.iter_mut().for_each(|corners| corners.swap(0, 1));
            copy.iter_mut().flatten().for_each(|corner| *corner += 36);
        }
        copy
    };
    let mesh = Mesh::new(vertices().chain(vertices()).collect(), (0..times).flat_map(copy).collect()).expect("a mesh");
    let mut scene = scene(0, true);
    let mesh = Arc::new(mesh);
    let sheet = |x: f64| body(format!("at {x}"), Shape::Mesh(Arc::clone(&mesh)), [x, 0.0, 0.0], 1.0, Sides::Two);
    // Two instances, and one with a mesh of its own.
    scene.objects.extend([-1.5, 1.5].map(sheet));
    let own = Shape::Mesh(Arc::new(Mesh::clone(&mesh)));
    scene.objects.push(body("above".into(), own, [0.0, 1.0, 0.0], 1.0, Sides::Two));
    scene
}

#[test]
fn triangles_given_again_shadow_nothing_more() {
    let [once, many] = [1, 7].map(sheet_over_floor);
    for sampling in [None, Some(Sampling::Spacing(0.05))] {
        let request = |scene: &Scene, method| Request { method, ..asking(scene, DEPTH, sampling) };
        let [expected, found] = [&once, &many].map(|scene| baked(scene, &request(scene, CellMethod::Quadtree)).lights);
        for (expected, found) in expected.iter().zip(&found) {
            assert_eq!(expected.objects[0], found.objects[0], "the floor");
            for (expected, found) in expected.objects[2..].iter().zip(&found.objects[2..]) {
                let first: Vec<_> = found.cells.iter().filter(|cell| cell.face < 50).copied().collect();
                assert_eq!(expected.cells, first, "the first of all triangles, object {}", found.object);
                assert!((found.lit.upper - 7.0 * expected.lit.upper).abs() < 1e-9 * found.area);
                assert!((found.lit.lower - 7.0 * expected.lit.lower).abs() < 1e-9 * found.area);
            }
        }
        let [expected, found] = [&once, &many].map(|scene| baked(scene, &request(scene, CellMethod::Borders)).lights);
        for (expected, found) in expected.iter().zip(&found) {
            let [expected, found] = [&expected.objects[0], &found.objects[0]];
            assert!(expected.lit.lower <= found.lit.upper && found.lit.lower <= expected.lit.upper);
            assert_eq!(expected.samples, found.samples);
        }
    }
}

/// Six copies are all orders of three corners; with twelve more, each face has the answer of the first one of its order, and no cell more is examined.
#[test]
fn triangles_given_again_answer_as_the_first_and_cost_nothing() {
    const ORDERS: u32 = 6 * 50;
    let [six, eighteen] = [6, 18].map(sheet_over_floor);
    for sampling in [None, Some(Sampling::Spacing(0.05))] {
        let [expected, found] = [&six, &eighteen].map(|scene| baked(scene, &asking(scene, DEPTH, sampling)));
        assert_eq!((expected.work.cells, expected.work.rays), (found.work.cells, found.work.rays));
        for (expected, found) in expected.lights.iter().zip(&found.lights) {
            for (expected, found) in expected.objects[2..].iter().zip(&found.objects[2..]) {
                assert!(found.cells.is_sorted_by_key(|cell| cell.face) && expected.undecided() > 0.0);
                for again in 0..3 {
                    let of_first = |face: u32| face.checked_sub(again * ORDERS).filter(|&face| face < ORDERS);
                    let cells =
                        found.cells.iter().filter_map(|&cell| Some(Cell { face: of_first(cell.face)?, ..cell }));
                    assert!(cells.eq(expected.cells.iter().copied()), "copy {again} of object {}", found.object);
                }
                assert!((found.lit.upper - 3.0 * expected.lit.upper).abs() < 1e-9 * found.area);
                assert!((found.lit.lower - 3.0 * expected.lit.lower).abs() < 1e-9 * found.area);
                let samples = [found, expected].map(|report| report.samples.map(|samples| samples.lit));
                assert_eq!(samples[0], samples[1].map(|lit| 3 * lit));
            }
        }
    }
}
