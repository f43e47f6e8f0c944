//! Rivals: closed forms in rational numbers where the box keeps its axes in local coordinates, the distance between a
//! parallelepiped and a point elsewhere, and what must hold between a box and its eighths.

use glam::DAffine3;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, Zero};
use proptest::prelude::*;

use super::*;
use crate::{Analytic, Placement, Relation};

type Interval = [BigRational; 2];

fn rational(value: f64) -> BigRational {
    BigRational::from_float(value).expect("finite")
}

fn squared(value: &BigRational) -> BigRational {
    value * value
}

fn least<'a>(a: &'a BigRational, b: &'a BigRational) -> &'a BigRational {
    a.min(b)
}

/// The squares of the least and the greatest distance of a number in the interval from zero.
fn squared_distances([low, high]: &Interval) -> [BigRational; 2] {
    let ends = [squared(low), squared(high)];
    let holds_zero = !low.is_positive() && !high.is_negative();
    let near = if holds_zero { BigRational::zero() } else { ends[0].clone().min(ends[1].clone()) };
    let [a, b] = ends;
    [near, a.max(b)]
}

fn sums(a: [BigRational; 2], b: [BigRational; 2]) -> [BigRational; 2] {
    let ([a0, a1], [b0, b1]) = (a, b);
    [a0 + b0, a1 + b1]
}

/// A closed set: whether the box meets it, and whether it is in its interior.
fn relation_of(meets: bool, is_within: bool) -> Relation {
    match (meets, is_within) {
        (false, _) => Relation::Outside,
        (true, false) => Relation::Boundary,
        (true, true) => Relation::Inside,
    }
}

/// Where a box lies whose sides are along the body's axes.
fn closed_form(body: &Analytic, cell: &[Interval; 3]) -> Relation {
    let [x, y, z] = cell;
    let [near, far] = sums(squared_distances(x), squared_distances(z));
    let between = |height: f64, squared_radius: &dyn Fn(&BigRational) -> BigRational| {
        let half = rational(height) / BigInt::from(2);
        let meets = y[0] <= half && -half.clone() <= y[1];
        let ends = [y[0].clone().max(-half.clone()), y[1].clone().min(half.clone())];
        // All these radii have no greatest value but at the ends, and no least but at the ends or the middle.
        let mut heights = ends.to_vec();
        if ends[0].is_negative() && ends[1].is_positive() {
            heights.push(BigRational::zero());
        }
        let meets = meets && ends.iter().any(|y| near <= squared_radius(y));
        let is_within = -half.clone() < y[0] && y[1] < half && heights.iter().all(|y| far < squared_radius(y));
        relation_of(meets, is_within)
    };
    let cone = |bottom: f64, top: f64, height: f64| {
        let (bottom, top, length) = (rational(bottom), rational(top), rational(height));
        let share = move |y: &BigRational| y / &length + BigRational::new(1.into(), 2.into());
        between(height, &|y| squared(&(&bottom + (&top - &bottom) * share(y))))
    };
    match *body {
        Analytic::Sphere { radius } => closed_form(&Analytic::Ellipsoid { radii: [radius; 3] }, cell),
        Analytic::Ellipsoid { radii } => {
            let scaled = |axis: usize| cell[axis].each_ref().map(|end| end / rational(radii[axis]));
            let [x, y, z] = [0, 1, 2].map(|axis| squared_distances(&scaled(axis)));
            let ([near, far], one) = (sums(sums(x, y), z), rational(1.0));
            relation_of(near <= one, far < one)
        }
        Analytic::Cylinder { radius, height } => cone(radius, radius, height),
        Analytic::Cone { radius, height } => cone(radius, 0.0, height),
        Analytic::Frustum { bottom_radius, top_radius, height } => cone(bottom_radius, top_radius, height),
        Analytic::Capsule { radius, height } => {
            let half = rational(height) / BigInt::from(2);
            let beyond = |y: &BigRational| (y.abs() - &half).max(BigRational::zero());
            let is_beside = y[0] <= half && -half.clone() <= y[1];
            let along = [beyond(&y[0]), beyond(&y[1])];
            let along_near = if is_beside { BigRational::zero() } else { squared(least(&along[0], &along[1])) };
            let along_far = squared(&along[0]).max(squared(&along[1]));
            let radius = squared(&rational(radius));
            relation_of(near + along_near <= radius, far + along_far < radius)
        }
        Analytic::Paraboloid { radius, height } => between(height, &|y| {
            squared(&rational(radius)) * (BigRational::new(1.into(), 2.into()) - y / rational(height))
        }),
        Analytic::Hyperboloid { waist_radius, end_radius, height } => between(height, &|y| {
            let [waist, end] = [waist_radius, end_radius].map(|radius| squared(&rational(radius)));
            &waist + (end - &waist) * squared(&(y * BigInt::from(2) / rational(height)))
        }),
        Analytic::Disk { radius } => {
            let meets = !y[0].is_positive() && !y[1].is_negative() && near <= squared(&rational(radius));
            relation_of(meets, false)
        }
        Analytic::Quadric { .. } => unreachable!("judged by its own"),
    }
}

