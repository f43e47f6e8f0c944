//! The progress bar, and Ctrl-C.
//!
//! A bar appears only on a terminal and only once the work has taken half a second. Ctrl-C sets a flag that the long
//! loops look at; the command then ends by itself, and files that are not whole yet vanish with it.

use std::{
    io::{self, IsTerminal},
    sync::{
        Arc, OnceLock,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressStyle};
use umbriel_shadow::{Cancelled, Progress};

/// How long work may take before a bar appears.
const PATIENCE: Duration = Duration::from_millis(500);

/// Whether Ctrl-C was pressed.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens to Ctrl-C from now on; while files are read it still ends the process at once. Where that is impossible, Ctrl-C ends the process as it does everywhere.
    pub(crate) fn install() -> Self {
        let interrupt = Self::default();
        let flag = interrupt.0.clone();
        let _ = ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed));
        interrupt
    }

    pub(crate) fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Stops here if Ctrl-C was pressed.
    pub(crate) fn check(&self) -> Result<(), Cancelled> {
        if self.is_set() { Err(Cancelled) } else { Ok(()) }
    }
}

/// A bar on standard error.
#[derive(Debug)]
pub(crate) struct Bar {
    interrupt: Interrupt,
    begun: Instant,
    visible: bool,
    bar: OnceLock<ProgressBar>,
}

impl Bar {
    pub(crate) fn new(interrupt: &Interrupt, quiet: bool) -> Self {
        let visible = !quiet && io::stderr().is_terminal();
        Self { interrupt: interrupt.clone(), begun: Instant::now(), visible, bar: OnceLock::new() }
    }
}

impl Progress for Bar {
    fn advance(&self, phase: &str, done: u64, total: u64) {
        if !self.visible || self.begun.elapsed() < PATIENCE {
            return;
        }
        let bar = self.bar.get_or_init(|| {
            let style = ProgressStyle::with_template("{msg:12} {wide_bar} {percent:>3} %  {elapsed}");
            ProgressBar::new(total).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        if bar.message() != phase {
            bar.set_message(phase.to_owned());
        }
        bar.set_length(total);
        bar.set_position(done);
    }

    fn is_cancelled(&self) -> bool {
        self.interrupt.is_set()
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}
