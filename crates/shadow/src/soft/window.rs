//! An area light as seen from a point: its plane, and how much of it a part of that plane is.
//!
//! From a point x, rays are points (a, b) of a plane: x sees along x + γ·(a·u + b·v + w). For a rectangle light u and v are its
//! half edges and w leads to its centre, so the light is the square −1..1 and γ = 1 its plane. For a round light, seen from x as
//! a cap of directions, w leads to its middle and u, v are as long as the tangent of its radius: it is the disk a² + b² ≤ 1.
//! Flat faces project to polygons in both, since the map from space to (α, β, γ) is linear; so faces are cut there, before any
//! division. A rectangle is measured by its area, a cap by its solid angle: of the part of a polygon in the disk that is a sum over
//! its edges, of spherical triangles (Van Oosterom and Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng. 30(2),
//! 1983) and sectors.

use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3};
use libm::{atan2, sqrt, tan};
use umbriel_geometry::LightSource;
use umbriel_scene::{Extent, Light};

use super::{
    caps::{Cap, cap_area},
    normal::Normal,
    polygon::{Pieces, Polygon},
};

/// Units roundoff of a projected point: its own, the eye's and their difference's, a product, two sums, and the cuts at the borders.
const ROUNDING: f64 = 16.0 * (f64::EPSILON / 2.0);

/// A light's image from a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    pub(crate) eye: DVec3,
    /// Columns u, v, w.
    pub(crate) axes: DMat3,
    to_image: DMat3,
    /// Occluders are nearer than this γ; infinite for a sun.
    pub(super) end: f64,
    pub(crate) shape: Shape,
}

/// What the image is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shape {
    /// The square −1..1, measured by area.
    Square,
    /// The unit disk, measured by solid angle.
    Disk {
        /// Tangent of the cap's radius.
        tangent: f64,
        cap: Cap,
    },
}

impl Window {
    /// The light as seen from `eye`; `None` where it has no image: it is a point, it is seen edge-on, or the eye is in it.
    pub(crate) fn new(eye: DVec3, light: &Light) -> Option<Self> {
        let to_centre = light.source.xyz() - eye;
        match light.extent {
            Extent::Rectangle { u, v } => Self::with_axes(eye, DMat3::from_cols(u, v, to_centre), 1.0, Shape::Square),
            Extent::Sphere { radius } => {
                let cap = Cap::of_ball(to_centre, radius)?;
                let distance = to_centre.length();
                let rest = (distance - radius) * (distance + radius);
                Self::round(eye, cap, radius / sqrt(rest), rest / distance)
            }
            Extent::Disk { angular_diameter } => {
                let radius = 0.5 * angular_diameter.to_radians();
                Self::round(eye, Cap { towards: light.source.xyz(), radius }, tan(radius), f64::INFINITY)
            }
            _ => None,
        }
    }

    fn round(eye: DVec3, cap: Cap, tangent: f64, end: f64) -> Option<Self> {
        let w = cap.towards.normalize();
        let (u, v) = w.any_orthonormal_pair();
        Self::with_axes(eye, DMat3::from_cols(u * tangent, v * tangent, w), end, Shape::Disk { tangent, cap })
    }

    pub(super) fn with_axes(eye: DVec3, axes: DMat3, end: f64, shape: Shape) -> Option<Self> {
        let to_image = axes.inverse();
        let is_regular = axes.determinant() != 0.0 && to_image.to_cols_array().iter().all(|value| value.is_finite());
        is_regular.then_some(Self { eye, axes, to_image, end, shape })
    }

    /// How much longer than in space a vector may be in (α, β, γ), at most: a bound on the matrix's norm.
    pub(super) fn stretch(&self) -> f64 {
        self.to_image.to_cols_array().iter().map(|value| value.abs()).sum()
    }

    /// (α, β, γ) of a point in space.
    pub(crate) fn homogeneous(&self, point: DVec3) -> DVec3 {
        self.to_image * (point - self.eye)
    }

