//! Bakes that may take so much and no more: what they prove is right, whatever there is to spend, and the same for any number of threads.

#![allow(clippy::print_stdout, reason = "figures are part of what these tests tell")]

use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex},
};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{CellMethod, Detail, LightReport, Progress, Report, Request, Silent, bake, typical_effort};

use crate::judged::judged;

fn placed(shape: Shape, at: DVec3) -> Object {
    let placement = Placement::new(DAffine3::from_translation(at)).expect("regular");
    Object::new("object".into(), shape, placement, Sides::Auto).expect("an object")
}

/// A floor under boxes and balls, with a sun and a lamp.
fn yard() -> Scene {
    let mut objects = vec![placed(Shape::Rectangle(Rectangle { size: [8.0; 2] }), DVec3::ZERO)];
    for k in 0..12 {
        let at = DVec3::new(f64::from(k % 4) * 1.75 - 2.5, 1.0, f64::from(k / 4) * 2.0 - 2.25);
        let height = 0.5 + 0.25 * f64::from(k % 3);
        objects.push(match k % 2 {
            0 => placed(Shape::Cuboid(Cuboid { size: [0.75, height, 0.5] }), at),
            _ => placed(Shape::from(Analytic::Sphere { radius: 0.5 * height }), at),
        });
    }
    let sun = LightSource::sun([0.45, -1.0, 0.3]).expect("a sun");
    let lamp = LightSource::point([0.5, 4.0, 0.25]).expect("a lamp");
    Scene {
        objects: objects.into(),
        lights: vec![Light::new("sun", sun), Light::new("lamp", lamp)],
        ..Scene::default()
    }
}

/// Balls that all but coincide, over a floor: hardly anything can be told of them at any depth.
fn pile(count: u32) -> Scene {
    let floor = placed(Shape::Rectangle(Rectangle { size: [8.0; 2] }), DVec3::ZERO);
    let ball =
        |k: u32| placed(Shape::from(Analytic::Sphere { radius: 1.0 }), DVec3::new(1e-9 * f64::from(k), 2.0, 0.0));
    let sun = LightSource::sun([0.45, -1.0, 0.3]).expect("a sun");
    let objects = std::iter::once(floor).chain((0..count).map(ball)).collect();
    Scene { objects, lights: vec![Light::new("sun", sun)], ..Scene::default() }
}

