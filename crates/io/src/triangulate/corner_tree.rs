//! Corners of a polygon in a tree of boxes: which of them may lie in a triangle. Corners can be taken out.
//!
//! A balanced tree over medians (Bentley, "Multidimensional binary search trees", 1975), laid out as a heap. A box is
//! passed over when one of the triangle's sides has all of it strictly outside, an exact sign; so nothing that lies in
//! the closed triangle is missed, and long thin triangles cost little more than short ones. O(n log n) to build, about
//! O(log n) a search where corners lie on a border, up to O(√n) where they are strewn; O(log n) to take a corner out.

use std::cell::Cell;

use robust::{Coord, orient2d};

/// Corners in a leaf at most.
const LEAF: usize = 8;

/// The corners, by their places in the polygon.
pub(super) struct CornerTree {
    /// Grouped by leaf.
    corners: Vec<usize>,
    /// A heap: the root is 1, the children of i are 2i and 2i + 1; the last half are the leaves.
    nodes: Vec<Node>,
    /// The leaf of each corner of the polygon; 0 for those that are not in the tree.
    leaf_of: Vec<usize>,
}

#[derive(Clone, Copy)]
struct Node {
    low: Coord<f64>,
    high: Coord<f64>,
    /// How many corners below are still in the tree.
    count: usize,
}

impl CornerTree {
    /// A tree of some corners of a polygon that stand `at` these places.
    pub(super) fn new(at: &[Coord<f64>], corners: Vec<usize>) -> Self {
        let leaves = corners.len().div_ceil(LEAF).next_power_of_two();
        let nothing = Coord { x: f64::INFINITY, y: f64::INFINITY };
        let empty = Node { low: nothing, high: Coord { x: -nothing.x, y: -nothing.y }, count: 0 };
        let mut tree = Self { corners, nodes: vec![empty; 2 * leaves], leaf_of: vec![0; at.len()] };
        for node in 1..2 * leaves {
            let range = tree.range(node);
            let bounds = tree.corners[range.clone()].iter().fold(empty, |bounds, &corner| bounds.with(at[corner]));
            tree.nodes[node] = bounds;
            if node < leaves {
                let middle = tree.range(2 * node).len();
                let along_x = bounds.high.x - bounds.low.x > bounds.high.y - bounds.low.y;
                let key = |corner: usize| if along_x { at[corner].x } else { at[corner].y };
                if middle < range.len() {
                    tree.corners[range].select_nth_unstable_by(middle, |&a, &b| key(a).total_cmp(&key(b)));
                }
            } else {
                tree.corners[range].iter().for_each(|&corner| tree.leaf_of[corner] = node);
            }
        }
        tree
    }

    /// The corners below a node: an equal share on every level.
    fn range(&self, node: usize) -> std::ops::Range<usize> {
        let level = node.ilog2();
        let share = |part: usize| (self.corners.len() * part) >> level;
        let part = node - (1 << level);
        share(part)..share(part + 1)
    }

    /// Takes a corner out; does nothing when it is not there.
    pub(super) fn remove(&mut self, corner: usize) {
        let mut node = std::mem::take(&mut self.leaf_of[corner]);
        while node > 0 {
            self.nodes[node].count -= 1;
            node /= 2;
        }
    }

    /// Whether `test` holds for a corner in the closed triangle (counter-clockwise). It is asked about all of these,
    /// until it says yes, and about some others. Boxes looked at are added to `work`.
    pub(super) fn any(
        &self,
        triangle: [Coord<f64>; 3],
        work: &Cell<usize>,
        mut test: impl FnMut(usize) -> bool,
    ) -> bool {
        let leaves = self.nodes.len() / 2;
        let mut open = vec![1];
        while let Some(node) = open.pop() {
            work.set(work.get() + 1);
            if self.nodes[node].count == 0 || self.nodes[node].is_outside(triangle) {
                continue;
            }
            if node < leaves {
                open.extend([2 * node, 2 * node + 1]);
            } else if self.corners[self.range(node)].iter().any(|&corner| self.leaf_of[corner] > 0 && test(corner)) {
                return true;
            }
        }
        false
    }
}

impl Node {
    fn with(self, at: Coord<f64>) -> Self {
        Self {
            low: Coord { x: self.low.x.min(at.x), y: self.low.y.min(at.y) },
            high: Coord { x: self.high.x.max(at.x), y: self.high.y.max(at.y) },
            count: self.count + 1,
        }
    }

    /// Whether a side of the triangle has the whole box strictly on its outer side: the corner of the box that is
    /// farthest to the side's left decides.
    fn is_outside(&self, [a, b, c]: [Coord<f64>; 3]) -> bool {
        [(a, b), (b, c), (c, a)].into_iter().any(|(from, to)| {
            let x = if to.y < from.y { self.high.x } else { self.low.x };
            let y = if to.x > from.x { self.high.y } else { self.low.y };
            orient2d(from, to, Coord { x, y }) < 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_finds_what_a_loop_finds() {
        // A scattered lattice, so that corners lie on sides of triangles too.
        let at: Vec<_> = (0..300u32).map(|i| Coord { x: f64::from(i * 7 % 19), y: f64::from(i * 11 % 23) }).collect();
        let mut tree = CornerTree::new(&at, (0..at.len()).filter(|i| i % 3 != 0).collect());
        let mut there: Vec<bool> = (0..at.len()).map(|i| i % 3 != 0).collect();
        for round in 0..200 {
            let triangle = [round, round * 5 + 1, round * 13 + 2].map(|i| at[i % at.len()]);
            let [a, b, c] = triangle;
            if orient2d(a, b, c) <= 0.0 {
                continue;
            }
            let inside = |p: Coord<f64>| [(a, b), (b, c), (c, a)].iter().all(|&(f, t)| orient2d(f, t, p) >= 0.0);
            let mut found = Vec::new();
            assert!(!tree.any(triangle, &Cell::new(0), |corner| {
                found.extend(inside(at[corner]).then_some(corner));
                false
            }));
            found.sort_unstable();
            let expected: Vec<_> = (0..at.len()).filter(|&i| there[i] && inside(at[i])).collect();
            assert_eq!(found, expected);
            tree.remove(round);
            there[round] = false;
        }
    }
}