    /// The direction of an image point.
    pub(crate) fn direction(&self, image: DVec2) -> DVec3 {
        self.axes * image.extend(1.0)
    }

    /// The plane of the light by a point and the normal towards the eye: for a ball the plane of the circle at which rays touch it.
    /// Nothing for a sun.
    pub(crate) fn light_plane(&self) -> Option<(DVec3, Normal)> {
        let normal = Normal::across(self.axes.x_axis, self.axes.y_axis);
        let towards_eye = if normal.value().dot(self.axes.z_axis) > 0.0 { normal.flipped() } else { normal };
        self.end.is_finite().then(|| (self.eye + self.axes.z_axis * self.end, towards_eye))
    }

    /// Whether a ball at this distance is wholly before a round light (`true`) or wholly beyond it; `None` if neither is certain.
    pub(crate) fn is_before_light(&self, distance: f64, radius: f64) -> Option<bool> {
        let Shape::Disk { cap, .. } = self.shape else { return None };
        if distance + radius <= self.end {
            Some(true)
        } else {
            (distance - radius >= 2.0 * cap.towards.length() - self.end).then_some(false)
        }
    }

    /// The point of the light at an image point.
    pub(crate) fn light_point(&self, image: DVec2, light: &Light) -> Option<LightSource> {
        match light.extent {
            Extent::Rectangle { u, v } => {
                LightSource::point((light.source.xyz() + u * image.x + v * image.y).to_array()).ok()
            }
            Extent::Disk { .. } => LightSource::sun((-self.direction(image)).to_array()).ok(),
            _ => LightSource::point((self.eye + self.direction(image) * self.end).to_array()).ok(),
        }
    }

    /// By how much the image of what [`Window::light_point`] gives may differ from what it was asked for, in each direction: five roundings of
    /// numbers no larger than these lengths together, lengthened by the map to the image, twice for γ, which is off by as little.
    pub(crate) fn rounding_of_points(&self, light: &Light) -> f64 {
        let axes = self.axes;
        let size = axes.x_axis.length() + axes.y_axis.length() + axes.z_axis.length();
        let size = match light.extent {
            Extent::Disk { .. } => size,
            _ => size * self.end + light.source.xyz().length() + self.eye.length(),
        };
        16.0 * f64::EPSILON * size * self.stretch()
    }

    /// Whether a polygon may reach the light's image; corners of the square are no part of a round light.
    pub(super) fn may_meet(&self, polygon: &Polygon) -> bool {
        // A dozen roundings of numbers of the polygon's size.
        let rounding = || 64.0 * f64::EPSILON * polygon.0.iter().map(|p| p.abs().max_element()).fold(1.0, f64::max);
        matches!(self.shape, Shape::Square) || polygon.distance_to_origin() <= 1.0 + rounding()
    }

    /// The image of a convex face as far as it is before the light and in the square, counter-clockwise, and how far off its outline may be;
    /// `None` for none.
    pub(crate) fn image(&self, corners: impl Iterator<Item = DVec3>) -> Option<(Polygon, f64)> {
        let mut size = self.eye.abs().max_element();
        let seen = |corner: DVec3| {
            size = size.max(corner.abs().max_element());
            self.homogeneous(corner)
        };
        let mut polygon: Vec<DVec3> = corners.map(seen).collect();
        // The same test for all keeps most faces from being cut at all.
        let sides: [fn(DVec3) -> f64; 4] = [|p| p.z + p.x, |p| p.z - p.x, |p| p.z + p.y, |p| p.z - p.y];
        for side in sides {
            if polygon.iter().all(|&point| side(point) <= 0.0) {
                return None;
            }
        }
        for side in sides {
            cut(&mut polygon, side);
        }
        let end = self.end;
        if end.is_finite() {
            cut(&mut polygon, |point| end - point.z);
        }
        // With γ = 0 a corner is the eye itself: the face is then seen edge-on, or is the eye's own.
        if polygon.len() < 3 || polygon.iter().any(|point| point.z <= 0.0) {
            return None;
        }
        let shift = self.shift(size, polygon.iter().fold(f64::INFINITY, |depth, point| depth.min(point.z)));
        let mut image = Polygon(polygon.into_iter().map(|point| point.truncate() / point.z).collect());
        let area = image.area();
        if area < 0.0 {
            image.0.reverse();
        }
        (area != 0.0).then_some((image, shift))
    }

