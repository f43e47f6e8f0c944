//! Does a curved body block a segment? The library against the oracle, on segments made to touch.
//!
//! Every kind of body under every kind of placement; two segments in three are exact tangents, rulings, chords through
//! apexes and rims, lines in the planes of caps and along axes, with ends on the surface, or any of these moved by an
//! ulp or two. `UMBRIEL_CASES` sets the number of segments for each kind of body.

use crate::oracle::{
    blocking::{Lamp, Place},
    cases,
    dice::Dice,
    graze::{Segment, Subject, Target, aimed_light, maps, segment, short_segment, subjects},
    number::vector,
};
use glam::DVec3;
use umbriel_geometry::{Analytic, Dyadic, LightSource, PlacedAnalytic, Placement, Sign, blocking::Probe};

/// What the definition says.
fn by_definition(target: &Target, segment: &Segment) -> bool {
    target.curved.blocks(&Place::new(vector(segment.x)), &Lamp::new(&segment.light))
}

/// What the library says.
fn by_library(target: &PlacedAnalytic, segment: &Segment) -> bool {
    let x = Probe::<Dyadic>::at(DVec3::from_array(segment.x));
    target.blocks(&x, None, &segment.light)
}

/// What came of many segments: how many are free and blocked, and what is wrong.
#[derive(Debug, Default)]
struct Outcome {
    answers: [u64; 2],
    wrong: Vec<String>,
}

/// Puts `count` segments of one subject to `judge`, spread over all placements.
fn judge(subject: &Subject, count: u64, judge: impl Fn(&Target, &Segment) -> Result<bool, String>) -> Outcome {
    let maps = maps();
    let share = count.div_ceil(maps.len() as u64);
    let mut outcome = Outcome::default();
    for (place, map) in maps.into_iter().enumerate() {
        let target = Target::new(subject, map);
        for number in 0..share {
            let mut dice = Dice::new("segments", number + share * place as u64);
            let segment = segment(subject, &target, &mut dice);
            match judge(&target, &segment) {
                Ok(blocked) => outcome.answers[usize::from(blocked)] += 1,
                Err(complaint) => {
                    let name = subject.name;
                    outcome.wrong.push(format!("{name}, placement {place}, case {number}: {segment:?}: {complaint}"));
                }
            }
        }
    }
    outcome
}

/// Holds the library against the definition on segments aimed at these bodies.
fn compare(subjects: &[Subject], count: u64) {
    let mut wrong = Vec::new();
    for subject in subjects {
        let outcome = judge(subject, count, |target, segment| {
            let placed = PlacedAnalytic::new(subject.body, target.placement).expect("an accepted body");
            let (library, expected) = (by_library(&placed, segment), by_definition(target, segment));
            if library == expected { Ok(expected) } else { Err(format!("{library}, by definition {expected}")) }
        });
        let some = outcome.wrong.iter().take(3).cloned().collect::<Vec<_>>().join("\n");
        if !outcome.wrong.is_empty() {
            wrong.push(format!("{} of {count}:\n{some}", outcome.wrong.len()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn segments_are_blocked_as_the_definition_says() {
    compare(&subjects(), cases(4_000));
}

#[test]
fn segments_at_bodies_of_any_size_are_blocked_as_the_definition_says() {
    let curved: Vec<Subject> = subjects().into_iter().filter(|subject| !is_quadric(subject)).collect();
    for factor in [1.0 / 3.0, 0.1, 1e-5 / 7.0, 1e9 / 11.0] {
        let resized: Vec<Subject> = curved.iter().map(|subject| subject.scaled(factor)).collect();
        compare(&resized, cases(10_000) / 10);
    }
}

fn is_quadric(subject: &Subject) -> bool {
    matches!(subject.body, Analytic::Quadric { .. })
}

#[test]
fn both_answers_are_common() {
    for subject in subjects() {
        let answers = judge(&subject, cases(1_200) / 10, |target, segment| Ok(by_definition(target, segment))).answers;
        let total = answers[0] + answers[1];
        assert!(answers.iter().all(|&count| 10 * count > total), "{}: {answers:?} free and blocked", subject.name);
    }
}

#[test]
fn exact_placements_change_no_answer() {
    // Tangents stay tangents: the image of a segment meets the image of a body when the segment meets the body.
    for subject in subjects() {
        let exact = maps().into_iter().take(8).map(|map| Target::new(&subject, map)).collect::<Vec<_>>();
        for number in 0..cases(10_000) / 50 {
            let mut dice = Dice::new("placements", number);
            let local = short_segment(&subject, &mut dice);
            let answers = exact.iter().map(|target| by_definition(target, &target.carried(&local)));
            let answers: Vec<bool> = answers.collect();
            assert!(answers.iter().all(|&answer| answer == answers[0]), "{}: {local:?}: {answers:?}", subject.name);
        }
    }
}

/// A point of a face: the face, its parameters, and the oracle's piece and point.
fn surface_point(subject: &Subject, target: &Target, dice: &mut Dice) -> Option<(usize, [f64; 2], usize, Place)> {
    let solid = subject.solid();
    let (face, parameters) = (dice.index(solid.face_count()), dice.parameters(false));
    let (piece, local) = solid.point(face, parameters)?;
    Some((face, parameters, piece, target.curved.image(&local)))
}

#[test]
fn surface_points_are_blocked_and_turned_as_the_definition_says() {
    let mut wrong = Vec::new();
    let count = cases(10_000) / 10;
    for subject in subjects() {
        for (place, map) in maps().into_iter().enumerate() {
            let target = Target::new(&subject, map);
            let body = PlacedAnalytic::new(subject.body, target.placement).expect("an accepted body");
            for number in 0..count.div_ceil(12) {
                let mut dice = Dice::new("surface points", number + 1000 * place as u64);
                let Some((face, [u, v], piece, x)) = surface_point(&subject, &target, &mut dice) else { continue };
                let light = aimed_light(&subject, &target, x.approximate(), &mut dice);
                let lamp = Lamp::new(&light);
                if lamp.is_at(&x) {
                    continue;
                }
                let expected = (target.curved.blocks(&x, &lamp), target.curved.light_side(piece, &x, &lamp));
                let chart = &body.charts()[face];
                let exact = || chart.exact_point(&target.placement, u, v).expect("a point of the surface");
                let probe = Probe::new(chart.bounded_point(&target.placement, u, v), exact);
                let blocked = body.blocks(&probe, Some(chart.surface), &light);
                let facing = match body.facing(chart.surface, &probe, &light) {
                    Sign::Negative => -1,
                    Sign::Zero => 0,
                    Sign::Positive => 1,
                };
                if (blocked, facing) != expected {
                    let found = format!("{blocked} {facing}, by definition {expected:?}");
                    wrong.push(format!("{}, {place}: face {face} ({u}, {v}) {light:?}: {found}", subject.name));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} are wrong:\n{}", wrong.len(), wrong[..wrong.len().min(12)].join("\n"));
}

#[test]
fn a_light_at_the_very_point_is_not_blocked() {
    // The open segment has no points, whatever its ends touch.
    for subject in subjects() {
        let placed = PlacedAnalytic::new(subject.body, Placement::IDENTITY).expect("an accepted body");
        for (p, _) in &subject.touching {
            let segment = Segment { x: p.to_array(), light: LightSource::point(p.to_array()).expect("a light") };
            assert!(!by_library(&placed, &segment), "{} at {p}", subject.name);
        }
    }
}
