//! The closed forms themselves, against brute force: formulas by other formulas, by counting points that the definition
//! puts in shadow, and by sums over many small parts of a body. No library decision takes part.

use std::f64::consts::PI;

use crate::forms::{
    Caster, Lamp,
    chance::{Arrangement, Kind, any_arrangement},
    lit::areas,
    quadrature::integral,
    shadow::{closed, hull_of_disks, shadow},
    support::{Hull, ellipse_area},
};
use crate::oracle::{blocking, body::placed, cases, curved::Curved, dice::Dice, number::vector, solids::Solid};
use glam::{DVec2, DVec3};
use umbriel_geometry::{Analytic, LightSource, Placement};

fn source(lamp: Lamp) -> blocking::Lamp {
    let light = match lamp {
        Lamp::Sun(way) => LightSource::sun(way.to_array()),
        Lamp::Point(position) => LightSource::point(position.to_array()),
    };
    blocking::Lamp::new(&light.expect("a light"))
}

fn curved(caster: &Caster) -> Curved {
    let placement = Placement::new(caster.map()).expect("a regular matrix");
    placed(&Solid::new(&caster.body), &placement, true)
}

fn arrangements(count: u64) -> impl Iterator<Item = (String, Arrangement)> {
    let kinds = Kind::ALL.into_iter().flat_map(|kind| [(kind, true), (kind, false)]);
    kinds.flat_map(move |(kind, is_sun)| {
        (0..count).map(move |number| {
            let arrangement = any_arrangement(&mut Dice::new("checked", number), kind, is_sun);
            (format!("{kind:?}, sun {is_sun}, case {number}: {arrangement:?}"), arrangement)
        })
    })
}

fn assert_close(a: f64, b: f64, share: f64, title: &str) {
    assert!((a - b).abs() <= share * a.abs().max(b.abs()), "{a} and {b} differ by {}: {title}", (a - b) / b);
}

#[test]
fn integrals_with_known_values() {
    assert_close(integral(|x| x.sqrt(), 0.0, 1.0), 2.0 / 3.0, 1e-15, "a root");
    assert_close(integral(|x| (1.0 - x * x).sqrt(), -1.0, 1.0), PI / 2.0, 1e-15, "half a circle");
    assert_close(integral(f64::exp, 0.0, 1.0), 1f64.exp_m1(), 1e-15, "e");
    assert_close(integral(|x| (x / 2.0).acos(), -2.0, 2.0), 2.0 * PI, 1e-15, "an arc cosine");
}

#[test]
fn hulls_of_two_disks() {
    assert_close(hull_of_disks(1.0, 1.0, 3.0), PI + 6.0, 1e-15, "a stadium");
    assert_close(hull_of_disks(2.0, 1.0, 0.5), 4.0 * PI, 1e-15, "one within the other");
    let apex_at = 2.0;
    let tangents = PI - 1.0 * (0.5f64).acos() + apex_at * (PI / 3.0).sin();
    assert_close(hull_of_disks(1.0, 0.0, apex_at), tangents, 1e-15, "a disk and a point");
}

#[test]
fn closed_forms_agree_with_the_integral_over_touching_lines() {
    let mut worst: f64 = 0.0;
    let mut checked = 0;
    for (title, Arrangement { caster, lamp, .. }) in arrangements(cases(1_000) / 20) {
        let Some(hull) = Hull::new(&caster, lamp) else { continue };
        if let Some(area) = ellipse_area(&hull).or_else(|| closed(&caster, lamp)) {
            let integrated = hull.area();
            worst = worst.max((integrated / area - 1.0).abs());
            assert_close(integrated, area, 1e-12, &title);
            checked += 1;
        }
    }
    assert!(checked > 200, "only {checked} arrangements have a closed form");
    assert!(worst < 1e-9, "{worst}");
}

