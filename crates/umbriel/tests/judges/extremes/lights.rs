//! Lights far away, very near, on vertices and edges, in planes, inside of things; suns on the horizon and overhead.

use glam::{DAffine3, DMat3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, LightSource};
use umbriel_io::sun_from_angles;
use umbriel_scene::{Object, Scene};

use super::{judge, lamp, sampled, sun};
use crate::{
    oracle::fixtures::{analytic, at, cuboid, l_prism, mesh, object, quadric, rectangle, scene, sphere},
    proving::Case,
};

fn floor() -> Object {
    object("floor", rectangle(8.0, 8.0), DAffine3::IDENTITY)
}

/// A floor, a box that stands on it, a prism beside and a ball that floats.
fn furnished() -> Scene {
    scene(vec![
        floor(),
        object("box", cuboid(1.0, 1.0, 1.0), at(0.5, 0.5, 0.5)),
        object("prism", l_prism(), at(-3.0, 0.0, -2.0)),
        object("ball", sphere(0.5), at(2.0, 2.0, -1.0)),
    ])
}

#[test]
fn lamps_as_far_as_suns() {
    let whole = furnished();
    for distance in [1e9, 1e15, 1e30, 1e60] {
        for way in [DVec3::new(0.5, 1.0, -0.25), DVec3::Y, DVec3::new(1.0, 1e-9, 0.0)] {
            let judged = judge("far lamp", &whole, lamp((way * distance).to_array()));
            assert!(judged.lit > 5, "{way} at {distance}: {judged:?}");
        }
    }
}

/// From a lamp at 2^200 and from the sun behind it come the same answers, but for points within a hair of a border.
#[test]
fn a_lamp_at_the_end_of_the_range_is_a_sun() {
    let whole = furnished();
    let way = DVec3::new(0.5, 1.0, -0.25);
    let far = Case::new("far", &whole, lamp((way * 2f64.powi(200)).to_array()), 5);
    let behind = Case::new("sun", &whole, sun((-way).to_array()), 5);
    for (a, b) in far.report.lights[0].objects.iter().zip(&behind.report.lights[0].objects) {
        assert!(a.lit.lower <= b.lit.upper && b.lit.lower <= a.lit.upper, "{:?} {:?}", a.lit, b.lit);
        assert!((a.undecided() - b.undecided()).abs() < 0.05 * a.area, "{:?} {:?}", a.lit, b.lit);
    }
}

#[test]
fn lamps_that_all_but_touch() {
    let whole = furnished();
    let near = 1e-15;
    for position in [
        // Over the floor, beside the box's side, over its top, beside its edge and its corner, over the ball's pole.
        [-1.0, near, 1.0],
        [1.0 + 2.0 * near, 0.5, 0.5],
        [0.5, 1.0 + 2.0 * near, 0.5],
        [1.0 + 2.0 * near, 1.0 + 2.0 * near, 0.5],
        [1.0 + 2.0 * near, 1.0 + 2.0 * near, 1.0 + 2.0 * near],
        [2.0, 2.5 + 4.0 * near, -1.0],
        // The same from the other side.
        [-1.0, -near, 1.0],
        [1.0 - near, 0.5, 0.5],
        [2.0, 2.5 - near, -1.0],
    ] {
        judge("near lamp", &whole, lamp(position));
    }
    // However low the lamp is, it lights all of an empty floor.
    let bare = scene(vec![floor()]);
    let lit = Case::new("bare", &bare, lamp([-1.0, near, 1.0]), 4).report.lights[0].objects[0].lit;
    assert!(lit.lower <= 64.0 && 64.0 <= lit.upper && lit.upper - lit.lower < 1e-9, "{lit:?}");
}

