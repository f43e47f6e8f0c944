//! Times of the day, read only to find the step between them.
//!
//! A time is `H:MM` or `H:MM:SS`, alone or after a date `YYYY-MM-DD` and a `T` or a space, and may end in `Z` or an
//! offset like `+02:00`. The step is the least difference between times of one date, and every difference must be a
//! whole multiple of it (a table may leave out the night). Offsets do not count: times are compared as the clock showed them.

use std::{collections::BTreeMap, time::Duration};

/// What a clock showed.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Clock {
    /// As written; empty without one.
    date: String,
    /// Seconds since midnight.
    second: u32,
}

impl Clock {
    /// The time in a text; `None` if it is anything else.
    pub(super) fn read(text: &str) -> Option<Self> {
        let (date, time) = text.split_once(['T', ' ']).unwrap_or(("", text));
        let is_digits = |part: &str, lengths: [usize; 2]| {
            lengths.contains(&part.len()) && part.bytes().all(|byte| byte.is_ascii_digit())
        };
        let parts: Vec<&str> = date.split('-').collect();
        let is_date = matches!(parts[..], [y, m, d] if is_digits(y, [4, 4]) && is_digits(m, [2, 2]) && is_digits(d, [2, 2])
            && is_day(y, m, d));
        if !date.is_empty() && !is_date {
            return None;
        }
        // An offset begins at a sign; `Z` stands for none.
        let (clock, offset) = match time.find(['+', '-']) {
            Some(at) => (&time[..at], &time[at + 1..]),
            None => (time.strip_suffix('Z').unwrap_or(time), "0:00"),
        };
        let whole = || if is_digits(offset, [4, 4]) { offset.split_at(2) } else { (offset, "00") };
        let (hours, minutes) = offset.split_once(':').unwrap_or_else(whole);
        let is_below = |part: &str, limit: u32| part.parse().is_ok_and(|number: u32| number < limit);
        let is_offset = is_digits(hours, [1, 2]) && is_digits(minutes, [2, 2]);
        if !is_offset || !is_below(hours, 24) || !is_below(minutes, 60) {
            return None;
        }
        let clock = clock.trim_end();
        let parts: Vec<&str> = clock.split(':').collect();
        if !(2..=3).contains(&parts.len()) || !parts.iter().all(|part| is_digits(part, [1, 2])) {
            return None;
        }
        let number = |index: usize| parts.get(index).map_or(Some(0), |part| part.parse::<u32>().ok());
        let (hour, minute, second) = (number(0)?, number(1)?, number(2)?);
        let second_of_day = hour * 3600 + minute * 60 + second;
        let is_time = second_of_day <= 24 * 3600 && minute < 60 && second < 60;
        is_time.then(|| Self { date: date.to_owned(), second: second_of_day })
    }
}

/// Whether the calendar has that day.
fn is_day(year: &str, month: &str, day: &str) -> bool {
    let number = |text: &str| text.parse::<u32>().unwrap_or_default();
    let year = number(year);
    let is_leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let days = match number(month) {
        2 => 28 + u32::from(is_leap),
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => 0,
    };
    (1..=days).contains(&number(day))
}

/// Why times have no step. Rows by their index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StepDefect {
    /// Two rows with one time.
    Repeated { row: usize, of: usize },
    /// A time that is no whole number of steps after the one before.
    Uneven { row: usize, seconds: u32 },
}

/// The step of the times; `None` where no date has two of them.
pub(super) fn step(clocks: &[Clock]) -> Result<Option<Duration>, StepDefect> {
    let mut rows: BTreeMap<&Clock, usize> = BTreeMap::new();
    for (row, clock) in clocks.iter().enumerate() {
        if let Some(of) = rows.insert(clock, row) {
            return Err(StepDefect::Repeated { row, of });
        }
    }
    let pairs = || rows.iter().zip(rows.iter().skip(1)).filter(|((one, _), (next, _))| one.date == next.date);
    let gap = |one: &Clock, next: &Clock| next.second - one.second;
    let Some(step) = pairs().map(|((one, _), (next, _))| gap(one, next)).min() else { return Ok(None) };
    match pairs().find(|((one, _), (next, _))| gap(one, next) % step != 0) {
        Some((_, (_, &row))) => Err(StepDefect::Uneven { row, seconds: step }),
        None => Ok(Some(Duration::from_secs(u64::from(step)))),
    }
}
