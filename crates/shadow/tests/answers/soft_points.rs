//! The visible fraction of points, against closed forms and against many exact rays.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use umbriel_geometry::{Analytic, Cuboid, LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Extent, Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{Place, Queries};

use crate::dice::Dice;

fn object(name: &str, shape: Shape, map: DAffine3) -> Object {
    let placement = Placement::new(map).expect("regular");
    Object::new(name.into(), shape, placement, Sides::Auto).expect("a body")
}

fn ball(radius: f64, center: DVec3) -> Object {
    object("ball", Shape::from(Analytic::Sphere { radius }), DAffine3::from_translation(center))
}

fn lamp(center: DVec3, extent: Extent) -> Light {
    Light::with_extent("lamp", LightSource::point(center.to_array()).expect("a point"), extent).expect("a light")
}

fn sun(direction: [f64; 3], angular_diameter: f64) -> Light {
    let source = LightSource::sun(direction).expect("a sun");
    Light::with_extent("sun", source, Extent::Disk { angular_diameter }).expect("a light")
}

fn free(position: DVec3) -> Place {
    Place::Free { position: position.to_array() }
}

/// The place where `is_inside` turns from true (at `low`) to false (at `high`).
fn bisect(mut low: f64, mut high: f64, is_inside: impl Fn(f64) -> bool) -> f64 {
    assert!(is_inside(low) && !is_inside(high), "the border lies between");
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low.min(high) || middle >= low.max(high) {
            return middle;
        }
        if is_inside(middle) { low = middle } else { high = middle }
    }
}

fn assert_near(found: f64, expected: f64, relative: f64, what: &str) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{what}: {found} is not {expected}");
}

#[test]
fn a_ball_over_a_floor_has_the_radii_of_its_umbra_and_penumbra() {
    // Light of radius R at the height H, ball of radius r at the height h, both over the origin.
    let (light_radius, light_height, radius, height) = (0.5, 10.0, 1.0, 3.0);
    let scene = Scene { objects: [ball(radius, DVec3::new(0.0, height, 0.0))].into(), ..Scene::default() };
    let light = lamp(DVec3::new(0.0, light_height, 0.0), Extent::Sphere { radius: light_radius });
    let queries = Queries::new(&scene);
    let seen = |x: f64| queries.visible_fraction(&free(DVec3::new(x, 0.0, 0.0)), &light).expect("a place").value;
    let between = light_height - height;
    // Tangent cones: apexes where the radii are in the ratio of the distances.
    let umbra_apex = light_height + between * light_radius / (radius - light_radius);
    let tangent = |sine: f64| sine / (1.0f64 - sine * sine).sqrt();
    let umbra = umbra_apex * tangent((radius - light_radius) / between);
    let penumbra_apex = light_height - between * light_radius / (radius + light_radius);
    let penumbra = penumbra_apex * tangent((radius + light_radius) / between);
    assert_near(bisect(0.0, 5.0, |x| seen(x) == 0.0), umbra, 1e-9, "umbra");
    assert_near(bisect(0.0, 9.0, |x| seen(x) < 1.0), penumbra, 1e-9, "penumbra");
}

#[test]
fn a_rectangle_under_a_parallel_rectangle_has_the_overlap_of_rectangles() {
    // A light of half edges 1 and 2 at the height 8, an occluder of half edges 1.5 and 0.5 at the height 3.
    let shape = Shape::Rectangle(Rectangle { size: [3.0, 1.0] });
    let scene = Scene {
        objects: [object("plate", shape, DAffine3::from_translation(DVec3::Y * 3.0))].into(),
        ..Scene::default()
    };
    let light = lamp(DVec3::Y * 8.0, Extent::Rectangle { u: DVec3::X, v: DVec3::Z * 2.0 });
    let queries = Queries::new(&scene);
    let overlap = |x: f64, half_plate: f64, half_light: f64| {
        // The plate's image on the light's plane from x.
        let image = |edge: f64| x + (edge - x) * 8.0 / 3.0;
        let (low, high) = (image(-half_plate).max(-half_light), image(half_plate).min(half_light));
        (high - low).max(0.0) / (2.0 * half_light)
    };
    for (i, j) in (0..21).flat_map(|i| (0..21).map(move |j| (i, j))) {
        let (x, z) = (0.31 * f64::from(i) - 3.1, 0.23 * f64::from(j) - 2.3);
        let seen = queries.visible_fraction(&free(DVec3::new(x, 0.0, z)), &light).expect("a place");
        let expected = 1.0 - overlap(x, 1.5, 1.0) * overlap(z, 0.5, 2.0);
        assert!(
            (seen.value - expected).abs() <= seen.max_error && seen.max_error < 1e-11,
            "({x}, {z}): {seen:?} {expected}"
        );
    }
}

