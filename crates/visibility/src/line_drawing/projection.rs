//! From space to the picture, rounded: for strokes, which decide nothing.

use glam::DVec3;
use umbriel_geometry::{Aabb, LightSource};
use umbriel_scene::Projection;

use crate::{
    View,
    hidden_surface::ShotDefect,
    view::{Basis, corners},
};

/// Where points are drawn.
pub(super) struct Projector {
    origin: DVec3,
    basis: Basis,
    eye: LightSource,
    is_parallel: bool,
    /// Half the picture's edges at distance 1 (perspective) or everywhere (parallel), metres.
    half: [f64; 2],
    /// Pixels a metre there.
    pixels: f64,
}

impl Projector {
    pub(super) fn new(view: &View) -> Result<Self, ShotDefect> {
        let [width, height] = [view.width, view.height];
        if width == 0 || height == 0 {
            return Err(ShotDefect::Size { width, height });
        }
        let basis = view.basis();
        let (is_parallel, metres) = match view.camera.projection {
            Projection::Orthographic { height } => (true, height),
            Projection::Perspective { vertical_degrees } => (false, 2.0 * (0.5 * vertical_degrees).to_radians().tan()),
            _ => return Err(ShotDefect::Projection),
        };
        if !(metres > 0.0 && metres.is_finite()) {
            return Err(ShotDefect::Projection);
        }
        let origin = view.camera.eye;
        let eye = if is_parallel {
            LightSource::sun(basis.forward.to_array())
        } else {
            LightSource::point(origin.to_array())
        };
        let eye = eye.map_err(ShotDefect::Eye)?;
        let (pixels, aspect) = (f64::from(height) / metres, f64::from(width) / f64::from(height));
        Ok(Self { origin, basis, eye, is_parallel, half: [0.5 * metres * aspect, 0.5 * metres], pixels })
    }

    pub(super) fn eye(&self) -> &LightSource {
        &self.eye
    }

    /// A point that is ahead of the eye, in pixels from the upper left corner.
    pub(super) fn place(&self, point: DVec3) -> [f64; 2] {
        let seen = self.basis.local(point - self.origin);
        let z = if self.is_parallel { 1.0 } else { seen.z };
        [(seen.x / z + self.half[0]) * self.pixels, (self.half[1] - seen.y / z) * self.pixels]
    }

    /// The part of a segment inside the picture, by its parameters; `None` if there is none.
    pub(super) fn visible_range(&self, ends: [DVec3; 2]) -> Option<[f64; 2]> {
        let [a, b] = ends.map(|end| self.basis.local(end - self.origin));
        let depth = |point: DVec3| if self.is_parallel { 1.0 } else { point.z };
        let sides = |p: DVec3| {
            let [x, y] = self.half.map(|half| half * depth(p));
            [x - p.x, x + p.x, y - p.y, y + p.y, p.z]
        };
        let mut range = [0.0, 1.0];
        for (from, to) in sides(a).into_iter().zip(sides(b)) {
            cut(&mut range, from, to);
        }
        (range[0] < range[1]).then_some(range)
    }

    /// How far a pixel reaches where a box is nearest, metres; not positive for a box that reaches behind the eye.
    pub(super) fn least_pixel(&self, bounds: &Aabb) -> f64 {
        if self.is_parallel {
            return 1.0 / self.pixels;
        }
        let depths = corners(bounds).map(|corner| self.basis.local(corner - self.origin).z);
        depths.into_iter().fold(f64::INFINITY, f64::min).max(0.0) / self.pixels
    }

    /// A coordinate of the picture, along a unit vector (right, up), from its middle in pixels: as a numerator and a denominator that are affine in the point. The denominator is
    /// positive ahead of the eye.
    pub(super) fn across(&self, point: DVec3, [right, up]: [f64; 2]) -> [f64; 2] {
        let seen = self.basis.local(point - self.origin);
        [self.pixels * (seen.x * right + seen.y * up), if self.is_parallel { 1.0 } else { seen.z }]
    }

    /// The greatest such coordinate in the picture.
    pub(super) fn reach_across(&self, [right, up]: [f64; 2]) -> f64 {
        self.pixels * (self.half[0] * right.abs() + self.half[1] * up.abs())
    }
}

/// Cuts a range of parameters to where a function, affine between its values at 0 and 1, is not negative.
pub(super) fn cut(range: &mut [f64; 2], at_start: f64, at_end: f64) {
    let crossing = at_start / (at_start - at_end);
    match (at_start < 0.0, at_end < 0.0) {
        (false, false) => {}
        (true, true) => range[1] = range[0],
        (true, false) => range[0] = range[0].max(crossing),
        (false, true) => range[1] = range[1].min(crossing),
    }
}
