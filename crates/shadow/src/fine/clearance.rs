//! What cannot block a flat face, told by floats: of what is over the box of a face in a dense mesh, most lies beside it.
//!
//! A polygon does not block a face if it lies in the face's plane or behind it, or beyond the shadow plane of one of its
//! borders, where corners on that plane count if both share them. These planes are made once a face; the exact form of the
//! same question is [`Receiver::is_clear_of`], which is asked where floats cannot tell.
//!
//! Guarantee: what is told is so (NUMERICS.md, "Clear of a face"), and the same whatever the order of the axes. Cost: some nanoseconds a corner.

use glam::DVec3;
use umbriel_geometry::{
    Point, Sign,
    predicates::{coincide, symmetric_sum},
};

use super::receiver::Receiver;

/// Covers the roundings of a determinant of three rows and of its bound, as a share of the product of the rows' sums of magnitudes.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A face as what lies over it is held against it.
pub(crate) struct Clearance<'a> {
    /// Where each border begins; the next one begins where it ends.
    corners: [&'a Point<'a>; 4],
    count: usize,
    /// What is negative beyond the borders' shadow planes, then what is negative behind the face; four each.
    planes: [Determinants; 2],
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
        let mut face = Self { corners: [a; 4], count: 0, planes: [Determinants::POSITIVE; 2] };
        for [from, to] in receiver.borders() {
            let to_light = if light.is_sun() {
                Row { entries: light.xyz(), slack: 0.0 }
            } else {
                Row::between(from, &Point::exact(light.xyz()))
            };
            face.corners[face.count] = from;
            face.set(face.count, [from, to], to_light, -facing);
            face.count += 1;
        }
        face.set(face.count, [a, b], Row::between(a, c), facing);
        Some(face)
    }

    fn set(&mut self, lane: usize, ends: [&Point; 2], second: Row, sign: f64) {
        self.planes[lane / LANES].set(lane % LANES, ends, second, sign);
    }

    /// Whether a polygon blocks no point of the face; `None` where floats cannot tell.
    #[inline]
    pub(crate) fn tells_of<'p>(&self, polygon: impl Iterator<Item = Point<'p>>) -> Option<bool> {
        // All of it beyond a plane, some of it surely not; a bit each.
        let used = (2u32 << self.count) - 1;
        let (mut beyond, mut within) = (used, 0);
        for corner in polygon {
            let place = self.place(&corner);
            beyond &= place.beyond;
            within |= place.within;
        }
        if beyond != 0 { Some(true) } else { (within & used == used).then_some(false) }
    }

    /// Where a point lies.
    #[inline(always)]
    pub(super) fn place(&self, point: &Point) -> Place {
        let (mut negative, mut positive) = self.planes[0].signs_at(point);
        if self.count == LANES {
            let (behind, before) = self.planes[1].signs_at(point);
            (negative, positive) = (negative | behind << LANES, positive | before << LANES);
        }
        let own = self.planes_through(point);
        Place { beyond: negative | own, within: positive & !own, count: self.count }
    }

    /// The borders that begin or end at a point, and the plane if one does.
    #[inline(always)]
    fn planes_through(&self, point: &Point) -> u32 {
        let mut planes = 0;
        for (number, corner) in self.corners[..self.count].iter().enumerate() {
            if coincide(corner, point) {
                let before = (if number == 0 { self.count } else { number }) - 1;
                planes |= 1 << number | 1 << before | 1 << self.count;
            }
        }
        planes
    }
}

/// Where a point lies beside a face, as far as floats tell: a bit for each border's shadow plane, then one for the face's plane.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// Beyond it, or on it as a corner of the face is.
    beyond: u32,
    /// Strictly on the side where the face is, or the light.
    within: u32,
    /// How many borders there are.
    count: usize,
}

impl Place {
    /// Whether the point is strictly before the face's plane.
    pub(super) fn is_nearer(self) -> bool {
        self.within >> self.count & 1 == 1
    }

    /// Whether the light sees the point inside of the face.
    pub(super) fn is_over(self) -> bool {
        let borders = (1 << self.count) - 1;
        self.within & borders == borders
    }

    /// Whether both points lie beyond one border or on it.
    pub(super) fn shares_outside(self, other: Self) -> bool {
        self.beyond & other.beyond & ((1 << self.count) - 1) != 0
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
        Self { entries: to.position - from.position, slack: symmetric_sum(from.slack) + symmetric_sum(to.slack) }
    }

    /// No less than the sum of the magnitudes of the true entries, but for its roundings.
    fn reach(&self) -> f64 {
        symmetric_sum(self.entries.abs()) + self.slack
    }
}

/// Planes that are looked at together.
const LANES: usize = 4;

