//! Cells and portals: which parts of a scene see each other.
//!
//! A *cell* is a closed convex region, a room; one cell at most is the *outdoors*, all that lies in no other cell. A *portal*
//! is a convex polygon in the boundary of two cells: a door, a window. The scene states by them that nothing is seen across
//! the boundary of a cell but through its portals: walls stand there, as objects of the scene. That statement is taken as
//! it is, as the rest of a file is; what is checked here is that cells are convex bodies and that every portal lies in the
//! boundaries of its two cells ([`CellGraph::new`]).
//!
//! Objects belong to every closed cell that they may meet ([`CellGraph::objects_in`]): an object that straddles two cells
//! belongs to both, one that touches a boundary as well. Decided by exact signs against the planes of cells; of curved
//! bodies the hull of a box is asked. An object may be counted to a cell that it just misses at an edge, never the other way.
//!
//! Source: a note on indoor scene management (cells and portals). Cost: O((n + c) log c) for n objects and c cells that lie
//! side by side along some axis, and a look at the points of objects that straddle.

mod assign;
mod overlap;
mod portal;
mod rounded;
#[cfg(test)]
mod tests;

use glam::DVec3;
use umbriel_geometry::{AXES, Aabb, Brep, NumberDefect, Point, Sign, predicates};

use crate::Object;
use assign::Index;
pub use overlap::Overlap;
pub use portal::Portal;
pub use rounded::convex_body;
use rounded::{apart, boxed};

/// What a cell is.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Region {
    /// A closed convex body, world coordinates in metres.
    Convex(Brep),
    /// All points that are in the inside of no other cell. Not convex.
    Outdoors,
}

/// A named cell.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCell {
    /// Unique within the scene.
    pub name: String,
    /// Where it is.
    pub region: Region,
    /// How far each coordinate of its corners may be from what is meant, by rounding, metres; 0 where it is exact. What is so near to its boundary counts as inside.
    pub slack: f64,
}

/// Which entry a defect is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellEntry {
    /// A cell, by its index.
    Cell(usize),
    /// A portal, by its index.
    Portal(usize),
}

/// Why cells and portals are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CellDefect {
    /// A second outdoors.
    #[error("there is an outdoors already, and there can be one only")]
    SecondOutdoors,
    /// A portal between a cell and itself, or one that is not there.
    #[error("a portal joins two different cells of the scene")]
    Ends,
    /// A coordinate outside the accepted range.
    #[error("corner {corner}: coordinate {} {defect}", AXES[*.axis])]
    Coordinate {
        /// Which corner.
        corner: usize,
        /// 0, 1 or 2.
        axis: usize,
        /// What is wrong with it.
        defect: NumberDefect,
    },
    /// Fewer than three corners, or more than [`Portal::MOST_CORNERS`].
    #[error("it has {0} corners; a portal is a polygon of 3 to {most} corners", most = Portal::MOST_CORNERS)]
    Corners(usize),
    /// A corner off the plane of the first three.
    #[error("corner {corner} lies off the plane of the others")]
    NotPlanar {
        /// Which corner.
        corner: usize,
    },
    /// Corners that do not go once round a strictly convex polygon.
    #[error("the polygon is not strictly convex at corner {corner}")]
    NotConvex {
        /// Which corner.
        corner: usize,
    },
    /// A corner outside the boundary of one of the two cells, or a polygon that lies in no single face of it.
    #[error("corner {corner} does not lie in the boundary of its cell number {end}, in one face with the others")]
    NotInBoundary {
        /// Which corner.
        corner: usize,
        /// 0 for the first of the portal's cells, 1 for the second.
        end: usize,
    },
    /// Both cells lie on one side of the portal.
    #[error("both of its cells lie on the same side of it")]
    SameSide,
}

/// The cells of a scene, the portals between them, and which objects are in which cell.
#[derive(Clone, Debug, Default)]
pub struct CellGraph {
    cells: Vec<SceneCell>,
    portals: Vec<Portal>,
    /// The portals of each cell.
    portals_of: Vec<Vec<u32>>,
    /// The objects of each cell, ascending.
    objects_in: Vec<Vec<u32>>,
    /// The box of each object that the graph was made for.
    bounds: Vec<Aabb>,
    /// How many of them are in no cell.
    loose: usize,
    outdoors: Option<usize>,
    index: Index,
}

