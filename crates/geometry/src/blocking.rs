//! Does a face block the open segment from a point to a light? The definition of shadow, decided exactly.
//!
//! Faces are closed sets: a segment through an edge or a vertex is blocked. The segment is open: what only touches its
//! ends does not block. A filter answers nearly all questions; the rest goes to exact arithmetic over a [`Ring`] that
//! holds the point's coordinates.

use std::cell::LazyCell;

use glam::DVec3;

use crate::{
    approx::Approx,
    light::LightSource,
    point::{ExactPoint, Point},
    predicates::{Target, count_fallback, side_filter},
    ring::{Ring, Sign, determinant, dot},
    sphere::SphereForm,
};

/// How the exact coordinates of a point are made when they are asked for.
type Recipe<'a, R> = Box<dyn FnOnce() -> ExactPoint<R> + 'a>;

/// A point with exact coordinates over `R`, made when first needed, and floats that bound them.
pub struct Probe<'a, R = crate::Dyadic> {
    /// The bounds; its `exact` is not used.
    pub bounds: Point<'static>,
    exact: LazyCell<ExactPoint<R>, Recipe<'a, R>>,
}

impl<'a, R: Ring> Probe<'a, R> {
    /// A point inside `bounds` whose exact coordinates `exact` gives; called once at most.
    pub fn new(bounds: Point<'static>, exact: impl FnOnce() -> ExactPoint<R> + 'a) -> Self {
        Self { bounds, exact: LazyCell::new(Box::new(exact)) }
    }

    /// The point with these float coordinates.
    pub fn at(position: DVec3) -> Self {
        Self::new(Point::exact(position), move || ExactPoint::from_position(position))
    }

    /// The exact point.
    pub fn exact(&self) -> &ExactPoint<R> {
        &self.exact
    }
}

impl<R: std::fmt::Debug> std::fmt::Debug for Probe<'_, R> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Probe").field("bounds", &self.bounds).finish_non_exhaustive()
    }
}

/// Whether the closed planar convex polygon with these corners meets the open segment from `x` to the light.
pub fn polygon_blocks<R: Ring>(corners: &[Point], x: &Probe<R>, light: &LightSource) -> bool {
    filtered_polygon_blocks(corners, &x.bounds, light).unwrap_or_else(|| {
        count_fallback();
        let corners: Vec<ExactPoint<R>> = corners.iter().map(Point::to_exact).collect();
        exact_polygon_blocks(&corners, x.exact(), &ExactPoint::from_light(light))
    })
}

/// The answer where floats can tell.
fn filtered_polygon_blocks(corners: &[Point], x: &Point, light: &LightSource) -> Option<bool> {
    let [a, b, c] = [corners[0], corners[1], corners[corners.len() - 1]];
    let light_side = side_filter(&a, &b, &c, Target::Light(light)).sign()?;
    let point_side = side_filter(&a, &b, &c, Target::Point(x)).sign()?;
    if light_side == Sign::Zero {
        return if point_side == Sign::Zero { None } else { Some(false) };
    }
    if point_side.times(light_side) != Sign::Negative {
        return Some(false);
    }
    let mut certain = true;
    for (i, from) in corners.iter().enumerate() {
        let to = &corners[(i + 1) % corners.len()];
        match side_filter(from, to, x, Target::Light(light)).sign() {
            Some(sign) if sign.times(light_side) == Sign::Negative => return Some(false),
            Some(_) => {}
            None => certain = false,
        }
    }
    certain.then_some(true)
}

/// [`polygon_blocks`] in exact arithmetic alone. Corners must have weight 1; the polygon may be without area.
pub fn exact_polygon_blocks<R: Ring>(corners: &[ExactPoint<R>], x: &ExactPoint<R>, light: &ExactPoint<R>) -> bool {
    // Everything relative to x, scaled by its positive weight.
    let away: Vec<[R; 3]> = corners.iter().map(|corner| difference(corner, x)).collect();
    let to_light = difference(light, x);
    let [a, b, c] = [&away[0], &away[1], &away[away.len() - 1]];
    // With normal n = (a − c) × (b − c): x lies on side −n·c, the light on side n·(to_light·1 − w·c).
    let normal = cross(&minus(a, c), &minus(b, c));
    let x_side = (-dot(&normal, c)).sign();
    let light_side = (dot(&normal, &to_light) - light.w.clone() * dot(&normal, c)).sign();
    match (light_side, x_side) {
        (Sign::Zero, Sign::Zero) => in_plane_blocks(&away, &normal, &to_light, light.w.sign() == Sign::Zero),
        (Sign::Zero, _) | (_, Sign::Zero) => false,
        (light_side, x_side) if light_side == x_side => false,
        _ => (0..away.len()).all(|i| {
            let rows = [away[i].clone(), away[(i + 1) % away.len()].clone(), to_light.clone()];
            determinant(&rows).sign().times(light_side) != Sign::Negative
        }),
    }
}

