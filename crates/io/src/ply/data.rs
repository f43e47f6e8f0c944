//! The rows behind the header.

use super::header::{Element, Encoding, Header, Type};
use crate::{
    error::{LoadProblem, excerpt},
    tokens::Tokens,
};

/// The numbers of a row, property by property.
#[derive(Debug, Default)]
pub(super) struct Row {
    numbers: Vec<f64>,
    /// Where the numbers of each property end.
    ends: Vec<usize>,
}

/// What of an element's rows is not as the format has it, and read all the same.
#[derive(Debug, Default)]
pub(super) struct Oddities {
    /// How many words were too large for their type, whole numbers written as floats (`3.0`), or of unused properties no number of their type.
    pub(super) numbers: usize,
    /// How many rows of text were not just a line.
    pub(super) lines: usize,
}

impl Row {
    /// The numbers of a list.
    pub(super) fn list(&self, property: usize) -> &[f64] {
        let start = if property == 0 { 0 } else { self.ends[property - 1] };
        &self.numbers[start..self.ends[property]]
    }

    /// A single number.
    pub(super) fn number(&self, property: usize) -> f64 {
        self.numbers[self.ends[property] - 1]
    }
}

/// Where numbers come from.
pub(super) enum Source<'a> {
    Text(Tokens<'a>),
    Binary { bytes: &'a [u8], is_big_endian: bool },
}

/// Why a number is not there.
enum Fault {
    Ended,
    Wrong(String),
}

impl<'a> Source<'a> {
    /// The data of a file, as bytes and (if it is text) as text.
    pub(super) fn new(header: &Header, bytes: &'a [u8], text: &'a str) -> Self {
        match header.encoding {
            Encoding::Text => Self::Text(Tokens::new(text, header.lines + 1)),
            Encoding::LittleEndian => Self::Binary { bytes, is_big_endian: false },
            Encoding::BigEndian => Self::Binary { bytes, is_big_endian: true },
        }
    }

    /// Whether anything is left.
    pub(super) fn has_more(&mut self) -> bool {
        match self {
            Self::Text(tokens) => tokens.next().is_some(),
            Self::Binary { bytes, .. } => !bytes.is_empty(),
        }
    }

    /// Whether the rest of the file can hold that many rows, before any is read.
    pub(super) fn check_room(&self, element: &Element) -> Result<(), LoadProblem> {
        let firsts = element.properties.iter().map(|property| property.first());
        let (least, room) = match self {
            // A digit and a space, or the end of the file.
            Self::Text(tokens) => (2 * firsts.count(), tokens.remaining() + 1),
            Self::Binary { bytes, .. } => (firsts.map(Type::size).sum(), bytes.len()),
        };
        if u128::from(element.count) * least as u128 <= room as u128 {
            return Ok(());
        }
        let message = format!("the header tells of {} rows, which do not fit into the rest of the file", element.count);
        Err(LoadProblem::element(format!("element {}", excerpt(&element.name)), message))
    }

    /// Reads all rows of an element. Properties other than those `used` may hold anything.
    pub(super) fn rows(
        &mut self,
        element: &Element,
        used: &[usize],
        mut take: impl FnMut(u64, &Row) -> Result<(), LoadProblem>,
    ) -> Result<Oddities, LoadProblem> {
        let mut oddities = Oddities::default();
        if element.properties.is_empty() {
            return Ok(oddities);
        }
        let mut row = Row::default();
        for number in 0..element.count {
            let line = self.line_of_next();
            let odd = self.row(element, used, &mut row).map_err(|fault| self.problem(element, number, fault))?;
            oddities.numbers += odd;
            oddities.lines += usize::from(line.is_some_and(|line| !self.ends_line(line)));
            take(number, &row)?;
        }
        Ok(oddities)
    }

    /// The line on which the next number of a text stands.
    fn line_of_next(&mut self) -> Option<usize> {
        match self {
            Self::Text(tokens) => {
                tokens.skip_space();
                Some(tokens.line())
            }
            Self::Binary { .. } => None,
        }
    }

    /// Whether the last number is the last one of that line.
    fn ends_line(&self, line: usize) -> bool {
        match self {
            Self::Text(tokens) => tokens.line() == line && !tokens.has_on_line(|_| true),
            Self::Binary { .. } => true,
        }
    }

    /// Reads a row; answers how many numbers are none of their type.
    fn row(&mut self, element: &Element, used: &[usize], row: &mut Row) -> Result<usize, Fault> {
        let mut odd = 0;
        row.numbers.clear();
        row.ends.clear();
        for (place, property) in element.properties.iter().enumerate() {
            let length = match property.length {
                Some(kind) => self.length(kind, &mut odd)?,
                None => 1,
            };
            for _ in 0..length {
                let number = match self.number(property.item, &mut odd) {
                    Err(Fault::Wrong(_)) if !used.contains(&place) => {
                        odd += 1;
                        f64::NAN
                    }
                    number => number?,
                };
                odd += usize::from(property.item.is_exceeded_by(number));
                row.numbers.push(number);
            }
            row.ends.push(row.numbers.len());
        }
        Ok(odd)
    }

    /// The length of a list; what does not fit into the file ends the reading soon enough.
    fn length(&mut self, kind: Type, odd: &mut usize) -> Result<u64, Fault> {
        let length = self.number(kind, odd)?;
        if length < 0.0 { Err(Fault::Wrong(format!("a list of {length} numbers"))) } else { Ok(length as u64) }
    }

    /// A number of a type; one more is `odd` where a whole number is written as a float, which others do not read.
    fn number(&mut self, kind: Type, odd: &mut usize) -> Result<f64, Fault> {
        match self {
            Self::Text(tokens) => {
                let word = tokens.next().ok_or(Fault::Ended)?;
                let number = word.parse().ok().filter(|&number| kind.holds(number));
                let is_float = kind.is_whole() && number.is_some() && word.contains(['.', 'e', 'E']);
                *odd += usize::from(is_float);
                let expected = if kind.is_whole() { "whole number of its type" } else { "number" };
                number.ok_or_else(|| Fault::Wrong(format!("\"{}\" is not a {expected}", excerpt(word))))
            }
            Self::Binary { bytes, is_big_endian } => {
                let (number, rest) = bytes.split_at_checked(kind.size()).ok_or(Fault::Ended)?;
                *bytes = rest;
                Ok(decode(number, kind, *is_big_endian))
            }
        }
    }

    fn problem(&self, element: &Element, row: u64, fault: Fault) -> LoadProblem {
        let place = format!("{} {row}", excerpt(&element.name));
        let message = match fault {
            Fault::Ended => "the file ends here".to_owned(),
            Fault::Wrong(message) => message,
        };
        match self {
            Self::Text(tokens) => LoadProblem::line(tokens.line(), format!("{place}: {message}")),
            Self::Binary { .. } => LoadProblem::element(place, message),
        }
    }
}

/// A number of just that many bytes; every type fits into f64.
fn decode(bytes: &[u8], kind: Type, is_big_endian: bool) -> f64 {
    let append = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
    let bits = if is_big_endian { bytes.iter().fold(0, append) } else { bytes.iter().rev().fold(0, append) };
    match kind {
        Type::U8 | Type::U16 | Type::U32 => bits as f64,
        Type::I8 => f64::from(bits as u8 as i8),
        Type::I16 => f64::from(bits as u16 as i16),
        Type::I32 => f64::from(bits as u32 as i32),
        Type::F32 => f64::from(f32::from_bits(bits as u32)),
        Type::F64 => f64::from_bits(bits),
    }
}
