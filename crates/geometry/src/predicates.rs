//! Signs that decide: each a floating-point filter with a running error bound, the same in pairs of floats, then exact sums of
//! floats where all coordinates are floats, then big numbers.

use glam::DVec3;

use crate::{
    approx::{Approx, UNIT_ROUNDOFF, sorted},
    decide::Decide,
    decisions::{Decisions, Level, count, decide},
    dyadic::Dyadic,
    expansion::{self, difference},
    light::LightSource,
    number::power_of_two_below,
    pair::Pair,
    point::{ExactPoint, Point},
    ring::{Sign, determinant},
};

/// How many decisions of this process went on to exact arithmetic so far: exact sums of floats, or big numbers.
/// [`Decisions`] tells them apart.
pub fn exact_fallbacks() -> u64 {
    let Decisions { expansion, exact, .. } = Decisions::of_process();
    expansion + exact
}

/// What [`side_value`] is asked about: a point, or a light.
#[derive(Clone, Copy, Debug)]
pub enum Target<'a> {
    /// A point of space.
    Point(&'a Point<'a>),
    /// A light: a point, or a direction for a sun.
    Light(&'a LightSource),
}

/// The side of the plane (a, b, c) on which a point lies: positive in front, where a, b, c appear counter-clockwise.
///
/// Cost: about 40 flops; a few microseconds where the filter is in doubt.
pub fn side(a: &Point, b: &Point, c: &Point, x: &Point) -> Sign {
    Sign::of(side_value(a, b, c, Target::Point(x)).value)
}

/// The side of the plane (a, b, c) on which a light lies; see [`side`].
pub fn light_side(a: &Point, b: &Point, c: &Point, light: &LightSource) -> Sign {
    Sign::of(side_value(a, b, c, Target::Light(light)).value)
}

/// The determinant |a − c, b − c, x − w·c| with a bound that never straddles zero: its sign is exact, and an exact
/// zero has no error. Twice the area of (a, b, c) times the distance of x for a point; degree 3.
pub fn side_value(a: &Point, b: &Point, c: &Point, x: Target) -> Approx {
    if coincide(a, b) || coincide(b, c) || coincide(c, a) {
        return Approx::exact(0.0);
    }
    if let Target::Point(p) = x
        && (coincide(p, a) || coincide(p, b) || coincide(p, c))
    {
        return Approx::exact(0.0);
    }
    let filtered = side_filter(a, b, c, x);
    let known = match filtered.sign() {
        Some(_) => Some(filtered),
        None => are_on_two_lines(a, b, c, x).then_some(Approx::exact(0.0)),
    };
    if known.is_none()
        && let grid = power_of_two_below(filtered.error * PAIR_GRID)
        && let Some(value) = side_pair([a, b, c].map(Pair::of_point), x).on_grid(grid)
    {
        count(Level::Pair, 1);
        return value;
    }
    if known.is_none()
        && let Some(rows) = rows_of_floats(a, b, c, x)
    {
        count(Level::Expansion, 1);
        return expansion::determinant(&rows);
    }
    decide(known, || {
        let exact = match x {
            Target::Point(p) => p.to_exact(),
            Target::Light(l) => ExactPoint::from_light(l),
        };
        exact_side::<Dyadic>(&a.to_exact(), &b.to_exact(), &c.to_exact(), &exact).to_approx()
    })
}

/// What pairs tell is rounded to this share of the filter's bound, which no order of the axes changes: some 2^20 times what
/// pairs may lose.
const PAIR_GRID: f64 = f64::EPSILON * (1 << 22) as f64;

