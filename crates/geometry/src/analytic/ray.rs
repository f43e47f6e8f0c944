//! Rays against a placed body in floats: for pictures, not for proofs.

use glam::{DVec2, DVec3};

use super::{
    chart::{Chart, Kind, quarter_axes},
    forms::{Forms, LocalPoint},
    layout::{Part, Surface, Trim},
    outline::Outline,
    placed::PlacedAnalytic,
};

/// How far outside a part a hit may seem to lie, in units of the body's size: rounding must not open seams.
const PADDING: f64 = 256.0 * f64::EPSILON;

/// Where a ray meets a surface, rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// In lengths of the ray's direction.
    pub distance: f64,
    /// Patch of the body.
    pub face: usize,
    /// First parameter.
    pub u: f64,
    /// Second parameter.
    pub v: f64,
    /// Outward, local coordinates, not of unit length.
    pub normal: DVec3,
}

impl PlacedAnalytic {
    /// The nearest point of the surface on a ray, local coordinates, strictly ahead of its origin.
    pub fn nearest_local_hit(&self, origin: DVec3, direction: DVec3) -> Option<SurfaceHit> {
        // From the point nearest to the body's middle: there the quadratics cancel least.
        let middle = -origin.dot(direction) / direction.length_squared();
        let start = origin + direction * middle;
        let hits = self.parts().iter().filter_map(|part| {
            let distances = self.crossings(part, start, direction).into_iter().flatten();
            let ahead = distances.filter(|&distance| middle + distance > 0.0);
            ahead.filter(|&distance| self.is_in(part, start + direction * distance)).reduce(f64::min).map(|d| (d, part))
        });
        let (distance, part) = hits.reduce(|a, b| if b.0 < a.0 { b } else { a })?;
        let point = start + direction * distance;
        let (face, [u, v]) = self.locate(part.surface, point)?;
        let distance = middle + distance;
        distance.is_finite().then(|| SurfaceHit { distance, face, u, v, normal: self.outward_at(part.surface, point) })
    }

    fn homogeneous(&self, local: DVec3, weight: f64) -> LocalPoint<f64> {
        let scaled = local / self.unit();
        [scaled.x, scaled.y, scaled.z, weight]
    }

    /// Where a line crosses the surface of a part, trims left aside.
    fn crossings(&self, part: &Part, start: DVec3, direction: DVec3) -> [Option<f64>; 2] {
        let (x, way) = (self.homogeneous(start, 1.0), self.homogeneous(direction, 0.0));
        let forms = self.float_forms();
        let (a, b, c) = match part.surface {
            Surface::Plane(index) => (0.0, 0.5 * forms.plane(index, &way), forms.plane(index, &x)),
            Surface::Quadric(index) => {
                (forms.quadric(index, &way, &way), forms.quadric(index, &x, &way), forms.quadric(index, &x, &x))
            }
        };
        let discriminant = b * b - a * c;
        if discriminant.is_nan() || discriminant < 0.0 {
            return [None; 2];
        }
        let sum = -(b + discriminant.sqrt().copysign(b));
        [sum / a, c / sum].map(|distance| distance.is_finite().then_some(distance))
    }

    fn is_in(&self, part: &Part, point: DVec3) -> bool {
        let (forms, x) = (self.float_forms(), self.homogeneous(point, 1.0));
        part.trims.iter().all(|&trim| {
            let value = match trim {
                Trim::Inside(index) => -forms.quadric(index, &x, &x),
                Trim::Above(index) => forms.plane(index, &x),
                Trim::Below(index) => -forms.plane(index, &x),
            };
            value >= -PADDING
        })
    }

    /// A vector along the outer normal at a point of a surface, rounded; local coordinates, not of unit length.
    pub fn outward_at(&self, surface: Surface, point: DVec3) -> DVec3 {
        let forms: &Forms<f64> = self.float_forms();
        match surface {
            Surface::Quadric(index) => forms.quadrics()[index].half_gradient(&self.homogeneous(point, 1.0)).into(),
            Surface::Plane(index) => {
                let [x, y, z, _] = forms.planes()[index];
                -DVec3::new(x, y, z)
            }
        }
    }

    /// The patch and parameters of a point of a surface: those that fit best.
    pub fn locate(&self, surface: Surface, point: DVec3) -> Option<(usize, [f64; 2])> {
        let charts = self.charts().iter().enumerate().filter(|(_, chart)| chart.surface == surface);
        let places = charts.filter_map(|(face, chart)| Some((face, chart.parameters(point)?)));
        let excess = |uv: [f64; 2]| uv.map(|t| (t - t.clamp(0.0, 1.0)).abs()).into_iter().sum::<f64>();
        let (face, uv) = places.reduce(|a, b| if excess(b.1) < excess(a.1) { b } else { a })?;
        Some((face, uv.map(|t| t.clamp(0.0, 1.0))))
    }
}

impl Chart {
    /// The parameters of a point of the patch, local coordinates; `None` on another side of the body.
    fn parameters(&self, point: DVec3) -> Option<[f64; 2]> {
        match &self.kind {
            Kind::Radial { center, radii, origin, along } => {
                let direction = (point - DVec3::new(0.0, *center, 0.0)) / DVec3::from_array(*radii);
                let axis = (0..3).find(|&k| along[0][k] == 0.0 && along[1][k] == 0.0)?;
                let on_cube = direction / (direction[axis] / origin[axis]);
                let parameter = |step: &[f64; 3]| {
                    let k = (0..3).find(|&k| step[k] != 0.0).unwrap_or(0);
                    (on_cube[k] - origin[k]) / step[k]
                };
                (direction[axis] * origin[axis] > 0.0).then(|| [parameter(&along[0]), parameter(&along[1])])
            }
            Kind::Turned { quarter, outline } => {
                let flat = DVec2::new(point.x, point.z);
                let [ahead, beside] = quarter_axes(*quarter).map(|axis| flat.dot(axis.into()));
                let is_on_axis = flat == DVec2::ZERO;
                let u = if is_on_axis { 0.5 } else { 0.5 + 0.5 * beside / ahead };
                (ahead > 0.0 || is_on_axis).then(|| [u, outline.parameter(flat.length(), point.y)])
            }
            Kind::Graph(graph) => graph.parameters(point),
        }
    }
}

impl Outline {
    /// v at a point (radius, y) of the outline.
    fn parameter(&self, radius: f64, y: f64) -> f64 {
        match *self {
            Self::Line { from, to } => {
                let step = DVec2::from_array(to) - DVec2::from_array(from);
                (DVec2::new(radius, y) - DVec2::from_array(from)).dot(step) / step.length_squared()
            }
            Self::Parabola { radius: rim, .. } => 1.0 - radius / rim,
            Self::Hyperbola { height, .. } => 0.5 + y / height,
        }
    }
}