#[test]
fn lamps_on_vertices_edges_and_faces() {
    let whole = furnished();
    for position in [
        [1.0, 1.0, 1.0],
        [0.0, 0.0, 0.0],
        [1.0, 1.0, 0.5],
        [0.5, 1.0, 0.5],
        [1.0, 0.0, 0.5],
        [-3.0, 2.0, -2.0],
        [-2.0, 2.0, -1.0],
        [-2.5, 2.0, -1.5],
        [2.0, 2.5, -1.0],
        [2.5, 2.0, -1.0],
        // In the planes of faces, beside them.
        [3.0, 1.0, 3.0],
        [1.0, 3.0, 3.0],
        [-1.0, 0.0, 3.5],
        [4.0, 0.0, 4.0],
        [5.0, 0.0, 0.0],
    ] {
        judge("lamp on it", &whole, lamp(position));
    }
    // A lamp in the floor's plane does not light it.
    let case = Case::new("in the plane", &whole, lamp([5.0, 0.0, 0.0]), 3);
    assert_eq!(case.report.lights[0].objects[0].lit.upper, 0.0);
}

/// From a lamp on a curved body all is hidden that is on the inner side of the tangent plane, and nothing on the outer one.
#[test]
fn lamps_on_curved_surfaces_are_told_from_their_tangent_planes() {
    let cylinder = Analytic::Cylinder { radius: 0.5, height: 1.0 };
    let cone = Analytic::Cone { radius: 1.0, height: 2.0 };
    let capsule = Analytic::Capsule { radius: 0.5, height: 1.0 };
    // A lamp on the surface, and the height of its tangent plane over the floor if that is level.
    for (name, shape, position, share) in [
        ("ball, pole", sphere(0.5), [0.0, 2.5, 0.0], 0.0),
        ("ball, below", sphere(0.5), [0.0, 1.5, 0.0], 1.0),
        // The tangent plane x = 1/2 parts the floor.
        ("ball, side", sphere(0.5), [0.5, 2.0, 0.0], 3.5 / 8.0),
        ("cylinder, end", analytic(cylinder), [0.25, 2.5, 0.0], 0.0),
        ("cylinder, other end", analytic(cylinder), [0.25, 1.5, 0.0], 1.0),
        ("cylinder, side", analytic(cylinder), [0.5, 2.25, 0.0], 3.5 / 8.0),
        ("capsule, side", analytic(capsule), [0.5, 2.25, 0.0], 3.5 / 8.0),
        ("capsule, pole", analytic(capsule), [0.0, 3.0, 0.0], 0.0),
        // On its slanted side, half way up: x + y/2 = 1.5 there, and 3/2 on the floor.
        ("cone, side", analytic(cone), [0.5, 2.0, 0.0], 2.5 / 8.0),
        ("disk", analytic(Analytic::Disk { radius: 1.0 }), [0.25, 2.0, 0.0], 1.0),
    ] {
        let whole = scene(vec![floor(), object("body", shape, at(0.0, 2.0, 0.0))]);
        judge(name, &whole, lamp(position));
        let lit = Case::new(name, &whole, lamp(position), 6).report.lights[0].objects[0].lit;
        let truth = 64.0 * share;
        // One row of cells along the tangent plane, and its neighbours.
        assert!(
            lit.lower <= truth && truth <= lit.upper && lit.upper - lit.lower < 3.5,
            "{name}: {lit:?}, not {truth}"
        );
    }
}

