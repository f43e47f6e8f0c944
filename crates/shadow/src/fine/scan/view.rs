//! From world points to integer coordinates across the light and a depth along it.
//!
//! A view maps a point to homogeneous (x, y, z); its image is (x/z, y/z), counted in quanta from the middle of the
//! window, and shadow rays are points of the image. A sun has one view, a shear along the light (z = 1). A lamp has one
//! if everything fits into a cone before it, else six, one for each face of a cube round it. Depth grows away from the
//! light and is affine over planes: along the axis for a sun, −1/z for a lamp.
//!
//! Guarantee: images of points are off by [`View::error`] quanta at most, depths by [`View::depth_error`] (a sun) or
//! 2^-22 of their own size (a lamp). Differences of two images are exact integers. NUMERICS.md, "Images".

use glam::DVec3;
use umbriel_geometry::{Aabb, LightSource, Sign};

use super::faces::Rect;

/// Unit roundoff of f64.
const ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// Quanta from the middle of the window to its border; two images differ by less than 2^31.
const HALF_WINDOW: f64 = 536_870_912.0;

/// The widest cone, as the tangent of its half angle, that one view of a lamp covers.
const WIDEST: f64 = 16.0;

/// What one of six views keeps beyond its window: vertices with images up to this far out, in units of the window.
const MARGIN: f64 = 1.75;

/// One view from the light.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    origin: DVec3,
    rows: [DVec3; 3],
    is_sun: bool,
    /// Quanta per unit of x/z.
    scale: f64,
    /// The middle of the window in units of x/z, y/z.
    center: [f64; 2],
    depth_scale: f64,
    /// Half extents of the window, quanta.
    pub(super) half: [f64; 2],
    /// Whether every point of the scene has an image.
    sees_all: bool,
    /// How far an image may be off, quanta.
    pub(super) error: f64,
    /// How far a depth may be off, in units of the greatest depth.
    pub(super) depth_error: f32,
}

/// A point in a view: its image in quanta and its depth. `depth` is NaN where the point has no image; `x` then says
/// beyond which planes of the window it lies, a bit each.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Image {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) depth: f32,
}

impl Image {
    /// Whether the point has an image.
    #[inline(always)]
    pub(super) fn is_valid(&self) -> bool {
        !self.depth.is_nan()
    }
}

impl View {
    /// The views that together see everything in `bounds`, a box with all occluders and receivers. `slack` bounds how
    /// far a float corner may be from the exact one.
    pub(super) fn all(light: &LightSource, bounds: &Aabb, slack: f64) -> Vec<Self> {
        if light.is_sun() {
            return vec![Self::of_sun(light.xyz(), bounds, slack)];
        }
        if let Some(view) = Self::of_lamp(light.xyz(), bounds, slack) {
            return vec![view];
        }
        let sides = (0..3).flat_map(|axis| [-1.0, 1.0].map(|sign| (axis, sign)));
        sides.map(|(axis, sign)| Self::of_side(light.xyz(), axis, sign, bounds, slack)).collect()
    }

    fn of_sun(toward: DVec3, bounds: &Aabb, slack: f64) -> Self {
        let axis = toward.abs().max_position();
        let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
        let along = DVec3::AXES[axis];
        let row = |k: usize| DVec3::AXES[k] - along * (toward[k] / toward[axis]);
        let reach = 0.5 * bounds.size().max_element() * (1.0 + 4.0 * ROUNDOFF);
        let mut view = Self {
            origin: bounds.center(),
            rows: [row(a), row(b), along * -toward[axis].signum()],
            is_sun: true,
            scale: 1.0,
            center: [0.0; 2],
            depth_scale: 1.0,
            half: [0.0; 2],
            sees_all: true,
            error: 0.0,
            depth_error: 0.0,
        };
        let [low, high] = view.corner_range(bounds).expect("z is 1");
        view.fit(low, high);
        view.depth_scale = 1.0 / reach.max(f64::MIN_POSITIVE);
        // q = p − origin and q_c·slope and the difference, each rounded once; the slope too: below 8u·reach.
        let off = 8.0 * ROUNDOFF * reach + 2.0 * slack;
        view.error = 0.5 + off * view.scale * (1.0 + 1e-9);
        view.depth_error = (off * view.depth_scale) as f32 + f32::EPSILON * 8.0;
        view
    }

