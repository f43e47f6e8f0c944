//! Long runs of the judges: the tests that count their cases, with far more of them.
//!
//! The tests are those of every day, compiled the same way (overflow checks included); each is given its share of cases
//! in rounds, by `UMBRIEL_FIRST` and `UMBRIEL_CASES`. Rounds of all judges take turns, so that all have been heard when time
//! is up. A round that fails ends everything and is shown, with the numbers that repeat it. Cost: hours for all of it.

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

const JUDGES: [Judge; 22] = [
    Judge {
        file: "watertight",
        test: "no_segment_leaves_a_closed_mesh",
        unit: "segments",
        cases: 100_000_000,
        round: 2_000_000,
    },
    Judge {
        file: "watertight",
        test: "no_packet_and_no_batch_sees_a_lamp_inside",
        unit: "segments",
        cases: 100_000_000,
        round: 2_000_000,
    },
    Judge {
        file: "watertight",
        test: "what_lies_strictly_in_front_is_not_hit",
        unit: "segments",
        cases: 100_000_000,
        round: 10_000_000,
    },
    Judge {
        file: "adversarial",
        test: "segments_that_graze_agree_with_the_definition",
        unit: "segments",
        cases: 10_000_000,
        round: 1_000_000,
    },
    Judge {
        file: "adversarial",
        test: "cells_round_a_corner_on_an_outline_are_true",
        unit: "cells",
        cases: 1_000_000,
        round: 50_000,
    },
    Judge {
        file: "adversarial",
        test: "samples_on_an_outline_agree_with_the_definition",
        unit: "scenes",
        cases: 1_000_000,
        round: 50_000,
    },
    Judge {
        file: "adversarial",
        test: "scenes_of_all_families_agree_with_the_definition",
        unit: "scenes",
        cases: 100_000,
        round: 5_000,
    },
    Judge {
        file: "adversarial",
        test: "a_state_is_baked_alike_whatever_came_before",
        unit: "histories",
        cases: 10_000,
        round: 300,
    },
    Judge { file: "adversarial", test: "a_session_follows_its_history", unit: "histories", cases: 10_000, round: 300 },
    Judge { file: "crowds", test: "proofs_in_crowds_are_true", unit: "soups", cases: 1_000, round: 20 },
    Judge { file: "crowds", test: "proofs_in_throngs_are_true", unit: "scenes", cases: 1_000, round: 20 },
    Judge { file: "metamorphic", test: "objects_in_another_order", unit: "scenes", cases: 10_000, round: 200 },
    Judge { file: "metamorphic", test: "any_simd_level", unit: "scenes", cases: 10_000, round: 200 },
    Judge { file: "metamorphic", test: "one_thread_or_many", unit: "scenes", cases: 10_000, round: 200 },
    Judge { file: "metamorphic", test: "powers_of_two", unit: "scenes", cases: 10_000, round: 200 },
    Judge { file: "metamorphic", test: "triangles_cut_at_exact_points", unit: "scenes", cases: 10_000, round: 200 },
    Judge { file: "metamorphic", test: "an_object_that_cannot_matter", unit: "scenes", cases: 10_000, round: 200 },
    Judge { file: "rooms", test: "nothing_that_is_seen_is_missing", unit: "eyes", cases: 10_000, round: 1_000 },
    Judge { file: "metamorphic", test: "axes_exchanged_and_mirrored", unit: "scenes", cases: 10_000, round: 200 },
    Judge {
        file: "metamorphic",
        test: "faces_that_start_at_another_corner",
        unit: "scenes",
        cases: 10_000,
        round: 200,
    },
    Judge { file: "metamorphic", test: "triangles_in_another_order", unit: "scenes", cases: 10_000, round: 200 },
    Judge {
        file: "random_scenes",
        test: "proved_cells_of_random_scenes_are_true",
        unit: "scenes",
        cases: 100_000,
        round: 1_000,
    },
];

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
    let is_over = || options.minutes.is_some_and(|minutes| begun.elapsed() >= Duration::from_secs(60 * minutes));
    while !is_over() && courses.iter().any(|course| course.done < course.judge.cases) {
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
