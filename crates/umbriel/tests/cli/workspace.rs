//! A folder of its own for every test, and the command run in it.

use std::{fs, process::Output};

use assert_cmd::Command;
use tempfile::TempDir;

/// A floor, a ball above it, and a sun straight overhead.
pub(crate) const NOON: &str = r#"
[[object]]
name = "floor"
rectangle = { size = [8.0, 8.0] }

[[object]]
name = "ball"
sphere = { radius = 1.0 }
translation = [0.0, 2.0, 0.0]

[[light]]
name = "noon"
sun = { direction = [0.0, -1.0, 0.0] }
"#;

/// The same without a light.
pub(crate) const DARK: &str = "[[object]]\nname = \"floor\"\nrectangle = { size = [8.0, 8.0] }\n";

pub(crate) struct Workspace(TempDir);

impl Workspace {
    pub(crate) fn with(files: &[(&str, &str)]) -> Self {
        let workspace = Self(tempfile::tempdir().expect("a folder"));
        for (name, content) in files {
            fs::write(workspace.0.path().join(name), content).expect("written");
        }
        workspace
    }

    pub(crate) fn noon() -> Self {
        Self::with(&[("noon.toml", NOON)])
    }

    /// Runs `umbriel` with arguments that are separated by spaces.
    pub(crate) fn run(&self, arguments: &str) -> Run {
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbriel"));
        let output = command.current_dir(self.0.path()).args(arguments.split_whitespace()).output();
        Run(output.expect("the command runs"))
    }

    /// Starts `umbriel` with its outputs on pipes.
    #[cfg(unix)]
    pub(crate) fn start(&self, arguments: &str) -> std::process::Child {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_umbriel"));
        command.current_dir(self.0.path()).args(arguments.split_whitespace());
        command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
        command.spawn().expect("the command starts")
    }

    pub(crate) fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.0.path().join(name)).expect("a file")
    }

    pub(crate) fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).expect("text")
    }

    /// The names of all files, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("a folder");
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

pub(crate) struct Run(Output);

impl Run {
    pub(crate) fn stdout(&self) -> String {
        String::from_utf8_lossy(&self.0.stdout).into_owned()
    }

    pub(crate) fn stderr(&self) -> String {
        String::from_utf8_lossy(&self.0.stderr).into_owned()
    }

    pub(crate) fn succeeds(self) -> Self {
        assert_eq!(self.0.status.code(), Some(0), "{}", self.stderr());
        self
    }

    /// Ends with `code` and one message that holds all of `words`; nothing on standard output.
    pub(crate) fn fails(self, code: i32, words: &[&str]) {
        let message = self.stderr();
        assert_eq!(self.0.status.code(), Some(code), "{message}");
        assert!(!message.contains("panicked"), "{message}");
        for word in words {
            assert!(message.contains(word), "\"{word}\" is missing in: {message}");
        }
        assert_eq!(self.stdout(), "");
    }
}
