//! Proofs are true where thousands of triangles lie over each other, too many for all pairs of them to be measured.
//!
//! Soups whose triangles all share a corner, or an edge with the next, with corners short and long; points of proved cells, their corners and
//! edges included, are put to the oracle. `UMBRIEL_CASES` sets the number of soups.

use std::ops::Range;

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

/// Objects of one triangle each, more than are looked at pair by pair.
const OBJECTS: u32 = 7_000;

/// Triangles that share a corner, or an edge with the next.
fn soup(dice: &mut Dice, count: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let is_short = dice.one_in(2);
    let mut corner = |_| if is_short { dice.grid_point(8, 0.125) } else { [0; 3].map(|_| dice.float(-1.0, 1.0)) };
    let positions: Vec<[f64; 3]> = (0..count + 2).map(&mut corner).collect();
    let hub = dice.pick(&[true, false]);
    (positions, (0..count).map(|k| [if hub { 0 } else { k }, k + 1, k + 2]).collect())
}

fn throng(dice: &mut Dice) -> Scene {
    let (positions, triangles) = soup(dice, OBJECTS);
    let object = |(k, corners): (usize, &[u32; 3])| {
        let corners = corners.map(|corner| positions[corner as usize]);
        with_sides(&format!("{k}"), mesh(&corners, &[[0, 1, 2]]), DAffine3::IDENTITY, Sides::Two)
    };
    scene(triangles.iter().enumerate().map(object).collect())
}

fn crowd(dice: &mut Dice) -> Scene {
    let (positions, triangles) = soup(dice, TRIANGLES);
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
    proofs_are_true("crowds", case_numbers(3), crowd);
}

#[test]
fn proofs_in_throngs_are_true() {
    proofs_are_true("throngs", case_numbers(4), throng);
}

fn proofs_are_true(name: &str, numbers: Range<u64>, make: fn(&mut Dice) -> Scene) {
    let mut judged = [0; 2];
    for number in numbers {
        let mut dice = Dice::new(name, number);
        let (whole, light) = (make(&mut dice), any_light(&mut dice));
        let (case, oracle) = (Case::new("crowd", &whole, light, DEPTH), Oracle::new(&whole));
        let is_left = |cell: &Cell| cell.verdict == Verdict::Undecided && cell.level == DEPTH_IN_CROWDS;
        assert!(case.cells().any(|(_, cell)| is_left(&cell)), "crowd {number} is none");
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
