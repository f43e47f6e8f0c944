//! Soft shadows of the fixtures: a robot under a square light, and the eclipses.
//!
//! The robot is the setting of Duan, "A fast soft shadows algorithm for dynamic scene in MMOG" (2009): four boxes with finer geometry inside, a hundred
//! units high, over a floor. The eclipses have closed forms: cones that touch two balls.

use std::path::Path;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Analytic, Placement};
use umbriel_io::{LoadOptions, load};
use umbriel_scene::{Extent, Scene, Shape};
use umbriel_shadow::{
    Detail, Place, Queries, Silent, SoftRequest, soft_bake,
    soft_image::{BoxTree, OrientedBox, Outline, light_space, visible_outlines},
};
use umbriel_visibility::depth_map::LightSpace;

fn fixture(name: &str) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(name);
    load(&file, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}")).scene
}

fn number_of(scene: &Scene, name: &str) -> usize {
    scene.objects.iter().position(|object| object.name == name).expect("an object of this name")
}

#[test]
fn at_depth_8_the_robot_and_its_floor_are_known_to_one_per_cent() {
    let scene = fixture("robot.toml");
    let closed = scene.objects.iter().filter(|object| matches!(object.shape, Shape::Mesh(_)));
    for facets in closed.map(|object| object.facets().expect("flat")) {
        assert!((0..facets.len()).all(|face| facets.is_closed(face)));
    }
    let detail = Detail::Depth { interior: 8, boundary: 8 };
    let request = SoftRequest { keep_cells: true, ..SoftRequest::everything(&scene, detail) };
    let report = soft_bake(&scene, &request, &Silent).expect("done").remove(0);
    let queries = Queries::new(&scene);
    let (mut squares, mut whole, mut penumbra, mut count) = (0.0, 0.0, 0, 0);
    for object in &report.objects {
        let facets = scene.objects[object.object].facets().expect("flat");
        // About ten thousand cells of each object, spread evenly, at a point that is not their middle, weighted by area.
        for cell in object.cells.iter().step_by((object.cells.len() / 10_000).max(1)) {
            let area = facets.area(cell.face as usize).value * 0.25f64.powi(i32::from(cell.level));
            let [u, v] = cell.point([0.171, 0.683]);
            let place = Place::Surface { object: object.object, face: cell.face as usize, u, v };
            // Of a cell that is cut by a triangle's edge the point may be outside.
            let Ok(seen) = queries.visible_fraction(&place, &scene.lights[0]) else { continue };
            let (low, high) = (cell.lower - seen.max_error, cell.upper + seen.max_error);
            assert!(low <= seen.value && seen.value <= high, "{seen:?} {cell:?}");
            squares += area * (seen.value - cell.estimate).powi(2);
            whole += area;
            penumbra += usize::from(seen.value > 0.0 && seen.value < 1.0);
            count += 1;
        }
    }
    let rmse = (squares / whole).sqrt();
    assert!(rmse < 0.01, "RMSE {rmse} of {count} points");
    assert!(penumbra > 300, "{penumbra} of {count}");
    let floor = &report.objects[number_of(&scene, "floor")];
    assert!(floor.umbra.lower > 1_000.0 && floor.umbra.lower < floor.umbra.upper);
    assert!(floor.visible.upper - floor.visible.lower < 0.02 * floor.area, "{:?}", floor.visible);
}

