//! Long runs of the judges: the tests that count their cases, with far more of them.
//!
//! The tests are those of every day, compiled the same way (overflow checks included); each is given its share of cases
//! in rounds, by `UMBRIEL_FIRST` and `UMBRIEL_CASES`. Rounds of all judges take turns, so that all have been heard when time
//! is up. Before each turn of theirs the property tests of all crates draw cases that no day has seen. A round that fails ends everything and is shown, with the
//! numbers that repeat it. Cost: hours for all of it.

use std::{
    process::Command,
    time::{Duration, Instant},
};

use anyhow::{Context, Result, ensure};

use crate::workspace::{cargo, succeed};

/// How long, and from where on.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// End after the round in which this many minutes are over, instead of when all cases are done
    #[arg(long)]
    minutes: Option<u64>,
    /// Only judges whose names hold this text
    #[arg(long, default_value = "")]
    judge: String,
    /// The number of the first case: other numbers, other cases
    #[arg(long, default_value_t = 0)]
    first: u64,
}

/// A test of the crate `umbriel` that counts its cases.
#[derive(Debug)]
struct Judge {
    /// The file in `tests/judges`.
    file: &'static str,
    test: &'static str,
    /// What a case is.
    unit: &'static str,
    cases: u64,
    /// Cases of one round: a minute or so.
    round: u64,
}

/// One judge of [`JUDGES`].
const fn judge(file: &'static str, test: &'static str, unit: &'static str, cases: u64, round: u64) -> Judge {
    Judge { file, test, unit, cases, round }
}

const JUDGES: [Judge; 46] = [
    judge("watertight", "no_segment_leaves_a_closed_mesh", "segments", 100_000_000, 2_000_000),
    judge("watertight", "no_packet_and_no_batch_sees_a_lamp_inside", "segments", 100_000_000, 2_000_000),
    judge("watertight", "what_lies_strictly_in_front_is_not_hit", "segments", 100_000_000, 10_000_000),
    judge(
        "watertight",
        "segments_that_end_right_before_or_behind_a_face_meet_what_is_on_their_way",
        "segments",
        1_000_000,
        100_000,
    ),
    judge("adversarial", "segments_that_graze_agree_with_the_definition", "segments", 10_000_000, 1_000_000),
    judge("adversarial", "cells_round_a_corner_on_an_outline_are_true", "cells", 1_000_000, 50_000),
    judge("adversarial", "samples_on_an_outline_agree_with_the_definition", "scenes", 1_000_000, 50_000),
    judge("adversarial", "scenes_of_all_families_agree_with_the_definition", "scenes", 100_000, 5_000),
    judge("adversarial", "a_state_is_baked_alike_whatever_came_before", "histories", 10_000, 300),
    judge("adversarial", "a_session_follows_its_history", "histories", 10_000, 300),
    judge("queries", "surface_points_agree_with_the_definition", "points", 10_000_000, 500_000),
    judge("queries", "points_in_space_agree_with_the_definition", "points", 1_000_000, 50_000),
    judge("queries", "positions_with_normals_agree_with_their_slack_box", "points", 1_000_000, 50_000),
    judge("queries", "surface_points_of_the_stored_scenes_agree_with_the_definition", "points", 100_000, 10_000),
    judge("crowds", "proofs_in_crowds_are_true", "soups", 1_000, 20),
    judge("crowds", "proofs_in_throngs_are_true", "scenes", 1_000, 20),
    judge("metamorphic", "objects_in_another_order", "scenes", 10_000, 200),
    judge("metamorphic", "any_simd_level", "scenes", 10_000, 200),
    judge("metamorphic", "one_thread_or_many", "scenes", 10_000, 200),
    judge("metamorphic", "powers_of_two", "scenes", 10_000, 200),
    judge("metamorphic", "triangles_cut_at_exact_points", "scenes", 10_000, 200),
    judge("metamorphic", "an_object_that_cannot_matter", "scenes", 10_000, 200),
    judge("rooms", "nothing_that_is_seen_is_missing", "eyes", 10_000, 1_000),
    judge("metamorphic", "axes_exchanged_and_mirrored", "scenes", 10_000, 200),
    judge("metamorphic", "faces_that_start_at_another_corner", "scenes", 10_000, 200),
    judge("metamorphic", "triangles_in_another_order", "scenes", 10_000, 200),
    judge("random_scenes", "proved_cells_of_random_scenes_are_true", "scenes", 100_000, 1_000),
    judge("closed_forms", "sphere_under_a_sun", "scenes", 100_000, 5_000),
    judge("closed_forms", "sphere_under_a_point_light", "scenes", 100_000, 5_000),
    judge("closed_forms", "box_under_a_sun", "scenes", 100_000, 5_000),
    judge("closed_forms", "box_under_a_point_light", "scenes", 100_000, 5_000),
    judge("closed_forms_solids", "spheres_over_a_floor", "scenes", 10_000, 200),
    judge("closed_forms_solids", "ellipsoids_over_a_floor", "scenes", 10_000, 200),
    judge("closed_forms_solids", "cylinders_over_a_floor", "scenes", 10_000, 200),
    judge("closed_forms_solids", "cones_over_a_floor", "scenes", 10_000, 200),
    judge("closed_forms_solids", "frusta_over_a_floor", "scenes", 10_000, 200),
    judge("closed_forms_solids", "capsules_over_a_floor", "scenes", 10_000, 200),
    judge("closed_forms_solids", "paraboloids_over_a_floor", "scenes", 10_000, 200),
    judge("closed_forms_solids", "hyperboloids_over_a_floor", "scenes", 10_000, 200),
    judge("closed_forms_solids", "disks_over_a_floor", "scenes", 10_000, 200),
    judge("closed_forms_solids", "bodies_over_and_on_a_disk", "scenes", 10_000, 200),
    judge("closed_forms_solids", "bodies_on_one_axis_under_a_sun", "scenes", 10_000, 200),
    judge("closed_forms_solids", "bodies_on_one_axis_under_a_lamp", "scenes", 10_000, 200),
    judge("far_away", "boxes_under_any_light", "scenes", 1_000, 20),
    judge("far_away", "curved_bodies_under_a_sun", "scenes", 1_000, 20),
    judge("far_away", "curved_bodies_under_a_lamp", "scenes", 1_000, 20),
];

