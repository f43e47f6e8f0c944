//! Points of flat faces in a slack box.
//!
//! Guarantee: a point is found where the face meets the box. Cost: half a microsecond where no face does, some by pairs where one does.

use glam::DVec3;
use umbriel_geometry::{
    Approx, Decide, Dyadic, ExactPoint, Facets, LightSource, Point, Ring, Sign,
    blocking::Probe,
    decisions::{Level, count, decide_by_pairs},
    predicates::{Target, exact_side, side_filter},
};

use super::{Meaning, SlackBox};

impl Meaning<'_> {
    /// Whether a flat face is meant.
    pub(crate) fn is_of_face(&self, facets: &Facets, face: usize) -> bool {
        let turn = facets.turn(face, self.light);
        let lit_side =
            if self.is_one_sided { if facets.is_mirrored() { Sign::Negative } else { Sign::Positive } } else { turn };
        turn_along(facets, face, self.normal).times(lit_side) == Sign::Positive
    }
}

impl SlackBox {
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
