//! Polygons with numbers on them as a VTK unstructured grid (Kitware, "VTK XML file formats", `.vtu`), for ParaView.
//!
//! ```text
//! <VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
//!   <UnstructuredGrid>
//!     <FieldData> arrays about the whole </FieldData>
//!     <Piece> <Points> f64 </Points> <Cells> connectivity, offsets, types </Cells> <CellData> ... </CellData> </Piece>
//! ```
//!
//! Every array is inline base64 of its length in bytes (a 64-bit integer) and its values, uncompressed: valid XML, no
//! rounding, one pass, no memory beside the grid itself.

use std::io::{self, Write};

use base64::{engine::general_purpose::STANDARD, write::EncoderWriter};

/// Polygons that share points, and arrays of numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonGrid {
    /// World coordinates, metres.
    pub points: Vec<[f64; 3]>,
    /// The corners of all polygons one after the other, indices of points.
    pub corners: Vec<u32>,
    /// For each polygon, where its corners end in `corners`; it begins where the one before ends.
    pub ends: Vec<u32>,
    /// Arrays with one value a polygon.
    pub cell_data: Vec<GridArray>,
    /// Arrays of any length, about the whole.
    pub field_data: Vec<GridArray>,
}

/// A named array.
#[derive(Clone, Debug, PartialEq)]
pub struct GridArray {
    /// The name; unique among the arrays of its kind.
    pub name: String,
    /// Its values.
    pub values: GridValues,
}

impl GridArray {
    /// A named array.
    pub fn new(name: impl Into<String>, values: GridValues) -> Self {
        Self { name: name.into(), values }
    }
}

/// The values of an array.
#[derive(Clone, Debug, PartialEq)]
pub enum GridValues {
    /// Text in UTF-8 (not every reader takes arrays of strings), or colours, which is what VTK takes bytes for.
    U8(Vec<u8>),
    /// Small whole numbers.
    I8(Vec<i8>),
    /// Whole numbers.
    U32(Vec<u32>),
    /// Floats, kept to the last bit.
    F64(Vec<f64>),
}

impl GridValues {
    fn len(&self) -> usize {
        match self {
            Self::U8(values) => values.len(),
            Self::I8(values) => values.len(),
            Self::U32(values) => values.len(),
            Self::F64(values) => values.len(),
        }
    }
}

/// The numbers that VTK gives to kinds of cells.
const TRIANGLE: u8 = 5;
const POLYGON: u8 = 7;
const QUAD: u8 = 9;

