//! The oracle itself, on cases with answers known by hand.

use glam::{DAffine3, DVec3};
use num_bigint::BigInt;
use num_rational::BigRational;
use umbriel_geometry::LightSource;
use umbriel_scene::{Object, Sides};

use crate::oracle::{
    Oracle,
    body::closed_faces,
    dice::Dice,
    fixtures::{at, cuboid, l_prism, mesh, object, rectangle, sphere, tetrahedron, with_sides},
    number::{Binary, Surd},
};

fn point(x: f64, y: f64, z: f64) -> LightSource {
    LightSource::point([x, y, z]).expect("a light")
}

fn sun(x: f64, y: f64, z: f64) -> LightSource {
    LightSource::sun([x, y, z]).expect("a sun")
}

fn of(objects: Vec<Object>) -> Oracle {
    Oracle::of_objects(&objects)
}

fn floor() -> Object {
    object("floor", rectangle(8.0, 8.0), DAffine3::IDENTITY)
}

/// The parameters of the floor's point (x, z).
fn on_floor(x: f64, z: f64) -> [f64; 2] {
    [(x + 4.0) / 8.0, (4.0 - z) / 8.0]
}

#[test]
fn binaries_round_like_floats() {
    let mut dice = Dice::new("binaries", 0);
    for _ in 0..2_000 {
        let [a, b, c] = [0; 3].map(|_| dice.float(-1.0, 1.0) * 2f64.powi(dice.below(40) as i32 - 20));
        let [x, y, z] = [a, b, c].map(Binary::new);
        assert_eq!((&x + &y).to_nearest(), a + b);
        assert_eq!((&x * &y).to_nearest(), a * b);
        assert_eq!((&(&x * &y) + &z).to_nearest(), a.mul_add(b, c));
        assert_eq!(x.to_nearest_of(24), f64::from(a as f32));
        let rational = |value: f64| BigRational::from_float(value).expect("finite");
        let difference = rational(a) * rational(b) - rational(c);
        assert_eq!((&(&x * &y) - &z).sign() > 0, difference > BigRational::from(BigInt::from(0)));
    }
}

#[test]
fn surds_know_their_sign() {
    let sign =
        |a: f64, b: f64, n: f64| Surd { rational: Binary::new(a), irrational: Binary::new(b) }.sign(&Binary::new(n));
    assert_eq!([sign(3.0, -2.0, 2.0), sign(-3.0, 2.0, 2.0), sign(-4.0, 3.0, 2.0)], [1, -1, 1]);
    assert_eq!([sign(6.0, -3.0, 4.0), sign(0.0, -1.0, 2.0), sign(0.0, 1.0, 0.0), sign(-1.0, 9.0, 0.0)], [0, -1, 0, -1]);
}

#[test]
fn a_box_shades_the_floor_and_its_border_is_shadow() {
    let oracle = of(vec![floor(), object("box", cuboid(1.0, 1.0, 1.0), at(0.0, 1.5, 0.0))]);
    let noon = sun(0.0, -1.0, 0.0);
    for (x, lit) in [(0.0, false), (0.5, false), (0.5 + 2f64.powi(-40), true), (-0.5, false), (2.0, true)] {
        assert_eq!(oracle.lit(0, 0, on_floor(x, 0.0), &noon), lit, "x = {x}");
    }
    assert_eq!(
        [0, 1, 2, 3, 4, 5].map(|face| oracle.lit(1, face, [0.5, 0.5], &noon)),
        [false, false, false, true, false, false]
    );
    // From 4 m up, the top at 2 m throws a shadow of twice its size.
    let lamp = point(0.0, 4.0, 0.0);
    for (x, lit) in [(0.75, false), (1.0, false), (1.0 + 2f64.powi(-40), true)] {
        assert_eq!(oracle.lit(0, 0, on_floor(x, 0.25), &lamp), lit, "x = {x}");
    }
}

#[test]
fn contact_never_blocks() {
    let oracle = of(vec![floor(), object("box", cuboid(2.0, 2.0, 2.0), at(0.0, 1.0, 0.0))]);
    let inside = point(0.0, 1.0, 0.0);
    assert!(oracle.lit(0, 0, on_floor(0.5, 0.5), &inside), "the box's bottom is in contact");
    assert!(oracle.lit(0, 0, on_floor(1.0, 0.0), &inside), "at the foot of a wall the segment runs inside the box");
    assert!(!oracle.lit(0, 0, on_floor(1.5, 0.0), &inside), "the wall blocks");
    assert!(!oracle.lit(1, 3, [0.5, 0.5], &inside), "a box is lit from outside only");
    let low = sun(-1.0, -1.0, 0.0);
    assert!(oracle.lit(0, 0, on_floor(1.0, 0.0), &low), "the foot of the lit wall");
    assert!(!oracle.lit(0, 0, on_floor(-1.0, 0.0), &low), "the foot of the wall behind");
}

