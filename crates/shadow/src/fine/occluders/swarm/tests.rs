//! What is looked up in a tree is what going through all bodies finds.

use std::array::from_fn;

use glam::{DAffine3, DVec3};
use umbriel_bvh::may_shadow;
use umbriel_geometry::{Analytic, Placement};
use umbriel_scene::{Object, Scene, Shape, Sides};

use super::*;
use crate::bodies::Bodies;

/// Numbers from 0 to 1.
fn dice() -> impl FnMut() -> f64 {
    let mut state = 7u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn scene() -> Scene {
    let mut dice = dice();
    let ball = |k: usize| {
        let (radius, place) = (0.1 + 0.25 * dice(), DVec3::new(dice(), 1.5 * dice(), dice()));
        let placement = Placement::new(DAffine3::from_translation(place)).expect("regular");
        let shape = Shape::from(Analytic::Sphere { radius });
        Object::new(format!("{k}"), shape, placement, Sides::Auto).expect("an object")
    };
    Scene { objects: (0..400).map(ball).collect(), ..Scene::default() }
}

/// Whether a body of the 400 that may shadow the receiver hides a point of it: the same whichever is asked first.
fn is_hidden_as_by_all(
    occluders: &Occluders,
    above: &Above,
    point: &Receiver<1>,
    may_shadow: impl Fn(u32) -> bool,
) -> bool {
    let is_over = |object: &u32| may_shadow(*object) && occluders.is_body_over(*object, &point.points);
    let over: Vec<u32> = (0..400).filter(|&object| object != above.own).filter(is_over).collect();
    let is_hidden = over.iter().any(|&object| occluders.probably_blocks(object, point));
    for first in [over.first().copied(), over.last().copied(), None] {
        match occluders.probably_hides(above, point, first) {
            Ok(body) => assert!(over.contains(&body) && occluders.probably_blocks(body, point)),
            Err(asked) => assert!(!is_hidden && asked >= over.len() as u64),
        }
    }
    is_hidden
}

/// Under a sun, one that comes equally along all axes, and a lamp of which several frames see some hulls.
#[test]
fn what_is_above_is_what_going_through_all_finds() {
    let lights = [LightSource::sun([0.5, -1.0, 0.25]), LightSource::sun([1.0; 3]), LightSource::point([0.5, 2.0, 0.5])];
    let scene = scene();
    let bodies = Bodies::new(&scene);
    let (mut few, mut kept_out, mut hidden) = (0, [0; 2], 0);
    for light in lights.map(|light| light.expect("a light")) {
        let occluders = Occluders::new(&bodies, &light);
        let swarm = Swarm::new(&occluders, 0..400).expect("many");
        let mut dice = dice();
        for receiver in 0..100 {
            let bounds = bodies.bounds(receiver);
            let above = swarm.above(bounds, &light, receiver as u32);
            let size = 0.25 * dice();
            let corner = bounds.min + DVec3::new(dice(), dice(), dice()) * (1.0 - size) * bounds.size();
            let points: [Point; HULL] = from_fn(|k| {
                let side = DVec3::from_array(from_fn(|axis| f64::from(k as u32 >> axis & 1)));
                Point::exact(corner + side * size * bounds.size())
            });
            let cells = occluders.cells_over(&points);
            let may_shadow = |object: u32| {
                let body = bodies.bounds(object as usize);
                may_shadow(&body, &bounds, &light) && !cannot_shadow(&body, &bounds, &light)
            };
            let meets = |object: u32, (view, cell): &(usize, Aabb)| {
                occluders.view_of_body(object, *view).is_some_and(|body| body.meets(cell))
            };
            let (seen, ties): (Vec<_>, Vec<_>) = cells.iter().partition(|(view, _)| *view < occluders.frames.len());
            let over = (0..400).filter(|&object| object != receiver as u32);
            let over: Vec<u32> = over.filter(|&object| seen.iter().any(|cell| meets(object, cell))).collect();
            let all: Vec<u32> =
                over.iter().copied().filter(|&object| ties.iter().all(|tie| meets(object, tie))).collect();
            kept_out[0] += over.len() - all.len();
            let (all, no_occluders): (Vec<u32>, Vec<u32>) = all.into_iter().partition(|&object| may_shadow(object));
            kept_out[1] += no_occluders.len();
            few += usize::from(all.len() <= MANY);
            let expected = (all.len() <= MANY).then(|| all.clone());
            assert_eq!(occluders.few_above(&above, &points), expected, "{receiver} under {light:?}");
            let counted = occluders.counted(&above, &points).count;
            assert!((all.len().min(COUNTED)..=COUNTED).contains(&counted));
            let point = Receiver { points: [points[0]], light: &light, facing: None, plane: None };
            hidden += usize::from(is_hidden_as_by_all(&occluders, &above, &point, may_shadow));

            let cells = occluders.views_of(&points);
            let promise = |object: u32| Some((-occluders.least_promise(object, &cells)?, object));
            let sorted = |mut promises: Vec<(f64, u32)>| {
                promises.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
                promises
            };
            let promising = sorted(all.into_iter().filter_map(promise).collect());
            // With all that promise as much as the last one.
            let worst = promising.get(LOOKED_AT - 1).map_or(f64::INFINITY, |(entry, _)| *entry);
            let promising: Vec<(f64, u32)> = promising.into_iter().filter(|(entry, _)| *entry <= worst).collect();
            let best = occluders.best_above(&above, &points).into_iter().map(|(entry, body)| (entry, body.object));
            let best = sorted(best.collect());
            assert_eq!(best, promising, "{receiver} under {light:?}");
        }
    }
    assert!((50..290).contains(&hidden), "{hidden} hidden");
    assert!((50..250).contains(&few) && kept_out.iter().all(|&count| count > 10), "{few} few, {kept_out:?} kept out");
}

/// Of bodies that promise the same all are found, or none.
#[test]
fn bodies_that_promise_the_same_stand_together() {
    let ball = |k: usize| {
        let shape = Shape::from(Analytic::Sphere { radius: if k < 3 { 2.0 } else { 1.0 } });
        Object::new(format!("{k}"), shape, Placement::IDENTITY, Sides::Auto).expect("an object")
    };
    let beside = Placement::new(DAffine3::from_translation(DVec3::X * 50.0)).expect("regular");
    let sun = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
    for (same, found) in [(2 * LOOKED_AT - 3, 2 * LOOKED_AT), (2 * LOOKED_AT, 3)] {
        let others = (0..MANY).map(|k| ball(k).moved(beside).expect("in range"));
        let scene = Scene { objects: (0..3 + same).map(ball).chain(others).collect(), ..Scene::default() };
        let bodies = Bodies::new(&scene);
        let occluders = Occluders::new(&bodies, &sun);
        let swarm = Swarm::new(&occluders, 0..scene.objects.len()).expect("many");
        let below = Aabb { min: DVec3::new(-0.1, -5.0, -0.1), max: DVec3::new(0.1, -4.0, 0.1) };
        let above = swarm.above(below, &sun, u32::MAX);
        let points = below.corners().map(Point::exact);
        assert_eq!(occluders.best_above(&above, &points).len(), found);
    }
}

/// A cell that two frames of a lamp see, under bodies that both see as well: each frame shows all of them to its end and no farther.
#[test]
fn the_ends_of_frames_say_nothing() {
    let ball = |k: u32| {
        let place = DVec3::new(2.5, 0.001 * f64::from(k), 2.5);
        let shape = Shape::from(Analytic::Sphere { radius: if k == 50 { 1.0 } else { 0.5 } });
        let placement = Placement::new(DAffine3::from_translation(place)).expect("regular");
        Object::new(format!("{k}"), shape, placement, Sides::Auto).expect("an object")
    };
    let scene = Scene { objects: (0..100).map(ball).collect(), ..Scene::default() };
    let (bodies, lamp) = (Bodies::new(&scene), LightSource::point([0.0; 3]).expect("a lamp"));
    let occluders = Occluders::new(&bodies, &lamp);
    let swarm = Swarm::new(&occluders, 0..100).expect("many");
    let below = Aabb { min: DVec3::new(4.9, -0.1, 4.9), max: DVec3::new(5.1, 0.1, 5.1) };
    let points = below.corners().map(Point::exact);
    assert_eq!(occluders.views_of(&points).len(), 2);
    let best = occluders.best_above(&swarm.above(below, &lamp, u32::MAX), &points);
    assert_eq!(best.first().map(|(_, body)| body.object), Some(50));
}