/// Writes the grid. O(its size).
///
/// # Errors
/// What the system says; `InvalidInput` where the parts of the grid do not fit each other.
pub fn write_vtu(grid: &PolygonGrid, out: &mut impl Write) -> io::Result<()> {
    check(grid)?;
    out.write_all(b"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n")?;
    let kind = "type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"";
    writeln!(out, "<VTKFile {kind}>\n<UnstructuredGrid>\n<FieldData>")?;
    grid.field_data.iter().try_for_each(|array| write_array(array, out))?;
    writeln!(out, "</FieldData>")?;
    writeln!(out, "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">", grid.points.len(), grid.ends.len())?;
    writeln!(out, "<Points>")?;
    let points = grid.points.iter().map(|point| bytes_of_point(*point));
    write_values(&Head { kind: "Float64", name: "Points", components: 3 }, points, out)?;
    writeln!(out, "</Points>\n<Cells>")?;
    let corners = grid.corners.iter().map(|corner| corner.to_le_bytes());
    write_values(&Head { kind: "UInt32", name: "connectivity", components: 1 }, corners, out)?;
    let ends = grid.ends.iter().map(|end| end.to_le_bytes());
    write_values(&Head { kind: "UInt32", name: "offsets", components: 1 }, ends, out)?;
    let kinds = lengths(grid).map(|corners| [kind_of(corners)]);
    write_values(&Head { kind: "UInt8", name: "types", components: 1 }, kinds, out)?;
    writeln!(out, "</Cells>\n<CellData>")?;
    grid.cell_data.iter().try_for_each(|array| write_array(array, out))?;
    writeln!(out, "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>")
}

fn bytes_of_point(point: [f64; 3]) -> [u8; 24] {
    let mut bytes = [0; 24];
    for (place, coordinate) in bytes.chunks_exact_mut(8).zip(point) {
        place.copy_from_slice(&coordinate.to_le_bytes());
    }
    bytes
}

/// The numbers of corners of all polygons.
fn lengths(grid: &PolygonGrid) -> impl ExactSizeIterator<Item = u32> {
    let begins = |polygon: usize| if polygon == 0 { 0 } else { grid.ends[polygon - 1] };
    (0..grid.ends.len()).map(move |polygon| grid.ends[polygon].saturating_sub(begins(polygon)))
}

fn kind_of(corners: u32) -> u8 {
    match corners {
        3 => TRIANGLE,
        4 => QUAD,
        _ => POLYGON,
    }
}

fn check(grid: &PolygonGrid) -> io::Result<()> {
    let refuse = |message: String| Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    if let Some(polygon) = lengths(grid).position(|corners| corners < 3) {
        return refuse(format!("polygon {polygon} has less than three corners"));
    }
    let end = grid.ends.last().map_or(0, |&end| end as usize);
    if end != grid.corners.len() {
        return refuse(format!("the polygons end at corner {end} of {}", grid.corners.len()));
    }
    if let Some(corner) = grid.corners.iter().find(|&&corner| corner as usize >= grid.points.len()) {
        return refuse(format!("point {corner} of {}", grid.points.len()));
    }
    match grid.cell_data.iter().find(|array| array.values.len() != grid.ends.len()) {
        Some(array) => {
            refuse(format!("{}: {} values for {} polygons", array.name, array.values.len(), grid.ends.len()))
        }
        None => Ok(()),
    }
}

fn write_array(array: &GridArray, out: &mut impl Write) -> io::Result<()> {
    let head = |kind| Head { kind, name: &array.name, components: 1 };
    match &array.values {
        GridValues::U8(values) => write_values(&head("UInt8"), values.iter().map(|&value| [value]), out),
        GridValues::I8(values) => write_values(&head("Int8"), values.iter().map(|value| value.to_le_bytes()), out),
        GridValues::U32(values) => write_values(&head("UInt32"), values.iter().map(|value| value.to_le_bytes()), out),
        GridValues::F64(values) => write_values(&head("Float64"), values.iter().map(|value| value.to_le_bytes()), out),
    }
}

/// What stands before the values of an array.
struct Head<'a> {
    kind: &'a str,
    name: &'a str,
    components: usize,
}

