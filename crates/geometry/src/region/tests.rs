//! Rivals: a polygon clipped by the six sides of a box in rational numbers, and solid angles.

use glam::DAffine3;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::Signed;
use proptest::prelude::*;

use super::*;
use crate::{Cuboid, Facets, Mesh, Placement, Point};

type Corner = [BigRational; 3];

fn rational(value: f64) -> BigRational {
    BigRational::from_float(value).expect("finite")
}

/// The part of the polygon with sign·(x_axis − value) ≤ 0.
fn clipped(polygon: &[Corner], axis: usize, value: f64, sign: i64) -> Vec<Corner> {
    let beyond = |corner: &Corner| (corner[axis].clone() - rational(value)) * BigRational::from(BigInt::from(sign));
    let mut kept = Vec::new();
    for (index, from) in polygon.iter().enumerate() {
        let to = &polygon[(index + 1) % polygon.len()];
        let (a, b) = (beyond(from), beyond(to));
        if !a.is_positive() {
            kept.push(from.clone());
        }
        if (a.is_positive() && b.is_negative()) || (a.is_negative() && b.is_positive()) {
            let share = a.clone() / (a - b);
            kept.push(std::array::from_fn(|i| from[i].clone() + (to[i].clone() - from[i].clone()) * share.clone()));
        }
    }
    kept
}

fn meets_by_clipping(corners: &[DVec3], cell: &Aabb) -> bool {
    let polygon: Vec<Corner> = corners.iter().map(|corner| corner.to_array().map(rational)).collect();
    let sides = (0..3).flat_map(|axis| [(axis, cell.max[axis], 1), (axis, cell.min[axis], -1)]);
    !sides.fold(polygon, |part, (axis, value, sign)| clipped(&part, axis, value, sign)).is_empty()
}

/// Numbers on a coarse grid, where everything touches, and others.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![3 => (-4i32..=4).prop_map(|n| f64::from(n) * 0.5), 1 => -2.0..2.0f64]
}

fn point() -> impl Strategy<Value = DVec3> {
    proptest::array::uniform3(number()).prop_map(DVec3::from_array)
}

fn cell() -> impl Strategy<Value = Aabb> {
    let size = prop_oneof![Just(0.25), Just(0.5), Just(1.0), 0.01..1.5f64];
    (point(), proptest::array::uniform3(size)).prop_map(|(min, size)| Aabb { min, max: min + DVec3::from_array(size) })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn triangles_meet_what_clipping_leaves(corners in proptest::array::uniform3(point()), cell in cell()) {
        let expected = meets_by_clipping(&corners, &cell);
        prop_assert_eq!(overlap::meets(&corners.map(Point::exact), &cell), expected);
    }

    #[test]
    fn a_corner_within_ulps_of_a_cell_is_told(corners in proptest::array::uniform3(point()), share in 0.0..1.0f64, ulps in -2i64..=2) {
        // The cell's corner lies within a few ulps of the triangle.
        let [a, b, c] = corners;
        let near = (a + b) * 0.5 + (c - (a + b) * 0.5) * share;
        let z = if near.z == 0.0 { near.z } else { f64::from_bits(near.z.to_bits().wrapping_add_signed(ulps)) };
        let min = DVec3::new(near.x, near.y, z);
        let cell = Aabb { min, max: min + DVec3::splat(0.5) };
        prop_assert_eq!(overlap::meets(&corners.map(Point::exact), &cell), meets_by_clipping(&corners, &cell));
    }

    #[test]
    fn exact_images_of_boxes_are_met_exactly(
        entries in proptest::array::uniform12(number()), size in proptest::array::uniform3(0.25..2.0f64), cell in cell(),
    ) {
        let Ok(placement) = Placement::new(DAffine3::from_cols_array(&entries)) else { return Ok(()) };
        let cuboid = Cuboid { size };
        let facets = Facets::of_cuboid(&cuboid, &placement);
        for (part, face) in (0u32..).zip(Cuboid::FACES) {
            // Exact images by rational numbers.
            let polygon: Vec<Corner> = face.iter().map(|&corner| image(&entries, cuboid.corners()[corner as usize])).collect();
            let sides = (0..3).flat_map(|axis| [(axis, cell.max[axis], 1), (axis, cell.min[axis], -1)]);
            let rest = sides.fold(polygon, |part, (axis, value, sign)| clipped(&part, axis, value, sign));
            prop_assert_eq!(facets.meets(part, &cell), !rest.is_empty(), "face {}", part);
        }
    }

    #[test]
    fn what_is_inside_a_placed_box_maps_into_it(
        entries in proptest::array::uniform12(number()), size in proptest::array::uniform3(0.25..2.0f64), local in point(),
    ) {
        let Ok(placement) = Placement::new(DAffine3::from_cols_array(&entries)) else { return Ok(()) };
        let facets = Facets::of_cuboid(&Cuboid { size }, &placement);
        let at = DAffine3::from_cols_array(&entries).transform_point3(local);
        let depth = (0..3).map(|axis| size[axis] * 0.5 - local[axis].abs()).fold(f64::INFINITY, f64::min);
        // Rounding moves the point by far less than this in the box's own frame, unless the map is nearly singular.
        prop_assume!(depth.abs() > 1e-6 && DAffine3::from_cols_array(&entries).matrix3.determinant().abs() > 1e-3);
        prop_assert_eq!(facets.encloses(at), depth > 0.0);
    }

    #[test]
    fn winding_is_the_solid_angle(bodies in proptest::collection::vec((point(), 0.3..1.5f64, any::<bool>()), 1..4), at in point()) {
        let facets = octahedra(&bodies);
        let at = at + DVec3::new(1e-3, 2e-3, 5e-4);
        let angle: f64 = (0..facets.len()).map(|facet| {
            let [a, b, c] = [0, 1, 2].map(|i| facets.positions()[facets.facet(facet).corners()[i] as usize] - at);
            solid_angle(a, b, c)
        }).sum();
        let turns = angle / (4.0 * std::f64::consts::PI);
        prop_assume!((turns - turns.round()).abs() < 1e-9); // not on the surface
        prop_assert_eq!(facets.encloses(at), turns.round() > 0.0, "{} turns", turns);
    }
}

