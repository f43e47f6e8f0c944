//! A light as a homogeneous point: one set of predicates for suns and point lights.

use glam::DVec3;

use crate::number::{AXES, NumberDefect, accept_point};

/// Why a light is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LightDefect {
    /// A coordinate outside the accepted range; axis 0, 1 or 2.
    #[error("coordinate {axis} {1}", axis = AXES[*.0])]
    Coordinate(usize, NumberDefect),
    /// A sun without a direction.
    #[error("the direction has length zero")]
    NoDirection,
}

/// Where light comes from: a homogeneous point (x, y, z, w).
///
/// w = 1 is a point light at (x, y, z) in world coordinates, metres. w = 0 is a sun; (x, y, z) then points *towards*
/// the sun (against the way the light travels) and need not be of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSource {
    xyz: DVec3,
    is_sun: bool,
}

impl LightSource {
    /// A sun whose light travels along `direction` (any length but zero).
    ///
    /// # Errors
    /// [`LightDefect`] for a zero direction or a coordinate outside the accepted range.
    pub fn sun(direction: [f64; 3]) -> Result<Self, LightDefect> {
        let direction = accept_point(direction).map_err(|(axis, defect)| LightDefect::Coordinate(axis, defect))?;
        if direction == DVec3::ZERO {
            return Err(LightDefect::NoDirection);
        }
        Ok(Self { xyz: DVec3::ZERO - direction, is_sun: true })
    }

    /// A point light at `position`, world coordinates in metres.
    ///
    /// # Errors
    /// [`LightDefect::Coordinate`] for a coordinate outside the accepted range.
    pub fn point(position: [f64; 3]) -> Result<Self, LightDefect> {
        let xyz = accept_point(position).map_err(|(axis, defect)| LightDefect::Coordinate(axis, defect))?;
        Ok(Self { xyz, is_sun: false })
    }

    /// Whether this is a sun (w = 0).
    pub fn is_sun(&self) -> bool {
        self.is_sun
    }

    /// The position of a point light, or the vector towards a sun.
    pub fn xyz(&self) -> DVec3 {
        self.xyz
    }

    /// The homogeneous weight: 0 for a sun, 1 for a point light.
    pub fn w(&self) -> f64 {
        if self.is_sun { 0.0 } else { 1.0 }
    }
}
