//! All pairs of items of one tree whose boxes meet, each once.
//!
//! Both nodes of a pair are walked down together, the larger one first, so that what two neighbours have in common is looked at once, not again for each item. Work comes in parts
//! that threads may share. Cost: some tens of nanoseconds a pair where boxes overlap little.

use std::ops::ControlFlow;

use super::{BoxTree, Node};

/// Two nodes whose items may meet, or one that is paired with itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodePair {
    first: u32,
    second: u32,
}

impl BoxTree {
    /// Parts that together hold all pairs of items that meet: at least so many, unless the tree has fewer.
    pub fn meeting_parts(&self, least: usize) -> Vec<NodePair> {
        let mut parts = Vec::from_iter((!self.nodes.is_empty()).then_some(NodePair { first: 0, second: 0 }));
        while parts.len() < least && parts.iter().any(|&part| !self.are_leaves(part)) {
            let mut divided = Vec::new();
            for part in parts {
                if self.are_leaves(part) {
                    divided.push(part);
                } else {
                    self.divide(part, |part| divided.push(part));
                }
            }
            parts = divided;
        }
        parts
    }

    /// Visits the pairs of items of a part whose closed boxes meet, in no particular order, until `visit` breaks; returns what it last returned.
    ///
    /// # Panics
    /// If the part is of another tree.
    pub fn for_each_meeting_pair(
        &self,
        part: NodePair,
        mut visit: impl FnMut(u32, u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut stack = vec![part];
        while let Some(part) = stack.pop() {
            if self.are_leaves(part) {
                self.pair_items(part, &mut visit)?;
            } else {
                self.divide(part, |part| stack.push(part));
            }
        }
        ControlFlow::Continue(())
    }

    fn pair(&self, NodePair { first, second }: NodePair) -> [&Node; 2] {
        [first, second].map(|node| &self.nodes[node as usize])
    }

    fn are_leaves(&self, part: NodePair) -> bool {
        self.pair(part).iter().all(|node| node.count > 0)
    }

    /// The parts of a part, where these are not two leaves.
    fn divide(&self, part: NodePair, mut push: impl FnMut(NodePair)) {
        let [a, b] = self.pair(part);
        if part.first == part.second {
            let [left, right] = [a.first, a.first + 1];
            push(NodePair { first: left, second: left });
            push(NodePair { first: right, second: right });
            self.push_if_they_meet(left, right, &mut push);
            return;
        }
        let is_first = b.count > 0 || a.count == 0 && a.bounds.half_area() >= b.bounds.half_area();
        let (divided, other) = if is_first { (a, part.second) } else { (b, part.first) };
        self.push_if_they_meet(divided.first, other, &mut push);
        self.push_if_they_meet(divided.first + 1, other, &mut push);
    }

    fn push_if_they_meet(&self, first: u32, second: u32, push: &mut impl FnMut(NodePair)) {
        let part = NodePair { first, second };
        let [a, b] = self.pair(part);
        if a.bounds.meets(&b.bounds) {
            push(part);
        }
    }

    /// The items of two leaves, or of one.
    fn pair_items(&self, part: NodePair, visit: &mut impl FnMut(u32, u32) -> ControlFlow<()>) -> ControlFlow<()> {
        let [a, b] = self.pair(part);
        let is_one = part.first == part.second;
        for (index, (item, bounds)) in self.items_of(a).enumerate() {
            for (other, other_bounds) in self.items_of(b).skip(if is_one { index + 1 } else { 0 }) {
                if bounds.meets(other_bounds) {
                    visit(item, other)?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}
