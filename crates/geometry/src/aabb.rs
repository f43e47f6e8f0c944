//! Axis-aligned bounding boxes.

use glam::DVec3;

/// A closed axis-aligned box in world coordinates, metres. Empty when `min > max` on some axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Least coordinates.
    pub min: DVec3,
    /// Greatest coordinates.
    pub max: DVec3,
}

impl Aabb {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The smallest box that holds all `points`.
    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, point| bounds.with(point))
    }

    /// The box grown to hold `point`.
    #[must_use]
    pub fn with(self, point: DVec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// The smallest box that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The box grown outward by at least `slack` on every side of every axis, rounded outward.
    #[must_use]
    pub fn widened(self, slack: DVec3) -> Self {
        let down = |v: f64, s: f64| if s == 0.0 { v } else { below(v - s) };
        let up = |v: f64, s: f64| if s == 0.0 { v } else { above(v + s) };
        let (min, max) = (self.min, self.max);
        Self {
            min: DVec3::new(down(min.x, slack.x), down(min.y, slack.y), down(min.z, slack.z)),
            max: DVec3::new(up(max.x, slack.x), up(max.y, slack.y), up(max.z, slack.z)),
        }
    }

    /// Whether the box holds no point.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Whether the closed boxes share a point.
    pub fn meets(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Whether `point` lies in the closed box.
    pub fn contains(&self, point: DVec3) -> bool {
        self.min.cmple(point).all() && point.cmple(self.max).all()
    }

    /// The eight corners: bit k of a corner's number says whether it lies at the far end of axis k.
    #[inline]
    pub fn corners(&self) -> [DVec3; 8] {
        let ends = [self.min, self.max];
        std::array::from_fn(|corner| DVec3::from_array(std::array::from_fn(|axis| ends[corner >> axis & 1][axis])))
    }

    /// The greatest magnitude of a coordinate; 0 for an empty box.
    #[inline]
    pub fn magnitude(&self) -> f64 {
        if self.is_empty() { 0.0 } else { self.min.abs().max(self.max.abs()).max_element() }
    }

    /// The middle, rounded.
    pub fn center(&self) -> DVec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Edge lengths, rounded; zero for an empty box.
    pub fn size(&self) -> DVec3 {
        if self.is_empty() { DVec3::ZERO } else { self.max - self.min }
    }

    /// Half the surface area, rounded; zero for an empty box. The measure of the surface-area heuristic.
    pub fn half_area(&self) -> f64 {
        let size = self.size();
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}

/// The next float below a rounded sum; of zero zero, since a sum that rounds to zero is zero. So no size enters that does not grow with the scene.
pub(crate) fn below(sum: f64) -> f64 {
    if sum == 0.0 { sum } else { sum.next_down() }
}

/// The next float above a rounded sum; as [`below`].
pub(crate) fn above(sum: f64) -> f64 {
    if sum == 0.0 { sum } else { sum.next_up() }
}
