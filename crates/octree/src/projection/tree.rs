//! The compact octree parallel to the view plane: children that no triangle meets are left out.
//!
//! Leaves come in the recursive front-to-back order of octants seen from the viewpoint: at every cell the child on the
//! viewpoint's side first, the opposite one last. A ray from there crosses each middle plane once and away from it, so
//! the numbers of the leaves that it enters grow. (A ray inside a middle plane touches leaves on both sides of it; each side by
//! itself is in order, and what the ray hits is listed on both.)
//!
//! A leaf lists the triangles that meet its closed cell widened by [`Root::slack`], which is more than all roundings of
//! corners, rays and hits take: a point of a ray and a triangle that it hits there are in one leaf, whichever of the
//! leaves at a border the point is counted to. O(triangles in leaves × levels).

use std::cmp::Ordering;

use glam::DVec3;

use super::{
    budget::Budget,
    overlap,
    pack::{Pack, WIDTH},
    tasks::{self, SERIAL},
};
use crate::morton::{Octant, encode3};

/// Where a node leads: a node, or a leaf with [`LEAF`] added, or [`NOTHING`].
pub(super) type Link = u32;
pub(super) const NOTHING: Link = u32::MAX;
pub(super) const LEAF: Link = 1 << 31;

/// The cube that is divided, local coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Root {
    pub(super) min: DVec3,
    pub(super) edge: f64,
    /// By how much leaves reach beyond their cells; local coordinates.
    pub(super) slack: f64,
    /// The viewpoint in the cube's coordinates; below everything on all axes for parallel rays.
    pub(super) eye: DVec3,
}

/// How much larger than the error of a corner the slack is: 16 roundings of a corner's own, 24 of the overlap test, and as many
/// for each of a ray's places, a cell's planes and a hit's parameter, with room to spare.
const SLACK_OVER_ERROR: f64 = 256.0;

impl Root {
    /// A cube that holds all `corners`; `error` bounds what they are off by. `eye` is local.
    pub(super) fn around(corners: &[DVec3], error: f64, eye: Option<DVec3>) -> Self {
        // The least that a corner of size 1 is off by: of tiny errors, where all is near the viewpoint, the edge is no number.
        let slack = SLACK_OVER_ERROR * error.max(f64::EPSILON);
        let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = corners.iter().fold(empty, |(low, high), &p| (low.min(p), high.max(p)));
        let (low, high) = if corners.is_empty() { (DVec3::ZERO, DVec3::ZERO) } else { (low, high) };
        let min = low - 2.0 * slack;
        let edge = (high - low).max_element() + 4.0 * slack;
        let eye = eye.map_or(DVec3::NEG_INFINITY, |eye| (eye - min) / edge);
        Self { min, edge, slack, eye }
    }

    /// Which child of a cell is nearest to the viewpoint: bit k is set for the upper half on axis k.
    fn nearest_child(&self, cell: Octant) -> u8 {
        let scale = 0.5f64.powi(i32::from(cell.level()) + 1);
        let place = cell.coordinates();
        (0..3).fold(0, |bits, axis| {
            let middle = (2.0 * f64::from(place[axis]) + 1.0) * scale;
            bits | u8::from(self.eye[axis] >= middle) << axis
        })
    }
}

/// The least corner and the edge of a cell in the cube's coordinates, 0 to 1: multiples of 2^-21, exact.
pub(super) fn unit_cell(cell: Octant) -> ([f32; 3], f32) {
    let edge = 0.5f32.powi(i32::from(cell.level()));
    (cell.coordinates().map(|place| place as f32 * edge), edge)
}

/// Nodes, and leaves with their triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Tree {
    /// Children by octant; the root's link is in front.
    pub(super) nodes: Vec<[Link; 8]>,
    pub(super) root: Link,
    /// The leaves in the order of their numbers.
    pub(super) cells: Vec<Octant>,
    /// Where the triangles of each leaf end.
    pub(super) ends: Vec<u32>,
    pub(super) triangles: Vec<u32>,
}

/// Triangles of a leaf that are one pack.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) leaf: u32,
    /// Where they are in the list of all.
    start: u32,
    end: u32,
}

/// What divides a tree.
#[derive(Clone, Copy)]
pub(super) struct Grower<'a> {
    pub(super) root: &'a Root,
    /// Corners in the cube's coordinates.
    pub(super) corners: &'a [DVec3],
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) max_level: u8,
    pub(super) leaf_items: usize,
    /// For packs of leaves; once it is spent nothing is divided any more.
    pub(super) budget: &'a Budget,
}

