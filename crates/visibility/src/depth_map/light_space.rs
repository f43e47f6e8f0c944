//! Where a depth map lies: light space, the image that the light's middle sees, and how wide a light is in it.
//!
//! z runs along the direction in which the light looks. From a lamp the image is the plane of slopes (x/z, y/z), and a plane in space has 1/z affine
//! over it. From a sun rays are parallel: the image is (x, y), and a plane has z affine over it. Either number is the *depth number* here.
//! A light of width W (metres of a lamp's edge, or 2·tan(α/2) of a sun) is on the image, seen from a point at z past a blocker at
//! z_b, as wide as W times the difference of the two depth numbers.

use glam::{DMat3, DVec2, DVec3};

/// Of the deepest point's depth: nearer to a lamp a slope has no place on a map.
const NEAREST: f64 = 1.0 / 4096.0;

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
    /// Nothing nearer to a lamp is drawn, metres.
    near: f64,
}

/// How the light's middle looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rays {
    FromOrigin,
    Parallel,
}

impl LightSpace {
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

    /// The space of a lamp at `origin` that looks along `forward`, with a window of slopes from −1 to 1, whatever `points` (world coordinates, metres) are
    /// before it: a side of a cube.
    pub fn square(origin: DVec3, forward: DVec3, points: impl IntoIterator<Item = DVec3>, size: usize) -> Self {
        let space = Self::without_points(origin, forward, Rays::FromOrigin, size);
        let deepest = points.into_iter().map(|point| space.to_light(point).z).fold(0.0, f64::max);
        Self { near: NEAREST * deepest, ..space }
    }

    fn without_points(origin: DVec3, forward: DVec3, rays: Rays, size: usize) -> Self {
        let forward = forward.normalize_or(DVec3::NEG_Y);
        let (right, up) = forward.any_orthonormal_pair();
        let turn = DMat3::from_cols(right, up, forward).transpose();
        Self { origin, turn, rays, low: DVec2::NEG_ONE, texel: 2.0 / size as f64, size, near: 0.0 }
    }

    fn new(origin: DVec3, forward: DVec3, rays: Rays, points: impl IntoIterator<Item = DVec3>, size: usize) -> Self {
        let whole = Self::without_points(origin, forward, rays, size);
        let seen: Vec<DVec3> = points.into_iter().map(|point| whole.to_light(point)).collect();
        let near = NEAREST * seen.iter().map(|point| point.z).fold(0.0, f64::max);
        let whole = Self { near, ..whole };
        let images = seen.into_iter().filter(|&point| whole.is_drawn(point)).map(|point| whole.image(point));
        let (low, high) =
            images.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), place| (low.min(place), high.max(place)));
        let edge = (high - low).max_element();
        if !(edge > 0.0 && edge.is_finite()) {
            return whole;
        }
        // A texel free on every side.
        let texel = edge / (size.max(4) - 2) as f64;
        let middle = 0.5 * (low + high);
        Self { low: middle - DVec2::splat(0.5 * texel * size as f64), texel, ..whole }
    }

    /// Nothing nearer to a lamp than this is drawn, metres.
    pub(super) fn near(&self) -> f64 {
        self.near
    }

    /// Whether a point in light space is far enough from a lamp's plane to be drawn.
    pub(super) fn is_drawn(&self, seen: DVec3) -> bool {
        self.rays == Rays::Parallel || (seen.z > 0.0 && seen.z >= self.near)
    }

    /// Greater is nearer, and affine over the map for the points of a plane: 1/z, or −z where rays are parallel.
    pub(super) fn nearness(&self, depth: f64) -> f64 {
        if self.is_parallel() { -depth } else { 1.0 / depth }
    }

    /// That of an infinite depth.
    pub(super) fn nearness_of_nothing(&self) -> f32 {
        if self.is_parallel() { f32::NEG_INFINITY } else { 0.0 }
    }

    /// The depth with a nearness.
    pub(super) fn depth_of_nearness(&self, nearness: f32) -> f32 {
        if self.is_parallel() { -nearness } else { 1.0 / nearness }
    }

    /// A point in light space: x, y, and z along the light's look, metres.
    pub fn to_light(&self, point: DVec3) -> DVec3 {
        self.turn * (point - self.origin)
    }

    /// A direction in light space.
    pub fn direction_to_light(&self, direction: DVec3) -> DVec3 {
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
    pub fn image_to_texels(&self, place: DVec2) -> DVec2 {
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

    /// Whether rays are parallel: a sun's.
    pub fn is_parallel(&self) -> bool {
        self.rays == Rays::Parallel
    }

    /// Whether a face with this normal, through this point (both in light space), is turned to the light's middle.
    pub fn is_turned_to_light(&self, normal: DVec3, point: DVec3) -> bool {
        match self.rays {
            Rays::FromOrigin => normal.dot(point) < 0.0,
            Rays::Parallel => normal.z < 0.0,
        }
    }

    /// The depth number of a point: 1/z, or z where rays are parallel.
    pub fn depth_number(&self, depth: f64) -> f64 {
        if self.is_parallel() { depth } else { 1.0 / depth }
    }

    /// How fast the depth number of a plane changes from one texel to the next in both directions; in light space, by the normal and a point.
    /// Zero for a plane that is seen edge-on.
    pub fn change_of_plane(&self, normal: DVec3, point: DVec3) -> DVec2 {
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
    pub fn on_image(&self, metres: f64, depth: f64) -> f64 {
        if self.is_parallel() { metres } else { metres / depth }
    }

    /// The ray through a texel's middle: where it begins, and its direction, along which z grows as fast as the parameter.
    pub fn ray(&self, column: usize, row: usize) -> (DVec3, DVec3) {
        let place = self.low + DVec2::new(column as f64 + 0.5, row as f64 + 0.5) * self.texel;
        let to_world = self.turn.transpose();
        match self.rays {
            Rays::FromOrigin => (self.origin, to_world * place.extend(1.0)),
            Rays::Parallel => (self.origin + to_world * place.extend(0.0), to_world.z_axis),
        }
    }
}