    /// How far off the image in the square may be of a point that is at this γ or deeper, its coordinates and the eye's up to `size` (NUMERICS.md, "Soft
    /// shadows").
    fn shift(&self, size: f64, depth: f64) -> f64 {
        let rows = self.rows();
        let off = ROUNDING * size * (rows.max_element() + rows.z);
        let rest = self.rest() + self.rest_of_rounding();
        match off < depth && rest < 0.5 {
            true => off / (depth - off) + 4.0 * rest,
            false => f64::INFINITY,
        }
    }

    /// Whether the map to the image is the inverse of the axes up to rounding. It is not where a light's edges are nearly parallel to each other.
    pub(super) fn is_sharp(&self) -> bool {
        self.rest() <= 3.0 * self.rest_of_rounding()
    }

    /// Row sums of the map to the image.
    fn rows(&self) -> DVec3 {
        self.to_image.x_axis.abs() + self.to_image.y_axis.abs() + self.to_image.z_axis.abs()
    }

    /// By how much the map to the image is not the inverse of the axes: relative, so the same at all depths.
    fn rest(&self) -> f64 {
        let rest = self.to_image * self.axes - DMat3::IDENTITY;
        (rest.x_axis.abs() + rest.y_axis.abs() + rest.z_axis.abs()).max_element()
    }

    /// How far off that is, and the third axis itself.
    fn rest_of_rounding(&self) -> f64 {
        // A sun's axes do not begin at the eye.
        let eye = if self.end.is_finite() { self.eye.abs().max_element() } else { 0.0 };
        let largest = self.axes.to_cols_array().into_iter().fold(eye, |largest, entry| largest.max(entry.abs()));
        ROUNDING * largest * self.rows().max_element()
    }

    /// The whole light, as pieces of its square.
    pub(crate) fn whole(&self) -> Pieces {
        Pieces::of(Polygon::square())
    }

    /// The share of the light that a piece of its square is.
    pub(crate) fn share(&self, piece: &Polygon) -> f64 {
        match self.shape {
            Shape::Square => 0.25 * piece.area(),
            Shape::Disk { tangent, cap } => {
                let measure: f64 = piece.edges().map(|edge| measure_below(edge, tangent)).sum();
                measure * tangent * tangent / cap.solid_angle()
            }
        }
    }

    /// The share of the light that pieces are; with what rounding may have changed.
    pub(crate) fn share_of(&self, pieces: &Pieces) -> (f64, f64) {
        let share: f64 = pieces.pieces.iter().map(|piece| self.share(piece)).sum();
        let terms = pieces.cuts + 8 * pieces.pieces.len() as u64;
        (share.clamp(0.0, 1.0), terms as f64 * super::polygon::ERROR_PER_CUT)
    }
}

/// The part of a homogeneous polygon where `value` is not negative.
pub(super) fn cut(polygon: &mut Vec<DVec3>, value: impl Fn(DVec3) -> f64) {
    if polygon.iter().all(|&point| value(point) >= 0.0) {
        return;
    }
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &a) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % polygon.len()];
        let (at_a, at_b) = (value(a), value(b));
        if at_a >= 0.0 {
            kept.push(a);
        }
        if (at_a > 0.0 && at_b < 0.0) || (at_a < 0.0 && at_b > 0.0) {
            kept.push(a + (b - a) * (at_a / (at_a - at_b)));
        }
    }
    *polygon = kept;
}

