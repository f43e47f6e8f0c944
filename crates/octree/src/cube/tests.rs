use proptest::prelude::*;
use umbriel_geometry::{Dyadic, Ring, Sign};

use super::*;

fn number() -> impl Strategy<Value = f64> {
    let grid = (-16i32..=16).prop_map(|n| f64::from(n) * 0.25);
    let scaled = (-4.0..4.0f64, -60i32..60).prop_map(|(x, e)| x * 2f64.powi(e));
    prop_oneof![grid, -4.0..4.0f64, scaled]
}

fn point() -> impl Strategy<Value = DVec3> {
    proptest::array::uniform3(number()).prop_map(DVec3::from_array)
}

fn a_box() -> impl Strategy<Value = Aabb> {
    (point(), point()).prop_map(|(a, b)| Aabb::of([a, b]))
}

/// 2^21·(x − plane), exactly.
fn beyond(cube: &Cube, axis: usize, x: f64, plane: u32) -> Sign {
    let [x, min, edge] = [x, cube.min()[axis], cube.edge()].map(Dyadic::new);
    ((x - min) * Dyadic::new(f64::from(CELLS)) - edge * Dyadic::new(f64::from(plane))).sign()
}

/// Whether the closed box meets the closed cell, exactly.
fn meets(cube: &Cube, cell: Octant, bounds: &Aabb) -> bool {
    let below = Octant::MAX_LEVEL - cell.level();
    let first = cell.coordinates().map(|c| c << below);
    (0..3).all(|axis| {
        beyond(cube, axis, bounds.max[axis], first[axis]) != Sign::Negative
            && beyond(cube, axis, bounds.min[axis], first[axis] + (1 << below)) != Sign::Positive
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn the_cube_holds_its_box_and_is_the_smallest(bounds in a_box()) {
        let cube = Cube::around(&bounds).expect("a finite box");
        let sticks_out = |edge: f64| (0..3).any(|axis| beyond(&Cube { edge, ..cube }, axis, bounds.max[axis], CELLS) == Sign::Positive);
        prop_assert!(!sticks_out(cube.edge()));
        prop_assert!(cube.edge() == 0.0 || sticks_out(cube.edge().next_down()));
    }

    #[test]
    fn comparisons_are_exact(bounds in a_box(), plane in 0..=CELLS, ulps in -2i64..=2, axis in 0usize..3) {
        let cube = Cube::around(&bounds).expect("a finite box");
        let near = cube.near_plane(axis, plane, f64::next_up);
        prop_assume!(near != 0.0);
        let x = f64::from_bits(near.to_bits().wrapping_add_signed(ulps));
        let expected = match beyond(&cube, axis, x, plane) {
            Sign::Negative => Ordering::Less,
            Sign::Zero => Ordering::Equal,
            Sign::Positive => Ordering::Greater,
        };
        prop_assert_eq!(cube.compare(axis, x, plane), Some(expected));
    }

    #[test]
    fn cells_lie_in_their_bounds(bounds in a_box(), level in 0u8..=21, place in any::<[u32; 3]>()) {
        let cube = Cube::around(&bounds).expect("a finite box");
        let cell = Octant::at(level, place.map(|c| c & ((1 << level) - 1))).expect("within its level");
        let (held, below) = (cube.bounds_of(cell), 21 - level);
        for axis in 0..3 {
            let first = cell.coordinates()[axis] << below;
            prop_assert!(beyond(&cube, axis, held.min[axis], first) != Sign::Positive);
            prop_assert!(beyond(&cube, axis, held.max[axis], first + (1 << below)) != Sign::Negative);
            prop_assert!(beyond(&cube, axis, held.min[axis].next_up().next_up().next_up(), first) != Sign::Negative);
        }
    }

    #[test]
    fn boxes_meet_the_cells_that_they_meet(bounds in a_box(), query in a_box(), level in 0u8..=21, corner in 0usize..8, step in 0u32..3) {
        let cube = Cube::around(&bounds).expect("a finite box");
        prop_assume!(cube.edge() > 0.0);
        let met = cube.lattice_box(&query);
        prop_assert_eq!(met.is_some(), meets(&cube, Octant::ROOT, &query));
        let Some(met) = met else { return Ok(()) };
        // A cell at or beside a corner of what is met: the border is where it can go wrong.
        let pick = |axis: usize| {
            let end = if corner >> axis & 1 == 0 { met.min[axis] } else { met.max[axis] };
            ((end >> (21 - level)) + step).saturating_sub(1).min((1 << level) - 1)
        };
        let cell = Octant::at(level, [pick(0), pick(1), pick(2)]).expect("within its level");
        prop_assert_eq!(met.meets(cell), meets(&cube, cell, &query));
        prop_assert!(!met.covers(cell) || met.meets(cell));
    }

    #[test]
    fn points_lie_in_their_cells(bounds in a_box(), at in point(), level in 0u8..=21) {
        let cube = Cube::around(&bounds).expect("a finite box");
        let point = Aabb { min: at, max: at };
        match cube.octant_at(at, level) {
            Some(cell) => prop_assert!(meets(&cube, cell, &point) && cell.level() == level),
            None => prop_assert!(!meets(&cube, Octant::ROOT, &point)),
        }
    }

    #[test]
    fn the_depth_of_a_length_is_the_greatest(edge in 1e-6..1e6f64, share in 1e-8..2.0f64, exact in any::<bool>(), halvings in 0u8..=21) {
        let length = if exact { edge / f64::from(1 << halvings) } else { edge * share };
        let cell = |depth: u8| edge / f64::from(1u32 << depth);
        match depth_of_length(edge, length, 21) {
            Some(depth) => prop_assert!(cell(depth) >= length && (depth == 21 || cell(depth + 1) < length)),
            None => prop_assert!(length > edge),
        }
        if exact {
            prop_assert_eq!(depth_of_length(edge, length, 21), Some(halvings));
        }
    }
}

#[test]
fn boxes_without_a_cube_have_none() {
    assert_eq!(Cube::around(&Aabb::EMPTY), None);
    assert_eq!(Cube::around(&Aabb { min: DVec3::ZERO, max: DVec3::INFINITY }), None);
    assert_eq!(Cube::around(&Aabb { min: DVec3::splat(f64::NAN), max: DVec3::ONE }), None);
    let cube = Cube::around(&Aabb { min: DVec3::ZERO, max: DVec3::new(1.0, 2.0, 3.0) }).expect("a box");
    assert_eq!((cube.edge(), cube.bounds_of(Octant::ROOT).max), (3.0, DVec3::splat(3.0)));
    assert_eq!(cube.lattice_box(&Aabb { min: DVec3::splat(f64::NAN), max: DVec3::ONE }), None);
    assert_eq!(cube.octant_at(DVec3::splat(f64::NAN), 3), None);
    assert_eq!(cube.octant_at(DVec3::ONE, 22), None);
    let everywhere = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
    let met = cube.lattice_box(&everywhere).expect("all of it");
    assert!(met.covers(Octant::ROOT) && met.meets(Octant::ROOT));
}

#[test]
fn the_cube_of_a_point_is_a_point() {
    let cube = Cube::around(&Aabb::of([DVec3::ONE])).expect("a point");
    assert_eq!((cube.edge(), cube.depth_of(0.5), cube.depth_of(0.0)), (0.0, None, Some(21)));
    assert_eq!(cube.octant_at(DVec3::ONE, 21), Octant::at(21, [0; 3]));
    assert_eq!(cube.lattice_box(&Aabb::of([DVec3::ONE])), Some(LatticeBox { min: [0; 3], max: [0; 3] }));
}
