//! Bodies on a common upright axis, light straight down from a sun or from a lamp on that axis.
//!
//! The caster's shadow is a disk about the axis. On a receiver it takes away the part within that distance of the axis; a
//! sun straight above lights nothing else than what looks up.

use std::f64::consts::PI;

use umbriel_geometry::Analytic;

use super::{lit::Areas, quadrature::integral};

/// A receiver's areas when a sun straight above is hidden within the distance `hidden` of the axis, less than the
/// receiver's radius. `None` where no formula is known.
pub(crate) fn under_a_sun(receiver: &Analytic, hidden: f64) -> Option<Areas> {
    let disk = |radius: f64| PI * radius * radius;
    let ring = |radius: f64| (disk(radius) - disk(hidden)).max(0.0);
    Some(match *receiver {
        Analytic::Disk { radius } => Areas { whole: disk(radius), lit: ring(radius) },
        Analytic::Cylinder { radius, height } => {
            Areas { whole: 2.0 * disk(radius) + 2.0 * PI * radius * height, lit: ring(radius) }
        }
        Analytic::Cone { radius, height } => cone(radius, 0.0, height, hidden),
        Analytic::Frustum { bottom_radius, top_radius, height } => cone(bottom_radius, top_radius, height, hidden),
        Analytic::Sphere { radius } => Areas { whole: 4.0 * disk(radius), lit: cap_without(radius, hidden) },
        Analytic::Capsule { radius, height } => {
            Areas { whole: 4.0 * disk(radius) + 2.0 * PI * radius * height, lit: cap_without(radius, hidden) }
        }
        Analytic::Ellipsoid { radii: [a, b, c] } if a == c => {
            // x = a·sin t, y = b·cos t.
            let element = |t: f64| 2.0 * PI * a * t.sin() * (a * t.cos()).hypot(b * t.sin());
            let from = (hidden / a).asin();
            Areas { whole: 2.0 * integral(element, 0.0, PI / 2.0), lit: integral(element, from, PI / 2.0) }
        }
        Analytic::Paraboloid { radius, height } => {
            let within = |rho: f64| {
                let growth = (1.0 + (2.0 * height * rho / (radius * radius)).powi(2)).powf(1.5) - 1.0;
                PI * radius.powi(4) / (6.0 * height * height) * growth
            };
            Areas { whole: within(radius) + disk(radius), lit: within(radius) - within(hidden) }
        }
        _ => return None,
    })
}

/// Half a sphere without what lies within a distance of its axis.
fn cap_without(radius: f64, hidden: f64) -> f64 {
    2.0 * PI * radius * ((radius - hidden) * (radius + hidden)).sqrt()
}

fn cone(low: f64, high: f64, height: f64, hidden: f64) -> Areas {
    let slant = height.hypot(low - high);
    let whole = PI * (low * low + high * high + (low + high) * slant);
    let top = PI * (high * high - hidden * hidden).max(0.0);
    let inner = high.max(hidden);
    let side = if low > inner { PI * (low + inner) * (low - inner) * slant / (low - high) } else { 0.0 };
    Areas { whole, lit: top + side }
}

/// The distance from the axis that a caster about the height `y` hides on the level 0 from a lamp at the height `lamp` on
/// the axis. `None` where no formula is known.
pub(crate) fn hidden_from_lamp(caster: &Analytic, y: f64, lamp: f64) -> Option<f64> {
    let beyond = |radius: f64, level: f64| radius * lamp / (lamp - level);
    match *caster {
        Analytic::Sphere { radius } => {
            let away = lamp - y;
            Some(lamp * radius / ((away - radius) * (away + radius)).sqrt())
        }
        Analytic::Disk { radius } => Some(beyond(radius, y)),
        Analytic::Cylinder { radius, height } => Some(beyond(radius, y + height / 2.0)),
        Analytic::Cone { radius, height } => Some(beyond(radius, y - height / 2.0)),
        _ => None,
    }
}
