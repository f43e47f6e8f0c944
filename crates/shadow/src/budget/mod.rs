//! Limits as detail: a share that may stay undecided, a time, or the memory of the answers; and what may be done for a detail where more would be too much.
//!
//! One engine for all of them, a best-first search over faces. At first only the area of each face is known, and whether it is turned to the light; what
//! is turned away is in shadow, all else is undecided. Then, step by step, the faces with the most undecided area for the cells that a closer look is
//! expected to cost are looked at: a face for the first time as deep as pays beside the cost of looking at it at all, later two levels deeper each
//! time, or more where those pay. What a look finds only ever narrows what is known: bounds are the tighter ones of two proofs. So the result is valid whenever it stops, and
//! more time never gives wider bounds.
//!
//! Where a clock runs, nothing may cost more than its turn: of meshes only bounds on the area are known until their faces are listed ([`unlisted`]), and a look
//! waits until as much has been spent on others, since one that the clock catches is lost.
//!
//! The sequence of looks depends on counts alone, not on clocks or threads; a time limit decides only how many of them are done. The looks that the clock
//! catches are given up, with those after them that other threads had done. Equal worth goes into one step, so that the order of objects and faces does not
//! matter to a share. Cost: that of the last look at each face; a look costs about four times the one before it where cells lie along borders, so those
//! before add a third.

mod looks;
mod open;
mod unlisted;

use std::{
    collections::{BTreeMap, BinaryHeap},
    time::{Duration, Instant},
};

use rayon::prelude::*;

use crate::{
    bodies::Bodies,
    effort::Ledger,
    levels::MAX_DEPTH,
    progress::{Cancelled, Progress},
    receivers::{FaceSums, Found, Job, Receivers},
    report::Cell,
    request::Detail,
    sums::{AreaSums, ExactSum, FaceArea},
};
use looks::{First, Looks};
use open::{FaceId, Known, Open};
use unlisted::{Unlisted, Waiting};

/// Steps take faces together until about so many cells are expected, so that threads have something to do.
const CELLS_A_STEP: u64 = 1 << 12;

/// Later steps take this part of all that was spent before: threads wait for each other at the end of each step.
const SPENT_A_STEP: u64 = 8;

/// What it takes to join the cells of a receiver's faces, a cell: mostly for fresh memory.
const JOINING: Duration = Duration::from_nanos(15);

/// Where to stop; what is not given does not stop.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Limit {
    /// Enough is decided when at most this share of the area is not.
    pub(crate) share: f64,
    /// The answers are due at this moment: no look is begun later, and none goes on.
    pub(crate) deadline: Option<Instant>,
    /// Bytes that the examined cells may take if they are stored.
    pub(crate) bytes: Option<u64>,
    /// What all looks together may spend; no cell is finer than those of the detail.
    pub(crate) work: Option<u64>,
}

/// Divides the faces of the receivers as far as the limit lets it: sums, one a receiver.
///
/// # Errors
/// [`Cancelled`] when `progress` says so.
pub(crate) fn refine(
    receivers: &mut Receivers,
    limit: &Limit,
    progress: &dyn Progress,
) -> Result<Vec<FaceSums>, Cancelled> {
    receivers.is_cut_short = limit.work.is_some();
    if limit.work.is_none() {
        receivers.detail = Detail::Depth { interior: MAX_DEPTH, boundary: MAX_DEPTH };
    }
    let mut refined = Refined::new(receivers, limit, progress)?;
    // The first looks are taken whatever the clock says; of all others those that it caught are given up.
    limit.deadline.iter().for_each(|&deadline| refined.looks.all.occluders.stop_at(deadline));
    while !refined.is_enough(limit.share) && !refined.is_full(limit) {
        refined.take_back();
        let until = Until { progress, deadline: limit.deadline.map(|deadline| refined.last_moment(deadline)) };
        let unlisted = refined.waiting.next_step(refined.open.peek().map(|open| open.worth));
        let goes_on = if unlisted.is_empty() {
            let step = refined.next_step();
            !step.is_empty() && refined.take_step(step, limit, &until)
        } else {
            refined.list_step(unlisted, &until)
        };
        if !goes_on {
            break;
        }
        progress.advance("shadows", refined.decided(), 1000);
    }
    if progress.is_cancelled() { Err(Cancelled) } else { Ok(refined.finish()) }
}