/// Triangles through each other in one place: a crowd.
fn tangle(count: u32) -> Scene {
    let step = [0.754_877_666, 0.569_840_291, 0.438_579_021];
    let at = |k: u32| step.map(|step: f64| (step * f64::from(k)).fract() * 4.0 - 2.0);
    let corners = (0..3 * count).map(at).collect();
    let mesh = Mesh::new(corners, (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect()).expect("a mesh");
    let lights = vec![Light::new("sun", LightSource::sun([0.45, -1.0, 0.3]).expect("a sun"))];
    Scene { objects: [placed(Shape::Mesh(Arc::new(mesh)), DVec3::ZERO)].into(), lights, ..Scene::default() }
}

/// Balls beside each other in rows over a floor, each in the shadow of the one before it.
fn orchard(count: u32) -> Scene {
    let floor = placed(Shape::Rectangle(Rectangle { size: [64.0; 2] }), DVec3::ZERO);
    let ball = |k: u32| {
        let at = DVec3::new(0.9 * f64::from(k % 16), 1.0, 0.8 * f64::from(k / 16));
        placed(Shape::from(Analytic::Sphere { radius: 0.5 + 1e-3 * f64::from(k) }), at)
    };
    let lights = vec![Light::new("sun", LightSource::sun([0.45, -0.5, 0.3]).expect("a sun"))];
    Scene { objects: std::iter::once(floor).chain((0..count).map(ball)).collect(), lights, ..Scene::default() }
}

/// Bodies the areas of whose cells no formula tells.
fn eggs() -> Scene {
    let egg = |k: u32| {
        let radii = [0.5, 0.75, 0.4 + 0.05 * f64::from(k)];
        placed(Shape::from(Analytic::Ellipsoid { radii }), DVec3::new(f64::from(k), 0.0, 0.0))
    };
    let lights = vec![Light::new("sun", LightSource::sun([0.45, -1.0, 0.3]).expect("a sun"))];
    Scene { objects: (0..4).map(egg).collect(), lights, ..Scene::default() }
}

const DEPTH: Detail = Detail::Depth { interior: 7, boundary: 7 };

fn with(scene: &Scene, effort: Option<u64>) -> Report {
    let request = Request { keep_cells: true, effort, ..Request::everything(scene, DEPTH) };
    bake(scene, &request, &Silent).expect("nobody cancels")
}

fn undecided(report: &Report) -> f64 {
    report.lights.iter().flat_map(|light| &light.objects).map(|object| object.undecided()).sum()
}

/// What is the same in every run.
fn answers(report: &Report) -> (Vec<LightReport>, u64, u64) {
    (report.lights.clone(), report.work.cells, report.work.lights_cut_short)
}

#[test]
fn an_effort_that_is_enough_changes_nothing() {
    let scene = yard();
    let (free, within) = (with(&scene, None), with(&scene, Some(typical_effort(&scene, 2))));
    assert_eq!(answers(&free), answers(&within));
    assert_eq!(within.work.lights_cut_short, 0);
}

#[test]
fn what_is_proved_with_less_is_right_and_more_never_tells_less() {
    let scene = yard();
    let whole = with(&scene, None);
    let mut before = f64::INFINITY;
    let mut cut_short = 0;
    for effort in [0, 1000, 20_000, 100_000, 400_000, 1 << 40] {
        let report = with(&scene, Some(effort));
        let left = undecided(&report);
        println!("{effort}: {left} m² undecided, {} lights cut short", report.work.lights_cut_short);
        judged(&scene, &report, 7);
        for (some, all) in report.lights.iter().zip(&whole.lights) {
            for (some, all) in some.objects.iter().zip(&all.objects) {
                assert!(some.lit.lower <= all.lit.upper && all.lit.lower <= some.lit.upper, "{some:?}, {all:?}");
            }
        }
        assert!(left <= before, "{left} m² after {before} m²");
        before = left;
        cut_short += report.work.lights_cut_short;
    }
    assert!(cut_short >= 4, "the efforts are too large to tell anything");
    assert_eq!(before, undecided(&whole));
}

#[test]
fn threads_change_nothing() {
    let scenes = [yard(), pile(40), tangle(1500), eggs(), orchard(80)];
    for (scene, effort) in scenes.into_iter().zip([100_000, 200_000, 1_000_000, 500_000, 50_000]) {
        let with_threads = |count: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("threads");
            pool.install(|| with(&scene, Some(effort)))
        };
        let alone = with_threads(1);
        assert!(alone.work.lights_cut_short > 0);
        for count in [2, 3, 8] {
            assert_eq!(answers(&alone), answers(&with_threads(count)), "{count} threads");
        }
    }
}

/// Five cells a face at most, which is little beside what is looked at for each of them.
#[test]
fn what_is_looked_at_in_a_crowd_counts() {
    let scene = tangle(1500);
    let report = with(&scene, Some(1_000_000));
    assert_eq!((report.work.lights_cut_short, report.work.objects_crowded), (1, 1));
    assert!(report.work.cells < 100_000, "{} cells", report.work.cells);
    judged(&scene, &report, 7);
}

/// How many jobs of how many are done, as it is told last.
#[derive(Default)]
struct Told(Mutex<BTreeMap<u64, u64>>);

impl Progress for Told {
    fn advance(&self, _: &str, done: u64, of: u64) {
        let mut told = self.0.lock().expect("nobody panics");
        let most = told.entry(of).or_default();
        *most = done.max(*most);
    }
}

