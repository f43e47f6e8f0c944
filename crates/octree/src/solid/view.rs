//! A solid's octree at a level of detail: the same list, read with a greatest depth.

use glam::DVec3;
use umbriel_geometry::Relation;

use super::SolidOctree;
use crate::morton::Octant;

/// An octree cut at a depth. A cell of that depth that is divided further says boundary: it holds boundary, or both
/// sides. Cells above that depth are leaves and say what they say.
#[derive(Clone, Copy, Debug)]
pub struct SolidView<'a> {
    tree: &'a SolidOctree,
    depth: u8,
}

impl<'a> SolidView<'a> {
    pub(super) fn new(tree: &'a SolidOctree, depth: u8) -> Self {
        Self { tree, depth }
    }

    /// The depth of the cut.
    pub fn depth(&self) -> u8 {
        self.depth
    }

    /// The cells in Morton order with what they say. A search a cell.
    pub fn leaves(&self) -> impl Iterator<Item = (Octant, Relation)> + 'a {
        let tree = self.tree;
        tree.partition.at_depth(self.depth).map(|(cell, run)| {
            let relation = if run.len() == 1 { tree.relations[run.start] } else { Relation::Boundary };
            (cell, relation)
        })
    }

    /// What the cell that holds `point` says; `None` outside the closed cube.
    pub fn relation_at(&self, point: DVec3) -> Option<Relation> {
        let cell = self.tree.partition.cube().octant_at(point, self.depth.min(Octant::MAX_LEVEL))?;
        Some(self.tree.relation_of(cell))
    }

    /// The view as an octree of its own. O(cells) searches.
    pub fn to_octree(&self) -> SolidOctree {
        SolidOctree::simplified(*self.tree.partition.cube(), self.leaves())
    }
}