/// All that is known so far.
struct Refined<'a> {
    looks: Looks<'a>,
    /// Receivers whose faces are not listed yet.
    waiting: Waiting,
    open: BinaryHeap<Open>,
    /// Faces whose next look costs more than all before it, by its cost; where a clock runs, such a look might be all that it gets.
    dear: BTreeMap<(u64, FaceId), Open>,
    /// What all looks were expected to cost, in cells.
    spent: u64,
    /// What they did, as it is counted for a limit of work.
    work: u64,
    /// Whether looks may be lost: a clock runs, or the work is counted.
    is_clocked: bool,
    /// One a receiver, without cells.
    totals: Vec<FaceSums>,
    /// The cells of each receiver's faces, if they are kept.
    cells: Vec<BTreeMap<u32, Vec<Cell>>>,
    /// How many of these will have to be joined.
    to_join: u32,
    /// Over all receivers.
    areas: AreaSums,
    /// Cells kept or examined for what is known.
    stored: u64,
    /// What is undecided of faces that are divided no further.
    closed: ExactSum,
}

impl<'a> Refined<'a> {
    /// The areas; where samples are asked for, a look at each face that decides them.
    fn new(receivers: &'a Receivers<'a>, limit: &Limit, progress: &dyn Progress) -> Result<Self, Cancelled> {
        // Of cells that are kept each face has one at least.
        let is_each_face_told = receivers.spacing.is_some() || receivers.request.keep_cells;
        let may_wait = limit.deadline.is_some() && !is_each_face_told;
        let waiting = if may_wait { Waiting::of(receivers) } else { Waiting::default() };
        let count = receivers.request.receivers.len();
        let mut waits = vec![false; count];
        waiting.iter().for_each(|unlisted| waits[unlisted.receiver] = true);
        let jobs: Vec<Job> = (0..count).filter(|&k| !waits[k]).flat_map(|k| receivers.jobs_of(k)).collect();
        let looks = Looks { all: receivers, is_sparing: limit.bytes.is_some() };
        let firsts: Vec<First> = jobs.par_iter().map(|job| looks.first(job, progress)).collect();
        let mut all = Self {
            looks,
            waiting: Waiting::default(),
            open: BinaryHeap::new(),
            dear: BTreeMap::new(),
            spent: 0,
            work: 0,
            is_clocked: limit.deadline.is_some() || limit.work.is_some(),
            totals: (0..count).map(|_| FaceSums::default()).collect(),
            cells: vec![BTreeMap::new(); count],
            to_join: 0,
            areas: AreaSums::default(),
            stored: 0,
            closed: ExactSum::default(),
        };
        for unlisted in waiting.iter() {
            let area = FaceArea::unknown(unlisted.area);
            all.totals[unlisted.receiver].areas.add(&area);
            all.areas.add(&area);
        }
        all.waiting = waiting;
        let mut open = Vec::new();
        jobs.iter().zip(firsts).for_each(|(job, first)| open.append(&mut all.take_first(job.receiver, first)));
        all.open = open.into();
        if progress.is_cancelled() { Err(Cancelled) } else { Ok(all) }
    }

    /// Takes what is known of some faces at first; answers those that may be looked at.
    fn take_first(&mut self, receiver: usize, mut first: First) -> Vec<Open> {
        self.stored += first.stored;
        for cell in std::mem::take(&mut first.sums.cells) {
            self.cells[receiver].entry(cell.face).or_default().push(cell);
        }
        self.areas.append(first.sums.areas.clone());
        self.totals[receiver].append(first.sums);
        first.open
    }

