//! The slack box of a point given by floats: all the points that round to it, half an ulp a coordinate.
//!
//! A point of a surface can hardly be said in floats. So a point with a normal stands for its box, and the question is
//! put to a point of a surface inside it, found exactly.

use glam::DVec3;
use umbriel_geometry::{
    Aabb, Dyadic, ExactPoint, Facets, LightSource, PlacedAnalytic, Point, Ring, Sign, Surd,
    analytic::{Part, Surface, Trim},
    blocking::Probe,
    predicates::exact_side,
};

use crate::query::Precision;

/// A point and half an ulp round it.
pub(crate) struct SlackBox {
    position: DVec3,
    /// Half an ulp of each coordinate; zero for a zero coordinate.
    half: DVec3,
    /// The box, rounded outward.
    pub(crate) bounds: Aabb,
}

impl SlackBox {
    /// The box of `position`, whose coordinates came in as floats of `precision`.
    pub(crate) fn new(position: DVec3, precision: Precision) -> Self {
        let ulp = |coordinate: f64| {
            let size = coordinate.abs();
            match precision {
                _ if size == 0.0 => 0.0,
                Precision::Double => size.next_up() - size,
                Precision::Single => f64::from((size as f32).next_up()) - f64::from(size as f32),
            }
        };
        let half = DVec3::from_array(position.to_array().map(|coordinate| 0.5 * ulp(coordinate)));
        Self { position, half, bounds: Aabb { min: position, max: position }.widened(half) }
    }

    /// Whether the side of a flat face that can be lit makes an acute angle with the normal.
    pub(crate) fn is_meant(
        &self,
        facets: &Facets,
        face: usize,
        normal: DVec3,
        is_one_sided: bool,
        light: &LightSource,
    ) -> bool {
        let turn = facets.turn(face, light);
        let lit_side =
            if is_one_sided { if facets.is_mirrored() { Sign::Negative } else { Sign::Positive } } else { turn };
        // The face's normal against the given one: the face's side of a light far away along it.
        let far = LightSource::sun((-normal).to_array());
        far.is_ok_and(|far| facets.turn(face, &far).times(lit_side) == Sign::Positive)
    }

