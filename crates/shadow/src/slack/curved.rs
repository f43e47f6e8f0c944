//! Points of curved bodies in a slack box.
//!
//! Looked for along the half diagonals nearest to the surface's normal, which its surface crosses whenever it is known by pairs of
//! floats to pass the box; then along its normal through the middle and the corners, along the box's edges and along the rims: where
//! the surface meets the box otherwise, its points are all beside the box's middle. Cost: a microsecond or two by pairs; near rims and tips, and
//! where the surface passes a corner of the box, a tenth of a millisecond.

use glam::DVec3;
use umbriel_geometry::{
    Approx, Dyadic, ExactPoint, PlacedAnalytic, Ring, Sign, Surd,
    analytic::{Part, Surface, Trim},
    blocking::Probe,
    decisions::{Level, count},
};

use super::{Meaning, SlackBox};

/// A point of a curved surface.
pub(crate) struct SurfacePoint<'a> {
    pub(crate) probe: Probe<'a, Surd>,
    pub(crate) surface: Surface,
}

impl Meaning<'_> {
    /// Whether all points of a surface in a box are meant, or none, if floats tell.
    fn is_of_all(&self, body: &PlacedAnalytic, surface: Surface, slack: &SlackBox) -> Option<bool> {
        let whole = slack.whole();
        let lit_side = if self.is_one_sided { Sign::Positive } else { body.facing_in(surface, &whole, self.light)? };
        let outward = body.outward_in(surface, &whole);
        let term = |k: usize| outward[k] * Approx::exact(self.normal[k]);
        Some((term(0) + term(1) + term(2)).sign()?.times(lit_side) == Sign::Positive)
    }

    /// Whether a point of a curved surface is meant. Exact.
    fn is_of_point(&self, body: &PlacedAnalytic, point: &SurfacePoint) -> bool {
        let SurfacePoint { probe, surface } = point;
        let lit_side = if self.is_one_sided { Sign::Positive } else { body.facing(*surface, probe, self.light) };
        let outward = body.outward(*surface, probe.exact());
        let term = |k: usize| outward[k].clone() * Surd::from_f64(self.normal[k]);
        (term(0) + term(1) + term(2)).sign().times(lit_side) == Sign::Positive
    }
}

