//! Cells and portals of a scene file.

use std::path::Path;

use glam::{DAffine3, DVec3};
use toml::Spanned;
use umbriel_scene::Shape;

use super::{
    entries::{CellEntry, PortalEntry},
    objects::{Context, read_file},
};
use crate::{
    error::{LoadError, LoadProblem},
    model::Model,
    rooms::{CellShape, EntryPlace, ModelCell, ModelPortal, Outline, points_of_planes},
};

/// Reads all cells and portals.
pub(super) fn read(
    model: &mut Model,
    path: &Path,
    (cells, portals): (&[Spanned<CellEntry>], &[Spanned<PortalEntry>]),
    context: &Context,
) -> Result<(), LoadError> {
    for (number, spanned) in cells.iter().enumerate() {
        let entry = spanned.get_ref();
        let name = entry.name.clone().unwrap_or_else(|| format!("cell{}", number + 1));
        let (line, column) = context.places.line_and_column(spanned.span());
        let place = EntryPlace::Text(line, column);
        let (shape, map) =
            shape_of(entry, &name, path, context).map_err(|fault| fault.at(&place, &name).in_file(path))?;
        model.cells.push(ModelCell { name, shape, map, rounding: entry.rounding, place });
    }
    for (number, spanned) in portals.iter().enumerate() {
        let entry = spanned.get_ref();
        let name = entry.name.clone().unwrap_or_else(|| format!("portal{}", number + 1));
        let (line, column) = context.places.line_and_column(spanned.span());
        let outline = Outline::Corners(entry.corners.iter().copied().map(DVec3::from_array).collect());
        let (cells, place) = (entry.cells.clone(), EntryPlace::Text(line, column));
        let map = DAffine3::IDENTITY;
        model.portals.push(ModelPortal { name, cells, outline, map, rounding: entry.rounding, place });
    }
    Ok(())
}

/// Why a cell is not read.
enum Fault {
    Said(String),
    Problem(LoadProblem),
}

impl Fault {
    fn at(self, place: &EntryPlace, name: &str) -> LoadProblem {
        match self {
            Self::Said(message) => place.problem(format!("cell \"{name}\": {message}")),
            Self::Problem(problem) => problem,
        }
    }
}

fn shape_of(entry: &CellEntry, name: &str, path: &Path, context: &Context) -> Result<(CellShape, DAffine3), Fault> {
    let said = |message: &str| Fault::Said(message.to_owned());
    let here = |shape| Ok((shape, DAffine3::IDENTITY));
    let corners = entry.cuboid.map(corners_of);
    match (entry.points.as_ref().or(corners.as_ref()), &entry.planes, &entry.mesh, entry.outdoors.unwrap_or_default()) {
        _ if entry.points.is_some() && entry.cuboid.is_some() => Err(said("give points or box, not both")),
        _ if entry.cuboid.is_some_and(|[least, most]| (0..3).any(|axis| least[axis] >= most[axis])) => {
            Err(said("box: give its least coordinates, then its greatest"))
        }
        (Some(points), None, None, false) => {
            here(CellShape::Points(points.iter().copied().map(DVec3::from_array).collect()))
        }
        (None, Some(planes), None, false) => here(CellShape::Points(points_of_planes(planes).map_err(Fault::Said)?)),
        (None, None, None, true) => here(CellShape::Outdoors),
        (None, None, Some(file), false) => {
            let place = format!("cell \"{name}\"");
            let located = context.folder.resolve(file, &place).map_err(Fault::Problem)?;
            let model =
                read_file(&located, place, false, path, context).map_err(|error| Fault::Problem(error.problem))?;
            body_of(&model, entry.node.as_deref()).ok_or_else(|| {
                said("its mesh file must have one mesh, or node must name a mesh in it that is a cell or an object")
            })
        }
        _ => Err(said("give exactly one of points, box, planes, mesh, outdoors = true")),
    }
}

/// The corners of a box from its least and greatest coordinates.
fn corners_of(ends: [[f64; 3]; 2]) -> Vec<[f64; 3]> {
    (0..8).map(|corner: usize| std::array::from_fn(|axis| ends[corner >> axis & 1][axis])).collect()
}

/// The mesh of a file, or of one of its nodes.
fn body_of(model: &Model, node: Option<&str>) -> Option<(CellShape, DAffine3)> {
    let object = |object: &crate::model::ModelObject| match &object.shape {
        Shape::Mesh(mesh) => Some((CellShape::Mesh(mesh.clone()), object.map)),
        _ => None,
    };
    match (node, &model.objects[..], &model.cells[..]) {
        (None, [only], []) => object(only),
        (None, [], [only]) => Some((only.shape.clone(), only.map)),
        (None, ..) => None,
        (Some(node), objects, cells) => {
            let of_cell = cells.iter().find(|cell| cell.name == node).map(|cell| (cell.shape.clone(), cell.map));
            of_cell.or_else(|| objects.iter().find(|object| object.name == node).and_then(object))
        }
    }
}