/// An array of tuples, `N` bytes each.
fn write_values<const N: usize>(
    head: &Head,
    tuples: impl ExactSizeIterator<Item = [u8; N]>,
    out: &mut impl Write,
) -> io::Result<()> {
    let (kind, name, components, count) = (head.kind, escaped(head.name), head.components, tuples.len());
    write!(out, "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"")?;
    write!(out, " NumberOfTuples=\"{count}\" format=\"binary\">")?;
    let mut encoder = EncoderWriter::new(&mut *out, &STANDARD);
    encoder.write_all(&((count * N) as u64).to_le_bytes())?;
    for tuple in tuples {
        encoder.write_all(&tuple)?;
    }
    encoder.finish()?;
    drop(encoder);
    writeln!(out, "</DataArray>")
}

/// Text as the value of an XML attribute. Characters that XML 1.0 cannot hold at all become U+FFFD.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\t' | '\n' | '\r' => escaped.push_str(&format!("&#{};", u32::from(character))),
            '\0'..' ' | '\u{fffe}' | '\u{ffff}' => escaped.push('\u{fffd}'),
            _ => escaped.push(character),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;
    use base64::Engine;

    /// A square and a triangle beside it.
    fn house() -> PolygonGrid {
        PolygonGrid {
            points: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.1], [0.0, 1.0, 0.0], [0.5, 1e-300, 2.0]],
            corners: vec![0, 1, 2, 3, 3, 2, 4],
            ends: vec![4, 7],
            cell_data: vec![GridArray::new("a & \"b\"\u{1}", GridValues::F64(vec![0.1, -0.0]))],
            field_data: vec![GridArray::new("names", GridValues::U8("dach\nwand".into()))],
        }
    }

    fn text(grid: &PolygonGrid) -> String {
        let mut bytes = Vec::new();
        write_vtu(grid, &mut bytes).expect("written");
        String::from_utf8(bytes).expect("text")
    }

    /// The bytes of the array with that name, and the type it says.
    fn array(text: &str, name: &str) -> (String, Vec<u8>) {
        let at = text.find(&format!("Name=\"{name}\"")).unwrap_or_else(|| panic!("{name} in {text}"));
        let kind = text[..at].rsplit("type=\"").next().and_then(|rest| rest.split('"').next()).expect("a type");
        let content = text[at..].split_once('>').and_then(|(_, rest)| rest.split_once('<')).expect("an element").0;
        let bytes = base64::engine::general_purpose::STANDARD.decode(content).expect("base64");
        let (length, values) = bytes.split_at(8);
        assert_eq!(u64::from_le_bytes(length.try_into().expect("8 bytes")), values.len() as u64, "{name}");
        (kind.to_owned(), values.to_vec())
    }

    fn floats(bytes: &[u8]) -> Vec<f64> {
        bytes.chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().expect("8 bytes"))).collect()
    }

    #[test]
    fn arrays_come_back_to_the_last_bit() {
        let (grid, text) = (house(), text(&house()));
        assert!(text.contains("<Piece NumberOfPoints=\"5\" NumberOfCells=\"2\">"), "{text}");
        let (kind, points) = array(&text, "Points");
        assert_eq!((kind.as_str(), floats(&points)), ("Float64", grid.points.as_flattened().to_vec()));
        let whole = |name: &str| -> Vec<u32> {
            let (kind, bytes) = array(&text, name);
            assert_eq!(kind, "UInt32");
            bytes.chunks_exact(4).map(|bytes| u32::from_le_bytes(bytes.try_into().expect("4 bytes"))).collect()
        };
        assert_eq!((whole("connectivity"), whole("offsets")), (grid.corners, grid.ends));
        assert_eq!(array(&text, "types").1, [QUAD, TRIANGLE]);
        let values = floats(&array(&text, "a &amp; &quot;b&quot;\u{fffd}").1);
        assert_eq!(values.iter().map(|value| value.to_bits()).collect::<Vec<_>>(), [0.1f64.to_bits(), 1 << 63]);
        assert_eq!(array(&text, "names").1, b"dach\nwand");
    }

    #[test]
    fn an_empty_grid_is_a_file_too() {
        assert!(text(&PolygonGrid::default()).contains("NumberOfCells=\"0\""));
    }

    #[test]
    fn grids_that_do_not_fit_are_refused() {
        type Change = fn(&mut PolygonGrid);
        let changes: [(Change, &str); 5] = [
            (|grid| grid.ends[0] = 2, "polygon 0 has less than three corners"),
            (|grid| grid.ends[1] = 3, "polygon 1 has less than three corners"),
            (|grid| grid.corners.truncate(6), "end at corner 7 of 6"),
            (|grid| grid.corners[3] = 5, "point 5 of 5"),
            (|grid| grid.cell_data[0].values = GridValues::U32(vec![1]), "1 values for 2 polygons"),
        ];
        for (change, expected) in changes {
            let mut grid = house();
            change(&mut grid);
            let error = write_vtu(&grid, &mut Vec::new()).expect_err("a defect");
            assert!(error.to_string().contains(expected), "{error}");
        }
    }
}
