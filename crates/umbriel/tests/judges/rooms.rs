//! Cells and portals: nothing that rays meet is missing from what is reached, and shadows are those of the whole scene.
//!
//! `cargo xtask portals` does the first with far more eyes, and `cargo xtask soak` goes on with others.

use std::path::Path;

use glam::{DAffine3, DVec3};
use umbriel::{
    geometry::{LightSource, Placement},
    io::{LoadOptions, load},
    scene::{Camera, CellGraph, Light, Projection, Region, Scene},
    shadow::{Change, Detail, Place, Queries, Request, Session, Silent, Verdict, bake, reached_receivers},
    visibility::{
        Ray, RayCaster, View,
        portals::{Start, frustum_culling, reach_of_eye, reach_of_light},
    },
};

use crate::oracle::{case_numbers, dice::Dice};

fn office() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/office/office.toml");
    load(&path, &LoadOptions::default()).expect("the office").scene
}

/// A number between −1 and 1.
fn signed(dice: &mut Dice) -> f64 {
    dice.below(1 << 20) as f64 / f64::from(1 << 19) - 1.0
}

/// A place in a random room, off the walls.
fn place(scene: &Scene, dice: &mut Dice) -> glam::DVec3 {
    let cells = scene.cells.cells();
    loop {
        if let Region::Convex(body) = &cells[dice.index(cells.len())].region {
            let bounds = body.bounds();
            let half = bounds.size() * 0.5 - 0.1;
            return bounds.center() + half * glam::DVec3::new(signed(dice), signed(dice), signed(dice));
        }
    }
}

#[test]
fn nothing_that_is_seen_is_missing() {
    let scene = office();
    let caster = RayCaster::new(&scene);
    let (mut met, mut drawn, mut framed) = (0, 0, 0);
    for case in case_numbers(300) {
        let dice = &mut Dice::new("rooms", case);
        let eye = place(&scene, dice);
        let target = eye + glam::DVec3::new(signed(dice), 0.2 * signed(dice), signed(dice) + 1e-3);
        let projection = Projection::Perspective { vertical_degrees: 20.0 + 70.0 * signed(dice).abs() };
        let view = View { camera: Camera { eye, target, up: glam::DVec3::Y, projection }, width: 160, height: 100 };
        let reach = reach_of_eye(&scene, &view).expect("an eye");
        assert_eq!(reach.start, Start::Cells);
        let seen: Vec<usize> = reach.indices().collect();
        drawn += seen.len();
        framed += frustum_culling(&scene, &view).expect("an eye").len();
        let lamp = place(&scene, dice);
        let light = LightSource::point(lamp.to_array()).expect("a lamp");
        let lit: Vec<usize> = reach_of_light(&scene, &light).indices().collect();
        for _ in 0..40 {
            let ahead = view.ray(80.0 * (1.0 + signed(dice)), 50.0 * (1.0 + signed(dice)));
            let around = Ray::new(lamp, glam::DVec3::new(signed(dice), signed(dice), signed(dice) + 1e-3));
            for (ray, reached) in [(ahead, &seen), (around, &lit)] {
                let Some(hit) = caster.nearest(&ray) else { continue };
                met += 1;
                let name = &scene.objects[hit.object].name;
                assert!(reached.binary_search(&hit.object).is_ok(), "case {case}: {name} is seen along {ray:?}");
            }
        }
    }
    assert!(met > 0 && 20 * drawn < framed, "{met} rays met something; {drawn} drawn, {framed} in the frusta");
}

