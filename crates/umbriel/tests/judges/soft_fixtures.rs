//! Soft shadows of the fixtures: a robot under a square light, and the eclipses.
//!
//! The robot is the setting of Duan, "A fast soft shadows algorithm for dynamic scene in MMOG" (2009): four boxes with finer geometry inside, a hundred
//! units high, over a floor. The eclipses have closed forms: cones that touch two balls.

use std::path::Path;

use glam::DVec3;
use umbriel_geometry::Analytic;
use umbriel_io::{LoadOptions, load};
use umbriel_scene::{Extent, Scene, Shape};
use umbriel_shadow::{
    Detail, Place, Queries, Silent, SoftRequest, soft_bake,
    soft_image::{LightSpace, OrientedBox, outlines},
};

fn fixture(name: &str) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(name);
    load(&file, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}")).scene
}

fn number_of(scene: &Scene, name: &str) -> usize {
    scene.objects.iter().position(|object| object.name == name).expect("an object of this name")
}

#[test]
fn at_depth_8_the_floor_is_known_to_one_per_cent() {
    let scene = fixture("robot.toml");
    let floor = number_of(&scene, "floor");
    let closed = scene.objects.iter().filter(|object| matches!(object.shape, Shape::Mesh(_)));
    for facets in closed.map(|object| object.facets().expect("flat")) {
        assert!((0..facets.len()).all(|face| facets.is_closed(face)));
    }
    let detail = Detail::Depth { interior: 8, boundary: 8 };
    let request = SoftRequest { receivers: vec![floor], keep_cells: true, ..SoftRequest::everything(&scene, detail) };
    let report = soft_bake(&scene, &request, &Silent).expect("done").remove(0).objects.remove(0);
    let queries = Queries::new(&scene);
    let light = &scene.lights[0];
    let (mut squares, mut penumbra, mut count) = (0.0, 0, 0);
    // Every third cell, at a point that is not its middle, weighted by area.
    for cell in report.cells.iter().step_by(3) {
        let area = 0.25f64.powi(i32::from(cell.level));
        let [u, v] = cell.point([0.171, 0.683]);
        let place = Place::Surface { object: floor, face: 0, u, v };
        let seen = queries.visible_fraction(&place, light).expect("a place");
        let (low, high) = (cell.lower - seen.max_error, cell.upper + seen.max_error);
        assert!(low <= seen.value && seen.value <= high, "{seen:?} {cell:?}");
        squares += 3.0 * area * (seen.value - cell.estimate).powi(2);
        penumbra += usize::from(seen.value > 0.0 && seen.value < 1.0);
        count += 1;
    }
    assert!(squares.sqrt() < 0.01, "RMSE {} of {count} points", squares.sqrt());
    assert!(penumbra > 300, "{penumbra} of {count}");
    assert!(report.umbra.lower > 1_000.0 && report.umbra.lower < report.umbra.upper);
    assert!(report.visible.upper - report.visible.lower < 0.02 * report.area, "{:?}", report.visible);
}

#[test]
fn both_arms_vanish_the_head_keeps_three_corners_and_the_body_five() {
    let scene = fixture("robot.toml");
    let origin = scene.lights[0].source.xyz();
    let parts = scene.objects.iter().filter(|object| matches!(object.shape, Shape::Mesh(_)));
    let boxes: Vec<OrientedBox> = parts.filter_map(OrientedBox::of).collect();
    assert_eq!(boxes.len(), 4);
    let corners = boxes.iter().flat_map(|oriented| oriented.corners);
    let space = LightSpace::round(origin, DVec3::Y * 50.0 - origin, corners, 64);
    let corners: Vec<usize> = outlines(&space, &boxes).iter().map(|outline| outline.corners.len()).collect();
    assert_eq!(corners, [3, 5]);
}

/// Radii and distances, metres; all middles lie on the x axis, the Earth's at 0, those of Moon and Sun before it.
struct Eclipse {
    scene: Scene,
    sun: f64,
    earth: f64,
    moon: f64,
    sun_at: f64,
    moon_at: f64,
}

/// Observers stand this far above the ground, metres.
const EYE: f64 = 10.0;

