//! How much of a body faces the light, for bodies that do not shade themselves, and for hyperboloids where that is known.
//!
//! A point x of the surface is lit when L is strictly beyond its tangent plane. On a side of revolution this is a bound on
//! the cosine of the angle φ from L's meridian: cos φ > τ, with τ constant along a cone's generatrices.

use std::f64::consts::PI;

use glam::DVec3;
use umbriel_geometry::Analytic;

use super::{
    Lamp,
    quadrature::{integral, integral_with_breaks},
};

/// Area and lit area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Areas {
    /// All of the surface.
    pub(crate) whole: f64,
    /// What faces the light.
    pub(crate) lit: f64,
}

/// A body alone under a light given in its local coordinates (a sun by the way its light travels). `None` where rounding
/// leaves open whether a flat end is turned to the light, or where no formula is known.
pub(crate) fn areas(body: &Analytic, light: Lamp) -> Option<Areas> {
    match *body {
        Analytic::Sphere { radius } => Some(ellipsoid([radius; 3], light)),
        Analytic::Ellipsoid { radii } => Some(ellipsoid(radii, light)),
        Analytic::Cylinder { radius, height } => frustum(radius, radius, height, light),
        Analytic::Cone { radius, height } => frustum(radius, 0.0, height, light),
        Analytic::Frustum { bottom_radius, top_radius, height } => frustum(bottom_radius, top_radius, height, light),
        Analytic::Capsule { radius, height } => Some(capsule(radius, height, light)),
        Analytic::Paraboloid { radius, height } => {
            let base = end(radius, height, false, light)?;
            Some(sum(&[base, paraboloid_side(radius, height, light)]))
        }
        Analytic::Hyperboloid { waist_radius, end_radius, height } => {
            hyperboloid([waist_radius, end_radius, height], light)
        }
        Analytic::Disk { radius } => {
            let whole = PI * radius * radius;
            let is_edge_on = beyond(light, 0.0)? == 0.0;
            Some(Areas { whole, lit: if is_edge_on { 0.0 } else { whole } })
        }
        _ => None,
    }
}

fn sum(parts: &[Areas]) -> Areas {
    Areas { whole: parts.iter().map(|part| part.whole).sum(), lit: parts.iter().map(|part| part.lit).sum() }
}

/// How far the light is above the level y (of a sun: how steeply above), or `None` when that is zero up to rounding only.
fn beyond(light: Lamp, y: f64) -> Option<f64> {
    let (height, size) = match light {
        Lamp::Sun(way) => (-way.y, way.length()),
        Lamp::Point(position) => (position.y - y, position.length() + y.abs()),
    };
    (height == 0.0 || height.abs() > 1e-9 * size).then_some(height)
}

/// A flat end.
fn end(radius: f64, height: f64, is_top: bool, light: Lamp) -> Option<Areas> {
    let whole = PI * radius * radius;
    let outward = if is_top { beyond(light, height / 2.0)? } else { -beyond(light, -height / 2.0)? };
    Some(Areas { whole, lit: if outward > 0.0 { whole } else { 0.0 } })
}

fn frustum(low: f64, high: f64, height: f64, light: Lamp) -> Option<Areas> {
    let bottom = end(low, height, false, light)?;
    let side = cone_side(low, high, height, light);
    let top = if high > 0.0 { end(high, height, true, light)? } else { Areas { whole: 0.0, lit: 0.0 } };
    Some(sum(&[bottom, side, top]))
}

/// The outward normal at the angle φ is (h·cos φ, low − high, h·sin φ).
fn cone_side(low: f64, high: f64, height: f64, light: Lamp) -> Areas {
    let whole = PI * (low + high) * height.hypot(low - high);
    let (bound, away) = match light {
        Lamp::Sun(way) => ((low - high) * way.y, way.x.hypot(way.z)),
        Lamp::Point(l) => (height * low - (low - high) * (l.y + height / 2.0), l.x.hypot(l.z)),
    };
    Areas { whole, lit: whole * angle(bound, height * away) / PI }
}

/// Half the angle in which scale·cos φ > bound.
fn angle(bound: f64, scale: f64) -> f64 {
    if bound >= scale {
        0.0
    } else if bound <= -scale {
        PI
    } else {
        (bound / scale).acos()
    }
}

fn capsule(radius: f64, height: f64, light: Lamp) -> Areas {
    let half_sphere = |is_upper: bool| {
        let pole = if is_upper { DVec3::Y } else { DVec3::NEG_Y };
        let (towards, share) = match light {
            Lamp::Sun(way) => (-way, 0.0),
            Lamp::Point(l) => {
                let towards = l - pole * (height / 2.0);
                (towards, radius / towards.length())
            }
        };
        let lit = radius * radius * cap_in_half_sphere(share, towards.angle_between(pole));
        Areas { whole: 2.0 * PI * radius * radius, lit }
    };
    sum(&[half_sphere(false), cone_side(radius, radius, height, light), half_sphere(true)])
}