    /// A point of a flat face inside the box; `None` when they do not meet.
    pub(crate) fn point_on_face(&self, facets: &Facets, face: usize) -> Option<Probe<'static>> {
        let corners: Vec<ExactPoint> =
            facets.facet(face).corners().iter().map(|&corner| facets.point(corner).to_exact()).collect();
        let x = self.straight_to(&corners).or_else(|| self.clip(corners))?;
        Some(Probe::new(self.whole(), || x))
    }

    /// The box as a filter sees any point inside it.
    pub(crate) fn whole(&self) -> Point<'static> {
        Point::within(self.position, self.half)
    }

    /// The point of the face's plane straight above or below the middle along some axis, if it lies in the face and in
    /// the box.
    fn straight_to(&self, corners: &[ExactPoint]) -> Option<ExactPoint> {
        let plane = |x: &ExactPoint| exact_side(&corners[0], &corners[1], &corners[corners.len() - 1], x);
        let middle = ExactPoint::from_position(self.position);
        let height = plane(&middle);
        (0..3).find_map(|axis| {
            let mut direction = ExactPoint::from_position(DVec3::AXES[axis]);
            direction.w = Dyadic::zero();
            let slope = plane(&direction);
            let upward = match slope.sign() {
                Sign::Zero => return None,
                sign => sign == Sign::Positive,
            };
            // middle·slope − direction·height, over the weight slope > 0.
            let (slope, height) = if upward { (slope, height.clone()) } else { (-slope, -height.clone()) };
            let mut xyz = middle.xyz.clone().map(|coordinate| coordinate * slope.clone());
            xyz[axis] = xyz[axis].clone() - height;
            let x = ExactPoint { xyz, w: slope };
            (self.holds(&x) && lies_inside(corners, &x)).then_some(x)
        })
    }

    /// The face cut by the box's six planes, one corner of what is left (Sutherland & Hodgman 1974, in exact numbers).
    fn clip(&self, corners: Vec<ExactPoint>) -> Option<ExactPoint> {
        let mut polygon = corners;
        for plane in 0..6 {
            let inside: Vec<Dyadic> = polygon.iter().map(|corner| self.inside_by(corner, plane)).collect();
            let mut kept = Vec::new();
            for (i, corner) in polygon.iter().enumerate() {
                let next = (i + 1) % polygon.len();
                if inside[i].sign() != Sign::Negative {
                    kept.push(corner.clone());
                }
                if inside[i].sign().times(inside[next].sign()) == Sign::Negative {
                    kept.push(crossing(corner, &inside[i], &polygon[next], &inside[next]));
                }
            }
            polygon = kept;
        }
        polygon.into_iter().next()
    }

    /// How far inside one of the box's planes a point lies, times its weight.
    fn inside_by<R: Ring>(&self, x: &ExactPoint<R>, plane: usize) -> R {
        let axis = plane / 2;
        let half = R::from_f64(self.half[axis]);
        let offset = x.xyz[axis].clone() - x.w.clone() * R::from_f64(self.position[axis]);
        let reach = x.w.clone() * half;
        if plane.is_multiple_of(2) { reach - offset } else { reach + offset }
    }

    fn holds<R: Ring>(&self, x: &ExactPoint<R>) -> bool {
        (0..6).all(|plane| self.inside_by(x, plane).sign() != Sign::Negative)
    }

    /// A point of an analytic body's surface inside the box, one that `is_meant` where it can be had; and whether it is.
    ///
    /// Looks along the surface's normal through the middle and the corners of the box, along the box's edges, and along the
    /// rims: where the surface meets the box otherwise, its points are all beside the box's middle.
    pub(crate) fn point_on_analytic(
        &self,
        body: &PlacedAnalytic,
        is_meant: impl Fn(&SurfacePoint) -> bool,
    ) -> Option<(SurfacePoint, bool)> {
        let mut other = None;
        for part in body.parts().iter().filter(|part| self.may_meet(body, part.surface)) {
            let lines = self.lines(body, part);
            let points = lines.iter().flat_map(|(line, surface)| points_on_line(body, *surface, line));
            for exact in points.filter(|x| self.holds(x) && body.part_holds(part, x)) {
                let outward = body.outward(part.surface, &exact);
                let found = SurfacePoint { probe: Probe::new(self.whole(), || exact), surface: part.surface, outward };
                if is_meant(&found) {
                    return Some((found, true));
                }
                other = Some((found, false));
            }
        }
        other
    }

    /// Whether the bounds leave room for a surface to pass the box.
    fn may_meet(&self, body: &PlacedAnalytic, surface: Surface) -> bool {
        let forms = body.forms();
        let x = forms.pull_back_point(&self.whole());
        let value = match surface {
            Surface::Quadric(index) => forms.quadric(index, &x, &x),
            Surface::Plane(index) => forms.plane(index, &x),
        };
        value.sign().is_none_or(|sign| sign == Sign::Zero)
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

/// A point of a curved surface.
pub(crate) struct SurfacePoint {
    pub(crate) probe: Probe<'static, Surd>,
    pub(crate) surface: Surface,
    /// Along the outer normal, world coordinates.
    pub(crate) outward: [Surd; 3],
}

impl SurfacePoint {
    /// Whether a vector points outward (positive) or inward there.
    pub(crate) fn side_of(&self, vector: DVec3) -> Sign {
        let term = |k: usize| self.outward[k].clone() * Surd::from_f64(vector[k]);
        (term(0) + term(1) + term(2)).sign()
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

/// Whether a point of the plane of a convex polygon lies in the closed polygon.
fn lies_inside(corners: &[ExactPoint], x: &ExactPoint) -> bool {
    // Against the planes through each edge and along the normal's largest axis, all must agree with the polygon's turn.
    let [a, b, c] = [&corners[0], &corners[1], &corners[corners.len() - 1]];
    let turns = |p: &ExactPoint, q: &ExactPoint, r: &ExactPoint, axis: usize| {
        let mut direction = ExactPoint::from_position(DVec3::AXES[axis]);
        direction.w = Dyadic::zero();
        exact_side(p, q, r, &direction).sign()
    };
    let Some((axis, turn)) = (0..3).map(|axis| (axis, turns(a, b, c, axis))).find(|&(_, turn)| turn != Sign::Zero)
    else {
        return false;
    };
    (0..corners.len()).all(|i| {
        let next = &corners[(i + 1) % corners.len()];
        turns(&corners[i], next, x, axis).times(turn) != Sign::Negative
    })
}

/// The point between two corners, on different sides of a plane, where the plane is crossed.
fn crossing(a: &ExactPoint, a_inside: &Dyadic, b: &ExactPoint, b_inside: &Dyadic) -> ExactPoint {
    // a·|b_inside| + b·|a_inside|, weights included.
    let size = |value: &Dyadic| if value.sign() == Sign::Negative { -value.clone() } else { value.clone() };
    let (to_a, to_b) = (size(b_inside), size(a_inside));
    let mix = |x: &Dyadic, y: &Dyadic| x.clone() * to_a.clone() + y.clone() * to_b.clone();
    ExactPoint { xyz: std::array::from_fn(|k| mix(&a.xyz[k], &b.xyz[k])), w: mix(&a.w, &b.w) }
}
