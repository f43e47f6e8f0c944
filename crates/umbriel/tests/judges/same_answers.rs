//! What must not change the answer: the scale (powers of two), the order of the axes and their signs, the order of objects and
//! of triangles, the number of threads.
//!
//! None of them changes a bit of cells or of areas; `metamorphic` asks for more ways and more changes in fewer scenes.

use std::collections::BTreeMap;

use crate::chance::{any_light, any_scene};
use crate::oracle::{
    case_numbers,
    dice::Dice,
    fixtures::{elsewhere, scene, with_sides},
};
use crate::proving::Case;
use crate::shuffle::Shuffled;
use glam::{DAffine3, DMat3, DVec3};
use umbriel_geometry::LightSource;
use umbriel_scene::Scene;
use umbriel_shadow::{Cell, ObjectReport, Verdict};

/// A bake's answers, one an object.
fn answers(scene: &Scene, light: LightSource) -> Vec<ObjectReport> {
    let mut case = Case::new("the same", scene, light, 3);
    case.report.lights.remove(0).objects
}

/// Whether all sums are equal, after a factor, and all cells as well.
fn same(a: &ObjectReport, b: &ObjectReport, factor: f64) -> bool {
    let sums = |report: &ObjectReport| [report.area, report.lit.lower, report.lit.upper, report.lit.estimate];
    sums(a).map(|sum| sum * factor) == sums(b) && a.cells == b.cells
}

fn light_from(light: &LightSource, change: impl Fn(DVec3) -> DVec3) -> LightSource {
    let xyz = change(light.xyz()).to_array();
    let changed = if light.is_sun() { LightSource::sun(xyz.map(|c| -c)) } else { LightSource::point(xyz) };
    changed.expect("a light")
}

/// Bakes random scenes as they are and changed; `compare` says what differs.
fn judge(title: &str, compare: impl Fn(&Scene, LightSource, &mut Dice) -> Option<String>) {
    let numbers = case_numbers(200);
    let count = numbers.end - numbers.start;
    let wrong: Vec<String> = numbers
        .filter_map(|number| {
            let mut dice = Dice::new(title, number);
            let scene = any_scene(&mut dice);
            let light = any_light(&scene, &mut dice);
            compare(&scene, light, &mut dice).map(|text| format!("scene {number}: {text}"))
        })
        .collect();
    let shown = wrong[..wrong.len().min(3)].join("\n");
    assert!(wrong.is_empty(), "{} of {count}: {shown}", wrong.len());
}

/// Whether two bakes of one surface can both be true: the bounds overlap, and no cell is lit in one, shadowed in the
/// other.
fn agree(a: &ObjectReport, b: &ObjectReport) -> bool {
    let proved = |report: &ObjectReport| -> BTreeMap<(u32, u8, u32, u32), Verdict> {
        let place = |cell: &Cell| (cell.face, cell.level, cell.i, cell.j);
        let cells = report.cells.iter().filter(|cell| cell.verdict != Verdict::Undecided);
        cells.map(|cell| (place(cell), cell.verdict)).collect()
    };
    let (first, second) = (proved(a), proved(b));
    let contradicts = first.iter().any(|(place, verdict)| second.get(place).is_some_and(|other| other != verdict));
    !contradicts && a.lit.lower <= b.lit.upper && b.lit.lower <= a.lit.upper
}

fn first_difference(a: &[ObjectReport], b: &[ObjectReport], factor: f64) -> Option<String> {
    assert!(a.iter().zip(b).all(|(a, b)| factor != 1.0 || agree(a, b)), "proofs contradict each other");
    let pair = a.iter().zip(b).find(|(a, b)| !same(a, b, factor))?;
    let cell = |x: &ObjectReport, y: &ObjectReport| x.cells.iter().find(|cell| !y.cells.contains(cell)).copied();
    let cells: [Option<Cell>; 2] = [cell(pair.0, pair.1), cell(pair.1, pair.0)];
    Some(format!(
        "object {}: {:?} {:?} or {:?} {:?}, {} {} {cells:?}",
        pair.0.object,
        pair.0.area,
        pair.0.lit,
        pair.1.area,
        pair.1.lit,
        pair.0.cells.len(),
        pair.1.cells.len()
    ))
}

#[test]
fn powers_of_two() {
    judge("scale", |scene, light, dice| {
        // Beyond what numbers of 32 bits hold, too; much smaller, matrices would have entries that are not accepted.
        let factor = 2f64.powi(dice.pick(&[-60, 20, 60, 150]));
        let scaled = elsewhere(&scene.objects, factor, DVec3::ZERO);
        let changed = answers(&scaled, light_from(&light, |xyz| xyz * factor));
        first_difference(&answers(scene, light), &changed, factor * factor)
    });
}

#[test]
fn axes_in_turn_and_mirrored() {
    let maps = [
        DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
        DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y),
        DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0)),
    ];
    judge("axes", |whole, light, dice| {
        let map = DAffine3::from_mat3(dice.pick(&maps));
        let moved = whole
            .objects
            .iter()
            .map(|object| with_sides(&object.name, object.shape.clone(), map * *object.placement.map(), object.sides));
        let changed = answers(&scene(moved.collect()), light_from(&light, |xyz| map.transform_vector3(xyz)));
        first_difference(&answers(whole, light), &changed, 1.0)
    });
}

#[test]
fn objects_in_another_order() {
    judge("objects", |whole, light, dice| same_in_order(whole, light, &Shuffled::objects(whole, dice)));
}

#[test]
fn triangles_in_another_order() {
    judge("triangles", |whole, light, dice| same_in_order(whole, light, &Shuffled::triangles(whole, dice)));
}

fn same_in_order(whole: &Scene, light: LightSource, shuffled: &Shuffled) -> Option<String> {
    let changed = shuffled.back(&answers(&shuffled.scene, light));
    first_difference(&answers(whole, light), &changed, 1.0)
}

#[test]
fn one_thread_or_many() {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let (one, many) = (pool(1), pool(7));
    judge("threads", |scene, light, _| {
        let alone = one.install(|| answers(scene, light));
        first_difference(&alone, &many.install(|| answers(scene, light)), 1.0)
    });
}