/// The case where the light and x lie in the polygon's plane, or the polygon has no area. `away` are the corners seen
/// from x.
fn in_plane_blocks<R: Ring>(away: &[[R; 3]], normal: &[R; 3], to_light: &[R; 3], is_sun: bool) -> bool {
    let edges = || (0..away.len()).map(|i| (&away[i], &away[(i + 1) % away.len()]));
    if edges().any(|(from, to)| segments_meet(from, to, to_light, is_sun)) {
        return true;
    }
    // No edge is met: the segment is inside as a whole or not at all. It starts inside when x is inside, or on an edge
    // with the light on its inner side.
    let has_area = dot(normal, normal).sign() == Sign::Positive;
    let is_empty = dot(to_light, to_light).sign() == Sign::Zero;
    has_area
        && !is_empty
        && edges().all(|(from, to)| match dot(&cross(from, to), normal).sign() {
            Sign::Zero => dot(&cross(&minus(to, from), to_light), normal).sign() == Sign::Positive,
            side => side == Sign::Positive,
        })
}

/// Whether the open segment from the origin to `direction` (an open ray for a sun) meets the closed segment [a, b].
fn segments_meet<R: Ring>(a: &[R; 3], b: &[R; 3], direction: &[R; 3], is_sun: bool) -> bool {
    let (across_a, across_b) = (cross(direction, a), cross(direction, b));
    if dot(&across_a, b).sign() != Sign::Zero {
        return false; // skew lines
    }
    let length = dot(direction, direction);
    let inside = |along: &R, scale: &R| {
        along.sign() == Sign::Positive && (is_sun || (along.clone() - scale.clone()).sign() == Sign::Negative)
    };
    let (along_a, along_b) = (dot(a, direction), dot(b, direction));
    let turn = minus(&across_a, &across_b);
    let Some(k) = (0..3).find(|&k| turn[k].sign() != Sign::Zero) else {
        let collinear = across_a.iter().all(|coordinate| coordinate.sign() == Sign::Zero);
        if !collinear {
            return false;
        }
        let (least, most) = match (along_a.clone() - along_b.clone()).sign() {
            Sign::Negative => (along_a, along_b),
            _ => (along_b, along_a),
        };
        return most.sign() == Sign::Positive && (is_sun || (least - length).sign() == Sign::Negative);
    };
    let (ca, cb) = (&across_a[k], &across_b[k]);
    if ca.sign().times(cb.sign()) == Sign::Positive {
        return false;
    }
    // The crossing divides [a, b] at ca : −cb; its place along the segment, times `turn`, made positive.
    let flip = |value: R| if turn[k].sign() == Sign::Negative { -value } else { value };
    let along = flip(along_b * ca.clone() - along_a * cb.clone());
    inside(&along, &flip(length * turn[k].clone()))
}

/// p·w_x − x·w_p: the vector from x to p, times both weights (for a sun, times w_x).
fn difference<R: Ring>(p: &ExactPoint<R>, x: &ExactPoint<R>) -> [R; 3] {
    std::array::from_fn(|i| p.xyz[i].clone() * x.w.clone() - x.xyz[i].clone() * p.w.clone())
}

fn minus<R: Ring>(a: &[R; 3], b: &[R; 3]) -> [R; 3] {
    std::array::from_fn(|i| a[i].clone() - b[i].clone())
}

fn cross<R: Ring>(a: &[R; 3], b: &[R; 3]) -> [R; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j].clone() * b[k].clone() - a[k].clone() * b[j].clone()
    })
}

