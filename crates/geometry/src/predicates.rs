//! Signs that decide: each a floating-point filter with a running error bound, then exact arithmetic.

use glam::DVec3;

use crate::{
    approx::{Approx, UNIT_ROUNDOFF},
    decisions::{Decisions, decide},
    dyadic::Dyadic,
    light::LightSource,
    point::{ExactPoint, Point},
    ring::{Ring, Sign, determinant},
};

/// How many decisions of this process went on to exact arithmetic so far; [`Decisions`] has all levels.
pub fn exact_fallbacks() -> u64 {
    Decisions::of_process().exact
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
    decide(filtered.sign().map(|_| filtered), || {
        let exact = match x {
            Target::Point(p) => p.to_exact(),
            Target::Light(l) => ExactPoint::from_light(l),
        };
        exact_side::<Dyadic>(&a.to_exact(), &b.to_exact(), &c.to_exact(), &exact).to_approx()
    })
}

/// The filter of [`side_value`] alone: the bound may straddle zero. Exact points are not looked at, only slacks.
pub fn side_filter(a: &Point, b: &Point, c: &Point, x: Target) -> Approx {
    let (position, slack, w) = match x {
        Target::Point(p) => (p.position, p.slack, 1.0),
        Target::Light(l) => (l.xyz(), DVec3::ZERO, l.w()),
    };
    if a.slack + b.slack + c.slack + slack == DVec3::ZERO {
        return exact_corners_filter(a.position - c.position, b.position - c.position, position - c.position * w);
    }
    determinant(&[minus(a, c), minus(b, c), row_of(x, c)])
}

/// Shewchuk's bound for the determinant of three rows, each a difference of floats (or a float): the error is at most
/// (7 + 56u)·u times the permanent of the magnitudes ("Adaptive Precision Floating-Point Arithmetic", 1997, §4.3).
const ROUNDED_ROWS_BOUND: f64 = (7.0 + 56.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

/// The filter where all coordinates are exact floats.
fn exact_corners_filter(a: DVec3, b: DVec3, x: DVec3) -> Approx {
    let value = a.x * (b.y * x.z - b.z * x.y) + a.y * (b.z * x.x - b.x * x.z) + a.z * (b.x * x.y - b.y * x.x);
    let (a, b, x) = (a.abs(), b.abs(), x.abs());
    let permanent = a.x * (b.y * x.z + b.z * x.y) + a.y * (b.z * x.x + b.x * x.z) + a.z * (b.x * x.y + b.y * x.x);
    Approx { value, error: permanent * ROUNDED_ROWS_BOUND }
}

/// The exact determinant behind [`side_value`], times the positive weights w_a·w_b·w_c (for weights 1 it is equal).
pub fn exact_side<R: Ring>(a: &ExactPoint<R>, b: &ExactPoint<R>, c: &ExactPoint<R>, x: &ExactPoint<R>) -> R {
    // Rows w_c·a − w_a·c; the common factor w_c² is not divided out: it is positive.
    let row = |p: &ExactPoint<R>| -> [R; 3] {
        std::array::from_fn(|i| p.xyz[i].clone() * c.w.clone() - c.xyz[i].clone() * p.w.clone())
    };
    determinant(&[row(a), row(b), row(x)])
}

/// Whether two points are the same by their floats alone: neighbours on a surface share corners all the time.
fn coincide(a: &Point, b: &Point) -> bool {
    a.position == b.position && a.slack == DVec3::ZERO && b.slack == DVec3::ZERO
}

fn minus(a: &Point, c: &Point) -> [Approx; 3] {
    let (a, c) = (a.coordinates(), c.coordinates());
    std::array::from_fn(|i| a[i] - c[i])
}

fn row_of(x: Target, c: &Point) -> [Approx; 3] {
    match x {
        Target::Point(p) => minus(p, c),
        Target::Light(l) if l.is_sun() => exact_vector(l.xyz()),
        Target::Light(l) => minus(&Point::exact(l.xyz()), c),
    }
}

fn exact_vector(v: DVec3) -> [Approx; 3] {
    v.to_array().map(Approx::exact)
}

#[cfg(test)]
mod tests {
    use super::*;
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

    proptest! {
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