/// From the tip of a cone all is hidden that the cone would hold if it went on, and the cone itself is seen edge-on.
#[test]
fn lamps_in_tips_are_told() {
    let cone = analytic(Analytic::Cone { radius: 1.0, height: 2.0 });
    let upside_down = DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0));
    let leaning = DMat3::from_cols(DVec3::X, DVec3::new(0.25, 1.0, 0.0), DVec3::Z);
    let leaning = DAffine3 { matrix3: leaning, translation: DVec3::new(-0.25, 2.0, 0.0) };
    // Two cones on one tip, as wide as they are high.
    let cones = quadric([1.0, -1.0, 1.0], 0.0, 0.0, [1.0, 1.0, 1.0]);
    for (name, shape, map, tip, radius) in [
        // Its base is in contact with the floor, which lets light through.
        ("on the floor", &cone, at(0.0, 1.0, 0.0), [0.0, 2.0, 0.0], 0.0),
        ("above", &cone, at(0.0, 2.0, 0.0), [0.0, 3.0, 0.0], 1.5),
        ("leaning", &cone, leaning, [0.0, 3.0, 0.0], 1.5),
        ("upside down", &cone, at(0.0, 2.0, 0.0) * upside_down, [0.0, 1.0, 0.0], 0.0),
        ("two cones", &cones, at(0.0, 2.0, 0.0), [0.0, 2.0, 0.0], 2.0),
    ] {
        let whole = scene(vec![floor(), object("cone", shape.clone(), map)]);
        judge(name, &whole, lamp(tip));
        let case = Case::new(name, &whole, lamp(tip), 6);
        let [floor, cone] = [0, 1].map(|k| case.report.lights[0].objects[k].lit);
        let truth = 64.0 - std::f64::consts::PI * radius * radius;
        assert!(
            floor.lower <= truth && truth <= floor.upper && floor.upper - floor.lower < 3.5,
            "{name}: {floor:?}, not {truth}"
        );
        assert_eq!([cone.lower, cone.upper], [0.0; 2], "{name}");
    }
}

/// From a lamp that all but touches a curved body as much is proved as from one on it.
#[test]
fn lamps_a_hair_beside_curved_surfaces_prove_as_much() {
    let bit = f64::EPSILON;
    let cylinder = analytic(Analytic::Cylinder { radius: 0.5, height: 1.0 });
    for (name, shape, position, share) in [
        ("ball, over its pole", sphere(0.5), [0.0, 2.5 + 2.0 * bit, 0.0], 0.0),
        ("ball, under its pole", sphere(0.5), [0.0, 2.5 - 2.0 * bit, 0.0], 0.0),
        ("ball, below it", sphere(0.5), [0.0, 1.5 - bit, 0.0], 1.0),
        ("ball, beside it", sphere(0.5), [0.5 + bit, 2.0, 0.0], 3.5 / 8.0),
        ("cylinder, over it", cylinder.clone(), [0.25, 2.5 + 2.0 * bit, 0.0], 0.0),
        ("cylinder, beside it", cylinder, [0.5 + bit, 2.25, 0.0], 3.5 / 8.0),
    ] {
        let whole = scene(vec![floor(), object("body", shape, at(0.0, 2.0, 0.0))]);
        judge(name, &whole, lamp(position));
        let lit = Case::new(name, &whole, lamp(position), 6).report.lights[0].objects[0].lit;
        let truth = 64.0 * share;
        // The truth is that of a lamp on the surface, but for strips far narrower than a cell.
        let slack = 1e-6;
        assert!(lit.lower <= truth + slack && truth - slack <= lit.upper, "{name}: {lit:?}, not {truth}");
        assert!(lit.upper - lit.lower < 3.5, "{name}: {lit:?}");
    }
}

/// What stands on the floor has its bottom in contact with it, and contact never blocks: only there is the floor lit.
#[test]
fn lamps_inside_solids_light_nothing_outside() {
    let whole = furnished();
    for (position, footprint) in [([0.5, 0.25, 0.75], 1.0), ([-2.5, 1.0, -1.5], 3.0), ([2.0, 2.0, -1.0], 0.0)] {
        judge("inside", &whole, lamp(position));
        let case = Case::new("inside", &whole, lamp(position), 5);
        let (floor, others) = case.report.lights[0].objects.split_first().expect("four objects");
        let lit = floor.lit;
        // The footprint's border and cells of a quarter metre, some more along the walls that light grazes.
        assert!(
            lit.lower <= footprint && footprint <= lit.upper && lit.upper - lit.lower < 4.0,
            "{position:?}: {lit:?}"
        );
        for report in others {
            // One-sided faces look outward: the lamp's own body is dark as well.
            assert_eq!([report.lit.lower, report.lit.estimate], [0.0; 2], "{position:?}: {report:?}");
        }
        let (_, _, report) = sampled(&whole, lamp(position), 5000);
        let samples = report.lights[0].objects.iter().map(|object| object.samples.expect("samples were asked for"));
        let lit: Vec<u64> = samples.map(|samples| samples.lit).collect();
        assert!(lit[1..] == [0; 3] && (lit[0] > 0) == (footprint > 0.0), "{position:?}: {lit:?}");
    }
}

