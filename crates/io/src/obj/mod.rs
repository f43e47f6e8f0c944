//! Wavefront OBJ: polygons with groups and objects.
//!
//! Read by an own parser instead of the `tobj` crate: that one cuts meshes where the material changes, forgets which
//! line a fault is in, and takes what is not finite. Here a fault names its line, a material changes nothing, and an
//! object is its `o`; faces before any `o` belong to their `g`, faces before either to an object named after the file.
//! Objects whose faces all lie in one group form the family of that group.
//!
//! Positions are read as f64. Normals are checked and not used, texture coordinates used for light maps only (their v
//! counts from below in this format, so it is turned). A statement may be continued
//! by a `\` at the end of the line; negative indices count back from their own line, others may look ahead. Text is UTF-8 or
//! UTF-16, with any line ends. Faults that change no surface (a normal that is no number, a face of two corners, corners of
//! different forms in one face, a texture coordinate that is none) are findings, as are triangles that their material would have transparent, and so are exponents that Fortran writes with a D: they are read as what they mean,
//! where other readers stop at the letter. Indices are refused out of range also in points and lines. Two passes (statements, then triangles), linear in the file but for
//! triangulation.

mod materials;
mod parser;

use std::{
    borrow::Cow,
    collections::{BTreeSet, HashMap},
    sync::Arc,
};

use glam::{DAffine3, DVec3};
use umbriel_geometry::Mesh;
use umbriel_scene::{Family, FindingKind, Member, Shape};

use crate::{
    error::{LoadProblem, excerpt},
    folder::Folder,
    lightmap::{LightmapLayout, NOWHERE},
    load::Reading,
    model::{Findings, Model, ModelObject},
    text,
    triangulate::{Triangulation, Triangulator, is_planar},
    z_up::tell_z_up,
};
use parser::{Owner, Parser, Polygon};

/// Reads an OBJ file. `stem` names what stands before any object or group.
pub(crate) fn read(bytes: &[u8], stem: &str, folder: &Folder, reading: &Reading) -> Result<Model, LoadProblem> {
    let (text, odd_line) = text::decode(bytes)?;
    let mut parser = Parser::new(reading.lightmap_set.is_some());
    for (line, statement) in statements(&text) {
        parser.statement(&statement, line).map_err(|message| LoadProblem::line(line, message))?;
    }
    if let Some(line) = odd_line {
        parser.require(false, "text: neither UTF-8 nor UTF-16, taken as U+FFFD", line);
    }
    parser.check_ranges()?;
    let mut model = build(&parser, stem)?;
    model.findings.absorb(std::mem::take(&mut parser.findings), str::to_owned);
    tell_materials(&parser, folder, &mut model.findings);
    tell_non_planar(&parser, &mut model.findings);
    tell_z_up(&mut model, reading);
    Ok(model)
}

/// The statements of a file, each with the number of its first line.
fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text::lines(text).enumerate();
    std::iter::from_fn(move || {
        let (number, first) = lines.next()?;
        let Some(begun) = continued(first, false) else {
            return Some((number + 1, Cow::Borrowed(first)));
        };
        let mut statement = begun.to_owned();
        let is_numeric = parser::is_numeric(parser::keyword(begun));
        for (_, line) in lines.by_ref() {
            let begun = continued(line, is_numeric);
            statement.push(' ');
            statement.push_str(begun.unwrap_or(line));
            if begun.is_none() {
                break;
            }
        }
        Some((number + 1, Cow::Owned(statement)))
    })
}

/// What stands before the backslash that continues a line. A remark that ends in one (a path, say) must not swallow the next line; names may
/// hold the sign of remarks, so one that follows others is looked for among numbers only.
fn continued(line: &str, is_numeric: bool) -> Option<&str> {
    let begun = line.trim_end().strip_suffix('\\')?;
    let keyword = parser::keyword(begun);
    let is_remark = keyword.starts_with('#')
        || (is_numeric || parser::is_numeric(keyword)) && parser::without_remark(begun) != begun;
    (!is_remark).then_some(begun)
}

