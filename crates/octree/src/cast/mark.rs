//! Places on a ray: the parameters at which it meets lattice planes, bounded by floats and compared exactly.

use std::cmp::Ordering;

use umbriel_geometry::{
    Dyadic, Ring, Sign,
    decisions::{Level, count},
};

use super::ray::Ray;
use crate::cube::{CELLS, Cube, difference};

/// Covers the roundings of a sum of three error terms.
const ERROR_PADDING: f64 = 1.0 + 4.0 * f64::EPSILON;

/// Below this the remainder of a division might underflow and wrongly seem to be zero: 2^-900.
const REMAINDER_LIMIT: f64 = f64::from_bits((1023 - 900) << 52);

/// A place on a ray, between two bounds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    low: f64,
    high: f64,
    at: At,
}

/// What a mark stands for.
#[derive(Clone, Copy, Debug)]
enum At {
    Plane { axis: u8, plane: u32 },
    Parameter(f64),
}

impl Mark {
    /// Before every other.
    pub(super) const BEFORE_ALL: Self = Self::parameter(f64::NEG_INFINITY);
    /// Behind every other.
    pub(super) const BEHIND_ALL: Self = Self::parameter(f64::INFINITY);

    const fn parameter(t: f64) -> Self {
        Self { low: t, high: t, at: At::Parameter(t) }
    }
}

/// The marks of one ray on the lattice of one cube.
#[derive(Clone, Copy, Debug)]
pub(super) struct Marks {
    cube: Cube,
    ray: Ray,
    first: Mark,
    last: Mark,
}

impl Marks {
    pub(super) fn new(cube: Cube, ray: Ray) -> Self {
        Self { cube, ray, first: Mark::parameter(0.0), last: Mark::parameter(ray.last) }
    }

    /// Whether the ray runs up the axis, down, or across it.
    pub(super) fn heading(&self, axis: usize) -> Ordering {
        self.ray.direction[axis].0.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
    }

    /// Where the ray's origin lies, seen from a lattice plane: exact.
    pub(super) fn side(&self, axis: usize, plane: u32) -> Ordering {
        self.cube.compare(axis, self.ray.origin[axis], plane).unwrap_or(Ordering::Equal)
    }

    /// Where the ray meets a lattice plane that it does not run along.
    pub(super) fn mark(&self, axis: usize, plane: u32) -> Mark {
        let at = At::Plane { axis: axis as u8, plane };
        let (offset, offset_error) = self.cube.offset(plane);
        let (from_min, first_error) = difference(self.cube.min()[axis], self.ray.origin[axis]);
        let (distance, second_error) = difference(from_min, -offset);
        let (along, along_error) = self.ray.direction[axis];
        // The exact distance is `distance` and these three, which are exact themselves.
        let error = (offset_error.abs() + first_error.abs() + second_error.abs()) * ERROR_PADDING;
        let t = distance / along;
        if error == 0.0 && along_error == 0.0 {
            let is_exact = distance == 0.0 || distance.abs() > REMAINDER_LIMIT && t.mul_add(-along, distance) == 0.0;
            let (low, high) = if is_exact { (t, t) } else { (t.next_down(), t.next_up()) };
            return Mark { low: low + 0.0, high: high + 0.0, at };
        }
        let distances = outward([distance - error, distance + error]);
        let slack = along_error.abs();
        let lengths = if slack == 0.0 { [along; 2] } else { outward([along - slack, along + slack]) };
        let quotients = [0, 1, 2, 3].map(|corner| distances[corner & 1] / lengths[corner >> 1]);
        let low = quotients.iter().copied().fold(f64::INFINITY, f64::min).next_down();
        let high = quotients.iter().copied().fold(f64::NEG_INFINITY, f64::max).next_up();
        Mark { low, high, at }
    }

    /// Whether the ray and the three ranges between marks have a common point: exact.
    pub(super) fn overlap(&self, near: &[Mark; 3], far: &[Mark; 3]) -> bool {
        let begins = || near.iter().chain([&self.first]);
        let ends = || far.iter().chain([&self.last]);
        let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
        let greatest = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::NEG_INFINITY, f64::max);
        if greatest(&mut begins().map(|mark| mark.high)) <= least(&mut ends().map(|mark| mark.low)) {
            return true;
        }
        if greatest(&mut begins().map(|mark| mark.low)) > least(&mut ends().map(|mark| mark.high)) {
            return false;
        }
        begins().all(|begin| ends().all(|end| self.is_not_behind(begin, end)))
    }

    /// The greatest lower bound among the beginnings and the ray's own.
    pub(super) fn enter(&self, near: &[Mark; 3]) -> f64 {
        near.iter().fold(0.0, |t, mark| t.max(mark.low))
    }

    /// The least upper bound among the ends and the ray's own.
    pub(super) fn exit(&self, far: &[Mark; 3]) -> f64 {
        far.iter().fold(self.ray.last, |t, mark| t.min(mark.high))
    }

    /// a ≤ b, exactly.
    fn is_not_behind(&self, a: &Mark, b: &Mark) -> bool {
        if a.high <= b.low {
            return true;
        }
        if a.low > b.high {
            return false;
        }
        count(Level::Exact, 1);
        let ((a, a_below), (b, b_below)) = (self.fraction(a.at), self.fraction(b.at));
        (a * b_below - b * a_below).sign() != Sign::Positive
    }

    /// The parameter as a fraction with a positive denominator. Infinite ones are decided by their bounds before.
    fn fraction(&self, at: At) -> (Dyadic, Dyadic) {
        match at {
            At::Parameter(t) => (Dyadic::new(t.clamp(f64::MIN, f64::MAX)), Dyadic::new(1.0)),
            At::Plane { axis, plane } => {
                let axis = usize::from(axis);
                let share = Dyadic::new(f64::from(plane) / f64::from(CELLS));
                let [min, edge, origin] =
                    [self.cube.min()[axis], self.cube.edge(), self.ray.origin[axis]].map(Dyadic::new);
                let (along, along_error) = self.ray.direction[axis];
                let (above, below) = (min + edge * share - origin, Dyadic::new(along) + Dyadic::new(along_error));
                if below.sign() == Sign::Negative { (-above, -below) } else { (above, below) }
            }
        }
    }
}

/// A range whose ends were rounded, one step wider.
fn outward([low, high]: [f64; 2]) -> [f64; 2] {
    [low.next_down(), high.next_up()]
}
