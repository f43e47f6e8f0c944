//! The most memory that a part of the work held, where the system tells (Linux).

use std::fs;

/// The most memory in use since this was made, over what was in use then.
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
