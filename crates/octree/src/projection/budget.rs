//! Memory that parts made side by side may take together: once it is spent, what is left is not made, and the whole is thrown away.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Bytes that may be spent, and what was. Whether it is exceeded in the end does not depend on the order of spending.
#[derive(Debug)]
pub(super) struct Budget {
    limit: usize,
    spent: AtomicUsize,
}

impl Budget {
    pub(super) fn new(limit: usize) -> Self {
        Self { limit, spent: AtomicUsize::new(0) }
    }

    /// For what is known to fit.
    pub(super) fn unlimited() -> Self {
        Self::new(usize::MAX)
    }

    pub(super) fn limit(&self) -> usize {
        self.limit
    }

    pub(super) fn spend(&self, bytes: usize) {
        self.spent.fetch_add(bytes, Ordering::Relaxed);
    }

    pub(super) fn is_over(&self) -> bool {
        self.spent.load(Ordering::Relaxed) > self.limit
    }
}
