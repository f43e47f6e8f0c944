//! Does a face block the open segment from a point to a light? The definition of shadow, decided exactly.
//!
//! Faces are closed sets: a segment through an edge or a vertex is blocked. The segment is open: what only touches its
//! ends does not block. A filter answers nearly all questions; the rest goes to exact arithmetic over a [`Ring`] that
//! holds the point's coordinates.

use std::cell::LazyCell;

use glam::DVec3;

use crate::{
    analytic::{Chart, HomogeneousPoint},
    approx::Approx,
    decide::Decide,
    decisions::decide_by_pairs,
    light::LightSource,
    pair::Pair,
    placement::Placement,
    point::{ExactPoint, Point},
    predicates::{Target, exact_side, side_filter, side_of_pairs, side_value},
    ring::{Ring, Sign, determinant, dot},
    surd::Surd,
};

/// How the exact coordinates of a point are made when they are asked for.
type Recipe<'a, R> = Box<dyn FnOnce() -> ExactPoint<R> + 'a>;

/// A point with exact coordinates over `R`, made when first needed, and floats that bound them.
pub struct Probe<'a, R = crate::Dyadic> {
    /// The bounds; its `exact` is not used.
    pub bounds: Point<'static>,
    exact: LazyCell<ExactPoint<R>, Recipe<'a, R>>,
    /// Where it is on a flat face, if it is known as a point of one.
    face: Option<FacePlace<'a>>,
    /// The same of a patch.
    patch: Option<PatchPlace<'a>>,
    /// Three corners of a face in whose plane it lies, if no more is known of it.
    plane: Option<[Point<'a>; 3]>,
}

/// The point (u, v) of a patch of a placed body.
#[derive(Clone, Copy)]
struct PatchPlace<'a> {
    chart: &'a Chart,
    placement: &'a Placement,
    u: f64,
    v: f64,
}

/// A place on a planar face: A + u·(B − A) + v·(D − A) for its first, second and last corner.
#[derive(Clone, Copy)]
struct FacePlace<'a> {
    corners: [Point<'a>; 3],
    u: f64,
    v: f64,
}

impl<'a, R: Ring> Probe<'a, R> {
    /// A point inside `bounds` whose exact coordinates `exact` gives; called once at most.
    pub fn new(bounds: Point<'static>, exact: impl FnOnce() -> ExactPoint<R> + 'a) -> Self {
        Self { bounds, exact: LazyCell::new(Box::new(exact)), face: None, patch: None, plane: None }
    }

    /// As [`Probe::new`], a point in the plane of a face with these corners.
    pub fn in_plane(bounds: Point<'static>, plane: [Point<'a>; 3], exact: impl FnOnce() -> ExactPoint<R> + 'a) -> Self {
        Self { plane: Some(plane), ..Self::new(bounds, exact) }
    }

    /// The point A + u·(B − A) + v·(D − A) of a planar face with the corners A, B and D, its first, second and last one.
    pub fn on_face(corners: [Point<'a>; 3], u: f64, v: f64) -> Self {
        let [a, b, d] = corners;
        let (along_u, along_v) = (b.minus(&a), d.minus(&a));
        let offset: [Approx; 3] =
            std::array::from_fn(|k| a.known_rest(k) + (along_u[k] * Approx::exact(u) + along_v[k] * Approx::exact(v)));
        let [offset, slack] = [offset.map(|c| c.value), offset.map(|c| c.error)].map(DVec3::from_array);
        let bounds = Point::beside(a.position, offset, slack);
        let exact = move || {
            let [a, b, d] = corners.map(|corner| corner.to_exact::<R>().xyz);
            let along = |from: &R, to: &R, share: f64| R::from_f64(share) * (to.clone() - from.clone());
            let xyz = std::array::from_fn(|k| a[k].clone() + along(&a[k], &b[k], u) + along(&a[k], &d[k], v));
            ExactPoint { xyz, w: R::from_f64(1.0) }
        };
        Self { face: Some(FacePlace { corners, u, v }), ..Self::new(bounds, exact) }
    }

    /// The point with these float coordinates.
    pub fn at(position: DVec3) -> Self {
        Self::new(Point::exact(position), move || ExactPoint::from_position(position))
    }

    /// The coordinates in pairs of floats: of a place on a face, or of floats.
    fn pairs(&self) -> Option<[Pair; 3]> {
        let Some(FacePlace { corners, u, v }) = &self.face else {
            return (self.bounds.slack == DVec3::ZERO).then(|| self.bounds.position.to_array().map(Pair::exact));
        };
        let [a, b, d] = corners.each_ref().map(Pair::of_point);
        let [u, v] = [*u, *v].map(Pair::exact);
        Some(std::array::from_fn(|k| a[k] + (b[k] - a[k]) * u + (d[k] - a[k]) * v))
    }

    /// Points in pairs of floats whose weighted mean this is: the corners of its face, or itself.
    fn weighted_pairs(&self) -> Option<Vec<([Pair; 3], Pair)>> {
        let one = Pair::exact(1.0);
        match &self.face {
            None => self.pairs().map(|point| vec![(point, one)]),
            Some(FacePlace { corners, u, v }) => {
                let [u, v] = [*u, *v].map(Pair::exact);
                Some(corners.iter().map(Pair::of_point).zip([one - u - v, u, v]).collect())
            }
        }
    }

    /// The point in pairs of floats and a root of such: of a point of a patch, of a place on a face, or of floats.
    pub(crate) fn in_pairs(&self) -> Option<ExactPoint<Surd<Pair>>> {
        match self.patch {
            Some(PatchPlace { chart, placement, u, v }) => chart.point_in_pairs(placement, u, v),
            None => self.pairs().map(ExactPoint::of_pairs),
        }
    }

    /// The same in the local coordinates of a body, homogeneous; `None` unless the point is one of a patch of that body.
    pub(crate) fn local_in_pairs(&self, body: &Placement) -> Option<HomogeneousPoint<Pair>> {
        let PatchPlace { chart, placement, u, v } = self.patch?;
        if std::ptr::eq(placement, body) { chart.local_point_in_pairs(u, v) } else { None }
    }

    /// The exact point.
    pub fn exact(&self) -> &ExactPoint<R> {
        &self.exact
    }
}