/// Whether the surface of a placed sphere meets the open segment from `x` to the light. Where x lies on the surface
/// itself, that root is divided out and only the other one counts.
pub fn sphere_blocks<R: Ring>(
    form: &SphereForm<Approx>,
    exact_form: impl FnOnce() -> SphereForm<R>,
    x: &Probe<R>,
    light: &LightSource,
) -> bool {
    let bounds = Coefficients::new(
        form,
        (&x.bounds.coordinates(), &Approx::exact(1.0)),
        (&light.xyz().to_array().map(Approx::exact), &Approx::exact(light.w())),
    );
    bounds.has_root_on_the_way(light.is_sun(), |value| value.sign()).unwrap_or_else(|| {
        count_fallback();
        let light_point = ExactPoint::<R>::from_light(light);
        let exact =
            Coefficients::new(&exact_form(), (&x.exact().xyz, &x.exact().w), (&light_point.xyz, &light_point.w));
        exact.has_root_on_the_way(light.is_sun(), |value| Some(value.sign())).unwrap_or(false)
    })
}

/// On which side of a placed sphere's tangent plane at `x`, a point of its surface, the light lies: positive outside.
/// Where it is positive the sphere is wholly behind the plane and cannot block the point.
pub fn sphere_light_side<R: Ring>(
    form: &SphereForm<Approx>,
    exact_form: impl FnOnce() -> SphereForm<R>,
    x: &Probe<R>,
    light: &LightSource,
) -> Sign {
    let (one, weight) = (Approx::exact(1.0), Approx::exact(light.w()));
    let local_x = form.pull_back(&x.bounds.coordinates(), &one);
    let local_light = form.pull_back(&light.xyz().to_array().map(Approx::exact), &weight);
    form.value((&local_x, &one), (&local_light, &weight)).sign().unwrap_or_else(|| {
        count_fallback();
        let (form, x, light) = (exact_form(), x.exact(), ExactPoint::<R>::from_light(light));
        let (local_x, local_light) = (form.pull_back(&x.xyz, &x.w), form.pull_back(&light.xyz, &light.w));
        form.value((&local_x, &x.w), (&local_light, &light.w)).sign()
    })
}

/// q along the segment x + s·(light − x): quadratic·s² + 2·linear·s + constant, with quadratic > 0.
struct Coefficients<T> {
    quadratic: T,
    linear: T,
    constant: T,
}

