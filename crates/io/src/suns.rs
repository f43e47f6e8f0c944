//! Tables of suns: the positions of the sun over a day or a year, one a row, as CSV.
//!
//! The header holds `azimuth,elevation` (degrees, as everywhere here) or `x,y,z` (the way the light travels), and may hold
//! `time` and `hours`; the order of the columns does not matter. A row lasts for its `hours`. Where that column is missing, all
//! rows last equally long: as long as the caller says; else for the step of the times ([`clock`]), where all are times of the day; else, where none is, for one hour. A column
//! of another name is an error: a misspelt `hours` must not become one hour a row. Cost: O(n log n).

mod clock;

use std::{
    borrow::Cow,
    io::{self, Read},
    time::Duration,
};

use crate::{error::excerpt, text};
use clock::{Clock, StepDefect};

/// Where a sun stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SunPlace {
    /// By its angles.
    Angles {
        /// Degrees clockwise from north.
        azimuth: f64,
        /// Degrees above the horizon; −90 to 90.
        elevation: f64,
    },
    /// By the way its light travels; any length but zero.
    Direction([f64; 3]),
}

/// One row of a table of suns.
#[derive(Clone, Debug, PartialEq)]
pub struct SunRow {
    /// Line of the file, counted from 1.
    pub line: usize,
    /// Where the sun stands.
    pub place: SunPlace,
    /// The column `time`, as it was written.
    pub time: Option<String>,
    /// For how long it stands there.
    pub duration: Duration,
}

/// Why a table of suns is refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SunsError {
    /// The file cannot be read.
    #[error("cannot read it: {0}")]
    Unreadable(#[from] io::Error),
    /// No header, or one that does not say where the suns stand.
    #[error("line {line}: {message}; expected azimuth,elevation or x,y,z, then if you like time and hours")]
    Header {
        /// Line of the file.
        line: usize,
        /// What is wrong with it.
        message: String,
    },
    /// A row that is no row of this table.
    #[error("line {line}: {message}")]
    Row {
        /// Line of the file.
        line: usize,
        /// What is wrong with it.
        message: String,
    },
    /// A header without rows.
    #[error("there is no sun in it: no row follows the header")]
    Empty,
}

impl SunsError {
    fn row(line: usize, message: impl Into<String>) -> Self {
        Self::Row { line, message: message.into() }
    }
}

/// Reads a table of suns. `each` is how long a row lasts where there is no column `hours`. Spaces around fields do not count,
/// blank lines neither.
///
/// # Errors
/// The first [`SunsError`].
pub fn read_suns(mut input: impl Read, each: Option<Duration>) -> Result<Vec<SunRow>, SunsError> {
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes)?;
    let text = str::from_utf8(&bytes).map_err(|error| {
        let before = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
        SunsError::row(text::last_line(&before), "the text is not UTF-8")
    })?;
    let mut lines = records(text.trim_start_matches('\u{feff}'));
    let (line, header) = lines.next().transpose()?.unwrap_or((1, "".into()));
    let columns = Columns::of(&fields(line, &header)?, line)?;
    let row = |(line, text): (usize, Cow<str>)| columns.row(line, &fields(line, &text)?);
    let mut rows = lines.map(|record| record.and_then(row)).collect::<Result<Vec<_>, _>>()?;
    if rows.is_empty() {
        return Err(SunsError::Empty);
    }
    if columns.hours.is_none() {
        let duration = each.map_or_else(|| step_of(&rows), Ok)?;
        rows.iter_mut().for_each(|row| row.duration = duration);
    }
    Ok(rows)
}

/// The rows of a text that are not blank, each with the number of its first line: fields in quotes may hold several. A quote that nothing closes would take
/// the rest of the file, and is refused.
fn records(text: &str) -> impl Iterator<Item = Result<(usize, Cow<'_, str>), SunsError>> {
    let mut lines = text::lines(text).zip(1..).filter(|(line, _)| !line.trim().is_empty());
    std::iter::from_fn(move || {
        let (first, number) = lines.next()?;
        let mut row = Cow::Borrowed(first);
        let mut is_in_quotes = ends_in_quotes(first, false);
        while is_in_quotes && let Some((line, _)) = lines.next() {
            is_in_quotes = ends_in_quotes(line, true);
            row = row + "\n" + line;
        }
        Some(if is_in_quotes { Err(SunsError::row(number, "a quote is not closed")) } else { Ok((number, row)) })
    })
}

/// Whether a line ends within a field in quotes: one that begins with a quote, up to the next one that is not doubled.
fn ends_in_quotes(line: &str, mut is_in_quotes: bool) -> bool {
    let (mut begins_field, mut rest) = (true, line.bytes().peekable());
    while let Some(byte) = rest.next() {
        if is_in_quotes {
            is_in_quotes = byte != b'"' || rest.next_if_eq(&b'"').is_some();
        } else {
            is_in_quotes = begins_field && byte == b'"';
        }
        begins_field = byte == b',' && !is_in_quotes;
    }
    is_in_quotes
}

/// The fields of one row.
fn fields(line: usize, text: &str) -> Result<Vec<String>, SunsError> {
    if !text.contains('"') && !text.is_empty() {
        return Ok(text.split(',').map(|field| field.trim().to_owned()).collect());
    }
    let mut options = csv::ReaderBuilder::new();
    let mut reader = options.has_headers(false).flexible(true).trim(csv::Trim::All).from_reader(text.as_bytes());
    let record = reader.records().next().transpose().map_err(|error| SunsError::row(line, error.to_string()))?;
    Ok(record.unwrap_or_default().iter().map(str::to_owned).collect())
}

