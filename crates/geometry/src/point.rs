//! Points that are known exactly, and the floats that stand for them in filters.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use crate::{
    aabb::Aabb, approx::Approx, decide::Decide, dyadic::Dyadic, expansion::two_sum, light::LightSource, pair::Pair,
    placement::Placement, ring::Ring, surd::Surd,
};

/// A homogeneous point whose coordinates are exact, or pairs of floats with their bounds: (x, y, z)/w, w > 0; w = 0 only for a
/// direction (a sun).
#[derive(Clone, Debug)]
pub struct ExactPoint<R = Dyadic> {
    /// Homogeneous x, y, z.
    pub xyz: [R; 3],
    /// The weight.
    pub w: R,
}

impl<T: Decide> ExactPoint<T> {
    /// The point with these float coordinates.
    pub fn from_position(position: DVec3) -> Self {
        Self { xyz: position.to_array().map(T::number), w: T::number(1.0) }
    }

    /// A light's homogeneous point.
    pub fn from_light(light: &LightSource) -> Self {
        Self { xyz: light.xyz().to_array().map(T::number), w: T::number(light.w()) }
    }
}

impl ExactPoint<Surd<Pair>> {
    /// The point with these coordinates.
    pub(crate) fn of_pairs(coordinates: [Pair; 3]) -> Self {
        Self { xyz: coordinates.map(Surd::plain), w: Surd::number(1.0) }
    }
}

impl ExactPoint<Dyadic> {
    /// The point for predicates, floats and all; its weight must be one.
    pub fn bounded(&self) -> Point<'_> {
        let position = self.xyz.each_ref().map(Dyadic::to_nearest);
        let rest = std::array::from_fn(|k| (self.xyz[k].clone() - Dyadic::new(position[k])).to_nearest());
        Point::with_rest(DVec3::from_array(position), DVec3::from_array(rest), Exact::Point(self))
    }

    /// The same point over a larger ring.
    pub fn lifted<R: Ring>(&self) -> ExactPoint<R> {
        ExactPoint { xyz: self.xyz.clone().map(R::from), w: R::from(self.w.clone()) }
    }
}

/// The exact image of a local point, computed when it is first asked for: filters hardly ever do.
#[derive(Clone, Debug)]
pub struct Image {
    position: DVec3,
    rest: DVec3,
    placement: Arc<Placement>,
    local: DVec3,
    exact: OnceLock<Box<ExactPoint>>,
}

impl Image {
    pub(crate) fn new(placement: &Arc<Placement>, local: DVec3) -> Self {
        let (placement, exact) = (Arc::clone(placement), OnceLock::new());
        if let Some([position, rest]) = placement.in_two_floats(local) {
            return Self { position, rest, placement, local, exact };
        }
        let point = placement.exact(local);
        let Point { position, rest, .. } = point.bounded();
        Self { position, rest, placement, local, exact: Box::new(point).into() }
    }

    /// The point for predicates.
    #[inline]
    pub(crate) fn point(&self) -> Point<'_> {
        Point::with_rest(self.position, self.rest, Exact::Image(self))
    }
}

/// The exact point behind a float position.
#[derive(Clone, Copy, Debug)]
pub enum Exact<'a> {
    /// It is at hand.
    Point(&'a ExactPoint),
    /// It is the image of a local point.
    Image(&'a Image),
}

impl<'a> Exact<'a> {
    /// The point. An image is computed the first time: about a microsecond.
    pub fn point(self) -> &'a ExactPoint {
        match self {
            Self::Point(point) => point,
            Self::Image(Image { placement, local, exact, .. }) => {
                exact.get_or_init(|| Box::new(placement.exact(*local)))
            }
        }
    }

    /// Whether both are one and the same in memory.
    pub(crate) fn is_same(self, other: Self) -> bool {
        match (self, other) {
            (Self::Point(a), Self::Point(b)) => std::ptr::eq(a, b),
            (Self::Image(a), Self::Image(b)) => std::ptr::eq(a, b),
            _ => false,
        }
    }
}

