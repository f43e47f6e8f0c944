//! The bounds hold the truth for curved bodies: shadows on floors and on each other that have a closed form.
//!
//! One body of each kind hovers over a floor, or stands on it, upright or tilted, under a sun or a lamp; the floor is a
//! rectangle or a disk. Bodies on a common axis shade each other under a light on that axis. The formulas are in
//! `oracle/forms`, checked by brute force in `closed_forms_checked.rs`, derived in NUMERICS.md.
//!
//! *Rounding.* As in `closed_forms.rs`: the formulas start from the rounded numbers of the scene. What is left are some
//! hundreds of roundings, and the error of a quadrature where a formula has one: 10^-12 of the area.
//!
//! `UMBRIEL_CASES` sets the number of scenes.

use std::{f64::consts::PI, ops::Range};

use crate::floor::{Case, NEAR_AND_FAR, Site, baked, holds, judge_all};
use crate::forms::{
    Caster,
    chance::{Arrangement, Kind, any_arrangement},
    coaxial::{hidden_from_lamp, under_a_sun},
    lit::{Areas, areas},
    shadow::{Shadow, shadow},
};
use crate::oracle::{
    case_numbers,
    dice::Dice,
    fixtures::{analytic as shape, lit_by, object, scene},
    graze::scaled,
};
use glam::{DAffine3, DMat3, DVec3};
use umbriel_geometry::{Analytic, LightSource};
use umbriel_scene::{Scene, Shape};

/// An arrangement on a site: the caster and its truth, the light, the floor's shadow.
struct Placed {
    site: Site,
    shape: Shape,
    map: DAffine3,
    source: LightSource,
    shadow: Shadow,
    areas: Option<Areas>,
}

/// `None` when rounding leaves the truth open.
fn placed(dice: &mut Dice, distances: &[f64], kind: Kind, is_sun: bool) -> Option<Placed> {
    let Arrangement { caster, lamp, stands } = any_arrangement(dice, kind, is_sun);
    let site = Site::any(dice, stands, distances);
    let body = scaled(caster.body, site.scale);
    let center = site.place(caster.center);
    let (source, lamp) = site.light(lamp);
    let caster = Caster { body, turn: caster.turn, center: center - site.origin };
    let areas = areas(&body, lamp.local(caster.turn, caster.center));
    if areas.is_none() && kind != Kind::Hyperboloid {
        return None;
    }
    let map = DAffine3 { matrix3: caster.turn, translation: center };
    Some(Placed { site, shape: shape(body), map, source, shadow: shadow(&caster, lamp)?, areas })
}

pub(crate) fn any_case(dice: &mut Dice, distances: &[f64], kind: Kind, is_sun: bool) -> Option<Case> {
    let found = placed(dice, distances, kind, is_sun)?;
    let case = Case::new(dice, found.site.origin, (found.shape, found.map), found.source, found.shadow);
    Some(Case { caster: found.areas, ..case })
}

fn judge_kind(kind: Kind, numbers: Range<u64>) {
    for is_sun in [true, false] {
        let title = format!("{kind:?} {is_sun}");
        judge_all(&title, numbers.clone(), |dice| any_case(dice, &NEAR_AND_FAR, kind, is_sun));
    }
}

#[test]
fn the_formulas_agree_with_the_oracle() {
    for (kind, is_sun) in Kind::ALL.into_iter().flat_map(|kind| [(kind, true), (kind, false)]) {
        for number in 0..10 {
            let mut dice = Dice::new("formulas", number);
            let Some(case) = any_case(&mut dice, &NEAR_AND_FAR, kind, is_sun) else { continue };
            if let Err(complaint) = case.check_floor(&mut dice) {
                panic!("{kind:?}, sun {is_sun}, case {number}: {complaint}; {:?}", case.scene);
            }
        }
    }
}

#[test]
fn spheres_over_a_floor() {
    judge_kind(Kind::Sphere, case_numbers(10));
}

#[test]
fn ellipsoids_over_a_floor() {
    judge_kind(Kind::Ellipsoid, case_numbers(10));
}

#[test]
fn cylinders_over_a_floor() {
    judge_kind(Kind::Cylinder, case_numbers(10));
}

#[test]
fn cones_over_a_floor() {
    judge_kind(Kind::Cone, case_numbers(10));
}

#[test]
fn frusta_over_a_floor() {
    judge_kind(Kind::Frustum, case_numbers(10));
}

