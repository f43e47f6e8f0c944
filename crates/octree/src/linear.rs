//! A linear octree: the leaves alone, sorted by Morton code (Gargantini, "An effective way to represent quadtrees",
//! Communications of the ACM 25(12), 1982, for the cube and with leaves of several levels).
//!
//! Built top-down from items with boxes: a cell is halved while more items meet it than a leaf may hold, down to a
//! greatest level. An item is listed in every leaf that its closed box meets; cells are closed and their bounds are the
//! exact lattice planes of [`Cube`], so neither end of that is rounded. The leaves divide the cube without gaps: those
//! that no item meets are there too.
//!
//! Point location is a binary search over the codes, O(log leaves); the leaves below a cell are one run of the list.
//! What breaks it: boxes as large as the cube are listed in every leaf. A cell whose items all cover it is not halved
//! further, since that could separate nothing.

use std::cmp::Reverse;

use glam::DVec3;
use umbriel_geometry::Aabb;

use crate::{
    cube::{Cube, LatticeBox},
    morton::Octant,
};

#[cfg(test)]
mod tests;

/// How far an octree is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// No leaf is deeper; at most [`Octant::MAX_LEVEL`].
    pub max_level: u8,
    /// A leaf above the greatest level holds no more items than this, or only items that cover it whole.
    pub leaf_items: usize,
}

/// Why an octree cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildDefect {
    /// A level that Morton codes of 64 bits cannot name.
    #[error("level {0} is deeper than 21")]
    TooDeep(u8),
    /// More items, or more places in leaves, than a `u32` can name.
    #[error("more than 2^32 - 1 items in leaves")]
    TooMany,
}

/// Why an octree is not one over the given boxes; see [`LinearOctree::check`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OctreeDefect {
    /// The leaf does not begin where the one before it ends, or the last does not end the cube.
    #[error("leaf {leaf} leaves a gap or overlaps")]
    Gap {
        /// Index of the leaf.
        leaf: usize,
    },
    /// The items of the leaf are not those that meet it.
    #[error("leaf {leaf} does not hold the items that meet it")]
    Items {
        /// Index of the leaf.
        leaf: usize,
    },
}

/// A leaf and the items that meet it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Leaf<'a> {
    /// Which part of the cube.
    pub cell: Octant,
    /// Indices of the items whose boxes meet it, ascending.
    pub items: &'a [u32],
}

/// The leaves of an octree in Morton order, without pointers.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearOctree {
    cube: Cube,
    leaves: Vec<Octant>,
    /// Where the items of each leaf end; they begin where those of the leaf before end.
    ends: Vec<u32>,
    items: Vec<u32>,
}

impl LinearOctree {
    /// Divides `cube` for the items with these boxes. Items that miss the cube are in no leaf.
    ///
    /// O(items in leaves × levels).
    ///
    /// # Errors
    /// [`BuildDefect`] for a level that is too deep, or too many items.
    pub fn build(cube: Cube, boxes: &[Aabb], limits: Limits) -> Result<Self, BuildDefect> {
        if limits.max_level > Octant::MAX_LEVEL {
            return Err(BuildDefect::TooDeep(limits.max_level));
        }
        let names = 0..u32::try_from(boxes.len()).map_err(|_| BuildDefect::TooMany)?;
        let extents: Vec<Option<LatticeBox>> = boxes.iter().map(|bounds| cube.lattice_box(bounds)).collect();
        let extent = |item: u32| extents[item as usize].as_ref();
        let mut tree = Self { cube, leaves: Vec::new(), ends: Vec::new(), items: Vec::new() };
        let mut open = vec![(Octant::ROOT, Vec::from_iter(names.filter(|&item| extent(item).is_some())))];
        while let Some((cell, items)) = open.pop() {
            let is_separable = || items.iter().any(|&item| extent(item).is_some_and(|extent| !extent.covers(cell)));
            if cell.level() == limits.max_level || items.len() <= limits.leaf_items || !is_separable() {
                tree.push(cell, &items)?;
                continue;
            }
            // The first child ends on top, so leaves come in Morton order.
            for child in cell.children().rev() {
                let meets = |item: &u32| extent(*item).is_some_and(|extent| extent.meets(child));
                open.push((child, items.iter().copied().filter(meets).collect()));
            }
        }
        Ok(tree)
    }

