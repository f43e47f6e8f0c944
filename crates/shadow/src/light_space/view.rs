//! One view from a light: a sun's shear onto the coordinate plane most across it, or one of a lamp's six frusta.
//!
//! A point is seen at homogeneous (x, y, w): u = x/w, v = y/w. A sun has w = 1, a lamp the distance along the view's axis.
//! The nearness n = h/w is the height towards a sun (h = n), and a number over the distance to a lamp (h constant): both are
//! affine functions of (u, v) over a plane, and greater nearer to the light.
//!
//! Cost: some 20 flops a point.

use glam::DVec3;
use umbriel_geometry::{Aabb, LightSource, power_of_two_below};

/// Unit roundoff of f64.
const ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// A lamp's view is this wide: |u|, |v| ≤ 1, and room for what points and corners are off by.
const LAMP_WINDOW: f64 = 1.0 + 1.0 / 16.0;

/// A point as a view sees it: u = x/w, v = y/w, nearness = h/w.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homogeneous {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) w: f64,
    pub(crate) h: f64,
}

/// One view from a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    /// What x, y and the third (a sun's h, a lamp's w) are in the world's axes, from the origin.
    rows: [[f64; 3]; 3],
    /// The lamp's place; for a sun the point that is seen at (0, 0) with nearness 0.
    origin: DVec3,
    is_sun: bool,
    /// Scales nearness to about one over the scene; a power of two.
    scale: f64,
}

impl View {
    /// All views of a light: one of a sun, six of a lamp: +x, −x, +y, and so on. `bounds` holds the scene, and sets where
    /// numbers are best.
    pub(crate) fn all(light: &LightSource, bounds: &Aabb) -> Vec<Self> {
        let xyz = light.xyz();
        let size = power_of_two(bounds.size().max_element());
        let middle = if bounds.is_empty() { DVec3::ZERO } else { bounds.center() };
        if !light.is_sun() {
            let scale = size.max(power_of_two((middle - xyz).abs().max_element()));
            let sides = (0..3).flat_map(|axis| [1.0, -1.0].map(|sign| (axis, sign)));
            let view = |(axis, sign)| {
                let rows = [unit((axis + 1) % 3, 1.0), unit((axis + 2) % 3, 1.0), unit(axis, sign)];
                Self { rows, origin: xyz, is_sun: false, scale }
            };
            return sides.map(view).collect();
        }
        let axis = xyz.abs().max_position();
        let sheared = |across: usize| {
            let mut row = unit(across, 1.0);
            row[axis] = -(xyz[across] / xyz[axis]);
            row
        };
        let height = unit(axis, xyz[axis].signum() / size);
        let rows = [sheared((axis + 1) % 3), sheared((axis + 2) % 3), height];
        vec![Self { rows, origin: middle, is_sun: true, scale: 1.0 / size }]
    }

    pub(crate) fn is_sun(&self) -> bool {
        self.is_sun
    }

    /// A lamp's place; for a sun the point with u, v and nearness zero.
    pub(crate) fn origin(&self) -> DVec3 {
        self.origin
    }

    /// A point of the world, rounded. Most coefficients are zero or one, so there is one rounded product in each sum.
    #[inline(always)]
    pub(crate) fn see(&self, point: DVec3) -> Homogeneous {
        let DVec3 { x, y, z } = point - self.origin;
        let [u, v, third] = self.rows;
        let (u, v) = (u[0] * x + u[1] * y + u[2] * z, v[0] * x + v[1] * y + v[2] * z);
        let third = third[0] * x + third[1] * y + third[2] * z;
        let (w, h) = if self.is_sun { (1.0, third) } else { (third, self.scale) };
        Homogeneous { x: u, y: v, w, h }
    }

    /// Bound on the error of x, y and w of [`View::see`] for points that are off by `slack` in each coordinate and no farther than `reach` from
    /// the view's origin along any axis; that of h is as much times [`View::nearness_scale`].
    ///
    /// With p the slack and r the reach: a difference is off by p and rounds by ur. Its part along is multiplied by a slope of at most 1 with an
    /// error of u, and rounds: p + 3ur in all; the sum of the two, at most 2r, rounds by 2ur. All together below 2p + 6ur, without the
    /// second powers of u. What the scene's distance from the world's origin is does not matter, as long as coordinates are exact.
    pub(crate) fn error(&self, slack: f64, reach: f64) -> f64 {
        2.5 * slack + 8.0 * ROUNDOFF * reach
    }

    /// How far a box reaches from the origin of the view along any axis; 0 for an empty one.
    pub(crate) fn reach(&self, bounds: &Aabb) -> f64 {
        if bounds.is_empty() {
            return 0.0;
        }
        let [low, high] = [bounds.min, bounds.max].map(|corner| (corner - self.origin).abs().max_element());
        low.max(high) * (1.0 + f64::EPSILON)
    }

