//! Times and memory of this process.

use std::{
    fs,
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

/// The most memory in use since this was made, over what was in use then. Bytes; Linux only.
pub(super) struct MemoryPeak {
    before: Option<u64>,
}

impl MemoryPeak {
    pub(super) fn start() -> Self {
        // Sets the peak back to what is in use now.
        let is_reset = fs::write("/proc/self/clear_refs", "5").is_ok();
        Self { before: is_reset.then(|| status_bytes("VmRSS:")).flatten() }
    }

    pub(super) fn bytes(&self) -> Option<u64> {
        Some(status_bytes("VmHWM:")?.saturating_sub(self.before?))
    }
}

fn status_bytes(key: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(key))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}