/// A plate half-way to a light far aside; all numbers are short, so that the share of 5/8 is exact.
#[test]
fn bounds_hold_far_aside_of_a_light() {
    for x in [0.25, 1_000.25, 1_000_000.25, 1_000_000_000.25] {
        for height in [8.0, 700_001.0, 1_234_567.0] {
            // From x an edge e at half the height is seen at 2e − x: at 1/4, and beyond the light.
            let (near, far) = (0.5 * x + 0.125, 0.5 * x + 5.0);
            let shape = Shape::Rectangle(Rectangle { size: [far - near, 64.0] });
            let middle = DVec3::new(0.5 * (near + far), 0.5 * height, 0.0);
            let objects = vec![object("plate", shape, DAffine3::from_translation(middle))];
            let scene = Scene { objects: objects.into(), ..Scene::default() };
            let light = lamp(DVec3::Y * height, Extent::Rectangle { u: DVec3::X, v: DVec3::Z * 2.0 });
            let seen = Queries::new(&scene).visible_fraction(&free(DVec3::X * x), &light).expect("a place");
            assert!((seen.value - 0.625).abs() <= seen.max_error, "{x}, {height}: {seen:?}");
        }
    }
}

/// Lights seen at a grazing angle, one with edges that are nearly parallel: no digit of the inverse of its axes is right in floats, and the bound says so.
#[test]
fn bounds_hold_where_a_light_is_a_needle() {
    let u = DVec3::new(0.9144652231682989, 0.7713461635755045, 1.3991075526609589);
    for v in [DVec3::new(0.94045245323253, 0.7932662431208143, 1.4388673285625195), DVec3::new(-0.5, 1.0, 0.25)] {
        let centre = DVec3::new(0.6853951105353164, 0.5781268394221618, 1.0486363543551827) * 4.0;
        let light = lamp(centre, Extent::Rectangle { u, v });
        // Half-way, half as large, an edge through the middle: it hides the half of the light with positive shares of u.
        let at = |a: f64, b: f64| ((centre + u * a + v * b) * 0.5).to_array();
        let corners = vec![at(0.0, -4.0), at(4.0, -4.0), at(4.0, 4.0), at(0.0, 4.0)];
        let plate = Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).expect("a mesh");
        let objects = vec![object("plate", Shape::Mesh(Arc::new(plate)), DAffine3::IDENTITY)];
        let scene = Scene { objects: objects.into(), ..Scene::default() };
        let seen = Queries::new(&scene).visible_fraction(&free(DVec3::ZERO), &light).expect("a place");
        assert!((seen.value - 0.5).abs() <= seen.max_error, "{v}: {seen:?}");
        let is_wide = v.x < 0.0;
        assert_eq!(seen.max_error < 1e-3, is_wide, "{v}: {seen:?}");
    }
}

#[test]
fn what_is_proved_all_free_or_all_hidden_is_exact() {
    // Neither flat nor balls: the light is sampled where a body may be in the way.
    let body = |shape, at| object("body", Shape::from(shape), DAffine3::from_translation(at));
    let wide = Analytic::Cylinder { radius: 30.0, height: 1.0 };
    let scene = Scene { objects: [body(wide, DVec3::Y * 4.0)].into(), ..Scene::default() };
    let lights = [
        lamp(DVec3::Y * 9.0, Extent::Rectangle { u: DVec3::X, v: DVec3::Z * 2.0 }),
        lamp(DVec3::Y * 9.0, Extent::Sphere { radius: 1.0 }),
        sun([0.1, -1.0, 0.2], 5.0),
    ];
    for light in &lights {
        let seen = |scene, x| Queries::new(scene).visible_fraction(&free(DVec3::X * x), light).expect("a place");
        let [hidden, partly] = [0.3, 60.0].map(|x| seen(&scene, x));
        assert_eq!((hidden.value, hidden.max_error), (0.0, 0.0), "{light:?}");
        assert!(partly.max_error > 0.0 || partly.value == 1.0, "{light:?}: {partly:?}");
    }
    // In a corner of the square round a round light, beside the light itself.
    let beside = body(Analytic::Cylinder { radius: 0.05, height: 0.05 }, DVec3::new(0.45, 4.5, 0.45));
    let scene = Scene { objects: [beside].into(), ..Scene::default() };
    let seen = Queries::new(&scene).visible_fraction(&free(DVec3::ZERO), &lights[1]).expect("a place");
    // Squares of the light that the body's outline touches are cut to 2^-32 of it.
    assert!(seen.value == 1.0 && seen.max_error < 1e-9, "{seen:?}");
    // Far from the origin the light's points are rounded coarsely; nothing is claimed that rounding may undo.
    let far = DVec3::splat(2f64.powi(40));
    let scene = Scene { objects: [body(wide, far + DVec3::Y * 4.0)].into(), ..Scene::default() };
    let light = lamp(far + DVec3::Y * 9.0, Extent::Rectangle { u: DVec3::X, v: DVec3::Z });
    let seen = Queries::new(&scene).visible_fraction(&free(far), &light).expect("a place");
    assert_eq!((seen.value, seen.max_error), (0.0, 0.0));
}

