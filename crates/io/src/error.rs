//! Why a scene was not loaded: which file, where in it, and what to do.

use std::{
    borrow::Cow,
    io,
    path::{Path, PathBuf},
};

use crate::names::printable;

/// A scene that was not loaded. Its message names the file and the place in it.
#[derive(Debug, thiserror::Error)]
#[error("{}", self.describe())]
pub struct LoadError {
    /// The file that was being read: the scene, or a mesh that it names.
    pub file: PathBuf,
    /// What is wrong with it.
    pub problem: LoadProblem,
}

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadProblem {
    /// A file that is missing or cannot be read.
    #[error("{} cannot be read: {source}", path.display())]
    Unreadable {
        /// The scene itself, or a file that it names.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// A file name that ends in none of the known ways.
    #[error("only files that end in .toml, .gltf, .glb, .obj, .stl or .ply are read as scenes")]
    UnknownFormat,
    /// A path that leads out of the folder of the scene.
    #[error(
        "{place}: the path \"{path}\" leads out of the folder of the scene; move the file into it, or allow paths \
         outside (--allow-outside)"
    )]
    Outside {
        /// The element that names the path.
        place: String,
        /// The path as written.
        path: String,
    },
    /// Text that breaks the rules of its format.
    #[error("line {line}{}: {message}", column.map(|column| format!(", column {column}")).unwrap_or_default())]
    Text {
        /// Counted from 1.
        line: usize,
        /// Counted from 1, in characters; unknown in formats that are read by the line.
        column: Option<usize>,
        /// What is wrong there.
        message: String,
    },
    /// An element (object, node, accessor, ...) that is refused.
    #[error("{place}: {message}")]
    Element {
        /// Which one.
        place: String,
        /// What is wrong with it.
        message: String,
    },
    /// Extensions that the file requires and that are not read.
    #[error("requires extensions that are not read: {name}; {advice}")]
    Extension {
        /// Their names, with commas between them.
        name: String,
        /// What to do about it.
        advice: &'static str,
    },
    /// A scene that multiplies what its files hold beyond the limits told in the crate's documentation.
    #[error(
        "the scene makes {count} {what} out of its files; at most {most} are read; leave instances out or split it"
    )]
    TooMuch {
        /// What is too much.
        what: &'static str,
        /// How many there would be, at least.
        count: u64,
        /// How many are read at most.
        most: u64,
    },
}

/// Text of a file for use in a message: not too much of it, and [`printable`].
pub(crate) fn excerpt(text: &str) -> Cow<'_, str> {
    const LONGEST: usize = 60;
    cut(text, LONGEST)
}

/// A whole message: not longer than one can read.
pub(crate) fn brief(text: &str) -> Cow<'_, str> {
    const LONGEST: usize = 400;
    cut(text, LONGEST)
}

fn cut(text: &str, longest: usize) -> Cow<'_, str> {
    match text.char_indices().nth(longest) {
        Some((end, _)) => format!("{}...", printable(&text[..end])).into(),
        None => printable(text),
    }
}

impl LoadProblem {
    pub(crate) fn element(place: impl Into<String>, message: impl ToString) -> Self {
        Self::Element { place: place.into(), message: message.to_string() }
    }

    pub(crate) fn line(line: usize, message: impl Into<String>) -> Self {
        Self::Text { line, column: None, message: message.into() }
    }

    pub(crate) fn in_file(self, file: &Path) -> LoadError {
        LoadError { file: file.to_path_buf(), problem: self }
    }
}

impl LoadError {
    /// Whether a file is missing, unreadable or of an unknown kind (the command line's exit code 2); otherwise the
    /// files were read and their content is refused (exit code 1).
    pub fn is_unreadable(&self) -> bool {
        matches!(self.problem, LoadProblem::Unreadable { .. } | LoadProblem::UnknownFormat)
    }

    fn describe(&self) -> String {
        let text = match &self.problem {
            LoadProblem::Unreadable { path, .. } if *path == self.file => self.problem.to_string(),
            problem => format!("{}: {}", self.file.display(), brief(&problem.to_string())),
        };
        printable(&text).into_owned()
    }
}
