//! Fuzzing: the targets of `fuzz/` on libFuzzer, one after the other.
//!
//! The coverage counters are those of LLVM's SanitizerCoverage pass, which the stable compiler has as well; a nightly
//! one would add sanitizers, which find what safe Rust does not have. Overflow checks are on. New inputs go to
//! `target/fuzz/corpus`; `--store` keeps the shortest of a smallest set of them with the same coverage in `fixtures/fuzz`, where the
//! tests of every day repeat them. Cost: the minutes asked for, and some to build.

use std::{
    ffi::OsString,
    fs::{self, File},
    path::{Path, PathBuf},
    process::Command,
};

use anyhow::{Context, Result, ensure};

use crate::workspace::{cargo, output_of, root, succeed};

/// How long, and what.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Minutes for all targets together
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// Only targets whose names hold this text
    #[arg(long, default_value = "")]
    target: String,
    /// Keep what adds coverage in fixtures/fuzz, the shortest inputs first
    #[arg(long)]
    store: bool,
}

/// A target's name, and the longest input that is worth its time, bytes.
const TARGETS: [(&str, usize); 14] = [
    ("obj", 16384),
    ("stl", 1024),
    ("ply", 1024),
    ("gltf", 4096),
    ("glb", 4096),
    ("meshopt", 512),
    ("draco", 1024),
    ("picture", 1024),
    ("scene_file", 2048),
    ("npy", 512),
    ("points", 512),
    ("suns", 512),
    ("shadows", 256),
    ("codes", 256),
];

/// What turns counters on.
const COVERAGE: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing";

/// One input may take so long, seconds by the clock, and all of the program so much memory, MiB.
const SECONDS: u32 = 5;
const MEBIBYTES: u32 = 1024;
/// A scene is computed twice and judged by the oracle: some take seconds of the instrumented program on a quiet machine.
const SECONDS_OF_A_SCENE: u32 = 60;
/// What a target may keep among the fixtures, bytes: the tests of every day repeat it.
const STORED: u64 = 128 << 10;

pub(crate) fn run(options: &Options) -> Result<()> {
    let program = build()?;
    let chosen: Vec<_> = TARGETS.iter().filter(|(name, _)| name.contains(&options.target)).collect();
    ensure!(!chosen.is_empty(), "no target has {:?} in its name", options.target);
    let seconds = (options.minutes * 60.0 / chosen.len() as f64).max(1.0) as u64;
    let mut found = Vec::new();
    for &&(name, longest) in &chosen {
        let course = Course { program: &program, name, longest };
        match course.run(seconds)? {
            Ok(summary) => println!("{name}: {summary}"),
            Err(finding) => {
                println!("{finding}");
                found.push(name);
            }
        }
        if options.store {
            println!("{name}: {} inputs in {}", course.store()?, stored(name).display());
        }
    }
    ensure!(found.is_empty(), "findings of {}", found.join(", "));
    Ok(())
}

/// The folder of everything that fuzzing makes.
fn folder() -> PathBuf {
    root().join("target/fuzz")
}

/// A target's corpus among the fixtures.
fn stored(name: &str) -> PathBuf {
    root().join("fixtures/fuzz").join(name)
}

fn build() -> Result<PathBuf> {
    let compiler = output_of(Command::new("rustc").arg("-vV"))?;
    let host = compiler.lines().find_map(|line| line.strip_prefix("host: ")).context("rustc names no host")?;
    let mut build = cargo(&["build", "--release", "--manifest-path", "fuzz/Cargo.toml"]);
    // With a target of its own, build scripts and macros stay without counters.
    build.args(["--target", host, "--target-dir"]).arg(folder()).env("RUSTFLAGS", COVERAGE);
    succeed(&mut build)?;
    Ok(folder().join(host).join("release/umbriel-fuzz"))
}

/// One target at work.
struct Course<'a> {
    program: &'a Path,
    name: &'static str,
    longest: usize,
}

