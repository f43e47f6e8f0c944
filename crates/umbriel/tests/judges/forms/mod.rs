//! Closed forms: shadows of curved bodies on a level floor, and how much of the bodies themselves is lit.
//!
//! [`shadow`] gives areas and borders of shadows, [`lit`] lit areas of bodies that nothing else shades. Where no closed form
//! is at hand a [`quadrature`] of the formula stands in, good to some 10^-13 of the result. Derivations are in NUMERICS.md.

#![allow(dead_code, reason = "every judge uses its own part of the formulas")]

pub(crate) mod chance;
pub(crate) mod coaxial;
pub(crate) mod lit;
pub(crate) mod quadrature;
pub(crate) mod shadow;
pub(crate) mod support;

use glam::{DAffine3, DMat3, DVec2, DVec3};
use umbriel_geometry::Analytic;

/// A light as the formulas take it, relative to the middle of the floor.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Lamp {
    /// The direction the light travels.
    Sun(DVec3),
    /// The position of a point light.
    Point(DVec3),
}

impl Lamp {
    /// The light in the local coordinates of a body with this rotation and middle; of a sun its direction.
    pub(crate) fn local(self, turn: DMat3, center: DVec3) -> Self {
        match self {
            Self::Sun(way) => Self::Sun(turn.transpose() * way),
            Self::Point(position) => Self::Point(turn.transpose() * (position - center)),
        }
    }
}

/// A body over the floor: turned, then moved; coordinates relative to the middle of the floor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Caster {
    /// The body.
    pub(crate) body: Analytic,
    /// Its rotation.
    pub(crate) turn: DMat3,
    /// Its middle.
    pub(crate) center: DVec3,
}

impl Caster {
    /// The placement.
    pub(crate) fn map(&self) -> DAffine3 {
        DAffine3 { matrix3: self.turn, translation: self.center }
    }

    /// Whether its axis is upright.
    pub(crate) fn is_upright(&self) -> bool {
        self.turn.y_axis == DVec3::Y
    }
}

/// The part of a vector in the floor.
pub(crate) fn level(v: DVec3) -> DVec2 {
    DVec2::new(v.x, v.z)
}
