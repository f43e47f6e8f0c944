//! Far from the origin only the input's rounding shows.
//!
//! Each closed form is placed a thousand, a million and 10^12 of its sizes away. There its numbers are rounded, and the rounded scene
//! is the scene: the truth about it lies within the bounds, and what is undecided is a narrow band (`floor.rs`). Then that
//! scene is brought back, which rounds nothing, as differences of nearby floats are floats: what is left undecided far away must be
//! what is left undecided here, verdict for verdict. `UMBRIEL_CASES` sets the number of scenes of each kind, light and distance, `UMBRIEL_FIRST` the first.

use std::ops::Range;

use glam::{DAffine3, DVec3};
use umbriel_geometry::LightSource;
use umbriel_scene::{Object, Scene};
use umbriel_shadow::{Cell, Detail, ObjectReport, Request, Silent, bake};

use crate::{
    closed_forms, closed_forms_solids,
    floor::Case,
    forms::chance::Kind,
    oracle::{
        case_numbers,
        dice::Dice,
        fixtures::{lit_by, scene, with_sides},
    },
};

const DISTANCES: [f64; 3] = [1e3, 1e6, 1e12];

/// `to` − `from`, which must be a float on every axis.
fn way(from: DVec3, to: DVec3) -> DVec3 {
    let way = to - from;
    assert_eq!(from + way, to, "the way back is a float");
    assert_eq!(to - way, from, "the way back is a float");
    way
}

/// The scene with `origin` moved to zero.
fn brought_back(far: &Scene, origin: DVec3) -> Scene {
    let moved = |object: &Object| {
        let map = object.placement.map();
        let near = DAffine3 { translation: way(origin, map.translation), ..*map };
        with_sides(&object.name, object.shape.clone(), near, object.sides)
    };
    let light = &far.lights[0].source;
    let near = |source: &LightSource| LightSource::point(way(origin, source.xyz()).to_array()).expect("a lamp");
    lit_by(scene(far.objects.iter().map(moved).collect()), if light.is_sun() { *light } else { near(light) })
}

/// With cells of a size in metres: that of a box in the world is rounded.
fn objects_of(scene: &Scene, edge: f64) -> Vec<ObjectReport> {
    let request = Request { keep_cells: true, ..Request::everything(scene, Detail::Cell { edge }) };
    bake(scene, &request, &Silent).expect("nobody cancels").lights.remove(0).objects
}

/// The first cell that is another one far away.
fn differing<'a>(far: &'a ObjectReport, near: &'a ObjectReport) -> Option<(&'a Cell, &'a Cell)> {
    far.cells.iter().zip(&near.cells).find(|(a, b)| a != b)
}

fn judge(title: &str, numbers: &Range<u64>, make: impl Fn(&mut Dice, &[f64]) -> Option<Case>) {
    let mut judged = 0;
    let all = DISTANCES.into_iter().flat_map(|distance| numbers.clone().map(move |number| (distance, number)));
    for (place, (distance, number)) in all.enumerate() {
        // The next dice, where rounding leaves the truth open.
        let any = |attempt: u64| make(&mut Dice::new(title, 100 * number + attempt), &[distance]);
        let Some(case) = (0..100).find_map(any) else { continue };
        judged += 1;
        if let Err(complaint) = case.judge(place as u64) {
            panic!("{title}, {distance} units away, case {number}: {complaint}; {:?}", case.scene);
        }
        let origin = case.scene.objects[0].placement.map().translation;
        let near = brought_back(&case.scene, origin);
        // Not a power of two below any edge, as that is rounded far away, too.
        let edge = 0.9 * case.cell_edge();
        for (far, near) in objects_of(&case.scene, edge).iter().zip(&objects_of(&near, edge)) {
            let name = format!("{title}, {distance} units away, case {number}, object {}", far.object);
            let [undecided_far, undecided_near] = [far, near].map(ObjectReport::undecided);
            assert_eq!([far.area, far.area_error], [near.area, near.area_error], "{name}");
            assert_eq!(far.lit, near.lit, "{name}");
            assert!(
                far.cells == near.cells,
                "{name}: {undecided_far} undecided, {undecided_near} at the origin, {:?}; {:?}",
                differing(far, near),
                case.scene
            );
        }
    }
    assert_eq!(judged, DISTANCES.len() as u64 * (numbers.end - numbers.start), "{title}: scenes with a certain truth");
}

#[test]
fn boxes_under_any_light() {
    for is_sun in [true, false] {
        judge(&format!("far box {is_sun}"), &case_numbers(1), |dice, distances| {
            closed_forms::any_case(dice, distances, false, is_sun)
        });
    }
}

#[test]
fn curved_bodies_under_a_sun() {
    for kind in Kind::ALL {
        judge(&format!("far {kind:?} in the sun"), &case_numbers(1), |dice, distances| {
            closed_forms_solids::any_case(dice, distances, kind, true)
        });
    }
}

#[test]
fn curved_bodies_under_a_lamp() {
    for kind in Kind::ALL {
        judge(&format!("far {kind:?} by a lamp"), &case_numbers(1), |dice, distances| {
            closed_forms_solids::any_case(dice, distances, kind, false)
        });
    }
}
