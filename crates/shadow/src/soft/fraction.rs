//! How much of an area light a point sees.
//!
//! The visible fraction is the share of a rectangle light's area, or of the directions in which a round light stands, from which
//! light reaches the point: above its horizon if its face has one side, and with nothing in between. Three ways, the
//! first that serves:
//!
//! - **Polygons.** Flat faces are projected and taken away from the light one after the other ([`Pieces`]); exact up to rounding,
//!   for every light. O(faces × pieces).
//! - **Balls.** A ball before a round light is a cap of directions before another: closed form ([`super::caps`]), for balls that do not
//!   overlap each other in front of the light.
//! - **Bounds.** Other curved bodies, and mixtures: the light is cut into [`STRATA`]² squares. One is free if no body comes near it, hidden
//!   if one convex body meets the ways to its four corners (then it meets all in between), else in doubt and decided at its middle. The
//!   squares in doubt bound the answer, and so do the polyhedra that a body lies between ([`super::between`]): what both leave is the stated bound. Where all are free or all hidden and no face has cut the light, the answer is 1 or 0 exactly.

use glam::{DVec2, DVec3};
use umbriel_geometry::{Analytic, Dyadic, ExactPoint, Facets, PlacedAnalytic, blocking::Probe};
use umbriel_scene::{Extent, Light};

use super::{
    between::{density, seen_between},
    caps::{Cap, angle, common_area},
    horizon::{height_at, least_over, over_axes},
    normal::Normal,
    occluders::{HullShaft, InShaft, in_shaft},
    polygon::{ERROR_PER_CUT, Pieces, Polygon},
    window::{Shape, Window},
};
use crate::{
    bodies::Body,
    query::{Place, Queries, QueryDefect},
};

/// Squares along an edge of the light where it must be sampled.
const STRATA: u32 = 32;

/// The share of an area light that reaches a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fraction {
    /// 0 none of it, 1 all of it.
    pub value: f64,
    /// By how much the truth may differ: rounding, or where the light is sampled the squares in doubt.
    pub max_error: f64,
}

impl Fraction {
    const NONE: Self = Self { value: 0.0, max_error: 0.0 };
    const ALL: Self = Self { value: 1.0, max_error: 0.0 };

    /// Brought between two bounds, which hold the truth as well.
    fn within(self, [least, most]: [f64; 2]) -> Self {
        let (low, high) = ((self.value - self.max_error).max(least), (self.value + self.max_error).min(most));
        if low > high {
            return self;
        }
        let value = self.value.clamp(low, high);
        Self { value, max_error: (value - low).max(high - value) + f64::EPSILON }
    }
}

/// Where a light is looked at from.
#[derive(Clone, Debug)]
pub(crate) struct Receiver<'a> {
    pub(crate) position: DVec3,
    /// Outward, if only that side can be lit.
    pub(crate) horizon: Option<Normal>,
    /// What the point lies on: in contact, so never in the way.
    own_faces: Vec<(u32, u32)>,
    /// The body it lies on, if that is wholly behind the horizon.
    own_body: Option<u32>,
    /// The body it lies on, if that may be in its own way: only exact decisions know.
    doubtful_body: Option<u32>,
    place: &'a Place,
}

/// A placed sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ball {
    pub(crate) center: DVec3,
    pub(crate) radius: f64,
}

