//! Proofs are true in scenes that nobody would draw: soups of triangles that repeat, fold, cross and vanish, boxes and
//! spheres that touch and interpenetrate, lights on corners, edges and faces.
//!
//! Coordinates are small whole numbers and halves, so that degeneracies are exact and frequent; some are moved by an ulp
//! or two. Points of proved cells are put to the oracle, and to `Queries::lit` as well. What fails is made smaller before
//! it is shown. `UMBRIEL_CASES` sets the number of scenes.

use crate::chance::{any_light, any_scene};
use crate::oracle::{Oracle, case_numbers, dice::Dice, fixtures::scene};
use crate::proving::{Case, point_of};
use umbriel_geometry::{LightSource, Mesh};
use umbriel_scene::{Object, Scene, Shape};
use umbriel_shadow::{Place, Queries, Verdict};

/// Cells of one bake that are judged.
const CELLS: usize = 32;

/// Points of each.
const POINTS: u64 = 5;

/// What is wrong with some cells of a bake, if anything.
fn complaint(scene: &Scene, light: LightSource, depth: u8, cells: usize, dice: &mut Dice) -> Option<String> {
    let case = Case::new("random scene", scene, light, depth);
    let oracle = Oracle::new(scene);
    let queries = Queries::new(&case.scene);
    let all: Vec<_> = case.cells().collect();
    let count = if all.is_empty() { 0 } else { cells.min(2 * all.len()) };
    (0..count).find_map(|k| {
        let (object, cell) = if cells >= all.len() { all[k % all.len()] } else { dice.pick(&all) };
        let is_proved = cell.verdict != Verdict::Undecided;
        let wrong = is_proved.then(|| case.judge(&oracle, (object, cell), POINTS, dice)).flatten();
        if wrong.is_some() {
            return wrong;
        }
        let [u, v] = point_of(&cell, case.is_mesh(object), dice);
        if !oracle.has_point(object, cell.face as usize, [u, v]) {
            return None;
        }
        let place = Place::Surface { object, face: cell.face as usize, u, v };
        let expected = oracle.lit(object, cell.face as usize, [u, v], &light);
        match queries.lit(&place, &light) {
            Ok(answer) if answer.lit == expected => None,
            answer => Some(format!("{place:?} is answered {answer:?}, by definition {expected}")),
        }
    })
}

/// Leaves out objects and triangles as long as something stays wrong.
fn smallest(scene: &Scene, light: LightSource, depth: u8) -> String {
    let wrong =
        |scene: &Scene| (0..3).find_map(|seed| complaint(scene, light, depth, 4096, &mut Dice::new("smaller", seed)));
    let mut best = scene.clone();
    let mut text = wrong(&best).unwrap_or_else(|| "(does not repeat)".into());
    while let Some((smaller, complaint)) = parts(&best).into_iter().find_map(|part| wrong(&part).map(|w| (part, w))) {
        (best, text) = (smaller, complaint);
    }
    format!("{text}\n{:#?}", best.objects.iter().map(describe).collect::<Vec<_>>())
}

fn describe(object: &Object) -> String {
    format!("{:?} {:?} {:?}", object.shape, object.placement.map(), object.sides)
}

/// The scene without one of its objects, or without one triangle.
fn parts(whole: &Scene) -> Vec<Scene> {
    let mut parts = Vec::new();
    for left_out in 0..whole.objects.len() {
        let mut objects = whole.objects.to_vec();
        let object = objects.remove(left_out);
        parts.push(scene(objects));
        let Shape::Mesh(mesh) = &object.shape else { continue };
        for triangle in 0..mesh.triangles().len() {
            let mut triangles = mesh.triangles().to_vec();
            triangles.remove(triangle);
            let positions = mesh.positions().iter().map(|position| position.to_array()).collect();
            let smaller = Mesh::new(positions, triangles).expect("a part of a mesh");
            let mut objects = whole.objects.to_vec();
            let smaller = Object::new(object.name.clone(), Shape::Mesh(smaller.into()), object.placement, object.sides);
            objects[left_out] = smaller.expect("a part of an object");
            parts.push(scene(objects));
        }
    }
    parts.retain(|part| !part.objects.is_empty());
    parts
}

#[test]
fn proved_cells_of_random_scenes_are_true() {
    let wrong: Vec<String> = case_numbers(800)
        .filter_map(|number| {
            let mut dice = Dice::new("random", number);
            let scene = any_scene(&mut dice);
            let light = any_light(&scene, &mut dice);
            let depth = dice.pick(&[1, 2, 3, 4]);
            let found = complaint(&scene, light, depth, CELLS, &mut dice);
            found.map(|_| format!("scene {number}: {}", smallest(&scene, light, depth)))
        })
        .take(3)
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