/// The least and the greatest value of a·x² + b·x.
fn range(a: &BigRational, b: &BigRational, x: &Interval) -> [BigRational; 2] {
    let at = |x: &BigRational| a * squared(x) + b * x;
    let mut values = x.each_ref().map(at).to_vec();
    if !a.is_zero() {
        let vertex = -b / (a * BigInt::from(2));
        if x[0] <= vertex && vertex <= x[1] {
            values.push(at(&vertex));
        }
    }
    values.sort();
    [values[0].clone(), values[values.len() - 1].clone()]
}

/// Σ a·x² + b·x + c over a box within a box: every part of the surface by ranges of separate variables.
fn separable(a: [f64; 3], b: [f64; 3], c: f64, within: [[f64; 3]; 2], cell: &[Interval; 3]) -> Relation {
    let limits: [Interval; 3] = std::array::from_fn(|k| within.map(|corner| rational(corner[k])));
    let extremes = |cut: &[Interval; 3]| {
        let is_empty = cut.iter().any(|[low, high]| low > high);
        let ranges: [_; 3] = std::array::from_fn(|k| range(&rational(a[k]), &rational(b[k]), &cut[k]));
        let [x, y, z] = ranges;
        let [low, high] = sums(sums(x, y), z).map(|sum| sum + rational(c));
        (!is_empty).then_some((low, high))
    };
    let cut: [Interval; 3] = std::array::from_fn(|k| {
        [cell[k][0].clone().max(limits[k][0].clone()), cell[k][1].clone().min(limits[k][1].clone())]
    });
    let is_on_sheet = extremes(&cut).is_some_and(|(low, high)| !low.is_positive() && !high.is_negative());
    let is_on_side = (0..3).any(|axis| {
        limits[axis].iter().any(|side| {
            let mut face = cut.clone();
            let holds = cell[axis][0] <= *side && *side <= cell[axis][1];
            face[axis] = [side.clone(), side.clone()];
            holds && extremes(&face).is_some_and(|(low, _)| !low.is_positive())
        })
    });
    if is_on_sheet || is_on_side {
        return Relation::Boundary;
    }
    let corner: [Interval; 3] = cell.each_ref().map(|[low, _]| [low.clone(), low.clone()]);
    let is_in_box = (0..3).all(|k| limits[k][0] < corner[k][0] && corner[k][0] < limits[k][1]);
    let is_inside = is_in_box && extremes(&corner).is_some_and(|(low, _)| low.is_negative());
    if is_inside { Relation::Inside } else { Relation::Outside }
}

/// Numbers on a coarse grid, where everything touches, and others.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![4 => (-6i32..=6).prop_map(|n| f64::from(n) * 0.25), 1 => -2.0..2.0f64]
}

