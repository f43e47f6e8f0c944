//! Times of this process.

use std::{
    hint::black_box,
    time::{Duration, Instant},
};

use serde::Serialize;

/// Seconds that something took: by the clock on the wall, and of processor time over all threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Seconds {
    pub(crate) wall: f64,
    pub(crate) cpu: f64,
}

impl Seconds {
    /// More than anything takes.
    pub(super) const MOST: Self = Self { wall: f64::INFINITY, cpu: f64::INFINITY };

    /// The lesser of both, each for itself: what a quiet machine would show.
    pub(super) fn min(self, other: Self) -> Self {
        Self { wall: self.wall.min(other.wall), cpu: self.cpu.min(other.cpu) }
    }
}

impl std::ops::Add for Seconds {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { wall: self.wall + other.wall, cpu: self.cpu + other.cpu }
    }
}

/// Runs something and takes its time. The result is dropped outside.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, Seconds) {
    let (cpu, begun) = (processor_time(), Instant::now());
    let result = black_box(work());
    let wall = begun.elapsed();
    let cpu = processor_time().zip(cpu).map_or(wall, |(after, before)| after - before);
    (result, Seconds { wall: wall.as_secs_f64(), cpu: cpu.as_secs_f64() })
}

/// The processor time of all threads of this process so far, where the system tells it.
#[cfg(unix)]
fn processor_time() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Some(Duration::new(u64::try_from(time.tv_sec).ok()?, u32::try_from(time.tv_nsec).ok()?))
}

#[cfg(not(unix))]
fn processor_time() -> Option<Duration> {
    None
}
