//! Areas of convex shadows of any kind from the points where lines touch them.
//!
//! The outline of a quadric seen through a projection P is the conic with dual C* = P·D·Pᵀ, where D is the dual of the
//! quadric (the planes that touch it). A disk has a dual too. So the shadow of every body here is the hull of few conics.
//! With p(θ) the shadow's farthest point along n = (cos θ, sin θ) the area is ½∫ (h² − h'²) dθ, h = n·p, h' = n'·p.

use std::f64::consts::PI;

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};
use umbriel_geometry::Analytic;

use super::{Caster, Lamp, quadrature::integral};

/// A part of a shadow's hull.
#[derive(Clone, Copy, Debug)]
enum Part {
    /// The ellipse whose reach along n is n·center + √Σ(n·column)²; a point when all columns are zero.
    Ellipse { center: DVec2, columns: [DVec2; 4] },
    /// A paraboloid above the level y = `from`: the dual conic, and what tells the level of a touching point.
    Cap { dual: DMat3, point_of: [DVec4; 3], from: f64 },
}

/// The hull of the parts.
#[derive(Clone, Debug)]
pub(crate) struct Hull {
    parts: Vec<Part>,
    middle: DVec2,
}

/// The projection onto the floor as rows on homogeneous points.
fn projection(lamp: Lamp) -> [DVec4; 3] {
    match lamp {
        Lamp::Sun(d) => [DVec4::new(1.0, -d.x / d.y, 0.0, 0.0), DVec4::new(0.0, -d.z / d.y, 1.0, 0.0), DVec4::W],
        Lamp::Point(l) => {
            [DVec4::new(l.y, -l.x, 0.0, 0.0), DVec4::new(0.0, -l.z, l.y, 0.0), DVec4::new(0.0, -1.0, 0.0, l.y)]
        }
    }
}

/// The dual of h(x² + z²) + r²·y − r²h/2 = 0.
fn dual_of_paraboloid(radius: f64, height: f64) -> DMat4 {
    let mut form = DMat4::from_diagonal(DVec4::new(height, 0.0, height, -radius * radius * height / 2.0));
    form.y_axis.w = radius * radius / 2.0;
    form.w_axis.y = radius * radius / 2.0;
    form.inverse()
}

impl Hull {
    /// The shadow of a convex body.
    pub(crate) fn new(caster: &Caster, lamp: Lamp) -> Option<Self> {
        let rows = projection(lamp);
        let map = DMat4::from(caster.map());
        // What a plane through L and a line of the floor is in local coordinates.
        let local_rows = rows.map(|row| map.transpose() * row);
        let ellipse = |radii: [f64; 3], y: f64| ellipse_of(&local_rows, radii, y);
        let flat = |radius: f64, y: f64| ellipse([radius, 0.0, radius], y);
        let parts = match caster.body {
            Analytic::Sphere { radius } => vec![ellipse([radius; 3], 0.0)],
            Analytic::Ellipsoid { radii } => vec![ellipse(radii, 0.0)],
            Analytic::Cylinder { radius, height } => vec![flat(radius, -height / 2.0), flat(radius, height / 2.0)],
            Analytic::Cone { radius, height } => vec![flat(radius, -height / 2.0), flat(0.0, height / 2.0)],
            Analytic::Frustum { bottom_radius, top_radius, height } => {
                vec![flat(bottom_radius, -height / 2.0), flat(top_radius, height / 2.0)]
            }
            Analytic::Capsule { radius, height } => {
                vec![ellipse([radius; 3], -height / 2.0), ellipse([radius; 3], height / 2.0)]
            }
            Analytic::Paraboloid { radius, height } => {
                let dual = dual_of_paraboloid(radius, height);
                let entry = |i: usize, j: usize| local_rows[i].dot(dual * local_rows[j]);
                let conic = DMat3::from_cols_array_2d(&std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))));
                let point_of = local_rows.map(|row| dual * row);
                let cap = Part::Cap { dual: conic, point_of, from: -height / 2.0 };
                vec![flat(radius, -height / 2.0), cap]
            }
            Analytic::Disk { radius } => vec![flat(radius, 0.0)],
            _ => return None,
        };
        let Part::Ellipse { center: middle, .. } = parts[0] else { return None };
        Some(Self { parts, middle })
    }

    /// The farthest point along n, and the part it belongs to.
    fn farthest(&self, n: DVec2) -> (usize, DVec2) {
        let candidates = self
            .parts
            .iter()
            .enumerate()
            .flat_map(|(number, part)| part.farthest(n).into_iter().flatten().map(move |point| (number, point)));
        candidates.max_by(|(_, p), (_, q)| n.dot(*p).total_cmp(&n.dot(*q))).unwrap_or((0, self.middle))
    }

    /// The border as a polygon, fine enough for its area to be right to 10^-4.
    pub(crate) fn border(&self) -> Vec<DVec2> {
        let count = 360;
        let angle = |i: u32| 2.0 * PI * f64::from(i) / f64::from(count);
        let at = |theta: f64| self.farthest(DVec2::from_angle(theta)).1;
        let mut border = Vec::new();
        for i in 0..count {
            let [a, b] = [angle(i), angle(i + 1)];
            border.push(at(a));
            self.refine([a, b], [at(a), at(b)], 8, &mut border);
        }
        border.dedup();
        border
    }

    /// Points between two angles, where the chord between the points there is off.
    fn refine(&self, [a, b]: [f64; 2], [p, q]: [DVec2; 2], depth: u32, border: &mut Vec<DVec2>) {
        let middle = (a + b) / 2.0;
        let between = self.farthest(DVec2::from_angle(middle)).1;
        let off = (between - p).dot(DVec2::from_angle(middle));
        if depth > 0 && off > 1e-5 * p.distance(self.middle) {
            self.refine([a, middle], [p, between], depth - 1, border);
            border.push(between);
            self.refine([middle, b], [between, q], depth - 1, border);
        }
    }

    /// The area.
    pub(crate) fn area(&self) -> f64 {
        let count = 2048;
        let at = |theta: f64| self.farthest(DVec2::from_angle(theta));
        let element = |theta: f64| {
            let n = DVec2::from_angle(theta);
            let p = at(theta).1 - self.middle;
            let (h, slope) = (n.dot(p), n.perp().dot(p));
            (h * h - slope * slope) / 2.0
        };
        // Where the farthest point passes from one part to another.
        let mut breaks = Vec::new();
        for i in 0..count {
            let [mut a, mut b] = [i, i + 1].map(|k| 2.0 * PI * f64::from(k) / f64::from(count));
            let first = at(a).0;
            if first != at(b).0 {
                for _ in 0..60 {
                    let middle = (a + b) / 2.0;
                    if at(middle).0 == first { a = middle } else { b = middle }
                }
                breaks.push(b);
            }
        }
        breaks.extend((0..=16).map(|k| 2.0 * PI * f64::from(k) / 16.0));
        breaks.sort_by(f64::total_cmp);
        breaks.windows(2).map(|pair| integral(element, pair[0], pair[1])).sum()
    }
}

