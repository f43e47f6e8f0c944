//! Cells and portals as read, and the step from there to those of a scene.
//!
//! Counts are limited, since a small file may ask for much exact work: points and triangles of a cell, half-spaces of a cell, corners
//! of a portal, and cells and portals count as parts of the scene.
//!
//! Meshes whose coordinates are all numbers of 32 bits are taken as rounded to these ([`slack`]): a wall that was turned before it was written
//! is flat no more, and walls of two rooms differ. Other coordinates are exact, unless the entry says how they are rounded.

use std::{collections::HashMap, sync::Arc};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{AXES, Brep, HalfSpace, Mesh, Placement, accept_point};
use umbriel_scene::{
    CellEntry, CellGraph, Finding, FindingKind, Object, Overlap, Portal, Region, SceneCell, convex_body,
};

use crate::{
    error::{LoadProblem, excerpt},
    names::printable,
};

/// Half-spaces that a cell may be given by; each costs a look at all corners so far, exactly.
pub(crate) const MOST_PLANES: usize = 256;
/// Points or triangles that a cell, and points that a portal may be given by.
pub(crate) const MOST_POINTS: usize = 4096;
/// Metres that coordinates may be said to be rounded by; rounder rooms are mistakes.
const MOST_ROUNDING: f64 = 1.0;

/// Where an entry stands in its file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum EntryPlace {
    /// Line and column of a text.
    Text(usize, usize),
    /// An element by its name.
    Element(String),
}

impl EntryPlace {
    /// A problem there.
    pub(crate) fn problem(&self, message: String) -> LoadProblem {
        match self {
            Self::Text(line, column) => LoadProblem::Text { line: *line, column: Some(*column), message },
            Self::Element(place) => LoadProblem::element(place.clone(), message),
        }
    }
}

/// What a cell is, in its own coordinates.
#[derive(Clone, Debug)]
pub(crate) enum CellShape {
    Outdoors,
    /// The hull of points.
    Points(Vec<DVec3>),
    /// A closed convex mesh.
    Mesh(Arc<Mesh>),
}

/// A cell as read.
#[derive(Clone, Debug)]
pub(crate) struct ModelCell {
    pub(crate) name: String,
    pub(crate) shape: CellShape,
    /// Local to the file's coordinates.
    pub(crate) map: DAffine3,
    /// How far the file says that its coordinates are rounded, metres.
    pub(crate) rounding: Option<f64>,
    pub(crate) place: EntryPlace,
}

/// A portal as read.
#[derive(Clone, Debug)]
pub(crate) struct ModelPortal {
    pub(crate) name: String,
    /// The names of the two cells.
    pub(crate) cells: [String; 2],
    pub(crate) outline: Outline,
    /// Local to the file's coordinates.
    pub(crate) map: DAffine3,
    /// How far the file says that its coordinates are rounded, metres.
    pub(crate) rounding: Option<f64>,
    pub(crate) place: EntryPlace,
}

/// What a portal's polygon is given by.
#[derive(Clone, Debug)]
pub(crate) enum Outline {
    /// Its corners, in order.
    Corners(Vec<DVec3>),
    /// A mesh of whose vertices it is the hull.
    HullOf(Arc<Mesh>),
}

/// The points of a body that half-spaces [nx, ny, nz, offset] have in common: n·x ≤ offset.
pub(crate) fn points_of_planes(planes: &[[f64; 4]]) -> Result<Vec<DVec3>, String> {
    if planes.len() > MOST_PLANES {
        return Err(format!("it has {} planes; at most {MOST_PLANES} are read", planes.len()));
    }
    let half_space = |&[x, y, z, offset]: &[f64; 4]| HalfSpace { normal: [x, y, z], offset };
    let body = Brep::of_half_spaces(&planes.iter().map(half_space).collect::<Vec<_>>());
    body.map(|body| body.vertices().to_vec()).map_err(|defect| format!("planes: {defect}"))
}

