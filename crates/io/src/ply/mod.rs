//! PLY (G. Turk, "The PLY Polygon File Format", Stanford, 1994), as text or binary in both byte orders.
//!
//! Read here instead of by a crate: `ply-rs` has not been released since 2021, and its fork `ply-rs-bw` builds a map of names for every
//! vertex, unless each record's reader is written by hand. The surface is the elements `vertex` (x, y, z), `face` (lists of corners, triangulated) and
//! `tristrips` (strips, −1 begins a new one); their other properties are passed over, other elements too, with a finding. One object,
//! named after the file. One pass, O(bytes) but for triangulation. A header that tells of more than the file holds is
//! refused before anything is read.

mod data;
mod header;

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use umbriel_geometry::Mesh;
use umbriel_scene::{FindingKind, Member, Shape};

use crate::{
    error::{LoadProblem, excerpt},
    load::Reading,
    model::{Model, ModelObject},
    triangulate::{Triangulation, Triangulator, is_planar},
    z_up::tell_z_up,
};
use data::{Oddities, Row, Source};
use header::{Element, Header, Property};

/// Reads a PLY file; `stem` names its object.
pub(crate) fn read(bytes: &[u8], stem: &str, reading: &Reading) -> Result<Model, LoadProblem> {
    // Editors put a byte order mark before text.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let header = Header::read(bytes)?;
    let mut model = Model::default();
    let mut surface = Surface::default();
    let body = String::from_utf8_lossy(if header.is_text() { &bytes[header.length..] } else { b"" });
    let mut source = Source::new(&header, &bytes[header.length..], &body);
    for element in &header.elements {
        source.check_room(element)?;
        surface.take(element, &mut source, &mut model)?;
    }
    if source.has_more() {
        model.findings.add(FindingKind::BrokenRule, "data after the last element", 1);
    }
    let mesh = surface.into_mesh(&mut model)?;
    if !mesh.triangles().is_empty() {
        model.families.roots.push(Member::Object(0));
        let shape = Shape::Mesh(Arc::new(mesh));
        model.objects.push(ModelObject {
            name: stem.to_owned(),
            shape,
            map: DAffine3::IDENTITY,
            sides: None,
            lightmap: None,
            boxes: Vec::new(),
        });
    }
    tell_z_up(&mut model, reading);
    Ok(model)
}

/// What has been read of the surface.
#[derive(Default)]
struct Surface {
    positions: Vec<[f64; 3]>,
    corners: Vec<Corner>,
    /// Each with its element and its end among the corners.
    polygons: Vec<Polygon>,
}

/// An index of a vertex as written: it may lie ahead, or nowhere.
type Corner = i64;

/// What ends a strip among indices of 32 bits without a sign: −1, as such files write it.
const UNSIGNED_END: Corner = u32::MAX as Corner;

/// A face or a strip.
struct Polygon {
    kind: Kind,
    /// Its place in its element.
    number: u64,
    /// Behind its last corner.
    end: usize,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Face,
    Strip,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Face => "face",
            Self::Strip => "tristrips",
        }
    }
}

impl Surface {
    /// Takes all rows of an element.
    fn take(&mut self, element: &Element, source: &mut Source, model: &mut Model) -> Result<(), LoadProblem> {
        let oddities = match element.name.as_str() {
            // A table without rows needs no columns.
            "vertex" | "face" | "tristrips" if element.count == 0 => Oddities::default(),
            "vertex" => {
                let columns = element.columns(["x", "y", "z"])?;
                let normals = ["nx", "ny", "nz"].map(|name| element.columns([name]).ok());
                let take = |number, row: &Row| {
                    self.positions.push(columns.map(|column| row.number(column)));
                    if normals.iter().flatten().any(|&[column]| !row.number(column).is_finite()) {
                        let subject = "element vertex: normals that are no numbers";
                        model.findings.add_at(FindingKind::BrokenRule, subject, format_args!("vertex {number}"));
                    }
                    Ok(())
                };
                source.rows(element, &columns, take)?
            }
            "face" => self.take_polygons(Kind::Face, element, source, model)?,
            "tristrips" => self.take_polygons(Kind::Strip, element, source, model)?,
            "edge" => {
                let rows = if element.properties.is_empty() { 0 } else { element.count as usize };
                model.findings.add(FindingKind::NotTriangles, "", rows);
                source.rows(element, &[], |_, _| Ok(()))?
            }
            name => {
                model.findings.add(FindingKind::UnknownExtension, &excerpt(name), 1);
                source.rows(element, &[], |_, _| Ok(()))?
            }
        };
        let is_hollow = element.count > 0 && element.properties.is_empty();
        let subject = format!("element {}: rows without properties", excerpt(&element.name));
        model.findings.add(FindingKind::BrokenRule, &subject, usize::from(is_hollow));
        let subject = format!("element {}: numbers that are none of their type", excerpt(&element.name));
        model.findings.add(FindingKind::BrokenRule, &subject, oddities.numbers);
        model.findings.add(FindingKind::UnevenRows, &format!("element {}", excerpt(&element.name)), oddities.lines);
        Ok(())
    }

