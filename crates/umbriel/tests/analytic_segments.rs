//! Does a curved body block a segment? The library against the oracle, on segments made to touch.
//!
//! Every kind of body under every kind of placement; two segments in three are exact tangents, rulings, chords through
//! apexes and rims, lines in the planes of caps and along axes, with ends on the surface, or any of these moved by an
//! ulp or two. `UMBRIEL_CASES` sets the number of segments for each kind of body.

mod oracle;

use oracle::{
    blocking::{Lamp, Place},
    cases,
    dice::Dice,
    graze::{Segment, Subject, Target, maps, segment, short_segment, subjects},
    number::vector,
};

/// What the definition says.
fn by_definition(target: &Target, segment: &Segment) -> bool {
    target.curved.blocks(&Place::new(vector(segment.x)), &Lamp::new(&segment.light))
}

/// Puts `count` segments of one subject to `judge`, spread over all placements.
fn judge(subject: &Subject, count: u64, judge: impl Fn(&Target, &Segment) -> Result<bool, String>) -> [u64; 2] {
    let maps = maps();
    let share = count.div_ceil(maps.len() as u64);
    let mut answers = [0; 2];
    let mut wrong = Vec::new();
    for (place, map) in maps.into_iter().enumerate() {
        let target = Target::new(subject, map);
        for number in 0..share {
            let mut dice = Dice::new("segments", number + share * place as u64);
            let segment = segment(subject, &target, &mut dice);
            match judge(&target, &segment) {
                Ok(blocked) => answers[usize::from(blocked)] += 1,
                Err(complaint) => wrong.push(format!("placement {place}, case {number}: {segment:?}: {complaint}")),
            }
        }
    }
    let shown = wrong.iter().take(5).cloned().collect::<Vec<_>>().join("\n");
    assert!(wrong.is_empty(), "{}: {} of {count} segments are wrong:\n{shown}", subject.name, wrong.len());
    answers
}

#[test]
fn both_answers_are_common() {
    for subject in subjects() {
        let answers = judge(&subject, cases(1_200) / 10, |target, segment| Ok(by_definition(target, segment)));
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
