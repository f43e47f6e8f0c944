//! Ends other than success, and their exit codes.

use std::io;

use umbriel_io::{LoadError, write::WriteError};
use umbriel_shadow::Cancelled;

/// Why a command did not end well.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The files were read and their content is refused.
    Refused(String),
    /// Wrong usage, a missing or unreadable file, a failed write.
    Unusable(String),
    /// Stopped from the keyboard.
    Interrupted,
    /// Whoever read our output has seen enough; that is a success.
    ClosedPipe,
}

impl Failure {
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::ClosedPipe => 0,
            Self::Refused(_) => 1,
            Self::Unusable(_) => 2,
            // 128 + SIGINT, as shells expect.
            Self::Interrupted => 130,
        }
    }

    pub(crate) fn message(&self) -> Option<&str> {
        match self {
            Self::Refused(message) | Self::Unusable(message) => Some(message),
            Self::Interrupted => Some("interrupted; nothing was written"),
            Self::ClosedPipe => None,
        }
    }

    /// What became of writing to standard output.
    pub(crate) fn of_output(error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::ClosedPipe,
            _ => Self::Unusable(format!("cannot write to standard output: {error}")),
        }
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Self {
        if error.is_unreadable() { Self::Unusable(error.to_string()) } else { Self::Refused(error.to_string()) }
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        Self::Unusable(error.to_string())
    }
}

impl From<Cancelled> for Failure {
    fn from(Cancelled: Cancelled) -> Self {
        Self::Interrupted
    }
}