fn size() -> impl Strategy<Value = f64> {
    prop_oneof![4 => (1i32..=6).prop_map(|n| f64::from(n) * 0.25), 1 => 0.01..2.0f64]
}

fn triple<S: Strategy>(one: impl Fn() -> S) -> impl Strategy<Value = [S::Value; 3]> {
    [one(), one(), one()]
}

/// Boxes; a few of their coordinates are moved by an ulp or two.
fn cell() -> impl Strategy<Value = Aabb> {
    let moved = || prop_oneof![6 => Just(0i64), 1 => -2i64..=2];
    let nudged = |v: f64, ulps: i64| if v == 0.0 { v } else { f64::from_bits(v.to_bits().wrapping_add_signed(ulps)) };
    let edge = || prop_oneof![3 => size(), 1 => (8i32..=16).prop_map(|n| f64::from(n) * 0.25)];
    (triple(number), triple(edge), [moved(), moved(), moved(), moved(), moved(), moved()]).prop_map(
        move |(min, size, ulps)| Aabb {
            min: DVec3::from_array(std::array::from_fn(|k| nudged(min[k], ulps[k]))),
            max: DVec3::from_array(std::array::from_fn(|k| nudged(min[k] + size[k], ulps[3 + k]))),
        },
    )
}

fn body() -> impl Strategy<Value = Analytic> {
    let two = || [size(), size()];
    prop_oneof![
        size().prop_map(|radius| Analytic::Sphere { radius }),
        triple(size).prop_map(|radii| Analytic::Ellipsoid { radii }),
        two().prop_map(|[radius, height]| Analytic::Cylinder { radius, height }),
        two().prop_map(|[radius, height]| Analytic::Cone { radius, height }),
        triple(size).prop_map(|[bottom_radius, top_radius, height]| Analytic::Frustum {
            bottom_radius,
            top_radius,
            height
        }),
        two().prop_map(|[radius, height]| Analytic::Capsule { radius, height }),
        two().prop_map(|[radius, height]| Analytic::Paraboloid { radius, height }),
        triple(size).prop_map(|[a, b, height]| Analytic::Hyperboloid {
            waist_radius: a.min(b),
            end_radius: a.max(b),
            height
        }),
        size().prop_map(|radius| Analytic::Disk { radius }),
    ]
}

/// Which world axis each local axis lies along, and how long one unit of it is; then where the origin is.
#[derive(Clone, Debug)]
struct Axes {
    permutation: [usize; 3],
    scale: [f64; 3],
    translation: [f64; 3],
}

