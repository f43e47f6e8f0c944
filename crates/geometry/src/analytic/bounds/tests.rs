//! Quadrics that are bodies with formulas of their own, in rational numbers.

use glam::DAffine3;
use num_rational::BigRational;
use num_traits::{Signed, Zero};
use proptest::prelude::*;

use super::*;

fn rational(value: f64) -> BigRational {
    BigRational::from_float(value).expect("finite")
}

/// Whether the bound is not below offset + √square and less than `slack` above it.
fn is_tight(bound: f64, offset: &BigRational, square: &BigRational, slack: f64) -> bool {
    let root_is_below = |value: BigRational| !value.is_negative() && &value * &value >= *square;
    let above = rational(bound) - offset;
    root_is_below(above.clone()) && !root_is_below(above - rational(slack))
}

/// Σ factor·x² ≤ 1.
fn central(factors: [f64; 3], within: [[f64; 3]; 2]) -> Analytic {
    let mut matrix = [[0.0; 4]; 4];
    for (k, factor) in factors.into_iter().enumerate() {
        matrix[k][k] = factor;
    }
    matrix[3][3] = -1.0;
    Analytic::Quadric { matrix, within }
}

/// The bounds along every axis and way, each with the row of the placement that it belongs to; downward ones are turned.
fn reaches(bounds: Aabb, placement: &Placement) -> Vec<(f64, DVec3, f64)> {
    let map = placement.map();
    let pair = |axis: usize| {
        let (row, offset) = (map.matrix3.row(axis), map.translation[axis]);
        [(bounds.max[axis], row, offset), (-bounds.min[axis], -row, -offset)]
    };
    (0..3).flat_map(pair).collect()
}

/// What 40 halvings of the image of the box leave.
fn slack(body: &Analytic, placement: &Placement) -> f64 {
    let image = by_support(body, placement);
    (image.size().max_element() + image.min.abs().max(image.max.abs()).max_element()) * 2f64.powi(-39)
}

fn placement() -> impl Strategy<Value = Placement> {
    proptest::array::uniform12(prop_oneof![-2.0..2.0f64, (-3i32..=3).prop_map(f64::from)])
        .prop_filter_map("a singular matrix", |entries| Placement::new(DAffine3::from_cols_array(&entries)).ok())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn ellipsoids_have_the_bounds_of_their_support(powers in proptest::array::uniform3(-2i32..=2), placement in placement()) {
        let radii = powers.map(|power| 2f64.powi(power));
        let body = central(radii.map(|radius| 1.0 / (radius * radius)), [[-5.0, -7.0, -4.5], [4.5, 6.0, 5.0]]);
        let bounds = of(&body, &placement);
        for (bound, row, offset) in reaches(bounds, &placement) {
            let square: BigRational =
                (0..3).map(|k| rational(row[k]) * rational(radii[k])).map(|reach| &reach * &reach).sum();
            prop_assert!(is_tight(bound, &rational(offset), &square, slack(&body, &placement)), "{bound} along {row}");
        }
        let plain = by_support(&Analytic::Ellipsoid { radii }, &placement);
        prop_assert!(plain.min.abs_diff_eq(bounds.min, 1e-9) && plain.max.abs_diff_eq(bounds.max, 1e-9));
    }

    #[test]
    fn cylinders_cut_by_their_box_have_them_too(power in -2i32..=1, half in 0.1..3.0f64, placement in placement()) {
        let radius = 2f64.powi(power);
        let body = central([1.0 / (radius * radius), 0.0, 1.0 / (radius * radius)], [[-3.0, -half, -5.0], [4.0, half, 3.0]]);
        for (bound, row, offset) in reaches(of(&body, &placement), &placement) {
            let along = rational(row.y.abs()) * rational(half) + rational(offset);
            let across = [row.x, row.z].map(|factor| rational(factor) * rational(radius));
            let square = across.iter().map(|reach| reach * reach).sum();
            prop_assert!(is_tight(bound, &along, &square, slack(&body, &placement)), "{bound} along {row}");
        }
    }
}