#[test]
fn the_horizon_takes_its_part() {
    // A one-sided wall that looks along −z; the light's middle lies in its plane: half of it is above the horizon.
    let wall = Object::new(
        "wall".into(),
        Shape::Rectangle(Rectangle { size: [2.0, 2.0] }),
        Placement::new(DAffine3::from_quat(DQuat::from_xyzw(0.5f64.sqrt(), 0.0, 0.0, 0.5f64.sqrt()))).expect("regular"),
        Sides::One,
    );
    let scene = Scene { objects: [wall.expect("a wall")].into(), ..Scene::default() };
    let queries = Queries::new(&scene);
    let place = Place::Surface { object: 0, face: 0, u: 0.25, v: 0.5 };
    for light in [
        lamp(DVec3::new(0.0, 5.0, 0.0), Extent::Sphere { radius: 1.0 }),
        lamp(DVec3::new(0.0, 5.0, 0.0), Extent::Rectangle { u: DVec3::X, v: DVec3::Z }),
        sun([0.0, -1.0, 0.0], 0.53),
    ] {
        let seen = queries.visible_fraction(&place, &light).expect("a place");
        assert!((seen.value - 0.5).abs() < 1e-12, "{seen:?} {light:?}");
    }
}

/// Some points of the light as seen from `eye`, each standing for an equal share of it.
fn light_points(eye: DVec3, light: &Light, count: u32) -> Vec<LightSource> {
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(count);
    let squares = (0..count).flat_map(|i| (0..count).map(move |j| (at(i), at(j))));
    let around = |towards: DVec3, radius: f64, (s, t): (f64, f64)| {
        // Equal shares of a cap: the cosine is even.
        let cosine = 1.0 - s * (1.0 - radius.cos());
        let (u, v) = towards.normalize().any_orthonormal_pair();
        let sine = (1.0 - cosine * cosine).sqrt();
        let turn = t * std::f64::consts::TAU;
        towards.normalize() * cosine + (u * turn.cos() + v * turn.sin()) * sine
    };
    let centre = light.source.xyz();
    let point = |p: DVec3| LightSource::point(p.to_array()).expect("a point");
    squares
        .map(|(s, t)| match light.extent {
            Extent::Rectangle { u, v } => point(centre + u * (2.0 * s - 1.0) + v * (2.0 * t - 1.0)),
            Extent::Disk { angular_diameter } => {
                let towards = around(centre, 0.5 * angular_diameter.to_radians(), (s, t));
                LightSource::sun((-towards).to_array()).expect("a sun")
            }
            Extent::Sphere { radius } => {
                let distance = (centre - eye).length();
                let towards = around(centre - eye, (radius / distance).asin(), (s, t));
                let middle = towards.dot(centre - eye);
                let half = (radius * radius - distance * distance + middle * middle).max(0.0).sqrt();
                point(eye + towards * (middle - half))
            }
            _ => light.source,
        })
        .collect()
}