/// Whether coordinates alone tell that the four are in one plane: they lie on two lines along the same axis, as the corners of
/// upright walls do. A sun along the axis is on every such line.
fn are_on_two_lines(a: &Point, b: &Point, c: &Point, x: Target) -> bool {
    (0..3).any(|axis| {
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        let shares =
            |p: &Point, q: &Point, i: usize| p.position[i] == q.position[i] && p.slack[i] == 0.0 && q.slack[i] == 0.0;
        let is_above = |p: &Point, q: &Point| shares(p, q, j) && shares(p, q, k);
        let x = match x {
            Target::Point(p) => *p,
            Target::Light(l) if !l.is_sun() => Point::exact(l.xyz()),
            Target::Light(l) if l.xyz()[j] == 0.0 && l.xyz()[k] == 0.0 => *c,
            Target::Light(_) => return false,
        };
        let (on_c, off_c) = [a, b, &x]
            .into_iter()
            .fold((0, None), |(on, off), p| if is_above(p, c) { (on + 1, off) } else { (on, off.or(Some(p))) });
        on_c >= 2 || off_c.is_some_and(|other| [a, b, &x].into_iter().all(|p| is_above(p, c) || is_above(p, other)))
    })
}

/// The rows a − c, b − c, x − w·c without rounding, each entry a float and its rest; `None` unless all coordinates are floats.
fn rows_of_floats(a: &Point, b: &Point, c: &Point, x: Target) -> Option<[[[f64; 2]; 3]; 3]> {
    let row = |p: DVec3, c: DVec3| std::array::from_fn(|k| difference(p[k], c[k]));
    let (position, origin, is_float) = match x {
        Target::Point(p) => (p.position, c.position, p.slack == DVec3::ZERO),
        Target::Light(l) => (l.xyz(), if l.is_sun() { DVec3::ZERO } else { c.position }, true),
    };
    let are_floats = is_float && [a, b, c].iter().all(|p| p.slack == DVec3::ZERO);
    are_floats.then(|| [row(a.position, c.position), row(b.position, c.position), row(position, origin)])
}

/// The filter of [`side_value`] alone: the bound may straddle zero. Exact points are not looked at, only slacks.
pub fn side_filter(a: &Point, b: &Point, c: &Point, x: Target) -> Approx {
    let (position, slack, w) = match x {
        Target::Point(p) => (p.position, p.slack, 1.0),
        Target::Light(l) => (l.xyz(), DVec3::ZERO, l.w()),
    };
    if a.slack + b.slack + c.slack + slack == DVec3::ZERO {
        return rows_filter(a.position - c.position, b.position - c.position, position - c.position * w);
    }
    determinant(&[a.minus(c), b.minus(c), row_of(x, c)])
}

