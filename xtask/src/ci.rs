//! Every check, cheapest complaints first; the first that fails ends it.
//!
//! Formatting, lints and documentation come before anything is run, then the tests, then the tasks of this program.

use std::{
    process::Command,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};

use crate::{
    bench, downstream, fixtures, layers, regress, tidy,
    workspace::{cargo, succeed},
};

/// A name and what it does.
type Step = (&'static str, fn() -> Result<()>);

const STEPS: [Step; 10] = [
    ("fmt", || {
        succeed(&mut cargo(&["fmt", "--all", "--check"]))?;
        succeed(&mut cargo(&["fmt", "--manifest-path", "fuzz/Cargo.toml", "--check"]))
    }),
    ("clippy", || succeed(&mut cargo(&["clippy", "--quiet", "--workspace", "--all-targets", "--", "-D", "warnings"]))),
    ("doc", || succeed(&mut documentation())),
    ("test", || succeed(&mut cargo(&["test", "--quiet", "--workspace"]))),
    ("fixtures", fixtures::check),
    ("regress", regress::compare),
    ("layers", layers::run),
    ("tidy", tidy::run),
    ("downstream", downstream::run),
    ("bench", bench::guard),
];

pub(crate) fn run() -> Result<()> {
    let begun = Instant::now();
    let mut times: Vec<(&str, Duration)> = Vec::new();
    for (number, (name, step)) in STEPS.iter().enumerate() {
        println!("[{}/{}] {name}", number + 1, STEPS.len());
        let start = Instant::now();
        let outcome = step();
        times.push((name, start.elapsed()));
        println!("[{}/{}] {name}: {:.1} s", number + 1, STEPS.len(), start.elapsed().as_secs_f64());
        outcome.with_context(|| format!("{name} failed"))?;
    }
    let table: Vec<String> = times.iter().map(|(name, time)| format!("{name} {:.0} s", time.as_secs_f64())).collect();
    println!("all checks passed in {:.0} s: {}", begun.elapsed().as_secs_f64(), table.join(", "));
    Ok(())
}

fn documentation() -> Command {
    let mut command = cargo(&["doc", "--quiet", "--workspace", "--no-deps"]);
    command.env("RUSTDOCFLAGS", "-D warnings");
    command
}
