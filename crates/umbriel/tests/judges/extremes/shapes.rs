//! Shapes that hardly have an area, a volume or a tip.

use std::f64::consts::PI;

use glam::{DAffine3, DVec3};
use umbriel_geometry::Analytic;
use umbriel_scene::{Object, Scene, Shape, Sides};
use umbriel_shadow::{CellMethod, Place, Queries};

use super::{judge, lamp, sampled, sun};
use crate::{
    oracle::{
        Oracle,
        dice::Dice,
        fixtures::{analytic, at, cuboid, mesh, object, rectangle, scene, with_sides},
    },
    proving::Case,
};

fn floor() -> Object {
    object("floor", rectangle(8.0, 8.0), DAffine3::IDENTITY)
}

/// The lit area of the floor, which must be the first object.
fn floor_light(scene: &Scene, light: umbriel_geometry::LightSource) -> [f64; 2] {
    let case = Case::new("closed form", scene, light, 6);
    let lit = case.report.lights[0].objects[0].lit;
    [lit.lower, lit.upper]
}

#[test]
fn needles_of_aspect_a_billion() {
    let width = 1e-9;
    let needle = [[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.9, 1.0, 2.0 * width]];
    let tilted = [[-1.0, 0.5, -1.0], [1.0, 2.5, 1.0], [0.0, 1.5 + width, 0.0]];
    // A square of needles, side by side, over the corner of the floor.
    let strips = 8u32;
    let at = |k: u32| f64::from(k) * width;
    let positions: Vec<[f64; 3]> = (0..=strips).flat_map(|k| [[3.0, 1.0, at(k)], [4.0, 1.0, at(k)]]).collect();
    let quads = (0..strips).map(|k| [2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2]);
    let strip: Vec<[u32; 3]> = quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let whole = scene(vec![
        floor(),
        object("needle", mesh(&needle, &[[0, 1, 2]]), DAffine3::IDENTITY),
        object("tilted", mesh(&tilted, &[[0, 1, 2]]), DAffine3::IDENTITY),
        object("strip", mesh(&positions, &strip), DAffine3::IDENTITY),
    ]);
    for light in [sun([0.0, -1.0, 0.0]), sun([1.0, -1.0, 1.0]), lamp([0.0, 2.0, width]), lamp([0.0, 3.0, 0.0])] {
        let judged = judge("needles", &whole, light);
        assert!(judged.samples > 100, "{judged:?}");
    }
    // The middle of the needle's shadow, between its edges and beside them.
    let queries = Queries::new(&whole);
    let lit = |z: f64| {
        let place = Place::Free { position: [0.5, 0.0, z] };
        queries.lit(&place, &sun([0.0, -1.0, 0.0])).expect("accepted").lit
    };
    assert_eq!([-1e-15, 0.0, width, 1.58 * width, 1.6 * width].map(lit), [true, false, false, true, true]);
}

