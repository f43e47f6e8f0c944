//! A floor with one body over it under one light, baked and held against the truth.

use std::ops::Range;

use glam::{DAffine3, DMat3, DVec2, DVec3};
use umbriel_geometry::LightSource;
use umbriel_scene::{Scene, Shape};
use umbriel_shadow::{Cell, Detail, ObjectReport, Report, Request, Silent, Verdict, bake};

use crate::{
    forms::{Lamp, level, lit::Areas, shadow::Shadow},
    oracle::{
        Oracle,
        dice::Dice,
        fixtures::{elsewhere, lit_by, object, rectangle, scene},
    },
};

/// A scene of a floor (object 0) and a caster (object 1) under one light, and the truth about it.
pub(crate) struct Case {
    /// The scene.
    pub(crate) scene: Scene,
    /// The edges of the floor.
    pub(crate) size: DVec2,
    /// The floor's rotation.
    pub(crate) spin: DMat3,
    /// The floor's shadow, about the floor's middle.
    pub(crate) shadow: Shadow,
    /// The caster's area and lit area; `None` where no formula is known.
    pub(crate) caster: Option<Areas>,
    /// How far a bound may miss the formula, as a share of the object's area.
    pub(crate) formula_error: f64,
}

/// How far from the origin most scenes are, in units.
pub(crate) const NEAR_AND_FAR: [f64; 4] = [0.0, 1.0, 1e3, 1e6];

/// Scenes are made so large that their farthest coordinate has this exponent, or so small that the floor has the opposite, as far as placements have entries of
/// the accepted range.
const EXTREME: i32 = 180;
const LAST: i32 = 198;

fn exponent(number: f64) -> i32 {
    number.log2().floor() as i32
}

/// Where things stand before they are rounded to floats: a floor's middle and a scale.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Site {
    /// The middle of the floor.
    pub(crate) origin: DVec3,
    /// How many metres a unit has.
    pub(crate) scale: f64,
}

impl Site {
    /// Tiny or huge, and one of these distances away, in units. What stands on the floor needs it at height 0, so that the contact is
    /// exact.
    pub(crate) fn any(dice: &mut Dice, stands: bool, distances: &[f64]) -> Self {
        let scale = 2f64.powi(dice.pick(&[-40, 0, 40]));
        let far = scale * dice.pick(distances);
        let y = if stands { 0.0 } else { far * dice.float(-1.0, 1.0) };
        Self { origin: DVec3::new(far * dice.float(-1.0, 1.0), y, far * dice.float(-1.0, 1.0)), scale }
    }

    /// The world position of a point given in units about the floor's middle.
    pub(crate) fn place(&self, above: DVec3) -> DVec3 {
        self.origin + above * self.scale
    }

    /// The light's source, and the light as it is after rounding, about the floor's middle.
    pub(crate) fn light(&self, lamp: Lamp) -> (LightSource, Lamp) {
        let (source, lamp) = match lamp {
            Lamp::Sun(way) => (LightSource::sun(way.to_array()), lamp),
            Lamp::Point(position) => {
                let placed = self.place(position);
                (LightSource::point(placed.to_array()), Lamp::Point(placed - self.origin))
            }
        };
        (source.expect("an accepted light"), lamp)
    }
}

/// Bakes everything at depth 8 and keeps the cells.
pub(crate) fn baked(scene: &Scene) -> Report {
    let detail = Detail::Depth { interior: 8, boundary: 8 };
    let request = Request { keep_cells: true, ..Request::everything(scene, detail) };
    bake(scene, &request, &Silent).expect("nobody cancels")
}

/// The truth lies within the bounds, and the estimate too. `allowed` is how far the formulas may be off, in square metres.
pub(crate) fn holds(scene: &Scene, report: &ObjectReport, truth: Areas, allowed: f64) -> Result<(), String> {
    let (object, bounds, lit) = (&scene.objects[report.object], report.lit, truth.lit);
    let name = &object.name;
    if bounds.lower > lit + allowed || bounds.upper < lit - allowed {
        return Err(format!("BOUNDS: the {name}'s lit area {lit} is not in {bounds:?}"));
    }
    if bounds.estimate < bounds.lower || bounds.estimate > bounds.upper {
        return Err(format!("ESTIMATE: the {name}'s is outside its own bounds {bounds:?}"));
    }
    // The area itself is a plain float, not a bound: placed corners may have been rounded for it.
    let place = object.placement.map().translation.abs().max_element();
    let rounded = 16.0 * f64::EPSILON * place * truth.whole.sqrt();
    // That of a curved body sums cells that are known to 10^-8 each.
    let is_curved = matches!(object.shape, Shape::Analytic(_));
    let allowed = if is_curved { 1e-8 * truth.whole } else { allowed };
    if (report.area - truth.whole).abs() > allowed + rounded {
        return Err(format!("AREA: the {name}'s is {}, not {}", truth.whole, report.area));
    }
    Ok(())
}

impl Case {
    /// A floor that holds the shadow, and the caster.
    pub(crate) fn new(
        dice: &mut Dice,
        origin: DVec3,
        caster: (Shape, DAffine3),
        light: LightSource,
        shadow: Shadow,
    ) -> Self {
        let spin = crate::forms::chance::random_spin(dice);
        let size = floor_size(dice, spin, &shadow);
        let floor_map = DAffine3 { matrix3: spin, translation: origin };
        let objects = vec![object("floor", rectangle(size.x, size.y), floor_map), object("caster", caster.0, caster.1)];
        let scene = lit_by(scene(objects), light);
        Self { scene, size, spin, shadow, caster: None, formula_error: 1e-12 }
    }

