//! What a triangle covers in light space: three edge functions, and its nearness as an affine function.
//!
//! Edge functions of homogeneous corners need neither clipping nor division (Olano & Greer, "Triangle scan conversion using
//! 2D homogeneous coordinates", Graphics Hardware 1997): with corners r_i = (x, y, w)_i the function
//! E_i(u, v) = (r_i × r_{i+1})·(u, v, 1) has the sign of det(r_0, r_1, r_2) for all i exactly where the ray through (u, v)
//! meets the triangle in front of the light. This holds for triangles that reach behind a lamp, too.
//!
//! Functions are divided by |∂E/∂u| + |∂E/∂v|, so a point that is off by d in u and v moves them by d at most. What cannot
//! be told (which way the triangle turns, an edge that points at the light) is left vague: such a function is zero, which
//! says neither inside nor outside; a triangle that is seen edge-on is known to lie in a strip. Guarantee: all coefficients hold within the errors that stand beside them.

use super::{
    Homogeneous,
    view::{greater, lesser},
};

/// Unit roundoff of f64.
const ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// An affine function of (u, v).
pub(crate) type Affine = [f64; 3];

/// A triangle as a window sees it; (u, v) counts from the window's middle, so that |u|, |v| ≤ 1 inside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint {
    /// Not negative over the triangle, |∂u| + |∂v| = 1; or zero where nothing is known.
    pub(crate) edges: [Affine; 3],
    /// No edge function is off by more inside the window.
    pub(crate) edge_error: f64,
    /// Nearness over the triangle's plane; of no meaning where that is not known.
    pub(crate) plane: Affine,
    /// The plane's value is off by no more inside the window; infinite where it is not known: then nobody is sure to be behind it.
    pub(crate) plane_error: f64,
    /// No point of the triangle is nearer; infinite when it reaches behind a lamp.
    pub(crate) nearest: f64,
    /// No point of the triangle that a light sees is less near.
    pub(crate) farthest: f64,
    /// Holds the triangle where it is in front of the light: least u, v, greatest u, v; infinite where that is unknown.
    pub(crate) bounds: [f64; 4],
    /// It certainly turns one way.
    pub(crate) is_turned: bool,
    /// That way is not that of its winding in (u, v).
    pub(crate) is_reversed: bool,
}

/// The errors of corners: of x, y and w, and of h.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CornerError {
    pub(crate) place: f64,
    pub(crate) height: f64,
}

impl Footprint {
    /// The footprint of a triangle of a sun's view (w = 1) or a lamp's (h constant). Without branches, so that many take the same steps together. Of one that
    /// does not turn for certain [`Self::edge_on`] says more.
    #[inline(always)]
    pub(crate) fn of<const IS_SUN: bool>(r: &[Homogeneous; 3], error: CornerError) -> Self {
        Self::between::<IS_SUN>(r, &Span::of::<IS_SUN>(r, error), &sides(r, error), error)
    }

    #[inline(always)]
    fn between<const IS_SUN: bool>(r: &[Homogeneous; 3], span: &Span, sides: &[Side; 3], error: CornerError) -> Self {
        let (edges, edge_error) = span.edges(sides);
        let (plane, plane_error) = span.plane::<IS_SUN>(&r[0], error);
        Self {
            edges,
            edge_error,
            plane,
            plane_error,
            nearest: span.nearest,
            farthest: span.farthest,
            bounds: span.bounds,
            is_turned: span.is_turned(),
            is_reversed: span.determinant < 0.0,
        }
    }

    /// The footprint of a triangle that is seen edge-on, or too nearly so to be turned: the strip round its longest edge that holds it.
    pub(crate) fn edge_on<const IS_SUN: bool>(r: &[Homogeneous; 3], error: CornerError) -> Self {
        let (span, sides) = (Span::of::<IS_SUN>(r, error), sides(r, error));
        let footprint = Self::between::<IS_SUN>(r, &span, &sides, error);
        let longest = sides.iter().fold(&sides[0], |best, side| if side.reach > best.reach { side } else { best });
        let (factor, off) = (1.0 / longest.reach, longest.error / longest.reach);
        if !(span.least_w > 0.0 && off < VAGUE) {
            return footprint;
        }
        let [a, b, c] = longest.value.map(|coefficient| coefficient * factor);
        // The opposite corner lies as far from the edge as the determinant says.
        let width = (span.determinant.abs() + span.determinant_error) / span.least_w;
        let wide = width * factor * (1.0 + 8.0 * ROUNDOFF);
        let edges = [[a, b, c + wide], [-a, -b, wide - c], [0.0; 3]];
        Self { edges, edge_error: off + 8.0 * ROUNDOFF * (1.0 + c.abs() + wide), ..footprint }
    }

