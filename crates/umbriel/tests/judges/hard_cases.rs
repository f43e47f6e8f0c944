//! Scenes that once had, or could easily have, a wrong proof; each says what is special about it.

use crate::oracle::{
    Oracle,
    dice::Dice,
    fixtures::{self, at, cuboid, elsewhere, mesh, object, rectangle, scene, sphere},
};
use crate::proving::Case;
use glam::{DAffine3, DMat3, DVec3};
use umbriel_geometry::LightSource;
use umbriel_scene::Scene;
use umbriel_shadow::{Detail, LitArea, Place, Queries, Request, SamplePoint, Sampling, Silent, bake, for_each_sample};

/// Judges all proved cells at depth 4; tells how many there are.
fn judge(name: &str, scene: &Scene, light: LightSource) -> usize {
    let case = Case::new(name, scene, light, 4);
    let (oracle, mut dice) = (Oracle::new(scene), Dice::new(name, 0));
    let proved = case.proved();
    let wrong: Vec<String> = proved.iter().filter_map(|&cell| case.judge(&oracle, cell, 24, &mut dice)).collect();
    assert!(wrong.is_empty(), "{} of {}: {}", wrong.len(), proved.len(), wrong[0]);
    proved.len()
}

fn noon() -> LightSource {
    LightSource::sun([0.0, -1.0, 0.0]).expect("a sun")
}

/// Two corners of a sliver round to the same floats, yet one is exactly there and the other is not: they lie on
/// different sides of the shadow's border.
#[test]
fn corners_that_only_round_alike_are_two() {
    let tiny = 2f64.powi(-60);
    let columns = [DVec3::new(tiny, 0.0, 0.0), DVec3::Y, DVec3::new(-tiny, 0.0, 1.0)];
    let sliver = DAffine3 { matrix3: DMat3::from_cols_array_2d(&columns.map(|c| c.to_array())), translation: DVec3::X };
    let roof = mesh(&[[1.0, 2.0, -4.0], [9.0, 2.0, 0.0], [1.0, 2.0, 4.0]], &[[0, 1, 2]]);
    let objects = vec![object("sliver", rectangle(2.0, 2.0), sliver), object("roof", roof, DAffine3::IDENTITY)];
    assert!(judge("sliver", &scene(objects), noon()) > 0);
}

/// Squares of squares of coordinates leave the range of floats: proofs about spheres must not mistake that for zeros,
/// and the same cells are decided at any scale that is not extreme.
#[test]
fn spheres_far_below_and_above_a_metre() {
    let objects = [
        object("floor", rectangle(8.0, 8.0), DAffine3::IDENTITY),
        object("ball", sphere(1.0), at(0.0, 2.0, 0.0)),
        object("box", cuboid(1.0, 1.0, 1.0), at(2.0, 2.0, 0.0)),
    ];
    for lamp in [[0.25, 5.0, 0.5], [0.0, 2.5, 0.0]].map(Some).into_iter().chain([None]) {
        let proved = [0, -80, -100, -120, -140, -170, -190, 60, 100, 150, 190].map(|exponent| {
            let scale = 2f64.powi(exponent);
            let at = |lamp: [f64; 3]| LightSource::point(lamp.map(|coordinate| coordinate * scale)).expect("a light");
            (exponent, judge("scaled", &elsewhere(&objects, scale, DVec3::ZERO), lamp.map_or_else(noon, at)))
        });
        for (exponent, count) in proved.into_iter().filter(|(exponent, _)| (-140..=100).contains(exponent)) {
            assert_eq!(count, proved[0].1, "scale 2^{exponent}, lamp {lamp:?}");
        }
    }
}

/// Whole patches, which samples alone do not divide: where nothing bounds an area, the bake says so and goes on.
#[test]
fn samples_alone_of_every_curved_body() {
    for (name, whole) in fixtures::all() {
        let whole = fixtures::lit_by(whole, noon());
        let sampling = Some(Sampling::Spacing(whole.objects[0].bounds().size().max_element() / 24.0));
        let request = Request { sampling, ..Request::everything(&whole, Detail::Faces) };
        let report = bake(&whole, &request, &Silent).expect("nobody cancels");
        let (queries, mut lit) = (Queries::new(&whole), vec![0; whole.objects.len()]);
        for_each_sample(&whole, &request, |SamplePoint { object, face, u, v, .. }| {
            let answer = queries.lit(&Place::Surface { object, face, u, v }, &noon());
            lit[object] += u64::from(answer.expect("a point of the surface").lit);
        });
        for object in &report.lights[0].objects {
            let samples = object.samples.expect("samples were asked for");
            let is_curved = whole.objects[object.object].analytic().is_some();
            assert!(!is_curved || samples.lit == lit[object.object], "{name}: {object:?}");
            let LitArea { lower, upper, estimate } = object.lit;
            assert!(0.0 <= lower && lower <= estimate && estimate <= upper, "{name}: {object:?}");
            assert!(upper.is_finite() || object.area_error == f64::INFINITY, "{name}: {object:?}");
        }
    }
}