#[test]
fn nothing_twice_and_folded_back() {
    let corners = [[-1.0, 1.0, -1.0], [1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [0.0, 1.0, 0.0]];
    let folded = [
        // Once, again, and turned round.
        [0, 2, 1],
        [0, 2, 1],
        [0, 1, 2],
        // Folded back over the common edge (0, 2): both lie on the same side of it.
        [0, 4, 1],
        [2, 4, 1],
        // A segment and a point.
        [0, 4, 2],
        [3, 3, 3],
        [1, 4, 4],
    ];
    for sides in [Sides::Auto, Sides::One, Sides::Two] {
        let whole = scene(vec![floor(), with_sides("folded", mesh(&corners, &folded), DAffine3::IDENTITY, sides)]);
        for light in [
            sun([0.0, -1.0, 0.0]),
            sun([1.0, 0.0, 0.0]),
            sun([-1.0, -1.0, -1.0]),
            lamp([0.0, 2.0, 0.0]),
            lamp([0.5, 1.0, 0.5]),
            lamp([1.0, 1.0, -1.0]),
            lamp([0.0, -1.0, 0.0]),
        ] {
            judge("folded", &whole, light);
        }
        // Whatever is folded, the shadow is the triangle (0, 1, 2).
        let [lower, upper] = floor_light(&whole, sun([0.0, -1.0, 0.0]));
        assert!(lower <= 62.0 && 62.0 <= upper && upper - lower < 1.5, "{lower} {upper}");
    }
}

/// A disk of ten thousand triangles round one vertex.
fn fan(blades: u32) -> Object {
    let angle = |k: u32| f64::from(k) * (2.0 * PI / f64::from(blades));
    let rim = (0..blades).map(|k| [2.0 * angle(k).cos(), 1.0, 2.0 * angle(k).sin()]);
    let accepted = |x: f64| if x.abs() < 1e-12 { 0.0 } else { x };
    let positions: Vec<[f64; 3]> = rim.chain([[0.0, 1.0, 0.0]]).map(|p| p.map(accepted)).collect();
    let triangles: Vec<[u32; 3]> = (0..blades).map(|k| [blades, (k + 1) % blades, k]).collect();
    object("fan", mesh(&positions, &triangles), DAffine3::IDENTITY)
}

#[test]
fn ten_thousand_triangles_round_a_vertex() {
    let blades = 10_000;
    let whole = scene(vec![floor(), fan(blades)]);
    let noon = sun([0.0, -1.0, 0.0]);
    let shadow = f64::from(blades) / 2.0 * 4.0 * (2.0 * PI / f64::from(blades)).sin();
    let [lower, upper] = floor_light(&whole, noon);
    let slack = 64.0 * 1e-12;
    assert!(lower <= 64.0 - shadow + slack && 64.0 - shadow - slack <= upper, "{lower} {upper}");
    assert!(upper - lower < 6.0, "{lower} {upper}");
    // Under the hub, beside it and under an edge; from a lamp on the hub itself nothing of the floor is hidden.
    let (queries, oracle, mut dice) = (Queries::new(&whole), Oracle::new(&whole), Dice::new("fan", 0));
    let tiny = 2f64.powi(-60);
    let places = [[0.0, 0.0, 0.0], [tiny, 0.0, -tiny], [1.0, 0.0, 0.0], [0.0, 0.5, tiny], [2.0, 0.0, 0.0]];
    for light in [noon, lamp([0.0, 1.0, 0.0]), lamp([0.0, 1.0 + 2f64.powi(-40), 0.0]), lamp([0.0, 3.0, 0.0])] {
        for position in places {
            let lit = queries.lit(&Place::Free { position }, &light).expect("accepted").lit;
            assert_eq!(lit, oracle.lit_in_space(position, &light), "{position:?} under {light:?}");
        }
        for _ in 0..20 {
            let [u, v] = dice.parameters(false);
            let answer = queries.lit(&Place::Surface { object: 0, face: 0, u, v }, &light).expect("a point").lit;
            assert_eq!(answer, oracle.lit(0, 0, [u, v], &light), "({u}, {v}) under {light:?}");
        }
        for method in [CellMethod::Quadtree, CellMethod::Borders] {
            let case = Case::by(method, "fan", &whole, light, 5);
            let on_floor: Vec<_> = case.proved().into_iter().filter(|(object, _)| *object == 0).collect();
            // A lamp that all but touches the hub has each cell behind dozens of blades, which it sees too near to tell that they are one.
            let is_beyond_proof = light.xyz().y == 1.0 + 2f64.powi(-40);
            assert!(is_beyond_proof || !on_floor.is_empty(), "{method:?} under {light:?}");
            for _ in 0..if on_floor.is_empty() { 0 } else { 20 } {
                assert_eq!(case.judge(&oracle, dice.pick(&on_floor), 2, &mut dice), None);
            }
        }
    }
    let (_, _, report) = sampled(&whole, noon, 20_000);
    let counted = report.lights[0].objects[0].samples.expect("samples were asked for");
    let share = 1.0 - counted.lit as f64 / counted.samples as f64;
    assert!((share - shadow / 64.0).abs() < 0.01, "{share}");
}

#[test]
fn boxes_that_touch_share_and_overlap_by_an_ulp() {
    let ulp = f64::EPSILON;
    for gap in [-ulp, -ulp / 2.0, 0.0, ulp] {
        // The second box begins at 1 + gap, exactly or as the next float says it.
        let boxes = |kind: &dyn Fn(&str, DVec3, DVec3) -> Object| {
            let second = DVec3::new(1.0 + gap, 0.0, 0.0);
            let stacked = DVec3::new(0.0, 1.0 + gap, 0.25);
            scene(vec![
                floor(),
                kind("first", DVec3::ZERO, DVec3::ONE),
                kind("second", second, DVec3::new(2.0, 1.0, 1.0)),
                kind("on top", stacked, DVec3::new(1.0, 2.0, 0.75)),
                kind("same", DVec3::ZERO, DVec3::ONE),
            ])
        };
        let exact = |name: &str, low: DVec3, high: DVec3| {
            let (size, middle) = (high - low, (low + high) * 0.5);
            object(name, cuboid(size.x, size.y, size.z), at(middle.x, middle.y, middle.z))
        };
        for whole in [boxes(&exact), boxes(&box_of_triangles)] {
            for light in [
                sun([0.0, -1.0, 0.0]),
                sun([-1.0, -1.0, -0.5]),
                sun([0.0, 0.0, -1.0]),
                lamp([1.5, 0.5, 0.5]),
                lamp([1.0, 1.0, 1.0]),
                lamp([0.5, 3.0, 0.5]),
                // Where one box ends and the other begins.
                lamp([1.0, 0.5, 0.5]),
            ] {
                judge("boxes", &whole, light);
            }
            let [lower, upper] = floor_light(&whole, sun([0.0, -1.0, 0.0]));
            assert!(lower <= 62.0 && 62.0 - 2.0 * ulp <= upper && upper - lower < 1.0, "{gap}: {lower} {upper}");
        }
    }
}

/// The closed box between two corners.
fn box_of_triangles(name: &str, low: DVec3, high: DVec3) -> Object {
    let corner =
        |k: usize| -> [f64; 3] { std::array::from_fn(|axis| if k >> axis & 1 == 0 { low } else { high }[axis]) };
    let positions: Vec<[f64; 3]> = (0..8).map(corner).collect();
    let sides = umbriel_geometry::Cuboid::FACES;
    let triangles: Vec<[u32; 3]> = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    object(name, mesh(&positions, &triangles), DAffine3::IDENTITY)
}

#[test]
fn plates_one_ulp_thick() {
    let ulp = f64::EPSILON;
    let (low, high) = (DVec3::new(-1.0, 1.0, -1.0), DVec3::new(1.0, 1.0 + ulp, 1.0));
    // The box's faces are exact; the mesh's are the same, since its corners are floats.
    let plates = [object("box", cuboid(2.0, ulp, 2.0), at(0.0, 1.0, 0.0)), box_of_triangles("mesh", low, high)];
    for plate in plates {
        let whole = scene(vec![floor(), plate]);
        for light in [sun([0.0, -1.0, 0.0]), sun([1.0, -0.5, 0.25]), lamp([0.0, 1.0, 0.0]), lamp([0.0, 0.5, 0.0])] {
            judge("plate", &whole, light);
        }
        let noon = Case::new("plate", &whole, sun([0.0, -1.0, 0.0]), 4);
        let [floor, plate] = [0, 1].map(|k| &noon.report.lights[0].objects[k]);
        // Of 16 × 16 cells of 1/4 m² those along the outline of the shadow, 8 m, are in doubt.
        let width = floor.lit.upper - floor.lit.lower;
        assert!(floor.lit.lower <= 60.0 && 60.0 <= floor.lit.upper && width <= 10.0, "{:?}", floor.lit);
        // The upper side is lit, the lower one and the rims are not.
        assert!(plate.lit.lower <= 4.0 && 4.0 <= plate.lit.upper && plate.undecided() < 1e-9, "{:?}", plate.lit);
    }
}

#[test]
fn tips_of_cones_and_paraboloids() {
    let bodies = [
        Analytic::Cone { radius: 1.0, height: 2.0 },
        Analytic::Cone { radius: 1e-9, height: 2.0 },
        Analytic::Paraboloid { radius: 1.0, height: 2.0 },
        Analytic::Paraboloid { radius: 1e-6, height: 2.0 },
    ];
    for body in bodies {
        let whole = scene(vec![floor(), object("tip", analytic(body), at(0.0, 1.0, 0.0))]);
        let bit = f64::EPSILON;
        for light in [
            lamp([0.0, 2.0, 0.0]),
            lamp([0.0, 2.0 + 2.0 * bit, 0.0]),
            lamp([0.0, 2.0 - bit, 0.0]),
            lamp([-3.0, 2.0, 0.0]),
            lamp([0.5, 4.0, 0.25]),
            sun([0.0, -1.0, 0.0]),
            sun([1.0, 0.0, 0.0]),
            sun([1.0, -2.0, 0.0]),
            sun([1.0, -2.0 - 4.0 * bit, 0.0]),
        ] {
            judge("tip", &whole, light);
        }
        // A level segment over the tip, through it and under it.
        let queries = Queries::new(&whole);
        let lit = |y: f64| {
            let place = Place::Free { position: [-4.0, y, 0.0] };
            queries.lit(&place, &lamp([4.0, y, 0.0])).expect("accepted").lit
        };
        assert_eq!([2.0 + 2.0 * bit, 2.0, 2.0 - bit].map(lit), [true, false, false], "{body:?}");
    }
}

#[test]
fn cylinders_like_hairs_and_like_coins() {
    for (radius, height) in [(1e-9, 1.0), (1.0, 1e-9), (1e-12, 1e-3), (1e3, 1e-6)] {
        let body = analytic(Analytic::Cylinder { radius, height });
        let wide = 8.0 * radius.max(height);
        let ground = object("floor", rectangle(wide, wide), DAffine3::IDENTITY);
        let standing = at(0.0, height * 1.5, 0.0);
        let whole = scene(vec![ground, object("cylinder", body.clone(), standing)]);
        for light in [
            sun([0.0, -1.0, 0.0]),
            sun([1.0, -1.0, 0.0]),
            sun([radius, -height, 0.0]),
            lamp([0.0, height * 4.0, 0.0]),
            lamp([radius, height * 4.0, 0.0]),
            lamp([2.0 * radius, height * 1.5, 0.0]),
            lamp([0.0, height * 1.5, 0.0]),
        ] {
            judge("cylinder", &whole, light);
        }
        // Where the floor is as small as the shadow deserves, along whose border of 2πr cells of r/8 are in doubt.
        let tight = object("floor", rectangle(8.0 * radius, 8.0 * radius), DAffine3::IDENTITY);
        let whole = scene(vec![tight, object("cylinder", body, standing)]);
        let [lower, upper] = floor_light(&whole, sun([0.0, -1.0, 0.0])).map(|lit| lit / (radius * radius));
        let lit = 64.0 - PI;
        assert!(lower <= lit * (1.0 + 1e-12) && lit <= upper * (1.0 + 1e-12), "{lower} {upper}");
        assert!(upper - lower < 2.0, "{lower} {upper}");
        let cylinder = Shape::from(Analytic::Cylinder { radius, height });
        assert_eq!(object("again", cylinder, standing).face_count(), 12);
    }
}
