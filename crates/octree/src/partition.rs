//! A cube divided into cells: a sorted list of Morton codes, the core of every octree here.
//!
//! The leaves of an octree in Morton order, without pointers and without gaps (Gargantini, "An effective way to represent
//! quadtrees", Communications of the ACM 25(12), 1982, for the cube and with leaves of several levels). Point location
//! is one binary search, the leaves below a cell are one run of the list, and the list cut at a depth is the coarser
//! octree. Everything is exact. Costs are in searches of O(log leaves).

use std::ops::Range;

use glam::DVec3;

use crate::{
    cast::{Cast, Ray},
    cube::Cube,
    direction::Direction,
    morton::Octant,
};

/// The first leaf that does not begin where the one before it ends; or their number, where the last does not end the cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("leaf {leaf} leaves a gap or overlaps")]
pub struct Gap {
    /// Index of the leaf.
    pub leaf: usize,
}

/// The leaves of an octree over a cube, in Morton order; they divide the cube.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "crate::stored::Stored", into = "crate::stored::Stored")
)]
pub struct Partition {
    cube: Cube,
    cells: Vec<Octant>,
}

impl Partition {
    /// Checks and takes leaves. O(leaves).
    ///
    /// # Errors
    /// [`Gap`] unless the cells, in this order, divide the cube.
    pub fn new(cube: Cube, cells: Vec<Octant>) -> Result<Self, Gap> {
        let partition = Self { cube, cells };
        partition.check().map(|()| partition)
    }

    /// Takes leaves that divide the cube by the way they were made.
    pub(crate) fn of_leaves(cube: Cube, cells: Vec<Octant>) -> Self {
        debug_assert!(!cells.is_empty(), "a cube has one leaf at least");
        Self { cube, cells }
    }

    /// Whether the leaves divide the cube, in order.
    ///
    /// # Errors
    /// The first [`Gap`].
    pub fn check(&self) -> Result<(), Gap> {
        let mut next = 0;
        for (leaf, cell) in self.cells.iter().enumerate() {
            if *cell.range().start() != next {
                return Err(Gap { leaf });
            }
            next = cell.range().end() + 1;
        }
        let is_complete = next == Octant::ROOT.range().end() + 1;
        if is_complete { Ok(()) } else { Err(Gap { leaf: self.cells.len() }) }
    }

    /// The cube that is divided.
    pub fn cube(&self) -> &Cube {
        &self.cube
    }

    /// The leaves in Morton order; everything else names them by their place in this list.
    pub fn cells(&self) -> &[Octant] {
        &self.cells
    }

    /// The level of the deepest leaf. O(leaves).
    pub fn depth(&self) -> u8 {
        self.cells.iter().map(|cell| cell.level()).max().unwrap_or(0)
    }

    /// The leaf that holds `point`; a point on a plane between cells belongs to the upper one. `None` outside the closed
    /// cube. One search.
    pub fn leaf_at(&self, point: DVec3) -> Option<usize> {
        self.cube.octant_at(point, Octant::MAX_LEVEL).map(|cell| self.first_leaf(cell))
    }

    /// The leaves that `cell` divides into, or the one leaf that holds it. Two searches.
    pub fn run(&self, cell: Octant) -> Range<usize> {
        let start = self.first_leaf(cell);
        let last = *cell.range().end();
        if *self.cells[start].range().end() >= last {
            return start..start + 1;
        }
        start..start + self.cells[start..].partition_point(|leaf| leaf.start() <= last)
    }

    /// The leaf that holds the first corner of `cell`: the last one that does not begin behind it.
    pub(crate) fn first_leaf(&self, cell: Octant) -> usize {
        let start = cell.start();
        self.cells.partition_point(|leaf| leaf.start() <= start).saturating_sub(1)
    }

    /// The leaves that touch leaf number `leaf` in `direction`, ascending: one of its size or larger, or the finer ones
    /// along the common face, edge or corner. None beyond the cube, and none for a leaf that is not there.
    ///
    /// A larger leaf is found in several directions: seen from a corner it may touch a face as well. O(found) searches.
    pub fn neighbours(&self, leaf: usize, direction: Direction) -> Vec<usize> {
        let beside = self.cells.get(leaf).and_then(|cell| cell.neighbour(direction));
        let (mut open, mut found) = (Vec::from_iter(beside), Vec::new());
        while let Some(cell) = open.pop() {
            let run = self.run(cell);
            if run.len() == 1 {
                found.push(run.start);
            } else {
                open.extend(cell.children().rev().filter(|child| direction.is_near_side(child.bits() & 7)));
            }
        }
        found
    }

    /// All leaves that share a point with leaf number `leaf`, ascending, itself left out.
    pub fn touching(&self, leaf: usize) -> Vec<usize> {
        let mut found: Vec<usize> = Direction::all().flat_map(|direction| self.neighbours(leaf, direction)).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The octree cut at `depth`: its cells in Morton order, each with the run of leaves that it stands for. Nothing is
    /// built; a search a cell.
    pub fn at_depth(&self, depth: u8) -> impl Iterator<Item = (Octant, Range<usize>)> + Clone + '_ {
        let mut next = 0;
        std::iter::from_fn(move || {
            let leaf = self.cells.get(next)?;
            let cell = leaf.ancestor(depth).unwrap_or(*leaf);
            let last = *cell.range().end();
            let run = next..next + self.cells[next..].partition_point(|leaf| leaf.start() <= last);
            next = run.end;
            Some((cell, run))
        })
    }

    /// The leaves that `ray` meets, in the order in which it enters them; see [`Cast`].
    pub fn cast(&self, ray: &Ray) -> Cast<'_> {
        Cast::new(self, ray)
    }
}
