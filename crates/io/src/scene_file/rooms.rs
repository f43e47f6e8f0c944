//! Cells and portals of a scene file.

use glam::{DAffine3, DVec3};

use super::{
    entries::{CellEntry, PortalEntry},
    meshes::MeshFiles,
    objects::Context,
    tables::Placed,
};
use crate::{
    error::LoadError,
    model::Model,
    names::brief_name,
    rooms::{CellShape, EntryPlace, ModelCell, ModelPortal, Outline, points_of_planes},
};

/// Reads all cells and portals.
pub(super) fn read(
    model: &mut Model,
    (cells, portals): (&[Placed<CellEntry>], &[Placed<PortalEntry>]),
    files: &mut MeshFiles,
    context: &Context,
) -> Result<(), LoadError> {
    for (number, spanned) in cells.iter().enumerate() {
        let entry = spanned.get_ref();
        let name = entry.name.as_deref().map_or_else(|| format!("cell{}", number + 1), brief_name);
        let (line, column) = context.places.line_and_column(spanned.span());
        let place = EntryPlace::Text(line, column);
        let (shape, map) = shape_of(entry, &name, files, context).map_err(|fault| fault.at(&place, &name, context))?;
        model.cells.push(ModelCell { name, shape, map, rounding: entry.rounding, place });
    }
    for (number, spanned) in portals.iter().enumerate() {
        let entry = spanned.get_ref();
        let name = entry.name.as_deref().map_or_else(|| format!("portal{}", number + 1), brief_name);
        let (line, column) = context.places.line_and_column(spanned.span());
        let outline = Outline::Corners(entry.corners.iter().copied().map(DVec3::from_array).collect());
        let (cells, place) = (entry.cells.each_ref().map(|cell| brief_name(cell)), EntryPlace::Text(line, column));
        let map = DAffine3::IDENTITY;
        model.portals.push(ModelPortal { name, cells, outline, map, rounding: entry.rounding, place });
    }
    Ok(())
}

/// Why a cell is not read.
enum Fault {
    Said(String),
    Error(LoadError),
}

impl Fault {
    fn at(self, place: &EntryPlace, name: &str, context: &Context) -> LoadError {
        match self {
            Self::Said(message) => place.problem(format!("cell \"{name}\": {message}")).in_file(context.path),
            Self::Error(error) => error,
        }
    }
}

fn shape_of(
    entry: &CellEntry,
    name: &str,
    files: &mut MeshFiles,
    context: &Context,
) -> Result<(CellShape, DAffine3), Fault> {
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
            let file = files.get((file, &place), false, context).map_err(Fault::Error)?;
            file.cell(entry.node.as_deref()).ok_or_else(|| {
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