    /// A rectangle that holds the image of the hull of `corners`, least u, v and greatest u, v; `None` when a lamp's view
    /// sees nothing of it. `error` bounds that of the corners.
    pub(crate) fn bounds(&self, corners: &[DVec3], error: f64) -> Option<[f64; 4]> {
        if self.is_sun {
            return Some(self.sun_bounds(corners, error));
        }
        (!self.is_beyond(corners, error)).then(|| self.lamp_bounds(corners, error))
    }

    /// Whether a lamp's view certainly sees nothing of the hull of `corners`, which are finite: all lie behind the lamp, or all beyond one side of the view.
    #[inline(always)]
    pub(crate) fn is_beyond(&self, corners: &[DVec3], error: f64) -> bool {
        let (mut w_most, mut most) = (f64::NEG_INFINITY, [f64::NEG_INFINITY; 4]);
        for &corner in corners {
            let Homogeneous { x, y, w, .. } = self.see(corner);
            let edge = w * LAMP_WINDOW;
            w_most = greater(w, w_most);
            let [left, right, low, high] = most;
            most = [greater(edge - x, left), greater(edge + x, right), greater(edge - y, low), greater(edge + y, high)];
        }
        let [left, right, low, high] = most;
        lesser(w_most, lesser(lesser(left, right), lesser(low, high))) < -4.0 * error
    }

    /// [`Self::bounds`] of a lamp's view that may see something of it. With e the error of corners, u = x/w is off by e·(1 + |u|)/(w − e); 1/w, the product and the ends round by
    /// less than e·(1 + |u|)/(2w), as e ≥ 8·2^-53·w: together below 2e·(1 + |u|)/w where w > 16e. Elsewhere, NaN of w = 0 included, the whole window is taken.
    #[inline(always)]
    pub(crate) fn lamp_bounds(&self, corners: &[DVec3], error: f64) -> [f64; 4] {
        let mut least_w = f64::INFINITY;
        let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for &corner in corners {
            let Homogeneous { x, y, w, .. } = self.see(corner);
            least_w = lesser(w, least_w);
            let inverse = 1.0 / w;
            let (u, v) = (x * inverse, y * inverse);
            let [off_u, off_v] = [u, v].map(|place| 2.0 * error * inverse * (1.0 + place.abs()));
            let [u0, v0, u1, v1] = bounds;
            bounds = [lesser(u - off_u, u0), lesser(v - off_v, v0), greater(u + off_u, u1), greater(v + off_v, v1)];
        }
        // What reaches behind the lamp can appear anywhere.
        let is_in_front = least_w > 16.0 * error;
        let within = |place: f64, otherwise: f64| {
            let place = if is_in_front { place } else { otherwise };
            lesser(greater(place, -LAMP_WINDOW), LAMP_WINDOW)
        };
        let [u0, v0, u1, v1] = bounds;
        [within(u0, -LAMP_WINDOW), within(v0, -LAMP_WINDOW), within(u1, LAMP_WINDOW), within(v1, LAMP_WINDOW)]
    }

    /// No point of the hull of `corners` is nearer to the light; infinite where it may reach behind a lamp. `error` bounds that of the corners.
    #[inline(always)]
    pub(crate) fn nearest(&self, corners: &[DVec3], error: f64) -> f64 {
        let seen = corners.iter().map(|&corner| self.see(corner));
        if self.is_sun {
            return seen.fold(f64::NEG_INFINITY, |most, Homogeneous { h, .. }| greater(most, h)) + error * self.scale;
        }
        let least_w = seen.fold(f64::INFINITY, |least, Homogeneous { w, .. }| lesser(least, w));
        if least_w > 16.0 * error { self.scale / (least_w - 2.0 * error) } else { f64::INFINITY }
    }

    /// Of a sun's view, which sees everything.
    #[inline(always)]
    pub(crate) fn sun_bounds(&self, corners: &[DVec3], error: f64) -> [f64; 4] {
        let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for &corner in corners {
            let Homogeneous { x, y, .. } = self.see(corner);
            let [u0, v0, u1, v1] = bounds;
            bounds = [lesser(u0, x), lesser(v0, y), greater(u1, x), greater(v1, y)];
        }
        let [u0, v0, u1, v1] = bounds;
        [u0 - error, v0 - error, u1 + error, v1 + error]
    }

    /// Whether a triangle turns the other way round than its winding in (u, v), roundings aside: a hint for what belongs together, where [`Footprint`](super::Footprint) is certain.
    #[inline(always)]
    pub(crate) fn is_reversed(&self, corners: &[DVec3; 3]) -> bool {
        let [a, b, c] = [self.see(corners[0]), self.see(corners[1]), self.see(corners[2])];
        if self.is_sun {
            return (b.x - a.x) * (c.y - a.y) < (b.y - a.y) * (c.x - a.x);
        }
        a.x * (b.y * c.w - b.w * c.y) + a.y * (b.w * c.x - b.x * c.w) + a.w * (b.x * c.y - b.y * c.x) < 0.0
    }

