//! Random bodies over a floor, and lights above them.

use std::f64::consts::PI;

use glam::{DMat3, DQuat, DVec3};
use umbriel_geometry::Analytic;

use super::{Caster, Lamp};
use crate::oracle::dice::Dice;

/// A kind of body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Sphere,
    Ellipsoid,
    Cylinder,
    Cone,
    Frustum,
    Capsule,
    Paraboloid,
    Hyperboloid,
    Disk,
}

impl Kind {
    /// All kinds that have formulas.
    pub(crate) const ALL: [Self; 9] = [
        Self::Sphere,
        Self::Ellipsoid,
        Self::Cylinder,
        Self::Cone,
        Self::Frustum,
        Self::Capsule,
        Self::Paraboloid,
        Self::Hyperboloid,
        Self::Disk,
    ];

    /// A body of this kind, some decimetres to metres large.
    fn any(self, dice: &mut Dice) -> Analytic {
        let mut size = || dice.float(0.2, 1.5);
        let (radius, other, height) = (size(), size(), size());
        match self {
            Self::Sphere => Analytic::Sphere { radius },
            Self::Ellipsoid => Analytic::Ellipsoid { radii: [radius, height, other] },
            Self::Cylinder => Analytic::Cylinder { radius, height },
            Self::Cone => Analytic::Cone { radius, height },
            Self::Frustum => Analytic::Frustum { bottom_radius: radius, top_radius: other, height },
            Self::Capsule => Analytic::Capsule { radius, height },
            Self::Paraboloid => Analytic::Paraboloid { radius, height },
            Self::Hyperboloid => {
                Analytic::Hyperboloid { waist_radius: radius.min(other), end_radius: radius.max(other), height }
            }
            Self::Disk => Analytic::Disk { radius },
        }
    }

    /// Whether an upright body of this kind can stand on its flat bottom.
    fn can_stand(self) -> bool {
        matches!(self, Self::Cylinder | Self::Cone | Self::Frustum | Self::Paraboloid | Self::Hyperboloid)
    }
}

/// A body over a floor at y = 0 and a light, in metres about the middle of the floor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrangement {
    /// The body.
    pub(crate) caster: Caster,
    /// The light.
    pub(crate) lamp: Lamp,
    /// Whether the body's flat bottom lies on the floor, exactly.
    pub(crate) stands: bool,
}

/// Half the height that the body takes at most.
fn half_height(body: &Analytic, upright: bool) -> f64 {
    let (across, along) = match *body {
        Analytic::Sphere { radius } => (0.0, radius),
        Analytic::Ellipsoid { radii } => (if upright { 0.0 } else { radii[0].max(radii[2]) }, radii[1]),
        Analytic::Cylinder { radius, height }
        | Analytic::Cone { radius, height }
        | Analytic::Paraboloid { radius, height } => (radius, height / 2.0),
        Analytic::Frustum { bottom_radius, top_radius, height } => (bottom_radius.max(top_radius), height / 2.0),
        Analytic::Hyperboloid { end_radius, height, .. } => (end_radius, height / 2.0),
        Analytic::Capsule { radius, height } => (0.0, radius + height / 2.0),
        Analytic::Disk { radius } => (radius, 0.0),
        _ => (0.0, 0.0),
    };
    if upright { along } else { along.hypot(across) }
}

/// A rotation about the vertical; often none, so that faces can be exactly edge-on.
pub(crate) fn random_spin(dice: &mut Dice) -> DMat3 {
    if dice.one_in(3) { DMat3::IDENTITY } else { DMat3::from_rotation_y(dice.float(-PI, PI)) }
}

fn any_turn(dice: &mut Dice) -> DMat3 {
    let mut part = || dice.float(-1.0, 1.0);
    DMat3::from_quat(DQuat::from_xyzw(part(), part(), part(), part()).normalize())
}

/// The direction of a sun that stands well above the horizon, or a lamp above the height `top`.
pub(crate) fn random_lamp(dice: &mut Dice, is_sun: bool, top: f64) -> Lamp {
    if is_sun {
        let elevation = dice.float(0.3, 1.5);
        let azimuth = if dice.one_in(4) { 0.0 } else { dice.float(-PI, PI) };
        let across = elevation.cos();
        Lamp::Sun(DVec3::new(azimuth.sin() * across, -elevation.sin(), azimuth.cos() * across))
    } else {
        Lamp::Point(DVec3::new(dice.float(-2.0, 2.0), top + dice.float(0.5, 4.0), dice.float(-2.0, 2.0)))
    }
}

/// A body of this kind with a light, such that the formulas hold.
pub(crate) fn any_arrangement(dice: &mut Dice, kind: Kind, is_sun: bool) -> Arrangement {
    let body = kind.any(dice);
    let is_hyperboloid = kind == Kind::Hyperboloid;
    let lies = is_hyperboloid && is_sun && dice.one_in(2);
    let upright = if is_hyperboloid { !lies } else { dice.one_in(2) };
    let turn = if lies {
        DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y)
    } else if upright {
        random_spin(dice)
    } else {
        any_turn(dice)
    };
    let half = half_height(&body, upright);
    let stands = upright && kind.can_stand() && dice.one_in(3);
    let gap = if stands { 0.0 } else { dice.float(0.05, 2.0) };
    let center = DVec3::new(dice.float(-1.0, 1.0), half + gap, dice.float(-1.0, 1.0));
    let lamp = match random_lamp(dice, is_sun, center.y + half) {
        Lamp::Sun(way) if lies => Lamp::Sun(DVec3::new(way.x.hypot(way.z), way.y, 0.0)),
        Lamp::Point(l) if is_hyperboloid => Lamp::Point(DVec3::new(center.x, l.y, center.z)),
        lamp => lamp,
    };
    Arrangement { caster: Caster { body, turn, center }, lamp, stands }
}
