//! What cannot block a flat face, told by floats: of what is over the box of a face in a dense mesh, most lies beside it.
//!
//! A polygon does not block a face if it lies in the face's plane or behind it, or beyond the shadow plane of one of its
//! borders, where corners on that plane count if both share them. These planes are made once a face; the exact form of the
//! same question is [`Receiver::is_clear_of`].
//!
//! Guarantee: what is told is so (NUMERICS.md, "Clear of a face"). Cost: some nanoseconds a corner.

use glam::DVec3;
use umbriel_geometry::{Point, Sign, predicates::coincide};

use super::receiver::Receiver;

/// Covers the roundings of a determinant of three rows and of its bound, as a share of the product of the rows' sums of magnitudes.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A face as what lies over it is held against it.
pub(crate) struct Clearance<'a> {
    /// Negative behind the face.
    plane: Determinant,
    /// For each border its ends, and what is negative beyond its shadow plane.
    borders: Vec<([&'a Point<'a>; 2], Determinant)>,
}

impl<'a> Clearance<'a> {
    /// `None` for a curved receiver, and for one that is edge-on.
    pub(crate) fn of<const N: usize>(receiver: &'a Receiver<'a, N>) -> Option<Self> {
        let facing = match receiver.facing? {
            Sign::Positive => 1.0,
            Sign::Negative => -1.0,
            Sign::Zero => return None,
        };
        let ([a, b, c], light) = (receiver.plane.as_ref()?, receiver.light);
        let plane = Determinant::new([a, b], Row::between(a, c), facing);
        let shadow_plane = |ends: [&'a Point<'a>; 2]| {
            let to_light = if light.is_sun() {
                Row { entries: light.xyz(), slack: 0.0 }
            } else {
                Row::between(ends[0], &Point::exact(light.xyz()))
            };
            (ends, Determinant::new(ends, to_light, -facing))
        };
        Some(Self { plane, borders: receiver.borders().map(shadow_plane).collect() })
    }

    /// Whether a polygon surely blocks no point of the face.
    #[inline]
    pub(crate) fn tells_of<'p>(&self, polygon: impl Iterator<Item = Point<'p>> + Clone) -> bool {
        let is_own = |corner: &Point| self.borders.iter().any(|([from, _], _)| coincide(from, corner));
        let is_beyond = |(ends, border): &([&Point; 2], Determinant)| {
            polygon
                .clone()
                .all(|corner| border.is_negative_at(&corner) || ends.iter().any(|end| coincide(end, &corner)))
        };
        self.borders.iter().any(is_beyond)
            || polygon.clone().all(|corner| self.plane.is_negative_at(&corner) || is_own(&corner))
    }
}

/// A row of a determinant, and how much its entries may be off in all.
#[derive(Clone, Copy)]
struct Row {
    entries: DVec3,
    slack: f64,
}

impl Row {
    fn between(from: &Point, to: &Point) -> Self {
        Self { entries: to.position - from.position, slack: from.slack.element_sum() + to.slack.element_sum() }
    }

    /// No less than the sum of the magnitudes of the true entries, but for its roundings.
    fn reach(&self) -> f64 {
        self.entries.abs().element_sum() + self.slack
    }
}

/// The determinant of two rows and the way from a point to another one.
struct Determinant {
    from: DVec3,
    from_slack: f64,
    normal: DVec3,
    /// The greatest error, in parts of the third row's reach and of its slack.
    error: f64,
    area: f64,
}

impl Determinant {
    /// Of the row from `a` to `b`, another one, and ways from `a`, times `sign`.
    fn new([a, b]: [&Point; 2], second: Row, sign: f64) -> Self {
        let first = Row::between(a, b);
        let [m, n] = [first.reach(), second.reach()];
        Self {
            from: a.position,
            from_slack: a.slack.element_sum(),
            normal: first.entries.cross(second.entries) * sign,
            error: first.slack * n + m * second.slack + ROUNDING * m * n,
            area: m * n,
        }
    }

    #[inline(always)]
    fn is_negative_at(&self, point: &Point) -> bool {
        let way = point.position - self.from;
        let slack = self.from_slack + point.slack.element_sum();
        let reach = way.abs().element_sum() + slack;
        self.normal.dot(way) < -(self.error * reach + self.area * slack) * (1.0 + ROUNDING)
    }
}

#[cfg(test)]
mod tests {
    use umbriel_geometry::LightSource;

    use super::*;

    /// Whether a triangle is told to be clear of one with corners (0, 0), (4, 0), (0, 4) on the floor, by floats and exactly, under a lamp over it.
    fn told(polygon: [[f64; 3]; 3]) -> [bool; 2] {
        let points = [[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [0.0, 0.0, 0.0], [4.0, 0.0, 0.0]].map(at);
        let light = LightSource::point([1.0, 8.0, 1.0]).expect("a lamp");
        let plane = Some([points[0], points[1], points[3]]);
        let receiver = Receiver { points, light: &light, facing: Some(Sign::Positive), plane };
        let polygon = polygon.map(at);
        let clearance = Clearance::of(&receiver).expect("a flat face");
        [clearance.tells_of(polygon.iter().copied()), receiver.is_clear_of(&polygon)]
    }

    fn at(position: [f64; 3]) -> Point<'static> {
        Point::exact(position.into())
    }

    #[test]
    fn what_is_behind_or_beside_is_clear() {
        let (above, below) = (1.0, -1.0);
        assert_eq!(told([[1.0, above, 1.0], [2.0, above, 1.0], [1.0, above, 2.0]]), [false; 2], "over it");
        assert_eq!(told([[1.0, below, 1.0], [2.0, below, 1.0], [1.0, below, 2.0]]), [true; 2], "under it");
        assert_eq!(told([[-1.0, above, 1.0], [-2.0, above, 1.0], [-1.0, above, 2.0]]), [true; 2], "beside it");
        // Both share a border, and the third corner is nearer, outside or inside.
        assert_eq!(told([[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [-1.0, above, 1.0]]), [true; 2]);
        assert_eq!(told([[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [1.0, above, 1.0]]), [false; 2]);
        // It stands on the border, or has a corner over it.
        assert_eq!(told([[0.0, 0.0, 1.0], [0.0, 0.0, 2.0], [-1.0, above, 1.0]]), [false, true], "exact");
        assert_eq!(told([[0.125, above, 1.0], [-1.0, above, 1.0], [-1.0, above, 2.0]]), [false; 2], "over the border");
    }
}