impl Grower<'_> {
    /// The whole tree.
    pub(super) fn grow(&self) -> Tree {
        let all = (0..self.triangles.len() as u32).collect();
        self.subtree(Octant::ROOT, all)
    }

    /// The tree over a cell that a triangle meets, or the root. Children of large cells grow side by side.
    pub(super) fn subtree(&self, cell: Octant, items: Vec<u32>) -> Tree {
        let mut tree = Tree::default();
        if items.len() < SERIAL {
            tree.root = self.divide(&mut tree, cell, &mut Pile { items, children: Vec::new() }, 0);
            return tree;
        }
        let mut met = Vec::new();
        if self.budget.is_over() || !self.split(cell, &items, &mut met) {
            tree.root = self.push_leaf(&mut tree, cell, &items);
            return tree;
        }
        let parts = self.front_to_back(cell).map(|child| (child, held(child, &items, &met)));
        let parts = parts.filter(|(_, items)| !items.is_empty()).collect();
        tree.nodes.push([NOTHING; 8]);
        for (child, part) in tasks::map(parts, |(child, items)| (child, self.subtree(child, items))) {
            tree.nodes[0][number(child)] = tree.append(part);
        }
        tree
    }

    /// Puts what a cell divides into at the end of the tree; its triangles are those of the pile from `start` on.
    fn divide(&self, tree: &mut Tree, cell: Octant, pile: &mut Pile, start: usize) -> Link {
        let end = pile.items.len();
        if start == end {
            return NOTHING;
        }
        if self.budget.is_over() || !self.split(cell, &pile.items[start..], &mut pile.children) {
            return self.push_leaf(tree, cell, &pile.items[start..]);
        }
        let node = tree.nodes.len();
        tree.nodes.push([NOTHING; 8]);
        for child in self.front_to_back(cell) {
            for place in start..end {
                if pile.children[place] >> number(child) & 1 == 1 {
                    pile.items.push(pile.items[place]);
                }
            }
            tree.nodes[node][number(child)] = self.divide(tree, child, pile, end);
            pile.items.truncate(end);
            pile.children.truncate(end);
        }
        node as Link
    }

    fn push_leaf(&self, tree: &mut Tree, cell: Octant, items: &[u32]) -> Link {
        self.budget.spend(items.len().div_ceil(WIDTH) * size_of::<Pack>());
        if items.len() <= WIDTH {
            return tree.push_leaf(cell, items);
        }
        let mut items: Vec<(u64, u32)> = items.iter().map(|&item| (self.place(cell, item), item)).collect();
        items.sort_unstable();
        tree.push_leaf(cell, &items.into_iter().map(|(_, item)| item).collect::<Vec<_>>())
    }

    /// The Morton code of a triangle's middle within a cell, so that neighbours come to be in one pack.
    fn place(&self, cell: Octant, item: u32) -> u64 {
        let (min, edge) = unit_cell(cell);
        let [a, b, c] = self.triangles[item as usize].map(|corner| self.corners[corner as usize]);
        let middle = ((a + b + c) / 3.0 - DVec3::from_array(min.map(f64::from))) / f64::from(edge);
        encode3((middle * PLACES).clamp(DVec3::ZERO, DVec3::splat(PLACES - 1.0)).to_array().map(|x| x as u32))
    }

    /// Whether a cell is divided: it has many triangles, is not deep enough, and not all of them are in every child. If so, which children
    /// each triangle meets goes to the end of `children`, else what is there may be anything.
    pub(super) fn split(&self, cell: Octant, items: &[u32], children: &mut Vec<u8>) -> bool {
        let is_leaf = items.len() <= self.leaf_items || cell.level() >= self.max_level;
        if is_leaf {
            return false;
        }
        let first = children.len();
        self.children_met(cell, items, children);
        children[first..].iter().any(|&met| met != u8::MAX)
    }

    /// The children of a cell, the nearest to the viewpoint first.
    pub(super) fn front_to_back(&self, cell: Octant) -> impl Iterator<Item = Octant> + use<> {
        let nearest = self.root.nearest_child(cell);
        (0..8).filter_map(move |order| cell.child(order ^ nearest))
    }

    /// Puts which children of a cell each of its triangles meets at the end of a list, a bit a child.
    pub(super) fn children_met(&self, cell: Octant, items: &[u32], children: &mut Vec<u8>) {
        let (min, edge) = unit_cell(cell);
        let half = 0.5 * f64::from(edge);
        let middle = DVec3::from_array(min.map(f64::from)) + half;
        let slack = self.root.slack / self.root.edge;
        children.extend(items.iter().map(|&item| {
            let [a, b, c] = self.triangles[item as usize];
            let corners = [self.corners[a as usize], self.corners[b as usize], self.corners[c as usize]];
            overlap::children(&corners, middle, half, slack)
        }));
    }
}