impl SlackBox {
    /// A point of an analytic body's surface inside the box, one that is meant where it can be had; and whether it is. Without
    /// a meaning any point is.
    pub(crate) fn point_on_analytic<'a>(
        &self,
        body: &'a PlacedAnalytic,
        meaning: Option<&Meaning>,
    ) -> Option<(SurfacePoint<'a>, bool)> {
        let mut other = None;
        for part in body.parts() {
            let found = match self.passes(body, part) {
                Some(false) => None,
                Some(true) => self.point_on_diagonal(body, part, meaning),
                None => self.point_along_lines(body, part, meaning),
            };
            match found {
                Some((_, true)) => return found,
                Some((_, false)) => other = found,
                None => {}
            }
        }
        other
    }

    /// Whether a part of the surface meets the box, where filters tell.
    fn passes(&self, body: &PlacedAnalytic, part: &Part) -> Option<bool> {
        if body.certainly_misses(part.surface, &self.whole()) {
            count(Level::Double, 1);
            return Some(false);
        }
        let by_pairs = body.passes(part, &self.whole());
        count(Level::Pair, u64::from(by_pairs.is_some()));
        by_pairs
    }

    /// A point of a part that is known to pass the box; if it is not known whether all of its points are meant, the best along all lines.
    fn point_on_diagonal<'a>(
        &self,
        body: &'a PlacedAnalytic,
        part: &Part,
        meaning: Option<&Meaning>,
    ) -> Option<(SurfacePoint<'a>, bool)> {
        let (slack, surface) = (*self, part.surface);
        let Some(is_meant) = meaning.map_or(Some(true), |meaning| meaning.is_of_all(body, surface, self)) else {
            return self.point_along_lines(body, part, meaning);
        };
        let exact = move || slack.on_diagonal(body, surface).next().expect("the surface crosses the diagonal");
        Some((SurfacePoint { probe: Probe::new(self.whole(), exact), surface }, is_meant))
    }

    /// The first point of a part that is meant, or the last one.
    fn point_along_lines<'a>(
        &self,
        body: &PlacedAnalytic,
        part: &Part,
        meaning: Option<&Meaning>,
    ) -> Option<(SurfacePoint<'a>, bool)> {
        let lines = std::iter::once_with(|| self.lines(body, part)).flatten();
        let along_lines = lines.flat_map(|(line, surface)| points_on_line(body, surface, &line));
        let mut other = None;
        for exact in self.on_diagonal(body, part.surface).chain(along_lines) {
            if self.holds(&exact) == Some(true) && body.part_holds(part, &exact) {
                let found = SurfacePoint { probe: Probe::new(self.whole(), || exact), surface: part.surface };
                if meaning.is_none_or(|meaning| meaning.is_of_point(body, &found)) {
                    return Some((found, true));
                }
                other = Some((found, false));
            }
        }
        other
    }

    /// The points of a surface, its trims left aside, on the half diagonals nearest to its normal; the middle, where it is on the surface.
    fn on_diagonal(&self, body: &PlacedAnalytic, surface: Surface) -> impl Iterator<Item = ExactPoint<Surd>> {
        let middle = ExactPoint::from_position(self.position);
        let along = body.diagonal(surface, &self.whole()).to_array().map(Dyadic::new);
        let slack = *self;
        let middle_on_it = lies_on(body, surface, &middle).then(|| middle.lifted());
        let crossings = points_on_line(body, surface, &Line { start: middle, along });
        middle_on_it.into_iter().chain(crossings).filter(move |x| slack.holds(x) == Some(true))
    }

    /// Lines to look for points of a part along, each with the surface to cross it with.
    fn lines(&self, body: &PlacedAnalytic, part: &Part) -> Vec<(Line, Surface)> {
        let corner = |i: usize| -> [Dyadic; 3] {
            std::array::from_fn(|axis| {
                let half = if i >> axis & 1 == 0 { -self.half[axis] } else { self.half[axis] };
                Dyadic::new(self.position[axis]) + Dyadic::new(half)
            })
        };
        let middle = self.position.to_array().map(Dyadic::new);
        let normal = body.outward(part.surface, &ExactPoint::from_position(self.position));
        let across = std::iter::once(middle).chain((0..8).map(corner));
        let across = across.map(|xyz| Line { start: point(xyz), along: normal.clone() });
        let edges = (0..3).flat_map(|axis| (0..8).filter(move |i| i >> axis & 1 == 0).map(move |i| (axis, i)));
        let edges = edges
            .map(|(axis, i)| Line { start: point(corner(i)), along: DVec3::AXES[axis].to_array().map(Dyadic::new) });
        let mut lines: Vec<(Line, Surface)> = across.chain(edges).map(|line| (line, part.surface)).collect();
        for &trim in &part.trims {
            let rim = match (part.surface, trim) {
                (Surface::Quadric(quadric), Trim::Above(plane) | Trim::Below(plane))
                | (Surface::Plane(plane), Trim::Inside(quadric)) => Some((quadric, plane)),
                _ => None,
            };
            lines.extend(rim.and_then(|(quadric, plane)| {
                let line = self.line_in_plane(body, quadric, plane)?;
                Some((line, Surface::Quadric(quadric)))
            }));
        }
        lines
    }

    /// The line in a plane, beside the middle of the box, along which a quadric changes most.
    fn line_in_plane(&self, body: &PlacedAnalytic, quadric: usize, plane: usize) -> Option<Line> {
        let middle = ExactPoint::from_position(self.position);
        let normal: [Dyadic; 3] = body.outward(Surface::Plane(plane), &middle);
        let gradient: [Dyadic; 3] = body.outward(Surface::Quadric(quadric), &middle);
        let dot = |a: &[Dyadic; 3], b: &[Dyadic; 3]| {
            let term = |k: usize| a[k].clone() * b[k].clone();
            term(0) + term(1) + term(2)
        };
        let (square, lean) = (dot(&normal, &normal), dot(&normal, &gradient));
        let along: [Dyadic; 3] =
            std::array::from_fn(|k| gradient[k].clone() * square.clone() - normal[k].clone() * lean.clone());
        let is_zero = along.iter().all(|coordinate| coordinate.sign() == Sign::Zero);
        let straight = Line { start: middle, along: normal };
        let start = points_on_line(body, Surface::Plane(plane), &straight).into_iter().next()?;
        let start = ExactPoint { xyz: start.xyz.map(|x| x.rational().clone()), w: start.w.rational().clone() };
        (!is_zero).then_some(Line { start, along })
    }
}