/// Which columns hold the place.
#[derive(Clone, Copy, Debug)]
enum PlaceColumns {
    Angles([usize; 2]),
    Direction([usize; 3]),
}

/// What stands in which column.
#[derive(Clone, Copy, Debug)]
struct Columns {
    count: usize,
    place: PlaceColumns,
    time: Option<usize>,
    hours: Option<usize>,
}

const KNOWN: [&str; 7] = ["azimuth", "elevation", "x", "y", "z", "time", "hours"];

impl Columns {
    fn of(header: &[String], line: usize) -> Result<Self, SunsError> {
        let wrong = |message: String| SunsError::Header { line, message };
        if let Some(name) = header.iter().find(|name| !KNOWN.contains(&name.as_str())) {
            return Err(wrong(format!("there is a column \"{}\"", excerpt(name))));
        }
        let [azimuth, elevation, x, y, z, time, hours] = KNOWN.map(|name| header.iter().position(|have| have == name));
        if let Some(name) = header.iter().enumerate().find(|(i, name)| header[..*i].contains(name)) {
            return Err(wrong(format!("there are two columns \"{}\"", name.1)));
        }
        let place = match ([azimuth, elevation], [x, y, z]) {
            ([Some(azimuth), Some(elevation)], [None, None, None]) => PlaceColumns::Angles([azimuth, elevation]),
            ([None, None], [Some(x), Some(y), Some(z)]) => PlaceColumns::Direction([x, y, z]),
            _ => return Err(wrong(format!("the header is \"{}\"", excerpt(&header.join(","))))),
        };
        Ok(Self { count: header.len(), place, time, hours })
    }

    fn row(&self, line: usize, fields: &[String]) -> Result<SunRow, SunsError> {
        if fields.len() != self.count {
            let message = format!("{} fields where the header has {}", fields.len(), self.count);
            return Err(SunsError::row(line, message));
        }
        let number = |name: &str, column: usize| {
            let value = fields[column].parse::<f64>().ok().filter(|value| value.is_finite());
            value.ok_or_else(|| refused(line, name, &fields[column], "a finite number"))
        };
        let place = match self.place {
            PlaceColumns::Angles([azimuth, elevation]) => {
                let text = &fields[elevation];
                let (azimuth, elevation) = (number("azimuth", azimuth)?, number("elevation", elevation)?);
                if !(-90.0..=90.0).contains(&elevation) {
                    return Err(refused(line, "elevation", text, "between -90 and 90 degrees"));
                }
                SunPlace::Angles { azimuth, elevation }
            }
            PlaceColumns::Direction([x, y, z]) => {
                SunPlace::Direction([number("x", x)?, number("y", y)?, number("z", z)?])
            }
        };
        let duration = match self.hours {
            Some(column) => duration_of_hours(number("hours", column)?)
                .ok_or_else(|| refused(line, "hours", &fields[column], "between 0 and 1000000"))?,
            None => Duration::ZERO,
        };
        Ok(SunRow { line, place, time: self.time.map(|column| fields[column].clone()), duration })
    }
}

fn refused(line: usize, column: &str, found: &str, expected: &str) -> SunsError {
    SunsError::row(line, format!("{column} is \"{}\", not {expected}", excerpt(found)))
}

/// Hours as a duration, rounded to a nanosecond; `None` below zero and beyond a million.
pub fn duration_of_hours(hours: f64) -> Option<Duration> {
    let duration = Duration::try_from_secs_f64(hours * 3600.0).ok()?;
    (hours <= 1e6).then_some(duration)
}

/// How long each row lasts where nobody says: the step of the times, or one hour where there are none.
fn step_of(rows: &[SunRow]) -> Result<Duration, SunsError> {
    let hour = Duration::from_secs(3600);
    let read: Vec<Option<Clock>> = rows.iter().map(|row| Clock::read(row.time.as_deref()?)).collect();
    if read.iter().all(Option::is_none) {
        return Ok(hour);
    }
    let clock = |(row, clock): (&SunRow, Option<Clock>)| {
        clock.ok_or_else(|| {
            let expected = format!(
                "a time of day (9:30, 2026-06-21T09:30:00) as others are, which tell how long a row lasts; {ADVICE}"
            );
            refused(row.line, "time", row.time.as_deref().unwrap_or_default(), &expected)
        })
    };
    let clocks = rows.iter().zip(read).map(clock).collect::<Result<Vec<_>, _>>()?;
    let line = |row: usize| rows[row].line;
    match clock::step(&clocks) {
        Ok(step) => Ok(step.unwrap_or(hour)),
        Err(StepDefect::Repeated { row, of }) => Err(SunsError::row(
            line(row),
            format!("its time is that of line {} too, so times do not tell how long a row lasts; {ADVICE}", line(of)),
        )),
        Err(StepDefect::Uneven { row, seconds }) => Err(SunsError::row(
            line(row),
            format!(
                "its time breaks the step of {seconds} seconds, so times do not tell how long a row lasts; {ADVICE}"
            ),
        )),
    }
}

const ADVICE: &str = "add a column hours, or say it (--hours-each)";

#[cfg(test)]
mod tests;
