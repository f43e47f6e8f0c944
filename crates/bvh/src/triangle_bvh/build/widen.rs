//! From a binary tree to one with eight children a node, with the least cost that any choice of its nodes has.
//!
//! Dynamic programming over the binary tree (Ylitie, Karras and Laine, "Efficient incoherent ray traversal on GPUs
//! through compressed wide BVHs", High Performance Graphics 2017, section 3.1): for each node the least cost of
//! standing for its triangles by a forest of at most 1, 2, … 8 trees. A node costs [`NODE_COST`] times its area, a pack
//! [`PACK_COST`] times its own; costs are compared to 2^-20 of their size. O(n); the new tree is no deeper than the
//! binary one. The forests are found as the binary tree is built, child by child, so threads share that work too.

use super::{
    super::{
        bounds::Bounds,
        layout::{Node, WIDTH},
    },
    binary::BinaryNode,
    tasks::for_each,
};

/// Of testing a ray against the boxes of a node, in any unit.
const NODE_COST: f32 = 1.0;
/// Of testing a ray against the triangles of a pack, in the same unit; both as measured.
const PACK_COST: f32 = 1.5;

/// Below so many triangles a part is not worth a thread.
const SERIAL: usize = 1 << 14;

/// The low bits of a cost tell how it is reached.
const SHARE_MASK: u32 = WIDTH as u32 - 1;

/// The least costs of a node's triangles, and how they are reached.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forest {
    /// Entry i: with at most i + 1 trees.
    costs: [f32; WIDTH],
    /// Entry i: with at most i + 1 trees.
    splits: [Split; WIDTH],
    /// Of the eight children where the node becomes a node; [`Split::NONE`] where it becomes a pack.
    children: Split,
}

/// So many trees, and how many of them the left child gets.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Split {
    trees: u8,
    left: u8,
}

impl Split {
    /// One tree: the node itself.
    const NONE: Self = Self { trees: 1, left: 0 };
}

impl Forest {
    /// Of a leaf.
    pub(super) fn of_pack(bounds: &Bounds) -> Self {
        let costs = [bounds.half_area() * PACK_COST; WIDTH];
        Self { costs, splits: [Split::NONE; WIDTH], children: Split::NONE }
    }

    /// Of a node over `count` triangles, from those of its children. Without branches, which no processor could
    /// foresee.
    #[inline]
    pub(super) fn join(bounds: &Bounds, count: u32, left: &Self, right: &Self) -> Self {
        let area = bounds.half_area();
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
        let as_pack = if count as usize <= WIDTH { area * PACK_COST } else { f32::INFINITY };
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
}

/// The wide tree over a binary one. `pack` tells the index of the pack that a binary node becomes, from its own index
/// and the node.
pub(super) fn widen(binary: &[BinaryNode], pack: &(impl Fn(u32, &BinaryNode) -> u32 + Sync)) -> Vec<Node> {
    let mut nodes = Vec::with_capacity(binary.len() / 5);
    Wide { binary, pack }.emit(0, &mut nodes);
    nodes
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

struct Wide<'a, P> {
    binary: &'a [BinaryNode],
    pack: &'a P,
}

impl<P: Fn(u32, &BinaryNode) -> u32 + Sync> Wide<'_, P> {
    /// Appends the wide node that stands for a binary one, and all below it; returns its index. The largest child comes
    /// first: it is the likeliest to end the search for any hit.
    fn emit(&self, index: u32, nodes: &mut Vec<Node>) -> u32 {
        let own = nodes.len();
        nodes.push(Node::EMPTY);
        let mut children = Children { nodes: [0; WIDTH], areas: [0.0; WIDTH], count: 0 };
        self.add_roots(index, self.binary[index as usize].forest.children, &mut children);
        let mut wide = Node::EMPTY;
        let mut subtrees = Vec::new();
        let is_large = cfg!(feature = "rayon") && self.binary[index as usize].count as usize > SERIAL;
        for (lane, &child) in children.nodes[..children.count].iter().enumerate() {
            let node = &self.binary[child as usize];
            for axis in 0..3 {
                wide.planes[axis][lane] = node.bounds.min(axis);
                wide.planes[axis + 3][lane] = node.bounds.max(axis);
            }
            if node.forest.children == Split::NONE {
                wide.leaves |= 1 << lane;
                wide.children[lane] = (self.pack)(child, node);
            } else if is_large {
                subtrees.push((lane, child, Vec::new()));
            } else {
                wide.children[lane] = self.emit(child, nodes);
            }
        }
        for_each(&mut subtrees, &|(_, child, nodes)| {
            self.emit(*child, nodes);
        });
        for (lane, _, subtree) in subtrees {
            wide.children[lane] = nodes.len() as u32;
            append(nodes, subtree);
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
                self.add_roots(left, self.binary[left as usize].forest.splits[split.left as usize - 1], roots);
                self.add_roots(right, self.binary[right as usize].forest.splits[trees as usize - 1], roots);
            }
            _ => roots.insert(index, node.bounds.half_area()),
        }
    }
}

/// Puts a subtree behind the nodes that are there.
fn append(nodes: &mut Vec<Node>, mut subtree: Vec<Node>) {
    let offset = nodes.len() as u32;
    for node in &mut subtree {
        for lane in 0..WIDTH {
            let is_inner = node.leaves >> lane & 1 == 0 && node.planes[0][lane] <= node.planes[3][lane];
            node.children[lane] += if is_inner { offset } else { 0 };
        }
    }
    nodes.append(&mut subtree);
}
