//! A cell's views of an area light: from its middle, where what is hidden is known, and from its corners, which bound what
//! another place changes. NUMERICS.md, "Soft shadows", has the proofs.

use glam::{DVec2, DVec3};
use umbriel_scene::{Extent, Light};

use super::{
    caps::{angle, cap_area},
    cell::{Cell, CellBounds},
    window::{Shape, Window},
};

/// A cell's views of the light: from its middle, and from its corners.
pub(super) struct Views {
    pub(super) centre: Window,
    all: Vec<Window>,
    /// How much longer than in space a vector may be in an image, before that is divided by γ.
    stretch: f64,
    /// How far off the cell's corners may be along every axis, metres.
    slack: f64,
    /// A round light's rim in the image over all of the cell, and by what factor shares of it differ.
    pub(super) rim: Rim,
}

pub(super) struct Rim {
    /// Share of the light, as measured from the middle, within its smallest and its greatest image.
    inner: f64,
    outer: f64,
    /// Ratio of the greatest to the least density.
    density: f64,
    /// How far the image reaches beyond the unit disk.
    pub(super) growth: f64,
}

/// Roundings of a projected corner: the difference to the eye, the matrix's nine products, the quotient, and as many for a corner made by cuts.
const IMAGE_ROUNDING: f64 = 64.0 * f64::EPSILON;

impl Views {
    /// `None` where the light has no image from some point of the cell, or none that is known well.
    pub(super) fn new(cell: &Cell, light: &Light) -> Option<Self> {
        let Cell { corners, slack, middle } = cell;
        let centre = Window::new(*middle, light)?;
        let eyes = || corners.iter().chain([middle]).copied();
        let mut all = Vec::with_capacity(corners.len() + 1);
        let mut rim = Rim::NONE;
        if let (Extent::Sphere { radius }, Shape::Disk { tangent, cap }) = (light.extent, centre.shape) {
            // A plane through the ball's middle serves the whole cell.
            let (to_light, distance) = (cap.towards, cap.towards.length());
            let mut nearest = distance;
            for eye in eyes() {
                let mut axes = centre.axes * distance;
                axes.z_axis = light.source.xyz() - eye;
                let depth = axes.z_axis.dot(to_light) / distance;
                nearest = nearest.min(depth);
                all.push(Window::with_axes(eye, axes, 1.0 - radius / depth, centre.shape).filter(|_| depth > radius)?);
            }
            rim = Rim::of_ball(cell, light.source.xyz(), radius, tangent, nearest)?;
        } else {
            for eye in eyes() {
                all.push(Window::new(eye, light)?);
            }
        }
        if !all.iter().all(Window::is_sharp) {
            return None;
        }
        let stretch = all.iter().map(Window::stretch).fold(0.0, f64::max);
        Some(Self { centre, all, stretch, slack: *slack, rim })
    }

    /// The image of a point from the middle, and how far off it may be from elsewhere in the cell. `None` where that has no bound: the point is
    /// not before all of the cell, or not before the light.
    pub(super) fn project(&self, point: DVec3) -> Option<(DVec2, f64)> {
        // Vectors off by `slack` along every axis are off by less than twice that in length.
        let size = point.abs().max_element() + self.centre.eye.abs().max_element();
        let image = |window: &Window| {
            let seen = window.homogeneous(point);
            let slack = self.stretch * (IMAGE_ROUNDING * size + 2.0 * self.slack);
            let is_between = seen.z > 2.0 * slack && seen.z <= window.end + slack;
            is_between.then(|| {
                let image = seen.truncate() / seen.z;
                (image, slack * (2.0 + image.abs().max_element()) / (seen.z - slack))
            })
        };
        let (own, mut shift) = image(self.all.last()?)?;
        for window in &self.all {
            let (other, slack) = image(window)?;
            shift = shift.max((other - own).length() + 2.0 * slack);
        }
        Some((own, shift))
    }
}

impl Rim {
    const NONE: Self = Self { inner: 1.0, outer: 1.0, density: 1.0, growth: 0.0 };

    /// Of a ball of light. From x at the angle τ to the axis through the cell's middle, the image on the plane through the ball's middle reaches
    /// between R / cos(ρ − τ) and R / cos(ρ + τ). The density d/|p − x|³ on that plane differs from the middle's by a factor whose
    /// logarithm changes by 3|Δx| / (d d₀) a metre at most.
    fn of_ball(cell: &Cell, light: DVec3, radius: f64, tangent: f64, nearest: f64) -> Option<Self> {
        let axis = light - cell.middle;
        let reach = cell.reach();
        let turn = cell.corners.iter().map(|&corner| angle(axis, light - corner)).fold(0.0, f64::max);
        let tilt = turn + 2.0 * cell.slack / (axis.length() - reach).max(f64::MIN_POSITIVE);
        let (near, far) = (axis.length() - reach, axis.length() + reach);
        if near <= radius {
            return None;
        }
        let (narrow, wide) = (libm::asin(radius / far), libm::asin(radius / near));
        if wide + tilt >= std::f64::consts::FRAC_PI_2 {
            return None;
        }
        let unit = tangent * axis.length();
        let (least, most) = (radius / libm::cos((narrow - tilt).max(0.0)), radius / libm::cos(wide + tilt));
        let whole = cap_area(libm::atan(tangent));
        let share = |reach: f64| cap_area(libm::atan(tangent * reach / unit)) / whole;
        let density = libm::exp(6.0 * most * reach / (axis.length() * nearest));
        let rounding = 64.0 * f64::EPSILON;
        Some(Self {
            inner: share(least).min(1.0) - rounding,
            outer: share(most).max(1.0) + rounding,
            density,
            growth: (most / unit - 1.0).max(0.0) + rounding,
        })
    }

    /// Bounds for the light as the middle sees it, made bounds for the light as each point sees it.
    pub(super) fn widened(&self, bounds: CellBounds) -> CellBounds {
        let CellBounds { lower, upper, estimate } = bounds;
        if (lower, upper) == (0.0, 0.0) || (lower, upper) == (1.0, 1.0) {
            return bounds;
        }
        let lower = ((lower - (1.0 - self.inner)) / (self.density * self.outer)).max(0.0);
        let upper = ((upper + (self.outer - 1.0)) * self.density / self.inner).min(1.0);
        CellBounds { lower, upper, estimate: estimate.clamp(lower, upper) }
    }
}