/// Determinants of two rows and the way from a point to another one.
struct Determinants {
    from: [[f64; LANES]; 3],
    from_slack: [f64; LANES],
    normal: [[f64; LANES]; 3],
    /// The greatest errors, in parts of the third row's reach and of its slack.
    error: [f64; LANES],
    area: [f64; LANES],
}

impl Determinants {
    /// Of nothing; never negative.
    const POSITIVE: Self = Self {
        from: [[0.0; LANES]; 3],
        from_slack: [0.0; LANES],
        normal: [[0.0; LANES]; 3],
        error: [0.0; LANES],
        area: [0.0; LANES],
    };

    /// Of the row from `a` to `b`, another one, and ways from `a`, times `sign`.
    fn set(&mut self, lane: usize, [a, b]: [&Point; 2], second: Row, sign: f64) {
        let first = Row::between(a, b);
        let [m, n] = [first.reach(), second.reach()];
        let normal = first.entries.cross(second.entries) * sign;
        for k in 0..3 {
            self.from[k][lane] = a.position[k];
            self.normal[k][lane] = normal[k];
        }
        self.from_slack[lane] = symmetric_sum(a.slack);
        self.error[lane] = first.slack * n + m * second.slack + ROUNDING * m * n;
        self.area[lane] = m * n;
    }

    /// Which are surely negative at a point, and which are surely positive. Without branches: all lanes at once.
    #[inline(always)]
    fn signs_at(&self, point: &Point) -> (u32, u32) {
        let (position, point_slack) = (point.position.to_array(), symmetric_sum(point.slack));
        let (mut negative, mut positive) = ([false; LANES], [false; LANES]);
        for lane in 0..LANES {
            let [x, y, z] = [0, 1, 2].map(|k| position[k] - self.from[k][lane]);
            let slack = self.from_slack[lane] + point_slack;
            let reach = symmetric_sum(DVec3::new(x.abs(), y.abs(), z.abs())) + slack;
            let [p, q, r] = [self.normal[0][lane] * x, self.normal[1][lane] * y, self.normal[2][lane] * z];
            let value = symmetric_sum(DVec3::new(p, q, r));
            let bound = (self.error[lane] * reach + self.area[lane] * slack) * (1.0 + ROUNDING);
            (negative[lane], positive[lane]) = (value < -bound, value > bound);
        }
        (bits(negative), bits(positive))
    }
}

#[inline(always)]
fn bits(lanes: [bool; LANES]) -> u32 {
    lanes.iter().enumerate().fold(0, |bits, (lane, &is_set)| bits | u32::from(is_set) << lane)
}

#[cfg(test)]
mod tests {
    use umbriel_geometry::LightSource;

    use super::*;

    /// Whether a triangle is told to be clear of one with corners (0, 0), (4, 0), (0, 4) on the floor, by floats and exactly, under a lamp over it.
    fn told(polygon: [[f64; 3]; 3]) -> (Option<bool>, bool) {
        let points = [[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [0.0, 0.0, 0.0], [4.0, 0.0, 0.0]].map(at);
        let light = LightSource::point([1.0, 8.0, 1.0]).expect("a lamp");
        let plane = Some([points[0], points[1], points[3]]);
        let receiver = Receiver { points, light: &light, facing: Some(Sign::Positive), plane };
        let polygon = polygon.map(at);
        let clearance = Clearance::of(&receiver).expect("a flat face");
        (clearance.tells_of(polygon.iter().copied()), receiver.is_clear_of(&polygon))
    }

    fn at(position: [f64; 3]) -> Point<'static> {
        Point::exact(position.into())
    }

    #[test]
    fn what_is_behind_or_beside_is_clear() {
        let (above, below) = (1.0, -1.0);
        assert_eq!(told([[1.0, above, 1.0], [2.0, above, 1.0], [1.0, above, 2.0]]), (Some(false), false), "over it");
        assert_eq!(told([[1.0, below, 1.0], [2.0, below, 1.0], [1.0, below, 2.0]]), (Some(true), true), "under it");
        assert_eq!(told([[-1.0, above, 1.0], [-2.0, above, 1.0], [-1.0, above, 2.0]]), (Some(true), true), "beside it");
        // Both share a border, and the third corner is nearer, outside or inside.
        assert_eq!(told([[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [-1.0, above, 1.0]]), (Some(true), true));
        assert_eq!(told([[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [1.0, above, 1.0]]), (Some(false), false));
        // It stands on the border, or has a corner over it.
        assert_eq!(told([[0.0, 0.0, 1.0], [0.0, 0.0, 2.0], [-1.0, above, 1.0]]), (None, true), "exact");
        assert_eq!(
            told([[0.125, above, 1.0], [-1.0, above, 1.0], [-1.0, above, 2.0]]),
            (None, false),
            "over the border"
        );
    }
}