/// A cube of edge 4 with a cubic hole of edge 2, as one mesh: the inner walls look into the hole.
fn hollow() -> Object {
    let corner =
        |k: usize, half: f64| -> [f64; 3] { std::array::from_fn(|axis| if k >> axis & 1 == 0 { -half } else { half }) };
    let positions: Vec<[f64; 3]> = (0..16).map(|k| corner(k % 8, if k < 8 { 2.0 } else { 1.0 })).collect();
    let outward = Cuboid::FACES.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let inward = outward.clone().map(|[a, b, c]| [a + 8, c + 8, b + 8]);
    object("hollow", mesh(&positions, &outward.chain(inward).collect::<Vec<_>>()), at(0.0, 2.0, 0.0))
}

#[test]
fn a_lamp_in_a_cavity_lights_its_walls_and_nothing_else() {
    let whole = scene(vec![floor(), hollow()]);
    for position in [[0.0, 2.0, 0.0], [0.5, 1.25, -0.75], [1.0 - f64::EPSILON, 2.0, 0.0]] {
        judge("cavity", &whole, lamp(position));
        let case = Case::new("cavity", &whole, lamp(position), 3);
        let [floor, hollow] = [0, 1].map(|k| case.report.lights[0].objects[k].lit);
        assert_eq!([floor.lower, floor.estimate], [0.0; 2]);
        // Six walls of four square metres.
        assert!(hollow.lower <= 24.0 && 24.0 <= hollow.upper && hollow.upper - hollow.lower < 1e-9, "{hollow:?}");
    }
    // On a wall: that wall is edge-on, the five others are lit. Undecided are cells of a quarter metre along its border.
    let case = Case::new("on a wall", &whole, lamp([1.0, 2.0, 0.0]), 3);
    let lit = case.report.lights[0].objects[1].lit;
    assert!(lit.lower <= 20.0 && lit.upper >= 20.0 && lit.upper - lit.lower < 2.5, "{lit:?}");
}

#[test]
fn suns_at_the_horizon_and_overhead() {
    // The shadow of a box of one metre that stands on the floor: to the floor's end, or nowhere.
    let whole = scene(vec![floor(), object("box", cuboid(1.0, 1.0, 1.0), at(0.5, 0.5, 0.5))]);
    let from_east = |elevation: f64| -> LightSource { sun(sun_from_angles(90.0, elevation)) };
    for elevation in [1e-9, 1e-12, 90.0 - 1e-9, 90.0, 0.0, -1e-9] {
        judge("sun", &whole, from_east(elevation));
        judge("sun", &furnished(), from_east(elevation));
    }
    // The box stands at x and z from 0 to 1, the sun in the east; west of it are four metres of floor. The floor under
    // it is lit, or not: the box's lower face is in contact with it, the upper one is not.
    for (elevation, shadow) in [(1e-9, 5.0), (1e-12, 5.0), (90.0, 1.0)] {
        let lit = Case::new("sun", &whole, from_east(elevation), 6).report.lights[0].objects[0].lit;
        // Undecided are cells of an eighth of a metre along a border of twelve metres at most.
        assert!(lit.lower <= 64.0 - shadow && 64.0 - shadow <= lit.upper, "{elevation}: {lit:?}");
        assert!(lit.upper - lit.lower < 2.0, "{elevation}: {lit:?}");
    }
    for elevation in [0.0, -1e-9] {
        let lit = Case::new("sun", &whole, from_east(elevation), 6).report.lights[0].objects[0].lit;
        // Edge-on is shadowed; from below, the other side of the floor is lit.
        let expected = if elevation == 0.0 { 0.0 } else { 64.0 };
        assert!(lit.lower <= expected && expected <= lit.upper && lit.upper - lit.lower < 1.0, "{elevation}: {lit:?}");
    }
}
