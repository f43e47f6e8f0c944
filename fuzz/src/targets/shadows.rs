//! Small scenes made from bytes: bounds nest, cells cover, and what is proved is true by definition.

use umbriel_geometry::Analytic;
use umbriel_shadow::{ObjectReport, Verdict};

use crate::{
    chance::{any_light, any_scene},
    oracle::{Oracle, dice::Dice},
    proving::Case,
};

/// Proved cells that are put to the oracle, and points of each.
const CELLS: usize = 8;
const POINTS: u64 = 2;

pub(super) fn shadows(bytes: &[u8]) {
    let mut dice = Dice::of_bytes(bytes);
    let depth = 1 + dice.below(3) as u8;
    let scene = any_scene(&mut dice);
    let light = any_light(&scene, &mut dice);
    let coarse = Case::new("bytes", &scene, light, depth);
    let fine = Case::new("bytes", &scene, light, depth + 1);
    for (coarse_report, fine_report) in reports(&coarse).zip(reports(&fine)) {
        are_sums(coarse_report);
        are_sums(fine_report);
        do_nest(coarse_report, fine_report);
        cover(&fine, fine_report);
    }
    let oracle = Oracle::new(&scene);
    let proved = fine.proved();
    for _ in 0..CELLS.min(proved.len()) {
        let cell = dice.pick(&proved);
        if let Some(complaint) = fine.judge(&oracle, cell, POINTS, &mut dice) {
            panic!("{complaint}");
        }
    }
}

fn reports(case: &Case) -> impl Iterator<Item = &ObjectReport> {
    case.report.lights.iter().flat_map(|light| &light.objects)
}

/// How far sums that are rounded outward, and areas with errors, may be off.
fn slack(report: &ObjectReport) -> f64 {
    2.0 * report.area_error + report.area * 2f64.powi(-40)
}

fn are_sums(report: &ObjectReport) {
    let lit = report.lit;
    assert!(0.0 <= lit.lower && lit.lower <= lit.estimate && lit.estimate <= lit.upper, "{lit:?}");
    assert!(lit.upper <= report.area + slack(report), "{lit:?} of {}", report.area);
}

fn do_nest(coarse: &ObjectReport, fine: &ObjectReport) {
    let slack = slack(coarse) + slack(fine);
    let nests = coarse.lit.lower <= fine.lit.lower + slack && fine.lit.upper <= coarse.lit.upper + slack;
    assert!(nests, "{:?} does not hold {:?}", coarse.lit, fine.lit);
}

/// The cells of each face are all of its parameter square, or of the half that belongs to a triangle: lit, shadowed and
/// undecided parts add up. Shares are dyadic, so the sum is exact. A face without area has no cells, and a sheet of a general
/// quadric fills its square in part only.
fn cover(case: &Case, report: &ObjectReport) {
    let is_mesh = case.is_mesh(report.object);
    let mut shares = vec![0.0; case.scene.objects[report.object].face_count()];
    for cell in &report.cells {
        assert!(matches!(cell.verdict, Verdict::Lit | Verdict::Shadowed | Verdict::Undecided));
        let is_cut = is_mesh && cell.i + cell.j + 1 == 1 << cell.level;
        let of_face = if is_mesh && !is_cut { 2.0 } else { 1.0 };
        shares[cell.face as usize] += of_face * 0.25f64.powi(i32::from(cell.level));
    }
    let object = &case.scene.objects[report.object];
    let is_sheet = matches!(object.shape.analytic(), Some(Analytic::Quadric { .. }));
    let is_whole = |&share: &f64| share == 1.0 || share == 0.0 || is_sheet && (0.0..1.0).contains(&share);
    assert!(shares.iter().all(is_whole), "{:?}: {shares:?}", object.shape);
}
