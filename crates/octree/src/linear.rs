//! A linear octree over items with boxes: a [`Partition`] of the cube, and the items of each leaf.
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
    cast::{Crossing, Ray},
    cube::{Cube, LatticeBox},
    morton::Octant,
    partition::{Gap, Partition},
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
    /// A region without extent, or one so far from the origin that no cube has float planes down to the depth.
    #[error("no cube around the region has cells of that depth with floats for corners")]
    NoCube,
    /// A cube whose lattice planes down to the depth are not all floats; see [`Cube::has_float_planes`].
    #[error("the cells of level {0} have corners that are no floats")]
    Lattice(u8),
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
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "crate::stored::StoredItems", into = "crate::stored::StoredItems")
)]
pub struct LinearOctree {
    partition: Partition,
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
        let mut leaves = Leaves::default();
        let mut open = vec![(Octant::ROOT, Vec::from_iter(names.filter(|&item| extent(item).is_some())))];
        while let Some((cell, items)) = open.pop() {
            let is_separable = || items.iter().any(|&item| extent(item).is_some_and(|extent| !extent.covers(cell)));
            if cell.level() == limits.max_level || items.len() <= limits.leaf_items || !is_separable() {
                leaves.push(cell, &items)?;
                continue;
            }
            // The first child ends on top, so leaves come in Morton order.
            for child in cell.children().rev() {
                let meets = |item: &u32| extent(*item).is_some_and(|extent| extent.meets(child));
                open.push((child, items.iter().copied().filter(meets).collect()));
            }
        }
        Ok(Self { partition: Partition::of_leaves(cube, leaves.cells), ends: leaves.ends, items: leaves.items })
    }

    /// The leaves without their items: point location, neighbours, runs, rays.
    pub fn partition(&self) -> &Partition {
        &self.partition
    }

    /// Takes leaves and items that are in order.
    #[cfg(feature = "serde")]
    pub(crate) fn of_items(partition: Partition, ends: Vec<u32>, items: Vec<u32>) -> Self {
        Self { partition, ends, items }
    }

    /// Where the items of each leaf end, and the items.
    #[cfg(feature = "serde")]
    pub(crate) fn into_items(self) -> (Vec<u32>, Vec<u32>) {
        (self.ends, self.items)
    }

    /// The cube that is divided.
    pub fn cube(&self) -> &Cube {
        self.partition.cube()
    }

    /// How many leaves.
    pub fn len(&self) -> usize {
        self.partition.cells().len()
    }

    /// Whether there are no leaves: never, the cube is one at least.
    pub fn is_empty(&self) -> bool {
        self.partition.cells().is_empty()
    }

    /// Leaf number `index` in Morton order; `None` beyond the last.
    pub fn leaf(&self, index: usize) -> Option<Leaf<'_>> {
        let (&cell, &end) = (self.partition.cells().get(index)?, self.ends.get(index)?);
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
        self.leaf(self.partition.leaf_at(point)?)
    }

    /// The leaves that `cell` divides into, in Morton order; or the one leaf that holds it.
    pub fn leaves_in(&self, cell: Octant) -> impl Iterator<Item = Leaf<'_>> {
        self.partition.run(cell).filter_map(|index| self.leaf(index))
    }

    /// The octree as it looks cut at `depth`: its cells in Morton order, each with the items that meet it, ascending.
    pub fn at_depth(&self, depth: u8) -> impl Iterator<Item = (Octant, Vec<u32>)> + '_ {
        self.partition.at_depth(depth).map(|(cell, run)| {
            let mut items =
                Vec::from_iter(run.filter_map(|index| self.leaf(index)).flat_map(|leaf| leaf.items).copied());
            items.sort_unstable();
            items.dedup();
            (cell, items)
        })
    }

    /// The leaves that `ray` meets, in the order in which it enters them ([`Partition::cast`]).
    pub fn cast(&self, ray: &Ray) -> impl Iterator<Item = (Crossing, Leaf<'_>)> {
        self.partition.cast(ray).filter_map(|crossing| Some((crossing, self.leaf(crossing.leaf)?)))
    }

    /// Whether this is a sound octree over `boxes`: for tests, and for programs that keep trees.
    ///
    /// O(leaves × boxes).
    ///
    /// # Errors
    /// The first [`OctreeDefect`] found.
    pub fn check(&self, boxes: &[Aabb]) -> Result<(), OctreeDefect> {
        self.partition.check().map_err(|Gap { leaf }| OctreeDefect::Gap { leaf })?;
        let extents: Vec<Option<LatticeBox>> = boxes.iter().map(|bounds| self.cube().lattice_box(bounds)).collect();
        for (index, leaf) in self.leaves().enumerate() {
            let met = (0u32..).zip(&extents).filter(|(_, extent)| extent.is_some_and(|extent| extent.meets(leaf.cell)));
            if !met.map(|(item, _)| item).eq(leaf.items.iter().copied()) {
                return Err(OctreeDefect::Items { leaf: index });
            }
        }
        Ok(())
    }

    /// The leaf with the most items, the first of equals: where a tree is too coarse.
    pub fn fullest_leaf(&self) -> Option<Leaf<'_>> {
        self.leaves().min_by_key(|leaf| Reverse(leaf.items.len()))
    }
}

/// The parts of an octree while it grows.
#[derive(Default)]
struct Leaves {
    cells: Vec<Octant>,
    ends: Vec<u32>,
    items: Vec<u32>,
}

impl Leaves {
    fn push(&mut self, cell: Octant, items: &[u32]) -> Result<(), BuildDefect> {
        self.cells.push(cell);
        self.items.extend_from_slice(items);
        self.ends.push(u32::try_from(self.items.len()).map_err(|_| BuildDefect::TooMany)?);
        Ok(())
    }
}
