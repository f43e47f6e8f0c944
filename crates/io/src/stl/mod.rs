//! STL ("StereoLithography Interface Specification", 3D Systems, 1988), as text or binary.
//!
//! Read here instead of by a crate: the kept one (`stl_io`) rounds the numbers of text to 32 bits and names no line. A
//! binary file may begin with `solid` as well, so what decides is its length, and zero bytes, which no text has. Each
//! solid is an object; triangles have corners of their own, as in the file. Normals are not used: windings count. One
//! pass, O(bytes); no more is allocated than the file holds.

use std::sync::Arc;

use glam::DAffine3;
use umbriel_geometry::{AXES, Mesh, MeshDefect};
use umbriel_scene::{FindingKind, Member, Shape};

use crate::{
    error::{LoadProblem, excerpt},
    load::Reading,
    model::{Findings, Model, ModelObject},
    names::brief_name,
    tokens::{Tokens, fortran_number},
    z_up::tell_z_up,
};

/// Bytes before the triangles of a binary file: a remark, and their number.
const HEADER: usize = 84;
/// Bytes of a binary triangle: a normal, three corners, two bytes without a meaning.
const TRIANGLE: usize = 50;

/// Reads an STL file. `stem` names solids that have no name.
pub(crate) fn read(bytes: &[u8], stem: &str, reading: &Reading) -> Result<Model, LoadProblem> {
    let mut model = Model::default();
    let content = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if is_text(content) {
        let text = without_end_marks(content);
        tell_zeros(&content[text.len()..], bytes.len() - (content.len() - text.len()), &mut model.findings);
        read_text(&mut model, &String::from_utf8_lossy(text), stem)?;
    } else {
        read_binary(&mut model, bytes, stem)?;
    }
    tell_z_up(&mut model, reading);
    Ok(model)
}

fn is_text(bytes: &[u8]) -> bool {
    let begins = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let is_binary = binary_length(bytes).is_some_and(|length| length == bytes.len() as u64);
    begins && !is_binary && !without_end_marks(bytes).contains(&0)
}

/// Whether all bytes are such as text has.
fn is_like_text(bytes: &[u8]) -> bool {
    bytes.iter().all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace())
}

/// The file without the zero bytes and the Ctrl-Z that some programs end text with.
fn without_end_marks(bytes: &[u8]) -> &[u8] {
    let is_mark = |byte: &u8| matches!(byte, 0 | 0x1a);
    let end = bytes.iter().rposition(|byte| !is_mark(byte) && !byte.is_ascii_whitespace()).map_or(0, |last| last + 1);
    let marks = bytes[end..].iter().position(is_mark);
    &bytes[..marks.map_or(bytes.len(), |mark| end + mark)]
}

/// Ctrl-Z ends a text; zero bytes are what a file was filled up with.
fn tell_zeros(marks: &[u8], before: usize, findings: &mut Findings) {
    if let Some(first) = marks.iter().position(|&byte| byte == 0) {
        findings.add_at(FindingKind::BrokenRule, "zero bytes after the text", format_args!("byte {}", before + first));
    }
}

/// How long the file is according to its header, if it is long enough to have one.
fn binary_length(bytes: &[u8]) -> Option<u64> {
    let count: [u8; 4] = bytes.get(HEADER - 4..HEADER)?.try_into().ok()?;
    Some(HEADER as u64 + TRIANGLE as u64 * u64::from(u32::from_le_bytes(count)))
}

fn read_binary(model: &mut Model, bytes: &[u8], stem: &str) -> Result<(), LoadProblem> {
    let found = bytes.len() as u64;
    let Some(expected) = binary_length(bytes) else {
        let message = format!("a binary STL has {HEADER} bytes at the least, this file has {found}");
        return Err(LoadProblem::element("header", message));
    };
    if found < expected {
        let message = if is_like_text(bytes) {
            "neither text that begins with \"solid\", nor as long as a binary file is by its header".to_owned()
        } else {
            format!("the header tells of {expected} bytes, the file has {found}")
        };
        return Err(LoadProblem::element("triangles", message));
    }
    if found > expected {
        let place = format_args!("byte {expected}");
        model.findings.add_at(FindingKind::BrokenRule, "bytes after the last triangle", place);
    }
    let (triangles, _) = bytes[HEADER..expected as usize].as_chunks::<TRIANGLE>();
    let number = |triangle: &[u8; TRIANGLE], at: usize| {
        f64::from(f32::from_le_bytes(std::array::from_fn(|byte| triangle[4 * at + byte])))
    };
    for (place, triangle) in triangles.iter().enumerate() {
        let is_sound = (0..3).all(|axis| number(triangle, axis).is_finite());
        tell_normal(is_sound, &mut model.findings, format_args!("triangle {place}"));
    }
    let corner = |triangle, corner: usize| std::array::from_fn(|axis| number(triangle, 3 + 3 * corner + axis));
    let corners = triangles.iter().flat_map(|triangle| (0..3).map(move |at| corner(triangle, at)));
    take_solid(model, stem, corners.collect())
}

