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

mod oracle;

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DVec2, DVec3};
use oracle::{
    Oracle, cases,
    dice::Dice,
    fixtures::{cuboid, lit_by, object, rectangle, scene, sphere},
};
use umbriel_geometry::LightSource;
use umbriel_scene::{Scene, Shape};
use umbriel_shadow::{Cell, Detail, ObjectReport, Request, Silent, Verdict, bake};

/// How far a bound may miss the formula, as a share of the object's area.
const FORMULA_ERROR: f64 = 1e-12;

/// A light as the formulas take it, relative to the middle of the floor.
#[derive(Clone, Copy, Debug)]
enum Lamp {
    /// The direction the light travels.
    Sun(DVec3),
    /// The position of a point light.
    Point(DVec3),
}

/// What hovers over the floor.
#[derive(Clone, Copy, Debug)]
enum Caster {
    /// Its radius.
    Sphere(f64),
    /// Its edge lengths and its rotation about the vertical.
    Box(DVec3, DMat3),
}

/// A closed curve on the floor, as a fine polygon about the floor's middle, and the exact area it encloses.
struct Shadow {
    border: Vec<DVec2>,
    area: f64,
}

/// A scene of a floor (object 0) and a caster (object 1) under one light, and the truth about it.
struct Case {
    scene: Scene,
    size: DVec2,
    spin: DMat3,
    shadow: Shadow,
    caster_area: f64,
    caster_lit: f64,
}

