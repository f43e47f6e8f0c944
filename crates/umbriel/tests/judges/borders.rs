//! The two methods for flat faces are set against each other and against the oracle: drawing borders proves nothing
//! false, never contradicts the quadtree, and leaves little more undecided.
//!
//! The scenes are those of the random judge, full of exact coincidences, and the fixtures. `UMBRIEL_CASES` sets the number
//! of scenes.

use std::collections::HashMap;

use crate::chance::{any_light, any_scene};
use crate::oracle::{
    Oracle, cases,
    dice::Dice,
    fixtures::{all, features, mesh, rectangle, scene, tricky_light, with_sides},
};
use crate::proving::Case;
use glam::DAffine3;
use umbriel_geometry::{Cuboid, LightSource};
use umbriel_scene::{Scene, Sides};
use umbriel_shadow::{Cell, CellMethod, ObjectReport, Verdict};

/// Cells of one bake that are put to the oracle.
const CELLS: usize = 24;

/// The first cell in one report that contradicts a cell of the other which holds it or lies in it.
fn contradiction(a: &ObjectReport, b: &ObjectReport) -> Option<(Cell, Cell)> {
    let place = |cell: &Cell| (cell.face, cell.level, cell.i, cell.j);
    let proved = |cell: &&Cell| cell.verdict != Verdict::Undecided;
    let holders = |from: &[Cell], cell: Cell, known: &HashMap<_, usize>| {
        let up = |levels: u8| (cell.face, cell.level - levels, cell.i >> levels, cell.j >> levels);
        let found = (0..=cell.level).find_map(|levels| known.get(&up(levels)).copied());
        found.map(|k| from[k]).filter(|other| proved(&other) && other.verdict != cell.verdict)
    };
    [(a, b), (b, a)].into_iter().find_map(|(one, other)| {
        let known: HashMap<_, usize> = other.cells.iter().enumerate().map(|(k, cell)| (place(cell), k)).collect();
        let mut cells = one.cells.iter().filter(proved);
        cells.find_map(|&cell| holders(&other.cells, cell, &known).map(|holder| (cell, holder)))
    })
}

/// What is wrong with a bake by borders, if anything; adds the undecided shares by borders and by quadtree.
fn complaint(
    scene: &Scene,
    light: LightSource,
    depth: u8,
    dice: &mut Dice,
    undecided: &mut [f64; 2],
) -> Option<String> {
    let case = Case::by(CellMethod::Borders, "borders", scene, light, depth);
    let divided = Case::by(CellMethod::Quadtree, "quadtree", scene, light, depth);
    for (a, b) in case.report.lights[0].objects.iter().zip(&divided.report.lights[0].objects) {
        if let Some((cell, other)) = contradiction(a, b) {
            return Some(format!("object {}: {cell:?} by borders or quadtree, {other:?} by the other", a.object));
        }
        undecided[0] += a.undecided() / a.area.max(f64::MIN_POSITIVE);
        undecided[1] += b.undecided() / b.area.max(f64::MIN_POSITIVE);
    }
    let oracle = Oracle::new(scene);
    let proved = case.proved();
    let count = if proved.is_empty() { 0 } else { CELLS };
    (0..count).find_map(|_| case.judge(&oracle, dice.pick(&proved), 4, dice))
}

/// Bakes made scenes under a light at a depth by borders: nothing wrong is proved, and little more undecided than by a quadtree.
fn all_are_right(name: &str, make: impl Fn(&mut Dice) -> (Scene, LightSource, u8)) {
    let mut undecided = [0.0; 2];
    let wrong: Vec<String> = (0..cases(400))
        .filter_map(|number| {
            let mut dice = Dice::new(name, number);
            let (scene, light, depth) = make(&mut dice);
            let found = complaint(&scene, light, depth, &mut dice, &mut undecided);
            found.map(|text| format!("scene {number} under {light:?} at depth {depth}: {text}"))
        })
        .collect();
    let shown = wrong.iter().take(3).cloned().collect::<Vec<_>>().join("\n");
    assert!(wrong.is_empty(), "{} wrong:\n{shown}", wrong.len());
    let [by_borders, by_quadtree] = undecided;
    assert!(by_borders < 1.3 * by_quadtree, "undecided by borders {by_borders}, by quadtree {by_quadtree}");
}

#[test]
fn borders_prove_what_is_true_of_random_scenes() {
    all_are_right("borders", |dice| {
        let mut scene = any_scene(dice);
        let light = any_light(&scene, dice);
        // Borders are of flat faces only.
        scene.objects.retain(|object| object.analytic().is_none());
        (scene, light, dice.pick(&[2, 3, 4, 5, 6]))
    });
}