    /// What nearness is measured by beside its own size: 1 for a sun, whose nearness may have any sign, 0 for a lamp.
    #[inline(always)]
    pub(crate) fn unit(&self) -> f32 {
        if self.is_sun { 1.0 } else { 0.0 }
    }

    /// How much the nearness of a sun's view changes over one metre of height; of a lamp's view, h.
    pub(crate) fn nearness_scale(&self) -> f64 {
        self.scale
    }
}

/// A vector along an axis.
fn unit(axis: usize, size: f64) -> [f64; 3] {
    std::array::from_fn(|k| if k == axis { size } else { 0.0 })
}

/// One instruction, where `f64::min` looks for NaN; there is none among coordinates. `b` where one is NaN.
#[inline(always)]
pub(crate) fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// As [`lesser`].
#[inline(always)]
pub(crate) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// A power of two of about this size; 1 for what is no positive number.
pub(crate) fn power_of_two(size: f64) -> f64 {
    if size > 0.0 && size.is_finite() { power_of_two_below(size) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Multiples of 1/8, so that points between three of them are exact.
    fn corner() -> impl Strategy<Value = DVec3> {
        [-40i32..=40, -40..=40, -40..=40].prop_map(|at| DVec3::from_array(at.map(f64::from)) / 8.0)
    }

    fn lamp() -> LightSource {
        LightSource::point([0.25, -0.5, 0.125]).expect("a lamp")
    }

    fn sun() -> LightSource {
        LightSource::sun([1.0, -3.0, 2.0]).expect("a sun")
    }

    fn scene() -> Aabb {
        Aabb { min: DVec3::splat(-5.0), max: DVec3::splat(5.0) }
    }

    /// All views of a light, each with the error of corners.
    fn views(light: &LightSource) -> impl Iterator<Item = (View, f64)> {
        View::all(light, &scene()).into_iter().map(|view| (view, view.error(0.0, view.reach(&scene()))))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        #[test]
        fn what_a_view_sees_of_a_triangle_lies_in_its_rectangle(
            corners in [corner(), corner(), corner()],
            parts in (0u32..=16).prop_flat_map(|first| (Just(first), 0..=16 - first)),
        ) {
            let (first, second) = (f64::from(parts.0) / 16.0, f64::from(parts.1) / 16.0);
            let point = corners[0] * first + corners[1] * second + corners[2] * (1.0 - first - second);
            for light in [sun(), lamp()] {
                let mut seen_by = 0;
                for (view, error) in views(&light) {
                    let Homogeneous { x, y, w, h } = view.see(point);
                    if !light.is_sun() && (w <= 0.0 || x.abs() > w || y.abs() > w) {
                        continue;
                    }
                    seen_by += 1;
                    let bounds = view.bounds(&corners, error);
                    prop_assert!(bounds.is_some(), "{corners:?} {point} under {light:?}");
                    let [u0, v0, u1, v1] = bounds.unwrap_or_default();
                    let (u, v) = (x / w, y / w);
                    prop_assert!(u0 <= u && u <= u1 && v0 <= v && v <= v1, "{u} {v} in {bounds:?}");
                    prop_assert!(view.nearest(&corners, error) >= h / w);
                }
                prop_assert!(seen_by > 0 || point == light.xyz());
            }
        }

        /// Of what is before the lamp no more than the corners span, of what is behind it nothing.
        #[test]
        fn a_lamp_sees_small_triangles_in_small_rectangles(middle in corner(), off in [corner(), corner(), corner()]) {
            let corners = off.map(|off| middle + off / 1024.0);
            for (view, error) in views(&lamp()) {
                let seen = corners.map(|corner| view.see(corner));
                if seen.iter().any(|seen| seen.w < 0.25) {
                    prop_assert!(seen.iter().any(|seen| seen.w > -error) || view.bounds(&corners, error).is_none());
                    continue;
                }
                let places = seen.map(|seen| [seen.x / seen.w, seen.y / seen.w]);
                let Some(bounds) = view.bounds(&corners, error) else {
                    let is_beside = |axis: usize, sign: f64| places.iter().all(|place| sign * place[axis] > LAMP_WINDOW);
                    prop_assert!((0..2).any(|axis| is_beside(axis, 1.0) || is_beside(axis, -1.0)));
                    continue;
                };
                for axis in 0..2 {
                    let of_axis = places.map(|place| place[axis].clamp(-LAMP_WINDOW, LAMP_WINDOW));
                    let [low, high] = [of_axis.into_iter().fold(2.0, f64::min), of_axis.into_iter().fold(-2.0, f64::max)];
                    prop_assert!((bounds[axis] - low).abs() < 1e-12 && (bounds[axis + 2] - high).abs() < 1e-12);
                }
            }
        }
    }
}
