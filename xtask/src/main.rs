//! `cargo xtask <task>`: the one door to every check of the workspace. Here tasks are only told apart; each is a file.

#![allow(clippy::print_stdout, reason = "what a check has to say goes to the terminal")]
#![allow(clippy::print_stderr, reason = "what a check has to say goes to the terminal")]

mod bench;
mod ci;
mod downstream;
mod fixtures;
mod fuzz;
mod instances;
mod layers;
mod pictures;
mod portals;
mod projection;
mod rasteriser;
mod regress;
mod soak;
mod soft;
mod source;
mod svg;
mod tidy;
mod tradeoff;
mod workspace;

use std::process::ExitCode;

use clap::Parser;

/// The checks of the workspace.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask")]
enum Task {
    /// Everything below that checks, formatting, lints, documentation and tests included
    Ci,
    /// Write the generated fixtures
    Fixtures {
        /// Write nothing; fail where a stored fixture differs from the generated one
        #[arg(long)]
        check: bool,
    },
    /// Compute the shadows of every fixture and compare them with the stored results
    Regress {
        /// Store the new results, and why they changed
        #[arg(long, value_name = "REASON")]
        bless: Option<String>,
    },
    /// Measure the whole job against ray engines
    Bench(bench::Options),
    /// Measure rays looked up in projected octrees against ordinary traversal and the BVH
    Projection(projection::Options),
    /// Write an office floor with cells and portals, of any number of rooms
    Office(portals::OfficeOptions),
    /// Measure what portals spare on offices of 200 to 10,000 rooms, and judge by rays that nothing visible is missing
    Portals(portals::Options),
    /// Draw all fixtures and real models by all methods of hidden surfaces; no pixel may differ
    Pictures(pictures::Options),
    /// Measure what the choice between BVH, octree and projection goes by
    Calibrate(projection::CalibrateOptions),
    /// Measure the ways to shade soft shadows on the robot: times and errors
    Soft(soft::Options),
    /// Measure what time and memory buy, with bounds, with samples and with the rivals; charts go to docs
    Tradeoff(tradeoff::Options),
    /// Hold the source's claims about shadow volumes against measurements, for docs/source
    Source(source::Options),
    /// Measure what instances of a mesh take beside a single one: peak memory
    Instances(instances::Options),
    /// Let the judges look at millions of adversarial cases; hours, unless --minutes says otherwise
    Soak(soak::Options),
    /// Let libFuzzer look for bytes that break a parser, a small scene or an octree
    Fuzz(fuzz::Options),
    /// What distance from the origin does to answers: the table of the README
    Offsets,
    /// Check which crate uses which, and what the lower layers must not use
    Layers,
    /// Use each layer from a crate outside the workspace, by the example of its README
    Downstream,
    /// Sizes of files and functions, READMEs, leftovers
    Tidy,
}

fn main() -> ExitCode {
    let outcome = match Task::parse() {
        Task::Ci => ci::run(),
        Task::Fixtures { check: false } => fixtures::write(),
        Task::Fixtures { check: true } => fixtures::check(),
        Task::Regress { bless: None } => regress::compare(),
        Task::Regress { bless: Some(reason) } => regress::bless(&reason),
        Task::Bench(options) => bench::run(&options),
        Task::Projection(options) => projection::run(&options),
        Task::Office(options) => portals::write_office(&options),
        Task::Portals(options) => portals::run(&options),
        Task::Pictures(options) => pictures::run(&options),
        Task::Calibrate(options) => projection::calibrate(&options),
        Task::Soft(options) => soft::run(&options),
        Task::Tradeoff(options) => tradeoff::run(&options),
        Task::Source(options) => source::run(&options),
        Task::Instances(options) => instances::run(&options),
        Task::Soak(options) => soak::run(&options),
        Task::Fuzz(options) => fuzz::run(&options),
        Task::Offsets => bench::offsets(),
        Task::Layers => layers::run(),
        Task::Downstream => downstream::run(),
        Task::Tidy => tidy::run(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
