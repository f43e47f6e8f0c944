//! The first pass over an OBJ file: statements become positions and polygons, checked one by one.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;
use umbriel_geometry::{AXES, accept_point};
use umbriel_scene::FindingKind;

use crate::{
    error::{LoadProblem, excerpt},
    model::Findings,
    names::brief_name,
    tokens::fortran_number,
};

/// Statements that say nothing about flat surfaces.
const WITHOUT_EFFECT: &str = "s mg vp deg bmat step cstype parm trim hole scrv sp \
    end con bevel c_interp d_interp lod usemap maplib shadow_obj trace_obj ctech stech";

/// What faces belong to.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Owner {
    /// Neither an object nor a group was named yet.
    File,
    /// The group of that name; a group that comes up again is the same one.
    Group(String),
    /// An object; every `o` begins a new one.
    Object(String),
}

/// A face as written: a range of [`Parser::corners`].
#[derive(Clone, Debug)]
pub(super) struct Polygon {
    first: usize,
    len: usize,
    /// Of the file.
    pub(super) line: usize,
    pub(super) owner: usize,
    pub(super) group: Option<usize>,
}

/// What has been read so far.
#[derive(Debug, Default)]
pub(super) struct Parser {
    pub(super) positions: Vec<DVec3>,
    /// Whether texture coordinates are kept, or only counted.
    pub(super) keeps_texture: bool,
    texture_count: usize,
    /// `None` where the statement is no texture coordinate.
    texture_coordinates: Vec<Option<[f64; 2]>>,
    /// As long as `corners` where texture coordinates are kept.
    texture_corners: Vec<Option<u32>>,
    normals: usize,
    corners: Vec<u32>,
    pub(super) polygons: Vec<Polygon>,
    pub(super) owners: Vec<Owner>,
    pub(super) groups: Vec<String>,
    /// Each with how many statements name it.
    pub(super) libraries: BTreeMap<String, usize>,
    /// The triangles of each material, by its number.
    triangles: Vec<usize>,
    materials: HashMap<String, usize>,
    material: Option<usize>,
    pub(super) findings: Findings,
    group_of_name: HashMap<String, (usize, Option<usize>)>,
    /// The owner of faces before any name.
    unnamed: Option<usize>,
    owner: Option<usize>,
    in_object: bool,
    group: Option<usize>,
    /// The greatest index of each kind (position, texture coordinate, normal) that looks ahead, with its line.
    ahead: [(usize, usize); 3],
}

/// Of some files that corners name normals of, those were left out.
const NOT_THERE: &str = "f, l or p: corners that name texture coordinates or normals that are not there";

impl Parser {
    /// Nothing read yet.
    pub(super) fn new(keeps_texture: bool) -> Self {
        Self { keeps_texture, ..Self::default() }
    }

    /// The corners of a polygon, indices of positions.
    pub(super) fn corners(&self, polygon: &Polygon) -> &[u32] {
        &self.corners[polygon.first..polygon.first + polygon.len]
    }

    /// Takes one statement.
    pub(super) fn statement(&mut self, statement: &str, line: usize) -> Result<(), String> {
        let statement = statement.trim_end();
        let trimmed = statement.trim_start();
        let (keyword, rest) = trimmed.split_once(char::is_whitespace).unwrap_or((trimmed, ""));
        // A remark may follow a number without a space; names may hold its sign.
        let numeric = without_remark(rest);
        let words = || numeric.split_whitespace();
        if !statement.is_ascii() && is_numeric(keyword) {
            let written = without_remark(statement).trim_end();
            let is_plain = !written.contains(|character: char| !character.is_ascii() && character.is_whitespace());
            self.require(is_plain, "white space that other readers do not take for such", line);
        }
        match keyword {
            "" => {}
            _ if keyword.starts_with('#') => {}
            "v" => {
                let numbers = numbers(words().take(3), 3..=3).or_else(|fault| {
                    let numbers = words().take(3).map(fortran_number).collect::<Option<Vec<f64>>>();
                    self.require(numbers.is_none(), "v: exponents written with a D, as Fortran has them", line);
                    numbers.filter(|numbers| numbers.len() == 3).ok_or(fault)
                })?;
                let position = accept_point([numbers[0], numbers[1], numbers[2]]);
                self.positions.push(position.map_err(|(axis, defect)| format!("coordinate {} {defect}", AXES[axis]))?);
                self.behind_position(words().skip(3), line);
            }
            "vt" => self.texture_coordinate(words(), line),
            "vn" => {
                self.normals += 1;
                self.require(finite(words(), 3..=3), "vn: not three numbers", line);
            }
            "f" | "fo" => {
                self.whole_corners(words(), line);
                self.face(words(), line)?;
            }
            "o" => self.begin_object(rest.trim()),
            "g" => self.begin_group(&rest.split_whitespace().collect::<Vec<_>>().join(" ")),
            "usemtl" => {
                let next = self.triangles.len();
                let material = *self.materials.entry(rest.trim().to_owned()).or_insert(next);
                self.triangles.resize(self.triangles.len().max(material + 1), 0);
                self.material = Some(material);
            }
            "mtllib" if rest.trim().is_empty() => self.require(false, "mtllib: no file", line),
            "mtllib" => *self.libraries.entry(rest.trim().to_owned()).or_default() += 1,
            "p" | "l" => {
                self.whole_corners(words(), line);
                for word in words() {
                    self.indices(word, line)?;
                }
                self.tell_not_triangles(line);
            }
            "curv" | "curv2" => self.tell_not_triangles(line),
            _ if WITHOUT_EFFECT.split_whitespace().any(|known| known == keyword) => {}
            _ => self.findings.add_at(FindingKind::UnknownExtension, &excerpt(keyword), format_args!("line {line}")),
        }
        Ok(())
    }

