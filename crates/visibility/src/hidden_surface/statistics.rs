//! What a method did.

use std::ops::AddAssign;

/// Counts of a method's work; they add up over windows, and do not depend on threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Windows of the picture that were drawn one by one.
    pub windows: u64,
    /// Questions whether a face covers a pixel, a row of pixels or a window.
    pub tests: u64,
    /// Comparisons of depths.
    pub depths: u64,
    /// Faces, or rows of them, that were passed over because something nearer is known all over them.
    pub skipped: u64,
    /// Pixels that got a face, or one instead of another.
    pub written: u64,
    /// Windows that were quartered, intervals that were halved, faces that were split.
    pub divided: u64,
    /// Questions that floats left open, decided by exact signs.
    pub judged: u64,
}

impl AddAssign for Statistics {
    fn add_assign(&mut self, other: Self) {
        self.windows += other.windows;
        self.tests += other.tests;
        self.depths += other.depths;
        self.skipped += other.skipped;
        self.written += other.written;
        self.divided += other.divided;
        self.judged += other.judged;
    }
}

impl std::iter::Sum for Statistics {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), |mut sum, part| {
            sum += part;
            sum
        })
    }
}