/// Along a leaf's edge, to sort triangles by.
const PLACES: f64 = 1024.0;

/// The triangles of cells on the way down, those of a child behind its parent's, and which children they meet.
struct Pile {
    items: Vec<u32>,
    children: Vec<u8>,
}

/// Those of the triangles that meet a child.
pub(super) fn held(child: Octant, items: &[u32], met: &[u8]) -> Vec<u32> {
    let is_held = |(_, met): &(&u32, &u8)| **met >> number(child) & 1 == 1;
    items.iter().zip(met).filter(is_held).map(|(item, _)| *item).collect()
}

/// Which child of its parent a cell is.
pub(super) fn number(child: Octant) -> usize {
    (child.bits() & 7) as usize
}

impl Tree {
    pub(super) fn push_leaf(&mut self, cell: Octant, items: &[u32]) -> Link {
        let leaf = self.cells.len() as u32;
        self.cells.push(cell);
        self.triangles.extend_from_slice(items);
        self.ends.push(self.triangles.len() as u32);
        LEAF | leaf
    }

    /// Puts another tree behind this one; answers where its root is now.
    pub(super) fn append(&mut self, other: Self) -> Link {
        let (nodes, leaves, items) = (self.nodes.len() as u32, self.cells.len() as u32, self.triangles.len() as u32);
        let moved = |link: Link| match link {
            NOTHING => NOTHING,
            link if link & LEAF != 0 => link + leaves,
            link => link + nodes,
        };
        self.nodes.extend(other.nodes.into_iter().map(|links| links.map(moved)));
        self.cells.extend(other.cells);
        self.ends.extend(other.ends.into_iter().map(|end| end + items));
        self.triangles.extend(other.triangles);
        moved(other.root)
    }

    /// The packs of all leaves, in the leaves' order.
    pub(super) fn parts(&self) -> Vec<Part> {
        let starts = std::iter::once(&0).chain(&self.ends);
        let leaves = (0u32..).zip(starts.zip(&self.ends));
        let parts = leaves.flat_map(|(leaf, (&start, &end))| {
            (start..end).step_by(WIDTH).map(move |start| Part { leaf, start, end: end.min(start + WIDTH as u32) })
        });
        parts.collect()
    }

    /// The triangles of a part.
    pub(super) fn items_of(&self, part: &Part) -> &[u32] {
        &self.triangles[part.start as usize..part.end as usize]
    }

    /// The triangles of a leaf: ascending, or where they are several packs neighbours by neighbours.
    pub(super) fn items(&self, leaf: usize) -> &[u32] {
        let start = if leaf == 0 { 0 } else { self.ends[leaf - 1] };
        &self.triangles[start as usize..self.ends[leaf] as usize]
    }

    /// The level of the deepest leaf.
    pub(super) fn depth(&self) -> u8 {
        self.cells.iter().map(|cell| cell.level()).max().unwrap_or(0)
    }
}

/// The source's order of leaves on a face: by the depth of their upper faces, then by the distance from the leaf nearest to
/// the viewpoint's foot, the deeper leaf first of equals.
pub(super) fn by_sections(a: &SectionKey, b: &SectionKey) -> Ordering {
    a.near.total_cmp(&b.near).then(a.aside.total_cmp(&b.aside)).then(b.level.cmp(&a.level)).then(a.pack.cmp(&b.pack))
}

/// What the source's order looks at.
#[derive(Clone, Copy, Debug)]
pub(super) struct SectionKey {
    /// Depth of the upper face, local.
    pub(super) near: f64,
    /// How far aside of the viewpoint's foot the middle of the upper face lies.
    pub(super) aside: f64,
    pub(super) level: u8,
    pub(super) pack: u32,
}