impl Queries<'_> {
    /// The share of `light` that reaches `place`; 0 or 1 for a light without extent. A place in the plane of a rectangle light sees it
    /// edge-on, and none of it; one inside a ball of light sees nothing but light.
    ///
    /// # Errors
    /// [`QueryDefect`].
    pub fn visible_fraction(&self, place: &Place, light: &Light) -> Result<Fraction, QueryDefect> {
        // Refuses what is no place.
        let at_centre = self.lit(place, &light.source)?;
        if light.extent == Extent::Point {
            return Ok(if at_centre.lit { Fraction::ALL } else { Fraction::NONE });
        }
        let receiver = Receiver::new(self, place, at_centre.in_space)?;
        let Some(window) = Window::new(receiver.position, light) else {
            let is_inside = matches!(light.extent, Extent::Sphere { .. });
            return Ok(if is_inside { Fraction::ALL } else { Fraction::NONE });
        };
        Ok(self.seen(&receiver, &window, light))
    }

    /// The visible fraction at a receiver.
    fn seen(&self, receiver: &Receiver, window: &Window, light: &Light) -> Fraction {
        let near = in_shaft(self, &point_shaft(window, receiver));
        let left = self.left_by_faces(receiver, window, &near, light);
        if left.pieces.is_empty() {
            return Fraction { value: 0.0, max_error: left.cuts as f64 * ERROR_PER_CUT };
        }
        let bodies: Vec<u32> = near.bodies.into_iter().filter(|&body| receiver.own_body != Some(body)).collect();
        let (value, max_error) = window.share_of(&left);
        if bodies.is_empty() {
            // Nothing was cut: all of the light, exactly.
            return if left.cuts == 0 { Fraction::ALL } else { Fraction { value, max_error } };
        }
        let by_caps = || self.seen_past_balls(&bodies, window, &left, receiver);
        by_caps().unwrap_or_else(|| self.seen_by_strata(&bodies, window, &left, receiver, light))
    }

    /// What the horizon and flat faces leave of the light.
    fn left_by_faces(&self, receiver: &Receiver, window: &Window, near: &InShaft, light: &Light) -> Pieces {
        let (mut left, mut moved) = (window.whole(), 0.0_f64);
        if let Some(normal) = &receiver.horizon {
            keep_above(&mut left, normal, window, light);
        }
        for &(object, face) in &near.faces {
            if left.pieces.is_empty() {
                break;
            }
            let is_own = receiver.own_faces.contains(&(object, face));
            let Body::Flat(facets) = self.bodies.get(object as usize) else { continue };
            if is_own || receiver.is_behind(facets, face as usize) {
                continue;
            }
            if let Some((image, shift)) = window.image(corners(facets, face as usize)) {
                left.subtract(&image);
                moved += shift;
            }
        }
        // A convex outline in the square is no longer than eight: moved by as much it sweeps no more area, but for its corners.
        left.cuts += ((16.0 * moved * density(window)).min(1.0) / ERROR_PER_CUT).ceil() as u64;
        left
    }

    /// The closed form for balls before a round light of which nothing else takes a part.
    fn seen_past_balls(&self, bodies: &[u32], window: &Window, left: &Pieces, receiver: &Receiver) -> Option<Fraction> {
        let Shape::Disk { cap: light, .. } = window.shape else { return None };
        if left.cuts > 0 || receiver.doubtful_body.is_some() {
            return None;
        }
        let balls = bodies.iter().map(|&body| self.ball(body)).collect::<Option<Vec<Ball>>>()?;
        let mut caps = Vec::with_capacity(balls.len());
        for ball in balls {
            let towards = ball.center - receiver.position;
            let Some(cap) = Cap::of_ball(towards, ball.radius) else { return Some(Fraction::NONE) };
            if !window.is_before_light(towards.length(), ball.radius)? {
                continue;
            }
            if common_area(light.radius, cap.radius, light.distance(&cap)) > 0.0 {
                caps.push(cap);
            }
        }
        let is_apart = |a: &Cap, b: &Cap| angle(a.towards, b.towards) >= a.radius + b.radius;
        let all_apart = caps.iter().enumerate().all(|(k, a)| caps[..k].iter().all(|b| is_apart(a, b)));
        let shares: Vec<f64> = caps.iter().map(|cap| light.share_covered_by(cap)).collect();
        if shares.contains(&1.0) {
            return Some(Fraction::NONE);
        }
        // Thirty roundings of the closed form, of shares that are one at most.
        let max_error = caps.len() as f64 * 64.0 * f64::EPSILON;
        all_apart.then(|| Fraction { value: (1.0 - shares.iter().sum::<f64>()).max(0.0), max_error })
    }

    /// Sampled, with bounds.
    fn seen_by_strata(
        &self,
        bodies: &[u32],
        window: &Window,
        left: &Pieces,
        receiver: &Receiver,
        light: &Light,
    ) -> Fraction {
        let bounds: Vec<Ball> = bodies.iter().map(|&body| self.ball_round(body)).collect();
        let at = |k: u32| f64::from(k) * (2.0 / f64::from(STRATA)) - 1.0;
        let (mut value, mut doubt, mut is_hidden) = (0.0, 0.0, false);
        for (i, j) in (0..STRATA).flat_map(|i| (0..STRATA).map(move |j| (i, j))) {
            let (low, high) = (DVec2::new(at(i), at(j)), DVec2::new(at(i + 1), at(j + 1)));
            let square = Polygon::rectangle(low, high);
            let share: f64 = left.pieces.iter().map(|piece| window.share(&inside(piece, low, high))).sum();
            if share <= 0.0 {
                continue;
            }
            let middle = 0.5 * (low + high);
            let reach = square.0.iter().map(|&corner| angle(window.direction(corner), window.direction(middle)));
            let stratum = Cap { towards: window.direction(middle), radius: reach.fold(0.0, f64::max) };
            let near: Vec<u32> = bodies
                .iter()
                .zip(&bounds)
                .filter(|(_, ball)| ball.may_meet(&stratum, receiver.position))
                .map(|(&body, _)| body)
                .collect();
            if near.is_empty() {
                value += share;
            } else if near.iter().any(|&body| self.hides_all(body, receiver, window, &square, light)) {
                is_hidden = true;
            } else {
                doubt += share;
                let sample = window.light_point(middle, light);
                let is_lit =
                    sample.is_some_and(|sample| self.lit(receiver.place, &sample).is_ok_and(|answer| answer.lit));
                value += if is_lit { share } else { 0.0 };
            }
        }
        let by_cuts = left.cuts as f64 * ERROR_PER_CUT;
        if doubt == 0.0 && !is_hidden {
            // No body hides anything: what faces leave.
            let (value, max_error) = window.share_of(left);
            return if left.cuts == 0 { Fraction::ALL } else { Fraction { value, max_error } };
        }
        if doubt == 0.0 && value == 0.0 {
            return Fraction { value, max_error: by_cuts };
        }
        let rounding = by_cuts + f64::from(STRATA * STRATA) * 8.0 * ERROR_PER_CUT;
        let sampled = Fraction { value: value.clamp(0.0, 1.0), max_error: doubt + rounding };
        sampled.within(seen_between(self, bodies, window, left, receiver.doubtful_body))
    }

    /// Whether one convex body meets the ways to all points of a square of the light: it does if it meets those to the corners of a square
    /// that is larger by what the rounding of its corners may be.
    fn hides_all(&self, body: u32, receiver: &Receiver, window: &Window, square: &Polygon, light: &Light) -> bool {
        let Body::Analytic(placed) = self.bodies.get(body as usize) else { return false };
        let probe = Probe::<Dyadic>::at(receiver.position);
        let slack = window.rounding_of_points(light);
        let middle = 0.5 * (square.0[0] + square.0[2]);
        placed.body().is_convex()
            && receiver.doubtful_body != Some(body)
            && square.0.iter().all(|&corner| {
                let corner = corner + (corner - middle).signum() * slack;
                window.light_point(corner, light).is_some_and(|source| placed.blocks(&probe, None, &source))
            })
    }

    /// The ball that a curved body is, if it is one.
    pub(crate) fn ball(&self, body: u32) -> Option<Ball> {
        let Body::Analytic(placed) = self.bodies.get(body as usize) else { return None };
        ball_of(placed)
    }

    /// A ball round a curved body.
    fn ball_round(&self, body: u32) -> Ball {
        self.ball(body).unwrap_or_else(|| {
            let bounds = self.bodies.bounds(body as usize);
            Ball { center: bounds.center(), radius: 0.5 * bounds.size().length() * (1.0 + 8.0 * f64::EPSILON) }
        })
    }
}