    /// A body of which nothing is known but that it lies in the hull of `corners`.
    pub(crate) fn somewhere<const IS_SUN: bool>(corners: &[Homogeneous; 8], error: CornerError) -> Self {
        let mut hull = Self {
            edges: [[0.0; 3]; 3],
            edge_error: 0.0,
            plane: [0.0; 3],
            plane_error: f64::INFINITY,
            nearest: f64::NEG_INFINITY,
            farthest: f64::NEG_INFINITY,
            bounds: [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY],
            is_turned: false,
            is_reversed: false,
        };
        for triple in [[0, 1, 2], [3, 4, 5], [6, 7, 0]] {
            let r = triple.map(|k: usize| corners[k]);
            let ([_, nearest], [u0, v0, u1, v1]) = reach::<IS_SUN>(&r, least_w::<IS_SUN>(&r, error), error);
            hull.nearest = hull.nearest.max(nearest);
            let [a, b, c, d] = hull.bounds;
            hull.bounds = [a.min(u0), b.min(v0), c.max(u1), d.max(v1)];
        }
        hull
    }
}

/// Edges whose functions are off by more than this, in parts of the window, say nothing.
const VAGUE: f64 = 1.0 / (1u64 << 22) as f64;

#[inline(always)]
fn sides(r: &[Homogeneous; 3], error: CornerError) -> [Side; 3] {
    [side(&r[0], &r[1], error.place), side(&r[1], &r[2], error.place), side(&r[2], &r[0], error.place)]
}

/// The function of one edge before it is scaled.
struct Side {
    value: Affine,
    /// |∂u| + |∂v|.
    reach: f64,
    /// Bound on the error of the function's value inside the window.
    error: f64,
}

/// r × s as r × (s − r): then the products are as small as the edge is short.
///
/// Each coefficient is a difference of two products a·b with a off by d and b by 2d (its rounding is within d's slack):
/// off by 2d|a| + d|b| + 2d² + 2u|a·b|, and the difference rounds by 2u|a·b| more. With the sums r, e of the magnitudes of
/// the corner's and the edge's coordinates the three coefficients together are off by less than 2·(2d·r + d·e + 4u·r·e),
/// twice because each coordinate stands in two of them; inside the window |u|, |v| ≤ 1.
#[inline(always)]
fn side(r: &Homogeneous, s: &Homogeneous, d: f64) -> Side {
    let (ex, ey, ew) = (s.x - r.x, s.y - r.y, s.w - r.w);
    let value = [r.y * ew - r.w * ey, r.w * ex - r.x * ew, r.x * ey - r.y * ex];
    let sizes = [r.x.abs() + r.y.abs() + r.w.abs(), ex.abs() + ey.abs() + ew.abs()];
    let error = 2.0 * (2.0 * d * sizes[0] + d * sizes[1] + 4.0 * ROUNDOFF * sizes[0] * sizes[1] + 2.0 * d * d);
    Side { value, reach: value[0].abs() + value[1].abs(), error }
}

/// How a triangle lies: its normal, how far it is turned, what it spans.
struct Span {
    normal: [f64; 3],
    normal_error: f64,
    /// det(r_0, r_1, r_2).
    determinant: f64,
    determinant_error: f64,
    /// Below every corner's w.
    least_w: f64,
    nearest: f64,
    farthest: f64,
    bounds: [f64; 4],
}

impl Span {
    /// A sun's normal is taken in (x, y, h), where the third coordinate is the determinant; a lamp's in (x, y, w).
    #[inline(always)]
    fn of<const IS_SUN: bool>(r: &[Homogeneous; 3], error: CornerError) -> Self {
        let third = |corner: &Homogeneous| if IS_SUN { corner.h } else { corner.w };
        let edge = |k: usize| [r[k].x - r[0].x, r[k].y - r[0].y, third(&r[k]) - third(&r[0])];
        let ([ax, ay, az], [bx, by, bz]) = (edge(1), edge(2));
        let normal = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
        let d = if IS_SUN { greater(error.place, error.height) } else { error.place };
        let sizes = [ax.abs() + ay.abs() + az.abs(), bx.abs() + by.abs() + bz.abs()];
        // As for the edges, both factors off by 2d.
        let normal_error = 4.0 * (d * (sizes[0] + sizes[1]) + ROUNDOFF * sizes[0] * sizes[1] + 2.0 * d * d);
        let (determinant, determinant_error) = if IS_SUN {
            (normal[2], normal_error)
        } else {
            let size = r[0].x.abs() + r[0].y.abs() + r[0].w.abs();
            let wide = normal[0].abs() + normal[1].abs() + normal[2].abs();
            let value = normal[0] * r[0].x + normal[1] * r[0].y + normal[2] * r[0].w;
            (value, normal_error * size + wide * (d + 4.0 * ROUNDOFF * size) + 3.0 * normal_error * d)
        };
        let least_w = least_w::<IS_SUN>(r, error);
        let ([farthest, nearest], bounds) = reach::<IS_SUN>(r, least_w, error);
        Self { normal, normal_error, determinant, determinant_error, least_w, nearest, farthest, bounds }
    }

    /// Whether the triangle certainly turns one way.
    #[inline(always)]
    fn is_turned(&self) -> bool {
        self.determinant.abs() > self.determinant_error
    }

