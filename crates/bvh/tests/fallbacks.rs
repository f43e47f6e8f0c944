//! Segments that floats of 32 bits cannot tell: triangles in doubt go to 64 bits and then to big numbers. Boxes and shafts that all but
//! touch: a doubt counts as a meeting. NUMERICS.md, section 4.

use std::{ops::ControlFlow, sync::Arc};

use glam::DVec3;
use proptest::prelude::*;
use umbriel_bvh::{BoxTree, Shaft, TriangleBvh};
use umbriel_geometry::{Aabb, Dyadic, LightSource, Mesh, Ring, Sign, decisions::Decisions};

/// Two triangles with a common edge, 1 m above the ground; the light comes down at a slant.
fn two_triangles() -> TriangleBvh {
    let positions = vec![[0.0, 1.0, 0.0], [0.5, 1.0, 0.0], [0.0, 1.0, 0.5], [0.5, 1.0, 0.5]];
    TriangleBvh::build(Arc::new(Mesh::new(positions, vec![[0, 1, 2], [3, 2, 1]]).expect("a mesh")))
}

#[test]
fn segments_near_a_border_go_on_to_exact_arithmetic() {
    let bvh = two_triangles();
    let mut segments = bvh.towards(LightSource::sun([0.25, -1.0, 0.125]).expect("a sun"));
    let mut any_hit = |x: f64| {
        let before = Decisions::of_thread();
        let hit = segments.any_hit(DVec3::new(x, 0.0, 0.25));
        (hit, Decisions::of_thread() - before)
    };
    // The border of the shadow is at x = 0.75 on the ground.
    let (hit, decisions) = any_hit(0.6);
    assert!(hit && decisions.single == 1 && decisions.all() == 1, "clear: {decisions:?}");
    let (hit, decisions) = any_hit(0.75 + 0.5f64.powi(40));
    assert!(!hit && decisions.double > 0, "too near for 32 bits: {decisions:?}");
    assert_eq!(decisions.single + decisions.exact, 0, "{decisions:?}");
    let (hit, decisions) = any_hit(0.75);
    assert!(hit && decisions.pair > 0 && decisions.exact == 0, "on the border: {decisions:?}");
    let (hit, decisions) = any_hit(0.75f64.next_up());
    assert!(!hit && decisions.pair > 0 && decisions.exact == 0, "one ulp outside: {decisions:?}");
}

/// A packet tells its clear segments in 32 bits, and counts each once, whatever becomes of the others.
#[test]
fn segments_of_a_packet_are_counted_where_they_are_settled() {
    let bvh = two_triangles();
    let segments = bvh.towards(LightSource::sun([0.25, -1.0, 0.125]).expect("a sun"));
    let counted = |origins: &[DVec3]| {
        let before = Decisions::of_thread();
        let hits = segments.any_hits(origins).into_iter().filter(|&hit| hit).count();
        (hits, Decisions::of_thread() - before)
    };
    let row = |first: f64| (0..40).map(|k| DVec3::new(first + 0.001 * f64::from(k), 0.0, 0.25)).collect::<Vec<_>>();
    let (hits, decisions) = counted(&row(0.5));
    assert!(hits == 40 && decisions.single == 40 && decisions.all() == 40, "{decisions:?}");
    let (hits, decisions) = counted(&row(2.0));
    assert!(hits == 0 && decisions.single == 40 && decisions.all() == 40, "{decisions:?}");
    // One of forty on the border of the shadow.
    let mut origins = row(0.5);
    origins[17].x = 0.75;
    let (hits, decisions) = counted(&origins);
    assert!(hits == 40 && decisions.single == 39 && decisions.pair > 0, "{decisions:?}");
}

#[test]
fn segments_through_an_edge_with_all_its_digits_go_to_big_numbers() {
    // The middle of the segment is the middle of an edge: L = a + (b − x), without rounding.
    let (a, b, x) = ([1.1, 1.7, 1.3], [1.9, 1.2, 1.6], [1.4, 1.5, 1.8]);
    let mesh = Mesh::new(vec![a, b, [1.2, 1.1, 1.9]], vec![[0, 1, 2]]).expect("a triangle");
    let bvh = TriangleBvh::build(Arc::new(mesh));
    let lamp = LightSource::point(std::array::from_fn(|k| a[k] + (b[k] - x[k]))).expect("a lamp");
    let before = Decisions::of_thread();
    let hit = bvh.towards(lamp).any_hit(x.into());
    let decisions = Decisions::of_thread() - before;
    assert!(hit && decisions.exact > 0, "{decisions:?}");
}

/// factor·m ≥ least.
struct Bound {
    factor: Dyadic,
    least: Dyadic,
}

