use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::arbitrary::{a_box, light, whole_box, whole_light};

/// A bound on the parameter: numerator and positive denominator, both exact.
type Bound = (f64, f64);

fn not_above(a: Bound, b: Bound) -> bool {
    a.0 * b.1 <= b.0 * a.1
}

/// All lower and upper bounds on the parameter from factor·t ≥ least and factor·t ≤ most, in exact whole numbers.
/// `None` when a factor of zero contradicts its inequality.
fn bounds(occluder: &Aabb, receiver: &Aabb, light: &LightSource) -> Option<(Vec<Bound>, Vec<Bound>)> {
    let (mut lower, mut upper) = (vec![(0.0, 1.0)], vec![]);
    let p = light.xyz();
    for k in 0..3 {
        let inequalities = if light.is_sun() {
            [(p[k], occluder.min[k] - receiver.max[k]), (-p[k], receiver.min[k] - occluder.max[k])]
        } else {
            [(receiver.max[k] - p[k], occluder.min[k] - p[k]), (p[k] - receiver.min[k], p[k] - occluder.max[k])]
        };
        for (factor, least) in inequalities {
            match factor {
                0.0 if least > 0.0 => return None,
                0.0 => {}
                _ if factor > 0.0 => lower.push((least, factor)),
                _ => upper.push((-least, -factor)),
            }
        }
    }
    Some((lower, upper))
}

/// The definition in exact arithmetic; `open` leaves the receiver's own points out.
fn exact(occluder: &Aabb, receiver: &Aabb, light: &LightSource, open: bool) -> bool {
    let Some((lower, mut upper)) = bounds(occluder, receiver, light) else { return false };
    let (is_sun, zero, one) = (light.is_sun(), (0.0, 1.0), (1.0, 1.0));
    let ends_well = match (is_sun, open) {
        (true, true) => !upper.iter().any(|&u| not_above(u, zero)),
        (true, false) => true,
        (false, open) => {
            upper.push(one);
            let touches_light = upper.iter().any(|&u| not_above(u, zero));
            let touches_receiver = lower.iter().any(|&l| not_above(one, l));
            !touches_light && (!open || !touches_receiver)
        }
    };
    ends_well && lower.iter().all(|&l| upper.iter().all(|&u| not_above(l, u)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn influence_is_the_definition_on_whole_numbers(a in whole_box(), b in whole_box(), light in whole_light()) {
        prop_assert_eq!(may_shadow(&a, &b, &light), exact(&a, &b, &light, false));
    }

    #[test]
    fn exclusion_is_a_proof(a in whole_box(), b in whole_box(), light in whole_light()) {
        prop_assert!(!cannot_shadow(&a, &b, &light) || !exact(&a, &b, &light, true));
    }

    #[test]
    fn of_separated_boxes_one_never_shadows_the_other(a in whole_box(), b in whole_box(), light in whole_light()) {
        let separates = |axis: usize| {
            let (low, high) = if a.max[axis] <= b.min[axis] { (&a, &b) } else { (&b, &a) };
            let at = light.xyz()[axis];
            let in_plane = if light.is_sun() { at == 0.0 } else { low.max[axis] == at && at == high.min[axis] };
            low.max[axis] <= high.min[axis] && !in_plane
        };
        let is_separated = (0..3).any(separates);
        prop_assert!(!is_separated || cannot_shadow(&a, &b, &light) || cannot_shadow(&b, &a, &light));
    }

    #[test]
    fn what_stands_in_the_way_is_found(
        b in a_box(), light in light(), weights in [0.0..=1.0f64, 0.0..=1.0, 0.0..=1.0], along in 0.0..1.0f64,
    ) {
        prop_assume!(!b.is_empty());
        let from = b.min + (b.max - b.min) * DVec3::from_array(weights);
        let way = if light.is_sun() { light.xyz() } else { light.xyz() - from };
        let on_the_way = from + way * along;
        // The rounded point is within a few ulps of the way; the box around it reaches over the way.
        let size = from.abs() + way.abs();
        let a = Aabb { min: on_the_way, max: on_the_way }.widened(size * (4.0 * f64::EPSILON));
        prop_assert!(may_shadow(&a, &b, &light));
    }

    #[test]
    fn both_tests_are_monotone(a in a_box(), b in a_box(), more in a_box(), light in light()) {
        let (wide_a, wide_b) = (a.union(more), b.union(more));
        prop_assert!(!may_shadow(&a, &b, &light) || may_shadow(&wide_a, &wide_b, &light));
        prop_assume!(!a.is_empty() && !b.is_empty());
        prop_assert!(!cannot_shadow(&wide_a, &wide_b, &light) || cannot_shadow(&a, &b, &light));
    }

    #[test]
    fn powers_of_two_change_nothing(a in a_box(), b in a_box(), p in proptest::array::uniform3(-2.0..2.0f64), e in -150i32..150) {
        let scale = 2f64.powi(e);
        let scaled = |b: &Aabb| Aabb { min: b.min * scale, max: b.max * scale };
        let lights = [p, p.map(|x| x * scale)].map(|p| LightSource::point(p).expect("in range"));
        prop_assert_eq!(may_shadow(&a, &b, &lights[0]), may_shadow(&scaled(&a), &scaled(&b), &lights[1]));
    }
}

#[test]
fn a_house_on_the_floor_shadows_it_but_not_the_other_way_round() {
    let floor = Aabb { min: DVec3::new(-9.0, 0.0, -9.0), max: DVec3::new(9.0, 0.0, 9.0) };
    let house = Aabb { min: DVec3::ZERO, max: DVec3::ONE };
    let sun = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun above");
    assert!(may_shadow(&house, &floor, &sun) && !cannot_shadow(&house, &floor, &sun));
    assert!(may_shadow(&floor, &house, &sun), "they touch");
    assert!(cannot_shadow(&floor, &house, &sun), "the floor lies below");
}

#[test]
fn a_light_inside_a_box_excludes_nothing_of_it() {
    let room = Aabb { min: DVec3::splat(-1.0), max: DVec3::ONE };
    let chair = Aabb { min: DVec3::ZERO, max: DVec3::splat(0.5) };
    let lamp = LightSource::point([0.1, 0.9, 0.1]).expect("a lamp");
    for (a, b) in [(&room, &chair), (&chair, &room)] {
        assert!(may_shadow(a, b, &lamp) && !cannot_shadow(a, b, &lamp));
    }
}
