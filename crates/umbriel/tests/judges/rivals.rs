//! The rivals against the oracle: what should be right is, and what is wrong is wrong for the reason that is told.

use crate::oracle::{
    Oracle, cases,
    dice::Dice,
    fixtures::{all, at, cuboid, has_triangles, lit_by, object, rectangle, scene, sphere, tetrahedron, with_sides},
};
use glam::DAffine3;
use umbriel_geometry::LightSource;
use umbriel_scene::{Object, Scene, Shape, Sides};
use umbriel_shadow::{
    Detail, Place, Queries, Request, SamplePoint, Sampling, for_each_sample,
    rivals::{Literal, PointRays, Polygons, Rival, RivalPoint, RivalRefusal, ShadowMap, ShadowVolume},
};

/// Points of any face, with the points that rivals get.
fn some_points(scene: &Scene, polygons: &Polygons, count: u64, dice: &mut Dice) -> Vec<(SamplePoint, RivalPoint)> {
    let mut points = Vec::new();
    while (points.len() as u64) < count {
        let object = dice.index(scene.objects.len());
        let body = &scene.objects[object];
        let face = dice.index(body.face_count());
        let (mut u, mut v) = (dice.float(0.0, 1.0), dice.float(0.0, 1.0));
        if has_triangles(&body.shape) && u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let sample = SamplePoint { object, face, u, v, corner: 0, from_corner: [u, v] };
        points.extend(polygons.point(&sample).map(|point| (sample, point)));
    }
    points
}

/// A sun or a lamp in no special place.
fn plain_light(scene: &Scene, dice: &mut Dice) -> LightSource {
    let bounds = scene.objects.iter().fold(umbriel_geometry::Aabb::EMPTY, |all, object| all.union(object.bounds()));
    let coordinates = |dice: &mut Dice| -> [f64; 3] { std::array::from_fn(|_| dice.float(-1.0, 1.0)) };
    if dice.one_in(2) {
        return LightSource::sun(coordinates(dice)).expect("a sun");
    }
    let place = bounds.center() + glam::DVec3::from_array(coordinates(dice)) * bounds.size() * 0.8;
    LightSource::point(place.to_array()).expect("a lamp")
}

/// The scene with its floors let down a little: nothing lies on them, so that floats can tell on which side of them a point is.
fn on_no_floor(scene: &Scene) -> Scene {
    let lowered = |object: &Object| {
        let map =
            *object.placement.map() * if object.name == "floor" { at(0.0, -0.125, 0.0) } else { DAffine3::IDENTITY };
        with_sides(&object.name, object.shape.clone(), map, object.sides)
    };
    Scene { objects: scene.objects.iter().map(lowered).collect(), ..Scene::default() }
}

/// How many points of flat fixtures a rival answers otherwise than the oracle, and of how many.
fn wrong_answers(rival: &dyn Rival, is_taken: impl Fn(&str) -> bool) -> (u64, u64, Vec<String>) {
    let (mut asked, mut wrong, mut told) = (0, 0, Vec::new());
    let is_flat = |scene: &Scene| !scene.objects.iter().any(|object| matches!(object.shape, Shape::Analytic(_)));
    for (name, scene) in all().iter().filter(|(name, scene)| is_flat(scene) && is_taken(name)) {
        let scene = &on_no_floor(scene);
        let (oracle, polygons) = (Oracle::new(scene), Polygons::new(scene, 1));
        for round in 0..cases(6) {
            let mut dice = Dice::new("rivals", round);
            let light = plain_light(scene, &mut dice);
            let points = some_points(scene, &polygons, 150, &mut dice);
            let given: Vec<RivalPoint> = points.iter().map(|(_, point)| *point).collect();
            let answer = rival.answer(&polygons, &light, &given).expect("an answer");
            for ((sample, _), lit) in points.iter().zip(answer.lit) {
                let SamplePoint { object, face, u, v, .. } = *sample;
                asked += 1;
                if oracle.lit(object, face, [u, v], &light) != lit {
                    wrong += 1;
                    told.push(format!("{name}, round {round}: {sample:?} is not lit = {lit} by {light:?}"));
                }
            }
        }
    }
    told.truncate(5);
    (wrong, asked, told)
}

