//! From a binary tree to one with eight children a node, with the least cost that any choice of its nodes has.
//!
//! Dynamic programming over the binary tree (Ylitie, Karras and Laine, "Efficient incoherent ray traversal on GPUs
//! through compressed wide BVHs", High Performance Graphics 2017, section 3.1): for each node the least cost of
//! standing for its triangles by a forest of at most 1, 2, … 8 trees. A node costs [`NODE_COST`] times its area, a pack
//! [`PACK_COST`] times its own; costs are compared to 2^-20 of their size. O(n); the new tree is no deeper than the binary
//! one.

use super::{
    super::layout::{Node, WIDTH},
    binary::BinaryNode,
};

/// Of testing a ray against the boxes of a node, in any unit.
const NODE_COST: f32 = 1.0;
/// Of testing a ray against the triangles of a pack, in the same unit; both as measured.
const PACK_COST: f32 = 1.5;

/// The low bits of a cost tell how it is reached.
const SHARE_MASK: u32 = WIDTH as u32 - 1;

/// The least costs of a node's triangles, and how they are reached.
#[derive(Clone, Copy)]
struct Forest {
    /// Entry i: with at most i + 1 trees.
    costs: [f32; WIDTH],
    /// Entry i: with at most i + 1 trees.
    splits: [Split; WIDTH],
    /// Of the eight children where the node becomes a node; [`Split::NONE`] where it becomes a pack.
    children: Split,
}

/// So many trees, and how many of them the left child gets.
#[derive(Clone, Copy, PartialEq)]
struct Split {
    trees: u8,
    left: u8,
}

impl Split {
    /// One tree: the node itself.
    const NONE: Self = Self { trees: 1, left: 0 };
}

/// The wide tree, made of nodes, and the binary nodes that become packs. `pack` gives each its index; it is asked in the order in which a walk
/// meets them.
pub(super) fn widen(binary: &[BinaryNode], mut pack: impl FnMut(&BinaryNode) -> u32) -> Vec<Node> {
    let forests = forests(binary);
    let mut nodes = Vec::with_capacity(binary.len() / 5);
    Wide { binary, forests: &forests }.emit(0, &mut nodes, &mut pack);
    nodes
}

/// Children come after parents, so the list is filled from its end.
fn forests(binary: &[BinaryNode]) -> Vec<Forest> {
    let nothing = Forest { costs: [0.0; WIDTH], splits: [Split::NONE; WIDTH], children: Split::NONE };
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

/// Without branches, which no processor could foresee.
#[inline(always)]
fn join(node: &BinaryNode, area: f32, left: &Forest, right: &Forest) -> Forest {
    let mut least = [f32::MAX; WIDTH];
    for share in 1..WIDTH {
        for trees in share + 1..=WIDTH {
            let cost = left.costs[share - 1] + right.costs[trees - share - 1];
            let cost = f32::from_bits(cost.to_bits() & !SHARE_MASK | share as u32);
            least[trees - 1] = if cost < least[trees - 1] { cost } else { least[trees - 1] };
        }
    }
    let split = |trees: usize| Split { trees: trees as u8, left: (least[trees - 1].to_bits() & SHARE_MASK) as u8 };
    let as_node = area * NODE_COST + least[WIDTH - 1];
    let as_pack = if node.count as usize <= WIDTH { area * PACK_COST } else { f32::INFINITY };
    let (mut cost, children) = if as_pack <= as_node { (as_pack, Split::NONE) } else { (as_node, split(WIDTH)) };
    let mut forest = Forest { costs: [cost; WIDTH], splits: [Split::NONE; WIDTH], children };
    for trees in 2..=WIDTH {
        let is_less = least[trees - 1] < cost;
        cost = if is_less { least[trees - 1] } else { cost };
        forest.costs[trees - 1] = cost;
        forest.splits[trees - 1] = if is_less { split(trees) } else { forest.splits[trees - 2] };
    }
    forest
}

/// Binary nodes, and their areas; the largest first.
struct Children {
    nodes: [u32; WIDTH],
    areas: [f32; WIDTH],
    count: usize,
}

impl Children {
    #[inline(always)]
    fn insert(&mut self, node: u32, area: f32) {
        let mut at = self.count;
        while at > 0 && self.areas[at - 1] < area {
            (self.nodes[at], self.areas[at]) = (self.nodes[at - 1], self.areas[at - 1]);
            at -= 1;
        }
        (self.nodes[at], self.areas[at]) = (node, area);
        self.count += 1;
    }
}

struct Wide<'a> {
    binary: &'a [BinaryNode],
    forests: &'a [Forest],
}

impl Wide<'_> {
    /// Appends the wide node that stands for a binary one, and all below it; returns its index. The largest child comes
    /// first: it is the likeliest to end the search for any hit.
    fn emit(&self, index: u32, nodes: &mut Vec<Node>, pack: &mut impl FnMut(&BinaryNode) -> u32) -> u32 {
        let own = nodes.len();
        nodes.push(Node::EMPTY);
        let mut children = Children { nodes: [0; WIDTH], areas: [0.0; WIDTH], count: 0 };
        self.add_roots(index, self.forests[index as usize].children, &mut children);
        let mut wide = Node::EMPTY;
        for (lane, &child) in children.nodes[..children.count].iter().enumerate() {
            let node = &self.binary[child as usize];
            let is_leaf = self.forests[child as usize].children == Split::NONE;
            wide.leaves |= u32::from(is_leaf) << lane;
            wide.children[lane] = if is_leaf { pack(node) } else { self.emit(child, nodes, pack) };
            for axis in 0..3 {
                wide.planes[axis][lane] = node.bounds.min(axis);
                wide.planes[axis + 3][lane] = node.bounds.max(axis);
            }
        }
        nodes[own] = wide;
        own as u32
    }

    /// The roots of the forest that a node is split into.
    fn add_roots(&self, index: u32, split: Split, roots: &mut Children) {
        let node = &self.binary[index as usize];
        match node.right {
            Some(right) if split != Split::NONE => {
                let (left, right, trees) = (index + 1, right.get(), split.trees - split.left);
                self.add_roots(left, self.forests[left as usize].splits[split.left as usize - 1], roots);
                self.add_roots(right, self.forests[right as usize].splits[trees as usize - 1], roots);
            }
            _ => roots.insert(index, node.bounds.half_area()),
        }
    }
}
