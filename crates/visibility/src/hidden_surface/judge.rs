//! The one judge of all methods: does this face cover this pixel's centre, and which of two is nearer there?
//!
//! Footprints answer first, in floats with bounds. What they leave open is asked of the ray itself, whose origin and direction are
//! floats: three (four) edge signs of degree 3 and the place where it meets the plane, or the crossings of a curved body, in
//! floats with running bounds and then exactly. Depths are numbers (p + q·√d)/e and are compared by signs. So every method that asks
//! about the right candidates gets the same picture.

use glam::DVec3;
use umbriel_bvh::Ray;
use umbriel_geometry::{
    Approx, Decide, Dyadic, Facets, PlacedAnalytic, Point, Sign,
    analytic::{Crossing, Root},
    decisions::decide,
    predicates,
};

use super::{
    footprint::{Cover, Footprint},
    frame::U,
    shot::{Body, Shot},
    statistics::Statistics,
};

/// How a face lies to another one's plane, seen from the eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Before,
    Behind,
    /// In one plane.
    Within,
    /// On both sides; curved bodies count as that.
    Across,
}

/// The numbers that the judge works with, one level after the other.
trait Level: Decide {
    fn coordinates(point: &Point) -> [Self; 3];
    fn crossing(body: &PlacedAnalytic, ray: &Ray) -> Option<Option<Crossing<Self>>>;
}

impl Level for Approx {
    fn coordinates(point: &Point) -> [Self; 3] {
        point.coordinates()
    }

    fn crossing(body: &PlacedAnalytic, ray: &Ray) -> Option<Option<Crossing<Self>>> {
        body.first_crossing(body.forms(), ray.origin, ray.direction)
    }
}

impl Level for Dyadic {
    fn coordinates(point: &Point) -> [Self; 3] {
        // Corners of facets have weight one.
        point.to_exact::<Dyadic>().xyz
    }

    fn crossing(body: &PlacedAnalytic, ray: &Ray) -> Option<Option<Crossing<Self>>> {
        Some(body.first_exact_crossing(ray.origin, ray.direction))
    }
}

impl Shot {
    /// Whether a face covers the centre of a pixel.
    pub(super) fn covers(&self, face: u32, pixel: [u32; 2], work: &mut Statistics) -> bool {
        let footprint = &self.footprints[face as usize];
        work.tests += 1;
        match footprint.cover(&self.frame, pixel) {
            Cover::All => true,
            Cover::None => false,
            Cover::Doubt => {
                work.judged += 1;
                let ray = self.ray(pixel);
                let filtered = self.distance::<Approx>(footprint, &ray).map(|distance| distance.is_some());
                decide(filtered, || self.distance::<Dyadic>(footprint, &ray).flatten().is_some())
            }
        }
    }

    /// Which of two faces that both cover the centre of a pixel is seen: the nearer one, else the lower one.
    pub(super) fn is_nearer(&self, face: u32, other: u32, pixel: [u32; 2], work: &mut Statistics) -> bool {
        work.depths += 1;
        let [a, b] = [face, other].map(|face| &self.footprints[face as usize]);
        let (low, high) = self.nearness(a, pixel);
        let (other_low, other_high) = self.nearness(b, pixel);
        if low > other_high || high < other_low {
            return low > other_high;
        }
        work.judged += 1;
        if self.place(face, other) == Place::Within {
            return face < other;
        }
        let ray = self.ray(pixel);
        match decide(self.order::<Approx>(a, b, &ray).map(Some), || self.order::<Dyadic>(a, b, &ray)) {
            Some(Sign::Negative) => true,
            Some(Sign::Positive) => false,
            Some(Sign::Zero) | None => face < other,
        }
    }

    /// Puts a face into a pixel that it may cover, unless what is there is seen before it.
    pub(super) fn contest(&self, face: u32, pixel: [u32; 2], held: &mut u32, work: &mut Statistics) {
        if *held == face {
            return;
        }
        if *held != super::NOTHING && self.is_behind(face, *held, pixel) {
            work.skipped += 1;
            return;
        }
        if self.covers(face, pixel, work) && (*held == super::NOTHING || self.is_nearer(face, *held, pixel, work)) {
            *held = face;
            work.written += 1;
        }
    }

    /// Not less than the ray's parameter where it meets a face that covers the pixel; infinite where that is not known.
    ///
    /// In perspective the way along q is 1/nearness; the direction is q over its length, but for the errors of both. There is more
    /// room in it than boxes need, whose parameters are off by three roundings.
    pub(super) fn reach(&self, face: u32, pixel: [u32; 2]) -> f64 {
        let footprint = &self.footprints[face as usize];
        if footprint.plane.is_none() {
            let distance = self.distance::<Approx>(footprint, &self.ray(pixel)).flatten();
            return distance.map_or(f64::INFINITY, |distance| distance.value().upper() * (1.0 + 16.0 * U));
        }
        let (low, frame) = (self.nearness(footprint, pixel).0, &self.frame);
        if frame.is_parallel {
            return if low.is_finite() { -low } else { f64::INFINITY };
        }
        let length = DVec3::new(frame.scale * frame.x(pixel[0]), frame.scale * frame.y(pixel[1]), 1.0).length();
        if low > 0.0 { length / low * (1.0 + 2.0 * frame.unit * frame.stretch) } else { f64::INFINITY }
    }

