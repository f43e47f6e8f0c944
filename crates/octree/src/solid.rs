//! A solid as a linear octree: cells inside, outside, and on the boundary.
//!
//! Built top-down over any [`Region`]: a cell that no part of the surface meets is a leaf, others are halved down to a
//! depth, and each cell is asked only about the parts that meet its parent. Leaves off the surface that share a face are
//! on the same side of it (no surface is in either of the two closed cells, nor between them), so the region is asked
//! about one point of each connected set of them. All decisions are the region's, on boxes whose corners are floats
//! exactly ([`Cube::has_float_planes`]): nothing is rounded.
//!
//! The octree is kept in its simplest form: eight siblings that are all inside, or all outside, are one leaf. So a cell
//! that is divided has boundary in it, or both sides, and what a coarser cell says needs one search. Set operations walk
//! two sorted lists side by side (Gargantini, "Linear octtrees for fast processing of three-dimensional objects",
//! Computer Graphics and Image Processing 20(4), 1982). In their results a boundary cell is one that is not known to be
//! inside or outside: two boxes side by side keep the cells of their common face.

use glam::DVec3;
use umbriel_geometry::{Region, Relation};

use crate::{
    cast::{Crossing, Ray},
    cube::Cube,
    linear::BuildDefect,
    morton::Octant,
    partition::Partition,
};

mod build;
mod view;
mod volume;

pub use view::SolidView;
pub use volume::VolumeBounds;

/// Two octrees over different cubes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the octrees divide different cubes")]
pub struct CubesDiffer;

/// The leaves of a solid's octree in Morton order, each inside, outside or on the boundary.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "crate::stored::Stored", into = "crate::stored::Stored")
)]
pub struct SolidOctree {
    partition: Partition,
    relations: Vec<Relation>,
}

impl SolidOctree {
    /// The octree of `region` down to level `depth`, over a cube around it ([`Cube::on_grid`]).
    ///
    /// O(boundary cells · parts in each); one question of [`Region::encloses`] for each connected set of other cells.
    ///
    /// # Errors
    /// [`BuildDefect::TooDeep`]; [`BuildDefect::NoCube`] for a region without extent, or one so far from the origin that
    /// floats are too coarse for cells of that depth.
    pub fn build<R: Region + ?Sized>(region: &R, depth: u8) -> Result<Self, BuildDefect> {
        if depth > Octant::MAX_LEVEL {
            return Err(BuildDefect::TooDeep(depth));
        }
        let cube = Cube::on_grid(&region.bounds(), depth).ok_or(BuildDefect::NoCube)?;
        Self::build_in(cube, region, depth)
    }

    /// The octree of the part of `region` in `cube`, down to level `depth`; for octrees that are to be combined.
    ///
    /// # Errors
    /// [`BuildDefect::TooDeep`]; [`BuildDefect::Lattice`] unless [`Cube::has_float_planes`].
    pub fn build_in<R: Region + ?Sized>(cube: Cube, region: &R, depth: u8) -> Result<Self, BuildDefect> {
        build::build_in(cube, region, depth)
    }

    /// Puts leaves that divide the cube into the simplest form.
    fn simplified(cube: Cube, leaves: impl Iterator<Item = (Octant, Relation)>) -> Self {
        let (mut cells, mut relations) = (Vec::new(), Vec::new());
        for (cell, relation) in leaves {
            let mut last = cell;
            cells.push(last);
            relations.push(relation);
            while let Some(parent) = joined(&cells, &relations) {
                last = parent;
                cells.truncate(cells.len() - 8);
                relations.truncate(relations.len() - 8);
                cells.push(last);
                relations.push(relation);
            }
        }
        Self { partition: Partition::of_leaves(cube, cells), relations }
    }

    /// Takes leaves that divide the cube and are in the simplest form already.
    #[cfg(feature = "serde")]
    pub(crate) fn of_leaves(partition: Partition, relations: Vec<Relation>) -> Option<Self> {
        let is_whole = partition.cells().len() == relations.len();
        let is_simple = (1..=relations.len()).all(|end| joined(&partition.cells()[..end], &relations[..end]).is_none());
        (is_whole && is_simple).then_some(Self { partition, relations })
    }

    /// The leaves without what they say: point location, neighbours, runs, rays.
    pub fn partition(&self) -> &Partition {
        &self.partition
    }

    /// What each leaf says, in Morton order.
    pub fn relations(&self) -> &[Relation] {
        &self.relations
    }

