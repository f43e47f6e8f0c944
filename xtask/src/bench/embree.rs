//! Embree as the peer: a program of its own, made of `embree.cpp` when it is first needed, asked over its standard input.
//!
//! Its best configuration counts: quality of the build, robust edges or not, single rays, packets of 8 or 16, streams.
//! Samples, normals and the turning of two-sided ones are given to it ready-made; only builds and rays are timed.

use std::{
    fmt,
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
};

use anyhow::{Context, Result, bail, ensure};
use umbriel_geometry::LightSource;

use super::clock::Seconds;
use crate::workspace::root;

const PROGRAM: &str = include_str!("embree.cpp");

/// How a tree is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Build {
    pub(super) quality: &'static str,
    pub(super) mode: &'static str,
}

/// A configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Setup {
    pub(super) build: Build,
    /// How rays are asked.
    pub(super) rays: &'static str,
}

/// All builds, the quick ones first.
pub(super) fn builds() -> impl Iterator<Item = Build> {
    let modes = |quality| ["fast", "robust"].map(|mode| Build { quality, mode });
    ["low", "medium", "high"].into_iter().flat_map(modes)
}

/// All ways to ask.
pub(super) const RAYS: [&str; 4] = ["single", "packet8", "packet16", "stream"];

impl fmt::Display for Setup {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{} {} {}", self.build.quality, self.build.mode, self.rays)
    }
}

/// The order in which samples are asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// That of the surface.
    Coherent,
    /// A fixed permutation.
    Shuffled,
}

/// The running program.
pub(super) struct Embree {
    child: Child,
    commands: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Embree {
    /// Compiles the program if need be and starts it. An error says why there is no Embree here.
    pub(super) fn start() -> Result<Self> {
        let mut child = Command::new(compiled()?).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let commands = child.stdin.take().context("no way to write to the Embree program")?;
        let answers = BufReader::new(child.stdout.take().context("no way to read from the Embree program")?);
        Ok(Self { child, commands, answers })
    }

    /// Reads triangles and samples from a file of [`Soup::write`](super::rays::Soup::write).
    pub(super) fn load(&mut self, path: &Path) -> Result<()> {
        self.ask(&format!("load {}", path.display())).map(drop)
    }

    /// Chooses the light.
    pub(super) fn set_light(&mut self, light: &LightSource) -> Result<()> {
        let place = if light.is_sun() { light.xyz().normalize() } else { light.xyz() };
        let kind = if light.is_sun() { "sun" } else { "lamp" };
        self.ask(&format!("light {kind} {} {} {}", place.x, place.y, place.z)).map(drop)
    }

    /// Builds a tree; the last one goes.
    pub(super) fn build(&mut self, build: Build, threads: usize) -> Result<Seconds> {
        let numbers = self.ask(&format!("build {} {} {threads}", build.quality, build.mode))?;
        seconds(&numbers)
    }

    /// Asks all rays; answers the time and how many samples are lit.
    pub(super) fn trace(&mut self, rays: &str, order: Order, threads: usize) -> Result<(Seconds, u64)> {
        let order = if order == Order::Coherent { "coherent" } else { "shuffled" };
        let numbers = self.ask(&format!("rays {rays} {order} {threads}"))?;
        let lit = numbers.get(3).context("Embree did not count the lit samples")?;
        Ok((seconds(&numbers)?, *lit as u64))
    }

    /// The last answers in the order of the surface: whether each sample is lit.
    pub(super) fn answers(&mut self) -> Result<Vec<bool>> {
        let file = scratch()?.join("answers.bin");
        self.ask(&format!("answers {}", file.display()))?;
        let bytes = std::fs::read(file)?;
        Ok(bytes.into_iter().map(|byte| byte == 1).collect())
    }

    /// Bytes that Embree held at most for the last build, and the answers; without triangles and samples.
    pub(super) fn memory(&mut self) -> Result<u64> {
        let numbers = self.ask("memory")?;
        Ok(numbers.first().map_or(0, |&bytes| bytes as u64))
    }

    fn ask(&mut self, command: &str) -> Result<Vec<f64>> {
        writeln!(self.commands, "{command}")?;
        self.commands.flush()?;
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        let Some(numbers) = line.strip_prefix("ok") else { bail!("Embree, asked for {command}: {}", line.trim()) };
        numbers.split_whitespace().map(|number| Ok(number.parse()?)).collect()
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // Nothing is left to do if it has gone already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn seconds(numbers: &[f64]) -> Result<Seconds> {
    let [wall, cpu, ..] = *numbers else { bail!("Embree told no times") };
    Ok(Seconds { wall, cpu })
}

/// The folder in which the benchmark keeps its files.
pub(super) fn scratch() -> Result<PathBuf> {
    let folder = root().join("target/bench");
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// The program, compiled for this machine.
fn compiled() -> Result<PathBuf> {
    let (source, program) = (scratch()?.join("embree.cpp"), scratch()?.join("embree"));
    if program.is_file() && std::fs::read_to_string(&source).is_ok_and(|text| text == PROGRAM) {
        return Ok(program);
    }
    // The source is stored last, as the sign that the program is of it.
    let made_of = scratch()?.join("embree-new.cpp");
    std::fs::write(&made_of, PROGRAM)?;
    let mut compiler = Command::new("g++");
    compiler
        .args(["-std=c++17", "-O3", "-march=native", "-ffp-contract=off", "-pthread", "-o"])
        .arg(&program)
        .arg(&made_of)
        .arg("-lembree3");
    let output = compiler.output().context("there is no g++")?;
    ensure!(output.status.success(), "g++ or libembree-dev: {}", String::from_utf8_lossy(&output.stderr));
    std::fs::rename(made_of, source)?;
    Ok(program)
}
