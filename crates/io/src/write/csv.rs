//! Tables as CSV, and the tables of points that queries start from.
//!
//! A point table has one of three headers: `x,y,z`; `x,y,z,nx,ny,nz`; `object,face,u,v`. Its rows are kept as they were
//! written, so that an answer can repeat them unchanged.

use std::io::{self, Read, Write};

use crate::error::excerpt;

/// A header and its rows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// Column names.
    pub header: Vec<String>,
    /// One string a column.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Writes the table; fields are quoted where they need it.
    ///
    /// # Errors
    /// What the system says, or a row that is not as long as the header.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        write_rows(&self.header, &self.rows, out)
    }
}

/// Writes a header and rows as CSV, one after the other: for tables that are too long to be held.
///
/// # Errors
/// What the system says, or a row that is not as long as the header.
pub fn write_rows<R>(
    header: &[impl AsRef<[u8]>],
    rows: impl IntoIterator<Item = R>,
    out: &mut impl Write,
) -> io::Result<()>
where
    R: IntoIterator<Item: AsRef<[u8]>>,
{
    let mut writer = csv::Writer::from_writer(out);
    writer.write_record(header)?;
    for row in rows {
        writer.write_record(row)?;
    }
    writer.flush()
}

/// What the columns of a point table mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointColumns {
    /// `x,y,z`
    Position,
    /// `x,y,z,nx,ny,nz`
    PositionAndNormal,
    /// `object,face,u,v`
    Surface,
}

impl PointColumns {
    const ALL: [Self; 3] = [Self::Position, Self::PositionAndNormal, Self::Surface];

    /// The header.
    pub fn names(self) -> &'static [&'static str] {
        match self {
            Self::Position => &["x", "y", "z"],
            Self::PositionAndNormal => &["x", "y", "z", "nx", "ny", "nz"],
            Self::Surface => &["object", "face", "u", "v"],
        }
    }
}

/// What a row of a point table says.
#[derive(Clone, Debug, PartialEq)]
pub enum PointRow {
    /// World coordinates, metres.
    Position([f64; 3]),
    /// World coordinates, metres, and a normal of any length.
    PositionAndNormal([f64; 3], [f64; 3]),
    /// (u, v) of a face of a named object.
    Surface {
        /// The object's name.
        object: String,
        /// The face's number.
        face: usize,
        /// First parameter.
        u: f64,
        /// Second parameter.
        v: f64,
    },
}

/// A point table: what its rows say and how they were written.
#[derive(Clone, Debug, PartialEq)]
pub struct PointTable {
    /// What the columns mean.
    pub columns: PointColumns,
    /// The rows as numbers.
    pub points: Vec<PointRow>,
    /// The rows as written.
    pub text: Table,
    /// The line each row begins on; the header is usually line 1.
    pub lines: Vec<u64>,
}

/// Why a point table is refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PointsError {
    /// The file cannot be read.
    #[error("cannot read it: {0}")]
    Unreadable(io::Error),
    /// The header is none of the three.
    #[error("line 1: the header is \"{found}\"; expected x,y,z or x,y,z,nx,ny,nz or object,face,u,v")]
    Header {
        /// What stands there.
        found: String,
    },
    /// A row that is no row: fields missing, text that is not UTF-8.
    #[error("line {line}: {message}")]
    Row {
        /// Line of the file.
        line: u64,
        /// What is wrong.
        message: String,
    },
    /// A field that is not the number it should be.
    #[error("line {line}: {column} is \"{found}\", not {expected}")]
    Field {
        /// Line of the file.
        line: u64,
        /// The column's name.
        column: &'static str,
        /// What stands there.
        found: String,
        /// What should.
        expected: &'static str,
    },
}

/// Reads a table of points. Spaces around fields do not count; blank lines neither.
///
/// # Errors
/// The first [`PointsError`].
pub fn read_points(mut input: impl Read) -> Result<PointTable, PointsError> {
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes).map_err(PointsError::Unreadable)?;
    let mut options = csv::ReaderBuilder::new();
    let mut reader = options.has_headers(false).flexible(true).trim(csv::Trim::All).from_reader(bytes.as_slice());
    let mut records = reader.records();
    let first = records.next().transpose().map_err(row_error)?.unwrap_or_default();
    let header: Vec<String> = first.iter().map(|name| name.trim_start_matches('\u{feff}').to_owned()).collect();
    let columns = PointColumns::ALL.into_iter().find(|columns| columns.names() == header);
    let columns = columns.ok_or_else(|| PointsError::Header { found: excerpt(&header.join(",")).into_owned() })?;
    let mut table =
        PointTable { columns, points: Vec::new(), text: Table { header, rows: Vec::new() }, lines: Vec::new() };
    for record in records {
        let record = record.map_err(row_error)?;
        let line = record.position().map_or(0, |position| first_line(&bytes, position));
        let fields: Vec<String> = record.iter().map(str::to_owned).collect();
        table.points.push(parse_row(columns, &fields, line)?);
        table.text.rows.push(fields);
        table.lines.push(line);
    }
    Ok(table)
}