/// A point for the predicates: a float position, how far each coordinate may be off, and the exact point when the
/// position is not it.
///
/// Far from the origin floats are coarse. What a position leaves out may be known nevertheless: that is its rest.
#[derive(Clone, Copy, Debug)]
pub struct Point<'a> {
    /// World coordinates, metres.
    pub position: DVec3,
    /// Bound on |exact − position|, per coordinate.
    pub slack: DVec3,
    /// What is known of exact − position, no greater than the slack: position + rest is off by less than slack − |rest|.
    pub rest: DVec3,
    /// The exact point; `None` means that `position` is exact.
    pub exact: Option<Exact<'a>>,
}

impl Point<'static> {
    /// A point whose float coordinates are exact.
    #[inline]
    pub fn exact(position: DVec3) -> Self {
        Self::within(position, DVec3::ZERO)
    }

    /// A point that is off by no more than `slack` along each axis.
    #[inline]
    pub fn within(position: DVec3, slack: DVec3) -> Self {
        Self { position, slack, rest: DVec3::ZERO, exact: None }
    }

    /// The point `origin` + `offset`, the offset off by no more than `slack` along each axis.
    pub(crate) fn beside(origin: DVec3, offset: DVec3, slack: DVec3) -> Self {
        let sums: [[f64; 2]; 3] = std::array::from_fn(|k| two_sum(origin[k], offset[k]));
        let [position, rest] = [0, 1].map(|part| DVec3::from_array(sums.map(|sum| sum[part])));
        // The sum is exact; only that of the bounds is rounded.
        let slack = (rest.abs() + slack) * (1.0 + 2.0 * f64::EPSILON);
        Self { position, slack, rest, exact: None }
    }
}

impl Point<'_> {
    /// A box that holds the point, rounded outward.
    pub fn bounds(&self) -> Aabb {
        Aabb::of([self.position]).widened(self.slack)
    }
}

impl<'a> Point<'a> {
    /// A float position, what it leaves out of the exact point, rounded once at most, and that point.
    #[inline]
    pub fn with_rest(position: DVec3, rest: DVec3, exact: Exact<'a>) -> Self {
        Self { position, slack: rest.abs() * (1.0 + 2.0 * f64::EPSILON), rest, exact: Some(exact) }
    }
}

impl Point<'_> {
    /// The exact point over the ring `R`.
    pub fn to_exact<R: Ring>(&self) -> ExactPoint<R> {
        match self.exact {
            Some(exact) => exact.point().lifted(),
            None => ExactPoint::from_position(self.position),
        }
    }

    /// The point in pairs of floats, with their bounds.
    pub fn to_pairs(&self) -> ExactPoint<Pair> {
        ExactPoint { xyz: Pair::of_point(self), w: Pair::exact(1.0) }
    }

    /// The way to this point from another one, as the filters see it.
    pub fn minus(&self, other: &Point) -> [Approx; 3] {
        if self.rest == DVec3::ZERO && other.rest == DVec3::ZERO {
            let (a, b) = (self.coordinates(), other.coordinates());
            return std::array::from_fn(|k| a[k] - b[k]);
        }
        std::array::from_fn(|k| {
            let way = Approx::exact(self.position[k]) - Approx::exact(other.position[k]);
            way + (self.known_rest(k) - other.known_rest(k))
        })
    }

    /// What a coordinate leaves out. The difference of the bounds is off by half an ulp of the slack.
    pub(crate) fn known_rest(&self, axis: usize) -> Approx {
        let (rest, slack) = (self.rest[axis], self.slack[axis]);
        Approx { value: rest, error: (slack - rest.abs()).max(0.0) + slack * f64::EPSILON }
    }

    /// The coordinates as the filters see them.
    pub fn coordinates(&self) -> [Approx; 3] {
        let (p, s) = (self.position, self.slack);
        [Approx { value: p.x, error: s.x }, Approx { value: p.y, error: s.y }, Approx { value: p.z, error: s.z }]
    }
}