#[test]
fn a_sun_in_the_plane_of_a_face_is_shadowed_there_and_blocked_by_it() {
    let oracle = of(vec![floor(), object("box", cuboid(2.0, 2.0, 2.0), at(0.0, 1.0, 0.0))]);
    let noon = sun(0.0, -1.0, 0.0);
    assert!(!oracle.lit(1, 1, [0.5, 0.5], &noon), "edge-on");
    assert!(!oracle.lit(0, 0, on_floor(1.0, 0.0), &noon), "the ray runs up within the wall");
    assert!(!oracle.lit(0, 0, on_floor(1.0, 1.0), &noon), "the ray runs up along the edge");
    assert!(oracle.lit(1, 3, [1.0, 1.0], &noon), "the top's corner");
    let level = sun(1.0, 0.0, 0.0);
    assert!(!oracle.lit(0, 0, on_floor(3.0, 0.0), &level), "edge-on");
    assert!(!oracle.lit(1, 0, [0.0, 0.0], &level), "the foot of the box: the ray runs within the floor");
    assert!(oracle.lit(1, 0, [0.5, 0.5], &level));
}

#[test]
fn segments_and_points_block() {
    let needle = mesh(&[[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2], [2, 2, 2]]);
    let oracle = of(vec![floor(), object("needle", needle, DAffine3::IDENTITY)]);
    let noon = sun(0.0, -1.0, 0.0);
    for (x, z, lit) in [(0.5, 0.0, false), (1.0, 0.0, false), (1.25, 0.0, true), (0.5, 0.125, true)] {
        assert_eq!(oracle.lit(0, 0, on_floor(x, z), &noon), lit, "({x}, {z})");
    }
    assert!(!oracle.lit(1, 0, [0.25, 0.25], &noon), "a face without area is never lit");
    assert!(!oracle.lit_in_space([2.0, 1.0, 0.0], &point(-3.0, 1.0, 0.0)), "along the needle");
    assert!(oracle.lit_in_space([2.0, 1.0, 0.0], &point(1.0, 1.0, 0.0)), "the light at its tip");
    assert!(oracle.lit_in_space([2.0, 1.0, 0.0], &point(3.0, 1.0, 0.0)));
    assert!(!oracle.lit_in_space([2.0, 1.0, 0.0], &sun(1.0, 0.0, 0.0)));
    assert!(oracle.lit_in_space([2.0, 1.0, 0.0], &sun(-1.0, 0.0, 0.0)));
    let dot = mesh(&[[0.0, 1.0, 0.0]], &[[0, 0, 0]]);
    let oracle = of(vec![floor(), object("dot", dot, DAffine3::IDENTITY)]);
    assert!(!oracle.lit(0, 0, on_floor(1.0, 0.0), &point(-1.0, 2.0, 0.0)));
    assert!(oracle.lit(0, 0, on_floor(1.0, 0.0), &point(0.5, 0.5, 0.0)));
    assert!(!oracle.lit(0, 0, on_floor(0.0, 0.0), &noon));
    assert!(oracle.lit(0, 0, on_floor(0.0, 2f64.powi(-40)), &noon));
}

#[test]
fn sides_follow_winding_closedness_and_mirrors() {
    let noon = sun(0.0, -1.0, 0.0);
    let mirror = DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0));
    let lit_tile =
        |map, sides| of(vec![with_sides("tile", rectangle(1.0, 1.0), map, sides)]).lit(0, 0, [0.5; 2], &noon);
    assert!(lit_tile(DAffine3::IDENTITY, Sides::One));
    assert!(!lit_tile(mirror, Sides::One), "its front now looks down");
    assert!(lit_tile(mirror, Sides::Auto));
    for map in [DAffine3::IDENTITY, mirror, DAffine3::from_scale(DVec3::new(-2.0, 1.0, 3.0))] {
        let prism = of(vec![object("prism", l_prism(), map)]);
        let lit = (0..20).filter(|&face| prism.lit(0, face, [0.25, 0.25], &noon)).collect::<Vec<_>>();
        let top = if map.matrix3.y_axis.y > 0.0 { [4, 5, 6, 7] } else { [0, 1, 2, 3] };
        assert_eq!(lit, top, "only the upper cap");
    }
    let east = sun(-1.0, 0.0, 0.0);
    let plain = of(vec![object("tetrahedron", tetrahedron(), DAffine3::IDENTITY)]);
    assert_eq!([0, 1, 2, 3].map(|face| plain.lit(0, face, [0.25, 0.25], &east)), [false, false, false, true]);
    let both = of(vec![with_sides("tetrahedron", tetrahedron(), DAffine3::IDENTITY, Sides::Two)]);
    let center = point(0.125, 0.125, 0.125);
    assert!((0..4).all(|face| both.lit(0, face, [0.25, 0.25], &center)));
    assert!((0..4).all(|face| !plain.lit(0, face, [0.25, 0.25], &center)));
}