impl Course<'_> {
    fn command(&self) -> Command {
        let mut command = Command::new(self.program);
        command.env("UMBRIEL_TARGET", self.name).current_dir(root());
        let seconds = if self.name == "shadows" { SECONDS_OF_A_SCENE } else { SECONDS };
        command.arg(format!("-max_len={}", self.longest)).arg(format!("-timeout={seconds}"));
        command.arg(format!("-rss_limit_mb={MEBIBYTES}"));
        command
    }

    fn corpus(&self) -> PathBuf {
        folder().join("corpus").join(self.name)
    }

    /// Fuzzes for so long; says what was done, or what was found.
    fn run(&self, seconds: u64) -> Result<Result<String, String>> {
        let findings = folder().join("findings").join(self.name);
        fs::create_dir_all(self.corpus())?;
        fs::create_dir_all(&findings)?;
        fs::create_dir_all(stored(self.name))?;
        let mut command = self.command();
        command.arg(format!("-max_total_time={seconds}")).arg("-print_final_stats=1");
        command.arg(format!("-artifact_prefix={}/", findings.display())).arg("-dict=fuzz/words.dict");
        command.args([self.corpus(), stored(self.name), root().join("fixtures")]);
        let log = folder().join(format!("{}.log", self.name));
        let file = File::create(&log).with_context(|| format!("cannot write {}", log.display()))?;
        let status = command.stdout(file.try_clone()?).stderr(file).status().context("the fuzzer does not start")?;
        let text = String::from_utf8_lossy(&fs::read(&log)?).into_owned();
        if status.success() {
            return Ok(Ok(summary(&text)));
        }
        Ok(Err(format!("{}: a finding in {}\n{}", self.name, findings.display(), end_of(&text))))
    }

    /// Replaces the stored corpus by a smallest one of the same coverage, its shortest inputs at least; answers how many.
    fn store(&self) -> Result<usize> {
        let (old, new) = (stored(self.name), folder().join("smallest").join(self.name));
        if new.exists() {
            fs::remove_dir_all(&new)?;
        }
        fs::create_dir_all(&new)?;
        let mut merge = self.command();
        merge.arg("-set_cover_merge=1").arg(&new).arg(self.corpus()).arg(&old);
        output_of(merge.stderr(std::process::Stdio::null()))?;
        fs::remove_dir_all(&old)?;
        fs::create_dir_all(&old)?;
        let mut inputs = Vec::new();
        for entry in fs::read_dir(&new)? {
            let entry = entry?;
            inputs.push((entry.metadata()?.len(), entry.file_name()));
        }
        let kept = shortest(inputs, STORED);
        for name in &kept {
            fs::copy(new.join(name), old.join(name))?;
        }
        Ok(kept.len())
    }
}

/// The names of the shortest inputs that are together no longer than that.
fn shortest(mut inputs: Vec<(u64, OsString)>, most: u64) -> Vec<OsString> {
    inputs.sort_unstable();
    let mut total = 0;
    let fits = |(length, name): (u64, OsString)| {
        total += length;
        (total <= most).then_some(name)
    };
    inputs.into_iter().map_while(fits).collect()
}

/// Executions and coverage, from the fuzzer's last words.
fn summary(log: &str) -> String {
    let of = |key: &str| log.lines().rev().find_map(|line| line.split_once(key)).map_or("?", |(_, rest)| rest.trim());
    let coverage = of(" cov: ").split(" exec/s").next().unwrap_or("?");
    format!("{} executions, coverage {coverage}", of("stat::number_of_executed_units:"))
}

/// The last lines of a log.
fn end_of(log: &str) -> String {
    let lines: Vec<&str> = log.lines().collect();
    lines[lines.len().saturating_sub(60)..].join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_targets_are_those_of_the_program() {
        let text = fs::read_to_string(root().join("fuzz/src/targets/mod.rs")).expect("the list of targets");
        let there: Vec<&str> =
            text.lines().filter_map(|line| line.trim().strip_prefix("(\"")?.split('"').next()).collect();
        assert_eq!(there, TARGETS.map(|(name, _)| name));
    }

    #[test]
    fn what_is_stored_is_short() {
        let inputs = [(7, "c"), (1, "a"), (2, "b")].map(|(length, name)| (length, OsString::from(name)));
        assert_eq!(shortest(inputs.to_vec(), 9), ["a", "b"]);
        assert_eq!(shortest(inputs.to_vec(), 10), ["a", "b", "c"]);
    }

    #[test]
    fn the_last_words_are_understood() {
        let log = "#8\tINITED cov: 12 ft: 9 corp: 1/1b exec/s: 0 rss: 30Mb\n#99\tDONE   cov: 34 ft: 56 corp: 7/89b lim: 4 exec/s: 9 rss: 31Mb\nstat::number_of_executed_units: 99\n";
        assert_eq!(summary(log), "99 executions, coverage 34 ft: 56 corp: 7/89b lim: 4");
    }
}