/// The floor's one face, and six patches a ball.
#[test]
fn some_of_many_receivers_tell_early_that_all_are_too_much() {
    let (scene, jobs) = (orchard(160), 961);
    let request =
        |effort| Request { effort, ..Request::everything(&scene, Detail::Depth { interior: 5, boundary: 5 }) };
    let run = |effort: u64| {
        let told = Told::default();
        let report = bake(&scene, &request(Some(effort)), &told).expect("nobody cancels");
        (report, told.0.into_inner().expect("nobody panics")[&jobs])
    };
    let free = bake(&scene, &request(None), &Silent).expect("nobody cancels");
    let (enough, done) = run(1 << 40);
    assert_eq!((answers(&free), done), (answers(&enough), jobs));
    let (cut, done) = run(20_000);
    assert_eq!(cut.work.lights_cut_short, 1);
    assert!((12..jobs / 6).contains(&done), "{done} jobs in vain");
    let mut turned = scene.clone();
    turned.objects.reverse();
    let again = bake(&turned, &Request { effort: Some(20_000), ..request(None) }, &Silent).expect("nobody cancels");
    assert_eq!(again.work.lights_cut_short, 1);
    let lit = |report: &Report| report.lights[0].objects.iter().map(|object| object.lit).collect::<Vec<_>>();
    let backwards: Vec<_> = lit(&again).into_iter().rev().collect();
    assert_eq!(lit(&cut), backwards);
}

/// A floor that takes most of what all take: whatever it takes says nothing of the others.
#[test]
fn one_dear_receiver_among_many_is_not_taken_for_all() {
    let box_at = |k: u32| DVec3::new(2.0 * f64::from(k % 10) - 9.0, 0.75, 2.0 * f64::from(k / 10) - 9.0);
    let cuboid = |k: u32| placed(Shape::Cuboid(Cuboid { size: [0.5, 0.75, 0.25] }), box_at(k));
    let floor = placed(Shape::Rectangle(Rectangle { size: [64.0; 2] }), DVec3::ZERO);
    let lights = vec![Light::new("sun", LightSource::sun([0.45, -1.0, 0.3]).expect("a sun"))];
    let scene =
        Scene { objects: std::iter::once(floor).chain((0..100).map(cuboid)).collect(), lights, ..Scene::default() };
    let detail = Detail::Depth { interior: 4, boundary: 9 };
    // The least power of two that all of it takes.
    let enough = |receivers: Vec<usize>| {
        let is_cut_short = |effort: u64| {
            let (receivers, effort) = (receivers.clone(), Some(effort));
            let method = CellMethod::Quadtree;
            let request = Request { receivers, effort, method, ..Request::everything(&scene, detail) };
            bake(&scene, &request, &Silent).expect("nobody cancels").work.lights_cut_short > 0
        };
        (0..40).map(|power| 1u64 << power).find(|&effort| !is_cut_short(effort)).expect("there is one")
    };
    let [floor, boxes, all] = [enough(vec![0]), enough((1..101).collect()), enough((0..101).collect())];
    println!("the floor takes {floor}, the boxes {boxes}, all {all}");
    assert!(floor >= boxes && all <= 2 * floor);
}

/// A run of the detail would examine a hundred times as many cells.
#[test]
fn bodies_that_all_but_coincide_end() {
    let scene = pile(100);
    let request = Request { effort: Some(1 << 22), ..Request::everything(&scene, Detail::default()) };
    let report = bake(&scene, &request, &Silent).expect("nobody cancels");
    assert_eq!(report.work.lights_cut_short, 1);
    assert!(report.work.cells < 1 << 19, "{} cells", report.work.cells);
    let floor = &report.lights[0].objects[0];
    assert!(floor.lit.lower > 0.9 * floor.area && floor.lit.upper < floor.area, "{:?}", floor.lit);
}