#[test]
fn components_are_closed_when_their_edges_cancel() {
    let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut triangles = vec![[o, y, x], [o, x, z], [o, z, y], [x, y, z]];
    assert_eq!(closed_faces(&triangles), [true; 4]);
    triangles.push([[5.0; 3], x, o]);
    assert_eq!(closed_faces(&triangles), [false; 5], "a fin on an edge joins the component and opens it");
    triangles[4] = [[5.0; 3], [6.0, 5.0, 5.0], o];
    assert_eq!(closed_faces(&triangles), [true, true, true, true, false], "a shared corner does not join");
}

#[test]
fn spheres_block_where_they_touch_and_not_where_they_rest() {
    let oracle = of(vec![floor(), object("ball", sphere(1.0), at(0.0, 2.0, 0.0))]);
    let noon = sun(0.0, -1.0, 0.0);
    for (x, lit) in [(0.0, false), (1.0, false), (1.0 + 2f64.powi(-40), true)] {
        assert_eq!(oracle.lit(0, 0, on_floor(x, 0.0), &noon), lit, "x = {x}");
    }
    assert_eq!(
        [0, 1, 2, 3, 4, 5].map(|patch| oracle.lit(1, patch, [0.5, 0.5], &noon)),
        [false, false, false, true, false, false]
    );
    let resting = of(vec![floor(), object("ball", sphere(1.0), at(0.0, 1.0, 0.0))]);
    assert!(
        resting.lit(0, 0, on_floor(0.0, 0.0), &point(0.0, 1.0, 0.0)),
        "the light inside, the root at x divided out"
    );
    assert!(!resting.lit(0, 0, on_floor(0.0, 0.0), &noon));
    assert!(!resting.lit(0, 0, on_floor(0.5, 0.0), &point(0.0, 1.0, 0.0)));
    assert!(!resting.lit(0, 0, on_floor(0.5, 0.0), &point(-1.0, 1.0, 0.0)), "through the ball");
    assert!(resting.lit(0, 0, on_floor(2.0, 0.0), &point(1.0, 1.0, 0.0)), "the light on the surface");
}

#[test]
fn a_hollow_sphere_is_lit_inside_and_shades_itself() {
    let hollow = of(vec![with_sides("ball", sphere(1.0), DAffine3::IDENTITY, Sides::Two)]);
    let plain = of(vec![object("ball", sphere(1.0), DAffine3::IDENTITY)]);
    let (inside, above) = (point(0.25, 0.0, 0.125), point(0.0, 4.0, 0.0));
    for patch in 0..6 {
        for parameters in [[0.0, 0.0], [0.375, 0.75], [1.0, 0.5]] {
            assert!(hollow.lit(0, patch, parameters, &inside));
            assert!(!plain.lit(0, patch, parameters, &inside));
            assert_eq!(hollow.lit(0, patch, parameters, &above), plain.lit(0, patch, parameters, &above));
        }
    }
    assert!(plain.lit(0, 3, [0.0, 0.0], &above), "the cube's corner has height 1/√3, above 1/4");
    assert!(!plain.lit(0, 1, [0.5, 0.5], &above));
}

#[test]
fn sphere_points_know_what_stands_between() {
    // A plate just above the ball's point in direction (1, 1, 1)/√3, pierced by the segment to the light there.
    let plate = rectangle(0.5, 0.5);
    let objects = vec![object("ball", sphere(1.0), DAffine3::IDENTITY), object("plate", plate, at(1.0, 1.0, 1.0))];
    let oracle = of(objects);
    assert!(!oracle.lit(0, 3, [1.0, 1.0], &point(2.0, 2.0, 2.0)));
    assert!(!oracle.lit(0, 3, [1.0, 1.0], &sun(-1.0, -1.0, -1.0)));
    assert!(oracle.lit(0, 3, [1.0, 1.0], &point(1.0, 1.0, 1.0)), "the light in the plate");
    assert!(oracle.lit(0, 3, [1.0, 1.0], &sun(0.0, -1.0, 0.0)), "beside the plate");
}