    /// Lists the faces of receivers, as far as the clock lets it; `false` if it caught one.
    fn list_step(&mut self, step: Vec<Unlisted>, until: &Until) -> bool {
        // Instances are placed for this alone.
        let bodies = Bodies::of_group(self.looks.all.bodies);
        let looks = Looks { all: &self.looks.all.of_group(&bodies), is_sparing: self.looks.is_sparing };
        let listed = in_order(&step, |_, unlisted| unlisted.list(&looks, until));
        self.spent += step.iter().map(Unlisted::cost).sum::<u64>();
        for (unlisted, firsts) in step.iter().zip(listed) {
            let Some(firsts) = firsts else { return false };
            let before = FaceArea::unknown(unlisted.area);
            self.totals[unlisted.receiver].areas.remove(&before);
            self.areas.remove(&before);
            for first in firsts {
                let open = self.take_first(unlisted.receiver, first);
                self.open.extend(open);
            }
        }
        true
    }

    /// Whether little enough is undecided of what may still be divided.
    fn is_enough(&self, share: f64) -> bool {
        let undecided = self.areas.upper.rounded_up() - self.areas.lower.rounded_down();
        undecided - self.closed.nearest() <= share * self.areas.area.nearest()
    }

    /// Whether no look can be taken any more: each keeps one cell at least, as before it.
    fn is_full(&self, limit: &Limit) -> bool {
        limit.bytes.is_some_and(|most| self.stored * size_of::<Cell>() as u64 > most)
    }

    /// How much is decided, in thousandths.
    fn decided(&self) -> u64 {
        let undecided = self.areas.upper.nearest() - self.areas.lower.nearest();
        (1000.0 * (1.0 - undecided / self.areas.area.nearest())) as u64
    }

    /// When the last look has to end for answers that are due then.
    fn last_moment(&self, deadline: Instant) -> Instant {
        deadline.checked_sub(JOINING * self.to_join).unwrap_or(deadline)
    }

    /// What the looks of a step may cost where a clock runs: no more than all before it.
    fn affordable(&self) -> u64 {
        self.spent.max(CELLS_A_STEP)
    }

    /// Takes those back that are no longer too dear.
    fn take_back(&mut self) {
        let affordable = self.affordable();
        while self.dear.first_key_value().is_some_and(|((cost, _), _)| *cost <= affordable) {
            self.open.extend(self.dear.pop_first().map(|(_, open)| open));
        }
    }

    /// The faces that are looked at next, in their order; of those that are too dear the cheapest where there are no others.
    fn next_step(&mut self) -> Vec<Open> {
        let mut step = Vec::new();
        while step.is_empty() && !self.open.is_empty() {
            let next = self.of_most_worth();
            step = if self.is_clocked { self.affordable_of(next) } else { self.spend(next) };
        }
        if step.is_empty() {
            let cheapest = self.dear.pop_first();
            self.spent += cheapest.as_ref().map_or(0, |((cost, _), _)| *cost);
            step.extend(cheapest.map(|(_, open)| open));
        }
        step
    }

    /// Faces of most worth, as many as cost what a step does, or more where they are worth the same.
    fn of_most_worth(&mut self) -> Vec<Open> {
        let (mut step, mut expected): (Vec<Open>, u64) = (Vec::new(), 0);
        let enough = CELLS_A_STEP.max(self.spent / SPENT_A_STEP);
        while let Some(next) = self.open.peek() {
            let is_tie = step.last().is_some_and(|last| last.worth == next.worth);
            if expected >= enough && !is_tie {
                break;
            }
            expected += next.expected();
            step.extend(self.open.pop());
        }
        step
    }

    /// All of these, whatever they cost.
    fn spend(&mut self, all: Vec<Open>) -> Vec<Open> {
        self.spent += all.iter().map(Open::expected).sum::<u64>();
        all
    }