#[test]
fn borders_prove_what_is_true_of_the_fixtures() {
    for (name, scene) in &mut all() {
        scene.objects.retain(|object| object.analytic().is_none());
        if scene.objects.is_empty() {
            continue;
        }
        for round in 0..cases(300) / 100 {
            let mut dice = Dice::new("borders of fixtures", round);
            let features = features(scene);
            let near = dice.pick(&features);
            let light = match dice.below(3) {
                0 => LightSource::sun(dice.pick(&[
                    [0.0, -1.0, 0.0],
                    [1.0, 0.0, 0.0],
                    [0.0, -1.0, 1.0],
                    [-1.0, -2.0, 0.0],
                ]))
                .expect("a sun"),
                1 => LightSource::point(dice.pick(&[[0.0, 0.5, 0.0], [0.25, 1.0, 0.125], [1.0, 2.5, -1.0]]))
                    .expect("a light"),
                _ => tricky_light(&mut dice, near, &features),
            };
            let depth = dice.pick(&[3, 5, 6]);
            let found = complaint(scene, light, depth, &mut dice, &mut [0.0; 2]);
            assert_eq!(found, None, "{name} under {light:?} at depth {depth}");
        }
    }
}

/// A solid over the floor, on it by a face, an edge or a corner, or through it, and mostly convex: its corners and triangles.
fn standing(dice: &mut Dice) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let at = [0, 1].map(|_| dice.pick(&[-1.0, -0.5, -0.375, 0.0, 0.125, 0.5, 1.0]));
    let lift = dice.pick(&[0.0, 0.0, 0.0, 0.25, -0.25]);
    let (size, high) = (dice.pick(&[0.25, 0.375, 0.75]), dice.pick(&[0.125, 0.5, 1.0]));
    let lean = [0, 1].map(|_| dice.pick(&[0.0, 0.0, 0.25, -0.5]));
    let place = |[x, y, z]: [f64; 3]| {
        let [a, b] = [size * x + lean[0] * y, size * z + lean[1] * y];
        [at[0] + a - 0.25 * b, lift + high * y, at[1] + b + 0.25 * a]
    };
    let (corners, triangles) = match dice.below(4) {
        0 | 1 => {
            let mut corners = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(f64::from)).collect::<Vec<_>>();
            if dice.below(4) == 0 {
                // Out of a plane of its sides, to one side or the other.
                corners[7] = dice.pick(&[[0.5, 1.0, 0.5], [0.75, 0.75, 0.75], [1.25, 1.0, 1.25]]);
            }
            (corners, Cuboid::FACES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
        }
        kind => {
            // A tetrahedron on a face or on an edge, or upside down.
            let [two, three] = [f64::from(u32::from(kind == 3)), 1.0];
            let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, two, 1.0], [0.25, three, 0.25]];
            (corners, vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
        }
    };
    let is_upside_down = dice.below(4) == 0;
    let turned = |[x, y, z]: [f64; 3]| if is_upside_down { [x, 1.0 - y, z] } else { [x, y, z] };
    (corners.into_iter().map(|corner| place(turned(corner))).collect(), triangles)
}

/// Solids that stand on the floor are drawn by their outlines, several in one mesh or each by itself, and beside sheets that meet the floor.
#[test]
fn what_stands_on_the_floor_is_proved() {
    all_are_right("standing", |dice| {
        let mut objects = vec![with_sides("floor", rectangle(3.0, 3.0), DAffine3::IDENTITY, Sides::Auto)];
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        let solids = 1 + dice.below(6);
        for number in 1..=solids {
            let (corners, mut own) = standing(dice);
            if dice.below(8) == 0 {
                own.pop();
            }
            let first = positions.len() as u32;
            positions.extend(corners);
            triangles.extend(own.iter().map(|corners| corners.map(|corner| first + corner)));
            if dice.below(2) == 0 || number == solids {
                objects.push(with_sides("solids", mesh(&positions, &triangles), DAffine3::IDENTITY, Sides::Two));
                (positions, triangles) = (Vec::new(), Vec::new());
            }
        }
        let scene = scene(objects);
        let features = features(&scene);
        let near = dice.pick(&features);
        let light = match dice.below(3) {
            0 => LightSource::sun(dice.pick(&[[0.0, -1.0, 0.0], [1.0, -1.0, 0.25], [-0.5, -0.5, 1.0]])).expect("a sun"),
            1 => LightSource::point(dice.pick(&[[0.0, 2.0, 0.0], [0.25, 1.25, 0.125], [2.0, 0.75, -1.0]]))
                .expect("a lamp"),
            _ => tricky_light(dice, near, &features),
        };
        (scene, light, dice.pick(&[4, 6]))
    });
}