/// Cases of a property test in one round, where the test names no number of its own.
const PROPERTY_CASES: &str = "3000";

/// A judge at work.
struct Course {
    judge: &'static Judge,
    done: u64,
    time: Duration,
}

pub(crate) fn run(options: &Options) -> Result<()> {
    let asked = JUDGES.iter().filter(|judge| judge.test.contains(&options.judge));
    let mut courses: Vec<Course> = asked.map(|judge| Course { judge, done: 0, time: Duration::ZERO }).collect();
    ensure!(!courses.is_empty(), "no judge has {:?} in its name", options.judge);
    succeed(&mut cargo(&["test", "--quiet", "--package", "umbriel", "--test", "judges", "--no-run"]))?;
    let begun = Instant::now();
    let mut turns = 0;
    let is_over = || options.minutes.is_some_and(|minutes| begun.elapsed() >= Duration::from_secs(60 * minutes));
    while !is_over() && courses.iter().any(|course| course.done < course.judge.cases) {
        if options.judge.is_empty() {
            turns += 1;
            properties(options.first + turns)?;
        }
        for course in courses.iter_mut().filter(|course| course.done < course.judge.cases) {
            if is_over() {
                break;
            }
            course.round(options.first)?;
        }
    }
    println!("no case was wrong in {:.0} s", begun.elapsed().as_secs_f64());
    Ok(())
}

impl Course {
    /// The next cases, and a line that says how far it has come.
    fn round(&mut self, first: u64) -> Result<()> {
        let Judge { file, test, unit, cases, round } = self.judge;
        let (start, count) = (first + self.done, *round.min(&(cases - self.done)));
        let begun = Instant::now();
        judged(&mut command(self.judge, start, count))
            .with_context(|| format!("{file}: {test} with UMBRIEL_FIRST={start} UMBRIEL_CASES={count}"))?;
        self.done += count;
        self.time += begun.elapsed();
        println!("{test}: {} of {cases} {unit} in {:.0} s", self.done, self.time.as_secs_f64());
        Ok(())
    }
}

/// The tests of the libraries, whose property tests draw from another seed than every day's (`.cargo/config.toml`).
fn properties(seed: u64) -> Result<()> {
    let begun = Instant::now();
    let mut tests = cargo(&["test", "--quiet", "--workspace", "--lib"]);
    let output = tests
        .env("PROPTEST_RNG_SEED", seed.to_string())
        .env("PROPTEST_CASES", PROPERTY_CASES)
        .output()
        .context("cannot start cargo")?;
    let said = String::from_utf8_lossy(&output.stdout);
    ensure!(
        output.status.success(),
        "property tests with PROPTEST_RNG_SEED={seed} PROPTEST_CASES={PROPERTY_CASES}:\n{said}"
    );
    println!("property tests, seed {seed}: {PROPERTY_CASES} cases in {:.0} s", begun.elapsed().as_secs_f64());
    Ok(())
}

fn command(judge: &Judge, start: u64, count: u64) -> Command {
    let test = format!("{}::{}", judge.file, judge.test);
    let mut command = cargo(&["test", "--package", "umbriel", "--test", "judges", "--", "--exact", &test]);
    command.env("UMBRIEL_FIRST", start.to_string()).env("UMBRIEL_CASES", count.to_string());
    command
}

/// Runs one test, which must be there and pass.
fn judged(command: &mut Command) -> Result<()> {
    let output = command.output().with_context(|| format!("cannot start {command:?}"))?;
    let said = String::from_utf8_lossy(&output.stdout);
    ensure!(output.status.success(), "it failed:\n{said}{}", String::from_utf8_lossy(&output.stderr));
    // A name that no test has would pass as well.
    ensure!(said.contains(" 1 passed;"), "there is no such test");
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::workspace::root;

    #[test]
    fn every_judge_is_a_test_that_counts_its_cases() {
        for Judge { file, test, cases, round, .. } in &JUDGES {
            let text = fs::read_to_string(root().join(format!("crates/umbriel/tests/judges/{file}.rs")));
            let text = text.expect("a test file");
            let (_, body) = text.split_once(&format!("#[test]\nfn {test}()")).expect("a test of that name");
            let body = body.split("\n}\n").next().expect("a body");
            assert!(body.contains("case_numbers("), "{test} does not count");
            assert!(round <= cases);
        }
    }
}