impl<'a> Probe<'a, Surd> {
    /// The point (u, v) of a patch of a body under this placement.
    ///
    /// # Panics
    /// When its exact coordinates are asked for and the patch has no such point ([`Chart::has_point`]).
    pub fn on_patch(chart: &'a Chart, placement: &'a Placement, u: f64, v: f64) -> Self {
        let exact = move || chart.exact_point(placement, u, v).expect("the point is surface");
        let bounds = chart.bounded_point(placement, u, v);
        Self { patch: Some(PatchPlace { chart, placement, u, v }), ..Self::new(bounds, exact) }
    }
}

impl<R: std::fmt::Debug> std::fmt::Debug for Probe<'_, R> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Probe").field("bounds", &self.bounds).finish_non_exhaustive()
    }
}

/// Whether the closed planar convex polygon with these corners meets the open segment from `x` to the light.
pub fn polygon_blocks<R: Ring>(corners: &[Point], x: &Probe<R>, light: &LightSource) -> bool {
    let floats = FloatSigns { corners, x: &x.bounds, light };
    let filtered = floats
        .tell()
        .or_else(|| x.face.and_then(|place| polygon_blocks_place(&floats, &place)))
        .or_else(|| x.plane.filter(|plane| is_contact_in_plane(corners, plane, light)).map(|_| false));
    let by_pairs = || match x.patch {
        Some(_) => polygon_blocks_roots(corners, &x.in_pairs()?, light),
        None => polygon_blocks_pairs(&floats, x),
    };
    decide_by_pairs(filtered, by_pairs, || {
        let corners: Vec<ExactPoint<R>> = corners.iter().map(Point::to_exact).collect();
        exact_polygon_blocks(&corners, x.exact(), &ExactPoint::from_light(light))
    })
}

/// The answer of [`polygon_blocks`] where floats can tell. Looks at no exact coordinates, so they need not be at hand.
pub fn polygon_blocks_filter(corners: &[Point], x: &Point, light: &LightSource) -> Option<bool> {
    FloatSigns { corners, x, light }.tell()
}

/// The signs that tell whether a polygon blocks the way from a point to a light, as far as floats know them. The levels behind them
/// ask for these first: a float's sign costs a small part of one of theirs, so none is kept.
struct FloatSigns<'a> {
    corners: &'a [Point<'a>],
    x: &'a Point<'a>,
    light: &'a LightSource,
}

impl FloatSigns<'_> {
    fn tell(&self) -> Option<bool> {
        blocks_by_signs(self.corners.len(), self.of_light()?, self.of_point(), |i| self.of_shadow_plane(i))
    }

    /// Three corners of the polygon's plane.
    fn plane(&self) -> [&Point<'_>; 3] {
        [&self.corners[0], &self.corners[1], &self.corners[self.corners.len() - 1]]
    }

    fn edge(&self, i: usize) -> [&Point<'_>; 2] {
        [&self.corners[i], &self.corners[(i + 1) % self.corners.len()]]
    }

    /// The side of the polygon's plane on which the light lies.
    fn of_light(&self) -> Option<Sign> {
        let [a, b, c] = self.plane();
        side_filter(a, b, c, Target::Light(self.light)).sign()
    }

    /// The same of the point.
    fn of_point(&self) -> Option<Sign> {
        let [a, b, c] = self.plane();
        side_filter(a, b, c, Target::Point(self.x)).sign()
    }

    /// The side of the plane through edge i and the light on which the point lies.
    fn of_shadow_plane(&self, i: usize) -> Option<Sign> {
        let [from, to] = self.edge(i);
        side_filter(from, to, self.x, Target::Light(self.light)).sign()
    }
}

