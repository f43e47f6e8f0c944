//! A static binary tree over boxes.
//!
//! Built top-down with the surface-area heuristic over bins (Wald, "On fast construction of SAH-based bounding volume
//! hierarchies", IEEE Symposium on Interactive Ray Tracing 2007), nodes in one flat array, the two children of a node
//! side by side. Guarantee: a query visits exactly the boxes that a loop over all of them would, each once; only the
//! order of the visits depends on the tree. Build O(n log n); the depth is bounded ([`MAX_DEPTH`]), so traversals run
//! on a stack of fixed size. What breaks it: nothing in range; boxes that all overlap make it a slow list.

mod build;
mod meetings;
#[cfg(test)]
mod tests;

pub use meetings::NodePair;
use std::ops::ControlFlow;

use umbriel_geometry::Aabb;

use crate::{
    ray::Ray,
    shaft::{Segment, Shaft},
};

/// Most nodes on a way from the root to a leaf, see `build`.
const MAX_DEPTH: usize = 80;

/// A traversal takes one node from its stack and puts back at most two, one level further down.
const STACK: usize = MAX_DEPTH + 1;

// | bounds.min: 3 × f64 | bounds.max: 3 × f64 | first: u32 | count: u32 | padding |   64 bytes, one cache line
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Node {
    bounds: Aabb,
    /// Leaf: its first item, in leaf order. Inner node: its left child; the right child follows.
    first: u32,
    /// Leaf: how many items. Inner node: 0.
    count: u32,
}

const _: () = assert!(size_of::<Node>() == 64);

/// Why a tree is not one over the given boxes; see [`BoxTree::check`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TreeDefect {
    /// Built over another number of boxes.
    #[error("the tree is over {tree} boxes, not {given}")]
    Length {
        /// Boxes it was built over.
        tree: usize,
        /// Boxes given.
        given: usize,
    },
    /// A node that no node, or more than one, leads to, or that leads nowhere.
    #[error("node {node} is not reached exactly once")]
    Node {
        /// Index of the node.
        node: usize,
    },
    /// A node whose box is not the smallest around what it holds.
    #[error("node {node} has a box that is not the smallest around its content")]
    Bounds {
        /// Index of the node.
        node: usize,
    },
    /// A box that is missing, there twice, or not the one given.
    #[error("box {item} is missing, there twice, or another")]
    Item {
        /// Index of the box.
        item: usize,
    },
    /// A leaf deeper than the traversal stack allows.
    #[error("node {node} lies too deep")]
    Depth {
        /// Index of the node.
        node: usize,
    },
}

/// A static tree over boxes; items are named by their index in the list it was built from.
#[derive(Clone, Debug)]
pub struct BoxTree {
    nodes: Vec<Node>,
    /// Item boxes in leaf order.
    boxes: Vec<Aabb>,
    /// Item indices in leaf order.
    ids: Vec<u32>,
    /// How many boxes it was built from, empty ones included.
    len: usize,
}

impl BoxTree {
    /// Builds the tree over `boxes`. Empty boxes meet nothing and are left out of it.
    ///
    /// The tree depends on the boxes alone, not on their order, up to the order of equal boxes. O(n log n).
    ///
    /// # Panics
    /// For 2^32 boxes or more (200 GB of them): an item's name is a `u32`.
    pub fn build(boxes: &[Aabb]) -> Self {
        build::build(boxes, &|| true).expect("it goes on")
    }

    /// As [`BoxTree::build`] as long as `goes_on`, which is asked whenever some ten thousand boxes have been looked at; `None` if it did not.
    ///
    /// # Panics
    /// As [`BoxTree::build`].
    pub fn build_while(boxes: &[Aabb], goes_on: &dyn Fn() -> bool) -> Option<Self> {
        build::build(boxes, goes_on)
    }

