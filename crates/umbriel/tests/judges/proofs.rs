//! Proofs are true: every point of a cell that is called lit or shadowed is so by the oracle.
//!
//! Small scenes with contacts, crossings, lights inside bodies, very near and in the planes of faces are baked at depths
//! 3 to 6; points of decided cells, their corners and edges included, are put to the oracle. `UMBRIEL_CASES` sets the
//! number of cells, and then each is asked at 100 points.

use crate::oracle::{
    Oracle, asked_cases, case_numbers, cases,
    dice::Dice,
    fixtures::{all, analytic, features, has_gaps, has_triangles, scene, tricky_light},
};
use crate::proving::Case;
use umbriel_geometry::{Analytic, LightSource, Placement};
use umbriel_scene::{Object, Scene, Sides};
use umbriel_shadow::{Cell, Verdict};

fn light_for(scene: &Scene, dice: &mut Dice) -> LightSource {
    let features = features(scene);
    let near = dice.pick(&features);
    match dice.below(4) {
        // Exactly in the planes of upright and level faces.
        0 => LightSource::sun(dice.pick(&[[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 1.0], [-1.0, -2.0, 0.0]]))
            .expect("a sun"),
        // Inside bodies, and inside the room.
        1 => LightSource::point(dice.pick(&[[0.0, 0.5, 0.0], [0.25, 1.0, 0.125], [1.0, 2.5, -1.0], [-1.0, 3.5, 2.0]]))
            .expect("a light"),
        // Very near a corner, an edge or a pole, on it, or through it.
        _ => tricky_light(dice, near, &features),
    }
}

/// Bakes every fixture `rounds` times and judges `cells` cells a bake.
fn judge_all(title: &str, rounds: u64, cells: u64, points: u64) {
    let (mut judged, mut wrong) = (0, Vec::new());
    for (name, scene) in &all() {
        let oracle = Oracle::new(scene);
        for round in 0..rounds {
            let mut dice = Dice::new(title, round);
            let depth = dice.pick(&[3, 4, 5, 6]);
            let case = Case::new(name, scene, light_for(scene, &mut dice), depth);
            let proved = case.proved();
            let verdicts = [Verdict::Lit, Verdict::Shadowed];
            // As many lit as shadowed cells, where there are both.
            for kind in verdicts {
                let of_kind: Vec<(usize, Cell)> =
                    proved.iter().copied().filter(|(_, cell)| cell.verdict == kind).collect();
                for _ in 0..if of_kind.is_empty() { 0 } else { cells.div_ceil(2) } {
                    judged += 1;
                    wrong.extend(case.judge(&oracle, dice.pick(&of_kind), points, &mut dice));
                }
            }
        }
    }
    assert!(judged > 0, "nothing was proved");
    let shown = wrong.iter().take(5).cloned().collect::<Vec<_>>().join("\n");
    assert!(wrong.is_empty(), "{} of {judged} proved cells are wrong:\n{shown}", wrong.len());
}

#[test]
fn proved_cells_are_true_at_every_point() {
    let bakes = all().len() as u64;
    let points = if asked_cases().is_some() { 100 } else { 8 };
    let cells_a_bake = 40;
    let rounds = cases(5_000).div_ceil(cells_a_bake * bakes);
    judge_all("proofs", rounds, cells_a_bake, points);
}

#[test]
fn cells_tile_their_faces() {
    for (name, scene) in &all() {
        let mut dice = Dice::new("tiles", 0);
        let case = Case::new(name, scene, light_for(scene, &mut dice), 4);
        let oracle = Oracle::new(scene);
        for object in &case.report.lights[0].objects {
            let body = &case.scene.objects[object.object];
            if has_gaps(&body.shape) {
                continue;
            }
            let is_mesh = has_triangles(&body.shape);
            // A face without area has no cells.
            let has_area = |&face: &usize| oracle.front(object.object, face, [0.0; 2]) != [0.0; 3];
            for face in (0..body.face_count()).filter(has_area) {
                let cells = object.cells.iter().filter(|cell| cell.face as usize == face);
                let share = |cell: &Cell| {
                    let is_cut = is_mesh && cell.i + cell.j + 1 == 1 << cell.level;
                    0.25f64.powi(i32::from(cell.level))
                        * if is_cut {
                            1.0
                        } else if is_mesh {
                            2.0
                        } else {
                            1.0
                        }
                };
                let covered: f64 = cells.map(share).sum();
                assert_eq!(covered, 1.0, "{name}: face {face} of {}", body.name);
            }
        }
    }
}

/// A quadric of whole and half numbers in a box, and a light on or inside of the box: at times in a corner or on a side, in the body or on it.
fn around_its_light(dice: &mut Dice) -> Option<(Scene, LightSource)> {
    let matrix: [[f64; 4]; 4] = std::array::from_fn(|row| {
        std::array::from_fn(|column| if row == column || dice.one_in(4) { dice.grid(2, 0.5) } else { 0.0 })
    });
    // Whether a way touches a plane counted twice, where the form does not change its sign, floats cannot tell.
    let twice = |i: usize, k: usize| matrix[i][k] + matrix[k][i];
    let is_double_plane = (0..16).all(|n| twice(n / 4, n % 4).powi(2) == twice(n / 4, n / 4) * twice(n % 4, n % 4));
    let [low, high] = [(); 2].map(|()| [(); 3].map(|()| dice.pick(&[0.5, 1.0, 2.0])));
    let position: [f64; 3] = std::array::from_fn(|k| dice.pick(&[-low[k], high[k], 0.0, 0.25, -0.25, 0.5 * high[k]]));
    let sides = dice.pick(&[Sides::One, Sides::Two, Sides::Two]);
    let shape = analytic(Analytic::Quadric { matrix, within: [low.map(|edge| -edge), high] });
    // Quadrics that are the same everywhere are refused.
    let body = Object::new("quadric".into(), shape, Placement::IDENTITY, sides).ok()?;
    (!is_double_plane).then(|| (scene(vec![body]), LightSource::point(position).expect("a light")))
}

#[test]
fn quadrics_around_their_light_are_proved() {
    let mut wrong = Vec::new();
    for case in case_numbers(60) {
        let mut dice = Dice::new("around", case);
        let Some((scene, light)) = around_its_light(&mut dice) else { continue };
        let case = Case::new(&format!("quadric {case}"), &scene, light, 6);
        let oracle = Oracle::new(&case.scene);
        let object = &case.report.lights[0].objects[0];
        // Slivers are all border at this depth.
        if object.undecided() > 0.05 * object.area && object.area > 0.5 {
            let shape = &case.scene.objects[0].shape;
            wrong.push(format!("{}: {} of {} is undecided of {shape:?}", case.title, object.undecided(), object.area));
        }
        let proved = case.proved();
        for _ in 0..if proved.is_empty() { 0 } else { 10 } {
            wrong.extend(case.judge(&oracle, dice.pick(&proved), 4, &mut dice));
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}
