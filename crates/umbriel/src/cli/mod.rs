//! From the command line to an exit code; one command a file.

mod acceleration;
mod args;
mod bake;
mod compare;
mod doctor;
mod failure;
mod glob;
mod info;
mod lines;
mod plan;
mod query;
mod reach;
mod render;
mod render_args;
mod soft;
mod soft_casters;
mod soft_pictures;
mod suns;
mod surfaces;
mod tradeoff;

use std::{
    io::{self, Write},
    process::ExitCode,
};

use clap::Parser;
use umbriel_io::printable;

pub(crate) use failure::Failure;

/// Parses, runs, reports. clap's own complaints exit with 2, `--help` with 0.
pub(crate) fn main() -> ExitCode {
    let args = match args::Args::try_parse() {
        Ok(args) => args,
        Err(error) => {
            // Nothing sensible is left to do when even this cannot be printed.
            let _ = error.print();
            return ExitCode::from(error.exit_code().clamp(0, 255) as u8);
        }
    };
    match run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => report(&failure),
    }
}

fn run(args: &args::Args) -> Result<(), Failure> {
    take_full_files_as_failed_writes();
    match &args.command {
        args::Command::Info(args) => info::run(args),
        args::Command::Bake(args) => bake::run(args),
        args::Command::Query(args) => query::run(args),
        args::Command::Render(args) => render::run(args),
        args::Command::Compare(args) => compare::run(args),
        args::Command::Tradeoff(args) => tradeoff::run(args),
        args::Command::Soft(args) => soft::run(args),
        args::Command::Doctor(args) => doctor::run(args),
    }
}

/// A file that reaches the user's limit (`ulimit -f`) ends the process by a signal, unless somebody listens to it; then the write fails.
fn take_full_files_as_failed_writes() {
    #[cfg(unix)]
    // Where listening is impossible, the signal does what it does everywhere.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
}

fn report(failure: &Failure) -> ExitCode {
    if let Some(message) = failure.message() {
        // Names in files may hold what a terminal obeys.
        let lines: Vec<_> = message.split('\n').map(printable).collect();
        let _ = writeln!(io::stderr(), "umbriel: {}", lines.join("\n"));
    }
    ExitCode::from(failure.exit_code())
}