    /// One view of everything, if it all lies in a cone before the lamp.
    fn of_lamp(light: DVec3, bounds: &Aabb, slack: f64) -> Option<Self> {
        let ahead = (bounds.center() - light).try_normalize()?;
        let side = ahead.any_orthonormal_vector();
        let mut view = Self::before_lamp(light, [side, ahead.cross(side), ahead], true);
        let [low, high] = view.corner_range(bounds)?;
        let widest = low.iter().chain(&high).fold(0.0, |widest: f64, x| widest.max(x.abs()));
        let nearest = corners(bounds).map(|corner| view.homogeneous_raw(corner)[2]).fold(f64::INFINITY, f64::min);
        view.fit(low, high);
        view.bound_lamp_errors(widest, slack / nearest);
        view.depth_scale = nearest;
        // NaN, or errors as large as the window, are no view.
        (widest <= WIDEST && view.error < HALF_WINDOW / 65536.0).then_some(view)
    }

    fn of_side(light: DVec3, axis: usize, sign: f64, bounds: &Aabb, slack: f64) -> Self {
        let rows = [DVec3::AXES[(axis + 1) % 3], DVec3::AXES[(axis + 2) % 3], DVec3::AXES[axis] * sign];
        let mut view = Self::before_lamp(light, rows, false);
        view.scale = HALF_WINDOW / 2.0;
        view.half = [view.scale; 2];
        // Corners that are not floats are clipped away where their slack shows (`image`).
        view.bound_lamp_errors(MARGIN, 0.0);
        view.error += if slack > 0.0 { 0.5 } else { 0.0 };
        view.depth_scale = bounds.size().max_element().max(f64::MIN_POSITIVE) * 2f64.powi(-20);
        view
    }

    fn before_lamp(origin: DVec3, rows: [DVec3; 3], sees_all: bool) -> Self {
        Self {
            origin,
            rows,
            is_sun: false,
            scale: 1.0,
            center: [0.0; 2],
            depth_scale: 1.0,
            half: [0.0; 2],
            sees_all,
            error: 0.0,
            depth_error: f32::MIN_POSITIVE,
        }
    }

    /// q = p − light is rounded once, each row's sum thrice: x and z are off by 6u·|q| at most, |q| ≤ z·√(1 + 2X²).
    fn bound_lamp_errors(&mut self, widest: f64, slack: f64) {
        let length = (1.0 + 2.0 * widest * widest).sqrt();
        let off = (8.0 * ROUNDOFF + 4.0 * slack) * length * (1.0 + widest) + 4.0 * ROUNDOFF * widest;
        self.error = 0.5 + off * self.scale * (1.0 + 1e-9);
    }