    /// How many triangles have a material.
    pub(super) fn triangles_of(&self, material: &str) -> usize {
        self.materials.get(material).map_or(0, |&material| self.triangles[material])
    }

    /// A rule of the format that no surface hangs on: where it is broken, that is told.
    pub(super) fn require(&mut self, is_kept: bool, fault: &str, line: usize) {
        if !is_kept {
            self.findings.add_at(FindingKind::BrokenRule, fault, format_args!("line {line}"));
        }
    }

    fn whole_corners<'a>(&mut self, mut words: impl Iterator<Item = &'a str>, line: usize) {
        self.require(!words.any(|word| word.ends_with('/')), "f, l or p: a slash at the end of a corner", line);
    }

    /// A weight and a colour may follow a position: one number, three, or four.
    fn behind_position<'a>(&mut self, words: impl Iterator<Item = &'a str>, line: usize) {
        let numbers = numbers(words, 0..=4).unwrap_or(vec![0.0; 2]);
        self.require(numbers.len() != 2, "v: not a weight, a colour, or both after the position", line);
        self.require(numbers != [0.0], "v: a weight of 0, which is a point at infinity", line);
    }

    fn tell_not_triangles(&mut self, line: usize) {
        self.findings.add_at(FindingKind::NotTriangles, "", format_args!("line {line}"));
    }

    fn texture_coordinate<'a>(&mut self, words: impl Iterator<Item = &'a str>, line: usize) {
        let numbers = numbers(words, 1..=3);
        self.texture_count += 1;
        self.require(numbers.is_ok(), "vt: not one to three numbers", line);
        if self.keeps_texture {
            // The origin is the lower left corner here, the upper left one in glTF and in pictures.
            let turned = |numbers: Vec<f64>| [numbers[0], 1.0 - numbers.get(1).copied().unwrap_or(0.0)];
            self.texture_coordinates.push(numbers.ok().map(turned));
        }
    }

    /// The texture coordinates of a polygon's corners, if they are kept and it has them.
    pub(super) fn texture(&self, polygon: &Polygon) -> Option<Vec<[f64; 2]>> {
        let corners = self.texture_corners.get(polygon.first..polygon.first + polygon.len)?;
        corners.iter().map(|&corner| *self.texture_coordinates.get(corner? as usize)?).collect()
    }

    fn begin_object(&mut self, name: &str) {
        self.in_object = true;
        self.owner = Some(self.owners.len());
        self.owners.push(Owner::Object(brief_name(name)));
    }

    fn begin_group(&mut self, name: &str) {
        if name.is_empty() {
            self.group = None;
            self.owner = self.owner.filter(|_| self.in_object);
            return;
        }
        let next_group = self.groups.len();
        let (group, owner) = self.group_of_name.entry(name.to_owned()).or_insert((next_group, None));
        if *group == next_group {
            self.groups.push(brief_name(name));
        }
        self.group = Some(*group);
        if !self.in_object {
            self.owner = Some(*owner.get_or_insert_with(|| {
                self.owners.push(Owner::Group(brief_name(name)));
                self.owners.len() - 1
            }));
        }
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a str>, line: usize) -> Result<(), String> {
        let first = self.corners.len();
        let (mut form, mut is_uniform) = (None, true);
        for word in words {
            let parts = self.corner(word, line)?;
            is_uniform &= *form.get_or_insert(parts) == parts;
        }
        self.require(is_uniform, "f: corners of different forms (v, v/vt, v//vn, v/vt/vn)", line);
        let len = self.corners.len() - first;
        if len < 3 {
            self.require(false, "f: fewer than three corners", line);
            self.corners.truncate(first);
            self.texture_corners.truncate(first);
            return Ok(());
        }
        if let Some(material) = self.material {
            self.triangles[material] += len - 2;
        }
        let owner = self.current_owner();
        self.polygons.push(Polygon { first, len, line, owner, group: self.group });
        Ok(())
    }

    fn current_owner(&mut self) -> usize {
        *self.owner.get_or_insert_with(|| {
            // Faces before any name may come again after an unnamed group: they are one object.
            *self.unnamed.get_or_insert_with(|| {
                self.owners.push(Owner::File);
                self.owners.len() - 1
            })
        })
    }

    /// Takes a corner; says which of its three indices it has.
    fn corner(&mut self, word: &str, line: usize) -> Result<[bool; 3], String> {
        let indices = self.indices(word, line)?;
        self.corners.extend(indices[0]);
        if self.keeps_texture {
            self.texture_corners.push(indices[1]);
        }
        Ok(indices.map(|index| index.is_some()))
    }

    /// The indices `v`, `v/vt`, `v//vn` or `v/vt/vn`, which may look ahead.
    fn indices(&mut self, word: &str, line: usize) -> Result<[Option<u32>; 3], String> {
        let counts = [self.positions.len(), self.texture_count, self.normals];
        let mut indices = [None; 3];
        for (kind, part) in word.split('/').enumerate() {
            // Some writers end corners without texture coordinates and normals in two slashes.
            if kind > 2 || (part.is_empty() && kind == 0) {
                return Err(format!("\"{}\" is not a corner (v, v/vt, v//vn or v/vt/vn)", excerpt(word)));
            }
            if part.is_empty() {
                continue;
            }
            let written: i64 = part.parse().map_err(|_| format!("\"{}\" is not an index", excerpt(part)))?;
            match absolute(written, counts[kind]) {
                Some(index) => {
                    if index as usize >= counts[kind].max(self.ahead[kind].0) {
                        self.ahead[kind] = (index as usize + 1, line);
                    }
                    indices[kind] = Some(index);
                }
                None if kind == 0 => {
                    let so_far = format!("indices count from 1, and there are {} vertices so far", counts[0]);
                    return Err(format!("index {written} is out of range: {so_far}"));
                }
                None => self.require(false, NOT_THERE, line),
            }
        }
        Ok(indices)
    }

    /// Once everything is read: whether the indices that looked ahead found something. No surface hangs on texture coordinates and normals.
    pub(super) fn check_ranges(&mut self) -> Result<(), LoadProblem> {
        let [(needed, line), others @ ..] = self.ahead;
        let vertices = self.positions.len();
        if needed > vertices {
            let message = format!("index {needed} is out of range: there are {vertices} vertices");
            return Err(LoadProblem::line(line, message));
        }
        for ((needed, line), count) in others.into_iter().zip([self.texture_count, self.normals]) {
            self.require(needed <= count, NOT_THERE, line);
        }
        Ok(())
    }
}

