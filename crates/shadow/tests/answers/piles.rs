//! Scores of curved bodies in one place: what is proved of cells is right, and no order changes it.

use glam::{DAffine3, DQuat, DVec3};
use umbriel_geometry::{Analytic, LightSource, Placement};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Detail, Report, Request, Silent, bake};

use crate::judged::{dice, judged};

fn scene(bodies: impl Iterator<Item = (Analytic, DAffine3)>, light: LightSource) -> Scene {
    let object = |(number, (body, map)): (usize, (Analytic, DAffine3))| {
        let placement = Placement::new(map).expect("regular");
        Object::new(format!("{number}"), Shape::from(body), placement, Sides::Auto).expect("an object")
    };
    let objects = bodies.enumerate().map(object).collect();
    Scene { objects, lights: vec![Light::new("light", light)], ..Scene::default() }
}

/// Balls of two sizes all over a cube.
fn balls(count: usize, light: LightSource) -> Scene {
    balls_of([0.25, 0.5], count, light)
}

fn balls_of(radii: [f64; 2], count: usize, light: LightSource) -> Scene {
    let mut dice = dice();
    let ball = |k: usize| {
        let radius = radii[k % 2];
        (Analytic::Sphere { radius }, DAffine3::from_translation([(); 3].map(|()| dice()).into()))
    };
    scene((0..count).map(ball), light)
}

/// Balls round one point, each in the next one.
fn shells(count: usize, light: LightSource) -> Scene {
    let ball = |k: usize| (Analytic::Sphere { radius: 1.0 + k as f64 / 256.0 }, DAffine3::IDENTITY);
    scene((0..count).map(ball), light)
}

/// Cones, turned any way.
fn cones(count: usize, light: LightSource) -> Scene {
    let mut dice = dice();
    let cone = |_| {
        let mut number = || dice();
        let place = DVec3::new(number(), number(), number());
        let axis = DVec3::new(number() - 0.5, number() - 0.5, 0.5).normalize();
        let map = DAffine3::from_rotation_translation(DQuat::from_axis_angle(axis, 6.0 * number()), place);
        (Analytic::Cone { radius: 0.75, height: 1.5 }, map)
    };
    scene((0..count).map(cone), light)
}

/// Long cylinders through one point.
fn crossing(count: usize, light: LightSource) -> Scene {
    let mut dice = dice();
    let cylinder = |_| {
        let axis = DVec3::new(dice() - 0.5, dice() - 0.5, dice() - 0.5).normalize_or(DVec3::X);
        let map = DAffine3::from_quat(DQuat::from_axis_angle(axis, 6.0 * dice()));
        (Analytic::Cylinder { radius: 0.0625, height: 3.0 }, map)
    };
    scene((0..count).map(cylinder), light)
}

fn answers(scene: &Scene) -> Report {
    let detail = Detail::Depth { interior: 3, boundary: 6 };
    let request = Request { keep_cells: true, ..Request::everything(scene, detail) };
    bake(scene, &request, &Silent).expect("nobody cancels")
}

/// More bodies than are asked of every cell, under lights outside of them and among them.
#[test]
fn what_is_proved_in_a_pile_is_right_in_any_order() {
    let sun = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
    let [above, among] = [[0.5, 4.0, 0.25], [0.5, 0.5, 0.5]].map(|at| LightSource::point(at).expect("a lamp"));
    let mut all_lit = 0;
    for scene in
        [balls(64, sun), balls(48, above), balls(48, among), shells(40, sun), shells(40, above), cones(40, sun)]
    {
        let report = answers(&scene);
        let [lit, shadowed, _] = judged(&scene, &report, 5);
        assert!(shadowed > 100, "{shadowed} cells looked at");
        all_lit += lit;
        let objects = scene.objects.iter().rev().cloned().collect();
        let mut reversed = answers(&Scene { objects, ..scene.clone() });
        reversed.lights[0].objects.reverse();
        for (before, after) in report.lights[0].objects.iter().zip(&reversed.lights[0].objects) {
            assert!(before.cells == after.cells && before.lit == after.lit, "object {}", before.object);
        }
    }
    assert!(all_lit > 100, "{all_lit} cells looked at");
}

