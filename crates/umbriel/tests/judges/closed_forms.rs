//! The bounds hold the truth: scenes whose shadows have a closed form.
//!
//! A sphere or a box hovers over a floor that holds its whole shadow, under a sun or a point light. The truth is known:
//!
//! * sphere, sun: the floor loses an ellipse of area πr²/sin(elevation); half the sphere is lit, 2πr²;
//! * sphere, point light at distance d: the floor loses the conic section of the tangent cone; a cap is lit, 2πr²(1 − r/d);
//! * box: the floor loses the convex hull of the projected corners; the faces turned to the light are lit.
//!
//! *Rounding.* Positions are rounded to floats when the scene is made, and the formulas start from these rounded
//! numbers: differences of nearby floats are exact, so a far origin costs nothing. What is left are some tens of
//! roundings in well-conditioned formulas and a rotation that is orthogonal to an ulp: 10^-12 of the area is generous.
//!
//! `UMBRIEL_CASES` sets the number of scenes.

use std::{f64::consts::PI, ops::Range};

use crate::floor::{Case, NEAR_AND_FAR, Site, judge_all};
use crate::forms::{
    Lamp,
    chance::{random_lamp, random_spin},
    level,
    lit::Areas,
    shadow::Shadow,
};
use crate::oracle::{
    Oracle, case_numbers,
    dice::Dice,
    fixtures::{cuboid, sphere},
};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use umbriel_scene::Shape;

/// What hovers over the floor.
#[derive(Clone, Copy, Debug)]
enum Caster {
    /// Its radius.
    Sphere(f64),
    /// Its edge lengths and its rotation about the vertical.
    Box(DVec3, DMat3),
}

fn ellipse(center: DVec2, along: DVec2, [major, minor]: [f64; 2]) -> Shadow {
    let along = along.try_normalize().unwrap_or(DVec2::X);
    let count = 720;
    let angles = (0..count).map(|i| 2.0 * PI * f64::from(i) / f64::from(count));
    let border = angles.map(|t| center + along * (major * t.cos()) + along.perp() * (minor * t.sin())).collect();
    Shadow { border, area: PI * major * minor }
}

/// The shadow of a sphere about `center` on the plane y = 0.
fn sphere_shadow(radius: f64, center: DVec3, lamp: Lamp) -> Shadow {
    match lamp {
        Lamp::Sun(d) => {
            let foot = level(center) - level(d) * (center.y / d.y);
            ellipse(foot, level(d), [radius * d.length() / -d.y, radius])
        }
        Lamp::Point(l) => {
            // The cone from L about the axis to the centre, half angle α, cut by a plane at distance l.y whose normal
            // makes the angle β with the axis. With q = cos²β − sin²α: half axes l.y·sinα·cosα/q and l.y·sinα/√q, middle
            // l.y·sinβ·cosβ/q from the foot of L.
            let axis = center - l;
            let (sin_a, cos_b) = (radius / axis.length(), -axis.y / axis.length());
            let cos_a = (1.0 - sin_a * sin_a).sqrt();
            let sin_b = level(axis).length() / axis.length();
            let q = (cos_b - sin_a) * (cos_b + sin_a);
            let along = level(axis).try_normalize().unwrap_or(DVec2::X);
            let middle = level(l) + along * (l.y * sin_b * cos_b / q);
            ellipse(middle, along, [l.y * sin_a * cos_a / q, l.y * sin_a / q.sqrt()])
        }
    }
}

/// The shadow of a box on the plane y = 0.
fn box_shadow(size: DVec3, spin: DMat3, center: DVec3, lamp: Lamp) -> Shadow {
    let sign = |i: usize, bit: usize| if i >> bit & 1 == 0 { -0.5 } else { 0.5 };
    let corners = (0..8).map(|i| center + spin * (size * DVec3::new(sign(i, 0), sign(i, 1), sign(i, 2))));
    let project = |p: DVec3| match lamp {
        Lamp::Sun(d) => level(p) - level(d) * (p.y / d.y),
        Lamp::Point(l) => level(l) + (level(p) - level(l)) * (l.y / (l.y - p.y)),
    };
    let border = convex_hull(corners.map(project).collect());
    let base = border[0];
    let area = border.windows(2).map(|pair| (pair[0] - base).perp_dot(pair[1] - base)).sum::<f64>() / 2.0;
    Shadow { border, area }
}

/// The counter-clockwise hull by Andrew's monotone chains. Corners that rounding puts on the wrong side of an edge
/// change the area by less than the roundings of the formula do.
fn convex_hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let chain = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp_dot(p - a) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    hull
}