/// What a statement begins with.
pub(super) fn keyword(statement: &str) -> &str {
    statement.split_whitespace().next().unwrap_or_default()
}

/// Whether numbers follow a keyword, and no names.
pub(super) fn is_numeric(keyword: &str) -> bool {
    matches!(keyword, "v" | "vt" | "vn" | "f" | "fo" | "p" | "l")
}

/// What stands before a remark. Old runtimes of C write what is no number as `1.#INF`, `-1.#IND`, `1.#QNAN`.
pub(super) fn without_remark(numbers: &str) -> &str {
    let is_number = |at: usize| {
        let name = numbers[at + 1..].split(char::is_whitespace).next().unwrap_or_default();
        let name = name.trim_end_matches(|last: char| last.is_ascii_digit());
        let names = ["INF", "IND", "QNAN", "SNAN"];
        numbers[..at].ends_with('.') && names.into_iter().any(|known| known.eq_ignore_ascii_case(name))
    };
    let remark = numbers.match_indices('#').find(|&(at, _)| !is_number(at));
    remark.map_or(numbers, |(at, _)| &numbers[..at])
}

/// An index counted from 0, from one counted from 1 or (if negative) back from the `count` elements so far; `None` where there can be none.
fn absolute(index: i64, count: usize) -> Option<u32> {
    let from_zero = if index < 0 { index + count as i64 } else { index - 1 };
    u32::try_from(from_zero).ok().filter(|&from_zero| from_zero < u32::MAX)
}

/// Whether all the words are finite numbers, and as many as allowed.
fn finite<'a>(words: impl Iterator<Item = &'a str>, allowed: std::ops::RangeInclusive<usize>) -> bool {
    numbers(words, allowed).is_ok()
}

/// All the words as finite numbers.
fn numbers<'a>(
    words: impl Iterator<Item = &'a str>,
    allowed: std::ops::RangeInclusive<usize>,
) -> Result<Vec<f64>, String> {
    let mut numbers = Vec::with_capacity(3);
    for word in words {
        let number: f64 = word.parse().map_err(|_| format!("\"{}\" is not a number", excerpt(word)))?;
        if !number.is_finite() {
            return Err(format!("\"{}\" is not a finite number", excerpt(word)));
        }
        numbers.push(number);
    }
    if !allowed.contains(&numbers.len()) {
        let (least, most) = (allowed.start(), allowed.end());
        let expected = if least == most { least.to_string() } else { format!("{least} to {most}") };
        return Err(format!("{expected} numbers expected, found {}", numbers.len()));
    }
    Ok(numbers)
}
