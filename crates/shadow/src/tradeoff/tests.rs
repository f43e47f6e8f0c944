//! Settings on a box over a floor, whose shadow is known.

use umbriel_geometry::{Cuboid, LightSource, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};

use super::*;
use crate::{
    Silent,
    rivals::{Literal, ShadowMap, ShadowVolume},
};

/// A box of 1 that stands in the air over a floor of 8 × 8, under a slanting sun.
fn scene() -> Scene {
    let object = |name: &str, shape, height: f64| {
        let map = glam::DAffine3::from_translation(glam::DVec3::new(0.0, height, 0.0));
        let placement = Placement::new(map).expect("regular");
        Object::new(name.into(), shape, placement, Sides::Auto).expect("an object")
    };
    let floor = object("floor", Shape::Rectangle(Rectangle { size: [8.0, 8.0] }), 0.0);
    let cuboid = object("box", Shape::Cuboid(Cuboid { size: [1.0; 3] }), 1.5);
    let sun = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
    Scene { objects: [floor, cuboid].into(), lights: vec![Light::new("sun", sun)], ..Scene::default() }
}

#[test]
fn settings_are_judged_by_the_truth() {
    let scene = scene();
    let polygons = Polygons::new(&scene, 1);
    let judge = Judge::new(&scene, &polygons, &scene.lights[0].source, 50_000);
    let course = Course { scene: &scene, polygons: &polygons, light: 0, judge: &judge };
    let run = |setting: Setting| measure(&course, &setting, &Silent).expect("a measurement");
    let bake = |boundary| run(Setting::Bake(Detail::Depth { interior: 0, boundary }));
    let bakes = [3, 5, 7].map(bake);
    assert!(bakes.iter().all(|bake| bake.score.wrong == 0), "proofs: {bakes:?}");
    // A cell reaches no farther than the cube's edge / 2^depth; a spacing of the judged points may be added.
    let spacing = (70.0f64 / 50_000.0).sqrt() * 2.0;
    for (bake, depth) in bakes.iter().zip([3, 5, 7]) {
        assert!(bake.score.border_distance <= 8.0 / f64::from(1 << depth) + spacing, "{bake:?}");
        assert!(bake.score.undecided > 0);
    }
    assert!(bakes[2].score.error() < 0.3 * bakes[0].score.error());
    assert_eq!(run(Setting::Points).score.error(), 0.0, "exact");
    assert_eq!(run(Setting::PointsOfSolids).score.error(), 0.0, "exact");
    let limits = [Detail::MaxUndecided { share: 0.01 }, Detail::Memory { bytes: 100_000 }, Detail::Cell { edge: 0.2 }];
    for limit in limits.map(|detail| run(Setting::Bake(detail))) {
        assert!(limit.score.wrong == 0 && limit.score.error() < 0.05, "{limit:?}");
    }
    let few = [Setting::Samples(2000), Setting::RaySamples(2000)].map(run);
    assert_eq!(few[0].score, few[1].score, "the same samples, the same answers");
    assert!(few[0].score.wrong > 0 && few[0].score.error() < 0.02);
    let rivals: [Box<dyn Rival>; 4] = [
        Box::new(PointRays),
        Box::new(ShadowVolume::default()),
        Box::new(ShadowMap::new(512)),
        Box::new(Literal { interior: 4, boundary: 7, most_rays: u64::MAX }),
    ];
    let errors = rivals.map(|rival| run(Setting::Rival(rival)).score.error());
    assert_eq!(errors[..2], [0.0, 0.0], "exact up to rounding");
    assert!(errors[2] > 0.0 && errors[2] < 0.01 && errors[3] > 0.0 && errors[3] < 0.01, "{errors:?}");
}

#[test]
fn the_front_and_what_is_recommended() {
    let one = |name: &str, family, seconds, wrong| Measurement {
        name: name.into(),
        family,
        ready_seconds: 0.0,
        first_seconds: 0.0,
        second_seconds: seconds,
        rays: 0,
        pieces: 0,
        bytes: 0,
        score: Score { points: 100, wrong, ..Score::default() },
    };
    let all = [
        one("coarse", Family::Bake, 1.0, 10),
        one("fine", Family::Bake, 3.0, 2),
        one("slow", Family::ShadowMap, 2.0, 10),
        one("quick", Family::Rays, 2.0, 2),
    ];
    assert_eq!(pareto(&all, Measurement::seconds), [true, false, false, true]);
    let name = |error, with_bounds| recommend(&all, error, with_bounds).map(|one| one.name.as_str());
    assert_eq!((name(0.05, false), name(0.05, true), name(0.2, true)), (Some("quick"), Some("fine"), Some("coarse")));
    assert_eq!(name(0.01, false), None);
}