/// The solid angle over tangent² between the middle of the unit disk and an edge, as far as it is in the disk; negative for an edge
/// that runs clockwise.
fn measure_below([a, b]: [DVec2; 2], tangent: f64) -> f64 {
    let along = b - a;
    let (p, q, r) = (along.length_squared(), a.dot(along), a.length_squared() - 1.0);
    let discriminant = q * q - p * r;
    if p == 0.0 {
        return 0.0;
    }
    if discriminant <= 0.0 {
        return sector(a, b, tangent);
    }
    let root = discriminant.sqrt();
    let enter = ((-q - root) / p).clamp(0.0, 1.0);
    let leave = ((-q + root) / p).clamp(0.0, 1.0);
    if enter >= leave {
        return sector(a, b, tangent);
    }
    let at = |t: f64| {
        if t == 0.0 {
            a
        } else if t == 1.0 {
            b
        } else {
            a + along * t
        }
    };
    sector(a, at(enter), tangent) + triangle(at(enter), at(leave), tangent) + sector(at(leave), b, tangent)
}

/// A sector of the disk between two directions.
fn sector(a: DVec2, b: DVec2, tangent: f64) -> f64 {
    if a == b {
        return 0.0;
    }
    let angle = atan2(a.perp_dot(b), a.dot(b));
    angle * cap_area(libm::atan(tangent)) / (2.0 * PI * tangent * tangent)
}

/// The spherical triangle between the middle and two image points.
fn triangle(a: DVec2, b: DVec2, tangent: f64) -> f64 {
    let scale = tangent * tangent;
    let length = |p: DVec2| sqrt(1.0 + scale * p.length_squared());
    let (length_a, length_b) = (length(a), length(b));
    let below = length_a * length_b + length_a + length_b + (1.0 + scale * a.dot(b));
    // tan(Ω/2) = [m a b] / (|a||b| + (m·a)|b| + (m·b)|a| + a·b); the middle m has length one, and m·a = m·b = 1.
    2.0 * atan2(scale * a.perp_dot(b), below) / scale
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sun(degrees: f64) -> Light {
        let source = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
        Light::with_extent("sun", source, Extent::Disk { angular_diameter: degrees }).expect("a light")
    }

    #[test]
    fn the_whole_light_is_one() {
        for light in [sun(0.53), sun(60.0), sun(1e-4)] {
            let window = Window::new(DVec3::ZERO, &light).expect("a window");
            assert!((window.share(&Polygon::square()) - 1.0).abs() < 1e-14, "{:?}", window.share(&Polygon::square()));
            let mut half = window.whole();
            half.keep(|p| p.x + 0.3 * p.y);
            assert!((window.share_of(&half).0 - 0.5).abs() < 1e-14);
        }
    }

    #[test]
    fn a_strip_of_a_wide_sun_is_what_rings_sum_to() {
        let light = sun(80.0);
        let window = Window::new(DVec3::ZERO, &light).expect("a window");
        let tangent = 40f64.to_radians().tan();
        let strip = Polygon::rectangle(DVec2::new(0.2, -1.0), DVec2::new(0.7, 1.0));
        // Direct sums of (1 + t² s²)^(-3/2) over the strip in the disk.
        let (mut sum, mut whole) = (0.0, 0.0);
        let n = 2000;
        for i in 0..n {
            for j in 0..n {
                let p = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) * (2.0 / n as f64) - 1.0;
                let density = (1.0 + tangent * tangent * p.length_squared()).powf(-1.5);
                if p.length_squared() <= 1.0 {
                    whole += density;
                    sum += if p.x > 0.2 && p.x < 0.7 { density } else { 0.0 };
                }
            }
        }
        assert!((window.share(&strip) - sum / whole).abs() < 1e-4, "{} {}", window.share(&strip), sum / whole);
    }
}
