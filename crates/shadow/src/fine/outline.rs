//! Where a polygon's shadow can lie in the parameters of a flat face: bounds on u, v and u + v.
//!
//! These are the directions of a cell's own edges. Together with the polygon's edges they complete the separating-axis
//! test of two convex outlines in the plane, so a cell beside a sharp corner is not taken for touched. The corners of
//! the shadow are the crossings of neighbouring border lines; where they do not bound it (the shadow of a point light
//! may reach to infinity) nothing is claimed.

use umbriel_geometry::{
    Approx, Point,
    predicates::{Target, side_filter},
};

use super::{field::Field, receiver::Receiver};

/// Bounds on u, v, u + v.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ParamBox {
    pub(crate) min: [f64; 3],
    pub(crate) max: [f64; 3],
}

impl ParamBox {
    const EVERYTHING: Self = Self { min: [f64::NEG_INFINITY; 3], max: [f64::INFINITY; 3] };

    /// Holds nothing.
    pub(crate) const EMPTY: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// Grown to hold a point.
    pub(crate) fn with(&self, point: [f64; 3]) -> Self {
        self.union(&Self { min: point, max: point })
    }

    fn union(&self, other: &Self) -> Self {
        Self {
            min: std::array::from_fn(|k| self.min[k].min(other.min[k])),
            max: std::array::from_fn(|k| self.max[k].max(other.max[k])),
        }
    }

    /// Whether the closed sets cannot share a point.
    pub(crate) fn misses(&self, other: &Self) -> bool {
        (0..3).any(|k| self.max[k] < other.min[k] || other.max[k] < self.min[k])
    }

    /// Whether the interiors cannot share a point.
    pub(crate) fn misses_inside(&self, other: &Self) -> bool {
        (0..3).any(|k| self.max[k] <= other.min[k] || other.max[k] <= self.min[k])
    }
}

/// Bounds on the corners of a shadow: corner i is where sides i − 1 and i cross.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    corners: [ParamBox; 4],
    pub(crate) reach: ParamBox,
}

impl Outline {
    /// Nothing known.
    pub(crate) const UNBOUNDED: Self = Self { corners: [ParamBox::EVERYTHING; 4], reach: ParamBox::EVERYTHING };

    /// From the inner-side functions of the shadow's border on a flat face (corners: first, second, …, last); `None` where
    /// the crossings may not bound it: a shadow that reaches to infinity, or a needle.
    pub(crate) fn new<const N: usize>(sides: &[Field<N>]) -> Option<Self> {
        let lines: Vec<Line> = sides.iter().map(Line::of).collect();
        let mut corners = [ParamBox::EVERYTHING; 4];
        for i in 0..lines.len() {
            let before = (i + lines.len() - 1) % lines.len();
            let [u, v] = lines[before].crossing(&lines[i])?;
            // The shadow is bounded by its corners when each lies strictly inside all other sides.
            let mut others = (0..lines.len()).filter(|&k| k != i && k != before);
            if !others.all(|k| lines[k].at(u, v).lower() > 0.0) {
                return None;
            }
            let bounds = [u, v, u + v];
            corners[i] = ParamBox { min: bounds.map(Approx::lower), max: bounds.map(Approx::upper) };
        }
        let reach = corners[1..lines.len()].iter().fold(corners[0], |all, corner| all.union(corner));
        Some(Self { corners, reach })
    }

    /// From the corners of a polygon, each cast onto the face along the light: the shadow is in the hull of their images. The
    /// barycentric coordinates of an image are the corner's sides of the face's own shadow planes.
    pub(crate) fn of_images<const N: usize>(corners: &[Point], receiver: &Receiver<N>) -> Self {
        let [a, b, d] = [&receiver.points[0], &receiver.points[1], &receiver.points[N - 1]];
        let mut boxes = [ParamBox::EVERYTHING; 4];
        for (bounds, corner) in boxes.iter_mut().zip(corners) {
            let side = |from, to| side_filter(from, to, corner, Target::Light(receiver.light));
            let (from_a, u, v) = (side(b, d), side(d, a), side(a, b));
            let weight = from_a + u + v;
            // Another sign means that the light's ray through the corner moves away from the face.
            if weight.sign() != receiver.facing {
                return Self::UNBOUNDED;
            }
            let [u, v] = [u, v].map(|coordinate| coordinate.divided_by(weight));
            let values = [u, v, u + v];
            *bounds = ParamBox { min: values.map(Approx::lower), max: values.map(Approx::upper) };
        }
        let reach = boxes[1..corners.len()].iter().fold(boxes[0], |all, corner| all.union(corner));
        Self { corners: boxes, reach }
    }

    /// Bounds on side i of a shadow with `count` sides.
    pub(crate) fn edge(&self, side: usize, count: usize) -> ParamBox {
        self.corners[side].union(&self.corners[(side + 1) % count])
    }
}

/// A side's function as constant + along_u·u + along_v·v.
struct Line {
    constant: Approx,
    along_u: Approx,
    along_v: Approx,
}

impl Line {
    fn of<const N: usize>(side: &Field<N>) -> Self {
        let constant = side.corner(0);
        Self { constant, along_u: side.corner(1) - constant, along_v: side.corner(N - 1) - constant }
    }

    fn at(&self, u: Approx, v: Approx) -> Approx {
        self.constant + self.along_u * u + self.along_v * v
    }

    /// The parameters where both functions vanish; `None` when they may be parallel.
    fn crossing(&self, other: &Self) -> Option<[Approx; 2]> {
        let turn = self.along_u * other.along_v - self.along_v * other.along_u;
        let u = (self.along_v * other.constant - self.constant * other.along_v).divided_by(turn);
        let v = (self.constant * other.along_u - self.along_u * other.constant).divided_by(turn);
        (u.error.is_finite() && v.error.is_finite()).then_some([u, v])
    }
}