    /// Whether a face is farther than another one at a pixel for sure, wherever it is: spares judging whether it covers.
    fn is_behind(&self, face: u32, other: u32, pixel: [u32; 2]) -> bool {
        let [a, b] = [face, other].map(|face| &self.footprints[face as usize]);
        self.nearness(a, pixel).1 < self.nearness(b, pixel).0
    }

    /// Bounds on the nearness of a face at a pixel that it covers.
    fn nearness(&self, footprint: &Footprint, [column, row]: [u32; 2]) -> (f64, f64) {
        let Some(plane) = &footprint.plane else { return (f64::NEG_INFINITY, footprint.nearest) };
        let value = plane.nearness.at(self.frame.x(column), self.frame.y(row));
        (value - plane.nearness.error, value + plane.nearness.error)
    }

    /// How a face lies to the plane of another one, by the exact sides of its corners.
    pub(super) fn place(&self, face: u32, plane: u32) -> Place {
        let [face, plane] = [face, plane].map(|face| &self.footprints[face as usize]);
        let (Body::Flat(own), Body::Flat(others)) =
            (&self.bodies[face.object as usize], &self.bodies[plane.object as usize])
        else {
            return Place::Across;
        };
        let towards_eye = others.turn(plane.face as usize, &self.eye);
        let (mut before, mut behind) = (false, false);
        for sign in sides(own, face.face as usize, others, plane.face as usize) {
            before |= sign == towards_eye;
            behind |= sign == towards_eye.flipped();
        }
        match (before, behind) {
            (true, true) => Place::Across,
            (true, false) => Place::Before,
            (false, true) => Place::Behind,
            (false, false) => Place::Within,
        }
    }

    /// The sign of one face's distance less the other's.
    fn order<T: Level>(&self, a: &Footprint, b: &Footprint, ray: &Ray) -> Option<Sign> {
        self.distance::<T>(a, ray)??.sign_of_difference(&self.distance::<T>(b, ray)??)
    }

    /// How far along the ray the face is met: `Some(None)` where it is not, `None` where signs are not known.
    fn distance<T: Level>(&self, footprint: &Footprint, ray: &Ray) -> Option<Option<Root<T>>> {
        match &self.bodies[footprint.object as usize] {
            Body::Flat(facets) => facet_distance(facets, footprint.face as usize, ray),
            Body::Curved(body) => Some(T::crossing(body, ray)?.map(|crossing| crossing.distance)),
            Body::Unknown => Some(None),
        }
    }

    /// Where the ray of a pixel crosses a curved body that covers it.
    pub(super) fn crossing(&self, body: &PlacedAnalytic, ray: &Ray) -> Option<Crossing<Approx>> {
        if let Some(known) = Approx::crossing(body, ray) {
            return known;
        }
        let exact = body.first_exact_crossing(ray.origin, ray.direction)?;
        Some(Crossing { surface: exact.surface, distance: exact.distance.to_approx() })
    }
}

/// Where the ray crosses a closed facet's plane within its edges, strictly ahead.
fn facet_distance<T: Level>(facets: &Facets, face: usize, ray: &Ray) -> Option<Option<Root<T>>> {
    let numbers = facets.facet(face).corners();
    let corner = |k: usize| T::coordinates(&facets.point(numbers[k % numbers.len()]));
    let (origin, direction) = (numbers_of::<T>(ray.origin), numbers_of::<T>(ray.direction));
    let mut side = Sign::Zero;
    for k in 0..numbers.len() {
        let (start, end) = (corner(k), corner(k + 1));
        let sign = triple(&minus(&start, &origin), &minus(&end, &start), &direction).decide()?;
        match (side, sign) {
            (_, Sign::Zero) => {}
            (Sign::Zero, sign) => side = sign,
            (side, sign) if side != sign => return Some(None),
            _ => {}
        }
    }
    let (first, second, last) = (corner(0), corner(1), corner(numbers.len() - 1));
    let [u, v] = [minus(&second, &first), minus(&last, &first)];
    let (dividend, divisor) = (triple(&u, &v, &minus(&first, &origin)), triple(&u, &v, &direction));
    if divisor.decide()? == Sign::Zero {
        return Some(None);
    }
    let distance = Root::quotient(dividend, divisor)?;
    Some((distance.sign()? == Sign::Positive).then_some(distance))
}

/// The sides of a plane on which a facet's corners lie.
fn sides(own: &Facets, face: usize, others: &Facets, plane: usize) -> impl Iterator<Item = Sign> {
    let numbers = others.facet(plane).corners();
    let [a, b, c] = [0, 1, numbers.len() - 1].map(|k| others.point(numbers[k]));
    let corners = own.facet(face).corners();
    (0..corners.len()).map(move |k| predicates::side(&a, &b, &c, &own.point(corners[k])))
}

fn numbers_of<T: Decide>(vector: DVec3) -> [T; 3] {
    vector.to_array().map(T::number)
}

fn minus<T: Decide>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    std::array::from_fn(|k| a[k].clone() - b[k].clone())
}

/// The determinant of three vectors.
fn triple<T: Decide>(a: &[T; 3], b: &[T; 3], c: &[T; 3]) -> T {
    let term = |k: usize| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        c[k].clone() * (a[i].clone() * b[j].clone() - a[j].clone() * b[i].clone())
    };
    T::sum_of_three([term(0), term(1), term(2)])
}