impl Ball {
    /// Whether it may take something of a cap of directions from `eye`.
    fn may_meet(&self, cap: &Cap, eye: DVec3) -> bool {
        Cap::of_ball(self.center - eye, self.radius)
            .is_none_or(|own| cap.distance(&own) <= (cap.radius + own.radius) * (1.0 + f64::EPSILON * 64.0))
    }
}

/// The ball that a placed sphere is: its placement must be a similarity, column by column and exactly, as those of translations,
/// turned axes and even scales are.
pub(crate) fn ball_of(placed: &PlacedAnalytic) -> Option<Ball> {
    let Analytic::Sphere { radius } = *placed.body() else { return None };
    let map = placed.placement().map();
    let m = map.matrix3;
    let lengths = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.length_squared());
    let products = [m.x_axis.dot(m.y_axis), m.y_axis.dot(m.z_axis), m.z_axis.dot(m.x_axis)];
    // Turned by an angle, the columns are equal and at right angles up to rounding; the radius is off by as little.
    let rounding = 16.0 * f64::EPSILON * lengths[0];
    let is_similar = lengths.iter().all(|length| (length - lengths[0]).abs() <= rounding)
        && products.iter().all(|product| product.abs() <= rounding);
    is_similar.then(|| Ball { center: map.translation, radius: radius * lengths[0].sqrt() })
}

/// The corners of a flat face.
pub(crate) fn corners(facets: &Facets, face: usize) -> impl Iterator<Item = DVec3> + Clone + '_ {
    let numbers = facets.facet(face).corners();
    (0..numbers.len()).map(move |k| facets.positions()[numbers[k] as usize])
}