    /// The edges as they turn, all positive inside, and what they are off by. An edge without length is vague, and so are all of a triangle that turns no way.
    #[inline(always)]
    fn edges(&self, sides: &[Side; 3]) -> ([Affine; 3], f64) {
        let sign = if self.determinant < 0.0 { -1.0 } else { 1.0 };
        let (mut edges, mut edge_error) = ([[0.0; 3]; 3], 0.0);
        for (edge, side) in edges.iter_mut().zip(sides) {
            let factor = sign / side.reach;
            let off = side.error / side.reach;
            // Not so for NaN.
            let is_known = self.is_turned() & (off < VAGUE);
            for (coefficient, value) in edge.iter_mut().zip(side.value) {
                *coefficient = if is_known { value * factor } else { 0.0 };
            }
            edge_error = greater(if is_known { off + 4.0 * ROUNDOFF * (1.0 + edge[2].abs()) } else { 0.0 }, edge_error);
        }
        (edges, edge_error)
    }

    /// The plane and what it is off by, if the determinant allows.
    #[inline(always)]
    fn plane<const IS_SUN: bool>(&self, corner: &Homogeneous, error: CornerError) -> (Affine, f64) {
        let factor = 1.0 / self.determinant;
        let [nx, ny, nz] = self.normal;
        // Each coefficient is (N ± e)/(D ± d): off by (e + |N/D|·d)/(|D| − d), and its rounding.
        let least = self.determinant.abs() - self.determinant_error;
        let off = |value: f64| {
            (self.normal_error + value.abs() * self.determinant_error) / least + value.abs() * 4.0 * ROUNDOFF
        };
        let (plane, plane_error) = if IS_SUN {
            let (p, q) = (-nx * factor, -ny * factor);
            let at_origin = corner.h - p * corner.x - q * corner.y;
            let reach = corner.x.abs() + corner.y.abs() + 1.0;
            let carried =
                (off(p) + off(q)) * (reach + 1.0) + (p.abs() + q.abs()) * (error.place + 4.0 * ROUNDOFF * reach);
            ([p, q, at_origin], carried + error.height + 4.0 * ROUNDOFF * corner.h.abs())
        } else {
            let plane = [nx * factor * corner.h, ny * factor * corner.h, nz * factor * corner.h];
            (plane, corner.h * (off(nx * factor) + off(ny * factor) + off(nz * factor)))
        };
        let is_known = self.is_turned() & (plane_error < f64::INFINITY);
        (plane, if is_known { 2.0 * plane_error } else { f64::INFINITY })
    }
}

/// Below every corner's w.
#[inline(always)]
fn least_w<const IS_SUN: bool>(r: &[Homogeneous; 3], error: CornerError) -> f64 {
    if IS_SUN { 1.0 } else { least([r[0].w, r[1].w, r[2].w]) - error.place }
}

/// The least and the greatest nearness of a triangle, and its bounds.
#[inline(always)]
fn reach<const IS_SUN: bool>(r: &[Homogeneous; 3], least_w: f64, error: CornerError) -> ([f64; 2], [f64; 4]) {
    let all = f64::INFINITY;
    if IS_SUN {
        let (u, v) = ([r[0].x, r[1].x, r[2].x], [r[0].y, r[1].y, r[2].y]);
        let d = error.place;
        let bounds = [least(u) - d, least(v) - d, greatest(u) + d, greatest(v) + d];
        let heights = [r[0].h, r[1].h, r[2].h];
        return ([least(heights) - error.height, greatest(heights) + error.height], bounds);
    }
    // A quotient x/w is off by (d + |x/w|·d)/least_w; where that is large, nothing is known.
    let is_known = (least_w > 0.0) & (error.place <= least_w * 0.0625);
    let u = [r[0].x / r[0].w, r[1].x / r[1].w, r[2].x / r[2].w];
    let v = [r[0].y / r[0].w, r[1].y / r[1].w, r[2].y / r[2].w];
    let d = error.place / least_w * 1.25;
    let below = |least: f64| if is_known { least - d * (1.0 + least.abs()) } else { -all };
    let above = |greatest: f64| if is_known { greatest + d * (1.0 + greatest.abs()) } else { all };
    let nearest = if is_known { r[0].h / least_w * (1.0 + 4.0 * ROUNDOFF) } else { all };
    let farthest = r[0].h / (greatest([r[0].w, r[1].w, r[2].w]) + error.place) * (1.0 - 4.0 * ROUNDOFF);
    (
        [if is_known { farthest } else { 0.0 }, nearest],
        [below(least(u)), below(least(v)), above(greatest(u)), above(greatest(v))],
    )
}

#[inline(always)]
fn least([a, b, c]: [f64; 3]) -> f64 {
    lesser(lesser(a, b), c)
}

#[inline(always)]
fn greatest([a, b, c]: [f64; 3]) -> f64 {
    greater(greater(a, b), c)
}