/// Whether some m > 0 (up to 1 for a lamp; for a sun zero will do) fulfils the inequalities of the shaft's header.
fn has_common_parameter(bounds: Vec<Bound>, is_sun: bool) -> bool {
    // Quotients with positive divisors: a/b ≤ c/d is a·d ≤ c·b.
    let (mut lower, mut upper): (Vec<[Dyadic; 2]>, Vec<[Dyadic; 2]>) =
        (vec![[Dyadic::zero(), Dyadic::new(1.0)]], vec![]);
    if !is_sun {
        upper.push([Dyadic::new(1.0), Dyadic::new(1.0)]);
    }
    for Bound { factor, least } in bounds {
        match factor.sign() {
            Sign::Positive => lower.push([least, factor]),
            Sign::Negative => upper.push([-least, -factor]),
            Sign::Zero if least.sign() == Sign::Positive => return false,
            Sign::Zero => {}
        }
    }
    let is_apart = |[a, b]: &[Dyadic; 2], [c, d]: &[Dyadic; 2]| {
        (a.clone() * d.clone() - c.clone() * b.clone()).sign() == Sign::Positive
    };
    let reaches_past_the_light = |[c, _]: &[Dyadic; 2]| is_sun || c.sign() == Sign::Positive;
    upper.iter().all(|high| reaches_past_the_light(high) && !lower.iter().any(|low| is_apart(low, high)))
}

/// Whether the occluder's box meets the shaft, exactly.
fn meets(receiver: &Aabb, occluder: &Aabb, light: &LightSource) -> bool {
    let difference = |a: f64, b: f64| Dyadic::new(a) - Dyadic::new(b);
    let along = |axis: usize| {
        let at = light.xyz()[axis];
        let (a, b) = ([occluder.min[axis], occluder.max[axis]], [receiver.min[axis], receiver.max[axis]]);
        let [to_min, to_max] = if light.is_sun() {
            [(Dyadic::new(at), difference(a[0], b[1])), (Dyadic::new(at), difference(a[1], b[0]))]
        } else {
            [(difference(b[1], at), difference(a[0], at)), (difference(b[0], at), difference(a[1], at))]
        };
        [Bound { factor: to_min.0, least: to_min.1 }, Bound { factor: -to_max.0, least: -to_max.1 }]
    };
    has_common_parameter((0..3).flat_map(along).collect(), light.is_sun())
}

fn nudged(x: f64, ulps: i64) -> f64 {
    if x == 0.0 { 0.0 } else { f64::from_bits(x.to_bits().wrapping_add_signed(ulps)) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]
    #[test]
    fn a_shaft_never_misses_a_box_that_touches_it(
        corner in proptest::array::uniform3(-1.0..1.0f64), size in proptest::array::uniform3(0.0..0.5f64),
        light in proptest::array::uniform3(-3.0..3.0f64), is_sun: bool, share in 0.0..1.0f64, side in 0usize..8,
        ulps in proptest::array::uniform3(-4i64..=4), extent in proptest::array::uniform3(0.0..0.5f64), outward in 0usize..8,
    ) {
        let receiver = Aabb { min: corner.into(), max: DVec3::from(corner) + DVec3::from(size) };
        let source = if is_sun { LightSource::sun(light) } else { LightSource::point(light) };
        let Ok(source) = source else { return Ok(()) };
        // A box with a corner within a few ulps of the shaft's border.
        let pick = |axis: usize| if side >> axis & 1 == 0 { receiver.min[axis] } else { receiver.max[axis] };
        let from: DVec3 = [0, 1, 2].map(pick).into();
        let border = if is_sun { from + source.xyz() * share } else { from + (source.xyz() - from) * share };
        let touching: DVec3 = [0, 1, 2].map(|axis| nudged(border[axis], ulps[axis])).into();
        let away = |axis: usize| if outward >> axis & 1 == 0 { -extent[axis] } else { extent[axis] };
        let other = touching + DVec3::from([0, 1, 2].map(away));
        let occluder = Aabb { min: touching.min(other), max: touching.max(other) };
        if meets(&receiver, &occluder, &source) {
            let shaft = Shaft::new(&receiver, &source);
            prop_assert!(shaft.may_meet(&occluder), "{receiver:?} {occluder:?} {source:?}");
            let mut found = false;
            let _ = BoxTree::build(&[occluder]).for_each_in_shaft(&shaft, |_| {
                found = true;
                ControlFlow::Continue(())
            });
            prop_assert!(found, "the tree of boxes: {receiver:?} {occluder:?} {source:?}");
        }
    }
}

/// What is near is not met: the shaft tells boxes apart that are some hundred roundings away.
#[test]
fn a_shaft_misses_what_is_clearly_beside_it() {
    let receiver = Aabb { min: DVec3::ZERO, max: DVec3::ONE };
    let lamp = LightSource::point([0.5, 4.0, 0.5]).expect("a lamp");
    let at = |x: f64| Aabb { min: DVec3::new(x, 2.0, 0.25), max: DVec3::new(x + 1.0, 2.0, 0.75) };
    // At two metres the shaft reaches from 1/6 to 5/6.
    let border = 5.0 / 6.0;
    for (x, expected) in [(border - 1e-15, true), (border + 1e-13, false)] {
        assert_eq!(Shaft::new(&receiver, &lamp).may_meet(&at(x)), expected, "{x}");
        assert_eq!(meets(&receiver, &at(x), &lamp), expected, "{x}");
    }
}