    fn push(&mut self, cell: Octant, items: &[u32]) -> Result<(), BuildDefect> {
        self.leaves.push(cell);
        self.items.extend_from_slice(items);
        self.ends.push(u32::try_from(self.items.len()).map_err(|_| BuildDefect::TooMany)?);
        Ok(())
    }

    /// The cube that is divided.
    pub fn cube(&self) -> &Cube {
        &self.cube
    }

    /// How many leaves.
    pub fn len(&self) -> usize {
        self.leaves.len()
    }

    /// Whether there are no leaves: never, the cube is one at least.
    pub fn is_empty(&self) -> bool {
        self.leaves.is_empty()
    }

    /// Leaf number `index` in Morton order; `None` beyond the last.
    pub fn leaf(&self, index: usize) -> Option<Leaf<'_>> {
        let (&cell, &end) = (self.leaves.get(index)?, self.ends.get(index)?);
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        Some(Leaf { cell, items: &self.items[start as usize..end as usize] })
    }

    /// All leaves in Morton order.
    pub fn leaves(&self) -> impl Iterator<Item = Leaf<'_>> {
        (0..self.len()).filter_map(|index| self.leaf(index))
    }

    /// The leaf that holds `point`; a point on a plane between cells belongs to the upper one. `None` outside the closed
    /// cube. Exact.
    pub fn leaf_at(&self, point: DVec3) -> Option<Leaf<'_>> {
        let cell = self.cube.octant_at(point, Octant::MAX_LEVEL)?;
        self.leaf(self.leaf_index(cell))
    }

    /// The leaves that `cell` divides into, in Morton order; or the one leaf that holds it.
    pub fn leaves_in(&self, cell: Octant) -> impl Iterator<Item = Leaf<'_>> {
        let end = self.leaves.partition_point(|leaf| leaf.range().start() <= cell.range().end());
        (self.leaf_index(cell)..end).filter_map(|index| self.leaf(index))
    }

    /// The leaf that holds the first corner of `cell`: the last one that does not begin behind it.
    fn leaf_index(&self, cell: Octant) -> usize {
        let start = *cell.range().start();
        self.leaves.partition_point(|leaf| *leaf.range().start() <= start).saturating_sub(1)
    }

    /// Whether this is a sound octree over `boxes`: for tests, and for programs that keep trees.
    ///
    /// O(leaves × boxes).
    ///
    /// # Errors
    /// The first [`OctreeDefect`] found.
    pub fn check(&self, boxes: &[Aabb]) -> Result<(), OctreeDefect> {
        let extents: Vec<Option<LatticeBox>> = boxes.iter().map(|bounds| self.cube.lattice_box(bounds)).collect();
        let mut next = Some(*Octant::ROOT.range().start());
        for (index, leaf) in self.leaves().enumerate() {
            if next != Some(*leaf.cell.range().start()) {
                return Err(OctreeDefect::Gap { leaf: index });
            }
            next = leaf.cell.range().end().checked_add(1);
            let met = (0u32..).zip(&extents).filter(|(_, extent)| extent.is_some_and(|extent| extent.meets(leaf.cell)));
            if !met.map(|(item, _)| item).eq(leaf.items.iter().copied()) {
                return Err(OctreeDefect::Items { leaf: index });
            }
        }
        let is_complete = next == Octant::ROOT.range().end().checked_add(1);
        if is_complete { Ok(()) } else { Err(OctreeDefect::Gap { leaf: self.len() }) }
    }

    /// The leaf with the most items, the first of equals: where a tree is too coarse.
    pub fn fullest_leaf(&self) -> Option<Leaf<'_>> {
        self.leaves().min_by_key(|leaf| Reverse(leaf.items.len()))
    }
}