#[test]
fn a_session_follows_through_portals() {
    let mut scene = office();
    scene.lights = vec![scene.lights[2].clone()];
    let reached = reached_receivers(&scene, &[0]);
    let size = |&object: &usize| scene.cells.bounds()[object].size().length();
    let least =
        |objects: &mut dyn Iterator<Item = usize>| objects.min_by(|a, b| size(a).total_cmp(&size(b))).expect("some");
    let lit = least(&mut reached.iter().copied());
    let dark = least(&mut (0..scene.objects.len()).filter(|object| reached.binary_search(object).is_err()));
    let [lit_map, dark_map] = [lit, dark].map(|object| *scene.objects[object].placement.map());
    let request = Request::everything(&scene, Detail::Depth { interior: 3, boundary: 3 });
    let mut session = Session::new(scene, request.clone());
    let to = |map| Placement::new(map).expect("regular");
    let lamp =
        Light::new("other", LightSource::point((dark_map.translation + 0.4 * DVec3::Y).to_array()).expect("a lamp"));
    let steps: [(Vec<Change>, [bool; 2]); 4] = [
        (vec![], [true, false]),
        // Each takes the other's place.
        (
            vec![Change::Move {
                object: lit,
                placement: to(DAffine3 { translation: dark_map.translation, ..lit_map }),
            }],
            [false, false],
        ),
        (
            vec![Change::Move {
                object: dark,
                placement: to(DAffine3 { translation: lit_map.translation, ..dark_map }),
            }],
            [false, true],
        ),
        (vec![Change::SetLight(0, lamp)], [true, true]),
    ];
    for (number, (changes, are_reached)) in steps.into_iter().enumerate() {
        changes.into_iter().for_each(|change| session.change(change).expect("a sound change"));
        let update = session.update(&Silent).expect("nobody cancels");
        let reached = reached_receivers(session.scene(), &[0]);
        assert_eq!([lit, dark].map(|object| reached.binary_search(&object).is_ok()), are_reached, "step {number}");
        let fresh = bake(session.scene(), &request, &Silent).expect("nobody cancels");
        assert!(session.lights().eq(&fresh.lights), "step {number}: not what a bake answers");
        assert!(number != 1 || update.redone < 100, "{} redone for one that moves", update.redone);
    }
}

#[test]
fn shadows_are_those_of_the_whole_scene() {
    let scene = office();
    let light = 2;
    let detail = Detail::Depth { interior: 5, boundary: 5 };
    let receivers = reached_receivers(&scene, &[light]);
    let request = |receivers: Vec<usize>| Request {
        lights: vec![light],
        receivers,
        keep_cells: true,
        ..Request::everything(&scene, detail)
    };
    let ours = bake(&scene, &request(receivers.clone()), &Silent).expect("nobody cancels");
    let whole = Scene { cells: CellGraph::default(), ..scene.clone() };
    let theirs = bake(&whole, &request(receivers.clone()), &Silent).expect("nobody cancels");
    for (ours, theirs) in ours.lights[0].objects.iter().zip(&theirs.lights[0].objects) {
        let name = &scene.objects[ours.object].name;
        assert_eq!((ours.object, ours.area), (theirs.object, theirs.area), "{name}");
        assert!(ours.lit.lower <= theirs.lit.upper && theirs.lit.lower <= ours.lit.upper, "{name}");
    }
    let work = ours.work.portals;
    assert_eq!(work.objects, receivers.len() as u64);
    assert_eq!((work.objects + work.objects_left_out, work.lights_outside), (scene.objects.len() as u64, 0));
    // What is left out gets no light: cells, and points asked one by one of the whole scene.
    let queries = Queries::new(&whole);
    let dark = (0..scene.objects.len()).filter(|object| receivers.binary_search(object).is_err());
    let dark: Vec<usize> = dark.step_by(97).collect();
    let report = bake(&scene, &request(dark.clone()), &Silent).expect("nobody cancels");
    assert_eq!(report.work.portals.lights_left_out, 1);
    for object in &report.lights[0].objects {
        assert!(object.area > 0.0 && object.lit.upper == 0.0);
        assert!(!object.cells.is_empty() && object.cells.iter().all(|cell| cell.verdict == Verdict::Shadowed));
        for face in 0..scene.objects[object.object].face_count() {
            let point = Place::Surface { object: object.object, face, u: 0.375, v: 0.25 };
            let answer = queries.lit(&point, &scene.lights[light].source).expect("a point of a face");
            assert!(!answer.lit, "{} face {face}", scene.objects[object.object].name);
        }
    }
}