/// A bound for the determinant of three rows, each a difference of floats (or a float), as a share of the permanent of the magnitudes.
/// Shewchuk's (7 + 56u)·u tells the sign ("Adaptive Precision Floating-Point Arithmetic", 1997, §4.3): the rounding of the last
/// sum cannot change it. Of the value it is one u more.
const ROUNDED_ROWS_BOUND: f64 = (8.0 + 64.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

/// As [`side_filter`], of points that are floats.
#[inline(always)]
pub fn float_side_filter(a: DVec3, b: DVec3, c: DVec3, x: DVec3) -> Approx {
    rows_filter(a - c, b - c, x - c)
}

/// As [`side_filter`] of a light and points that are floats, for the sign alone: which order the axes have may change the last bits.
#[inline(always)]
pub fn float_light_filter(a: DVec3, b: DVec3, c: DVec3, light: &LightSource) -> Approx {
    let [terms, permanent] = terms_of_rows(a - c, b - c, light.xyz() - c * light.w());
    Approx { value: terms.element_sum(), error: permanent.element_sum() * ROUNDED_ROWS_BOUND }
}

/// The determinant of three rows, each a rounded difference of two exact floats or an exact float, with a bound of its error.
#[inline(always)]
pub fn rows_filter(a: DVec3, b: DVec3, x: DVec3) -> Approx {
    let [terms, permanent] = terms_of_rows(a, b, x);
    Approx { value: symmetric_sum(terms), error: symmetric_sum(permanent) * ROUNDED_ROWS_BOUND }
}

/// The terms whose sum is the determinant of three rows, and those of the permanent of their magnitudes.
#[inline(always)]
fn terms_of_rows(a: DVec3, b: DVec3, x: DVec3) -> [DVec3; 2] {
    let terms = a * b.cross(x);
    let (a, b, x) = (a.abs(), b.abs(), x.abs());
    [terms, a * DVec3::new(b.y * x.z + b.z * x.y, b.z * x.x + b.x * x.z, b.x * x.y + b.y * x.x)]
}

/// [`side_value`] in pairs of floats; the corners are those of [`Pair::of_point`].
fn side_pair(corners: [[Pair; 3]; 3], x: Target) -> Pair {
    let (x, w) = match x {
        Target::Point(p) => (Pair::of_point(p), 1.0),
        Target::Light(l) => (l.xyz().to_array().map(Pair::exact), l.w()),
    };
    side_of_pairs(&corners, &x, w)
}

/// The determinant |a − c, b − c, x − w·c| for w = 1, or 0 for a direction.
pub(crate) fn side_of_pairs([a, b, c]: &[[Pair; 3]; 3], x: &[Pair; 3], w: f64) -> Pair {
    let from_c = |p: &[Pair; 3]| std::array::from_fn(|k| p[k] - c[k]);
    determinant(&[from_c(a), from_c(b), if w == 0.0 { *x } else { from_c(x) }])
}

/// The sum of the coordinates, rounded alike whatever the order of the axes: least, greatest, then the one between.
#[inline(always)]
pub fn symmetric_sum(terms: DVec3) -> f64 {
    let [least, middle, greatest] = sorted(terms.to_array());
    least + greatest + middle
}

/// The determinant behind [`side_value`], as exact as its numbers, times the positive weights w_a·w_b·w_c (for weights 1 it is
/// equal).
pub fn exact_side<T: Decide>(a: &ExactPoint<T>, b: &ExactPoint<T>, c: &ExactPoint<T>, x: &ExactPoint<T>) -> T {
    // Rows w_c·a − w_a·c; the common factor w_c² is not divided out: it is positive.
    let row = |p: &ExactPoint<T>| -> [T; 3] {
        std::array::from_fn(|i| p.xyz[i].clone() * c.w.clone() - c.xyz[i].clone() * p.w.clone())
    };
    determinant(&[row(a), row(b), row(x)])
}

/// Whether two points are the same at a glance, by their floats or as one and the same corner of a body: neighbours on a
/// surface share corners all the time.
#[inline]
pub fn coincide(a: &Point, b: &Point) -> bool {
    if a.position != b.position {
        return false;
    }
    let are_floats = a.slack == DVec3::ZERO && b.slack == DVec3::ZERO;
    are_floats || matches!((a.exact, b.exact), (Some(a), Some(b)) if a.is_same(b))
}

fn row_of(x: Target, c: &Point) -> [Approx; 3] {
    match x {
        Target::Point(p) => p.minus(c),
        Target::Light(l) if l.is_sun() => exact_vector(l.xyz()),
        Target::Light(l) => Point::exact(l.xyz()).minus(c),
    }
}

fn exact_vector(v: DVec3) -> [Approx; 3] {
    v.to_array().map(Approx::exact)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ring::Ring;
    use glam::Vec3Swizzles;
    use proptest::prelude::*;

    #[test]
    fn the_front_is_where_the_corners_run_counter_clockwise() {
        let [a, b, c] = [DVec3::ZERO, DVec3::X, DVec3::Y].map(Point::exact);
        assert_eq!(side(&a, &b, &c, &Point::exact(DVec3::Z)), Sign::Positive);
        assert_eq!(side(&a, &b, &c, &Point::exact(-DVec3::Z)), Sign::Negative);
        let sun = LightSource::sun([0.0, 0.0, -1.0]).expect("a sun overhead");
        assert_eq!(light_side(&a, &b, &c, &sun), Sign::Positive);
        let level = LightSource::sun([1.0, 0.0, 0.0]).expect("a sun in the plane");
        assert_eq!(light_side(&a, &b, &c, &level), Sign::Zero);
    }

    /// How one decision falls.
    fn level_of<T>(decide: impl FnOnce() -> T) -> (T, Decisions) {
        let before = Decisions::of_thread();
        let answer = decide();
        (answer, Decisions::of_thread() - before)
    }

    const NONE: Decisions = Decisions { single: 0, double: 0, pair: 0, expansion: 0, exact: 0 };
    const DOUBLE: Decisions = Decisions { double: 1, ..NONE };
    const PAIR: Decisions = Decisions { pair: 1, ..NONE };
    const EXPANSION: Decisions = Decisions { expansion: 1, ..NONE };
    const EXACT: Decisions = Decisions { exact: 1, ..NONE };

    fn side_of(corners: [[f64; 3]; 4]) -> (Sign, Decisions) {
        let [a, b, c, x] = corners.map(|corner| Point::exact(corner.into()));
        level_of(|| side(&a, &b, &c, &x))
    }

    #[test]
    fn clear_sides_are_told_by_the_filter() {
        assert_eq!(side_of([[0.1; 3], [1.3, 0.2, 0.4], [0.3, 1.1, 0.2], [0.2, 0.4, 9.0]]), (Sign::Positive, DOUBLE));
    }

    #[test]
    fn points_near_one_plane_are_told_by_pairs() {
        // On the plane x + y + z = 1 exactly, with few digits, and one ulp beside it.
        let [a, b, c] = [[0.25, 0.25, 0.5], [0.125, 0.625, 0.25], [0.75, 0.1875, 0.0625]];
        assert_eq!(side_of([a, b, c, [0.5, 0.375, 0.125]]), (Sign::Zero, PAIR));
        let beside = [0.5_f64.next_up(), 0.375, 0.125];
        let (sign, level) = side_of([a, b, c, beside]);
        let far = [0.6, 0.475, 0.225];
        assert_eq!((sign, level), (side_of([a, b, c, far]).0, PAIR), "as a point far out on that side");
    }

    #[test]
    fn points_in_one_plane_with_all_their_digits_are_told_by_exact_sums() {
        // Corners of a parallelogram with long coordinates: x = a + (b − c) without rounding, as all three are in [1, 2).
        let [a, b, c] = [[1.1, 1.7, 1.3], [1.9, 1.2, 1.6], [1.4, 1.5, 1.8]];
        let x: [f64; 3] = std::array::from_fn(|k| a[k] + (b[k] - c[k]));
        assert!((0..3).all(|k| (1.0..2.0).contains(&x[k])), "no rounding");
        let (sign, level) = side_of([a, b, c, x]);
        assert_eq!(sign, Sign::Zero);
        assert_eq!(level, EXPANSION);
    }

    #[test]
    fn points_in_one_plane_that_are_no_floats_are_told_by_big_numbers() {
        // The corners of a tilted rectangle: none is a float, and the fourth is in the plane of the others.
        let turned = glam::DAffine3::from_quat(glam::DQuat::from_xyzw(0.1, 0.7, 0.2, 0.3).normalize());
        let placement = crate::Placement::new(turned).expect("regular");
        let facets = crate::Facets::of_rectangle(&crate::Rectangle { size: [3.0, 1.0] }, &placement);
        let [a, b, c, d] = [0, 1, 2, 3].map(|corner| facets.point(corner));
        assert_eq!(level_of(|| side(&a, &b, &c, &d)), (Sign::Zero, EXACT));
        assert_eq!(level_of(|| side(&a, &b, &c, &b)), (Sign::Zero, NONE), "a corner itself");
    }

    #[test]
    fn walls_are_told_by_their_coordinates() {
        let wall =
            [[422.421, 1.13, -20.971], [423.815, 2.25, -20.594], [423.815, 1.13, -20.594], [422.421, 2.26, -20.971]];
        assert_eq!(side_of(wall), (Sign::Zero, DOUBLE));
        // A sun along the upright edges.
        let [a, b, c, _] = wall.map(|corner| Point::exact(corner.into()));
        let zenith = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun overhead");
        assert_eq!(level_of(|| light_side(&a, &b, &c, &zenith)), (Sign::Zero, DOUBLE));
    }

    proptest! {
        #[test]
        fn the_value_is_the_same_whatever_the_axes(
            p in proptest::array::uniform12(-8i32..8), third in any::<bool>(), ulps in -2i64..=2, s in 0i32..4, t in 0i32..4,
        ) {
            let unit = if third { 1.0 / 3.0 } else { 0.125 };
            let [a, b, c, off] = [0, 1, 2, 3].map(|i| DVec3::from_array([0, 1, 2].map(|k| f64::from(p[3 * i + k]) * unit)));
            // Near the plane of the others, so that all levels are reached, or a light anywhere.
            let mut x = a + (b - a) * (0.25 * f64::from(s)) + (c - a) * (0.25 * f64::from(t));
            if x.y != 0.0 {
                x.y = f64::from_bits(x.y.to_bits().wrapping_add_signed(ulps));
            }
            let value = |map: &dyn Fn(DVec3) -> DVec3| {
                let [a, b, c, x] = [a, b, c, x].map(|point| Point::exact(map(point)));
                let light = LightSource::point(map(off).to_array()).expect("a lamp");
                [Target::Point(&x), Target::Light(&light)].map(|target| side_value(&a, &b, &c, target))
            };
            let whole = value(&|v| v);
            prop_assert_eq!(value(&|v| v.yzx()), whole);
            prop_assert_eq!(value(&|v| v.zxy()), whole);
            prop_assert_eq!(value(&|v| v.zyx()), whole.map(|side| -side));
            prop_assert_eq!(value(&|v| DVec3::new(v.x, -v.y, v.z)), whole.map(|side| -side));
        }

        #[test]
        fn points_on_two_lines_are_in_one_plane(
            p in proptest::array::uniform12(0usize..3), is_sun in any::<bool>(),
        ) {
            const NUMBERS: [f64; 3] = [0.0, 0.1, 0.7];
            let [a, b, c, x] = [0, 1, 2, 3].map(|i| DVec3::from_array([0, 1, 2].map(|k| NUMBERS[p[3 * i + k]])));
            let corners = [a, b, c].map(Point::exact);
            let [a, b, c] = &corners;
            let light = if is_sun { LightSource::sun(x.to_array()) } else { LightSource::point(x.to_array()) };
            let Ok(light) = light else { return Ok(()) };
            if are_on_two_lines(a, b, c, Target::Light(&light)) {
                let light = ExactPoint::<Dyadic>::from_light(&light);
                prop_assert_eq!(exact_side(&a.to_exact(), &b.to_exact(), &c.to_exact(), &light).sign(), Sign::Zero);
            }
        }

        #[test]
        fn signs_agree_with_the_published_predicate(
            p in proptest::array::uniform12(-1.0..1.0f64), ulps in -4i64..=4, s in 0.0..1.0f64, t in 0.0..1.0f64,
        ) {
            let at = |i: usize| DVec3::new(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
            // A fourth point within a few ulps of the plane of the others.
            let mut d = at(0) + (at(1) - at(0)) * s + (at(2) - at(0)) * t;
            d.z = f64::from_bits(d.z.to_bits().wrapping_add_signed(ulps));
            let coord = |v: DVec3| robust::Coord3D { x: v.x, y: v.y, z: v.z };
            let published = robust::orient3d(coord(at(0)), coord(at(1)), coord(at(2)), coord(d));
            let ours = side(&Point::exact(at(0)), &Point::exact(at(1)), &Point::exact(at(2)), &Point::exact(d));
            prop_assert_eq!(ours, Sign::of(published).flipped());
        }
    }
}