    /// The first of these that together cost no more than is affordable; those that alone do are put aside, the others back.
    fn affordable_of(&mut self, all: Vec<Open>) -> Vec<Open> {
        let costs = in_order(&all, |_, open| self.looks.cost(open));
        let (affordable, mut sum, mut step) = (self.affordable(), 0, Vec::new());
        for (open, cost) in all.into_iter().zip(costs) {
            if cost > affordable {
                self.dear.insert((cost, open.id), open);
            } else if sum + cost > affordable {
                self.open.push(open);
            } else {
                sum += cost;
                step.push(open);
            }
        }
        self.spent += sum;
        step
    }

    /// Looks at the faces of a step and takes what was found, in the order of the step and up to the first that the clock caught or for which the work
    /// did not last; `false` if there is one.
    fn take_step(&mut self, step: Vec<Open>, limit: &Limit, until: &Until) -> bool {
        let ledger = Ledger::new(step.len(), limit.work.map_or(u64::MAX, |most| most - self.work));
        let looks = in_order(&step, |place, open| self.looks.look(open, until, &|work| ledger.spend(place, work)));
        for ((open, look), spent) in step.into_iter().zip(looks).zip(ledger.spent()) {
            let (Some(found), Some(spent)) = (look, spent) else { return false };
            self.work += spent;
            self.take(open, found, limit);
        }
        true
    }

    /// Takes what a look found, unless it would be more than may be stored.
    fn take(&mut self, open: Open, found: Found, limit: &Limit) {
        let id = open.id;
        let before = self.looks.before(open);
        let total = &mut self.totals[id.receiver as usize];
        total.examined += found.examined;
        total.points += found.points;
        let stored = found.examined.max(found.cells.len() as u64);
        let with = self.stored - before.stored + stored;
        if limit.bytes.is_some_and(|most| with * size_of::<Cell>() as u64 > most) {
            return;
        }
        self.stored = with;
        let cost = self.looks.cost_of(&found);
        let area = found.area.narrowed_by(&before.area.lit);
        for areas in [&mut total.areas, &mut self.areas] {
            areas.remove(&before.area);
            areas.add(&area);
        }
        total.divided |= found.examined > 1;
        total.is_crowded |= found.is_crowded;
        if self.looks.all.request.keep_cells {
            let (faces, count) = (&mut self.cells[id.receiver as usize], found.cells.len() as u32);
            let before = faces.insert(id.face, found.cells).map_or(0, |cells| cells.len() as u32);
            if faces.len() > 1 {
                self.to_join = self.to_join.saturating_add(count).saturating_sub(before);
            }
        }
        let is_at_end = cost.level >= self.looks.deepest(id);
        if is_at_end && area.lit.upper.is_finite() {
            self.closed.add(area.undecided());
        }
        let is_open = area.undecided() > 0.0 && area.lit.upper.is_finite() && !is_at_end;
        if is_open {
            let known = Known { cost, stored, area };
            self.open.push(Open::known(id, known));
        }
    }

    fn finish(self) -> Vec<FaceSums> {
        let cells: Vec<Vec<Cell>> = self.cells.into_par_iter().map(joined).collect();
        self.totals.into_iter().zip(cells).map(|(total, cells)| FaceSums { cells, ..total }).collect()
    }
}

/// The cells of all faces of a receiver, in the order of the faces.
fn joined(faces: BTreeMap<u32, Vec<Cell>>) -> Vec<Cell> {
    let count: usize = faces.values().map(Vec::len).sum();
    let mut faces = faces.into_values();
    let mut all = faces.next().unwrap_or_default();
    all.reserve_exact(count - all.len());
    faces.for_each(|cells| all.extend(cells));
    all
}

/// What is found for each of some things, told its place. They are begun one after the other, so that what is done when the time is over is the beginning but for what
/// each thread has at hand.
fn in_order<T: Sync, F: Send>(all: &[T], find: impl Fn(usize, &T) -> F + Sync) -> Vec<F> {
    let found = all.iter().enumerate().par_bridge();
    let mut found: Vec<(usize, F)> = found.map(|(place, one)| (place, find(place, one))).collect();
    found.sort_unstable_by_key(|(place, _)| *place);
    found.into_iter().map(|(_, found)| found).collect()
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