/// Left out: scenes where faces lie on one another, which rounded points cannot tell apart.
fn has_no_contact(name: &str) -> bool {
    !["coplanar", "degenerate", "indoors", "instances"].contains(&name)
}

#[test]
fn rays_are_right() {
    let (wrong, asked, told) = wrong_answers(&PointRays, has_no_contact);
    assert!(wrong == 0 && asked > 4000, "{wrong} of {asked}: {told:#?}");
}

#[test]
fn shadow_volumes_are_right() {
    let (wrong, asked, told) = wrong_answers(&ShadowVolume::default(), has_no_contact);
    assert!(wrong == 0 && asked > 4000, "{wrong} of {asked}: {told:#?}");
}

#[test]
fn the_eye_does_not_change_what_shadow_volumes_say() {
    let (_, scene) = all().into_iter().find(|(name, _)| *name == "hulls").expect("there are hulls");
    let polygons = Polygons::new(&scene, 1);
    let mut dice = Dice::new("eyes", 0);
    let light = LightSource::point([1.5, 7.0, -2.25]).expect("a lamp");
    let points: Vec<RivalPoint> =
        some_points(&scene, &polygons, 2000, &mut dice).into_iter().map(|(_, point)| point).collect();
    let eyes = [None, Some([30.0, 1.1, 2.3]), Some([-20.2, -15.7, 3.1]), Some([2.1, 40.0, 1.3])];
    let answers = eyes.map(|eye| {
        let rival = ShadowVolume { eye: eye.map(glam::DVec3::from_array) };
        rival.answer(&polygons, &light, &points).expect("an answer").lit
    });
    let differ = |k: &usize| answers.iter().any(|answer| answer[*k] != answers[0][*k]);
    let told: Vec<_> =
        (0..points.len()).filter(differ).map(|k| (points[k], answers.each_ref().map(|a| a[k]))).collect();
    assert!(told.is_empty(), "{} points: {:#?}", told.len(), &told[..told.len().min(4)]);
    assert!(answers[0].iter().any(|&lit| lit) && answers[0].iter().any(|&lit| !lit));
}

/// A unit box 1 over a floor of 8 × 8.
fn box_over_floor() -> Scene {
    scene(vec![
        object("floor", rectangle(8.0, 8.0), DAffine3::IDENTITY),
        object("box", cuboid(1.0, 1.0, 1.0), at(0.0, 1.5, 0.0)),
    ])
}

/// The share of about `count` sampled points that a rival gets wrong.
fn wrong_share(scene: &Scene, rival: &dyn Rival, count: u64, divisions: u32) -> f64 {
    let light = scene.lights[0].source;
    let polygons = Polygons::new(scene, divisions);
    let request = Request { sampling: Some(Sampling::Count(count)), ..Request::everything(scene, Detail::default()) };
    let mut samples = Vec::new();
    for_each_sample(scene, &request, |sample| samples.push(sample));
    let points: Vec<RivalPoint> = samples.iter().map(|sample| polygons.point(sample).expect("surface")).collect();
    let answer = rival.answer(&polygons, &light, &points).expect("an answer");
    let queries = Queries::new(scene);
    let is_wrong = |(sample, lit): &(&SamplePoint, bool)| {
        let SamplePoint { object, face, u, v, .. } = **sample;
        queries.lit(&Place::Surface { object, face, u, v }, &light).expect("a point").lit != *lit
    };
    samples.iter().zip(answer.lit).filter(is_wrong).count() as f64 / samples.len() as f64
}

