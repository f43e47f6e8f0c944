//! Where the workspace lies, its tracked files, and how other programs are run in it.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use anyhow::{Context, Result, ensure};

/// The folder of the workspace.
pub(crate) fn root() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.parent().unwrap_or(own).to_owned()
}

/// The cargo that runs this program, in the folder of the workspace.
pub(crate) fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root()).args(arguments);
    command
}

/// The program that users run: this one, or else the workspace's own, built if need be.
pub(crate) fn umbriel(program: Option<&Path>) -> Command {
    match program {
        Some(program) => Command::new(program),
        None => cargo(&["run", "--quiet", "--release", "--package", "umbriel", "--"]),
    }
}

/// Runs a program that must succeed; what it prints is shown.
pub(crate) fn succeed(command: &mut Command) -> Result<()> {
    let status = command.status().with_context(|| format!("cannot start {command:?}"))?;
    ensure!(status.success(), "{command:?} failed ({status})");
    Ok(())
}

/// Runs a program that must succeed; answers what it prints.
pub(crate) fn output_of(command: &mut Command) -> Result<String> {
    let output = command.output().with_context(|| format!("cannot start {command:?}"))?;
    let errors = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{command:?} failed ({}):\n{errors}", output.status);
    String::from_utf8(output.stdout).with_context(|| format!("{command:?} printed something other than text"))
}

/// The files of the workspace: tracked ones, and new ones that git does not ignore. Relative to [`root`], sorted.
pub(crate) fn files() -> Result<Vec<PathBuf>> {
    let mut git = Command::new("git");
    git.current_dir(root()).args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"]);
    let mut files: Vec<PathBuf> = output_of(&mut git)?.split_terminator('\0').map(PathBuf::from).collect();
    files.retain(|file| root().join(file).is_file());
    files.sort();
    files.dedup();
    Ok(files)
}

/// Fails with all complaints at once, if there are any.
pub(crate) fn no_complaints(complaints: &[String]) -> Result<()> {
    ensure!(complaints.is_empty(), "{} complaints:\n  {}", complaints.len(), complaints.join("\n  "));
    Ok(())
}
