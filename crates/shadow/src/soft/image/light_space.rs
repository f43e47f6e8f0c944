//! Where a depth map lies: light space, the image that the light's middle sees, and how wide the light is in it.
//!
//! z runs along the direction in which the light looks. From a lamp the image is the plane of slopes (x/z, y/z), and a plane in space has 1/z affine
//! over it. From a sun rays are parallel: the image is (x, y), and a plane has z affine over it. Either number is the *depth number* here.
//! A light of width W (metres of a lamp's edge, or 2·tan(α/2) of a sun) is on the image, seen from a point at z past a blocker at
//! z_b, as wide as W times the difference of the two depth numbers.

use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3};
use umbriel_scene::{Extent, Light};

/// Light space and the window of the map.
#[derive(Clone, Copy, Debug)]
pub struct LightSpace {
    origin: DVec3,
    /// World to light: rows right, up, forward.
    turn: DMat3,
    rays: Rays,
    /// The window's low corner on the image.
    low: DVec2,
    /// On the image from one texel to the next.
    texel: f64,
    /// Texels along an edge.
    size: usize,
}

/// How the light's middle looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rays {
    FromOrigin,
    Parallel,
}

impl LightSpace {
    /// The space of an area light with a window round `corners`, and its width: the edge of a square of the same area in metres, for a ball facing the
    /// middle of the corners; of a sun twice the tangent of its radius. `None` for a point.
    pub fn of_light(light: &Light, corners: &[DVec3], size: usize) -> Option<(Self, f64)> {
        let points = || corners.iter().copied();
        let place = light.source.xyz();
        match light.extent {
            Extent::Rectangle { u, v } => {
                let normal = u.cross(v);
                let side: f64 = points().map(|corner| normal.dot(corner - place)).sum();
                let forward = if side < 0.0 { -normal } else { normal };
                Some((Self::round(place, forward, points(), size), 2.0 * normal.length().sqrt()))
            }
            Extent::Sphere { radius } => {
                let low = points().fold(DVec3::INFINITY, DVec3::min);
                let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
                let space = Self::round(place, 0.5 * (low + high) - place, points(), size);
                Some((space, PI.sqrt() * radius))
            }
            Extent::Disk { angular_diameter } => {
                let width = 2.0 * libm::tan(0.5 * angular_diameter.to_radians());
                Some((Self::parallel(-place, points(), size), width))
            }
            _ => None,
        }
    }

    /// The space of a lamp at `origin` that looks along `forward`, with a window round the slopes of `points` (world coordinates, metres).
    /// Points that are not before the lamp do not count.
    pub fn round(origin: DVec3, forward: DVec3, points: impl IntoIterator<Item = DVec3>, size: usize) -> Self {
        Self::new(origin, forward, Rays::FromOrigin, points, size)
    }