/// The cells of a scene, everything turned by `turn`.
pub(crate) fn graph(
    cells: Vec<ModelCell>,
    portals: Vec<ModelPortal>,
    turn: &DAffine3,
    objects: &[Object],
) -> Result<CellGraph, LoadProblem> {
    let mut numbers = HashMap::new();
    let mut regions = Vec::with_capacity(cells.len());
    let (mut cell_places, mut portal_places) = (Vec::new(), Vec::new());
    for (number, cell) in cells.into_iter().enumerate() {
        let refused = |message: String| cell.place.problem(format!("cell \"{}\": {message}", cell.name));
        if numbers.insert(cell.name.clone(), number).is_some() {
            return Err(refused("another cell has this name".to_owned()));
        }
        regions.push(placed_cell(&cell, turn).map_err(refused)?);
        cell_places.push((cell.place, cell.name));
    }
    let mut joined = Vec::with_capacity(portals.len());
    for portal in portals {
        let refused = |message: String| portal.place.problem(format!("portal \"{}\": {message}", portal.name));
        let number = |name: &String| {
            let unknown = || refused(format!("there is no cell \"{}\"", excerpt(name)));
            numbers.get(name).copied().ok_or_else(unknown)
        };
        let ends = [number(&portal.cells[0])?, number(&portal.cells[1])?];
        joined.push(placed_portal(&portal, ends, turn).map_err(refused)?);
        portal_places.push((portal.place, portal.name, portal.cells));
    }
    CellGraph::new(regions, joined, objects).map_err(|(entry, defect)| match entry {
        CellEntry::Cell(number) => {
            let (place, name) = &cell_places[number];
            place.problem(format!("cell \"{name}\": {defect}"))
        }
        CellEntry::Portal(number) => {
            let (place, name, cells) = &portal_places[number];
            place.problem(format!("portal \"{name}\" between \"{}\" and \"{}\": {defect}", cells[0], cells[1]))
        }
    })
}

fn placed_cell(cell: &ModelCell, turn: &DAffine3) -> Result<SceneCell, String> {
    let map = *turn * cell.map;
    let slack = cell_slack(cell, map)?;
    let region = region(&cell.shape, map, slack)?;
    Ok(SceneCell { name: printable(&cell.name).into_owned(), region, slack })
}

fn placed_portal(portal: &ModelPortal, cells: [usize; 2], turn: &DAffine3) -> Result<Portal, String> {
    let map = *turn * portal.map;
    let slack = portal_slack(portal, map)?;
    let corners = corners(&portal.outline, map)?;
    Ok(Portal { name: printable(&portal.name).into_owned(), cells, corners, slack })
}

/// A cell where its file has it, or why it is none.
pub(crate) fn cell_in_file(cell: &ModelCell) -> Result<SceneCell, String> {
    placed_cell(cell, &DAffine3::IDENTITY)
}

/// Why a portal does not join two cells, where its file has all three.
pub(crate) fn check_portal(portal: &ModelPortal, cells: [&SceneCell; 2]) -> Result<(), String> {
    let is_one = portal.cells[0] == portal.cells[1];
    let joined = placed_portal(portal, if is_one { [0, 0] } else { [0, 1] }, &DAffine3::IDENTITY)?;
    let graph = CellGraph::new(cells.map(SceneCell::clone).to_vec(), vec![joined], &[]);
    graph.map(|_| ()).map_err(|(_, defect)| defect.to_string())
}

/// As many overlapping pairs are told.
const MOST_OVERLAPS: usize = 64;

/// The pairs of cells and of portals that overlap, by their names, and about where.
pub(crate) fn overlaps(graph: &CellGraph) -> impl Iterator<Item = Finding> + '_ {
    graph.overlaps(MOST_OVERLAPS).into_iter().map(|Overlap { entries, near }| {
        let name = |entry: CellEntry| match entry {
            CellEntry::Cell(number) => format!("cell \"{}\"", graph.cells()[number].name),
            CellEntry::Portal(number) => format!("portal \"{}\"", graph.portals()[number].name),
        };
        let [one, two] = entries.map(name);
        Finding {
            kind: FindingKind::OverlappingCells,
            subject: format!("{one} and {two}"),
            count: 1,
            places: vec![format!("({}, {}, {})", near.x, near.y, near.z)],
        }
    })
}

/// What coordinates of 32 bits may be rounded by, of the greatest number: half an ulp is 2⁻²⁴. A turn and a move in such numbers (four entries and three
/// products rounded, three sums, and one more to write) take eight of them where nothing cancels.
const SINGLE_ROUNDING: f64 = f32::EPSILON as f64 * 4.0;

