//! The command `umbriel`: parse, run, exit code.

mod cli;
mod output;
mod progress;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