#[test]
fn a_cap_of_a_sphere_is_bounded_by_its_rim() {
    // x ≥ 0.6: the rim's radius squared is 1 − 0.6².
    let body = central([1.0; 3], [[0.6, -4.0, -4.0], [4.0; 3]]);
    let bounds = of(&body, &Placement::IDENTITY);
    let slack = slack(&body, &Placement::IDENTITY);
    let square = rational(1.0) - rational(0.6) * rational(0.6);
    for bound in [bounds.max.y, bounds.max.z, -bounds.min.y, -bounds.min.z] {
        assert!(is_tight(bound, &BigRational::zero(), &square, slack), "{bounds:?}");
    }
    assert!(is_tight(bounds.max.x, &rational(1.0), &BigRational::zero(), slack), "{bounds:?}");
    assert!(is_tight(-bounds.min.x, &rational(-0.6), &BigRational::zero(), slack), "{bounds:?}");
}

#[test]
fn a_double_cone_fills_its_box_and_a_sheet_leaves_half_of_it() {
    // x² + z² ≤ y², cut at |y| = 1: the rims touch the box.
    let cone = central([1.0, -1.0, 1.0], [[-1.0; 3], [1.0; 3]]);
    let Analytic::Quadric { mut matrix, within } = cone else { panic!("a quadric") };
    matrix[3][3] = 0.0;
    let whole = of(&Analytic::Quadric { matrix, within }, &Placement::IDENTITY);
    assert!(whole.contains(DVec3::ONE) && whole.contains(DVec3::NEG_ONE), "{whole:?}");
    assert!(whole.size().max_element() < 2.0 + 2f64.powi(-37), "{whole:?}");
    let upper = of(&Analytic::Quadric { matrix, within: [[-1.0, 0.25, -1.0], [1.0; 3]] }, &Placement::IDENTITY);
    assert!((upper.min.y - 0.25).abs() < 2f64.powi(-37) && (upper.max - 1.0).length() < 2f64.powi(-37), "{upper:?}");
}

#[test]
fn a_point_is_found_and_nothing_is_empty() {
    // (2, 2, 1)/4 is on the sphere of radius ¾, and the box begins there.
    let touching = |z: f64| central([1.0; 3], [[0.5, 0.5, z], [2.0; 3]]);
    let sphere = |z: f64| {
        let Analytic::Quadric { mut matrix, within } = touching(z) else { panic!("a quadric") };
        matrix[3][3] = -0.5625;
        Analytic::Quadric { matrix, within }
    };
    let point = of(&sphere(0.25), &Placement::IDENTITY);
    assert!(point.contains(DVec3::new(0.5, 0.5, 0.25)) && point.size().max_element() < 2f64.powi(-37), "{point:?}");
    assert!(of(&sphere(0.25f64.next_up()), &Placement::IDENTITY).is_empty(), "an ulp beyond");
    assert!(!of(&sphere(0.25f64.next_down()), &Placement::IDENTITY).is_empty());
}

#[test]
fn guesses_change_nothing() {
    for (inner, outer, last) in [(-3.0, 5.0, 1.2345), (5.0, -3.0, 1.2345), (0.0, 1.0, 1.0), (0.0, 1.0, 0.0)] {
        let asked = std::cell::Cell::new(0);
        let is_reached = |x: f64| {
            asked.set(asked.get() + 1);
            if inner < outer { x <= last } else { x >= last }
        };
        let plain = halved([inner, outer], HALVINGS, is_reached)[1];
        for guess in [last, last + 1e-14, last - 0.1, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            asked.set(0);
            assert_eq!(farthest([inner, outer], guess, is_reached), plain, "{guess}");
            assert!(asked.get() <= 2 + if guess == last { HALVINGS - TRUSTED } else { HALVINGS });
        }
    }
}
