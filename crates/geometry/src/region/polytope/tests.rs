//! What the filter says about forms that vanish at a corner up to rounding, and least values that are known.

use proptest::prelude::*;

use super::*;
use crate::Ring;

/// Entries above and on the diagonal of u₁, u₂, u₃, and halves of the linear factors.
fn form<T: Decide>(squares: [f64; 3], mixed: [f64; 3], linear: [f64; 3], constant: f64) -> Quadratic<T> {
    let entry = |i: usize, j: usize| match (i.min(j), i.max(j)) {
        (3, _) => constant,
        (k, 3) => linear[k],
        (j, k) if j == k => squares[k],
        (j, k) => mixed[j + k - 1],
    };
    std::array::from_fn(|i| std::array::from_fn(|j| T::number(entry(i, j))))
}

fn triple() -> impl Strategy<Value = [f64; 3]> {
    proptest::array::uniform3((-1.0..1.0f64, 0i32..8).prop_map(|(value, power)| value * 2f64.powi(-power)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn no_form_that_vanishes_at_a_corner_is_clearly_positive(
        squares in triple(), mixed in triple(), linear in triple(), ulps in -3i64..=3, spread in prop_oneof![Just(0.0), 0.0..1e-9f64],
    ) {
        // The constant cancels the rest at the corner (1, 1, 1), up to rounding and a spread.
        let sum = |part: [f64; 3]| part.iter().sum::<f64>();
        let constant = -(sum(squares) + 2.0 * sum(mixed) + 2.0 * sum(linear)) + spread;
        let constant = f64::from_bits(constant.to_bits().wrapping_add_signed(ulps));
        let exact: Quadratic<Dyadic> = form(squares, mixed, linear, constant);
        let one = [1.0; 4].map(Dyadic::new);
        let is_positive = value_at(&exact.each_ref().map(|row| value_at(row, &one)), &one).sign() == Sign::Positive;
        let mut stated: Quadratic<Approx> = form(squares, mixed, linear, constant);
        prop_assert!(is_positive || !is_clearly_positive(&stated));
        // The same form where the constant is only known up to the spread and some ulps.
        stated[3][3] = Approx { value: constant, error: spread + 8.0 * f64::EPSILON * constant.abs() };
        prop_assert!(!is_clearly_positive(&stated));
    }

    #[test]
    fn a_sum_of_squares_reaches_zero_where_its_root_is(root in proptest::array::uniform3(-8i32..=16), cut in 0i32..=8) {
        // (8u − root)² in the unit cube, below the plane 8·u₁ = cut.
        let root = root.map(f64::from);
        let constant = root.iter().map(|r| r * r).sum::<f64>();
        let is_in = root.iter().all(|r| (0.0..=8.0).contains(r)) && root[0] <= f64::from(cut);
        fn stated<T: Decide>(root: [f64; 3], constant: f64, cut: f64, is_flat: bool) -> Problem<T> {
            let plane = [-8.0, 0.0, 0.0, cut].map(T::number);
            let polytope = if is_flat { Polytope::new([], Some(plane)) } else { Polytope::new([plane], None) };
            Problem { form: form([64.0; 3], [0.0; 3], root.map(|r| -8.0 * r), constant), polytope }
        }
        let reaches = |constant: f64, is_flat: bool| {
            let exact = || stated(root, constant, f64::from(cut), is_flat);
            reaches_zero(&stated(root, constant, f64::from(cut), is_flat), exact)
        };
        prop_assert_eq!(reaches(constant, false), is_in);
        prop_assert!(!reaches(constant.next_up(), false), "all values are above zero");
        prop_assert_eq!(reaches(constant, true), is_in && root[0] == f64::from(cut));
    }
}