/// Normals are not used, but they should be numbers.
fn tell_normal(is_sound: bool, findings: &mut Findings, place: std::fmt::Arguments) {
    if !is_sound {
        findings.add_at(FindingKind::BrokenRule, "normal: not three numbers", place);
    }
}

/// A solid with the corners of its triangles, three a triangle; nothing if there are none.
fn take_solid(model: &mut Model, name: &str, corners: Vec<[f64; 3]>) -> Result<(), LoadProblem> {
    if corners.is_empty() {
        return Ok(());
    }
    let name = brief_name(name);
    let triangles = (0..corners.len() as u32 / 3).map(|triangle| [0, 1, 2].map(|corner| 3 * triangle + corner));
    let mesh = Mesh::new(corners, triangles.collect()).map_err(|defect| match defect {
        MeshDefect::Coordinate { vertex, axis, defect } => {
            let message = format!("coordinate {} of corner {} {defect}", AXES[axis], vertex % 3);
            LoadProblem::element(format!("solid \"{name}\", triangle {}", vertex / 3), message)
        }
        defect => LoadProblem::element(format!("solid \"{name}\""), defect),
    })?;
    model.families.roots.push(Member::Object(model.objects.len()));
    let shape = Shape::Mesh(Arc::new(mesh));
    model.objects.push(ModelObject {
        name,
        shape,
        map: DAffine3::IDENTITY,
        sides: None,
        lightmap: None,
        boxes: Vec::new(),
    });
    Ok(())
}

fn read_text(model: &mut Model, text: &str, stem: &str) -> Result<(), LoadProblem> {
    let mut tokens = Tokens::new(text, 1);
    while let Some(word) = tokens.next() {
        if !word.eq_ignore_ascii_case("solid") {
            return Err(unexpected(&tokens, Some(word), "solid"));
        }
        let name = tokens.line_until(begins_content).trim();
        let corners = solid(model, &mut tokens, name)?;
        take_solid(model, if name.is_empty() { stem } else { name }, corners)?;
    }
    Ok(())
}

/// The corners up to `endsolid`, also in two words, or, where that is left out, to the end of the file.
fn solid(model: &mut Model, tokens: &mut Tokens, name: &str) -> Result<Vec<[f64; 3]>, LoadProblem> {
    let mut corners = Vec::new();
    loop {
        match tokens.next() {
            Some(word) if word.eq_ignore_ascii_case("endsolid") => {
                skip_end(tokens, name);
                return Ok(corners);
            }
            Some(word) if word.eq_ignore_ascii_case("end") => {
                tell_end(model, tokens);
                expect(tokens, "solid")?;
                skip_end(tokens, name);
                return Ok(corners);
            }
            Some(word) if begins_with_end(word) => {
                tell(model, tokens, "\"endsolid\" without a space before the name");
                skip_end(tokens, name);
                return Ok(corners);
            }
            Some(word) if word.eq_ignore_ascii_case("facet") => facet(model, tokens, &mut corners)?,
            None if !corners.is_empty() => {
                tell(model, tokens, "no \"endsolid\" at the end of the file");
                return Ok(corners);
            }
            other => return Err(unexpected(tokens, other, "facet\" or \"endsolid")),
        }
    }
}

/// A rule that is broken in the line of the last word.
fn tell(model: &mut Model, tokens: &Tokens, fault: &str) {
    model.findings.add_at(FindingKind::BrokenRule, fault, format_args!("line {}", tokens.line()));
}

fn tell_end(model: &mut Model, tokens: &Tokens) {
    tell(model, tokens, "\"endloop\", \"endfacet\" or \"endsolid\" in two words");
}

fn begins_with_end(word: &str) -> bool {
    const END: &[u8] = b"endsolid";
    word.as_bytes().get(..END.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(END))
}

