//! From a binary tree to one with eight children a node, with the least cost that any choice of its nodes has.
//!
//! Dynamic programming over the binary tree (Ylitie, Karras and Laine, "Efficient incoherent ray traversal on GPUs
//! through compressed wide BVHs", High Performance Graphics 2017, section 3.1): for each node the least cost of
//! standing for its triangles by a forest of at most 1, 2, … 8 trees. A node costs [`NODE_COST`] times its area, a pack
//! [`PACK_COST`] times its own. O(n); the new tree is no deeper than the binary one.

use super::{
    super::layout::{Node, WIDTH},
    binary::BinaryNode,
};

/// Of testing a ray against the boxes of a node, in any unit.
const NODE_COST: f32 = 1.0;
/// Of testing a ray against the triangles of a pack, in the same unit; both as measured.
const PACK_COST: f32 = 1.5;

/// The least costs of a node's triangles, and how they are reached.
#[derive(Clone, Copy)]
struct Forest {
    /// Entry i: with at most i + 1 trees.
    costs: [f32; WIDTH],
    /// Entry i: how many of i + 1 trees the left child gets; 0 where fewer trees are as good.
    left_shares: [u8; WIDTH],
    /// Of the eight children, where the node becomes a node, the left child's; 0 where it becomes a pack.
    left_children: u8,
}

/// The nodes of the wide tree, and the packs as ranges of items, in the order in which a walk meets them.
pub(super) struct Wide {
    pub(super) nodes: Vec<Node>,
    pub(super) packs: Vec<(u32, u32)>,
}

/// The wide tree over a binary one.
pub(super) fn widen(binary: &[BinaryNode]) -> Wide {
    let forests = forests(binary);
    let mut wide = Wide { nodes: Vec::with_capacity(binary.len() / 5), packs: Vec::with_capacity(binary.len() / 2) };
    let collector = Collector { binary, forests: &forests };
    collector.emit(0, &mut wide);
    wide
}

/// Children come after parents, so the list is filled from its end.
fn forests(binary: &[BinaryNode]) -> Vec<Forest> {
    let nothing = Forest { costs: [f32::INFINITY; WIDTH], left_shares: [0; WIDTH], left_children: 0 };
    let mut forests = vec![nothing; binary.len()];
    for (index, node) in binary.iter().enumerate().rev() {
        let area = node.bounds.half_area();
        forests[index] = match node.right {
            None => Forest { costs: [area * PACK_COST; WIDTH], ..nothing },
            Some(right) => join(node, area, &forests[index + 1], &forests[right.get() as usize]),
        };
    }
    forests
}

fn join(node: &BinaryNode, area: f32, left: &Forest, right: &Forest) -> Forest {
    let (mut costs, mut left_shares) = ([f32::INFINITY; WIDTH], [0; WIDTH]);
    for trees in 2..=WIDTH {
        for share in 1..trees {
            let cost = left.costs[share - 1] + right.costs[trees - share - 1];
            if cost < costs[trees - 1] {
                (costs[trees - 1], left_shares[trees - 1]) = (cost, share as u8);
            }
        }
    }
    let as_node = area * NODE_COST + costs[WIDTH - 1];
    let as_pack = if node.count as usize <= WIDTH { area * PACK_COST } else { f32::INFINITY };
    let left_children = if as_pack <= as_node { 0 } else { left_shares[WIDTH - 1] };
    costs[0] = as_node.min(as_pack);
    for trees in 1..WIDTH {
        if costs[trees - 1] <= costs[trees] {
            (costs[trees], left_shares[trees]) = (costs[trees - 1], 0);
        }
    }
    Forest { costs, left_shares, left_children }
}

struct Collector<'a> {
    binary: &'a [BinaryNode],
    forests: &'a [Forest],
}

impl Collector<'_> {
    /// Appends the wide node that stands for a binary one, and all below it; returns its index.
    fn emit(&self, index: u32, wide: &mut Wide) -> u32 {
        let mut children = Vec::with_capacity(WIDTH);
        let share = self.forests[index as usize].left_children as usize;
        if share == 0 {
            children.push(index);
        } else {
            self.roots(index + 1, share, &mut children);
            self.roots(self.right_of(index), WIDTH - share, &mut children);
        }
        // The largest first: it is the likeliest to end the search for any hit.
        children.sort_by(|&a, &b| self.area(b).total_cmp(&self.area(a)));
        let own = wide.nodes.len();
        wide.nodes.push(Node::EMPTY);
        for (lane, &child) in children.iter().enumerate() {
            let BinaryNode { bounds, first, count, .. } = self.binary[child as usize];
            let is_leaf = self.forests[child as usize].left_children == 0;
            let leads_to = if is_leaf {
                wide.packs.push((first, count));
                wide.packs.len() as u32 - 1
            } else {
                self.emit(child, wide)
            };
            let node = &mut wide.nodes[own];
            node.children[lane] = leads_to;
            node.leaves |= u32::from(is_leaf) << lane;
            for axis in 0..3 {
                node.planes[axis][lane] = bounds.min(axis);
                node.planes[axis + 3][lane] = bounds.max(axis);
            }
        }
        own as u32
    }

    /// The roots of the best forest of at most `trees` trees.
    fn roots(&self, index: u32, trees: usize, roots: &mut Vec<u32>) {
        let forest = &self.forests[index as usize];
        let Some(trees) = (2..=trees).rev().find(|&trees| forest.left_shares[trees - 1] > 0) else {
            roots.push(index);
            return;
        };
        let share = forest.left_shares[trees - 1] as usize;
        self.roots(index + 1, share, roots);
        self.roots(self.right_of(index), trees - share, roots);
    }

    fn right_of(&self, index: u32) -> u32 {
        self.binary[index as usize].right.map_or(index, std::num::NonZeroU32::get)
    }

    fn area(&self, index: u32) -> f32 {
        self.binary[index as usize].bounds.half_area()
    }
}
