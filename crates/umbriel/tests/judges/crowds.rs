//! Proofs are true where thousands of triangles lie over each other, too many for all pairs of them to be measured.
//!
//! Soups whose triangles all share a corner, or an edge with the next, with corners short and long; points of proved cells, their corners and
//! edges included, are put to the oracle. `UMBRIEL_CASES` sets the number of soups.

use glam::DAffine3;
use umbriel_geometry::LightSource;
use umbriel_scene::{Scene, Sides};
use umbriel_shadow::{Cell, Verdict};

use crate::{
    oracle::{
        Oracle, case_numbers,
        dice::Dice,
        fixtures::{mesh, scene, with_sides},
    },
    proving::Case,
};

/// Of each of two objects: more pairs than are measured.
const TRIANGLES: u32 = 3_000;

/// As deep as cells are asked for, and as faces in crowds are divided.
const DEPTH: u8 = 4;
const DEPTH_IN_CROWDS: u8 = 3;

/// Cells of each verdict that are judged, and points of each.
const CELLS: usize = 12;
const POINTS: u64 = 3;

fn crowd(dice: &mut Dice) -> Scene {
    let is_short = dice.one_in(2);
    let mut corner = |_| if is_short { dice.grid_point(8, 0.125) } else { [0; 3].map(|_| dice.float(-1.0, 1.0)) };
    let positions: Vec<[f64; 3]> = (0..TRIANGLES + 2).map(&mut corner).collect();
    let hub = dice.pick(&[true, false]);
    let triangles: Vec<[u32; 3]> = (0..TRIANGLES).map(|k| [if hub { 0 } else { k }, k + 1, k + 2]).collect();
    let soup = mesh(&positions, &triangles);
    let object = |name: &str, map: DAffine3| with_sides(name, soup.clone(), map, Sides::Two);
    let aside = DAffine3::from_translation(dice.grid_point(2, 0.25).into());
    scene(vec![object("first", DAffine3::IDENTITY), object("second", aside)])
}

fn any_light(dice: &mut Dice) -> LightSource {
    let [x, y, z] = dice.grid_point(4, 1.0);
    match dice.one_in(2) {
        true => LightSource::sun([x, y - 0.5, z]).expect("a sun"),
        false => LightSource::point([x, y + 0.125, z]).expect("a lamp"),
    }
}

#[test]
fn proofs_in_crowds_are_true() {
    let mut judged = [0; 2];
    for number in case_numbers(3) {
        let mut dice = Dice::new("crowds", number);
        let (whole, light) = (crowd(&mut dice), any_light(&mut dice));
        let (case, oracle) = (Case::new("crowd", &whole, light, DEPTH), Oracle::new(&whole));
        assert!(case.cells().all(|(_, cell)| cell.level <= DEPTH_IN_CROWDS), "crowd {number} is none");
        let proved = case.proved();
        for verdict in [Verdict::Lit, Verdict::Shadowed] {
            let of_kind: Vec<(usize, Cell)> =
                proved.iter().copied().filter(|(_, cell)| cell.verdict == verdict).collect();
            judged[verdict as usize] += of_kind.len().min(CELLS);
            for _ in 0..CELLS.min(of_kind.len()) {
                let wrong = case.judge(&oracle, dice.pick(&of_kind), POINTS, &mut dice);
                assert_eq!(wrong, None, "crowd {number}");
            }
        }
    }
    assert!(judged.iter().all(|&judged| judged >= CELLS), "lit and shadowed cells judged: {judged:?}");
}