    /// The space of a sun whose light travels along `forward`, with a window round `points`. Depths are counted from as far before the first
    /// of them as the last is behind it, so that they are positive.
    pub fn parallel(forward: DVec3, points: impl IntoIterator<Item = DVec3>, size: usize) -> Self {
        let forward = forward.normalize_or(DVec3::NEG_Y);
        let points: Vec<DVec3> = points.into_iter().collect();
        let depths = points.iter().map(|point| forward.dot(*point));
        let (first, last) = depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(z), b.max(z)));
        let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let reach = points.iter().map(|&point| point.distance(middle)).fold(0.0, f64::max);
        let from = if first < last { 2.0 * first - last } else { forward.dot(middle) - reach };
        let origin = middle + forward * (from - forward.dot(middle));
        Self::new(origin, forward, Rays::Parallel, points, size)
    }

    fn new(origin: DVec3, forward: DVec3, rays: Rays, points: impl IntoIterator<Item = DVec3>, size: usize) -> Self {
        let forward = forward.normalize_or(DVec3::NEG_Y);
        let (right, up) = forward.any_orthonormal_pair();
        let turn = DMat3::from_cols(right, up, forward).transpose();
        let whole = Self { origin, turn, rays, low: DVec2::NEG_ONE, texel: 2.0 / size as f64, size };
        let images = points.into_iter().map(|point| whole.to_light(point)).filter(|seen| whole.is_before(*seen));
        let (low, high) = images
            .map(|seen| whole.image(seen))
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), place| (low.min(place), high.max(place)));
        let edge = (high - low).max_element();
        if !(edge > 0.0 && edge.is_finite()) {
            return whole;
        }
        // A texel free on every side.
        let texel = edge / (size.max(4) - 2) as f64;
        let middle = 0.5 * (low + high);
        Self { low: middle - DVec2::splat(0.5 * texel * size as f64), texel, ..whole }
    }

    /// A point in light space: x, y, and z along the light's look, metres.
    pub fn to_light(&self, point: DVec3) -> DVec3 {
        self.turn * (point - self.origin)
    }

    /// A direction in light space.
    pub(super) fn direction_to_light(&self, direction: DVec3) -> DVec3 {
        self.turn * direction
    }

    /// Whether a point in light space has an image.
    pub fn is_before(&self, seen: DVec3) -> bool {
        self.rays == Rays::Parallel || seen.z > 0.0
    }

    /// The image of a point in light space.
    pub fn image(&self, seen: DVec3) -> DVec2 {
        match self.rays {
            Rays::FromOrigin => seen.truncate() / seen.z,
            Rays::Parallel => seen.truncate(),
        }
    }

    /// Where a point in light space lies on the map, in texels.
    pub fn to_texels(&self, seen: DVec3) -> DVec2 {
        self.image_to_texels(self.image(seen))
    }

    /// Where a place on the image lies on the map, in texels.
    pub(super) fn image_to_texels(&self, place: DVec2) -> DVec2 {
        (place - self.low) / self.texel
    }

    /// On the image from one texel to the next.
    pub fn texel(&self) -> f64 {
        self.texel
    }

    /// Texels along an edge.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Whether rays are parallel.
    pub(super) fn is_parallel(&self) -> bool {
        self.rays == Rays::Parallel
    }

    /// A length that no point of a box is farther away than.
    pub(super) fn reach(&self, center: DVec3, size: DVec3) -> f64 {
        (center - self.origin).length() + size.length()
    }

    /// Whether a face with this normal, through this point (both in light space), is turned to the light's middle.
    pub(super) fn is_turned_to_light(&self, normal: DVec3, point: DVec3) -> bool {
        match self.rays {
            Rays::FromOrigin => normal.dot(point) < 0.0,
            Rays::Parallel => normal.z < 0.0,
        }
    }

    /// The depth number of a point: 1/z, or z where rays are parallel.
    pub(super) fn depth_number(&self, depth: f64) -> f64 {
        if self.is_parallel() { depth } else { 1.0 / depth }
    }

    /// How fast the depth number of a plane changes from one texel to the next in both directions; in light space, by the normal and a point.
    /// Zero for a plane that is seen edge-on.
    pub(super) fn change_of_plane(&self, normal: DVec3, point: DVec3) -> DVec2 {
        let change = match self.rays {
            Rays::FromOrigin => normal.truncate() * (self.texel / normal.dot(point)),
            Rays::Parallel => -normal.truncate() * (self.texel / normal.z),
        };
        if change.is_finite() { change } else { DVec2::ZERO }
    }

    /// How wide, on the image, a light of this width is seen from a depth past a blocker at another.
    pub fn width_on_image(&self, width: f64, blocker: f64, receiver: f64) -> f64 {
        let between = match self.rays {
            Rays::FromOrigin => 1.0 / blocker - 1.0 / receiver,
            Rays::Parallel => receiver - blocker,
        };
        (width * between).max(0.0)
    }

    /// The penumbra's width on a receiver at this depth, metres.
    pub fn penumbra(&self, width: f64, blocker: f64, receiver: f64) -> f64 {
        self.in_metres(self.width_on_image(width, blocker, receiver), receiver)
    }

    /// A width on the image at a depth, in metres.
    fn in_metres(&self, on_image: f64, depth: f64) -> f64 {
        if self.is_parallel() { on_image } else { on_image * depth }
    }

    /// A width in metres at a depth, on the image.
    pub(super) fn on_image(&self, metres: f64, depth: f64) -> f64 {
        if self.is_parallel() { metres } else { metres / depth }
    }

    /// The ray through a texel's middle: where it begins, and its direction, along which z grows as fast as the parameter.
    pub(super) fn ray(&self, column: usize, row: usize) -> (DVec3, DVec3) {
        let place = self.low + DVec2::new(column as f64 + 0.5, row as f64 + 0.5) * self.texel;
        let to_world = self.turn.transpose();
        match self.rays {
            Rays::FromOrigin => (self.origin, to_world * place.extend(1.0)),
            Rays::Parallel => (self.origin + to_world * place.extend(0.0), to_world.z_axis),
        }
    }
}