/// How far placed points may be from what is meant if all their coordinates are numbers of 32 bits, else 0: the rounding of the greatest coordinate, as the
/// placement magnifies it, and of the placement's own move, since its numbers are of 32 bits, too.
fn slack(points: &[DVec3], map: DAffine3) -> f64 {
    let is_single = |point: &DVec3| point.as_vec3().as_dvec3() == *point;
    if !points.iter().all(is_single) {
        return 0.0;
    }
    let greatest = points.iter().fold(0.0_f64, |greatest, point| greatest.max(point.abs().max_element()));
    let axes = &map.matrix3;
    let magnified = (axes.x_axis.abs() + axes.y_axis.abs() + axes.z_axis.abs()) * greatest + map.translation.abs();
    SINGLE_ROUNDING * magnified.max_element()
}

fn cell_slack(cell: &ModelCell, map: DAffine3) -> Result<f64, String> {
    let found = match &cell.shape {
        CellShape::Mesh(mesh) => slack(mesh.positions(), map),
        CellShape::Points(_) | CellShape::Outdoors => 0.0,
    };
    stated(cell.rounding, found)
}

fn portal_slack(portal: &ModelPortal, map: DAffine3) -> Result<f64, String> {
    let found = match &portal.outline {
        Outline::HullOf(mesh) => slack(mesh.positions(), map),
        Outline::Corners(_) => 0.0,
    };
    stated(portal.rounding, found)
}

/// What the file states, else what was found.
fn stated(rounding: Option<f64>, found: f64) -> Result<f64, String> {
    match rounding {
        Some(rounding) if !(0.0..=MOST_ROUNDING).contains(&rounding) => {
            Err(format!("its rounding is {rounding}; it lies between 0 and {MOST_ROUNDING} metres"))
        }
        rounding => Ok(rounding.unwrap_or(found)),
    }
}

fn region(shape: &CellShape, map: DAffine3, slack: f64) -> Result<Region, String> {
    let placed = |points: &[DVec3]| -> Result<Vec<DVec3>, String> {
        if points.len() > MOST_POINTS {
            return Err(format!("it has {} points; at most {MOST_POINTS} are read", points.len()));
        }
        placed_points(points, map, "point")
    };
    match shape {
        CellShape::Outdoors => Ok(Region::Outdoors),
        CellShape::Points(points) => {
            Brep::hull(placed(points)?).map(Region::Convex).map_err(|defect| defect.to_string())
        }
        CellShape::Mesh(mesh) => {
            if mesh.triangles().len() > MOST_POINTS {
                return Err(format!("it has {} triangles; at most {MOST_POINTS} are read", mesh.triangles().len()));
            }
            let positions = placed(mesh.positions())?.into_iter().map(|position| position.to_array()).collect();
            let placed = Mesh::new(positions, mesh.triangles().to_vec()).map_err(|defect| defect.to_string())?;
            convex_body(&placed, slack)
                .map(Region::Convex)
                .map_err(|defect| format!("its mesh is no convex body: {defect}"))
        }
    }
}

fn corners(outline: &Outline, map: DAffine3) -> Result<Vec<DVec3>, String> {
    match outline {
        Outline::Corners(corners) => placed_points(corners, map, "corner"),
        Outline::HullOf(mesh) if mesh.positions().len() > MOST_POINTS => {
            Err(format!("it has {} points; at most {MOST_POINTS} are read", mesh.positions().len()))
        }
        Outline::HullOf(mesh) => Ok(Portal::outline_of(&placed_points(mesh.positions(), map, "point")?)),
    }
}

/// Points in the scene's coordinates; `what` they are called where one is refused.
fn placed_points(points: &[DVec3], map: DAffine3, what: &str) -> Result<Vec<DVec3>, String> {
    let placement = Placement::new(map).map_err(|defect| defect.to_string())?;
    let place = |(number, point): (usize, &DVec3)| {
        let accepted = accept_point(point.to_array());
        let local =
            accepted.map_err(|(axis, defect)| format!("{what} {number}: coordinate {} {defect}", AXES[axis]))?;
        Ok(placement.round(local))
    };
    points.iter().enumerate().map(place).collect()
}