#[test]
fn capsules_over_a_floor() {
    judge_kind(Kind::Capsule, case_numbers(10));
}

#[test]
fn paraboloids_over_a_floor() {
    judge_kind(Kind::Paraboloid, case_numbers(10));
}

#[test]
fn hyperboloids_over_a_floor() {
    judge_kind(Kind::Hyperboloid, case_numbers(10));
}

#[test]
fn disks_over_a_floor() {
    judge_kind(Kind::Disk, case_numbers(10));
}

/// Bakes a scene and holds every object with a known truth against it; the first object's undecided part must be a narrow
/// band along a border of this length.
fn judge_objects(scene: &Scene, truths: &[Option<Areas>], border: f64, extent: f64) -> Result<(), String> {
    let report = baked(scene);
    let objects = report.lights.first().map_or(&[][..], |light| &light.objects[..]);
    for object in objects {
        if let Some(truth) = truths[object.object] {
            holds(scene, object, truth, 1e-12 * truth.whole)?;
        }
    }
    let (undecided, edge) = (objects[0].undecided(), extent / 256.0);
    if undecided > 3.0 * border * edge {
        return Err(format!(
            "WIDE: {undecided} m² are undecided: {} × border × cell edge",
            undecided / (border * edge)
        ));
    }
    Ok(())
}

fn all_hold(title: &str, numbers: Range<u64>, judge: impl Fn(&mut Dice) -> Option<Result<(), (String, Scene)>>) {
    let (mut judged, mut wrong, count) = (0, Vec::new(), numbers.end - numbers.start);
    for number in numbers {
        let Some(outcome) = judge(&mut Dice::new(title, number)) else { continue };
        judged += 1;
        if let Err((complaint, scene)) = outcome {
            wrong.push(format!("case {number}: {complaint}; {scene:?}"));
        }
    }
    assert!(2 * judged >= count, "only {judged} of {count} scenes have a certain truth");
    let shown = wrong.iter().take(3).cloned().collect::<Vec<_>>().join("\n");
    assert!(wrong.is_empty(), "{} of {judged} scenes are wrong:\n{shown}", wrong.len());
}

#[test]
fn bodies_over_and_on_a_disk() {
    all_hold("on a disk", case_numbers(36), |dice| {
        let kind = dice.pick(&Kind::ALL);
        let is_sun = dice.one_in(2);
        let found = placed(dice, &NEAR_AND_FAR, kind, is_sun)?;
        let reach = found.shadow.border.iter().map(|p| p.length()).fold(0.0, f64::max);
        let radius = reach * dice.float(1.02, 2.0);
        let floor = object("floor", shape(Analytic::Disk { radius }), DAffine3::from_translation(found.site.origin));
        let caster = object("caster", found.shape, found.map);
        let scene = lit_by(scene(vec![floor, caster]), found.source);
        let whole = PI * radius * radius;
        let truths = [Some(Areas { whole, lit: whole - found.shadow.area }), found.areas];
        let outcome = judge_objects(&scene, &truths, found.shadow.border_length(), 2.0 * radius);
        Some(outcome.map_err(|complaint| (complaint, scene)))
    });
}

/// Turns that permute the axes: the common axis stays an exact one.
fn exact_turn(dice: &mut Dice) -> DMat3 {
    dice.pick(&[
        DMat3::IDENTITY,
        DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
        DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z),
        DMat3::from_cols(DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z),
    ])
}

fn any_receiver(dice: &mut Dice, flat_top: bool) -> Analytic {
    let (radius, height) = (dice.float(1.0, 2.0), dice.float(0.2, 2.0));
    match dice.below(if flat_top { 2 } else { 8 }) {
        0 => Analytic::Disk { radius },
        1 => Analytic::Cylinder { radius, height },
        2 => Analytic::Cone { radius, height },
        3 => Analytic::Frustum { bottom_radius: radius, top_radius: dice.float(0.2, 2.0), height },
        4 => Analytic::Sphere { radius },
        5 => Analytic::Capsule { radius, height },
        6 => Analytic::Ellipsoid { radii: [radius, height, radius] },
        _ => Analytic::Paraboloid { radius, height },
    }
}