#[test]
fn ellipsoids_under_a_sun_by_their_outline() {
    for number in 0..200 {
        let arrangement = any_arrangement(&mut Dice::new("outline", number), Kind::Ellipsoid, true);
        let (Analytic::Ellipsoid { radii: [a, b, c] }, Lamp::Sun(way)) = (arrangement.caster.body, arrangement.lamp)
        else {
            panic!("an ellipsoid under a sun")
        };
        let s = arrangement.caster.turn.transpose() * way;
        let outline = PI * DVec3::new(b * c * s.x, c * a * s.y, a * b * s.z).length() / -way.y;
        let area = shadow(&arrangement.caster, arrangement.lamp).expect("a formula").area;
        assert_close(area, outline, 1e-12, "ellipsoid");
    }
}

#[test]
fn borders_enclose_what_the_definition_puts_in_shadow() {
    for (title, Arrangement { caster, lamp, .. }) in arrangements(cases(1_000) / 50) {
        let shadow = shadow(&caster, lamp).unwrap_or_else(|| panic!("no formula: {title}"));
        assert_close(shadow.polygon_area(), shadow.area, 1e-4, &title);
        let (body, light) = (curved(&caster), source(lamp));
        let low = shadow.border.iter().copied().reduce(DVec2::min).expect("a border");
        let high = shadow.border.iter().copied().reduce(DVec2::max).expect("a border");
        let margin = 1e-3 * (high - low).length();
        let mut dice = Dice::new("floor", 0);
        for _ in 0..100 {
            let any = DVec2::new(dice.float(-0.1, 1.1), dice.float(-0.1, 1.1));
            let near = dice.pick(&shadow.border[..]) + (any - 0.5) * (20.0 * margin);
            let point = if dice.one_in(2) { near } else { low + (high - low) * any };
            let Some(inside) = shadow.contains(point, margin) else { continue };
            let x = blocking::Place::new(vector([point.x, 0.0, point.y]));
            assert_eq!(body.blocks(&x, &light), inside, "({}, {}) of {title}", point.x, point.y);
        }
    }
}

/// Small parts of a surface in local coordinates: middle, outward normal of unit length, area.
fn parts(body: &Analytic, count: u32) -> Vec<(DVec3, DVec3, f64)> {
    let outline: Vec<[DVec2; 2]> = match *body {
        Analytic::Sphere { radius } => arc(DVec2::ZERO, [radius; 2], -0.5, 0.5, count),
        Analytic::Ellipsoid { radii } => return ellipsoid_parts(radii, count),
        Analytic::Cylinder { radius, height } => {
            chain(&[[0.0, -0.5], [radius, -0.5], [radius, 0.5], [0.0, 0.5]], height, count)
        }
        Analytic::Cone { radius, height } => chain(&[[0.0, -0.5], [radius, -0.5], [0.0, 0.5]], height, count),
        Analytic::Frustum { bottom_radius, top_radius, height } => {
            chain(&[[0.0, -0.5], [bottom_radius, -0.5], [top_radius, 0.5], [0.0, 0.5]], height, count)
        }
        Analytic::Capsule { radius, height } => [
            arc(DVec2::new(0.0, -height / 2.0), [radius; 2], -0.5, 0.0, count),
            chain(&[[radius, -0.5], [radius, 0.5]], height, count),
            arc(DVec2::new(0.0, height / 2.0), [radius; 2], 0.0, 0.5, count),
        ]
        .concat(),
        Analytic::Paraboloid { radius, height } => {
            let side = curve(count, |v| DVec2::new(radius * (1.0 - v), height * (0.5 - (1.0 - v) * (1.0 - v))));
            [chain(&[[0.0, -0.5], [radius, -0.5]], height, count), side].concat()
        }
        Analytic::Hyperboloid { waist_radius: waist, end_radius: end, height } => {
            let squared = |s: f64| waist * waist + (end * end - waist * waist) * s * s;
            let side = curve(count, |v| DVec2::new(squared(2.0 * v - 1.0).sqrt(), height * (v - 0.5)));
            let ends =
                [chain(&[[0.0, -0.5], [end, -0.5]], height, count), chain(&[[end, 0.5], [0.0, 0.5]], height, count)];
            [side, ends.concat()].concat()
        }
        Analytic::Disk { radius } => chain(&[[radius, 0.0], [0.0, 0.0]], 1.0, count),
        _ => Vec::new(),
    };
    let around = |[p, q]: [DVec2; 2]| {
        let (middle, along) = ((p + q) / 2.0, q - p);
        let area = 2.0 * PI / f64::from(count) * middle.x * along.length();
        let normal = DVec2::new(along.y, -along.x).normalize();
        (0..count).map(move |i| {
            let (s, c) = (2.0 * PI * (f64::from(i) + 0.37) / f64::from(count)).sin_cos();
            let turned = |v: DVec2| DVec3::new(v.x * c, v.y, v.x * s);
            (turned(middle), turned(normal), area)
        })
    };
    outline.into_iter().flat_map(around).collect()
}