fn level(v: DVec3) -> DVec2 {
    DVec2::new(v.x, v.z)
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
fn caster_areas(caster: Caster, center: DVec3, lamp: Lamp) -> Option<(f64, f64)> {
    match caster {
        Caster::Sphere(r) => {
            let lit_height = match lamp {
                Lamp::Sun(_) => r,
                Lamp::Point(l) => r * (1.0 - r / (l - center).length()),
            };
            Some((4.0 * PI * r * r, 2.0 * PI * r * lit_height))
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
            let area = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
            Some((area, lit))
        }
    }
}

/// A rotation about the vertical; often none, so that faces can be exactly edge-on.
fn random_spin(dice: &mut Dice) -> DMat3 {
    if dice.one_in(3) { DMat3::IDENTITY } else { DMat3::from_rotation_y(dice.float(-PI, PI)) }
}

/// A caster, and how high its middle must be at least, in metres before scaling.
fn random_caster(dice: &mut Dice, is_sphere: bool, scale: f64) -> (Caster, f64, f64) {
    if is_sphere {
        let radius = dice.float(0.2, 2.0);
        (Caster::Sphere(radius * scale), radius, 1.05 * radius)
    } else {
        let size = DVec3::new(dice.float(0.2, 2.0), dice.float(0.2, 2.0), dice.float(0.2, 2.0));
        let gap = if dice.one_in(3) { 0.0 } else { dice.float(0.05, 1.0) };
        (Caster::Box(size * scale, random_spin(dice)), size.y / 2.0, size.y / 2.0 + gap)
    }
}

fn random_lamp(dice: &mut Dice, is_sun: bool, top: f64) -> DVec3 {
    if is_sun {
        let elevation = dice.float(0.3, 1.5);
        let azimuth = if dice.one_in(4) { 0.0 } else { dice.float(-PI, PI) };
        let across = elevation.cos();
        DVec3::new(azimuth.sin() * across, -elevation.sin(), azimuth.cos() * across)
    } else {
        DVec3::new(dice.float(-2.0, 2.0), top + dice.float(0.5, 4.0), dice.float(-2.0, 2.0))
    }
}

impl Case {
    /// A random scene; `None` when rounding leaves the truth open.
    fn new(dice: &mut Dice, is_sphere: bool, is_sun: bool) -> Option<Self> {
        let scale = 2f64.powi(dice.pick(&[-40, 0, 40]));
        let far = scale * dice.pick(&[0.0, 1.0, 1e3, 1e6]);
        let (caster, half_height, height) = random_caster(dice, is_sphere, scale);
        // A box may stand on the floor: the floor is then at height 0, so that the contact is exact.
        let stands = height == half_height;
        let origin_y = if stands { 0.0 } else { far * dice.float(-1.0, 1.0) };
        let origin = DVec3::new(far * dice.float(-1.0, 1.0), origin_y, far * dice.float(-1.0, 1.0));
        let extra = if stands { 0.0 } else { dice.float(0.01, 2.0) };
        let above = DVec3::new(dice.float(-1.0, 1.0), height + extra, dice.float(-1.0, 1.0));
        let center = origin + above * scale;
        let top = above.y + half_height;
        let raw = random_lamp(dice, is_sun, top);
        let (source, lamp) = if is_sun {
            (LightSource::sun(raw.to_array()), Lamp::Sun(raw))
        } else {
            let position = origin + raw * scale;
            (LightSource::point(position.to_array()), Lamp::Point(position - origin))
        };
        let hovering = center - origin;
        let (caster_area, caster_lit) = caster_areas(caster, hovering, lamp)?;
        let shadow = match caster {
            Caster::Sphere(radius) => sphere_shadow(radius, hovering, lamp),
            Caster::Box(size, spin) => box_shadow(size, spin, hovering, lamp),
        };
        let spin = random_spin(dice);
        let size = floor_size(dice, spin, &shadow);
        let (shape, turn) = caster_shape(caster);
        let floor_map = DAffine3 { matrix3: spin, translation: origin };
        let caster_map = DAffine3 { matrix3: turn, translation: center };
        let objects = vec![object("floor", rectangle(size.x, size.y), floor_map), object("caster", shape, caster_map)];
        let scene = lit_by(scene(objects), source.expect("an accepted light"));
        Some(Self { scene, size, spin, shadow, caster_area, caster_lit })
    }

    fn judge(&self) -> Result<(), String> {
        let detail = Detail::Depth { interior: 8, boundary: 8 };
        let request = Request { keep_cells: true, ..Request::everything(&self.scene, detail) };
        let report = bake(&self.scene, &request, &Silent).map_err(|cancelled| format!("{cancelled:?}"))?;
        let objects = report.lights.first().map(|light| &light.objects[..]);
        let Some([floor, caster]) = objects else { return Err("not two objects".into()) };
        let floor_area = self.size.x * self.size.y;
        self.holds(floor, floor_area, floor_area - self.shadow.area)?;
        self.holds(caster, self.caster_area, self.caster_lit)?;
        self.is_worth_something(floor)
    }

    /// The truth lies within the bounds.
    fn holds(&self, report: &ObjectReport, area: f64, lit: f64) -> Result<(), String> {
        let name = &self.scene.objects[report.object].name;
        let (allowed, bounds) = (FORMULA_ERROR * area, report.lit);
        if bounds.lower > lit + allowed || bounds.upper < lit - allowed {
            return Err(format!("BOUNDS: the {name}'s lit area {lit} is not in {bounds:?}"));
        }
        if bounds.estimate < bounds.lower || bounds.estimate > bounds.upper {
            return Err(format!("ESTIMATE: the {name}'s is outside its own bounds {bounds:?}"));
        }
        // The area itself is a plain float, not a bound: placed corners may have been rounded for it.
        let place = self.scene.objects[report.object].placement.map().translation.abs().max_element();
        let rounded = 16.0 * f64::EPSILON * place * area.sqrt();
        if (report.area - area).abs() > allowed + rounded {
            return Err(format!("AREA: the {name}'s is {area}, not {}", report.area));
        }
        Ok(())
    }

    /// The undecided part is a narrow band along the border.
    fn is_worth_something(&self, floor: &ObjectReport) -> Result<(), String> {
        let (edge, length) = (self.cell_edge(), self.border_length());
        let undecided = floor.undecided();
        if undecided > 3.0 * length * edge {
            let bands = undecided / (length * edge);
            return Err(format!("WIDE: {undecided} m² of the floor are undecided: {bands} × border × cell edge"));
        }
        let cells = floor.cells.iter().filter(|cell| cell.verdict == Verdict::Undecided);
        let far: f64 = cells.filter(|cell| self.is_far(cell, 2.0 * edge)).map(|cell| self.area_of(cell)).sum();
        // All that is surely farther: the floor without a band of three cells on either side of the border.
        let all_far = (self.size.x * self.size.y - 6.0 * edge * length).max(0.0);
        if far > 0.01 * all_far {
            return Err(format!("FAR: {far} of {all_far} m² far from the border are undecided"));
        }
        Ok(())
    }

    /// The edge of the floor's bounding cube, halved eight times.
    fn cell_edge(&self) -> f64 {
        let half = DVec3::new(self.size.x, 0.0, self.size.y);
        let extent = self.spin.x_axis.abs() * half.x + self.spin.z_axis.abs() * half.z;
        extent.max_element() / 256.0
    }

    fn sides(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        let border = &self.shadow.border;
        (0..border.len()).map(|i| [border[i], border[(i + 1) % border.len()]])
    }

    fn border_length(&self) -> f64 {
        self.sides().map(|[a, b]| a.distance(b)).sum()
    }

    fn area_of(&self, cell: &Cell) -> f64 {
        self.size.x * self.size.y * 0.25f64.powi(i32::from(cell.level))
    }

    /// Whether all of a floor cell is farther than `limit` from the border.
    fn is_far(&self, cell: &Cell, limit: f64) -> bool {
        let step = 0.5f64.powi(i32::from(cell.level));
        let (u, v) = ((f64::from(cell.i) + 0.5) * step, (f64::from(cell.j) + 0.5) * step);
        let middle = level(self.spin * DVec3::new((u - 0.5) * self.size.x, 0.0, (0.5 - v) * self.size.y));
        let reach = limit + self.size.length() * step / 2.0;
        self.sides().all(|[a, b]| {
            let t = ((middle - a).dot(b - a) / (b - a).length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            middle.distance(a + (b - a) * t) > reach
        })
    }
}

impl Case {
    /// Whether a point of the floor (relative to its middle) is in the shadow; `None` near the border.
    fn is_inside(&self, point: DVec2) -> Option<bool> {
        let margin = 1e-3 * self.size.length();
        let near = self.sides().any(|[a, b]| {
            let t = ((point - a).dot(b - a) / (b - a).length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            point.distance(a + (b - a) * t) < margin
        });
        let turns = self.sides().map(|[a, b]| (b - a).perp_dot(point - a));
        (!near).then(|| turns.map(f64::signum).sum::<f64>().abs() as usize == self.shadow.border.len())
    }

    /// The formulas against the oracle, point by point.
    fn check_formulas(&self, dice: &mut Dice) -> Result<(), String> {
        let oracle = Oracle::new(&self.scene);
        let light = &self.scene.lights[0].source;
        for _ in 0..60 {
            let [u, v] = dice.parameters(false);
            let local = DVec3::new((u - 0.5) * self.size.x, 0.0, (0.5 - v) * self.size.y);
            let inside = self.is_inside(level(self.spin * local));
            if inside.is_some_and(|inside| inside == oracle.lit(0, 0, [u, v], light)) {
                return Err(format!("the floor at ({u}, {v}): {inside:?} in the shadow"));
            }
        }
        if let Shape::Cuboid(cuboid) = self.scene.objects[1].shape {
            let area = |face: usize| cuboid.size[(face / 2 + 1) % 3] * cuboid.size[(face / 2 + 2) % 3];
            let lit: f64 = (0..6).filter(|&face| oracle.lit(1, face, [0.25, 0.75], light)).map(area).sum();
            if (lit - self.caster_lit).abs() > FORMULA_ERROR * self.caster_area {
                return Err(format!("the box has {lit} m² lit, not {}", self.caster_lit));
            }
        }
        Ok(())
    }
}

fn caster_shape(caster: Caster) -> (Shape, DMat3) {
    match caster {
        Caster::Sphere(radius) => (sphere(radius), DMat3::IDENTITY),
        Caster::Box(size, spin) => (cuboid(size.x, size.y, size.z), spin),
    }
}

/// A floor about the origin that holds the whole shadow.
fn floor_size(dice: &mut Dice, spin: DMat3, shadow: &Shadow) -> DVec2 {
    let back = spin.transpose();
    let local = shadow.border.iter().map(|p| level(back * DVec3::new(p.x, 0.0, p.y)).abs());
    let half = local.fold(DVec2::ZERO, DVec2::max);
    half * 2.0 * DVec2::new(dice.float(1.02, 2.0), dice.float(1.02, 2.0))
}

fn judge_all(title: &str, is_sphere: bool, is_sun: bool) {
    let count = cases(1_000).div_ceil(4);
    let mut wrong = Vec::new();
    let mut judged = 0;
    for number in 0..count {
        let mut dice = Dice::new(title, number);
        let Some(case) = Case::new(&mut dice, is_sphere, is_sun) else { continue };
        judged += 1;
        if let Err(complaint) = case.judge() {
            wrong.push(format!("case {number}: {complaint}; {:?}", case.scene));
        }
    }
    assert!(2 * judged > count, "only {judged} of {count} scenes have a certain truth");
    let shown = wrong.iter().take(3).cloned().collect::<Vec<_>>().join("\n");
    assert!(wrong.is_empty(), "{} of {judged} scenes are wrong:\n{shown}", wrong.len());
}

#[test]
fn sphere_under_a_sun() {
    judge_all("sphere, sun", true, true);
}

#[test]
fn sphere_under_a_point_light() {
    judge_all("sphere, point", true, false);
}

#[test]
fn box_under_a_sun() {
    judge_all("box, sun", false, true);
}

#[test]
fn box_under_a_point_light() {
    judge_all("box, point", false, false);
}

#[test]
fn the_formulas_agree_with_the_oracle() {
    for (is_sphere, is_sun) in [(true, true), (true, false), (false, true), (false, false)] {
        for number in 0..50 {
            let mut dice = Dice::new("formulas", number);
            let Some(case) = Case::new(&mut dice, is_sphere, is_sun) else { continue };
            if let Err(complaint) = case.check_formulas(&mut dice) {
                panic!("sphere {is_sphere}, sun {is_sun}, case {number}: {complaint}; {:?}", case.scene);
            }
        }
    }
}
