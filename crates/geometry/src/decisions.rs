//! How many decisions were made, and at which level: floats of 32 bits, of 64 bits, pairs of these, exact
//! sums of floats, big numbers.
//!
//! A decision is a sign or an order of input numbers that something else follows from. Each goes through filters, and to
//! exact arithmetic only where these leave a doubt; it counts once, at the level that settled it. What coordinates tell by
//! being equal (shared corners) is no arithmetic and is not counted.
//!
//! Each thread counts for itself, in a line of its own that no other thread writes: a load, an addition and a store. Sums are
//! made when they are asked for. A statistic: nothing depends on it.

use std::{
    ops::Sub,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
};

/// What settles a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Floats of 32 bits, with their bound.
    Single,
    /// Floats of 64 bits, with their bound.
    Double,
    /// Pairs of floats of 64 bits (some 106 bits), with their bound.
    Pair,
    /// Sums of floats of 64 bits without rounding: exact, without big numbers.
    Expansion,
    /// Exact arithmetic with big numbers.
    Exact,
}

/// Decisions by the level that settled them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Decisions {
    /// By floats of 32 bits.
    pub single: u64,
    /// By floats of 64 bits.
    pub double: u64,
    /// By pairs of floats of 64 bits.
    pub pair: u64,
    /// By exact sums of floats.
    pub expansion: u64,
    /// By big numbers.
    pub exact: u64,
}

impl Decisions {
    /// All of this process so far, on all threads.
    pub fn of_process() -> Self {
        let threads = threads();
        threads.counting.iter().fold(threads.ended, |sum, thread| sum.plus(thread.read()))
    }

    /// All of the calling thread so far.
    pub fn of_thread() -> Self {
        OWN.try_with(|own| own.read()).unwrap_or_default()
    }

    /// How many there are, at all levels.
    pub fn all(self) -> u64 {
        self.single + self.double + self.pair + self.expansion + self.exact
    }

    fn plus(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }

    fn with(self, other: Self, join: impl Fn(u64, u64) -> u64) -> Self {
        Self {
            single: join(self.single, other.single),
            double: join(self.double, other.double),
            pair: join(self.pair, other.pair),
            expansion: join(self.expansion, other.expansion),
            exact: join(self.exact, other.exact),
        }
    }
}

impl Sub for Decisions {
    type Output = Self;

    /// What was decided between an earlier count and this one.
    fn sub(self, earlier: Self) -> Self {
        self.with(earlier, |now, then| now - then)
    }
}

/// Counts `number` decisions that were settled at a level. About a nanosecond; loops over many count once, at their end.
#[inline]
pub fn count(level: Level, number: u64) {
    // A thread that is ending counts no more.
    let _ = OWN.try_with(|own| own.add(level, number));
}

/// A filter's answer in floats of 64 bits, or else that of big numbers; counts which of them settled the decision.
#[inline]
pub fn decide<T>(filtered: Option<T>, exact: impl FnOnce() -> T) -> T {
    count(if filtered.is_some() { Level::Double } else { Level::Exact }, 1);
    filtered.unwrap_or_else(exact)
}

/// As [`decide`], with pairs of floats between the filter and big numbers.
pub fn decide_by_pairs<T>(filtered: Option<T>, by_pairs: impl FnOnce() -> Option<T>, exact: impl FnOnce() -> T) -> T {
    if filtered.is_none()
        && let Some(answer) = by_pairs()
    {
        count(Level::Pair, 1);
        return answer;
    }
    decide(filtered, exact)
}

/// The counts of one thread, in a cache line of their own.
#[derive(Debug, Default)]
#[repr(align(64))]
struct Counts([AtomicU64; 5]);

impl Counts {
    /// For the thread that the counts belong to: no other one writes, so nothing is lost between load and store.
    #[inline]
    fn add(&self, level: Level, number: u64) {
        let counter = &self.0[level as usize];
        counter.store(counter.load(Ordering::Relaxed) + number, Ordering::Relaxed);
    }

    fn read(&self) -> Decisions {
        let [single, double, pair, expansion, exact] = self.0.each_ref().map(|counter| counter.load(Ordering::Relaxed));
        Decisions { single, double, pair, expansion, exact }
    }
}

/// The counts of all threads that ever counted.
struct Threads {
    counting: Vec<Arc<Counts>>,
    /// The sum over threads that are no more.
    ended: Decisions,
}

static THREADS: Mutex<Threads> = Mutex::new(Threads {
    counting: Vec::new(),
    ended: Decisions { single: 0, double: 0, pair: 0, expansion: 0, exact: 0 },
});

thread_local! {
    static OWN: Arc<Counts> = register();
}

fn threads() -> std::sync::MutexGuard<'static, Threads> {
    THREADS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes the counts of a new thread, and adds up those of threads that have ended, so that the list stays short.
fn register() -> Arc<Counts> {
    let own = Arc::new(Counts::default());
    let mut threads = threads();
    let all = std::mem::take(&mut threads.counting);
    for counts in all {
        match Arc::try_unwrap(counts) {
            Ok(counts) => threads.ended = threads.ended.plus(counts.read()),
            Err(counts) => threads.counting.push(counts),
        }
    }
    threads.counting.push(Arc::clone(&own));
    own
}
