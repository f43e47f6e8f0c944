//! The header: a Python dictionary of three entries.

use super::NpyError;
use crate::error::excerpt;

/// The first bytes of every file.
pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

/// NumPy has no more axes.
const MOST_AXES: usize = 64;

/// What a file says of its numbers.
pub(super) struct Header {
    pub(super) kind: Type,
    /// Column by column ("Fortran order").
    pub(super) by_columns: bool,
    pub(super) shape: Vec<u64>,
}

/// A type of floats.
#[derive(Clone, Copy)]
pub(super) enum Type {
    Single { is_big_endian: bool },
    Double { is_big_endian: bool },
}

impl Type {
    /// Bytes of a number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::Single { .. } => 4,
            Self::Double { .. } => 8,
        }
    }

    pub(super) fn is_big_endian(self) -> bool {
        match self {
            Self::Single { is_big_endian } | Self::Double { is_big_endian } => is_big_endian,
        }
    }

    fn parse(text: &str) -> Result<Self, NpyError> {
        let is_big_endian = match text.get(..1) {
            Some("<") => false,
            Some(">") => true,
            // "=" is the order of the machine that reads.
            Some("=") => cfg!(target_endian = "big"),
            _ => return Err(NpyError::Type(excerpt(text).into_owned())),
        };
        match &text[1..] {
            "f4" => Ok(Self::Single { is_big_endian }),
            "f8" => Ok(Self::Double { is_big_endian }),
            _ => Err(NpyError::Type(excerpt(text).into_owned())),
        }
    }
}

impl Header {
    /// The header, and the bytes behind it.
    pub(super) fn read(bytes: &[u8]) -> Result<(Self, &[u8]), NpyError> {
        let rest = bytes.strip_prefix(MAGIC).ok_or(NpyError::NotNpy)?;
        let (&[major, minor], rest) = rest.split_first_chunk::<2>().ok_or(NpyError::Truncated)?;
        let (length, rest) = match (major, minor) {
            (1, 0) => {
                let (length, rest) = rest.split_first_chunk::<2>().ok_or(NpyError::Truncated)?;
                (usize::from(u16::from_le_bytes(*length)), rest)
            }
            (2 | 3, 0) => {
                let (length, rest) = rest.split_first_chunk::<4>().ok_or(NpyError::Truncated)?;
                (u32::from_le_bytes(*length) as usize, rest)
            }
            _ => return Err(NpyError::Version(major, minor)),
        };
        let (text, numbers) = rest.split_at_checked(length).ok_or(NpyError::Truncated)?;
        Ok((Parser { text, at: 0 }.dictionary()?, numbers))
    }
}

/// Reads the dictionary, byte by byte.
struct Parser<'a> {
    text: &'a [u8],
    at: usize,
}

impl Parser<'_> {
    /// `{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }`, the entries in any order.
    fn dictionary(&mut self) -> Result<Header, NpyError> {
        let (mut kind, mut by_columns, mut shape) = (None, None, None);
        self.expect(b'{')?;
        while !self.take(b'}') {
            let key = self.string()?;
            self.expect(b':')?;
            let is_known_twice = match key.as_str() {
                "descr" => kind.replace(Type::parse(&self.string()?)?).is_some(),
                "fortran_order" => by_columns.replace(self.truth()?).is_some(),
                "shape" => shape.replace(self.tuple()?).is_some(),
                _ => return Err(self.wrong(format!("the entry \"{}\" is not known", excerpt(&key)))),
            };
            if is_known_twice {
                return Err(self.wrong(format!("\"{key}\" is there twice")));
            }
            if !self.take(b',') {
                self.expect(b'}')?;
                break;
            }
        }
        self.skip_spaces();
        if self.at < self.text.len() {
            return Err(self.wrong("something follows the dictionary".to_owned()));
        }
        match (kind, by_columns, shape) {
            (Some(kind), Some(by_columns), Some(shape)) => Ok(Header { kind, by_columns, shape }),
            _ => Err(self.wrong("descr, fortran_order and shape are not all there".to_owned())),
        }
    }

    fn string(&mut self) -> Result<String, NpyError> {
        self.skip_spaces();
        let quote = self.text.get(self.at).copied().filter(|byte| matches!(byte, b'\'' | b'"'));
        let quote = quote.ok_or_else(|| self.wrong("expected a string in quotes".to_owned()))?;
        let rest = &self.text[self.at + 1..];
        let length = rest.iter().position(|&byte| byte == quote);
        let length = length.ok_or_else(|| self.wrong("the string does not end".to_owned()))?;
        let text = String::from_utf8_lossy(&rest[..length]).into_owned();
        self.at += length + 2;
        Ok(text)
    }

    fn truth(&mut self) -> Result<bool, NpyError> {
        self.skip_spaces();
        for (word, value) in [("True", true), ("False", false)] {
            if self.text[self.at..].starts_with(word.as_bytes()) {
                self.at += word.len();
                return Ok(value);
            }
        }
        Err(self.wrong("expected True or False".to_owned()))
    }

    /// `()`, `(2,)`, `(2, 3)` and so on; Python 2 wrote `2L`.
    fn tuple(&mut self) -> Result<Vec<u64>, NpyError> {
        let mut numbers = Vec::new();
        self.expect(b'(')?;
        while !self.take(b')') {
            self.skip_spaces();
            if numbers.len() == MOST_AXES {
                return Err(self.wrong(format!("more than {MOST_AXES} axes")));
            }
            let digits = self.text[self.at..].iter().take_while(|byte| byte.is_ascii_digit()).count();
            let text = String::from_utf8_lossy(&self.text[self.at..self.at + digits]).into_owned();
            numbers.push(text.parse().map_err(|_| self.wrong("expected a number of 64 bits".to_owned()))?);
            self.at += digits;
            self.take(b'L');
            if !self.take(b',') {
                self.expect(b')')?;
                break;
            }
        }
        Ok(numbers)
    }

    fn skip_spaces(&mut self) {
        self.at += self.text[self.at..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
    }

    /// Whether this byte comes next; it is then passed.
    fn take(&mut self, byte: u8) -> bool {
        self.skip_spaces();
        let is_next = self.text.get(self.at) == Some(&byte);
        self.at += usize::from(is_next);
        is_next
    }

    fn expect(&mut self, byte: u8) -> Result<(), NpyError> {
        if self.take(byte) { Ok(()) } else { Err(self.wrong(format!("expected \"{}\"", byte as char))) }
    }

    fn wrong(&self, message: String) -> NpyError {
        NpyError::Header { at: self.at, message }
    }
}
