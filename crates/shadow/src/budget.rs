//! Limits as detail: a share that may stay undecided, a time, or the memory of the answers.
//!
//! One engine for all of them. Every receiver is first looked at whole; then, step by step, the receivers whose undecided area is largest for what the next
//! depth is expected to cost are divided one depth further, until the limit is met. What a step finds only ever narrows what is known: bounds are the
//! tighter ones of two proofs. So the result is valid whenever it stops, and more time never gives wider bounds.
//!
//! The sequence of steps depends on counts alone, not on clocks or threads; a time limit decides only how many of them are done. A step that the clock
//! catches is given up. Cost: a receiver at depth d has been through all depths before, which together cost about as much as the last one where cells lie along
//! borders.

use std::time::Instant;

use crate::{
    bake::{Ran, run},
    levels::MAX_DEPTH,
    progress::{Cancelled, Progress},
    receivers::Receivers,
    report::{Cell, LitArea, ObjectReport, Work},
    request::Detail,
};

/// Steps take receivers together until about so many cells are expected, so that threads have something to do.
const CELLS_A_STEP: u64 = 1 << 15;

/// Where to stop; what is not given does not stop.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Limit {
    /// Enough is decided when at most this share of the area is not.
    pub(crate) share: f64,
    /// No step is begun after this moment, and none goes on.
    pub(crate) deadline: Option<Instant>,
    /// Bytes that the examined cells may take if they are stored.
    pub(crate) bytes: Option<u64>,
}

/// A receiver and what is known of it so far.
struct Known {
    depth: u8,
    /// Cells that the last look examined.
    cost: u64,
    /// Whether dividing it further is no use, or no longer allowed.
    is_done: bool,
    is_divided: bool,
    report: ObjectReport,
}

/// Divides the receivers as far as the limit lets it.
///
/// # Errors
/// [`Cancelled`] when `progress` says so.
pub(crate) fn refine(
    receivers: &mut Receivers,
    limit: &Limit,
    progress: &dyn Progress,
    work: &mut Work,
) -> Result<Vec<ObjectReport>, Cancelled> {
    receivers.detail = Detail::Depth { interior: 0, boundary: 0 };
    let first = run(receivers, |_| true, progress, work)?;
    let mut known: Vec<Known> = first.into_iter().map(Known::new).collect();
    let until = Until { progress, deadline: limit.deadline };
    while !is_enough(&known, limit.share) {
        let step = next_step(&known);
        if step.is_empty() || until.is_over() {
            break;
        }
        for depth in depths(&known, &step) {
            receivers.detail = Detail::Depth { interior: depth, boundary: depth };
            let asked = |receiver: usize| step.contains(&receiver) && known[receiver].depth + 1 == depth;
            let ran = match run(receivers, asked, &until, work) {
                Ok(ran) => ran,
                Err(Cancelled) if progress.is_cancelled() => return Err(Cancelled),
                Err(Cancelled) => return Ok(reports(known, work)),
            };
            let chosen: Vec<usize> = step.iter().copied().filter(|&receiver| asked(receiver)).collect();
            take(&mut known, &chosen, ran, limit);
        }
    }
    Ok(reports(known, work))
}

/// Whether little enough is undecided.
fn is_enough(known: &[Known], share: f64) -> bool {
    let area: f64 = known.iter().map(|one| one.report.area).sum();
    let undecided: f64 = known.iter().map(|one| one.report.undecided()).sum();
    undecided <= share * area
}

/// The receivers that the next step divides, ascending: those with the most undecided area for the expected cost.
fn next_step(known: &[Known]) -> Vec<usize> {
    let worth = |&receiver: &usize| known[receiver].report.undecided() / known[receiver].cost as f64;
    let open =
        (0..known.len()).filter(|&receiver| !known[receiver].is_done && known[receiver].report.undecided() > 0.0);
    let mut open: Vec<usize> = open.collect();
    open.sort_by(|a, b| worth(b).total_cmp(&worth(a)).then(a.cmp(b)));
    let mut expected = 0;
    let mut step: Vec<usize> = open
        .into_iter()
        .take_while(|&receiver| {
            let is_taken = expected < CELLS_A_STEP;
            // Cells along borders: twice as many a depth.
            expected += 2 * known[receiver].cost;
            is_taken
        })
        .collect();
    step.sort_unstable();
    step
}

/// The depths that a step goes to, ascending.
fn depths(known: &[Known], step: &[usize]) -> Vec<u8> {
    let mut depths: Vec<u8> = step.iter().map(|&receiver| known[receiver].depth + 1).collect();
    depths.sort_unstable();
    depths.dedup();
    depths
}

/// Takes what a step found, unless it would be more than may be stored.
fn take(known: &mut [Known], chosen: &[usize], mut ran: Vec<Ran>, limit: &Limit) {
    let bytes =
        |examined: u64, report: &ObjectReport| examined.max(report.cells.len() as u64) * size_of::<Cell>() as u64;
    let mut stored: u64 = known.iter().map(|one| bytes(one.cost, &one.report)).sum();
    for &receiver in chosen {
        let found = std::mem::take(&mut ran[receiver]);
        let one = &mut known[receiver];
        let with = stored - bytes(one.cost, &one.report) + bytes(found.examined, &found.report);
        if limit.bytes.is_some_and(|most| with > most) {
            one.is_done = true;
            continue;
        }
        stored = with;
        one.take(found);
    }
}

/// The reports, with the receivers counted that were divided in the end.
fn reports(known: Vec<Known>, work: &mut Work) -> Vec<ObjectReport> {
    work.octrees_built += known.iter().filter(|one| one.is_divided).count() as u64;
    known.into_iter().map(|one| one.report).collect()
}

impl Known {
    fn new(ran: Ran) -> Self {
        let is_done = ran.report.undecided() == 0.0;
        Self { depth: 0, cost: ran.examined.max(1), is_done, is_divided: ran.is_divided, report: ran.report }
    }

    /// A deeper look; bounds that were tighter before are kept.
    fn take(&mut self, ran: Ran) {
        let before = self.report.lit;
        let now = ran.report.lit;
        let (lower, upper) = (before.lower.max(now.lower), before.upper.min(now.upper));
        self.depth += 1;
        self.cost = ran.examined.max(1);
        self.is_done = self.depth >= MAX_DEPTH;
        self.is_divided = ran.is_divided;
        self.report =
            ObjectReport { lit: LitArea { lower, upper, estimate: now.estimate.clamp(lower, upper) }, ..ran.report };
    }
}

/// Cancels when the time is over, too.
pub(crate) struct Until<'a> {
    pub(crate) progress: &'a dyn Progress,
    pub(crate) deadline: Option<Instant>,
}

impl Until<'_> {
    pub(crate) fn is_over(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }
}

impl Progress for Until<'_> {
    fn advance(&self, phase: &str, done: u64, total: u64) {
        self.progress.advance(phase, done, total);
    }

    fn is_cancelled(&self) -> bool {
        self.progress.is_cancelled() || self.is_over()
    }
}
