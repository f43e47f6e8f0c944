//! The slack box of a point given by floats: all the points that round to it, half an ulp a coordinate.
//!
//! A point of a surface can hardly be said in floats. So a point with a normal stands for its box, and the question is
//! put to a point of a surface inside it, found exactly.

use glam::DVec3;
use umbriel_geometry::{
    Aabb, Approx, Decide, Dyadic, ExactPoint, Facets, LightSource, PlacedAnalytic, Point, Ring, Sign, Surd,
    analytic::{Part, Surface, Trim},
    blocking::Probe,
    decisions::{Level, count, decide_by_pairs},
    predicates::{Target, exact_side, side_filter},
};

use crate::query::Precision;

/// A point and half an ulp round it.
#[derive(Clone, Copy)]
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
        turn_along(facets, face, normal).times(lit_side) == Sign::Positive
    }

    /// A point of a flat face inside the box; `None` when they do not meet.
    pub(crate) fn point_on_face<'a>(&self, facets: &'a Facets, face: usize) -> Option<Probe<'a>> {
        let corners: Vec<Point<'a>> = facets.facet(face).corners().iter().map(|&corner| facets.point(corner)).collect();
        if self.certainly_misses(&corners) {
            count(Level::Double, 1);
            return None;
        }
        let exact = |corners: &[Point]| -> Vec<ExactPoint> { corners.iter().map(Point::to_exact).collect() };
        let by_pairs = || self.passage(&corners.iter().map(Point::to_pairs).collect::<Vec<_>>());
        let (slack, plane) = (*self, [corners[0], corners[1], corners[corners.len() - 1]]);
        match decide_by_pairs(None, by_pairs, || self.passage(&exact(&corners)).unwrap_or(Passage::Nowhere)) {
            Passage::Nowhere => None,
            Passage::Through(way) => Some(Probe::in_plane(self.whole(), plane, move || {
                slack.on_plane(&exact(&corners), way).flatten().expect("the way crosses the plane")
            })),
            Passage::PastAnEdge => Some(Probe::in_plane(self.whole(), plane, move || {
                slack.clip(&exact(&corners)).flatten().expect("something is left of the face")
            })),
        }
    }

    /// Whether the box is on one side of the face's plane, or beyond one of its edges, as far as floats tell.
    fn certainly_misses(&self, corners: &[Point]) -> bool {
        let [a, b, c] = [&corners[0], &corners[1], &corners[corners.len() - 1]];
        let whole = self.whole();
        if side_filter(a, b, c, Target::Point(&whole)).sign().is_some_and(|sign| sign != Sign::Zero) {
            return true;
        }
        let along = DVec3::AXES.map(|axis| LightSource::sun(axis.to_array()).expect("an axis is a direction"));
        let turns = along.map(|axis| (axis, side_filter(a, b, c, Target::Light(&axis))));
        let steepest = |(x, of_x): (LightSource, Approx), (y, of_y): (LightSource, Approx)| {
            if of_y.value.abs() > of_x.value.abs() { (y, of_y) } else { (x, of_x) }
        };
        let Some((axis, Some(turn))) = turns.into_iter().reduce(steepest).map(|(axis, turn)| (axis, turn.sign()))
        else {
            return false;
        };
        corners.iter().zip(corners.iter().cycle().skip(1)).any(|(from, to)| {
            let side = side_filter(from, to, &whole, Target::Light(&axis)).sign();
            side.is_some_and(|side| side.times(turn) == Sign::Negative)
        })
    }

    /// The box as a filter sees any point inside it.
    pub(crate) fn whole(&self) -> Point<'static> {
        Point::within(self.position, self.half)
    }

    /// How the face passes the box: it is looked for from the middle along the axes and along the box's diagonals, one of which meets
    /// its plane inside the box if any line does; where these points lie beside the face, or on its edges, the face is cut. `None` where that
    /// is not known.
    fn passage<T: Decide>(&self, corners: &[ExactPoint<T>]) -> Option<Passage> {
        // Of a face without area no line is known to pass the plane.
        let mut is_beside_plane = false;
        let mut may_be_in_plane = false;
        for way in self.ways() {
            match self.on_plane(corners, way) {
                Some(None) => {}
                Some(Some(x)) => match self.holds(&x) {
                    Some(false) => is_beside_plane = true,
                    Some(true) if lies_inside(corners, &x) == Some(true) => return Some(Passage::Through(way)),
                    _ => may_be_in_plane = true,
                },
                None => may_be_in_plane = true,
            }
        }
        if is_beside_plane && !may_be_in_plane {
            return Some(Passage::Nowhere);
        }
        Some(if self.clip(corners)?.is_some() { Passage::PastAnEdge } else { Passage::Nowhere })
    }

    fn ways(&self) -> [DVec3; 7] {
        let DVec3 { x, y, z } = self.half;
        let [a, b, c, d] = [[x, y, z], [-x, y, z], [x, -y, z], [x, y, -z]].map(DVec3::from_array);
        [DVec3::X, DVec3::Y, DVec3::Z, a, b, c, d]
    }

    /// Where the line through the middle, parallel to a vector, meets the face's plane, if it is not parallel to this. `None` where that is not known.
    fn on_plane<T: Decide>(&self, corners: &[ExactPoint<T>], way: DVec3) -> Option<Option<ExactPoint<T>>> {
        let plane = |x: &ExactPoint<T>| exact_side(&corners[0], &corners[1], &corners[corners.len() - 1], x);
        let (middle, way) = (ExactPoint::from_position(self.position), direction(way));
        let (slope, height) = (plane(&way), plane(&middle));
        let (slope, height) = match slope.decide()? {
            Sign::Zero => return Some(None),
            Sign::Positive => (slope, height),
            Sign::Negative => (-slope, -height),
        };
        // middle·slope − way·height, over the weight slope > 0.
        let at = |k: usize| middle.xyz[k].clone() * slope.clone() - way.xyz[k].clone() * height.clone();
        Some(Some(ExactPoint { xyz: std::array::from_fn(at), w: slope.clone() }))
    }

    /// The face cut by the box's six planes, one corner of what is left (Sutherland & Hodgman 1974, without rounding). `None` where that is not known.
    fn clip<T: Decide>(&self, corners: &[ExactPoint<T>]) -> Option<Option<ExactPoint<T>>> {
        let mut polygon = corners.to_vec();
        for plane in 0..6 {
            let distances: Vec<T> = polygon.iter().map(|corner| self.inside_by(corner, plane)).collect();
            let sides: Vec<Sign> = distances.iter().map(T::decide).collect::<Option<_>>()?;
            let mut kept = Vec::new();
            for (i, corner) in polygon.iter().enumerate() {
                let next = (i + 1) % polygon.len();
                if sides[i] != Sign::Negative {
                    kept.push(corner.clone());
                }
                if sides[i].times(sides[next]) == Sign::Negative {
                    let size = |k: usize| {
                        if sides[k] == Sign::Negative { -distances[k].clone() } else { distances[k].clone() }
                    };
                    kept.push(between(corner, &polygon[next], [size(next), size(i)]));
                }
            }
            polygon = kept;
        }
        Some(polygon.into_iter().next())
    }

    /// How far inside one of the box's planes a point lies, times its weight.
    fn inside_by<T: Decide>(&self, x: &ExactPoint<T>, plane: usize) -> T {
        let axis = plane / 2;
        let half = T::number(self.half[axis]);
        let offset = x.xyz[axis].clone() - x.w.clone() * T::number(self.position[axis]);
        let reach = x.w.clone() * half;
        if plane.is_multiple_of(2) { reach - offset } else { reach + offset }
    }

    /// Whether a point is in the box, if that is known.
    fn holds<T: Decide>(&self, x: &ExactPoint<T>) -> Option<bool> {
        for plane in 0..6 {
            if self.inside_by(x, plane).decide()? == Sign::Negative {
                return Some(false);
            }
        }
        Some(true)
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
        let near: Vec<&Part> = body.parts().iter().filter(|part| self.may_meet(body, part.surface)).collect();
        count(if near.is_empty() { Level::Double } else { Level::Exact }, 1);
        let mut other = None;
        for part in near {
            let lines = self.lines(body, part);
            let points = lines.iter().flat_map(|(line, surface)| points_on_line(body, *surface, line));
            for exact in points.filter(|x| self.holds(x) == Some(true) && body.part_holds(part, x)) {
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

/// How a face passes a box.
enum Passage {
    /// The line through the middle along this vector meets it inside.
    Through(DVec3),
    /// The face does not meet it.
    Nowhere,
    /// It does, past or through an edge of the face.
    PastAnEdge,
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

/// Whether a point of the plane of a convex polygon lies in the closed polygon, if that is known.
fn lies_inside<T: Decide>(corners: &[ExactPoint<T>], x: &ExactPoint<T>) -> Option<bool> {
    // Against the planes through each edge and along an axis that crosses the polygon's plane, all must agree with its turn.
    let [a, b, c] = [&corners[0], &corners[1], &corners[corners.len() - 1]];
    for axis in DVec3::AXES.map(direction) {
        let turn = exact_side(a, b, c, &axis).decide()?;
        if turn != Sign::Zero {
            for (i, corner) in corners.iter().enumerate() {
                let next = &corners[(i + 1) % corners.len()];
                if exact_side(corner, next, x, &axis).decide()?.times(turn) == Sign::Negative {
                    return Some(false);
                }
            }
            return Some(true);
        }
    }
    Some(false)
}

/// The point infinitely far away along a vector.
fn direction<T: Decide>(along: DVec3) -> ExactPoint<T> {
    ExactPoint { w: T::number(0.0), ..ExactPoint::from_position(along) }
}

/// Which way a face's corners turn as seen from far away along a vector; exact, as long as the vector is.
fn turn_along(facets: &Facets, face: usize, normal: DVec3) -> Sign {
    if let Ok(far) = LightSource::sun((-normal).to_array()) {
        return facets.turn(face, &far);
    }
    // Numbers that no light may have.
    count(Level::Exact, 1);
    let corners = facets.facet(face).corners();
    let [a, b, c] = [corners[0], corners[1], corners[corners.len() - 1]].map(|corner| facets.point(corner).to_exact());
    exact_side::<Dyadic>(&a, &b, &c, &direction(normal)).sign()
}

/// The point between two others with these weights.
fn between<T: Decide>(a: &ExactPoint<T>, b: &ExactPoint<T>, [of_a, of_b]: [T; 2]) -> ExactPoint<T> {
    let mix = |x: &T, y: &T| x.clone() * of_a.clone() + y.clone() * of_b.clone();
    ExactPoint { xyz: std::array::from_fn(|k| mix(&a.xyz[k], &b.xyz[k])), w: mix(&a.w, &b.w) }
}
