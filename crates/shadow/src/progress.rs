//! How a long computation tells where it is, and is told to stop.

/// Told about progress; may cancel. Called from several threads.
pub trait Progress: Sync {
    /// `done` of `total` steps of the named phase are through. Cheap calls, a few thousand at most.
    fn advance(&self, phase: &str, done: u64, total: u64);

    /// Whether to stop. Asked often.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Says nothing, never cancels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn advance(&self, _phase: &str, _done: u64, _total: u64) {}
}

/// The computation was told to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;
