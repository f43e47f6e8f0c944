//! NumPy's `.npy` files: points in, answers out.
//!
//! A file is a magic word, a version, a header that is a Python dictionary (`descr`, `fortran_order`, `shape`), and the raw numbers
//! ("NEP 1, A simple file format for NumPy arrays", versions 1.0, 2.0 and 3.0). Read are tables of 3 or 6 columns of 32- or 64-bit
//! floats, in either byte order, by rows or by columns; everything else is refused with a reason. No more is
//! allocated than the file holds.

use std::io::{self, Read, Write};

mod header;
#[cfg(test)]
mod tests;

use header::{Header, Type};

/// Why a `.npy` file is refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NpyError {
    /// The file cannot be read.
    #[error("cannot read it: {0}")]
    Unreadable(io::Error),
    /// The file does not begin as such files do.
    #[error("this is no .npy file")]
    NotNpy,
    /// A version that is not known.
    #[error("version {0}.{1} of the format is not known")]
    Version(u8, u8),
    /// The file ends within its header.
    #[error("the file ends within its header")]
    Truncated,
    /// A header that is not understood.
    #[error("byte {at} of the header: {message}")]
    Header {
        /// Where, from the header's first byte.
        at: usize,
        /// What is wrong.
        message: String,
    },
    /// Numbers of a type that is no float of 32 or 64 bits.
    #[error("the numbers are of type \"{0}\"; expected f4 or f8")]
    Type(String),
    /// A shape that is no table of 3 or 6 columns.
    #[error("the shape is {0:?}; expected (N, 3) or (N, 6)")]
    Shape(Vec<u64>),
    /// More or fewer bytes than the header says.
    #[error("the header tells of {expected} bytes of numbers, the file has {found}")]
    Length {
        /// What the header says.
        expected: u128,
        /// What there is.
        found: u64,
    },
}

/// Points of a `.npy` file, as they came: positions, or positions and normals.
#[derive(Clone, Debug, PartialEq)]
pub enum NpyPoints {
    /// N × 3 numbers of 32 bits.
    PositionsSingle(Vec<[f32; 3]>),
    /// N × 3 numbers of 64 bits.
    PositionsDouble(Vec<[f64; 3]>),
    /// N × 6 numbers of 32 bits.
    NormalsSingle(Vec<[f32; 6]>),
    /// N × 6 numbers of 64 bits.
    NormalsDouble(Vec<[f64; 6]>),
}

impl NpyPoints {
    /// How many points.
    pub fn len(&self) -> usize {
        match self {
            Self::PositionsSingle(rows) => rows.len(),
            Self::PositionsDouble(rows) => rows.len(),
            Self::NormalsSingle(rows) => rows.len(),
            Self::NormalsDouble(rows) => rows.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Reads points. O(bytes).
///
/// # Errors
/// [`NpyError`].
pub fn read_npy_points(mut input: impl Read) -> Result<NpyPoints, NpyError> {
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes).map_err(NpyError::Unreadable)?;
    let (header, numbers) = Header::read(&bytes)?;
    let shape = || NpyError::Shape(header.shape.clone());
    let &[rows, columns] = header.shape.as_slice() else { return Err(shape()) };
    let size = header.kind.size();
    let expected = (u128::from(rows) * u128::from(columns)).saturating_mul(size as u128);
    let found = numbers.len() as u64;
    let layout = |columns| Layout { rows: found as usize / (columns * size), columns, kind: &header };
    match (columns, header.kind) {
        (3 | 6, _) if expected != u128::from(found) => Err(NpyError::Length { expected, found }),
        (3, Type::Single { .. }) => Ok(NpyPoints::PositionsSingle(layout(3).table(numbers, f32::from_le_bytes))),
        (6, Type::Single { .. }) => Ok(NpyPoints::NormalsSingle(layout(6).table(numbers, f32::from_le_bytes))),
        (3, Type::Double { .. }) => Ok(NpyPoints::PositionsDouble(layout(3).table(numbers, f64::from_le_bytes))),
        (6, Type::Double { .. }) => Ok(NpyPoints::NormalsDouble(layout(6).table(numbers, f64::from_le_bytes))),
        _ => Err(shape()),
    }
}

/// Where the numbers of a table are.
struct Layout<'a> {
    rows: usize,
    columns: usize,
    kind: &'a Header,
}

impl Layout<'_> {
    /// The rows; `bytes` holds just as many numbers as the table has.
    fn table<T: Copy + Default, const SIZE: usize, const COLUMNS: usize>(
        &self,
        bytes: &[u8],
        from_little_endian: impl Fn([u8; SIZE]) -> T,
    ) -> Vec<[T; COLUMNS]> {
        let (numbers, _) = bytes.as_chunks::<SIZE>();
        let is_big_endian = self.kind.kind.is_big_endian();
        let number = |place: usize| {
            let mut bytes = numbers[place];
            if is_big_endian {
                bytes.reverse();
            }
            from_little_endian(bytes)
        };
        let (row_step, column_step) = if self.kind.by_columns { (1, self.rows) } else { (self.columns, 1) };
        let row = |row: usize| std::array::from_fn(|column| number(row * row_step + column * column_step));
        (0..self.rows).map(row).collect()
    }
}

/// Writes a table of bytes, row by row: the header of version 1.0, as NumPy pads it, and `values`.
///
/// # Errors
/// What the system says, or values that do not fill rows of `columns`.
pub fn write_npy_bytes(columns: usize, values: &[u8], out: &mut impl Write) -> io::Result<()> {
    let rows = values.len().checked_div(columns).unwrap_or(0);
    if rows * columns != values.len() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the rows are not all full"));
    }
    let text = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    // Magic, version, length, text, spaces and a line's end are a multiple of 64 bytes.
    let length = (10 + text.len() + 1).next_multiple_of(64) - 10;
    out.write_all(header::MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&(length as u16).to_le_bytes())?;
    writeln!(out, "{text:width$}", width = length - 1)?;
    out.write_all(values)
}