/// Keeps what is above a point's horizon. What is not certainly above it, nor certainly below, counts as the error of that many cuts.
fn keep_above(left: &mut Pieces, normal: &Normal, window: &Window, light: &Light) {
    let (eye, centre) = (window.eye, light.source.xyz());
    // The eye may be off the plane by its rounding; from a sun that is nothing.
    let moved = if window.end.is_finite() {
        (eye.abs() + centre.abs()) * (8.0 * f64::EPSILON * window.axes.z_axis.length() / (centre - eye).length())
    } else {
        DVec3::ZERO
    };
    let over = over_axes(normal, window, moved);
    let value = |p: DVec2| height_at(&over, p).value;
    if Polygon::square().0.iter().all(|&corner| value(corner) >= 0.0) && least_over(&window.shape, &over) >= 0.0 {
        return;
    }
    let (mut least, mut most) = (left.clone(), left.clone());
    least.keep(|p| height_at(&over, p).lower());
    most.keep(|p| height_at(&over, p).upper());
    left.keep(value);
    let doubt = window.share_of(&most).0 - window.share_of(&least).0;
    left.cuts += (doubt / ERROR_PER_CUT).ceil() as u64;
}

/// The part of a convex piece in a rectangle.
fn inside(piece: &Polygon, low: DVec2, high: DVec2) -> Polygon {
    let cut = piece.cut(|p| p.x - low.x).cut(|p| high.x - p.x);
    cut.cut(|p| p.y - low.y).cut(|p| high.y - p.y)
}

/// The pyramid of a window.
fn point_shaft(window: &Window, receiver: &Receiver) -> HullShaft {
    let mut shaft = HullShaft::unbounded();
    let square = Polygon::square();
    let middle = window.direction(DVec2::ZERO);
    for [a, b] in square.edges() {
        let normal = Normal::across(window.direction(a), window.direction(b));
        let is_inward = normal.value().dot(middle) >= 0.0;
        shaft.keep_before(window.eye, &if is_inward { normal } else { normal.flipped() });
    }
    if let Some(normal) = &receiver.horizon {
        shaft.keep_before(window.eye, normal);
    }
    if let Some((point, normal)) = window.light_plane() {
        shaft.keep_before(point, &normal);
    }
    shaft
}

impl<'a> Receiver<'a> {
    /// `in_space`: no surface was found at a point with a normal.
    fn new(queries: &Queries, place: &'a Place, in_space: bool) -> Result<Self, QueryDefect> {
        match *place {
            Place::Free { position } => Ok(Self::free(position.into(), place)),
            Place::Oriented { position, .. } if in_space => Ok(Self::free(position.into(), place)),
            Place::Oriented { position, normal, precision } => {
                let mut receiver = Self::free(position.into(), place);
                receiver.horizon = Some(Normal::exact(normal.into()));
                let touched = queries.touched(position.into(), precision);
                receiver.own_faces = touched.faces;
                touched.bodies.first().into_iter().for_each(|&body| receiver.stand_on(queries, body));
                Ok(receiver)
            }
            Place::Surface { object, face, u, v } => {
                let position = queries.position(object, face, [u, v]).ok_or(QueryDefect::OutsideFace)?;
                let mut receiver = Self::free(position, place);
                let is_one_sided = queries.bodies.is_one_sided(object, face);
                match queries.bodies.get(object) {
                    Body::Flat(facets) => {
                        receiver.own_faces.push((object as u32, face as u32));
                        receiver.horizon = is_one_sided.then(|| Normal::of_face(facets, face));
                    }
                    Body::Analytic(body) => {
                        receiver.stand_on(queries, object as u32);
                        let surface = body.charts()[face].surface;
                        let normal = body.outward(surface, &ExactPoint::<Dyadic>::from_position(position));
                        let normal = DVec3::from_array(normal.map(|value| value.to_nearest())).normalize_or_zero();
                        receiver.horizon = is_one_sided.then(|| Normal::exact(normal));
                    }
                }
                Ok(receiver)
            }
        }
    }

    fn free(position: DVec3, place: &'a Place) -> Self {
        Self { position, horizon: None, own_faces: Vec::new(), own_body: None, doubtful_body: None, place }
    }

    /// Puts the point on a curved body: a convex one with an outside only is all behind the point's horizon.
    fn stand_on(&mut self, queries: &Queries, body: u32) {
        let Body::Analytic(placed) = queries.bodies.get(body as usize) else { return };
        if placed.body().is_convex() && queries.bodies.is_one_sided(body as usize, 0) {
            self.own_body = Some(body);
        } else {
            self.doubtful_body = Some(body);
        }
    }

    /// Whether a face lies on the closed back side of the horizon for certain, or up to the rounding of the point: it then shares an edge
    /// or corner with the point's own face, or is coplanar, and cannot stand in the way.
    fn is_behind(&self, facets: &Facets, face: usize) -> bool {
        let Some(normal) = self.horizon.map(|normal| normal.value()) else { return false };
        let slack = 16.0 * f64::EPSILON;
        corners(facets, face).all(|corner| {
            let size = corner.abs() + self.position.abs();
            normal.dot(corner - self.position) <= slack * normal.abs().dot(size)
        })
    }
}