    /// The smallest box around all boxes.
    pub fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, |root| root.bounds)
    }

    /// How many boxes the tree was built from, empty ones included.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the tree was built from no boxes.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Visits every item whose closed box meets the closed box `query`, in no particular order.
    ///
    /// Cost, as of all visits: O(k log n) for k items visited where boxes overlap little, O(n) at worst; no memory.
    #[inline]
    pub fn for_each_meeting(&self, query: &Aabb, mut visit: impl FnMut(u32)) {
        let _ = self.for_each_where(
            |bounds| bounds.meets(query),
            |item| {
                visit(item);
                ControlFlow::Continue(())
            },
        );
    }

    /// Visits the items whose closed boxes may meet the open segment, in no particular order, until `visit` breaks.
    /// Never leaves out one that does ([`Shaft::may_meet`]); returns what `visit` last returned.
    #[inline]
    pub fn for_each_along(&self, segment: &Segment, visit: impl FnMut(u32) -> ControlFlow<()>) -> ControlFlow<()> {
        self.for_each_in_shaft(&segment.shaft(), visit)
    }

    /// Visits the items whose closed boxes may meet the shaft, in no particular order, until `visit` breaks.
    /// Never leaves out one that does ([`Shaft::may_meet`]); returns what `visit` last returned.
    #[inline]
    pub fn for_each_in_shaft(&self, shaft: &Shaft, visit: impl FnMut(u32) -> ControlFlow<()>) -> ControlFlow<()> {
        self.for_each_where(|bounds| shaft.may_meet(bounds), visit)
    }

    /// Visits the items whose boxes `may_hold` accepts, in no particular order, until `visit` breaks.
    ///
    /// `may_hold` must be monotone: when it accepts a box it must accept every box around it; otherwise items are
    /// left out.
    #[inline]
    pub fn for_each_where(
        &self,
        mut may_hold: impl FnMut(&Aabb) -> bool,
        mut visit: impl FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut stack = [0u32; STACK];
        let mut height = usize::from(self.nodes.first().is_some_and(|root| may_hold(&root.bounds)));
        while height > 0 {
            height -= 1;
            let node = &self.nodes[stack[height] as usize];
            if node.count > 0 {
                for (item, bounds) in self.items_of(node) {
                    if may_hold(bounds) {
                        visit(item)?;
                    }
                }
                continue;
            }
            // The left child ends on top, so leaves come in their order.
            for child in [node.first + 1, node.first] {
                if may_hold(&self.nodes[child as usize].bounds) {
                    stack[height] = child;
                    height += 1;
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Visits the items along `ray` up to the parameter `t_max`, near boxes first. `visit` gets an item and the
    /// parameters between which the ray is in its box, and returns the new `t_max`: a hit shortens the ray.
    ///
    /// An item is left out only when the ray misses its box or enters it strictly behind the `t_max` of that moment,
    /// so hits at equal parameters are all visited.
    pub fn for_each_near(&self, ray: &Ray, t_max: f64, visit: impl FnMut(u32, (f64, f64), f64) -> f64) {
        self.for_each_entered(|bounds| ray.span(bounds), t_max, visit);
    }

    /// As [`BoxTree::for_each_near`] for anything that enters boxes, several rays at once for instance: `enter` tells at what parameter, and
    /// something else that `visit` is to know; `None` where the box is missed.
    ///
    /// `enter` must be monotone: what it enters it enters no later with a larger box; otherwise items are left out.
    pub fn for_each_entered<T>(
        &self,
        enter: impl Fn(&Aabb) -> Option<(f64, T)>,
        mut t_max: f64,
        mut visit: impl FnMut(u32, (f64, T), f64) -> f64,
    ) {
        let entry = |index: u32| enter(&self.nodes[index as usize].bounds).map(|(entry, _)| (entry, index));
        let mut stack = [(0.0, 0u32); STACK];
        let mut height = 0;
        if !self.nodes.is_empty() {
            push(&mut stack, &mut height, entry(0));
        }
        while height > 0 {
            height -= 1;
            let (entered, index) = stack[height];
            let node = &self.nodes[index as usize];
            if entered > t_max {
                continue;
            }
            if node.count > 0 {
                for (item, bounds) in self.items_of(node) {
                    if let Some(entered) = enter(bounds).filter(|entered| entered.0 <= t_max) {
                        t_max = visit(item, entered, t_max);
                    }
                }
                continue;
            }
            let (left, right) = (entry(node.first), entry(node.first + 1));
            let left_is_nearer = left.zip(right).is_none_or(|(left, right)| left.0 <= right.0);
            let (near, far) = if left_is_nearer { (left, right) } else { (right, left) };
            push(&mut stack, &mut height, far);
            push(&mut stack, &mut height, near);
        }
    }

    /// The shape of the tree, root first; children come after their parent.
    pub(crate) fn shape(&self) -> impl DoubleEndedIterator<Item = Shape<'_>> + ExactSizeIterator {
        self.nodes.iter().map(|node| match (node.first as usize, node.count as usize) {
            (left, 0) => Shape::Inner([left, left + 1]),
            (first, count) => Shape::Leaf(&self.ids[first..first + count]),
        })
    }

    /// The items of a leaf with their boxes.
    #[inline]
    fn items_of(&self, leaf: &Node) -> impl Iterator<Item = (u32, &Aabb)> {
        let range = leaf.first as usize..(leaf.first + leaf.count) as usize;
        self.ids[range.clone()].iter().copied().zip(&self.boxes[range])
    }

    /// Whether this is a sound tree over `boxes`: for tests, and for programs that keep trees. O(n).
    ///
    /// # Errors
    /// The first [`TreeDefect`] found.
    pub fn check(&self, boxes: &[Aabb]) -> Result<(), TreeDefect> {
        if self.len != boxes.len() {
            return Err(TreeDefect::Length { tree: self.len, given: boxes.len() });
        }
        let mut seen = vec![false; boxes.len()];
        self.check_nodes(|item, bounds| match boxes.get(item as usize) {
            Some(given) if given == bounds && !seen[item as usize] => {
                seen[item as usize] = true;
                true
            }
            _ => false,
        })?;
        match (0..boxes.len()).find(|&item| seen[item] == boxes[item].is_empty()) {
            Some(item) => Err(TreeDefect::Item { item }),
            None => Ok(()),
        }
    }

    /// Walks all nodes; `is_item` says whether an item and its box are as expected.
    fn check_nodes(&self, mut is_item: impl FnMut(u32, &Aabb) -> bool) -> Result<(), TreeDefect> {
        let mut reached = vec![false; self.nodes.len()];
        let mut stack = Vec::from_iter((!self.nodes.is_empty()).then_some((0usize, 1)));
        while let Some((index, depth)) = stack.pop() {
            match reached.get_mut(index) {
                Some(mark) if !*mark => *mark = true,
                _ => return Err(TreeDefect::Node { node: index }),
            }
            let node = &self.nodes[index];
            if depth > MAX_DEPTH {
                return Err(TreeDefect::Depth { node: index });
            }
            let content = if node.count > 0 {
                let end = node.first as usize + node.count as usize;
                if end > self.ids.len() || self.boxes.len() != self.ids.len() {
                    return Err(TreeDefect::Node { node: index });
                }
                if let Some((item, _)) = self.items_of(node).find(|&(item, bounds)| !is_item(item, bounds)) {
                    return Err(TreeDefect::Item { item: item as usize });
                }
                self.items_of(node).fold(Aabb::EMPTY, |sum, (_, bounds)| sum.union(*bounds))
            } else {
                let left = node.first as usize;
                if left + 1 >= self.nodes.len() {
                    return Err(TreeDefect::Node { node: index });
                }
                stack.extend([(left, depth + 1), (left + 1, depth + 1)]);
                self.nodes[left].bounds.union(self.nodes[left + 1].bounds)
            };
            if content != node.bounds {
                return Err(TreeDefect::Bounds { node: index });
            }
        }
        match reached.iter().position(|&mark| !mark) {
            Some(node) => Err(TreeDefect::Node { node }),
            None => Ok(()),
        }
    }
}

/// What a node of the tree holds.
pub(crate) enum Shape<'a> {
    /// These items.
    Leaf(&'a [u32]),
    /// These nodes.
    Inner([usize; 2]),
}

/// Puts an entered node on the stack.
#[inline]
fn push(stack: &mut [(f64, u32); STACK], height: &mut usize, entry: Option<(f64, u32)>) {
    if let Some(entry) = entry {
        stack[*height] = entry;
        *height += 1;
    }
}