impl<T> Coefficients<T>
where
    T: Clone + std::ops::Add<Output = T> + std::ops::Sub<Output = T> + std::ops::Mul<Output = T>,
{
    fn new(form: &SphereForm<T>, x: (&[T; 3], &T), light: (&[T; 3], &T)) -> Self {
        let way: [T; 3] = std::array::from_fn(|i| light.0[i].clone() * x.1.clone() - x.0[i].clone() * light.1.clone());
        let nothing = x.1.clone() - x.1.clone();
        let (local_x, local_way) = (form.pull_back(x.0, x.1), form.pull_back(&way, &nothing));
        let (x, way) = ((&local_x, x.1), (&local_way, &nothing));
        Self { quadratic: form.value(way, way), linear: form.value(x, way), constant: form.value(x, x) }
    }

    /// Whether a root lies strictly between 0 and 1 (beyond 0 for a sun), s = 0 itself never counting. `None` where
    /// `sign` cannot tell.
    fn has_root_on_the_way(&self, is_sun: bool, sign: impl Fn(T) -> Option<Sign>) -> Option<bool> {
        let (a, b, c) = (self.quadratic.clone(), self.linear.clone(), self.constant.clone());
        let twice_b = b.clone() + b.clone();
        let start = sign(c.clone())?;
        if is_sun {
            return match start {
                Sign::Negative => Some(true),
                Sign::Zero => Some(sign(b)? == Sign::Negative),
                Sign::Positive if sign(b.clone())? != Sign::Negative => Some(false),
                Sign::Positive => Some(sign(b.clone() * b - a * c)? != Sign::Negative),
            };
        }
        if start == Sign::Zero {
            // The other root is −2b/a.
            return Some(sign(b)? == Sign::Negative && sign(twice_b + a)? == Sign::Positive);
        }
        let end = sign(a.clone() + twice_b + c.clone())?;
        Some(match (start, end) {
            (Sign::Negative, end) => end == Sign::Positive,
            (_, Sign::Negative) => true,
            // One root is the light itself; the other is c/a.
            (_, Sign::Zero) => sign(c - a)? == Sign::Negative,
            (_, Sign::Positive) => {
                // Both roots or none: the least value must lie on the way and not above zero.
                sign(b.clone())? == Sign::Negative
                    && sign(a.clone() + b.clone())? == Sign::Positive
                    && sign(b.clone() * b - a * c)? != Sign::Negative
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dyadic, Placement, Sphere};

    fn probe(x: [f64; 3]) -> Probe<'static> {
        Probe::at(DVec3::from_array(x))
    }

    fn triangle_blocks(x: [f64; 3], light: &LightSource) -> bool {
        let corners = [[0.0, 1.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 2.0]].map(|c| Point::exact(DVec3::from_array(c)));
        polygon_blocks(&corners, &probe(x), light)
    }

    #[test]
    fn a_triangle_is_a_closed_set() {
        let sun = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun overhead");
        assert!(triangle_blocks([0.5, 0.0, 0.5], &sun), "inside");
        assert!(triangle_blocks([1.0, 0.0, 1.0], &sun), "on an edge");
        assert!(triangle_blocks([0.0, 0.0, 2.0], &sun), "on a vertex");
        assert!(!triangle_blocks([1.0, 0.0, 1.0_f64.next_up()], &sun), "one ulp outside");
        assert!(!triangle_blocks([0.5, 1.0, 0.5], &sun), "contact");
        assert!(!triangle_blocks([0.5, 2.0, 0.5], &sun), "above");
    }

    #[test]
    fn a_lamp_counts_only_what_lies_before_it() {
        let lamp = |y| LightSource::point([0.5, y, 0.5]).expect("a lamp");
        assert!(triangle_blocks([0.5, 0.0, 0.5], &lamp(2.0)));
        assert!(!triangle_blocks([0.5, 0.0, 0.5], &lamp(1.0)), "the lamp lies on the triangle");
        assert!(!triangle_blocks([0.5, 0.0, 0.5], &lamp(0.5)), "the triangle lies behind the lamp");
    }

    #[test]
    fn an_edge_on_triangle_blocks_in_its_plane() {
        let level = LightSource::sun([1.0, 0.0, 0.0]).expect("a level sun");
        assert!(triangle_blocks([3.0, 1.0, 0.5], &level), "the triangle lies between");
        assert!(!triangle_blocks([3.0, 1.0_f64.next_up(), 0.5], &level));
        assert!(!triangle_blocks([-1.0, 1.0, 0.5], &level), "behind");
        assert!(triangle_blocks([3.0, 1.0, 2.0], &level), "through a vertex");
        assert!(triangle_blocks([0.5, 1.0, 0.5], &level), "from inside, in the plane");
        assert!(triangle_blocks([3.0, 1.0, 0.0], &level), "along an edge");
        assert!(!triangle_blocks([0.0, 1.0, 1.0], &level), "from an edge, away");
        assert!(triangle_blocks([1.0, 1.0, 1.0], &level), "from an edge, across");
    }

    #[test]
    fn a_sphere_blocks_where_the_segment_meets_its_surface() {
        let sphere = Sphere { radius: 1.0 };
        let form = sphere.form(&Placement::IDENTITY);
        let blocks = |x: [f64; 3], light: &LightSource| {
            sphere_blocks::<Dyadic>(&form, || sphere.exact_form(&Placement::IDENTITY), &probe(x), light)
        };
        let sun = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun overhead");
        assert!(blocks([0.0, -2.0, 0.0], &sun));
        assert!(blocks([1.0, -2.0, 0.0], &sun), "a tangent touches");
        assert!(!blocks([1.0_f64.next_up(), -2.0, 0.0], &sun));
        assert!(blocks([0.0, 0.0, 0.0], &sun), "from inside");
        assert!(!blocks([0.0, 1.0, 0.0], &sun), "contact on the lit side");
        assert!(blocks([0.0, -1.0, 0.0], &sun), "the other root counts");
        let lamp = |y| LightSource::point([0.0, y, 0.0]).expect("a lamp");
        assert!(!blocks([0.0, 0.5, 0.0], &lamp(-0.5)), "both inside");
        assert!(blocks([0.0, -2.0, 0.0], &lamp(1.0)), "the lamp on the far surface");
        assert!(!blocks([0.0, 2.0, 0.0], &lamp(1.0)), "the lamp on the near surface");
        assert!(!blocks([0.0, 3.0, 0.0], &lamp(2.0)), "the sphere lies behind the lamp");
    }
}
