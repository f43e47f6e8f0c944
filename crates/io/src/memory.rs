//! The most memory that this process, or a part of its work, held, where the system tells (Linux).

use std::fs;

/// The most memory in use since this was made, over what was in use then.
///
/// Pages that were freed before and not given back are in use to the system: what takes no more than these shows nothing. So a part of the work is measured
/// in a process of its own, with `MALLOC_TRIM_THRESHOLD_` and `MALLOC_MMAP_THRESHOLD_` set low where the C library is GNU's.
#[derive(Clone, Copy, Debug)]
pub struct MemoryPeak {
    before: Option<u64>,
}

impl MemoryPeak {
    /// Sets the peak back to what is in use now.
    pub fn start() -> Self {
        let is_reset = fs::write("/proc/self/clear_refs", "5").is_ok();
        Self { before: is_reset.then(|| status_bytes("VmRSS:")).flatten() }
    }

    /// Bytes; `None` where the system does not tell.
    pub fn bytes(&self) -> Option<u64> {
        Some(peak_memory_bytes()?.saturating_sub(self.before?))
    }
}

/// The most memory that this process has held, bytes; `None` where the system does not tell.
pub fn peak_memory_bytes() -> Option<u64> {
    status_bytes("VmHWM:")
}

fn status_bytes(key: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(key))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}
