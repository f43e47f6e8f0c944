//! The shadow of a curved body on the plane y = 0.
//!
//! Under a sun the area of the shadow is that of the body's outline seen from the sun, divided by the sine of the sun's
//! elevation. Under a lamp a level disk throws a disk, so upright bodies with flat ends throw hulls of two disks. What is left
//! is integrated: see [`super::support`].

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use umbriel_geometry::Analytic;

use super::{
    Caster, Lamp, level,
    quadrature::integral,
    support::{Hull, ellipse_area},
};

/// A closed curve on the floor, as a fine polygon about the floor's middle, and the exact area it encloses.
#[derive(Clone, Debug)]
pub(crate) struct Shadow {
    /// The border, going round once.
    pub(crate) border: Vec<DVec2>,
    /// The area.
    pub(crate) area: f64,
}

impl Shadow {
    fn sides(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        let border = &self.border;
        (0..border.len()).map(|i| [border[i], border[(i + 1) % border.len()]])
    }

    /// The length of the border.
    pub(crate) fn border_length(&self) -> f64 {
        self.sides().map(|[a, b]| a.distance(b)).sum()
    }

    /// The distance of a point from the border.
    pub(crate) fn distance(&self, point: DVec2) -> f64 {
        let to_side = |[a, b]: [DVec2; 2]| {
            let t = ((point - a).dot(b - a) / (b - a).length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            point.distance(a + (b - a) * t)
        };
        self.sides().map(to_side).fold(f64::INFINITY, f64::min)
    }

    /// Whether a point is in the shadow, by the winding of the border; `None` within `margin` of it.
    pub(crate) fn contains(&self, point: DVec2, margin: f64) -> Option<bool> {
        let turn = |[a, b]: [DVec2; 2]| (a - point).perp_dot(b - point).atan2((a - point).dot(b - point));
        (self.distance(point) >= margin).then(|| self.sides().map(turn).sum::<f64>().abs() > PI)
    }

    /// The area of the polygon.
    pub(crate) fn polygon_area(&self) -> f64 {
        let base = self.border[0];
        self.sides().map(|[a, b]| (a - base).perp_dot(b - base)).sum::<f64>().abs() / 2.0
    }
}

/// The shadow; `None` where no formula is known.
pub(crate) fn shadow(caster: &Caster, lamp: Lamp) -> Option<Shadow> {
    if let Analytic::Hyperboloid { waist_radius, end_radius, height } = caster.body {
        return hyperboloid([waist_radius, end_radius, height], caster, lamp);
    }
    let hull = Hull::new(caster, lamp)?;
    let border = hull.border();
    let area = ellipse_area(&hull).or_else(|| closed(caster, lamp)).unwrap_or_else(|| hull.area());
    Some(Shadow { border, area })
}

/// The area where a closed form is known, for bodies that are not a single ellipsoid or disk.
pub(crate) fn closed(caster: &Caster, lamp: Lamp) -> Option<f64> {
    match lamp {
        Lamp::Sun(way) => outline(&caster.body, caster.turn.y_axis, way).map(|area| area * way.length() / way.y.abs()),
        Lamp::Point(l) if caster.is_upright() => {
            let [low, high, height] = ends(&caster.body)?;
            let scale = |y: f64| l.y / (l.y - y);
            let (k, m) = (scale(caster.center.y - height / 2.0), scale(caster.center.y + height / 2.0));
            let away = level(caster.center - l).length() * (m - k).abs();
            Some(hull_of_disks(k * low, m * high, away))
        }
        Lamp::Point(_) => None,
    }
}

/// Radii of the flat ends and the height.
fn ends(body: &Analytic) -> Option<[f64; 3]> {
    match *body {
        Analytic::Cylinder { radius, height } => Some([radius, radius, height]),
        Analytic::Cone { radius, height } => Some([radius, 0.0, height]),
        Analytic::Frustum { bottom_radius, top_radius, height } => Some([bottom_radius, top_radius, height]),
        _ => None,
    }
}

/// The hull of two disks with these radii and this distance between their centres.
pub(crate) fn hull_of_disks(a: f64, b: f64, distance: f64) -> f64 {
    flattened_hull(a.max(b), a.min(b), distance, 1.0)
}

/// The hull of two ellipses with half axes (R, R·flat) and (r, r·flat), the second `distance` away along the short axis: the
/// image of the hull of two disks. Written so that flat = 0 is no exception.
fn flattened_hull(big: f64, small: f64, distance: f64, flat: f64) -> f64 {
    let difference = (big - small) * flat;
    if distance <= difference {
        return PI * big * big * flat;
    }
    let lean = (difference / distance).asin();
    let rounded = flat * (big * big * (PI / 2.0 + lean) + small * small * (PI / 2.0 - lean));
    rounded + (big + small) * ((distance - difference) * (distance + difference)).sqrt()
}

/// The area of a body's outline seen along a direction.
fn outline(body: &Analytic, axis: DVec3, way: DVec3) -> Option<f64> {
    let way = way.normalize();
    let (along, across) = (way.dot(axis).abs(), way.cross(axis).length());
    if let Some([low, high, height]) = ends(body) {
        return Some(flattened_hull(low.max(high), low.min(high), height * across, along));
    }
    match *body {
        Analytic::Capsule { radius, height } => Some(PI * radius * radius + 2.0 * radius * height * across),
        Analytic::Paraboloid { radius, height } => Some(paraboloid_outline(radius, height, along, across)),
        _ => None,
    }
}

/// On a plane across the axis, with k = across/along: an arc of the base circle, and beyond the chord at c = r²/(2hk) a
/// segment of a parabola; the curves touch there. Seen from steeper than the rim's slope: the base alone. All times `along`.
fn paraboloid_outline(radius: f64, height: f64, along: f64, across: f64) -> f64 {
    // c/r = cos of half the angle that the parabola replaces.
    let share = radius * along / (2.0 * height * across);
    if share >= 1.0 {
        return PI * radius * radius * along;
    }
    let sine = ((1.0 - share) * (1.0 + share)).sqrt();
    let arc = radius * radius * along * (PI - share.acos() + share * sine);
    // (4/3)·A^(3/2)/B with A = r²·sin², B = r²/(kh).
    arc + 4.0 / 3.0 * radius * sine * sine * sine * height * across
}

/// Upright under a sun, upright under a lamp on the axis, or at right angles to a sun.
fn hyperboloid([waist, end, height]: [f64; 3], caster: &Caster, lamp: Lamp) -> Option<Shadow> {
    match lamp {
        Lamp::Sun(way) if caster.is_upright() => {
            let foot = level(caster.center) - level(way) * (caster.center.y / way.y);
            let shift = level(way) / -way.y;
            Some(upright_hyperboloid([waist, end, height], foot, shift))
        }
        Lamp::Point(l) if caster.is_upright() && level(l) == level(caster.center) => {
            let radius = end * l.y / (l.y - caster.center.y - height / 2.0);
            let border = circle_arc(level(l), radius, 0.0, 2.0 * PI, 720);
            Some(Shadow { border, area: PI * radius * radius })
        }
        Lamp::Sun(way) if caster.turn.y_axis.dot(way) == 0.0 => {
            let foot = level(caster.center) - level(way) * (caster.center.y / way.y);
            Some(lying_hyperboloid([waist, end, height], caster.turn.y_axis, way, foot))
        }
        _ => None,
    }
}

fn circle_arc(center: DVec2, radius: f64, from: f64, to: f64, count: u32) -> Vec<DVec2> {
    let angle = |i: u32| from + (to - from) * f64::from(i) / f64::from(count);
    (0..count).map(|i| center + DVec2::from_angle(angle(i)) * radius).collect()
}

/// The union of disks of radius ρ(y) about foot + shift·y. With β = 4(end² − waist²)/h² and k = |shift|: for k² ≤ β the
/// union of the two ends (the distance from a point is concave in y); else the ends and between them the inside of the
/// hyperbola η² = waist² + q·ξ², q = β/(k² − β), from end to end, where it touches the rims' images.
fn upright_hyperboloid([waist, end, height]: [f64; 3], foot: DVec2, shift: DVec2) -> Shadow {
    let (beta, k) = (4.0 * (end * end - waist * waist) / (height * height), shift.length());
    let along = shift.try_normalize().unwrap_or(DVec2::X);
    let reach = k * height / 2.0;
    // Where an end's circle is left: the distance from its centre towards the middle, over its radius.
    let is_steep = k * k <= beta;
    let inward = if is_steep { (reach / end).min(1.0) } else { beta * height / (2.0 * k * end) };
    let open = inward.acos();
    let segment = end * end * (PI - open + inward * (1.0 - inward * inward).sqrt());
    let from = reach - inward * end;
    let edge = |xi: f64| (waist * waist + beta / (k * k - beta) * xi * xi).sqrt();
    let between = if is_steep { 0.0 } else { 4.0 * integral(edge, 0.0, from) };
    // Half of the border, from one end of the axis to the other, in (ξ, η); the rest by symmetry.
    let mut quarter = circle_arc(DVec2::new(reach, 0.0), end, 0.0, PI - open, 360);
    if !is_steep {
        quarter.extend((0..180).map(|i| from * (1.0 - f64::from(i) / 180.0)).map(|xi| DVec2::new(xi, edge(xi))));
    }
    let half: Vec<DVec2> = quarter.iter().copied().chain(quarter.iter().rev().map(|p| DVec2::new(-p.x, p.y))).collect();
    let whole = half.iter().copied().chain(half.iter().rev().map(|p| DVec2::new(p.x, -p.y)));
    let border = whole.map(|p| foot + along * p.x + along.perp() * p.y).collect();
    Shadow { border, area: 2.0 * segment + between }
}

/// The image of the section through the axis: |across| ≤ ρ(y).
fn lying_hyperboloid([waist, end, height]: [f64; 3], axis: DVec3, way: DVec3, foot: DVec2) -> Shadow {
    let beta = 4.0 * (end * end - waist * waist) / (height * height);
    let radius = |y: f64| (waist * waist + beta * y * y).sqrt();
    let project = |v: DVec3| level(v) - level(way) * (v.y / way.y);
    let (axis_image, across) = (project(axis), project(axis.cross(way).normalize()));
    let area = 4.0 * integral(radius, 0.0, height / 2.0) * axis_image.perp_dot(across).abs();
    let levels = (0..=360).map(|i| height * (f64::from(i) / 360.0 - 0.5));
    let upper: Vec<DVec2> = levels.map(|y| DVec2::new(y, radius(y))).collect();
    let lower = upper.iter().rev().map(|p| DVec2::new(p.x, -p.y));
    let border = upper.iter().copied().chain(lower).map(|p| foot + axis_image * p.x + across * p.y).collect();
    Shadow { border, area }
}