/// A small caster, its radius, and half its height.
fn any_caster(dice: &mut Dice) -> (Analytic, f64, f64) {
    let (radius, height) = (dice.float(0.1, 0.9), dice.float(0.1, 1.0));
    match dice.below(4) {
        0 => (Analytic::Sphere { radius }, radius, radius),
        1 => (Analytic::Disk { radius }, radius, 0.0),
        2 => (Analytic::Cylinder { radius, height }, radius, height / 2.0),
        _ => (Analytic::Cone { radius, height }, radius, height / 2.0),
    }
}

/// How far a receiver reaches above its middle.
fn top_of(receiver: &Analytic) -> f64 {
    match *receiver {
        Analytic::Cylinder { height, .. }
        | Analytic::Cone { height, .. }
        | Analytic::Frustum { height, .. }
        | Analytic::Paraboloid { height, .. } => height / 2.0,
        Analytic::Sphere { radius } => radius,
        Analytic::Capsule { radius, height } => radius + height / 2.0,
        Analytic::Ellipsoid { radii } => radii[1],
        _ => 0.0,
    }
}

/// A receiver at the origin and a caster above it on its axis, turned together.
fn coaxial(dice: &mut Dice, receiver: Analytic, caster: Analytic, above: f64) -> (DMat3, Vec<umbriel_scene::Object>) {
    let turn = exact_turn(dice);
    let at = |y: f64| DAffine3 { matrix3: turn, translation: turn * DVec3::new(0.0, y, 0.0) };
    let objects = vec![object("receiver", shape(receiver), at(0.0)), object("caster", shape(caster), at(above))];
    (turn, objects)
}

/// The radius and the greatest extent of a receiver.
fn sizes_of(receiver: &Analytic) -> [f64; 2] {
    match *receiver {
        Analytic::Disk { radius } | Analytic::Sphere { radius } => [radius, 2.0 * radius],
        Analytic::Ellipsoid { radii } => [radii[0], 2.0 * radii[0].max(radii[1])],
        Analytic::Frustum { bottom_radius, top_radius, height } => {
            let radius = bottom_radius.max(top_radius);
            [radius, height.max(2.0 * radius)]
        }
        Analytic::Capsule { radius, height } => [radius, 2.0 * radius + height],
        Analytic::Cylinder { radius, height }
        | Analytic::Cone { radius, height }
        | Analytic::Paraboloid { radius, height } => [radius, height.max(2.0 * radius)],
        _ => [1.0; 2],
    }
}

#[test]
fn bodies_on_one_axis_under_a_sun() {
    all_hold("coaxial, sun", case_numbers(18), |dice| {
        let receiver = any_receiver(dice, false);
        let (caster, hidden, half) = any_caster(dice);
        let gap = dice.float(0.05, 2.0);
        let (turn, objects) = coaxial(dice, receiver, caster, top_of(&receiver) + half + gap);
        let sun = LightSource::sun((turn * DVec3::NEG_Y).to_array()).expect("a sun");
        let scene = lit_by(scene(objects), sun);
        let truths = [Some(under_a_sun(&receiver, hidden)?), None];
        // The shadow's border, and where the surface turns away from the sun.
        let [radius, extent] = sizes_of(&receiver);
        let outcome = judge_objects(&scene, &truths, 2.0 * PI * (hidden + 2.0 * radius), extent);
        Some(outcome.map_err(|complaint| (complaint, scene)))
    });
}

#[test]
fn bodies_on_one_axis_under_a_lamp() {
    all_hold("coaxial, lamp", case_numbers(18), |dice| {
        let receiver = any_receiver(dice, true);
        let (caster, _, half) = any_caster(dice);
        let top = top_of(&receiver);
        let above = half + dice.float(0.05, 2.0);
        let height = above + half + dice.float(0.05, 3.0);
        let (turn, objects) = coaxial(dice, receiver, caster, top + above);
        let lamp = LightSource::point((turn * DVec3::new(0.0, top + height, 0.0)).to_array()).expect("a lamp");
        let scene = lit_by(scene(objects), lamp);
        // Heights as they are after rounding.
        let (above, height) = ((top + above) - top, (top + height) - top);
        let [radius, extent] = sizes_of(&receiver);
        let hidden = hidden_from_lamp(&caster, above, height)?.min(radius);
        let truths = [Some(under_a_sun(&receiver, hidden)?), None];
        let outcome = judge_objects(&scene, &truths, 2.0 * PI * (hidden + radius), extent);
        Some(outcome.map_err(|complaint| (complaint, scene)))
    });
}