/// A line in the world: a point and a vector, not zero.
struct Line {
    start: ExactPoint,
    along: [Dyadic; 3],
}

fn point(xyz: [Dyadic; 3]) -> ExactPoint {
    ExactPoint { xyz, w: Dyadic::new(1.0) }
}

/// Whether a point lies on a surface, trims left aside.
fn lies_on(body: &PlacedAnalytic, surface: Surface, x: &ExactPoint) -> bool {
    let forms = body.exact_forms();
    forms.surface(surface, &forms.pull_back(&x.xyz, &x.w)).sign() == Sign::Zero
}

/// Where a line meets a surface of a body, trims left aside: two points at most, equal where it touches.
fn points_on_line(body: &PlacedAnalytic, surface: Surface, line: &Line) -> Vec<ExactPoint<Surd>> {
    let forms = body.exact_forms();
    let x = forms.pull_back(&line.start.xyz, &line.start.w);
    let way = forms.pull_back(&line.along, &Dyadic::zero());
    // The point start + s·along with s = step/weight, weight > 0.
    let at = |step: Surd, weight: Dyadic| {
        let xyz = std::array::from_fn(|k| {
            Surd::from(line.start.xyz[k].clone() * weight.clone()) + Surd::from(line.along[k].clone()) * step.clone()
        });
        ExactPoint { xyz, w: Surd::from(line.start.w.clone() * weight) }
    };
    let turned = |value: Dyadic, sign: Sign| if sign == Sign::Negative { -value } else { value };
    let (a, b, c) = match surface {
        Surface::Plane(index) => {
            let half = Dyadic::new(0.5);
            (Dyadic::zero(), forms.plane(index, &way) * half, forms.plane(index, &x))
        }
        Surface::Quadric(index) => {
            (forms.quadric(index, &way, &way), forms.quadric(index, &x, &way), forms.quadric(index, &x, &x))
        }
    };
    match (a.sign(), b.sign()) {
        (Sign::Zero, Sign::Zero) => Vec::new(),
        (Sign::Zero, sign) => {
            let weight = turned(b.clone() + b, sign);
            vec![at(Surd::from(turned(-c, sign)), weight)]
        }
        (sign, _) => {
            let discriminant = b.clone() * b.clone() - a.clone() * c;
            let middle = Surd::from(turned(-b, sign));
            let weight = turned(a, sign);
            match discriminant.sign() {
                Sign::Negative => Vec::new(),
                Sign::Zero => vec![at(middle, weight)],
                Sign::Positive => [-1.0, 1.0]
                    .map(|side| {
                        at(middle.clone() + Surd::root(Dyadic::new(side), discriminant.clone()), weight.clone())
                    })
                    .to_vec(),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DMat3};
    use umbriel_geometry::{Analytic, Placement, accept_point};

    use super::*;
    use crate::query::Precision;

    fn bodies() -> Vec<PlacedAnalytic> {
        let matrix = [[1.0, 0.2, 0.0, 0.1], [0.2, -0.5, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0], [0.1, 0.0, 0.0, -0.3]];
        let shapes = [
            Analytic::Sphere { radius: 1.0 },
            Analytic::Ellipsoid { radii: [0.1, 3.0, 70.0] },
            Analytic::Cylinder { radius: 0.3, height: 2.0 },
            Analytic::Cone { radius: 1.0, height: 0.7 },
            Analytic::Capsule { radius: 0.2, height: 1.1 },
            Analytic::Paraboloid { radius: 1e-3, height: 1.0 },
            Analytic::Hyperboloid { waist_radius: 0.5, end_radius: 0.8, height: 2.0 },
            Analytic::Disk { radius: 1.5 },
            Analytic::Quadric { matrix, within: [[-1.0, -2.0, -1.0], [1.0, 1.5, 2.0]] },
        ];
        let columns = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.2], [0.0, 0.1, 1.3]].map(DVec3::from_array);
        let turned = DAffine3 {
            matrix3: DMat3::from_cols(columns[0], columns[1], columns[2]),
            translation: DVec3::new(3.1, -1e4, 0.0),
        };
        let placements = [DAffine3::IDENTITY, turned].map(|map| Placement::new(map).expect("a matrix"));
        let placed =
            |shape: &Analytic| placements.map(|placement| PlacedAnalytic::new(*shape, placement).expect("a body"));
        shapes.iter().flat_map(placed).collect()
    }

    /// Floats near points of all patches, edges and corners of theirs among them.
    fn positions(body: &PlacedAnalytic) -> impl Iterator<Item = (DVec3, Precision)> {
        let parameters = [0.0, 1e-9, 0.37, 1.0];
        let near = body.charts().iter().flat_map(move |chart| {
            let places = parameters.into_iter().flat_map(move |u| parameters.map(|v| (u, v)));
            places.filter(|&(u, v)| chart.has_point(u, v)).flat_map(|(u, v)| {
                let exact = chart.bounded_point(body.placement(), u, v).position;
                let single = exact.as_vec3().as_dvec3();
                let step = |ulps: f64| (exact * (1.0 + ulps * f64::EPSILON), Precision::Double);
                [step(0.0), step(1.0), step(-3.0), (single, Precision::Single), (single * 1.000_001, Precision::Single)]
            })
        });
        near.filter(|(position, _)| accept_point(position.to_array()).is_ok())
    }

    #[test]
    fn what_pairs_tell_of_a_box_is_so() {
        let mut counts = [0; 3];
        for body in &bodies() {
            for (position, precision) in positions(body) {
                let slack = SlackBox::new(position, precision);
                for part in body.parts() {
                    let told = slack.passes(body, part);
                    let diagonal: Vec<_> = slack.on_diagonal(body, part.surface).collect();
                    let is_on_diagonal = diagonal.first().is_some_and(|x| body.part_holds(part, x));
                    match told {
                        Some(true) => assert!(is_on_diagonal, "{body:?} {position}"),
                        Some(false) => {
                            assert!(slack.point_along_lines(body, part, None).is_none(), "{body:?} {position}");
                        }
                        None => {}
                    }
                    counts[told.map_or(0, |passes| if passes { 1 } else { 2 })] += 1;
                }
            }
        }
        // In doubt are points of rims and tips.
        assert!(counts.iter().all(|&count| count > 200), "{counts:?}");
    }

    #[test]
    fn what_floats_tell_of_all_points_is_so_of_each() {
        let light = umbriel_geometry::LightSource::point([5.0, 4.0, 3.0]).expect("a lamp");
        let mut told = 0;
        for body in &bodies() {
            for (position, precision) in positions(body).step_by(7) {
                let slack = SlackBox::new(position, precision);
                for (part, is_one_sided) in body.parts().iter().flat_map(|part| [(part, true), (part, false)]) {
                    let meaning = Meaning { normal: DVec3::new(0.3, 0.5, -0.2), is_one_sided, light: &light };
                    let Some(of_all) = meaning.is_of_all(body, part.surface, &slack) else { continue };
                    let found = slack.point_along_lines(body, part, Some(&meaning));
                    assert!(found.is_none_or(|(_, is_meant)| is_meant == of_all), "{body:?} {position}");
                    told += 1;
                }
            }
        }
        assert!(told > 500, "{told}");
    }
}