#[test]
fn both_arms_vanish_the_head_keeps_three_corners_and_the_body_five() {
    let scene = fixture("robot.toml");
    let origin = scene.lights[0].source.xyz();
    let parts = ["robot/head", "robot/body", "robot/left_arm", "robot/right_arm"].map(|name| number_of(&scene, name));
    let boxes: Vec<OrientedBox> = parts
        .map(|part| &scene.objects[part])
        .iter()
        .flat_map(|object| BoxTree::of(object).roots(object.placement.map()))
        .collect();
    assert_eq!(boxes.len(), 4);
    let corners = boxes.iter().flat_map(|oriented| oriented.corners);
    // As the light looks at the robot's middle, and as its depth map lies, along the square's normal.
    let at_robot = LightSpace::round(origin, DVec3::Y * 50.0 - origin, corners.clone(), 64);
    let corners: Vec<DVec3> = corners.collect();
    let (of_map, _) = light_space(&scene.lights[0], &corners, 64).expect("a square light");
    for space in [at_robot, of_map] {
        let whole: Vec<Outline> = boxes.iter().filter_map(|oriented| Outline::of(&space, oriented)).collect();
        let left = visible_outlines(&whole);
        let corners = |part: &Outline| {
            left.iter().find(|outline| outline.depths() == part.depths()).map(|outline| outline.corners.len())
        };
        assert_eq!(whole.iter().map(corners).collect::<Vec<_>>(), [Some(3), Some(5), None, None]);
    }
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

/// How long the cones are and how wide on the ground, metres.
#[derive(Debug)]
struct Cones {
    /// From the Moon's middle to the apex of the umbra, and how far before it that of the penumbra is.
    umbra: f64,
    penumbra: f64,
    /// From the umbra's apex to the ground; negative where it reaches the ground.
    antumbra: f64,
    /// Across the umbra or antumbra on the ground, straight, and across the penumbra.
    inner_width: f64,
    penumbra_width: f64,
}

impl Eclipse {
    /// The fixture with the Moon at another distance, if one is given.
    fn of(name: &str, distance: Option<f64>) -> Self {
        let mut scene = fixture(name);
        let (earth, moon) = (number_of(&scene, "earth"), number_of(&scene, "moon"));
        if let Some(distance) = distance {
            let map = DAffine3::from_translation(DVec3::NEG_X * distance);
            scene.objects[moon] = scene.objects[moon].moved(Placement::new(map).expect("regular")).expect("a ball");
        }
        let radius = |object: usize| match scene.objects[object].shape.analytic() {
            Some(&Analytic::Sphere { radius }) => radius,
            _ => panic!("a ball"),
        };
        let Extent::Sphere { radius: sun } = scene.lights[0].extent else { panic!("the Sun is a ball") };
        let sun_at = -scene.lights[0].source.xyz().x;
        let moon_at = -scene.objects[moon].placement.map().translation.x;
        Self { sun, earth: radius(earth), moon: radius(moon), sun_at, moon_at, scene }
    }

    /// By cones that touch both balls.
    fn cones(&self) -> Cones {
        let Self { sun, earth, moon, sun_at, moon_at, .. } = *self;
        let between = sun_at - moon_at;
        let (umbra, penumbra) = (between * moon / (sun - moon), between * moon / (sun + moon));
        Cones {
            umbra,
            penumbra,
            antumbra: moon_at - earth - umbra,
            inner_width: 2.0 * self.cone_on_earth(umbra - moon_at, (sun - moon) / between),
            penumbra_width: 2.0 * self.cone_on_earth(-moon_at - penumbra, (sun + moon) / between),
        }
    }

    /// Where the cone with its apex at `apex` on the axis and this sine of half its angle meets the Earth's surface, on the side of
    /// the Moon: the distance from the axis.
    fn cone_on_earth(&self, apex: f64, sine: f64) -> f64 {
        // x = −√(E² − r²) and r = |x − apex| t: (1 + t²) x² − 2 t² a x + t² a² − E² = 0.
        let tangent_squared = sine * sine / (1.0 - sine * sine);
        let (p, q) = (1.0 + tangent_squared, tangent_squared * apex);
        let r = tangent_squared * apex * apex - self.earth * self.earth;
        let x = (q - (q * q - p * r).sqrt()) / p;
        (x - apex).abs() * tangent_squared.sqrt()
    }

    /// The share of the Sun that no part of the Moon covers, where all of the Moon is before it.
    fn ring(&self, at: DVec3) -> f64 {
        let cap = |centre: f64, radius: f64| {
            let half = (0.5 * (radius / (DVec3::new(-centre, 0.0, 0.0) - at).length()).asin()).sin();
            4.0 * std::f64::consts::PI * half * half
        };
        1.0 - cap(self.moon_at, self.moon) / cap(self.sun_at, self.sun)
    }

    /// By how much the width of an umbra or antumbra may seem wider: a share of the Sun is rounded by sixteen units, and a sliver of it that is δ wide between two
    /// circles of radius about R is at least the share 4√2/(3π)·(δ/R)^1.5 of the disk. R is the Sun's image where the Moon is, and there are two sides.
    fn sliver(&self) -> f64 {
        let radius = self.sun * self.moon_at / self.sun_at;
        let share = 16.0 * f64::EPSILON * 3.0 * std::f64::consts::PI / (4.0 * 2f64.sqrt());
        2.0 * radius * share.powf(2.0 / 3.0)
    }

    /// By bisection on the visible fraction alone: along the axis behind the Moon, with the Earth out of the way, and on the
    /// Earth's own surface, a line of one of its patches from the point under the Moon.
    fn measured(&self) -> Cones {
        let expected = self.cones();
        let seen_in = |scene: &Scene, place: Place| {
            Queries::new(scene).visible_fraction(&place, &self.scene.lights[0]).expect("a place").value
        };
        let alone =
            Scene { objects: [self.scene.objects[number_of(&self.scene, "moon")].clone()].into(), ..Scene::default() };
        let on_axis = |x: f64| seen_in(&alone, Place::Free { position: [x - self.moon_at, 0.0, 0.0] });
        let umbra = bisect(2.0 * self.moon, 2.0 * expected.umbra, |x| on_axis(x) == 0.0);
        let earth = number_of(&self.scene, "earth");
        let placed = self.scene.objects[earth].analytic().expect("a ball");
        let position = |face: usize, u: f64| placed.charts()[face].bounded_point(placed.placement(), u, 0.5).position;
        let face = (0..6).min_by(|&a, &b| position(a, 0.5).x.total_cmp(&position(b, 0.5).x)).expect("six patches");
        let queries = Queries::new(&self.scene);
        let seen = |u: f64| {
            let place = Place::Surface { object: earth, face, u, v: 0.5 };
            queries.visible_fraction(&place, &self.scene.lights[0]).expect("a place").value
        };
        let width = |u: f64| 2.0 * position(face, u).y.hypot(position(face, u).z);
        let outer = bisect(0.5, 1.0, |u| seen(u) < 1.0);
        let inner = if seen(0.5) == 0.0 {
            bisect(0.5, outer, |u| seen(u) == 0.0)
        } else {
            // As long as the Moon is all before the Sun.
            bisect(0.5, outer, |u| seen(u) - self.ring(position(face, u)) < 4.0 * f64::EPSILON)
        };
        let antumbra = self.moon_at - self.earth - umbra;
        // The penumbra's apex is before the Moon, where nothing is hidden: its place follows from its width on the ground.
        Cones { umbra, penumbra: expected.penumbra, antumbra, inner_width: width(inner), penumbra_width: width(outer) }
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

/// Six distances of the Moon from the nearest to the farthest, metres.
const DISTANCES: [f64; 6] = [3.6e8, 3.69e8, 3.78e8, 3.87e8, 3.96e8, 4.06e8];

#[test]
fn the_eclipses_have_their_closed_forms() {
    assert!(Eclipse::of("eclipse-total.toml", None).cones().antumbra < 0.0);
    assert!(Eclipse::of("eclipse-annular.toml", None).cones().antumbra > 0.0);
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/soft.md");
    let page = std::fs::read_to_string(page).expect("the page with the table");
    for distance in DISTANCES {
        let eclipse = Eclipse::of("eclipse-total.toml", Some(distance));
        let (expected, found) = (eclipse.cones(), eclipse.measured());
        assert_near(found.umbra, expected.umbra, "length of the umbra");
        assert_near(found.penumbra_width, expected.penumbra_width, "width of the penumbra");
        let off = (found.inner_width - expected.inner_width).abs();
        assert!(off <= 1e-9 * expected.inner_width + eclipse.sliver(), "umbra or antumbra: {found:?} {expected:?}");
        let row = eclipse_row(distance, &found);
        assert!(page.contains(&row), "docs/soft.md lacks {row}");
    }
}

/// The row of the page's table: kilometres to the metre.
fn eclipse_row(distance: f64, cones: &Cones) -> String {
    let km = |metres: f64| format!("{:.3}", 1e-3 * metres);
    let kind = if cones.antumbra < 0.0 { "total" } else { "annular" };
    let Cones { umbra, penumbra, antumbra, inner_width, penumbra_width } = *cones;
    let lengths = [distance, umbra, penumbra, antumbra.max(0.0), inner_width, penumbra_width].map(km).join(" | ");
    format!("| {kind} | {lengths} |")
}
