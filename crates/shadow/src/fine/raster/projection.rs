//! Points cast along the light into the parameters of a flat face, with bounds.
//!
//! With r the point from the face's first corner, l the light from there (a sun: its direction), a and b the face's two
//! edges and n = a × b, the ray through the point meets the plane at u = U/W, v = V/W with
//!
//! > U = (b × l)·r,  V = (l × a)·r,  h = n·r,  W = n·l − w·h  (w = 0 for a sun).
//!
//! All are affine in the point; h > 0 is the light's side of the plane, and the light is where W = 0. The gradients are
//! computed once with running bounds; at a point everything is plain arithmetic, with one absolute bound for all points
//! of a body (NUMERICS.md, "Borders on a face"). Cost: about 40 flops and a division a point.

use glam::DVec3;
use umbriel_geometry::{Aabb, Approx, LightSource, Point, Sign, predicates::symmetric_sum};

use crate::fine::flat::FLAT;

/// Units roundoff that a form takes up at a point: one for the difference from the first corner, three for the products
/// and their sum, and room for two interpolations along an edge (three each, of terms twice as large).
const FORM_ROUNDING: f64 = 20.0 * (f64::EPSILON / 2.0);

/// Covers the roundings of a bound's own sums and products.
const PADDING: f64 = 1.0 + 64.0 * f64::EPSILON;

/// Points with W below this share of its value in the face's plane are cut off: their images are far away.
const CUTOFF: f64 = 1.0 / (1u64 << 20) as f64;

/// The light must be clear of the face's plane by this factor over the bound.
const CLEARANCE: f64 = (1u64 << 20) as f64;

/// A linear form of the vector from the first corner.
#[derive(Clone, Copy, Debug)]
struct Form {
    gradient: DVec3,
    error: DVec3,
}

/// U, V, W and h at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Image {
    pub(crate) u: f64,
    pub(crate) v: f64,
    pub(crate) w: f64,
    pub(crate) h: f64,
}

/// Absolute bounds on the errors of an [`Image`], for all points of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImageBounds {
    pub(crate) u: f64,
    pub(crate) v: f64,
    pub(crate) w: f64,
    pub(crate) h: f64,
}

/// A point of the face's plane in cells from the first corner; the true one is not farther off than `margin` in either
/// coordinate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) margin: f64,
    /// The number of the body's point that is cast here, if it is a corner clear of the face's plane.
    pub(crate) corner: Option<u32>,
}

/// From space to a face's parameters.
#[derive(Clone, Debug)]
pub(crate) struct Projection {
    origin: DVec3,
    origin_slack: DVec3,
    u: Form,
    v: Form,
    height: Form,
    /// W in the face's plane; positive.
    in_plane: Approx,
    /// The light's weight, 0 or 1.
    weight: f64,
    /// Cells along an edge of the face; a power of two.
    cells: f64,
}

impl Projection {
    /// For a face with these corners that has the light on side `facing`, `cells` cells along its edges; `None` where the
    /// light is hardly clear of the face's plane.
    pub(crate) fn new(corners: &[Point; FLAT], light: &LightSource, facing: Sign, cells: f64) -> Option<Self> {
        let sign = Approx::exact(if facing == Sign::Negative { -1.0 } else { 1.0 });
        let [a, b, d] = [0, 1, FLAT - 1].map(|k| corners[k].coordinates());
        let minus = |p: [Approx; 3]| -> [Approx; 3] { std::array::from_fn(|k| p[k] - a[k]) };
        let light_at = light.xyz().to_array().map(Approx::exact);
        let to_light = if light.is_sun() { light_at } else { minus(light_at) }.map(|c| c * sign);
        let (along_u, along_v) = (minus(b), minus(d));
        let normal = cross(&along_u, &along_v);
        let in_plane = Approx::sum_of_three([0, 1, 2].map(|k| normal[k] * to_light[k]));
        let is_clear = in_plane.value > CLEARANCE * in_plane.error;
        is_clear.then(|| Self {
            origin: corners[0].position,
            origin_slack: corners[0].slack,
            u: Form::new(&cross(&along_v, &to_light)),
            v: Form::new(&cross(&to_light, &along_u)),
            height: Form::new(&normal.map(|c| c * sign)),
            in_plane,
            weight: light.w(),
            cells,
        })
    }

    /// Cells along an edge of the face.
    pub(crate) fn cells(&self) -> f64 {
        self.cells
    }