/// The line a record stands on; its position may lie before blank lines that were passed over.
fn first_line(bytes: &[u8], position: &csv::Position) -> u64 {
    let start = (position.byte() as usize).min(bytes.len());
    let blank = bytes[start..].iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
    position.line() + blank.filter(|&&byte| byte == b'\n').count() as u64
}

fn row_error(error: csv::Error) -> PointsError {
    let line = error.position().map_or(1, csv::Position::line);
    match error.into_kind() {
        csv::ErrorKind::Io(error) => PointsError::Unreadable(error),
        csv::ErrorKind::Utf8 { .. } => PointsError::Row { line, message: "the text is not UTF-8".to_owned() },
        kind => PointsError::Row { line, message: format!("{kind:?}") },
    }
}

fn parse_row(columns: PointColumns, fields: &[String], line: u64) -> Result<PointRow, PointsError> {
    let names = columns.names();
    if fields.len() != names.len() {
        let message = format!("{} fields where the header has {}", fields.len(), names.len());
        return Err(PointsError::Row { line, message });
    }
    let wrong = |column: usize, expected| PointsError::Field {
        line,
        column: names[column],
        found: excerpt(&fields[column]).into_owned(),
        expected,
    };
    let number = |column: usize| {
        let value = fields[column].parse::<f64>().ok().filter(|value| value.is_finite());
        value.ok_or_else(|| wrong(column, "a finite number"))
    };
    let triple = |from: usize| Ok([number(from)?, number(from + 1)?, number(from + 2)?]);
    match columns {
        PointColumns::Position => Ok(PointRow::Position(triple(0)?)),
        PointColumns::PositionAndNormal => Ok(PointRow::PositionAndNormal(triple(0)?, triple(3)?)),
        PointColumns::Surface => {
            let face = fields[1].parse().map_err(|_| wrong(1, "the number of a face"))?;
            Ok(PointRow::Surface { object: fields[0].clone(), face, u: number(2)?, v: number(3)? })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_quotes_what_needs_it() {
        let table =
            Table { header: vec!["object".into(), "area".into()], rows: vec![vec!["a, \"b\"".into(), "1.5".into()]] };
        let mut bytes = Vec::new();
        table.write(&mut bytes).expect("written");
        assert_eq!(String::from_utf8(bytes).expect("text"), "object,area\n\"a, \"\"b\"\"\",1.5\n");
    }

    #[test]
    fn the_three_kinds_of_points() {
        let free = read_points("x,y,z\r\n1, -2.50 ,3e2\r\n\r\n".as_bytes()).expect("points");
        assert_eq!(free.points, [PointRow::Position([1.0, -2.5, 300.0])]);
        assert_eq!(free.text.rows, [["1", "-2.50", "3e2"]]);
        let oriented = read_points("x,y,z,nx,ny,nz\n1,2,3,0,1,0\n".as_bytes()).expect("points");
        assert_eq!(oriented.points, [PointRow::PositionAndNormal([1.0, 2.0, 3.0], [0.0, 1.0, 0.0])]);
        let surface = read_points("object,face,u,v\n\"a,b\",3,0.5,0\n".as_bytes()).expect("points");
        assert_eq!(surface.points, [PointRow::Surface { object: "a,b".into(), face: 3, u: 0.5, v: 0.0 }]);
        assert_eq!(surface.lines, [2]);
    }

    #[test]
    fn errors_name_the_line() {
        for (text, expected) in [
            ("", "header is \"\""),
            ("a,b\n", "header is \"a,b\""),
            (&"x".repeat(9000), "xxx...\"; expected"),
            (&format!("x,y,z\n1,2,{}", "x".repeat(9000)), "xxx...\", not"),
            ("x,y,z\n1,2,3\n1,2\n", "line 3: 2 fields"),
            ("x,y,z\n\n1,two,3\n", "line 3: y is \"two\""),
            ("x,y,z\n1,2,inf\n", "line 2: z is \"inf\""),
            ("object,face,u,v\nroof,-1,0,0\n", "line 2: face is \"-1\""),
        ] {
            let message = read_points(text.as_bytes()).expect_err("a defect").to_string();
            assert!(message.contains(expected), "{message} should contain {expected}");
        }
        assert!(matches!(read_points(&b"x,y,z\n\xff,1,2\n"[..]), Err(PointsError::Row { line: 2, .. })));
    }
}
