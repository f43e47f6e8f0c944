//! Scale and place: the same scene tiny, huge and far away.

use glam::{DAffine3, DQuat, DVec3};
use umbriel_geometry::{Analytic, LightSource};
use umbriel_scene::{Object, Scene};
use umbriel_shadow::ObjectReport;

use super::{judge, lamp, sampled, sun};
use crate::oracle::fixtures::{
    analytic, at, cuboid, elsewhere, l_prism, object, rectangle, scene, sphere, tetrahedron, with_sides,
};
use crate::proving::Case;

/// Flat bodies whose corners are multiples of 1/4, at most four from the origin.
fn flat_objects() -> Vec<Object> {
    vec![
        object("floor", rectangle(8.0, 8.0), at(0.0, 0.0, 0.0)),
        object("box", cuboid(1.0, 2.0, 1.5), at(1.0, 1.0, 0.0)),
        object("prism", l_prism(), at(-2.0, 0.0, -1.0)),
        object("tetrahedron", tetrahedron(), at(0.5, 2.25, -2.0)),
        with_sides("sheet", rectangle(1.0, 2.0), at(-1.0, 3.0, 1.0), umbriel_scene::Sides::Two),
    ]
}

/// Curved bodies, upright and tilted, and boxes whose corners are no floats.
fn other_objects() -> Vec<Object> {
    let tilted = |x: f64, y: f64, z: f64| {
        let turn = DQuat::from_xyzw(0.1, 0.7, 0.2, 0.3).normalize();
        DAffine3::from_rotation_translation(turn, DVec3::new(x, y, z))
    };
    let frustum = Analytic::Frustum { bottom_radius: 0.5, top_radius: 0.25, height: 0.5 };
    vec![
        object("floor", rectangle(8.0, 8.0), at(0.0, 0.0, 0.0)),
        object("ball", sphere(0.75), at(-0.5, 1.0, 2.0)),
        object("cylinder", analytic(Analytic::Cylinder { radius: 0.5, height: 1.5 }), at(2.5, 0.75, 1.5)),
        object("cone", analytic(Analytic::Cone { radius: 0.75, height: 1.25 }), at(-2.5, 1.25, -0.5)),
        object("tilted capsule", analytic(Analytic::Capsule { radius: 0.25, height: 0.75 }), tilted(0.5, 1.5, -1.5)),
        object("tilted frustum", analytic(frustum), tilted(-2.0, 2.5, 2.25)),
        object("tilted box", cuboid(1.0, 0.5, 1.5), tilted(2.0, 2.0, -2.0)),
        object("tilted sheet", rectangle(1.0, 2.0), tilted(-1.5, 1.5, -2.5)),
    ]
}

fn lights() -> [LightSource; 3] {
    [sun([0.5, -1.0, 0.25]), lamp([0.25, 3.5, 0.5]), lamp([-3.0, 0.5, 2.0])]
}

/// The light of a scene that is scaled, then moved.
fn moved(light: &LightSource, scale: f64, offset: DVec3) -> LightSource {
    if light.is_sun() { *light } else { lamp((light.xyz() * scale + offset).to_array()) }
}

/// Cells and samples of a bake.
fn decisions(scene: &Scene, light: LightSource) -> Vec<(ObjectReport, ObjectReport)> {
    let cells = Case::new("elsewhere", scene, light, 4).report.lights.remove(0).objects;
    let (_, _, mut samples) = sampled(scene, light, 2000);
    cells.into_iter().zip(samples.lights.remove(0).objects).collect()
}

/// Objects whose cells or samples are not those of the scene as it was.
fn differing(scene: &Scene, here: LightSource, moved: &Scene, there: LightSource) -> Vec<usize> {
    let pairs = decisions(scene, here).into_iter().zip(decisions(moved, there));
    let same = |(a, b): &((ObjectReport, ObjectReport), (ObjectReport, ObjectReport))| {
        a.0.cells == b.0.cells && a.1.samples == b.1.samples && a.1.answers == b.1.answers
    };
    pairs.enumerate().filter(|(_, pair)| !same(pair)).map(|(number, _)| number).collect()
}

#[test]
fn powers_of_two_change_no_decision() {
    let objects = flat_objects();
    let plain = scene(objects.clone());
    for exponent in [-180, -120, -60, -1, 60, 120, 180] {
        let scale = 2f64.powi(exponent);
        let scaled = elsewhere(&objects, scale, DVec3::ZERO);
        for light in lights() {
            let there = moved(&light, scale, DVec3::ZERO);
            let differing = differing(&plain, light, &scaled, there);
            assert!(differing.is_empty(), "2^{exponent} under {light:?}: objects {differing:?}");
            let judged = judge("scaled", &scaled, there);
            assert!(judged.cells > 100 && judged.lit > 5 && judged.samples > 150, "2^{exponent}: {judged:?}");
        }
    }
}

/// Where the moved coordinates are exact, nothing has changed.
#[test]
fn an_exact_shift_changes_no_decision() {
    for objects in [flat_objects(), other_objects()] {
        let plain = scene(objects.clone());
        for size in [2f64.powi(10), 2f64.powi(30), 2f64.powi(43)] {
            // Eight units at a distance of 2^43 is the scene's size at 10^12 times its size.
            let offset = DVec3::new(size, -size * 0.5, size * 0.75);
            let far = elsewhere(&objects, 1.0, offset);
            for light in lights() {
                let differing = differing(&plain, light, &far, moved(&light, 1.0, offset));
                assert!(differing.is_empty(), "{size} away under {light:?}: objects {differing:?}");
            }
        }
    }
}

/// Where they are rounded, the rounded scene is the scene.
#[test]
fn a_rough_shift_is_judged_as_it_is_rounded() {
    let mut objects = flat_objects();
    objects.push(object("ball", sphere(0.75), at(-0.5, 1.0, 2.0)));
    for distance in [1e6, 1e9, 8e12] {
        let offset = DVec3::new(1.0, -1.0 / 3.0, 0.7) * distance;
        let far = elsewhere(&objects, 1.0 / 3.0, offset);
        for light in lights() {
            let judged = judge("far away", &far, moved(&light, 1.0 / 3.0, offset));
            assert!(judged.lit > 5, "{distance} away under {light:?}: {judged:?}");
        }
    }
}
