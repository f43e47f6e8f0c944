//! What can be told of a result without believing the code that made it.
//!
//! Areas by formula or by adding up triangles; lit areas by closed forms; bounds in their order; and the verdicts of
//! some cells against exact queries, which go another way (rays, not projections).

use std::f64::consts::PI;

use anyhow::Result;
use glam::DMat3;
use umbriel_geometry::Analytic;
use umbriel_scene::{Object, Shape};
use umbriel_shadow::{Cell, LightReport, ObjectReport, Place, Queries, Verdict};

use super::{Baked, closed_forms};
use crate::fixtures::SplitMix64;

/// Relative slack of the formulas here, which are computed in plain floating point.
const FORMULA_SLACK: f64 = 1e-12;
/// Relative slack of areas that are added up triangle by triangle.
const SUM_SLACK: f64 = 1e-9;
/// Cells of an object under a light whose verdicts are compared with queries.
const ASKED_CELLS: usize = 16;

/// How many things were checked, and which were wrong.
#[derive(Debug, Default)]
pub(super) struct Sanity {
    areas: usize,
    closed_forms: usize,
    cells: usize,
    undecided: f64,
    area: f64,
    pub(super) complaints: Vec<String>,
}

impl Sanity {
    pub(super) fn of(baked: &Baked) -> Result<Self> {
        let mut sanity = Self::default();
        let queries = Queries::new(&baked.loaded.scene);
        let mut random = SplitMix64::new(7);
        for light in &baked.report.lights {
            for object in &light.objects {
                sanity.check_area(baked, object);
                sanity.check_order(baked, light, object);
                sanity.check_cells(baked, light, object, (&queries, &mut random))?;
                sanity.undecided += object.undecided();
                sanity.area += object.area;
            }
        }
        sanity.check_closed_forms(baked);
        Ok(sanity)
    }

    /// A row of the table.
    pub(super) fn summary(&self) -> String {
        format!(
            "{:5.2} % undecided; agree: {} areas, {} closed forms, {} cells",
            100.0 * self.undecided / self.area,
            self.areas,
            self.closed_forms,
            self.cells
        )
    }

    fn check_area(&mut self, baked: &Baked, report: &ObjectReport) {
        let object = &baked.loaded.scene.objects[report.object];
        let Some(area) = area_of(object) else { return };
        self.areas += 1;
        if (report.area - area).abs() > SUM_SLACK * area {
            self.complaints.push(format!("the area of {} is {}, should be {area}", object.name, report.area));
        }
    }

    fn check_order(&mut self, baked: &Baked, light: &LightReport, report: &ObjectReport) {
        let lit = report.lit;
        let most = report.area * (1.0 + SUM_SLACK);
        if !(0.0 <= lit.lower && lit.lower <= lit.estimate && lit.estimate <= lit.upper && lit.upper <= most) {
            let names = names(baked, light, report);
            self.complaints.push(format!("{names}: the bounds are out of order: {lit:?} of {}", report.area));
        }
    }

    fn check_closed_forms(&mut self, baked: &Baked) {
        let scene = &baked.loaded.scene;
        for form in closed_forms::all().iter().filter(|form| form.fixture == baked.name) {
            let light = baked.report.lights.iter().find(|light| scene.lights[light.light].name == form.light);
            let mut objects = light.iter().flat_map(|light| &light.objects);
            let Some(object) = objects.find(|report| scene.objects[report.object].name == form.object) else {
                self.complaints.push(format!("there is no {} under a light {}", form.object, form.light));
                continue;
            };
            self.closed_forms += 1;
            let slack = FORMULA_SLACK * object.area;
            if form.lit < object.lit.lower - slack || object.lit.upper + slack < form.lit {
                let (lower, upper) = (object.lit.lower, object.lit.upper);
                self.complaints.push(format!(
                    "{}, {}: {} is lit by formula, but the bounds are {lower} and {upper}",
                    form.light, form.object, form.lit
                ));
            }
        }
    }

    fn check_cells(
        &mut self,
        baked: &Baked,
        light: &LightReport,
        report: &ObjectReport,
        (queries, random): (&Queries, &mut SplitMix64),
    ) -> Result<()> {
        let proved: Vec<&Cell> = report.cells.iter().filter(|cell| cell.verdict != Verdict::Undecided).collect();
        for _ in 0..ASKED_CELLS.min(proved.len()) {
            let cell = proved[random.below(proved.len())];
            let place = place_in(cell, report.object, random);
            let answer = queries.lit(&place, &baked.loaded.scene.lights[light.light].source)?;
            self.cells += 1;
            if answer.lit != (cell.verdict == Verdict::Lit) {
                let names = names(baked, light, report);
                self.complaints.push(format!("{names}: {cell:?}, but {place:?} is lit: {}", answer.lit));
            }
        }
        Ok(())
    }
}

fn names(baked: &Baked, light: &LightReport, report: &ObjectReport) -> String {
    let scene = &baked.loaded.scene;
    format!("{}, {}", scene.lights[light.light].name, scene.objects[report.object].name)
}

/// A point of a cell, on its border at times; in the lower half, so that it is on a triangle's cut cells too.
fn place_in(cell: &Cell, object: usize, random: &mut SplitMix64) -> Place {
    let s = random.sixteenths(0, 1);
    let t = random.sixteenths(0, 1).min(1.0 - s);
    let [u, v] = cell.point([s, t]);
    Place::Surface { object, face: cell.face as usize, u, v }
}

/// The area of a body by formula; none for a ball that is no ball any more.
fn area_of(object: &Object) -> Option<f64> {
    let m = object.placement.map().matrix3;
    match &object.shape {
        Shape::Rectangle(body) => Some(m.x_axis.cross(m.z_axis).length() * body.size[0] * body.size[1]),
        Shape::Cuboid(body) => {
            let [x, y, z] = body.size;
            let [a, b, c] = [m.x_axis * x, m.y_axis * y, m.z_axis * z];
            Some(2.0 * (a.cross(b).length() + b.cross(c).length() + c.cross(a).length()))
        }
        Shape::Analytic(body) => {
            let Analytic::Sphere { radius } = **body else { return None };
            uniform_scale(&m).map(|scale| 4.0 * PI * (radius * scale).powi(2))
        }
        Shape::Mesh(mesh) => {
            let place = |corner: u32| object.placement.map().transform_point3(mesh.positions()[corner as usize]);
            let area = |[a, b, c]: [u32; 3]| (place(b) - place(a)).cross(place(c) - place(a)).length() / 2.0;
            Some(mesh.triangles().iter().copied().map(area).sum())
        }
        _ => None,
    }
}

/// The factor of a matrix that scales all directions alike.
fn uniform_scale(m: &DMat3) -> Option<f64> {
    let scale = m.x_axis.length();
    let gram = m.transpose() * *m;
    let off = gram - DMat3::from_diagonal(glam::DVec3::splat(scale * scale));
    let largest = off.to_cols_array().into_iter().fold(0.0_f64, |most, entry| most.max(entry.abs()));
    (largest <= FORMULA_SLACK * scale * scale).then_some(scale)
}