/// On the unit sphere, the area common to a cap of angular radius acos(`share`) ≤ π/2 and the half sphere whose pole is
/// the angle γ away from the cap's.
fn cap_in_half_sphere(share: f64, gamma: f64) -> f64 {
    let (psi, reach) = (share.acos(), (1.0 - share * share).sqrt());
    if gamma + psi <= PI / 2.0 {
        2.0 * PI * (1.0 - share)
    } else if gamma >= PI / 2.0 + psi {
        0.0
    } else {
        let clamped = |cosine: f64| cosine.clamp(-1.0, 1.0).acos();
        let corner = clamped(gamma.cos() / reach);
        let along = if share == 0.0 { 0.0 } else { share * clamped(-gamma.cos() * share / (gamma.sin() * reach)) };
        2.0 * (PI - corner - along)
    }
}

/// The ellipsoid is the image of the unit sphere; the lit part is the image of a cap, and the area stretches by
/// abc·|(u_x/a, u_y/b, u_z/c)|.
fn ellipsoid(radii: [f64; 3], light: Lamp) -> Areas {
    let radii = DVec3::from_array(radii);
    let (pole, from) = match light {
        Lamp::Sun(way) => (-way / radii, 0.0),
        Lamp::Point(l) => (l / radii, 1.0 / (l / radii).length()),
    };
    let pole = pole.normalize();
    let across = pole.any_orthonormal_vector();
    let third = pole.cross(across);
    let count = 192;
    // The mean over a circle of latitude: a periodic function, so equal steps converge as fast as can be.
    let mean = |cosine: f64| {
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let stretch = |k: i32| {
            let (s, c) = (2.0 * PI * f64::from(k) / f64::from(count)).sin_cos();
            ((pole * cosine + (across * c + third * s) * sine) / radii).length()
        };
        (0..count).map(stretch).sum::<f64>() / f64::from(count)
    };
    let scale = 2.0 * PI * radii.element_product();
    let (below, above) = (scale * integral(mean, -1.0, from), scale * integral(mean, from, 1.0));
    Areas { whole: below + above, lit: above }
}

/// In rings of radius ρ: area element ρ·√(1 + (2hρ/r²)²), normal (2hρ·cos φ, r², 2hρ·sin φ).
fn paraboloid_side(radius: f64, height: f64, light: Lamp) -> Areas {
    let squared = radius * radius;
    let away = match light {
        Lamp::Sun(way) => way.x.hypot(way.z),
        Lamp::Point(l) => l.x.hypot(l.z),
    };
    let bound = |rho: f64| match light {
        Lamp::Sun(way) => squared * way.y,
        Lamp::Point(l) => height * rho * rho - squared * (l.y - height / 2.0),
    };
    let breaks: Vec<f64> = match light {
        Lamp::Sun(way) => vec![squared * way.y.abs() / (2.0 * height * away)],
        Lamp::Point(l) => {
            let root = (away * away + squared * (l.y - height / 2.0) / height).max(0.0).sqrt();
            vec![root - away, root + away, away - root]
        }
    };
    let ring = |rho: f64| rho * (1.0 + (2.0 * height * rho / squared).powi(2)).sqrt();
    let lit = |rho: f64| 2.0 * ring(rho) * angle(bound(rho), 2.0 * height * rho * away);
    let growth = (1.0 + 4.0 * height * height / squared).powf(1.5) - 1.0;
    let whole = PI * squared * squared / (6.0 * height * height) * growth;
    Areas { whole, lit: integral_with_breaks(lit, 0.0, radius, &breaks) }
}

/// A hyperboloid shades itself. Known: a light on the axis beyond an end lights that end and nothing else, since the rim
/// hides the side; a sun at right angles to the axis sees convex sections, and lights half of the side.
fn hyperboloid([waist, end, height]: [f64; 3], light: Lamp) -> Option<Areas> {
    let slope = 4.0 * (end * end - waist * waist) / (height * height);
    let ring = |y: f64| 2.0 * PI * (waist * waist + slope * (1.0 + slope) * y * y).sqrt();
    let side = 2.0 * integral(ring, 0.0, height / 2.0);
    let cap = PI * end * end;
    let lit = match light {
        Lamp::Sun(way) if way.x == 0.0 && way.z == 0.0 => cap,
        Lamp::Point(l) if l.x == 0.0 && l.z == 0.0 && l.y.abs() > height / 2.0 => cap,
        Lamp::Sun(way) if way.y == 0.0 => side / 2.0,
        _ => return None,
    };
    Some(Areas { whole: side + 2.0 * cap, lit })
}
