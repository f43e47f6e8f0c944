//! Scenes that change: what a session answers is what a bake from scratch answers, bit for bit, and little is redone.

#![allow(clippy::print_stdout, reason = "figures are part of what these tests tell")]

use std::{sync::Arc, time::Instant};

use glam::{DAffine3, DQuat, DVec3};
use umbriel_geometry::{Analytic, Cuboid, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Change, ChangeDefect, Detail, Request, Sampling, Session, Silent, bake};

fn placed(name: &str, shape: Shape, map: DAffine3) -> Object {
    Object::new(name.into(), shape, Placement::new(map).expect("regular"), Sides::Auto).expect("an object")
}

fn at(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

fn sun(direction: [f64; 3]) -> Light {
    Light::new("sun", LightSource::sun(direction).expect("a sun"))
}

/// A wavy sheet of 2 × 8² triangles, 2 m wide.
fn sheet() -> Arc<Mesh> {
    const N: u32 = 8;
    let height = |i: u32, j: u32| 0.1 * f64::from((i * 7 + j * 5) % 4);
    let place = |k: u32| f64::from(k) / f64::from(N) * 2.0 - 1.0;
    let corners = (0..=N).flat_map(|i| (0..=N).map(move |j| (i, j)));
    let positions = corners.map(|(i, j)| [place(i), height(i, j), place(j)]).collect();
    let cells = (0..N).flat_map(|i| (0..N).map(move |j| i * (N + 1) + j));
    let triangles = cells.flat_map(|a| [[a, a + 1, a + N + 2], [a, a + N + 2, a + N + 1]]).collect();
    Arc::new(Mesh::new(positions, triangles).expect("a mesh"))
}

fn small_scene() -> Scene {
    let lamp = Light::new("lamp", LightSource::point([0.5, 6.0, 1.0]).expect("a lamp"));
    Scene {
        objects: [
            placed("floor", Shape::Rectangle(Rectangle { size: [12.0; 2] }), at(0.0, 0.0, 0.0)),
            placed("box", Shape::Cuboid(Cuboid { size: [1.0, 2.0, 1.0] }), at(-2.0, 1.0, 0.5)),
            placed("ball", Shape::from(Analytic::Sphere { radius: 0.75 }), at(2.0, 1.5, 0.0)),
            placed("sheet", Shape::Mesh(sheet()), at(0.0, 3.0, 0.0)),
        ]
        .into(),
        lights: vec![sun([0.3, -1.0, 0.2]), lamp],
        ..Scene::default()
    }
}

/// The session's answers against those of a bake of its scene.
fn check(session: &Session, request: &Request) {
    let scene = session.scene();
    let everything = Request {
        lights: (0..scene.lights.len()).collect(),
        receivers: (0..scene.objects.len()).collect(),
        ..request.clone()
    };
    let fresh = bake(scene, &everything, &Silent).expect("nobody cancels");
    assert!(session.lights().eq(&fresh.lights), "not what a bake answers");
}

#[test]
fn histories_of_changes_end_where_a_bake_begins() {
    let details = [
        (Detail::Depth { interior: 4, boundary: 6 }, None),
        (Detail::Faces, Some(Sampling::Spacing(0.2))),
        (Detail::Faces, Some(Sampling::Count(3000))),
        (Detail::MaxUndecided { share: 0.05 }, None),
    ];
    for (detail, sampling) in details {
        let scene = small_scene();
        let request = Request { sampling, keep_cells: true, ..Request::everything(&scene, detail) };
        let mut session = Session::new(scene, request.clone());
        let turned = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.7), DVec3::new(-1.0, 2.0, 0.25));
        let moved = |map| Placement::new(map).expect("regular");
        let changes = vec![
            vec![],
            vec![Change::Move { object: 1, placement: moved(turned) }],
            vec![Change::Add(placed("new", Shape::Cuboid(Cuboid { size: [0.5; 3] }), at(1.0, 4.0, 1.0)))],
            vec![Change::SetLight(0, sun([-0.2, -1.0, 0.4]))],
            vec![Change::Remove(2), Change::Move { object: 2, placement: moved(at(0.5, 2.5, 0.5)) }],
            vec![Change::RemoveLight(0), Change::AddLight(sun([0.5, -0.5, 0.1])), Change::Remove(0)],
        ];
        for step in changes {
            step.into_iter().for_each(|change| session.change(change).expect("a sound change"));
            session.update(&Silent).expect("nobody cancels");
            check(&session, &request);
        }
        let again = session.update(&Silent).expect("nobody cancels");
        let is_shared = matches!(detail, Detail::MaxUndecided { .. });
        assert_eq!(again.redone == 0, !is_shared, "nothing changed");
    }
}