/// Passes the name behind an end. It is the rest of the line, unless another solid stands there.
fn skip_end(tokens: &mut Tokens, name: &str) {
    tokens.skip(name);
    let goes_on = tokens.has_on_line(begins_content);
    tokens.line_until(|text| goes_on && (begins_with(text, &["solid"]) || begins_content(text)));
}

/// Whether the content of a solid begins, or ends, with this text. Names may hold "facet normal", even "solid".
fn begins_content(text: &str) -> bool {
    let is_number = || text.split_whitespace().nth(2).is_some_and(|word| word.parse::<f64>().is_ok());
    begins_with(text, &["facet", "normal"]) && is_number() || begins_with(text, &["endsolid"])
}

fn begins_with(text: &str, words: &[&str]) -> bool {
    let mut found = text.split_whitespace();
    words.iter().all(|word| found.next().is_some_and(|found| found.eq_ignore_ascii_case(word)))
}

/// The rest of a facet, after its first word.
fn facet(model: &mut Model, tokens: &mut Tokens, corners: &mut Vec<[f64; 3]>) -> Result<(), LoadProblem> {
    expect(tokens, "normal")?;
    let line = tokens.line();
    let is_sound = normal(tokens).iter().all(|number| number.is_some_and(f64::is_finite));
    tell_normal(is_sound, &mut model.findings, format_args!("line {line}"));
    expect(tokens, "outer")?;
    expect(tokens, "loop")?;
    for _ in 0..3 {
        expect(tokens, "vertex")?;
        corners.push(vertex(model, tokens)?);
    }
    expect_end(model, tokens, "loop")?;
    expect_end(model, tokens, "facet")
}

/// What stands where the numbers of a normal are due, up to the loop.
fn normal(tokens: &mut Tokens) -> [Option<f64>; 3] {
    [(); 3].map(|()| {
        let before = tokens.clone();
        match tokens.next() {
            Some(word) if word.eq_ignore_ascii_case("outer") => {
                *tokens = before;
                None
            }
            word => word?.parse().ok(),
        }
    })
}

fn vertex(model: &mut Model, tokens: &mut Tokens) -> Result<[f64; 3], LoadProblem> {
    let line = tokens.line();
    let mut vertex = [0.0; 3];
    for (found, coordinate) in vertex.iter_mut().enumerate() {
        *coordinate = number(model, tokens).map_err(|fault| match tokens.line() {
            same if same == line => fault,
            _ => LoadProblem::line(line, format!("3 numbers expected, found {found}")),
        })?;
    }
    Ok(vertex)
}

/// The end of a loop or a facet, in one word or in two.
fn expect_end(model: &mut Model, tokens: &mut Tokens, of: &str) -> Result<(), LoadProblem> {
    match tokens.next() {
        Some(word) if word.eq_ignore_ascii_case("end") => {
            tell_end(model, tokens);
            expect(tokens, of)
        }
        Some(word) if word.eq_ignore_ascii_case(&format!("end{of}")) => Ok(()),
        found => Err(unexpected(tokens, found, &format!("end{of}"))),
    }
}

fn expect(tokens: &mut Tokens, word: &str) -> Result<(), LoadProblem> {
    match tokens.next() {
        Some(found) if found.eq_ignore_ascii_case(word) => Ok(()),
        found => Err(unexpected(tokens, found, word)),
    }
}

fn number(model: &mut Model, tokens: &mut Tokens) -> Result<f64, LoadProblem> {
    let word = tokens.next();
    let number = word.and_then(|word| word.parse::<f64>().ok()).filter(|number| number.is_finite());
    let fortran = || {
        let number = word.and_then(fortran_number)?;
        tell(model, tokens, "vertex: exponents written with a D, as Fortran has them");
        Some(number)
    };
    number.or_else(fortran).ok_or_else(|| match word {
        Some(word) => LoadProblem::line(tokens.line(), format!("\"{}\" is not a finite number", excerpt(word))),
        None => unexpected(tokens, None, "vertex"),
    })
}

fn unexpected(tokens: &Tokens, found: Option<&str>, expected: &str) -> LoadProblem {
    let found = found.map_or("the file ends".to_owned(), |word| format!("\"{}\"", excerpt(word)));
    LoadProblem::line(tokens.line(), format!("{found} where \"{expected}\" is expected"))
}

#[cfg(test)]
mod tests;