fn curve(count: u32, at: impl Fn(f64) -> DVec2) -> Vec<[DVec2; 2]> {
    let point = |i: u32| at(f64::from(i) / f64::from(count));
    (0..count).map(|i| [point(i), point(i + 1)]).collect()
}

fn arc(center: DVec2, [a, b]: [f64; 2], from: f64, to: f64, count: u32) -> Vec<[DVec2; 2]> {
    curve(count, |v| {
        let (s, c) = (PI * (from + (to - from) * v)).sin_cos();
        center + DVec2::new(a * c, b * s)
    })
}

/// Straight pieces of an outline; heights in shares of `height`.
fn chain(corners: &[[f64; 2]], height: f64, count: u32) -> Vec<[DVec2; 2]> {
    let corner = |[x, y]: [f64; 2]| DVec2::new(x, y * height);
    corners.windows(2).flat_map(|pair| curve(count, |v| corner(pair[0]).lerp(corner(pair[1]), v))).collect()
}

fn ellipsoid_parts(radii: [f64; 3], count: u32) -> Vec<(DVec3, DVec3, f64)> {
    let radii = DVec3::from_array(radii);
    let on_sphere = parts(&Analytic::Sphere { radius: 1.0 }, count);
    let stretched = |(u, _, area): (DVec3, DVec3, f64)| {
        let normal = u / radii;
        (u.normalize() * radii, normal.normalize(), area * radii.element_product() * normal.length())
    };
    on_sphere.into_iter().map(stretched).collect()
}

#[test]
fn lit_areas_agree_with_sums_over_small_parts() {
    for (title, Arrangement { caster, lamp, .. }) in arrangements(cases(1_000) / 100) {
        let local = lamp.local(caster.turn, caster.center);
        let Some(formula) = areas(&caster.body, local) else { continue };
        let may_shade_itself = matches!(caster.body, Analytic::Hyperboloid { .. });
        let is_two_sided = matches!(caster.body, Analytic::Disk { .. });
        let body = placed(&Solid::new(&caster.body), &Placement::IDENTITY, true);
        let light = source(local);
        let (mut whole, mut lit) = (0.0, 0.0);
        for (x, normal, area) in parts(&caster.body, if may_shade_itself { 60 } else { 240 }) {
            whole += area;
            let facing = match local {
                Lamp::Sun(way) => -normal.dot(way),
                Lamp::Point(l) => normal.dot(l - x),
            };
            let is_free = || !body.blocks(&blocking::Place::new(vector((x + normal * 1e-4).to_array())), &light);
            if (facing > 0.0 || is_two_sided) && (!may_shade_itself || is_free()) {
                lit += area;
            }
        }
        assert_close(whole, formula.whole, 2e-3, &title);
        let allowed = if may_shade_itself { 2e-2 } else { 5e-3 };
        assert!((lit - formula.lit).abs() <= allowed * whole, "{lit}, by formula {}: {title}", formula.lit);
    }
}