/// The shadow's outline is at most 4√2·(1 + …) long and crosses texels; half of those it meets are wrong at most, and there is nothing else to be wrong about.
#[test]
fn shadow_maps_err_at_borders_only() {
    for light in
        [LightSource::sun([0.3, -1.0, 0.2]), LightSource::point([0.5, 5.0, 1.0]), LightSource::point([0.4, 1.8, 1.5])]
    {
        let scene = lit_by(box_over_floor(), light.expect("a light"));
        let shares = [64, 256, 1024].map(|size| wrong_share(&scene, &ShadowMap::new(size), 200_000, 1));
        assert!(shares[0] > 0.0, "a coarse map errs: {shares:?}");
        assert!(shares[1] < 0.5 * shares[0] && shares[2] < 0.5 * shares[1], "texels four times as small: {shares:?}");
    }
}

#[test]
fn the_literal_method_is_right_where_its_words_are() {
    let scene = lit_by(box_over_floor(), LightSource::sun([0.3, -1.0, 0.2]).expect("a sun"));
    let literal = |boundary| Literal { interior: 4, boundary, most_rays: 10_000_000 };
    let shares = [5, 6, 7, 8].map(|boundary| wrong_share(&scene, &literal(boundary), 100_000, 1));
    // Half a cell on both sides of an outline of about 5 m, of 70 m² in all: 5 · 8/2^8 / 2 / 70.
    assert!(shares[3] < 1.2e-3 && shares[3] < 0.5 * shares[1], "{shares:?}");
}

#[test]
fn the_literal_method_misses_what_the_source_leaves_open() {
    let sun = LightSource::sun([0.0, -1.0, 0.1]).expect("a sun");
    // A tilted plate under a box: no corner of any box round the plate lies on it.
    let tilted = DAffine3::from_translation(glam::DVec3::new(0.0, 0.5, 0.0)) * DAffine3::from_rotation_x(0.3);
    let plate =
        vec![object("plate", rectangle(2.0, 2.0), tilted), object("box", cuboid(4.0, 1.0, 4.0), at(0.0, 3.0, 0.0))];
    let literal = Literal { interior: 4, boundary: 6, most_rays: 10_000_000 };
    let scene_of = |objects| lit_by(scene(objects), sun);
    assert!(wrong_share(&scene_of(plate), &literal, 10_000, 1) > 0.02, "the plate is in shadow as a whole");
    // Two boxes that shadow half of a third one each: alone neither meets all eight rays, cell by cell both do.
    let folded = vec![with_sides("tent", tetrahedron(), at(0.0, 0.0, 0.0), Sides::Two)];
    let own = wrong_share(&scene_of(folded), &literal, 10_000, 1);
    assert!(own > 0.1, "a body does not shadow itself: {own}");
    let few = Literal { most_rays: 10, ..literal };
    let scene = lit_by(box_over_floor(), sun);
    let refused = few.answer(&Polygons::new(&scene, 1), &sun, &[]);
    assert_eq!(refused.expect_err("too many"), RivalRefusal::TooManyRays { limit: 10 });
}

/// What is wrong with a ball of triangles falls with the square of their size.
#[test]
fn curved_bodies_are_cut_into_triangles() {
    let ball =
        vec![object("floor", rectangle(8.0, 8.0), DAffine3::IDENTITY), object("ball", sphere(1.0), at(0.0, 1.5, 0.0))];
    let scene = lit_by(scene(ball), LightSource::sun([0.3, -1.0, 0.2]).expect("a sun"));
    for rival in [&PointRays as &dyn Rival, &ShadowVolume::default()] {
        let shares = [4, 8, 16].map(|divisions| wrong_share(&scene, rival, 200_000, divisions));
        assert!(shares[0] > 0.0 && shares[1] < 0.4 * shares[0] && shares[2] < 0.4 * shares[1], "{shares:?}");
    }
}

/// The triangles that stand for a body do not shadow points of the body itself.
#[test]
fn a_ball_has_its_own_light() {
    let scene = lit_by(
        scene(vec![object("ball", sphere(1.0), at(0.0, 1.5, 0.0))]),
        LightSource::point([3.0, 2.0, 1.0]).expect("a lamp"),
    );
    for rival in [&PointRays as &dyn Rival, &ShadowVolume::default()] {
        assert_eq!(wrong_share(&scene, rival, 20_000, 4), 0.0, "{}", rival.name());
    }
}
