//! The header: which elements follow, how many of each, and what they are made of.

use std::collections::HashSet;

use crate::{
    error::{LoadProblem, excerpt},
    text::cut_line,
};

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// A type of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// Whether a number is one of that type; of floats every one is.
    pub(super) fn holds(self, number: f64) -> bool {
        let (least, most) = match self {
            Self::I8 => (f64::from(i8::MIN), f64::from(i8::MAX)),
            Self::U8 => (0.0, f64::from(u8::MAX)),
            Self::I16 => (f64::from(i16::MIN), f64::from(i16::MAX)),
            Self::U16 => (0.0, f64::from(u16::MAX)),
            Self::I32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
            Self::U32 => (0.0, f64::from(u32::MAX)),
            Self::F32 | Self::F64 => return true,
        };
        number.fract() == 0.0 && (least..=most).contains(&number)
    }

    /// Whether a number that was written out is too large for that type of floats.
    pub(super) fn is_exceeded_by(self, number: f64) -> bool {
        self == Self::F32 && number.is_finite() && (number as f32).is_infinite()
    }
}

/// A column of an element.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    /// The type of a list's length; `None` for a single number.
    pub(super) length: Option<Type>,
    pub(super) item: Type,
}

impl Property {
    /// The type of what every row has at least.
    pub(super) fn first(&self) -> Type {
        self.length.unwrap_or(self.item)
    }

    /// Whether it lists vertices; both names are in use.
    pub(super) fn is_index_list(&self) -> bool {
        matches!(self.name.as_str(), "vertex_indices" | "vertex_index") && self.length.is_some()
    }
}

/// A table of rows.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// The places of single numbers.
    pub(super) fn columns<const N: usize>(&self, names: [&str; N]) -> Result<[usize; N], LoadProblem> {
        let mut columns = [0; N];
        for (column, name) in columns.iter_mut().zip(names) {
            let is_named = |property: &Property| property.name == name && property.length.is_none();
            *column = self.properties.iter().position(is_named).ok_or_else(|| self.lacks(name))?;
        }
        Ok(columns)
    }

    /// The place of the list of vertices.
    pub(super) fn index_list(&self) -> Result<usize, LoadProblem> {
        self.properties.iter().position(Property::is_index_list).ok_or_else(|| self.lacks("list vertex_indices"))
    }

    fn lacks(&self, name: &str) -> LoadProblem {
        LoadProblem::element(format!("element {}", excerpt(&self.name)), format!("it has no property {name}"))
    }
}

/// What the file says of itself.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// In bytes, its last line's end included.
    pub(super) length: usize,
    /// The number of its lines.
    pub(super) lines: usize,
}

/// The longest header that is looked for, bytes.
const LONGEST: usize = 1 << 20;

impl Header {
    pub(super) fn is_text(&self) -> bool {
        self.encoding == Encoding::Text
    }

    /// Reads the header. Its bytes are ASCII but for remarks.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, LoadProblem> {
        if bytes.get(..3) != Some(b"ply") || !bytes.get(3).is_some_and(u8::is_ascii_whitespace) {
            return Err(LoadProblem::line(1, "the first line is not \"ply\""));
        }
        let mut rest = &bytes[..bytes.len().min(LONGEST)];
        let ends_in_cr = has_cr_alone(rest);
        let (mut statements, mut number) = (Statements::default(), 0);
        loop {
            number += 1;
            let Some((line, behind)) = cut(rest, ends_in_cr) else {
                return Err(LoadProblem::line(number, endless(bytes.len() > LONGEST)));
            };
            let length = bytes.len().min(LONGEST) - behind.len();
            rest = behind;
            let text = String::from_utf8_lossy(line);
            let words: Vec<&str> = text.split_whitespace().collect();
            if words == ["end_header"] {
                let Statements { encoding, elements, .. } = statements;
                let encoding = encoding.ok_or_else(|| LoadProblem::line(number, "there is no line \"format\""))?;
                return Ok(Self { encoding, elements, length, lines: number });
            }
            statements
                .take(&words)
                .map_err(|message| LoadProblem::line(number, message.unwrap_or_else(|| unknown(&text))))?;
        }
    }
}