/// The same for a place on a face, by the signs at the corners of the face: they are exact, and so is a zero at all of them.
/// Tells that neighbours in one plane are in contact, and that edges through a corner or along a side are met there.
fn polygon_blocks_place(floats: &FloatSigns, place: &FacePlace) -> Option<bool> {
    let [a, b, c] = floats.plane();
    let light = Target::Light(floats.light);
    let light_side = Sign::of(side_value(a, b, c, light).value);
    let of_point = || place.mean(|corner| side_value(a, b, c, Target::Point(corner))).sign();
    blocks_by_signs(floats.corners.len(), light_side, floats.of_point().or_else(of_point), |i| {
        let [from, to] = floats.edge(i);
        floats.of_shadow_plane(i).or_else(|| place.mean(|corner| side_value(from, to, corner, light)).sign())
    })
}

/// Whether three points are in the polygon's plane, and the light is not: all that lies with them is in contact at most.
fn is_contact_in_plane(corners: &[Point], plane: &[Point; 3], light: &LightSource) -> bool {
    let [a, b, c] = [&corners[0], &corners[1], &corners[corners.len() - 1]];
    let sign = |target| Sign::of(side_value(a, b, c, target).value);
    sign(Target::Light(light)) != Sign::Zero && plane.iter().all(|point| sign(Target::Point(point)) == Sign::Zero)
}

/// The same in pairs of floats, for a point that pairs can hold. On a face the signs follow from those at its corners, whose
/// coordinates have fewer digits than the point's.
fn polygon_blocks_pairs<R: Ring>(floats: &FloatSigns, x: &Probe<R>) -> Option<bool> {
    let points = x.weighted_pairs()?;
    let mean = |function: &dyn Fn(&[Pair; 3]) -> Pair| {
        let sum = points.iter().fold(Pair::default(), |sum, (point, weight)| sum + function(point) * *weight);
        sum.sign()
    };
    let corners: Vec<[Pair; 3]> = floats.corners.iter().map(Pair::of_point).collect();
    let (towards, w) = (floats.light.xyz().to_array().map(Pair::exact), floats.light.w());
    let plane = [corners[0], corners[1], corners[corners.len() - 1]];
    let light_side = floats.of_light().or_else(|| side_of_pairs(&plane, &towards, w).sign())?;
    let point_side = floats.of_point().or_else(|| mean(&|x| side_of_pairs(&plane, x, 1.0)));
    blocks_by_signs(corners.len(), light_side, point_side, |i| {
        let edge = [corners[i], corners[(i + 1) % corners.len()]];
        floats.of_shadow_plane(i).or_else(|| mean(&|x| side_of_pairs(&[edge[0], edge[1], *x], &towards, w)))
    })
}

/// The same for a point in pairs of floats and a root of such.
fn polygon_blocks_roots(corners: &[Point], x: &ExactPoint<Surd<Pair>>, light: &LightSource) -> Option<bool> {
    let [a, b, c] = [&corners[0], &corners[1], &corners[corners.len() - 1]];
    let light_side = Sign::of(side_value(a, b, c, Target::Light(light)).value);
    let corners: Vec<_> = corners.iter().map(|corner| ExactPoint::of_pairs(Pair::of_point(corner))).collect();
    let (light, last) = (ExactPoint::from_light(light), &corners[corners.len() - 1]);
    let plane = exact_side(&corners[0], &corners[1], last, x);
    blocks_by_signs(corners.len(), light_side, plane.decide(), |i| {
        exact_side(&corners[i], &corners[(i + 1) % corners.len()], x, &light).decide()
    })
}

impl FacePlace<'_> {
    /// The value here of a function that is affine along the face.
    fn mean(&self, function: impl Fn(&Point) -> Approx) -> Approx {
        // Without rounding where it is a float: it is exactly zero on the side opposite the first corner.
        let first = Pair::exact(1.0) - Pair::exact(self.u) - Pair::exact(self.v);
        let weights = [first.to_approx(), Approx::exact(self.u), Approx::exact(self.v)];
        let terms = self.corners.iter().zip(weights).map(|(corner, weight)| function(corner) * weight);
        terms.fold(Approx::exact(0.0), |sum, term| sum + term)
    }
}

/// What follows from the sides of the polygon's plane on which the light and the point lie, and of the planes through the light
/// and each of its edges (NUMERICS.md, "Blocking as signs").
fn blocks_by_signs(
    edges: usize,
    light_side: Sign,
    point_side: Option<Sign>,
    shadow_plane: impl Fn(usize) -> Option<Sign>,
) -> Option<bool> {
    if light_side == Sign::Zero {
        return if point_side? == Sign::Zero { None } else { Some(false) };
    }
    if point_side.is_some_and(|side| side.times(light_side) != Sign::Negative) {
        return Some(false);
    }
    // Outside of the shadow it does not matter on which side of the plane.
    let mut certain = point_side.is_some();
    for i in 0..edges {
        match shadow_plane(i) {
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