    /// Bakes the scene, as it is, as large or as small as scenes may be by the case's number, and holds it against the truth.
    pub(crate) fn judge(&self, number: u64) -> Result<(), String> {
        let [least, greatest] = self.entries();
        let larger = (EXTREME - exponent(self.farthest())).min(LAST - exponent(greatest));
        let smaller = (-EXTREME - exponent(self.size.max_element())).max(-LAST - exponent(least));
        let powers = [0, larger, smaller];
        let report = self.baked_at(powers[number as usize % powers.len()]);
        let objects = report.lights.first().map(|light| &light.objects[..]);
        let Some([floor, caster]) = objects else { return Err("not two objects".into()) };
        let whole = self.size.x * self.size.y;
        let allowed = self.formula_error * whole;
        holds(&self.scene, floor, Areas { whole, lit: whole - self.shadow.area }, allowed)?;
        if let Some(areas) = self.caster {
            holds(&self.scene, caster, areas, self.formula_error * areas.whole)?;
        }
        self.is_worth_something(floor)
    }

    /// The greatest coordinate of bodies and of a lamp.
    fn farthest(&self) -> f64 {
        let source = self.scene.lights[0].source;
        let lamp = if source.is_sun() { DVec3::ZERO } else { source.xyz().abs() };
        let bounds = self.scene.objects.iter().map(|object| object.bounds());
        bounds.map(|bounds| bounds.min.abs().max(bounds.max.abs())).fold(lamp, DVec3::max).max_element()
    }

    /// The least and the greatest size of an entry of a placement that is not zero.
    fn entries(&self) -> [f64; 2] {
        let entries = self.scene.objects.iter().flat_map(|object| object.placement.map().to_cols_array());
        let sizes: Vec<f64> = entries.map(f64::abs).filter(|&size| size > 0.0).collect();
        [f64::min, f64::max].map(|better| sizes.iter().copied().reduce(better).expect("a matrix has entries"))
    }

    /// The report of the scene made larger by a power of two, in metres of the scene as it is: powers of two change no digit of it.
    fn baked_at(&self, power: i32) -> Report {
        let factor = 2f64.powi(power);
        let source = self.scene.lights[0].source;
        let placed = || LightSource::point((source.xyz() * factor).to_array()).expect("an accepted light");
        let light = if source.is_sun() { source } else { placed() };
        let mut report = baked(&lit_by(elsewhere(&self.scene.objects, factor, DVec3::ZERO), light));
        for object in &mut report.lights[0].objects {
            let lit = &mut object.lit;
            for area in [&mut object.area, &mut object.area_error, &mut lit.lower, &mut lit.upper, &mut lit.estimate] {
                *area = *area / factor / factor;
            }
        }
        report
    }

    /// The undecided part is a narrow band along the border.
    fn is_worth_something(&self, floor: &ObjectReport) -> Result<(), String> {
        let (edge, length) = (self.cell_edge(), self.shadow.border_length());
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
    pub(crate) fn cell_edge(&self) -> f64 {
        let half = DVec3::new(self.size.x, 0.0, self.size.y);
        let extent = self.spin.x_axis.abs() * half.x + self.spin.z_axis.abs() * half.z;
        extent.max_element() / 256.0
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
        self.shadow.distance(middle) > reach
    }

    /// The oracle's word on random points of the floor.
    pub(crate) fn check_floor(&self, dice: &mut Dice) -> Result<(), String> {
        let oracle = Oracle::new(&self.scene);
        let light = &self.scene.lights[0].source;
        for _ in 0..60 {
            let [u, v] = dice.parameters(false);
            let local = DVec3::new((u - 0.5) * self.size.x, 0.0, (0.5 - v) * self.size.y);
            let inside = self.shadow.contains(level(self.spin * local), 1e-3 * self.size.length());
            if inside.is_some_and(|inside| inside == oracle.lit(0, 0, [u, v], light)) {
                return Err(format!("the floor at ({u}, {v}): {inside:?} in the shadow"));
            }
        }
        Ok(())
    }
}

/// A floor about the origin that holds the whole shadow.
fn floor_size(dice: &mut Dice, spin: DMat3, shadow: &Shadow) -> DVec2 {
    let back = spin.transpose();
    let local = shadow.border.iter().map(|p| level(back * DVec3::new(p.x, 0.0, p.y)).abs());
    let half = local.fold(DVec2::ZERO, DVec2::max);
    half * 2.0 * DVec2::new(dice.float(1.02, 2.0), dice.float(1.02, 2.0))
}

/// Judges the cases of `make` with these numbers; it may leave some out, and at least half must remain.
pub(crate) fn judge_all(title: &str, numbers: Range<u64>, make: impl Fn(&mut Dice) -> Option<Case>) {
    let mut wrong = Vec::new();
    let (mut judged, count) = (0, numbers.end - numbers.start);
    for number in numbers {
        let Some(case) = make(&mut Dice::new(title, number)) else { continue };
        judged += 1;
        if let Err(complaint) = case.judge(number) {
            wrong.push(format!("case {number}: {complaint}; {:?}", case.scene));
        }
    }
    assert!(2 * judged >= count, "only {judged} of {count} scenes have a certain truth");
    let shown = wrong.iter().take(3).cloned().collect::<Vec<_>>().join("\n");
    assert!(wrong.is_empty(), "{} of {judged} scenes are wrong:\n{shown}", wrong.len());
}
