//! Rays and segments, exact.

use glam::DVec3;
use umbriel_geometry::{AXES, NumberDefect, accept_point};

use crate::cube::difference;

/// Why a ray is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RayDefect {
    /// A coordinate outside the accepted range; axis 0, 1 or 2.
    #[error("coordinate {axis} of a point of the ray {1}", axis = AXES[*.0])]
    Point(usize, NumberDefect),
    /// A component of the direction outside the accepted range; axis 0, 1 or 2.
    #[error("component {0} of the direction {1}")]
    Direction(usize, NumberDefect),
    /// A direction of length zero.
    #[error("the direction has length zero")]
    NoDirection,
}

/// The points `origin + t·direction` with t ≥ 0, or a segment of them; ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub(super) origin: DVec3,
    /// The direction as sums of two floats, the second below an ulp of the first.
    pub(super) direction: [(f64, f64); 3],
    pub(super) last: f64,
}

impl Ray {
    /// The ray from `origin` along `direction`, of any length but zero. Parameters count lengths of the direction.
    ///
    /// # Errors
    /// [`RayDefect`].
    pub fn new(origin: DVec3, direction: DVec3) -> Result<Self, RayDefect> {
        let origin = point(origin)?;
        let direction = accept_point(direction.to_array()).map_err(|(axis, why)| RayDefect::Direction(axis, why))?;
        if direction == DVec3::ZERO {
            return Err(RayDefect::NoDirection);
        }
        Ok(Self { origin, direction: direction.to_array().map(|along| (along, 0.0)), last: f64::INFINITY })
    }

    /// The closed segment between two points, which may be one; parameters run from 0 to 1. Its direction, the exact
    /// difference of the points, is not rounded.
    ///
    /// # Errors
    /// [`RayDefect::Point`].
    pub fn segment(from: DVec3, to: DVec3) -> Result<Self, RayDefect> {
        let (from, to) = (point(from)?, point(to)?);
        let direction = std::array::from_fn(|axis| difference(to[axis], from[axis]));
        Ok(Self { origin: from, direction, last: 1.0 })
    }
}

fn point(position: DVec3) -> Result<DVec3, RayDefect> {
    accept_point(position.to_array()).map_err(|(axis, why)| RayDefect::Point(axis, why))
}