    fn take_polygons(
        &mut self,
        kind: Kind,
        element: &Element,
        source: &mut Source,
        model: &mut Model,
    ) -> Result<Oddities, LoadProblem> {
        let column = element.index_list()?;
        let is_second = element.properties[column + 1..].iter().any(Property::is_index_list);
        let is_float = !element.properties[column].item.is_whole();
        for (rule, is_broken) in [("two lists of vertices", is_second), ("indices of a type of floats", is_float)] {
            let subject = format!("element {}: {rule}", kind.name());
            model.findings.add(FindingKind::BrokenRule, &subject, usize::from(is_broken));
        }
        source.rows(element, &[column], |number, row: &Row| {
            // Some writers list indices as floats.
            if let Some(index) = row.list(column).iter().find(|index| index.fract() != 0.0) {
                let place = format!("{} {number}", kind.name());
                return Err(LoadProblem::element(place, format!("{index} is not an index")));
            }
            self.corners.extend(row.list(column).iter().map(|&index| index as Corner));
            self.polygons.push(Polygon { kind, number, end: self.corners.len() });
            Ok(())
        })
    }

    fn into_mesh(self, model: &mut Model) -> Result<Mesh, LoadProblem> {
        let mut triangles = Vec::new();
        let mut triangulator = Triangulator::default();
        let mut start = 0;
        for polygon in &self.polygons {
            let corners = &self.corners[start..polygon.end];
            start = polygon.end;
            match polygon.kind {
                Kind::Face => self.add_face(polygon, corners, &mut triangles, (&mut triangulator, model))?,
                Kind::Strip => self.add_strips(polygon, corners, &mut triangles, model)?,
            }
        }
        Mesh::new(self.positions, triangles).map_err(|defect| LoadProblem::element("vertices", defect))
    }

    fn add_face(
        &self,
        polygon: &Polygon,
        corners: &[Corner],
        triangles: &mut Vec<[u32; 3]>,
        (triangulator, model): (&mut Triangulator, &mut Model),
    ) -> Result<(), LoadProblem> {
        let corners = self.existing(polygon, corners)?;
        if corners.len() < 3 {
            let place = format_args!("face {}", polygon.number);
            model.findings.add_at(FindingKind::BrokenRule, "faces of fewer than three corners", place);
            return Ok(());
        }
        let points: Vec<DVec3> = corners.iter().map(|&corner| self.positions[corner as usize].into()).collect();
        if !is_planar(&points) {
            model.findings.add_at(FindingKind::NonPlanarPolygons, "", format_args!("face {}", polygon.number));
        }
        let Triangulation { triangles: cut, crosses } = triangulator.cut(&points);
        if crosses {
            model.findings.add_at(FindingKind::CrossingPolygons, "", format_args!("face {}", polygon.number));
        }
        triangles.extend(cut.into_iter().map(|triangle| triangle.map(|corner| corners[corner])));
        Ok(())
    }

    /// Every other triangle of a strip is turned; those with two equal corners only lead from one part to another.
    fn add_strips(
        &self,
        polygon: &Polygon,
        corners: &[Corner],
        triangles: &mut Vec<[u32; 3]>,
        model: &mut Model,
    ) -> Result<(), LoadProblem> {
        for strip in corners.split(|&corner| corner == -1 || corner == UNSIGNED_END) {
            let strip = self.existing(polygon, strip)?;
            if (1..3).contains(&strip.len()) {
                let place = format_args!("{} {}", polygon.kind.name(), polygon.number);
                model.findings.add_at(FindingKind::BrokenRule, "strips of fewer than three corners", place);
            }
            for (place, three) in strip.windows(3).enumerate() {
                let (a, b, c) = (three[0], three[1], three[2]);
                if a != b && b != c && c != a {
                    triangles.push(if place % 2 == 0 { [a, b, c] } else { [b, a, c] });
                }
            }
        }
        Ok(())
    }

    fn existing(&self, polygon: &Polygon, corners: &[Corner]) -> Result<Vec<u32>, LoadProblem> {
        let count = self.positions.len();
        let check = |&corner: &Corner| match u32::try_from(corner) {
            Ok(index) if (index as usize) < count => Ok(index),
            _ => {
                let place = format!("{} {}", polygon.kind.name(), polygon.number);
                Err(LoadProblem::element(place, format!("it names vertex {corner}, but there are {count}")))
            }
        };
        corners.iter().map(check).collect()
    }
}

#[cfg(test)]
mod tests;
