//! What a blocker is measured against: the corners of a flat face, or of a hull round a part of a curved one.

use umbriel_geometry::{
    Approx, LightSource, Point, Sign,
    predicates::{Target, coincide, side_filter, side_value},
};

/// Up to N points whose convex hull holds the receiver. Unused corners repeat the first one.
pub(crate) struct Receiver<'a, const N: usize> {
    pub(crate) points: [Point<'a>; N],
    pub(crate) light: &'a LightSource,
    /// For a flat face: on which side of (first, second, last corner) the light lies. `None` for a hull, whose
    /// points are only bounds: signs are then never settled by exact arithmetic.
    pub(crate) facing: Option<Sign>,
    /// Three points of the plane of a flat receiver, with exact coordinates, from where the light's side is exact.
    pub(crate) plane: Option<[Point<'a>; 3]>,
}

impl<'a> Receiver<'a, 4> {
    /// A flat face with these corners: first, second, third (of a triangle the first again), last.
    pub(crate) fn of_face(points: [Point<'a>; 4], light: &'a LightSource, facing: Sign) -> Self {
        Self { points, light, facing: Some(facing), plane: Some([points[0], points[1], points[3]]) }
    }
}

impl<const N: usize> Receiver<'_, N> {
    /// The side of a planar polygon on which each corner lies, times `sign`. Corners that the two share lie in its plane.
    pub(crate) fn sides_of_plane(&self, polygon: &[Point], sign: f64) -> [Approx; N] {
        let [a, b, c] = [&polygon[0], &polygon[1], &polygon[polygon.len() - 1]];
        self.at_corners(|point| {
            let is_shared = polygon.iter().any(|corner| coincide(corner, point));
            if is_shared { Approx::exact(0.0) } else { self.evaluate(a, b, c, Target::Point(point), sign) }
        })
    }

    /// The side of the shadow plane through the edge (a, b) on which each corner lies, times `sign`.
    pub(crate) fn sides_of_shadow_plane(&self, [a, b]: [&Point; 2], sign: f64) -> [Approx; N] {
        self.at_corners(|point| self.evaluate(a, b, point, Target::Light(self.light), sign))
    }

    /// A function at each corner; at those that repeat the first one it is copied.
    fn at_corners(&self, function: impl Fn(&Point) -> Approx) -> [Approx; N] {
        let origin = &self.points[0];
        let first = function(origin);
        std::array::from_fn(|k| {
            let point = &self.points[k];
            if k == 0 || coincide(point, origin) { first } else { function(point) }
        })
    }

    fn evaluate(&self, a: &Point, b: &Point, c: &Point, target: Target, sign: f64) -> Approx {
        let value = if self.facing.is_some() { side_value(a, b, c, target) } else { side_filter(a, b, c, target) };
        Approx { value: value.value * sign, error: value.error }
    }

    /// Whether a polygon cannot block: all of it lies in the receiver's plane or behind it, seen from the light, or it lies
    /// beside the receiver and what is over a border of this, as at a shared corner, is not nearer. Exact; `false` for a curved receiver.
    pub(crate) fn is_clear_of(&self, corners: &[Point]) -> bool {
        let Some([a, b, c]) = &self.plane else { return false };
        let side = |target: Target| Sign::of(side_value(a, b, c, target).value);
        let facing = self.facing.unwrap_or_else(|| side(Target::Light(self.light)));
        let is_own = |corner: &Point| self.facing.is_some() && self.points.iter().any(|own| coincide(own, corner));
        let is_nearer = |corner: &Point| !is_own(corner) && side(Target::Point(corner)).times(facing) == Sign::Positive;
        if !corners.iter().any(is_nearer) {
            return true;
        }
        // Of the receiver's own corners none is outside of a border.
        let is_beyond = |[from, to]: [&Point; 2]| {
            corners.iter().all(|corner| {
                let inward = Sign::of(side_value(from, to, corner, Target::Light(self.light)).value).times(facing);
                inward == Sign::Negative || (inward == Sign::Zero && !is_nearer(corner))
            })
        };
        self.facing.is_some() && self.borders().any(is_beyond)
    }

    /// The borders of a flat face; a triangle's third corner repeats its first. None if that is in doubt.
    pub(crate) fn borders(&self) -> impl Iterator<Item = [&Point<'_>; 2]> {
        let [first, third] = [0, 2].map(|k| &self.points[k]);
        let numbers: &[usize] = match coincide(first, third) {
            true => &[0, 1, 3],
            false if first.position == third.position => &[],
            false => &[0, 1, 2, 3],
        };
        let next = |k: usize| numbers[(k + 1) % numbers.len()];
        numbers.iter().enumerate().map(move |(k, &number)| [number, next(k)].map(|number| &self.points[number]))
    }
}