/// Hundreds of bodies over each cell, looked up in a tree. The second sun comes equally along all axes.
#[test]
fn what_is_proved_in_a_swarm_is_right_in_any_order() {
    let [sun, tied] = [[0.3, -1.0, 0.2], [1.0, -1.0, 1.0]].map(|at| LightSource::sun(at).expect("a sun"));
    let [above, among] = [[0.5, 4.0, 0.25], [0.5, 0.5, 0.5]].map(|at| LightSource::point(at).expect("a lamp"));
    let small = [0.125, 0.1875];
    let scenes = [
        balls(300, sun),
        balls_of(small, 500, sun),
        balls_of(small, 500, tied),
        balls_of(small, 500, above),
        balls_of(small, 500, among),
        crossing(300, sun),
    ];
    let mut all_lit = 0;
    for scene in scenes {
        let baked = |scene: &Scene, of: &dyn Fn(usize) -> usize| {
            let detail = Detail::Depth { interior: 2, boundary: 5 };
            let receivers = (0..7).map(|k| of(k * 41)).collect();
            let request = Request { receivers, keep_cells: true, ..Request::everything(scene, detail) };
            bake(scene, &request, &Silent).expect("nobody cancels")
        };
        let report = baked(&scene, &|object| object);
        let [lit, shadowed, _] = judged(&scene, &report, 1);
        let undecided: f64 = report.lights[0].objects.iter().map(|object| object.undecided() / object.area).sum();
        assert!(shadowed > 100 && undecided < 0.25 * 7.0, "{shadowed} cells looked at, {undecided} of 7 undecided");
        all_lit += lit;
        let objects = scene.objects.iter().rev().cloned().collect();
        let last = scene.objects.len() - 1;
        let reversed = baked(&Scene { objects, ..scene.clone() }, &|object| last - object);
        for (before, after) in report.lights[0].objects.iter().zip(&reversed.lights[0].objects) {
            assert!(before.cells == after.cells && before.lit == after.lit, "object {}", before.object);
        }
    }
    assert!(all_lit > 40, "{all_lit} cells looked at");
}

/// What a coarser cell tells, finer ones do as well, in a scene in which hardly a cell is covered by one body.
#[test]
fn finer_cells_tell_no_less_of_a_swarm() {
    let scene = crossing(700, LightSource::sun([0.3, -1.0, 0.2]).expect("a sun"));
    let at_depth = |boundary: u8| {
        let detail = Detail::Depth { interior: 2, boundary };
        let request = Request { receivers: (0..4).collect(), keep_cells: true, ..Request::everything(&scene, detail) };
        bake(&scene, &request, &Silent).expect("nobody cancels")
    };
    let reports: Vec<Report> = (0..5).map(at_depth).collect();
    for pair in reports.windows(2) {
        for (coarse, fine) in pair[0].lights[0].objects.iter().zip(&pair[1].lights[0].objects) {
            let slack = 1e-9 * coarse.area;
            assert!(fine.lit.lower >= coarse.lit.lower - slack && fine.lit.upper <= coarse.lit.upper + slack);
        }
    }
    judged(&scene, &reports[4], 7);
}

/// Balls that are less apart than the finest cells are curved: no cell that faces the light is told, and that is seen long before all are divided.
#[test]
fn shells_that_all_but_coincide_are_not_divided_to_the_end() {
    let sun = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
    let detail = Detail::Depth { interior: 9, boundary: 9 };
    for gap in [f64::EPSILON, 2f64.powi(-40), 2f64.powi(-24)] {
        let ball = |k: i32| (Analytic::Sphere { radius: 1.0 + f64::from(k) * gap }, DAffine3::IDENTITY);
        let scene = scene((0..2).map(ball), sun);
        let report = bake(&scene, &Request::everything(&scene, detail), &Silent).expect("nobody cancels");
        let inner = &report.lights[0].objects[0];
        // Truly none of it is lit; half of it is turned away.
        assert!(inner.lit.lower == 0.0 && inner.undecided() < 0.51 * inner.area, "{gap}: {:?}", inner.lit);
        assert!(report.work.cells < 200_000, "{gap}: {} cells", report.work.cells);
    }
    // What finer cells tell, they do.
    let apart =
        scene((0..2).map(|k| (Analytic::Sphere { radius: 1.0 + f64::from(k) / 4096.0 }, DAffine3::IDENTITY)), sun);
    let report = bake(&apart, &Request::everything(&apart, detail), &Silent).expect("nobody cancels");
    let inner = &report.lights[0].objects[0];
    assert!(inner.undecided() < 0.05 * inner.area, "{:?}", inner.lit);
}