impl Axes {
    fn strategy() -> impl Strategy<Value = Self> {
        let permutations = vec![[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let scale = || prop_oneof![2 => Just(1.0), 1 => Just(-1.0), 1 => Just(0.5), 1 => Just(3.0), 1 => -3.0..-0.1f64];
        (proptest::sample::select(permutations), triple(scale), triple(number))
            .prop_map(|(permutation, scale, translation)| Self { permutation, scale, translation })
    }

    fn placement(&self) -> Placement {
        let mut entries = [0.0; 12];
        for local in 0..3 {
            entries[3 * local + self.permutation[local]] = self.scale[local];
            entries[9 + local] = self.translation[local];
        }
        Placement::new(DAffine3::from_cols_array(&entries)).expect("regular")
    }

    fn local(&self, cell: &Aabb) -> [Interval; 3] {
        std::array::from_fn(|local| {
            let world = self.permutation[local];
            let ends = [cell.min, cell.max].map(|corner| {
                (rational(corner[world]) - rational(self.translation[world])) / rational(self.scale[local])
            });
            let [a, b] = ends;
            [a.clone().min(b.clone()), a.max(b)]
        })
    }
}

fn placed(body: Analytic, placement: Placement) -> PlacedAnalytic {
    PlacedAnalytic::new(body, placement).expect("a body")
}

fn at(body: Analytic, [x, y, z]: [f64; 3]) -> PlacedAnalytic {
    placed(body, Placement::new(DAffine3::from_translation(DVec3::new(x, y, z))).expect("regular"))
}

fn eighths(cell: &Aabb) -> Vec<Aabb> {
    let planes = [cell.min, cell.center(), cell.max];
    let pick = |number: usize, upper: usize| {
        DVec3::from_array(std::array::from_fn(|axis| planes[(number >> axis & 1) + upper][axis]))
    };
    (0..8).map(|number| Aabb { min: pick(number, 0), max: pick(number, 1) }).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn boxes_along_the_axes_lie_where_closed_forms_say(body in body(), axes in Axes::strategy(), cell in cell()) {
        prop_assert_eq!(placed(body, axes.placement()).relation(&cell), closed_form(&body, &axes.local(&cell)));
    }

    #[test]
    fn quadrics_without_mixed_terms_too(
        a in triple(number), b in triple(number), c in number(), within in cell(), axes in Axes::strategy(), cell in cell(),
    ) {
        let within = [within.min.to_array(), within.max.to_array()];
        let mut matrix = [[0.0; 4]; 4];
        for k in 0..3 {
            matrix[k][k] = a[k];
            matrix[k][3] = b[k];
        }
        matrix[3][3] = c;
        let body = Analytic::Quadric { matrix, within };
        prop_assume!(body.check().is_ok());
        let expected = separable(a, b, c, within, &axes.local(&cell));
        prop_assert_eq!(placed(body, axes.placement()).relation(&cell), expected);
    }
}

/// Rational linear algebra for boxes askew.
mod askew {
    use super::*;

    pub(super) type Vector = [BigRational; 3];

    pub(super) fn dot(a: &Vector, b: &Vector) -> BigRational {
        (0..3).map(|k| &a[k] * &b[k]).sum()
    }

    fn plus(a: &Vector, b: &Vector, share: &BigRational) -> Vector {
        std::array::from_fn(|k| &a[k] + &b[k] * share)
    }

    fn clamped_unit(value: BigRational) -> BigRational {
        value.max(BigRational::zero()).min(rational(1.0))
    }

    /// The squared distance of the origin from the segment p, p + a.
    fn to_segment(p: &Vector, a: &Vector) -> BigRational {
        let share = clamped_unit(-dot(p, a) / dot(a, a));
        let nearest = plus(p, a, &share);
        dot(&nearest, &nearest)
    }

    /// The squared distance of the origin from the parallelogram p + s·a + t·b: its foot, if that lies in it, or the sides.
    fn to_parallelogram(p: &Vector, a: &Vector, b: &Vector) -> BigRational {
        let (aa, ab, bb, pa, pb) = (dot(a, a), dot(a, b), dot(b, b), dot(p, a), dot(p, b));
        let determinant = &aa * &bb - &ab * &ab;
        let s = (&ab * &pb - &bb * &pa) / &determinant;
        let t = (&ab * &pa - &aa * &pb) / &determinant;
        let one = rational(1.0);
        if !s.is_negative() && s <= one && !t.is_negative() && t <= one {
            let foot = plus(&plus(p, a, &s), b, &t);
            return dot(&foot, &foot);
        }
        let sides = [(p.clone(), a), (plus(p, b, &one), a), (p.clone(), b), (plus(p, a, &one), b)];
        sides.iter().map(|(p, a)| to_segment(p, a)).min().expect("four sides")
    }

    /// The squares of the least and greatest distance of a parallelepiped from the origin.
    pub(super) fn distances(corner: &Vector, edges: &[Vector; 3]) -> [BigRational; 2] {
        let one = rational(1.0);
        let corners = (0..8).map(|number| {
            (0..3).fold(corner.clone(), |p, k| if number >> k & 1 == 1 { plus(&p, &edges[k], &one) } else { p })
        });
        let far = corners.map(|p| dot(&p, &p)).max().expect("eight corners");
        if solution(edges, corner).iter().all(|share| !share.is_positive() && -share <= one) {
            return [BigRational::zero(), far];
        }
        let faces = (0..3).flat_map(|k| [(corner.clone(), k), (plus(corner, &edges[k], &one), k)]);
        let near = faces.map(|(p, k)| to_parallelogram(&p, &edges[(k + 1) % 3], &edges[(k + 2) % 3]));
        [near.min().expect("six faces"), far]
    }

    fn determinant(columns: [&Vector; 3]) -> BigRational {
        let [a, b, c] = columns;
        let minor = |i: usize, j: usize| &b[i] * &c[j] - &b[j] * &c[i];
        &a[0] * minor(1, 2) + &a[1] * minor(2, 0) + &a[2] * minor(0, 1)
    }

    /// The shares of the columns that sum up to the right side.
    pub(super) fn solution(columns: &[Vector; 3], right: &Vector) -> Vector {
        let [a, b, c] = columns;
        let whole = determinant([a, b, c]);
        [determinant([right, b, c]), determinant([a, right, c]), determinant([a, b, right])].map(|part| part / &whole)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn sheared_spheres_lie_where_distances_say(entries in proptest::array::uniform12(number()), radius in size(), cell in cell()) {
        let Ok(placement) = Placement::new(DAffine3::from_cols_array(&entries)) else { return Ok(()) };
        let columns: [askew::Vector; 3] = std::array::from_fn(|j| std::array::from_fn(|i| rational(entries[3 * j + i])));
        let corner: askew::Vector = std::array::from_fn(|k| rational(cell.min[k]) - rational(entries[9 + k]));
        let edges: [askew::Vector; 3] = std::array::from_fn(|axis| {
            let mut edge = [0.0; 3].map(rational);
            edge[axis] = rational(cell.max[axis]) - rational(cell.min[axis]);
            askew::solution(&columns, &edge)
        });
        let [near, far] = askew::distances(&askew::solution(&columns, &corner), &edges);
        let radius_squared = squared(&rational(radius));
        let expected = relation_of(near <= radius_squared, far < radius_squared);
        prop_assert_eq!(placed(Analytic::Sphere { radius }, placement).relation(&cell), expected);
    }

    #[test]
    fn a_box_meets_what_its_eighths_meet(body in body(), entries in proptest::array::uniform12(number()), cell in cell()) {
        let Ok(placement) = Placement::new(DAffine3::from_cols_array(&entries)) else { return Ok(()) };
        check_eighths(&placed(body, placement), &cell)?;
    }

    #[test]
    fn so_with_quadrics_of_all_kinds(
        matrix in proptest::array::uniform4(proptest::array::uniform4(number())), within in cell(),
        entries in proptest::array::uniform12(number()), cell in cell(),
    ) {
        let Ok(placement) = Placement::new(DAffine3::from_cols_array(&entries)) else { return Ok(()) };
        let body = Analytic::Quadric { matrix, within: [within.min.to_array(), within.max.to_array()] };
        prop_assume!(body.check().is_ok());
        check_eighths(&placed(body, placement), &cell)?;
    }
}

fn check_eighths(body: &PlacedAnalytic, cell: &Aabb) -> Result<(), TestCaseError> {
    let eighths = eighths(cell);
    for part in 0..Region::parts(body) {
        let expected = eighths.iter().any(|eighth| body.meets(part, eighth));
        prop_assert_eq!(body.meets(part, cell), expected, "part {}", part);
    }
    let whole = body.relation(cell);
    for eighth in &eighths {
        let relation = body.relation(eighth);
        prop_assert!(whole == Relation::Boundary || relation == whole);
        // Corners of both sides in one box: the surface is between them.
        let sides: Vec<Sign> =
            [eighth.min, eighth.center(), eighth.max].map(|x| body.side(&Point::exact(x), false)).to_vec();
        let is_mixed = sides.contains(&Sign::Negative) && sides.contains(&Sign::Positive);
        prop_assert!(!(is_mixed || sides.contains(&Sign::Zero)) || relation == Relation::Boundary, "{:?}", sides);
    }
    Ok(())
}

fn cube(min: [f64; 3], edge: f64) -> Aabb {
    let min = DVec3::from_array(min);
    Aabb { min, max: min + DVec3::splat(edge) }
}

#[test]
fn touching_is_meeting_to_the_last_bit() {
    let sphere = at(Analytic::Sphere { radius: 3.0 }, [0.0; 3]);
    // A face, an edge and a corner of a box: (2, 2, 1) is on the sphere.
    for (touching, apart) in [
        ([3.0, -1.0, -1.0], [3.0f64.next_up(), -1.0, -1.0]),
        ([2.0, 2.0, 1.0], [2.0, 2.0, 1.0f64.next_up()]),
        ([-0.5, 3.0, -0.25], [-0.5, 3.0f64.next_up(), -0.25]),
    ] {
        assert_eq!(sphere.relation(&cube(touching, 1.5)), Relation::Boundary, "{touching:?}");
        assert_eq!(sphere.relation(&cube(apart, 1.5)), Relation::Outside, "{apart:?}");
    }
    let inner = |corner: f64| Aabb { min: DVec3::ZERO, max: DVec3::new(2.0, 2.0, corner) };
    assert_eq!(sphere.relation(&inner(1.0)), Relation::Boundary, "a corner from within");
    assert_eq!(sphere.relation(&inner(1.0f64.next_down())), Relation::Inside);
    assert_eq!(sphere.relation(&cube([-8.0; 3], 16.0)), Relation::Boundary, "the box holds the sphere");
}

#[test]
fn apex_and_rim_touch() {
    let cone = at(Analytic::Cone { radius: 5.0, height: 2.0 }, [0.0; 3]);
    assert_eq!(cone.relation(&cube([-0.5, 1.0, -0.5], 1.0)), Relation::Boundary, "apex on a face");
    assert_eq!(cone.relation(&cube([0.0, 1.0, 0.0], 1.0)), Relation::Boundary, "apex on a corner");
    assert_eq!(cone.relation(&cube([-0.5, 1.0f64.next_up(), -0.5], 1.0)), Relation::Outside);
    assert_eq!(cone.relation(&cube([f64::MIN_POSITIVE, 1.0, 0.0], 1.0)), Relation::Outside, "beside the apex");
    assert_eq!(cone.relation(&cube([3.0, -2.0, 4.0], 1.0)), Relation::Boundary, "a corner on the rim");
    assert_eq!(cone.relation(&cube([3.0f64.next_up(), -2.0, 4.0], 1.0)), Relation::Outside);
    let disk = at(Analytic::Disk { radius: 5.0 }, [0.0; 3]);
    assert_eq!(disk.relation(&cube([3.0, -2.0, 4.0], 2.0)), Relation::Boundary, "a rim on an edge");
    assert_eq!(disk.relation(&cube([3.0, 0.0, 4.0], 2.0)), Relation::Boundary, "and a corner");
    assert_eq!(disk.relation(&cube([3.0, f64::MIN_POSITIVE, 4.0], 2.0)), Relation::Outside);
    assert_eq!(disk.relation(&cube([3.0, 0.0, 4.0f64.next_up()], 2.0)), Relation::Outside);
}

#[test]
fn the_seams_of_a_capsule_are_no_surface() {
    let capsule = at(Analytic::Capsule { radius: 1.0, height: 2.0 }, [0.0; 3]);
    assert_eq!(capsule.relation(&cube([-0.25, 0.75, -0.25], 0.5)), Relation::Inside, "across the upper seam");
    assert_eq!(capsule.relation(&cube([-0.5, -0.5, -0.5], 1.0)), Relation::Inside);
    assert!(capsule.encloses(DVec3::new(0.5, 1.0, 0.0)), "on the seam's plane");
    assert_eq!(capsule.relation(&cube([0.0, 2.0, 0.0], 1.0)), Relation::Boundary, "the pole");
    assert_eq!(capsule.relation(&cube([1.0, -0.5, 0.0], 1.0)), Relation::Boundary, "along the side");
    assert_eq!(capsule.relation(&cube([1.0f64.next_up(), -0.5, 0.0], 1.0)), Relation::Outside);
}

#[test]
fn all_sheets_of_a_quadric_are_surface() {
    let mut matrix = [[0.0; 4]; 4];
    matrix[0][0] = -1.0;
    let body = at(Analytic::Quadric { matrix, within: [[-1.0; 3], [1.0; 3]] }, [0.0; 3]);
    assert_eq!(body.relation(&cube([0.25, -0.5, -0.5], 0.5)), Relation::Inside);
    assert_eq!(body.relation(&cube([-0.25, -0.5, -0.5], 0.5)), Relation::Boundary, "the sheet x = 0");
    assert_eq!(body.relation(&cube([0.0, -0.5, -0.5], 0.5)), Relation::Boundary, "touched");
    assert_eq!(body.relation(&cube([f64::MIN_POSITIVE, -0.5, -0.5], 0.5)), Relation::Inside);
    assert_eq!(body.relation(&cube([1.0, -0.5, -0.5], 0.5)), Relation::Boundary, "a side of the box");
    matrix[0][0] = 1.0;
    matrix[3][3] = 1.0;
    let nothing = at(Analytic::Quadric { matrix, within: [[-1.0; 3], [1.0; 3]] }, [0.0; 3]);
    assert_eq!(nothing.relation(&cube([-4.0; 3], 8.0)), Relation::Outside, "x² + 1 ≤ 0");
}

#[test]
fn answers_do_not_change_with_scale_or_far_away() {
    let cells = [cube([2.0, 2.0, 1.0], 1.0), cube([2.0, 2.0, 1.0f64.next_up()], 1.0), cube([-1.0; 3], 2.0)];
    let expected = [Relation::Boundary, Relation::Outside, Relation::Inside];
    for power in [-199, -100, 0, 60, 197] {
        let scale = 2f64.powi(power);
        let body = placed(
            Analytic::Sphere { radius: 3.0 },
            Placement::new(DAffine3::from_scale(DVec3::splat(scale))).expect("regular"),
        );
        for (cell, expected) in cells.iter().zip(expected) {
            let cell = Aabb { min: cell.min * scale, max: cell.max * scale };
            assert_eq!(body.relation(&cell), expected, "2^{power}, {cell:?}");
        }
    }
    let far = at(Analytic::Sphere { radius: 1.0 }, [2f64.powi(50), 0.0, 0.0]);
    let beside = |x: f64| Aabb { min: DVec3::new(x, -1.0, -1.0), max: DVec3::new(2f64.powi(51), 1.0, 1.0) };
    assert_eq!(far.relation(&beside(2f64.powi(50) + 1.0)), Relation::Boundary);
    assert_eq!(far.relation(&beside(2f64.powi(50) + 1.25)), Relation::Outside);
}

#[test]
fn boxes_without_end_or_without_points() {
    let body = at(Analytic::Cylinder { radius: 1.0, height: 2.0 }, [0.0; 3]);
    let space = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
    let above = Aabb { min: DVec3::new(f64::NEG_INFINITY, 1.5, -1.0), max: DVec3::INFINITY };
    assert_eq!(body.relation(&space), Relation::Boundary);
    assert_eq!(body.relation(&above), Relation::Outside);
    assert_eq!(body.relation(&Aabb::EMPTY), Relation::Outside);
    assert!(!body.encloses(DVec3::NAN));
}