impl CellGraph {
    /// Checks and takes cells and portals, and finds the cells of every object. The graph holds for these objects: who
    /// changes them makes it anew.
    ///
    /// # Errors
    /// The first [`CellDefect`], and the entry that it is about.
    pub fn new(
        cells: Vec<SceneCell>,
        portals: Vec<Portal>,
        objects: &[Object],
    ) -> Result<Self, (CellEntry, CellDefect)> {
        let mut outdoors = None;
        for (number, cell) in cells.iter().enumerate() {
            if cell.region == Region::Outdoors && outdoors.replace(number).is_some() {
                return Err((CellEntry::Cell(number), CellDefect::SecondOutdoors));
            }
        }
        let mut portals_of = vec![Vec::new(); cells.len()];
        let mut checked = Vec::with_capacity(portals.len());
        for (number, portal) in portals.into_iter().enumerate() {
            let portal = portal.checked(&cells).map_err(|defect| (CellEntry::Portal(number), defect))?;
            portal.cells.iter().for_each(|&cell| portals_of[cell].push(number as u32));
            checked.push(portal);
        }
        let index = Index::new(&cells);
        let mut graph = Self { cells, portals: checked, portals_of, outdoors, index, ..Self::default() };
        if !graph.is_empty() {
            graph.bounds = objects.iter().map(Object::bounds).collect();
            (graph.objects_in, graph.loose) = assign::members(&graph, objects);
        }
        Ok(graph)
    }

    /// The same cells and portals with other objects: those of a scene that has changed. O((n + c) log c), as at first.
    pub fn with_objects(&self, objects: &[Object]) -> Self {
        let mut graph = Self { objects_in: Vec::new(), bounds: Vec::new(), loose: 0, ..self.clone() };
        if !graph.is_empty() {
            graph.bounds = objects.iter().map(Object::bounds).collect();
            (graph.objects_in, graph.loose) = assign::members(&graph, objects);
        }
        graph
    }

    /// Whether the scene has no cells.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// The cells.
    pub fn cells(&self) -> &[SceneCell] {
        &self.cells
    }

    /// The portals.
    pub fn portals(&self) -> &[Portal] {
        &self.portals
    }

    /// The portals of a cell, by their indices.
    ///
    /// # Panics
    /// If there is no such cell; as all that takes one.
    pub fn portals_of(&self, cell: usize) -> &[u32] {
        &self.portals_of[cell]
    }

    /// The objects of a cell, by their indices, ascending.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn objects_in(&self, cell: usize) -> &[u32] {
        &self.objects_in[cell]
    }

    /// The boxes of the objects that the graph was made for, rounded outward; none without cells.
    pub fn bounds(&self) -> &[Aabb] {
        &self.bounds
    }

    /// How many objects are in no cell: no chain of portals leads to them.
    pub fn loose_objects(&self) -> usize {
        self.loose
    }

    /// The cell that is the outdoors, if there is one.
    pub fn outdoors(&self) -> Option<usize> {
        self.outdoors
    }

    /// The cells that hold a point (world coordinates, metres), ascending: several where it lies on a common boundary, none
    /// inside a wall. The outdoors hold what is in the inside of no union of other cells. Cost: the cells beside it along one axis.
    pub fn cells_at(&self, point: DVec3) -> Vec<usize> {
        let at = Aabb { min: point, max: point };
        let mut held: Vec<usize> = Vec::new();
        self.index.for_each_near(&self.cells, &at, |cell, body| {
            if may_hold(&self.cells[cell], body, point) {
                held.push(cell);
            }
        });
        if let Some(outdoors) = self.outdoors
            && !assign::is_enclosed(self, &at)
        {
            held.push(outdoors);
        }
        held.sort_unstable();
        held
    }
}

/// Whether a point lies in a closed convex cell, as it may be meant.
fn may_hold(cell: &SceneCell, body: &Brep, point: DVec3) -> bool {
    let x = Point::exact(point);
    (0..body.face_count()).all(|face| !is_beyond(cell, body, face, &x))
}

/// Whether a point lies in a closed convex body.
fn is_inside(body: &Brep, point: DVec3) -> bool {
    let x = Point::exact(point);
    (0..body.face_count()).all(|face| side_of_face(body, face, &x) != Sign::Positive)
}

/// The side of a face's plane on which a point lies; positive is outside.
fn side_of_face(body: &Brep, face: usize, x: &Point) -> Sign {
    let [a, b, c] = face_plane(body, face).map(Point::exact);
    predicates::side(&a, &b, &c, x)
}

/// Whether a point lies strictly outside a face's plane, however the cell is meant.
fn is_beyond(cell: &SceneCell, body: &Brep, face: usize, x: &Point) -> bool {
    if cell.slack == 0.0 {
        return side_of_face(body, face, x) == Sign::Positive;
    }
    let [a, b, c] = face_plane(body, face).map(|corner| boxed(corner, cell.slack));
    apart(&a, &b, &c, x) == Some(Sign::Positive)
}

/// Three corners of a face, counter-clockwise from outside.
fn face_plane(body: &Brep, face: usize) -> [DVec3; 3] {
    let first = body.loop_of(face).start;
    [0, 1, 2].map(|k| body.vertices()[body.half_edges()[first + k].start as usize])
}
