//! One program for all fuzz targets, on libFuzzer (LLVM's coverage-guided, in-process fuzzer); `UMBRIEL_TARGET` names the
//! target. `cargo xtask fuzz` builds it with coverage counters, which needs no nightly compiler, and runs it.
//!
//! The targets themselves ([`targets`]) are plain functions of bytes, which a test of the crate `umbriel` calls with the
//! stored corpus. A target panics where something is wrong; otherwise it has nothing to say.

#![no_main]

#[allow(dead_code, reason = "the targets use a part of it")]
#[path = "../../crates/umbriel/tests/judges/chance/mod.rs"]
mod chance;
#[allow(dead_code, reason = "the targets use a part of it")]
#[path = "../../crates/umbriel/tests/judges/oracle/mod.rs"]
mod oracle;
#[allow(dead_code, reason = "the targets use a part of it")]
#[path = "../../crates/umbriel/tests/judges/proving/mod.rs"]
mod proving;
mod targets;

use std::sync::OnceLock;

libfuzzer_sys::fuzz_target!(|data: &[u8]| chosen()(data));

fn chosen() -> targets::Target {
    static CHOSEN: OnceLock<targets::Target> = OnceLock::new();
    *CHOSEN.get_or_init(|| {
        let name = std::env::var("UMBRIEL_TARGET").expect("UMBRIEL_TARGET names a target");
        targets::TARGETS.iter().find(|target| target.0 == name).expect("a target of that name").1
    })
}