    /// All leaves in Morton order.
    pub fn leaves(&self) -> impl ExactSizeIterator<Item = (Octant, Relation)> + '_ {
        self.partition.cells().iter().copied().zip(self.relations.iter().copied())
    }

    /// The leaves that say `relation`, in Morton order.
    pub fn leaves_that_are(&self, relation: Relation) -> impl Iterator<Item = Octant> + '_ {
        self.leaves().filter(move |(_, said)| *said == relation).map(|(cell, _)| cell)
    }

    /// What the leaf that holds `point` says; `None` outside the closed cube. One search.
    pub fn relation_at(&self, point: DVec3) -> Option<Relation> {
        self.partition.leaf_at(point).map(|leaf| self.relations[leaf])
    }

    /// What is known of a cell: what its leaf says, or boundary where it is divided. One search.
    pub fn relation_of(&self, cell: Octant) -> Relation {
        let run = self.partition.run(cell);
        if run.len() == 1 { self.relations[run.start] } else { Relation::Boundary }
    }

    /// The octree as it looks cut at `depth`: nothing is built.
    pub fn at_depth(&self, depth: u8) -> SolidView<'_> {
        SolidView::new(self, depth)
    }

    /// The leaves that `ray` meets and what they say, in the order in which it enters them ([`Partition::cast`]).
    pub fn cast(&self, ray: &Ray) -> impl Iterator<Item = (Crossing, Relation)> + '_ {
        self.partition.cast(ray).map(|crossing| (crossing, self.relations[crossing.leaf]))
    }

    /// Bounds of the solid's volume in the cube, cubic metres, rounded outward: the leaves inside, and those with the
    /// boundary ones.
    pub fn volume(&self) -> VolumeBounds {
        VolumeBounds::of(self)
    }

    /// What is in either. O(leaves of both).
    ///
    /// # Errors
    /// [`CubesDiffer`].
    pub fn union(&self, other: &Self) -> Result<Self, CubesDiffer> {
        self.combined(other, Ord::max)
    }

    /// What is in both. O(leaves of both).
    ///
    /// # Errors
    /// [`CubesDiffer`].
    pub fn intersection(&self, other: &Self) -> Result<Self, CubesDiffer> {
        self.combined(other, Ord::min)
    }

    /// What is in this one and not in `other`. O(leaves of both).
    ///
    /// # Errors
    /// [`CubesDiffer`].
    pub fn difference(&self, other: &Self) -> Result<Self, CubesDiffer> {
        self.combined(other, |own, other| own.min(opposite(other)))
    }

    /// What is in the cube and not in this one. O(leaves).
    #[must_use]
    pub fn complement(&self) -> Self {
        let relations = self.relations.iter().map(|&relation| opposite(relation)).collect();
        Self { partition: self.partition.clone(), relations }
    }

    /// The octree whose leaves are the finer ones of both, each saying what `rule` makes of what the two say there.
    fn combined(&self, other: &Self, rule: fn(Relation, Relation) -> Relation) -> Result<Self, CubesDiffer> {
        if self.partition.cube() != other.partition.cube() {
            return Err(CubesDiffer);
        }
        let (own, others) = (self.partition.cells(), other.partition.cells());
        let (mut i, mut j) = (0, 0);
        let leaves = std::iter::from_fn(|| {
            let (a, b) = (*own.get(i)?, *others.get(j)?);
            let leaf = (if a.level() >= b.level() { a } else { b }, rule(self.relations[i], other.relations[j]));
            let ends = (*a.range().end(), *b.range().end());
            i += usize::from(ends.0 <= ends.1);
            j += usize::from(ends.1 <= ends.0);
            Some(leaf)
        });
        Ok(Self::simplified(*self.partition.cube(), leaves))
    }
}

/// Inside and outside change places.
fn opposite(relation: Relation) -> Relation {
    match relation {
        Relation::Inside => Relation::Outside,
        Relation::Boundary => Relation::Boundary,
        Relation::Outside => Relation::Inside,
    }
}

/// The parent of the last eight leaves where they are siblings that agree and are no boundary.
fn joined(cells: &[Octant], relations: &[Relation]) -> Option<Octant> {
    let first = cells.len().checked_sub(8)?;
    let (parent, relation) = (cells.last()?.parent()?, *relations.last()?);
    // Eight leaves from a first child to a last one: none of those between can be finer.
    let are_siblings = parent.child(0) == Some(cells[first]) && parent.child(7) == cells.last().copied();
    let agree = relation != Relation::Boundary && relations[first..].iter().all(|said| *said == relation);
    (are_siblings && agree).then_some(parent)
}