/// A triangle without area that runs over the floor's side and through the floor: what it touches is not proved lit.
#[test]
fn a_triangle_without_area_shadows_a_line() {
    let floor = with_sides("floor", rectangle(2.0, 2.0), DAffine3::IDENTITY, Sides::Auto);
    let needle = mesh(&[[-2.0, 1.0, 0.0], [-1.5, 0.75, 0.0], [2.0, -1.0, 0.0]], &[[0, 1, 2]]);
    let needle = with_sides("needle", needle, DAffine3::IDENTITY, Sides::Auto);
    let overhead = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
    let case = Case::by(CellMethod::Borders, "needle", &scene(vec![floor, needle]), overhead, 4);
    let touched = case.cells().filter(|(object, cell)| {
        let edge = 0.5f64.powi(i32::from(cell.level));
        let [u, v] = [cell.i, cell.j].map(|k| f64::from(k) * edge);
        *object == 0 && u < 0.5 && v <= 0.5 && v + edge >= 0.5
    });
    let verdicts: Vec<Verdict> = touched.map(|(_, cell)| cell.verdict).collect();
    assert!(verdicts.len() > 8 && verdicts.iter().all(|&verdict| verdict == Verdict::Undecided), "{verdicts:?}");
}

/// What stands on the floor along a line or at a point does not block there: no cell with a point of contact that the sun reaches is proved shadowed.
#[test]
fn contact_within_a_shadow_is_not_proved_shadowed() {
    let [near, far] = [0.2, 0.4];
    let to_the_left = [[-0.8, 0.0, 0.3], [0.8, 0.0, 0.3], [0.8, 0.5, -near], [-0.8, 0.5, -near]];
    let to_the_right = [[-0.8, 0.0, 0.3], [0.8, 0.0, 0.3], [0.8, 0.5, 0.6 + near], [-0.8, 0.5, 0.6 + near]];
    let quad = [[0, 1, 2], [0, 2, 3]];
    let both: Vec<[f64; 3]> = to_the_left.iter().chain(&to_the_right).copied().collect();
    let gutter = vec![mesh(&both, &[[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])];
    let two_sheets = vec![mesh(&to_the_left, &quad), mesh(&to_the_right, &quad)];
    let rim =
        [[-far, 0.5, -far], [far, 0.5, -far], [far, 0.5, far], [-far, 0.5, far]].map(|[x, y, z]| [x + 0.3, y, z + 0.3]);
    let funnel = mesh(&[&rim[..], &[[0.3, 0.0, 0.3]]].concat(), &[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]);
    let blades = (0..3).map(|blade| {
        let at = |degrees: f64| [0.3 + 0.5 * degrees.to_radians().cos(), 0.5, 0.3 + 0.5 * degrees.to_radians().sin()];
        let start = 120.0 * f64::from(blade);
        mesh(&[[0.3, 0.0, 0.3], at(start), at(start + 130.0)], &[[0, 1, 2]])
    });
    let line: Vec<f64> = (-7..=7).map(|k| 0.1 * f64::from(k)).collect();
    for (name, bodies, along) in [
        ("gutter", gutter, &line[..]),
        ("two sheets", two_sheets, &line[..]),
        ("funnel", vec![funnel], &[0.3][..]),
        ("pinwheel", blades.collect(), &[0.3][..]),
    ] {
        let floor = with_sides("floor", rectangle(2.0, 2.0), DAffine3::IDENTITY, Sides::Auto);
        let bodies = bodies.into_iter().map(|body| with_sides("body", body, DAffine3::IDENTITY, Sides::Auto));
        let scene = scene(std::iter::once(floor).chain(bodies).collect());
        let overhead = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
        let case = Case::by(CellMethod::Borders, name, &scene, overhead, 5);
        let facets = scene.objects[0].facets().expect("a flat floor");
        let [a, b, d] = [0, 1, 3].map(|corner| facets.positions()[facets.facet(0).corners()[corner] as usize]);
        let cells: Vec<Cell> = case.cells().filter(|(object, _)| *object == 0).map(|(_, cell)| cell).collect();
        let holds = |cell: &Cell, x: f64| {
            let edge = 0.5f64.powi(i32::from(cell.level));
            let way = glam::DVec3::new(x, 0.0, 0.3) - a;
            let place = [b - a, d - a].map(|side| way.dot(side) / side.length_squared() / edge);
            (place[0] - f64::from(cell.i) - 0.5).abs() <= 0.5 && (place[1] - f64::from(cell.j) - 0.5).abs() <= 0.5
        };
        for &x in along {
            let verdicts: Vec<Verdict> = cells.iter().filter(|cell| holds(cell, x)).map(|cell| cell.verdict).collect();
            assert!(!verdicts.is_empty() && !verdicts.contains(&Verdict::Shadowed), "{name} at {x}: {verdicts:?}");
        }
        assert!(cells.iter().any(|cell| cell.verdict == Verdict::Shadowed), "{name} casts a shadow");
    }
}