    /// The least W that is looked at; see [`CUTOFF`].
    pub(crate) fn cutoff(&self) -> f64 {
        self.in_plane.value * CUTOFF
    }

    /// What the roundings can do at points in `bounds` that are known to `slack`.
    pub(crate) fn bounds(&self, bounds: &Aabb, slack: DVec3) -> ImageBounds {
        let reach = (bounds.max - self.origin).abs().max((bounds.min - self.origin).abs()) * PADDING;
        let slack = slack + self.origin_slack;
        let h = self.height.bound(reach, slack);
        let highest = dot(self.height.gradient.abs(), reach);
        let w = (self.in_plane.error + h + (self.in_plane.value + highest) * FORM_ROUNDING) * PADDING;
        ImageBounds { u: self.u.bound(reach, slack), v: self.v.bound(reach, slack), w, h }
    }

    /// The image of a point.
    #[inline]
    pub(crate) fn image(&self, point: DVec3) -> Image {
        let r = point - self.origin;
        let h = dot(self.height.gradient, r);
        let w = self.in_plane.value - self.weight * h;
        Image { u: dot(self.u.gradient, r), v: dot(self.v.gradient, r), w, h }
    }

    /// h at a point, with a bound of its own.
    #[inline]
    pub(crate) fn height(&self, point: DVec3) -> Approx {
        let r = point - self.origin;
        let reach = r.abs();
        let form = &self.height;
        let bound = dot(form.gradient.abs(), reach) * FORM_ROUNDING + dot(form.error, reach);
        Approx { value: dot(form.gradient, r), error: bound * PADDING }
    }

    /// Where an image with W ≥ cutoff lies on the face's plane.
    #[inline]
    pub(crate) fn place(&self, image: &Image, bounds: &ImageBounds) -> Place {
        let inverse = 1.0 / image.w;
        let (u, v) = (image.u * inverse, image.v * inverse);
        let far = u.abs().max(v.abs());
        // (E_U + |u|·E_W)/(W − E_W), and W's bound is far below W.
        let error = (bounds.u.max(bounds.v) + far * bounds.w) / (image.w - bounds.w) + far * (4.0 * f64::EPSILON);
        Place { x: u * self.cells, y: v * self.cells, margin: error * PADDING * self.cells, corner: None }
    }
}

impl Form {
    fn new(gradient: &[Approx; 3]) -> Self {
        Self { gradient: gradient.map(|c| c.value).into(), error: gradient.map(|c| c.error).into() }
    }

    /// The error at points within `reach` of the first corner, themselves off by `slack`.
    fn bound(&self, reach: DVec3, slack: DVec3) -> f64 {
        let steep = self.gradient.abs();
        (dot(steep, reach * FORM_ROUNDING + slack) + dot(self.error, reach + slack)) * PADDING
    }
}

impl Image {
    /// The point at `t` on the way to another; both exactly as they are.
    #[inline]
    pub(crate) fn toward(&self, other: &Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * t;
        Self { u: mix(self.u, other.u), v: mix(self.v, other.v), w: mix(self.w, other.w), h: mix(self.h, other.h) }
    }
}

/// How far the true segment may be from ours where it passes the face: ends that are far away are less certain, but points
/// between are off by the weighted mean of what the ends are.
pub(super) fn margin_over(from: &Place, to: &Place, cells: f64) -> f64 {
    let most = from.margin.max(to.margin);
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    if dx.abs() + dy.abs() < 2.0 * cells {
        return most;
    }
    // The part that may belong to a point of the face (Liang & Barsky 1984).
    let (low, high) = (-2.0 - most, cells + 2.0 + most);
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (start, step) in [(from.x, dx), (from.y, dy)] {
        if step == 0.0 {
            continue;
        }
        let [a, b] = [(low - start) / step, (high - start) / step];
        (first, last) = (first.max(a.min(b)), last.min(a.max(b)));
    }
    let at = |t: f64| from.margin + (to.margin - from.margin) * t;
    // Beside the segment's ends the line goes on for a cell or two.
    let beyond = 8.0 * (from.margin + to.margin) / (dx.abs() + dy.abs());
    if first > last { beyond } else { at(first).max(at(last)) + beyond }
}

/// Rounded alike whatever the order of the axes.
#[inline]
fn dot(a: DVec3, b: DVec3) -> f64 {
    symmetric_sum(a * b)
}

fn cross(a: &[Approx; 3], b: &[Approx; 3]) -> [Approx; 3] {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    })
}