fn image(entries: &[f64; 12], local: DVec3) -> Corner {
    std::array::from_fn(|row| {
        let term = |column: usize| rational(entries[3 * column + row]) * rational(local[column]);
        term(0) + term(1) + term(2) + rational(entries[9 + row])
    })
}

/// The signed solid angle of a triangle seen from the origin (van Oosterom & Strackee, 1983).
fn solid_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (l, m, n) = (a.length(), b.length(), c.length());
    let below = l * m * n + a.dot(b) * n + b.dot(c) * l + c.dot(a) * m;
    2.0 * a.dot(b.cross(c)).atan2(below)
}

/// Octahedra about the given centres; some turned inside out.
fn octahedra(bodies: &[(DVec3, f64, bool)]) -> Facets {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for &(centre, radius, is_cavity) in bodies {
        let first = positions.len() as u32;
        for step in [DVec3::X, DVec3::Y, DVec3::Z] {
            positions.extend([(centre + step * radius).to_array(), (centre - step * radius).to_array()]);
        }
        for signs in 0..8u32 {
            let [x, y, z] = [first + (signs & 1), first + 2 + (signs >> 1 & 1), first + 4 + (signs >> 2)];
            let is_turned = (signs.count_ones() % 2 == 1) != is_cavity;
            triangles.push(if is_turned { [x, z, y] } else { [x, y, z] });
        }
    }
    Facets::of_mesh(Mesh::new(positions, triangles).expect("a mesh"), &Placement::IDENTITY)
}

fn cube(min: f64, edge: f64) -> Aabb {
    Aabb { min: DVec3::splat(min), max: DVec3::splat(min + edge) }
}

#[test]
fn a_cavity_is_outside_and_an_overlap_inside() {
    let hollow = octahedra(&[(DVec3::ZERO, 4.0, false), (DVec3::ZERO, 2.0, true)]);
    assert_eq!(hollow.relation(&cube(-0.125, 0.25)), Relation::Outside, "in the cavity");
    assert_eq!(hollow.relation(&cube(1.0, 0.0625)), Relation::Inside, "between the two shells");
    assert_eq!(hollow.relation(&cube(2.0, 1.0)), Relation::Outside, "beyond");
    let [a, b] = [(DVec3::ZERO, 4.0, false), (DVec3::X, 4.0, false)];
    assert!(octahedra(&[a, b]).encloses(DVec3::new(0.5, 0.1, 0.1)), "in both");
    assert!(!octahedra(&[(DVec3::ZERO, 4.0, true)]).encloses(DVec3::ZERO), "a cavity alone encloses nothing");
}

#[test]
fn touching_is_meeting() {
    let facets = Facets::of_cuboid(&Cuboid { size: [2.0; 3] }, &Placement::IDENTITY);
    assert_eq!(facets.relation(&cube(1.0, 1.0)), Relation::Boundary, "one corner");
    assert_eq!(facets.relation(&cube(1.0_f64.next_up(), 1.0)), Relation::Outside);
    assert_eq!(facets.relation(&cube(-0.5, 1.0)), Relation::Inside);
    assert_eq!(facets.relation(&cube(-2.0, 4.0)), Relation::Boundary, "the box holds the solid");
}

#[test]
fn an_open_surface_is_a_surface_that_encloses_nothing() {
    let mesh = Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).expect("a triangle");
    let facets = Facets::of_mesh(mesh, &Placement::IDENTITY);
    assert_eq!(facets.relation(&cube(0.25, 0.25)), Relation::Outside);
    assert_eq!(facets.relation(&cube(0.0, 0.25)), Relation::Boundary);
    let none = Facets::default();
    assert_eq!((none.relation(&cube(0.0, 1.0)), Region::parts(&none)), (Relation::Outside, 0));
}

#[test]
fn rays_through_edges_and_corners_are_counted_once() {
    let facets = octahedra(&[(DVec3::ZERO, 1.0, false)]);
    // Along +x these rays run through a vertex, an edge, or past the silhouette.
    for (at, is_inside) in [
        (DVec3::ZERO, true),
        (DVec3::new(-2.0, 0.0, 0.0), false),
        (DVec3::new(-2.0, 0.5, 0.0), false),
        (DVec3::new(0.0, 0.5, 0.0), true),
        (DVec3::new(-3.0, 0.5, 0.5), false),
        (DVec3::new(-3.0, 1.0, 0.0), false),
        (DVec3::new(-3.0, 0.0, -1.0), false),
    ] {
        assert_eq!(facets.encloses(at), is_inside, "{at}");
    }
}