#[test]
fn random_scenes_agree_with_many_exact_rays() {
    let mut dice = Dice(11);
    let mut partly = [0; 3];
    for round in 0..90 {
        let mut objects = Vec::new();
        for k in 0..3 {
            let shape = match (round / 3 + k) % 5 {
                0 | 1 => Shape::Cuboid(Cuboid { size: dice.vector(0.3, 1.5).to_array() }),
                2 => Shape::Rectangle(Rectangle { size: [dice.next(0.3, 2.0), dice.next(0.3, 2.0)] }),
                3 => Shape::from(Analytic::Sphere { radius: dice.next(0.2, 0.6) }),
                _ => Shape::from(Analytic::Cylinder { radius: dice.next(0.1, 0.5), height: dice.next(0.3, 1.0) }),
            };
            let map = DAffine3::from_rotation_translation(dice.turn(), dice.vector(-1.0, 1.0) + DVec3::Y * 2.0);
            objects.push(object("thing", shape, map));
        }
        objects.push(object("floor", Shape::Rectangle(Rectangle { size: [8.0; 2] }), DAffine3::IDENTITY));
        let scene = Scene { objects: objects.into(), ..Scene::default() };
        let centre = dice.vector(-1.0, 1.0) + DVec3::Y * 7.0;
        let light = match round % 3 {
            0 => lamp(centre, Extent::Sphere { radius: dice.next(0.2, 1.0) }),
            1 => lamp(centre, Extent::Rectangle { u: dice.vector(-0.7, 0.7), v: dice.vector(-0.7, 0.7) }),
            _ => sun([dice.next(-0.5, 0.5), -1.0, dice.next(-0.5, 0.5)], dice.next(0.5, 20.0)),
        };
        let queries = Queries::new(&scene);
        for _ in 0..4 {
            let (object, u, v) = (3, dice.next(0.3, 0.7), dice.next(0.3, 0.7));
            let place = Place::Surface { object, face: 0, u, v };
            let seen = queries.visible_fraction(&place, &light).expect("a place");
            let eye = DVec3::new(8.0 * (u - 0.5), 0.0, 8.0 * (v - 0.5));
            const COUNT: u32 = 48;
            // The floor's first edge may run along either axis: only its place matters here.
            let floor_eye = scene.objects[3].facets().expect("flat");
            let corners: Vec<DVec3> = floor_eye.positions().to_vec();
            let eye = if eye.is_finite() {
                corners[0] + (corners[1] - corners[0]) * u + (corners[3] - corners[0]) * v
            } else {
                eye
            };
            let points = light_points(eye, &light, COUNT);
            let lit = points.iter().filter(|source| queries.lit(&place, source).expect("a place").lit).count();
            let sampled = lit as f64 / points.len() as f64;
            // Borders of shadows cross some squares: of length up to about six edges of the light.
            let tolerance = 4.0 / f64::from(COUNT);
            assert!(
                (seen.value - sampled).abs() <= seen.max_error + tolerance,
                "{round}: {seen:?} {sampled} {light:?}"
            );
            partly[round % 3] += usize::from(sampled > 0.02 && sampled < 0.98);
        }
    }
    assert!(partly.iter().all(|&count| count > 12), "penumbrae were met: {partly:?}");
}

/// Before a rectangle light a ball is no closed form, nor is a can before any light: what is stated there holds many exact rays, and is narrow.
#[test]
fn sampled_shares_have_narrow_bounds() {
    let body = |shape, at| object("body", Shape::from(shape), DAffine3::from_translation(at));
    let lights = [
        lamp(DVec3::Y * 10.0, Extent::Rectangle { u: DVec3::X * 0.5, v: DVec3::Z * 0.5 }),
        lamp(DVec3::Y * 10.0, Extent::Sphere { radius: 0.5 }),
        sun([0.1, -1.0, 0.0], 5.0),
    ];
    let bodies = [
        Analytic::Sphere { radius: 1.0 },
        Analytic::Cylinder { radius: 1.0, height: 1.0 },
        Analytic::Cone { radius: 1.0, height: 1.5 },
        Analytic::Capsule { radius: 0.6, height: 1.0 },
        Analytic::Ellipsoid { radii: [1.0, 0.5, 0.8] },
    ];
    let (mut sampled, mut widest) = (0, 0.0_f64);
    for (number, shape) in bodies.into_iter().enumerate() {
        let scene = Scene { objects: [body(shape, DVec3::Y * 3.0)].into(), ..Scene::default() };
        let queries = Queries::new(&scene);
        for light in &lights {
            for x in 0..12 {
                let eye = DVec3::new(0.2 * f64::from(x), 0.0, 0.3);
                let seen = queries.visible_fraction(&free(eye), light).expect("a place");
                const COUNT: u32 = 64;
                let points = light_points(eye, light, COUNT);
                let lit = points.iter().filter(|source| queries.lit(&free(eye), source).expect("a place").lit).count();
                let by_rays = lit as f64 / points.len() as f64;
                // The border of the shadow crosses at most some three rows of squares.
                let tolerance = 3.0 / f64::from(COUNT);
                assert!((seen.value - by_rays).abs() <= seen.max_error + tolerance, "{number}: {seen:?} {by_rays}");
                sampled += usize::from(seen.value > 0.02 && seen.value < 0.98);
                widest = widest.max(seen.max_error);
            }
        }
    }
    // The two polyhedra are a per cent of the radius apart, 10/3 as much on the light's plane, along no more than the light's diagonal.
    assert!(sampled > 25 && widest < 0.05, "{sampled} {widest}");
}