/// The second pass: triangles, object by object, and the families of the groups.
fn build(parser: &Parser, stem: &str) -> Result<Model, LoadProblem> {
    let mut faces_of: Vec<Vec<&Polygon>> = vec![Vec::new(); parser.owners.len()];
    for polygon in &parser.polygons {
        faces_of[polygon.owner].push(polygon);
    }
    let mut model = Model::default();
    let mut triangulator = Triangulator::default();
    let mut family_of: HashMap<usize, usize> = HashMap::new();
    for (owner, polygons) in parser.owners.iter().zip(&faces_of) {
        let Some(first) = polygons.first() else { continue };
        let (name, is_object) = match owner {
            Owner::File => (stem, false),
            Owner::Group(name) => (name.as_str(), false),
            Owner::Object(name) => (if name.is_empty() { stem } else { name }, true),
        };
        let member = Member::Object(model.objects.len());
        let (mesh, layout) = mesh_of(parser, polygons, name, (&mut triangulator, &mut model.findings))?;
        let (shape, lightmap) = (Shape::Mesh(Arc::new(mesh)), layout.map(Arc::new));
        model.objects.push(ModelObject {
            name: name.to_owned(),
            shape,
            map: DAffine3::IDENTITY,
            sides: None,
            lightmap,
            boxes: Vec::new(),
        });
        let group = first.group.filter(|_| is_object && polygons.iter().all(|face| face.group == first.group));
        let Some(group) = group else {
            model.families.roots.push(member);
            continue;
        };
        let tree = &mut model.families;
        let family = *family_of.entry(group).or_insert_with(|| {
            tree.families.push(Family { name: parser.groups[group].clone(), members: Vec::new() });
            tree.roots.push(Member::Family(tree.families.len() - 1));
            tree.families.len() - 1
        });
        tree.families[family].members.push(member);
    }
    Ok(model)
}

/// The mesh of some polygons, the vertices that they use in the order of first use; and its layout on a light map.
fn mesh_of(
    parser: &Parser,
    polygons: &[&Polygon],
    name: &str,
    (triangulator, findings): (&mut Triangulator, &mut Findings),
) -> Result<(Mesh, Option<LightmapLayout>), LoadProblem> {
    let mut place: HashMap<u32, u32> = HashMap::new();
    let (mut positions, mut triangles, mut layout) = (Vec::new(), Vec::new(), Vec::new());
    for polygon in polygons {
        let corners = parser.corners(polygon);
        let points: Vec<DVec3> = corners.iter().map(|&corner| parser.positions[corner as usize]).collect();
        let places: Vec<u32> = (corners.iter().zip(&points))
            .map(|(&corner, point)| {
                *place.entry(corner).or_insert_with(|| {
                    positions.push(point.to_array());
                    positions.len() as u32 - 1
                })
            })
            .collect();
        let Triangulation { triangles: cut, crosses } = triangulator.cut(&points);
        if crosses {
            findings.add_at(FindingKind::CrossingPolygons, "", format_args!("line {}", polygon.line));
        }
        if let Some(texture) = parser.texture(polygon) {
            layout.extend(cut.iter().map(|triangle| triangle.map(|corner| texture[corner])));
        } else if parser.keeps_texture {
            layout.extend(cut.iter().map(|_| NOWHERE));
        }
        triangles.extend(cut.iter().map(|triangle| triangle.map(|corner| places[corner])));
    }
    let mesh = Mesh::new(positions, triangles);
    let mesh = mesh.map_err(|defect| LoadProblem::element(format!("object \"{name}\""), defect))?;
    Ok((mesh, LightmapLayout::of(layout)))
}

/// Tells the libraries that cannot be read, and the triangles whose materials are transparent by the others.
fn tell_materials(parser: &Parser, folder: &Folder, findings: &mut Findings) {
    let mut known = HashMap::new();
    let mut transparent = BTreeSet::new();
    for (library, &count) in &parser.libraries {
        let mut is_there = |name| {
            let look = || {
                let bytes = folder.resolve(name, "mtllib").and_then(|file| folder.ledger().read(&file));
                let text = bytes.as_ref().ok().and_then(|bytes| text::decode(bytes).ok());
                if let Some((text, _)) = text {
                    transparent.extend(materials::transparent(&text).into_iter().map(str::to_owned));
                }
                bytes.is_ok()
            };
            *known.entry(name).or_insert_with(look)
        };
        // One name with spaces in it, or several.
        if !is_there(library.as_str()) && !library.split_whitespace().all(is_there) {
            findings.add(FindingKind::MissingMaterials, &excerpt(library), count);
        }
    }
    for name in transparent {
        findings.add(FindingKind::BlendAsOpaque, &excerpt(&name), parser.triangles_of(&name));
    }
}

fn tell_non_planar(parser: &Parser, findings: &mut Findings) {
    let mut points = Vec::new();
    for polygon in &parser.polygons {
        points.clear();
        points.extend(parser.corners(polygon).iter().map(|&corner| parser.positions[corner as usize]));
        if !is_planar(&points) {
            findings.add_at(FindingKind::NonPlanarPolygons, "", format_args!("line {}", polygon.line));
        }
    }
}

#[cfg(test)]
mod tests;