/// Where the first line ends.
fn line_end(bytes: &[u8]) -> Option<usize> {
    bytes.iter().position(|&byte| matches!(byte, b'\n' | b'\r'))
}

/// Whether the first line ends in CR alone. Then all do: an LF behind the last of them is the first byte of the data.
fn has_cr_alone(bytes: &[u8]) -> bool {
    line_end(bytes).is_some_and(|end| bytes[end] == b'\r' && bytes.get(end + 1) != Some(&b'\n'))
}

/// A line and what follows it.
fn cut(bytes: &[u8], ends_in_cr: bool) -> Option<(&[u8], &[u8])> {
    let end = line_end(bytes)?;
    let width = if !ends_in_cr && bytes[end..].starts_with(b"\r\n") { 2 } else { 1 };
    Some((&bytes[..end], &bytes[end + width..]))
}

/// What is wrong with a header without an end.
fn endless(is_too_long: bool) -> String {
    if is_too_long {
        format!("the header is too long: no line \"end_header\" in the first {LONGEST} bytes")
    } else {
        "the file has no line \"end_header\"".to_owned()
    }
}

fn unknown(line: &str) -> String {
    format!("\"{}\" is no line of a header", excerpt(cut_line(line).0))
}

/// What the lines of a header have said so far.
#[derive(Default)]
struct Statements {
    encoding: Option<Encoding>,
    elements: Vec<Element>,
    element_names: HashSet<String>,
    /// Of the last element.
    property_names: HashSet<String>,
}

impl Statements {
    /// Takes one line of the header; an error without words means that it is none.
    fn take(&mut self, words: &[&str]) -> Result<(), Option<String>> {
        match words {
            ["ply"] | [] | ["comment" | "obj_info", ..] => Ok(()),
            ["format", name, version] => self.format(name, version),
            ["element", name, count] => self.element(name, count),
            ["property", what @ .., name] => self.property(property(what, name)?),
            _ => Err(None),
        }
    }

    fn format(&mut self, name: &str, version: &str) -> Result<(), Option<String>> {
        let read = match name {
            "ascii" => Encoding::Text,
            "binary_little_endian" => Encoding::LittleEndian,
            "binary_big_endian" => Encoding::BigEndian,
            _ => return Err(None),
        };
        if version != "1.0" {
            return Err(Some(format!("version {} of the format is not known", excerpt(version))));
        }
        if self.encoding.replace(read).is_some() { Err(Some("\"format\" is there twice".to_owned())) } else { Ok(()) }
    }

    fn element(&mut self, name: &str, count: &str) -> Result<(), Option<String>> {
        let count = count.parse().map_err(|_| Some(format!("\"{}\" is not a count", excerpt(count))))?;
        if !self.element_names.insert(name.to_owned()) {
            return Err(Some(format!("element {} is there twice", excerpt(name))));
        }
        self.property_names.clear();
        self.elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
        Ok(())
    }

    fn property(&mut self, property: Property) -> Result<(), Option<String>> {
        let element = self.elements.last_mut().ok_or_else(|| Some("a property before any element".to_owned()))?;
        if !self.property_names.insert(property.name.clone()) {
            return Err(Some(format!("property {} is there twice", excerpt(&property.name))));
        }
        element.properties.push(property);
        Ok(())
    }
}

fn property(what: &[&str], name: &str) -> Result<Property, Option<String>> {
    let kind = |name: &str| Type::of(name).ok_or_else(|| Some(format!("\"{}\" is no type of numbers", excerpt(name))));
    let name = name.to_owned();
    match what {
        ["list", length, item] => {
            let length = kind(length)?;
            if !length.is_whole() {
                return Err(Some("the length of a list must be a whole number".to_owned()));
            }
            Ok(Property { name, length: Some(length), item: kind(item)? })
        }
        [item] => Ok(Property { name, length: None, item: kind(item)? }),
        _ => Err(None),
    }
}