#[test]
fn what_is_not_there_is_refused() {
    let scene = small_scene();
    let request = Request::everything(&scene, Detail::default());
    let mut session = Session::new(scene, request);
    let vast = Placement::new(DAffine3::from_scale(DVec3::splat(1e60))).expect("regular");
    assert_eq!(session.change(Change::Remove(4)), Err(ChangeDefect::NoObject(4)));
    assert_eq!(session.change(Change::RemoveLight(2)), Err(ChangeDefect::NoLight(2)));
    assert!(matches!(session.change(Change::Move { object: 0, placement: vast }), Err(ChangeDefect::Object(_))));
    assert_eq!(session.scene().objects.len(), 4);
}

/// A thousand sheets, each over a tile of its own.
#[test]
fn one_moved_object_among_a_thousand() {
    let mesh = sheet();
    let mut objects = Vec::new();
    for k in 0..500 {
        let (x, z) = (6.0 * f64::from(k % 25), 6.0 * f64::from(k / 25));
        objects.push(placed(&format!("tile {k}"), Shape::Rectangle(Rectangle { size: [5.0; 2] }), at(x, 0.0, z)));
        objects.push(placed(&format!("sheet {k}"), Shape::Mesh(Arc::clone(&mesh)), at(x, 1.5, z)));
    }
    let scene = Scene { objects: objects.into(), lights: vec![sun([0.3, -1.0, 0.2])], ..Scene::default() };
    let request = Request::everything(&scene, Detail::Depth { interior: 0, boundary: 4 });
    let begun = Instant::now();
    let mut session = Session::new(scene, request.clone());
    session.update(&Silent).expect("nobody cancels");
    let whole = begun.elapsed();
    let mut least = f64::INFINITY;
    for step in 1..4 {
        let placement = Placement::new(at(6.0, 1.5 + 0.1 * f64::from(step), 0.25)).expect("regular");
        let begun = Instant::now();
        session.change(Change::Move { object: 3, placement }).expect("a sound change");
        let update = session.update(&Silent).expect("nobody cancels");
        let share = begun.elapsed().as_secs_f64() / whole.as_secs_f64();
        least = least.min(share);
        println!("moved one of 1,000: {} of 1,000 redone, {:.4} of {whole:?}", update.redone, share);
        assert_eq!((update.redone, update.kept), (2, 998), "the sheet and its tile");
    }
    assert!(least < 0.05, "{least} of a whole run");
    check(&session, &request);
}

/// Three hundred balls, more over each other than are listed: only what a moved one may shadow is redone, from a tree that holds others than before.
#[test]
fn one_moved_ball_of_a_swarm() {
    let number = |k: u32, step: u32| f64::from(k * step % 997) / 997.0;
    let ball = |k: u32| {
        let place = at(2.0 * number(k, 359), 4.0 * number(k, 613), 2.0 * number(k, 787));
        placed(&format!("ball {k}"), Shape::from(Analytic::Sphere { radius: 0.25 }), place)
    };
    let lamp = Light::new("lamp", LightSource::point([0.5, 6.0, 1.0]).expect("a lamp"));
    let lights = vec![sun([0.3, -1.0, 0.2]), lamp];
    let scene = Scene { objects: (1..301).map(ball).collect(), lights, ..Scene::default() };
    let request =
        Request { keep_cells: true, ..Request::everything(&scene, Detail::Depth { interior: 1, boundary: 4 }) };
    let mut session = Session::new(scene, request.clone());
    session.update(&Silent).expect("nobody cancels");
    for (object, place) in [(7, at(0.25, 0.5, 1.75)), (250, at(1.75, 1.0, 0.125))] {
        let placement = Placement::new(place).expect("regular");
        session.change(Change::Move { object, placement }).expect("a sound change");
        let update = session.update(&Silent).expect("nobody cancels");
        assert!(update.kept > 100, "{} of 600 redone", update.redone);
        check(&session, &request);
    }
}