/// Area and lit area of the caster alone; `None` when rounding leaves open whether a face is turned to the light.
fn caster_areas(caster: Caster, center: DVec3, lamp: Lamp) -> Option<Areas> {
    match caster {
        Caster::Sphere(r) => {
            let lit_height = match lamp {
                Lamp::Sun(_) => r,
                Lamp::Point(l) => r * (1.0 - r / (l - center).length()),
            };
            Some(Areas { whole: 4.0 * PI * r * r, lit: 2.0 * PI * r * lit_height })
        }
        Caster::Box(size, spin) => {
            let to_light = match lamp {
                Lamp::Sun(d) => spin.transpose() * -d,
                Lamp::Point(l) => spin.transpose() * (l - center),
            };
            let reach = if matches!(lamp, Lamp::Point(_)) { size / 2.0 } else { DVec3::ZERO };
            let mut lit = 0.0;
            for axis in 0..3 {
                let beyond = to_light[axis].abs() - reach[axis];
                if beyond != 0.0 && beyond.abs() < 1e-9 * to_light.length() {
                    return None;
                }
                if beyond > 0.0 {
                    lit += size[(axis + 1) % 3] * size[(axis + 2) % 3];
                }
            }
            let whole = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
            Some(Areas { whole, lit })
        }
    }
}

/// A caster, and how high its middle must be at least.
fn random_caster(dice: &mut Dice, is_sphere: bool) -> (Caster, f64, f64) {
    if is_sphere {
        let radius = dice.float(0.2, 2.0);
        (Caster::Sphere(radius), radius, 1.05 * radius)
    } else {
        let size = DVec3::new(dice.float(0.2, 2.0), dice.float(0.2, 2.0), dice.float(0.2, 2.0));
        let gap = if dice.one_in(3) { 0.0 } else { dice.float(0.05, 1.0) };
        (Caster::Box(size, random_spin(dice)), size.y / 2.0, size.y / 2.0 + gap)
    }
}

fn scaled(caster: Caster, scale: f64) -> Caster {
    match caster {
        Caster::Sphere(radius) => Caster::Sphere(radius * scale),
        Caster::Box(size, spin) => Caster::Box(size * scale, spin),
    }
}

/// A random scene; `None` when rounding leaves the truth open.
pub(crate) fn any_case(dice: &mut Dice, distances: &[f64], is_sphere: bool, is_sun: bool) -> Option<Case> {
    let (caster, half_height, height) = random_caster(dice, is_sphere);
    // A box may stand on the floor.
    let stands = height == half_height;
    let site = Site::any(dice, stands, distances);
    let caster = scaled(caster, site.scale);
    let extra = if stands { 0.0 } else { dice.float(0.01, 2.0) };
    let above = DVec3::new(dice.float(-1.0, 1.0), height + extra, dice.float(-1.0, 1.0));
    let center = site.place(above);
    let (source, lamp) = site.light(random_lamp(dice, is_sun, above.y + half_height));
    let hovering = center - site.origin;
    let areas = caster_areas(caster, hovering, lamp)?;
    let shadow = match caster {
        Caster::Sphere(radius) => sphere_shadow(radius, hovering, lamp),
        Caster::Box(size, spin) => box_shadow(size, spin, hovering, lamp),
    };
    let (shape, turn) = caster_shape(caster);
    let map = DAffine3 { matrix3: turn, translation: center };
    let case = Case::new(dice, site.origin, (shape, map), source, shadow);
    Some(Case { caster: Some(areas), ..case })
}

/// The lit faces of a box against the oracle.
fn check_box(case: &Case) -> Result<(), String> {
    let (Shape::Cuboid(cuboid), Some(areas)) = (&case.scene.objects[1].shape, case.caster) else { return Ok(()) };
    let oracle = Oracle::new(&case.scene);
    let light = &case.scene.lights[0].source;
    let area = |face: usize| cuboid.size[(face / 2 + 1) % 3] * cuboid.size[(face / 2 + 2) % 3];
    let lit: f64 = (0..6).filter(|&face| oracle.lit(1, face, [0.25, 0.75], light)).map(area).sum();
    let is_right = (lit - areas.lit).abs() <= case.formula_error * areas.whole;
    if is_right { Ok(()) } else { Err(format!("the box has {lit} m² lit, not {}", areas.lit)) }
}

fn caster_shape(caster: Caster) -> (Shape, DMat3) {
    match caster {
        Caster::Sphere(radius) => (sphere(radius), DMat3::IDENTITY),
        Caster::Box(size, spin) => (cuboid(size.x, size.y, size.z), spin),
    }
}

fn judge(title: &str, numbers: Range<u64>, is_sphere: bool, is_sun: bool) {
    judge_all(title, numbers, |dice| any_case(dice, &NEAR_AND_FAR, is_sphere, is_sun));
}

#[test]
fn sphere_under_a_sun() {
    judge("sphere, sun", case_numbers(100), true, true);
}

#[test]
fn sphere_under_a_point_light() {
    judge("sphere, point", case_numbers(100), true, false);
}

#[test]
fn box_under_a_sun() {
    judge("box, sun", case_numbers(250), false, true);
}

#[test]
fn box_under_a_point_light() {
    judge("box, point", case_numbers(250), false, false);
}

#[test]
fn the_formulas_agree_with_the_oracle() {
    for (is_sphere, is_sun) in [(true, true), (true, false), (false, true), (false, false)] {
        for number in 0..50 {
            let mut dice = Dice::new("formulas", number);
            let Some(case) = any_case(&mut dice, &NEAR_AND_FAR, is_sphere, is_sun) else { continue };
            if let Err(complaint) = case.check_floor(&mut dice).and_then(|()| check_box(&case)) {
                panic!("sphere {is_sphere}, sun {is_sun}, case {number}: {complaint}; {:?}", case.scene);
            }
        }
    }
}