impl Part {
    /// Points that lines across n touch; the farthest along n is among them.
    fn farthest(&self, n: DVec2) -> [Option<DVec2>; 2] {
        match self {
            Self::Ellipse { center, columns } => {
                let along: DVec2 = columns.iter().map(|&column| column * column.dot(n)).sum();
                let reach = columns.iter().map(|column| column.dot(n).powi(2)).sum::<f64>().sqrt();
                [Some(if reach > 0.0 { *center + along / reach } else { *center }), None]
            }
            Self::Cap { dual, point_of, from } => {
                // The line n·p = m touches where (n, −m) is a zero of the dual form: a − 2bm + cm² = 0.
                let n3 = DVec3::new(n.x, n.y, 0.0);
                let (a, b, c) = (n3.dot(*dual * n3), n3.dot(dual.z_axis), dual.z_axis.z);
                // Not a number where no line of this direction touches.
                let root = (b * b - a * c).sqrt();
                let large = b + root.copysign(b);
                let offsets = [a / large, large / c];
                offsets.map(|m| {
                    let line = DVec3::new(n.x, n.y, -m);
                    let touched = point_of[0] * line.x + point_of[1] * line.y + point_of[2] * line.z;
                    let image = *dual * line;
                    let is_there = m.is_finite() && touched.y / touched.w >= *from;
                    is_there.then(|| image.truncate() / image.z)
                })
            }
        }
    }
}

/// The image of the ellipsoid with these half axes about (0, y, 0); of a disk where one of them is zero.
///
/// Its dual is p·pᵀ − Σ aᵢ·aᵢᵀ with the middle p and the half axes aᵢ as homogeneous vectors, so that of the image is q·qᵀ −
/// Σ bᵢ·bᵢᵀ. With the origin at q's place: C₂₂ = q_w² − Σ b_w², centre c = −Σ b_w·b/C₂₂, S = c·cᵀ + Σ b·bᵀ/C₂₂: a sum of
/// squares, without cancellation.
fn ellipse_of(rows: &[DVec4; 3], radii: [f64; 3], y: f64) -> Part {
    let image = |v: DVec4| DVec3::from_array(rows.map(|row| row.dot(v)));
    let q = image(DVec4::new(0.0, y, 0.0, 1.0));
    let place = q.truncate() / q.z;
    let axes: [DVec3; 3] = std::array::from_fn(|i| image(DVec4::AXES[i] * radii[i]));
    let moved = axes.map(|axis| axis.truncate() - place * axis.z);
    let corner = q.z * q.z - axes.iter().map(|axis| axis.z * axis.z).sum::<f64>();
    let shift = axes.iter().zip(moved).map(|(axis, b)| b * axis.z).sum::<DVec2>() / -corner;
    let [a, b, c] = moved.map(|b| b / corner.sqrt());
    Part::Ellipse { center: place + shift, columns: [a, b, c, shift] }
}

/// The area of the ellipse that a quadric or disk throws: π·√det S, by Cauchy and Binet a sum of squares.
pub(crate) fn ellipse_area(hull: &Hull) -> Option<f64> {
    match hull.parts[..] {
        [Part::Ellipse { columns, .. }] => {
            let pairs = (0..4).flat_map(|i| (0..i).map(move |j| columns[i].perp_dot(columns[j]).powi(2)));
            Some(PI * pairs.sum::<f64>().sqrt())
        }
        _ => None,
    }
}