    /// The least and greatest image of the corners of a box, before [`View::fit`]; `None` when one lies behind.
    fn corner_range(&self, bounds: &Aabb) -> Option<[[f64; 2]; 2]> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in corners(bounds) {
            let [x, y, z] = self.homogeneous_raw(corner);
            if z.is_nan() || z <= 0.0 {
                return None;
            }
            for (k, value) in [x / z, y / z].into_iter().enumerate() {
                low[k] = low[k].min(value);
                high[k] = high[k].max(value);
            }
        }
        Some([low, high])
    }

    /// Makes the window that of these images.
    fn fit(&mut self, low: [f64; 2], high: [f64; 2]) {
        self.center = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
        let reach = [0, 1].map(|k| 0.5 * (high[k] - low[k]));
        self.scale = HALF_WINDOW * (1.0 - 1e-6) / reach[0].max(reach[1]).max(f64::MIN_POSITIVE);
        self.half = reach.map(|reach| reach * self.scale + 4.0);
    }

    #[inline(always)]
    fn homogeneous_raw(&self, point: DVec3) -> [f64; 3] {
        let q = point - self.origin;
        let z = if self.is_sun { 1.0 } else { self.rows[2].dot(q) };
        [self.rows[0].dot(q), self.rows[1].dot(q), z]
    }

    /// Homogeneous coordinates in quanta from the middle of the window: the image is (x/z, y/z).
    #[inline(always)]
    pub(super) fn homogeneous(&self, point: DVec3) -> [f64; 3] {
        let [x, y, z] = self.homogeneous_raw(point);
        [(x - self.center[0] * z) * self.scale, (y - self.center[1] * z) * self.scale, z]
    }

    /// A length across the light at z = 1, in quanta.
    pub(super) fn in_quanta(&self, length: f64) -> f64 {
        length * self.scale
    }

    /// The depth of a point under a sun.
    #[inline(always)]
    pub(super) fn depth_of_sun(&self, point: DVec3) -> f64 {
        self.rows[2].dot(point - self.origin) * self.depth_scale
    }

    /// The depth at z before a lamp.
    #[inline(always)]
    pub(super) fn depth_before_lamp(&self, z: f64) -> f32 {
        (-self.depth_scale / z) as f32
    }

    /// The depth before a lamp times −z.
    pub(super) fn depth_scale_of_lamp(&self) -> f64 {
        self.depth_scale
    }

    /// Whether a box of images lies in the window.
    #[inline(always)]
    pub(super) fn holds(&self, rect: &Rect) -> bool {
        (0..2).all(|k| f64::from(rect.min[k]) >= -self.half[k] && f64::from(rect.max[k]) <= self.half[k])
    }

    /// Whether a box of images comes so near the window that the view decides samples in it.
    pub(super) fn meets(&self, rect: &Rect) -> bool {
        self.is_within(rect, 8.0 * self.error + 2.0)
    }

    /// Whether a face with this box of images may have samples that the view decides, or block one of these: they lie up to 8 errors and 2
    /// quanta beside the window, and boxes of occluders over them up to 2 errors and 4 quanta beside that.
    #[inline(always)]
    pub(super) fn concerns(&self, rect: &Rect) -> bool {
        self.is_within(rect, 16.0 * self.error + 8.0)
    }

    /// Whether a box of images meets the window when that is so much wider on all sides.
    #[inline(always)]
    fn is_within(&self, rect: &Rect, wider: f64) -> bool {
        let half = self.half.map(|half| half + wider);
        (0..2).all(|k| f64::from(rect.max[k]) >= -half[k] && f64::from(rect.min[k]) <= half[k])
    }

    /// Which way a face turns as seen from the light, by the images of its first, second and last corner (the fourth
    /// of these), where they tell.
    #[inline(always)]
    pub(super) fn turn(&self, corners: &[Image; 4]) -> Option<Sign> {
        let [a, b, _, d] = corners;
        let (bx, by) = (f64::from(b.x - a.x), f64::from(b.y - a.y));
        let (dx, dy) = (f64::from(d.x - a.x), f64::from(d.y - a.y));
        let doubled = bx * dy - by * dx;
        // Differences are off by twice the error of an image each.
        let off = 2.0 * self.error * (bx.abs() + by.abs() + dx.abs() + dy.abs()) + 8.0 * self.error * self.error;
        let is_certain = doubled.abs() > off * (1.0 + 1e-9);
        is_certain.then(|| if (doubled > 0.0) == self.is_mirrored() { Sign::Negative } else { Sign::Positive })
    }

    /// Whether what turns counter-clockwise in the image turns clockwise for somebody at the light.
    #[inline(always)]
    fn is_mirrored(&self) -> bool {
        self.rows[0].cross(self.rows[1]).dot(self.rows[2]) > 0.0
    }

    /// Whether the light is a sun.
    pub(super) fn is_sun(&self) -> bool {
        self.is_sun
    }

    /// The image of a corner whose coordinates are off by `slack` at most.
    #[inline(always)]
    pub(super) fn image(&self, point: DVec3, slack: f64) -> Image {
        let [x, y, z] = self.homogeneous(point);
        if !self.sees_all {
            let reach = z * self.scale;
            let is_inside = z > 0.0 && x.abs().max(y.abs()) <= MARGIN * reach && slack * self.scale * 16.0 <= z;
            if !is_inside {
                // Only what is certain counts: it may leave out a face.
                let off = 4.0 * slack * self.scale;
                let beyond = [z <= -slack, x - reach > off, -x - reach > off, y - reach > off, -y - reach > off];
                let code = beyond.iter().enumerate().map(|(bit, &is_beyond)| i32::from(is_beyond) << bit).sum();
                return Image { x: code, y: 0, depth: f32::NAN };
            }
        }
        let depth = if self.is_sun { self.depth_of_sun(point) as f32 } else { self.depth_before_lamp(z) };
        Image { x: (x / z).round_ties_even() as i32, y: (y / z).round_ties_even() as i32, depth }
    }
}

fn corners(bounds: &Aabb) -> impl Iterator<Item = DVec3> + '_ {
    (0..8).map(|i| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    })
}