impl Eclipse {
    fn of(name: &str) -> Self {
        let scene = fixture(name);
        let (earth, moon) = (number_of(&scene, "earth"), number_of(&scene, "moon"));
        let radius = |object: usize| match scene.objects[object].shape {
            Shape::Analytic(Analytic::Sphere { radius }) => radius,
            _ => panic!("a ball"),
        };
        let Extent::Sphere { radius: sun } = scene.lights[0].extent else { panic!("the Sun is a ball") };
        let sun_at = -scene.lights[0].source.xyz().x;
        let moon_at = -scene.objects[moon].placement.map().translation.x;
        Self { sun, earth: radius(earth), moon: radius(moon), sun_at, moon_at, scene }
    }

    /// Where the cone with its apex at `apex` on the axis and this sine of half its angle meets the sphere of the observers, on the side of
    /// the Moon: the distance from the axis.
    fn cone_on_earth(&self, apex: f64, sine: f64) -> f64 {
        // x = −√(E² − r²) and r = |x − apex| t: (1 + t²) x² − 2 t² a x + t² a² − E² = 0.
        let tangent_squared = sine * sine / (1.0 - sine * sine);
        let radius = self.earth + EYE;
        let (p, q) = (1.0 + tangent_squared, tangent_squared * apex);
        let r = tangent_squared * apex * apex - radius * radius;
        let x = (q - (q * q - p * r).sqrt()) / p;
        (x - apex).abs() * tangent_squared.sqrt()
    }

    /// An observer at this distance from the axis.
    fn on_earth(&self, r: f64) -> DVec3 {
        let radius = self.earth + EYE;
        DVec3::new(-(radius * radius - r * r).sqrt(), r, 0.0)
    }

    /// The share of the Sun that no part of the Moon covers, where all of the Moon is before it.
    fn ring(&self, at: DVec3) -> f64 {
        let cap = |centre: f64, radius: f64| {
            let half = (0.5 * (radius / (DVec3::new(-centre, 0.0, 0.0) - at).length()).asin()).sin();
            4.0 * std::f64::consts::PI * half * half
        };
        1.0 - cap(self.moon_at, self.moon) / cap(self.sun_at, self.sun)
    }
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

fn assert_near(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{what}: {found} is not {expected}");
}

#[test]
fn the_eclipses_have_their_closed_forms() {
    for (name, is_total) in [("eclipse-total.toml", true), ("eclipse-annular.toml", false)] {
        let eclipse = Eclipse::of(name);
        let Eclipse { scene, sun, earth, moon, sun_at, moon_at } = &eclipse;
        let seen_in = |queries: &Queries, position: DVec3| {
            let place = Place::Free { position: position.to_array() };
            queries.visible_fraction(&place, &scene.lights[0]).expect("a place").value
        };
        let queries = Queries::new(scene);
        let seen = |r: f64| seen_in(&queries, eclipse.on_earth(r));
        let between = sun_at - moon_at;
        let umbra_length = between * moon / (sun - moon);
        // Along the axis behind the Moon, with the Earth out of the way of the ray: the umbra ends at its apex.
        let alone = Scene { objects: vec![scene.objects[number_of(scene, "moon")].clone()], ..Scene::default() };
        let alone = Queries::new(&alone);
        let behind = |x: f64| seen_in(&alone, DVec3::new(x - moon_at, 0.0, 0.0));
        let found = bisect(2.0 * moon, 2.0 * umbra_length, |x| behind(x) == 0.0);
        assert_near(found, umbra_length, "length of the umbra");
        // Across the Earth.
        let penumbra_apex = -moon_at - between * moon / (sun + moon);
        let penumbra = bisect(0.0, 0.9 * earth, |r| seen(r) < 1.0);
        assert_near(penumbra, eclipse.cone_on_earth(penumbra_apex, (sun + moon) / between), "penumbra");
        let umbra_apex = umbra_length - moon_at;
        let inner = eclipse.cone_on_earth(umbra_apex, (sun - moon) / between);
        assert_eq!(is_total, umbra_apex > -earth - EYE);
        if is_total {
            assert_near(bisect(0.0, penumbra, |r| seen(r) == 0.0), inner, "umbra, total");
        } else {
            assert!(seen(0.0) > 0.0, "annular");
            // As long as the Moon is all before the Sun.
            let is_ring = |r: f64| seen(r) - eclipse.ring(eclipse.on_earth(r)) < 4.0 * f64::EPSILON;
            assert_near(bisect(0.0, penumbra, is_ring), inner, "antumbra, annular");
        }
    }
}
