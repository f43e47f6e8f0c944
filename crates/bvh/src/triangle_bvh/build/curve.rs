//! A binary tree along Morton's curve, for trees that are not used for long.
//!
//! Lauterbach, Garland, Sengupta, Luebke and Manocha, "Fast BVH construction on GPUs", Eurographics 2009: triangles are
//! sorted by the codes of their middles, and a part is cut where the highest bit changes in which its codes differ. Parts
//! below [`FINE`] triangles are built by the surface-area heuristic, which costs little there. O(n); the depth is that of
//! `binary.rs`. Boxes are known when the children are.

use std::num::NonZeroU32;

use super::{
    super::{
        bounds::Bounds,
        morton::{code, sorted},
    },
    binary::{BinaryNode, MAX_DEPTH, Part, centers_of, halvings},
};

/// Bits of a code on an axis.
const BITS: u32 = 10;

/// Parts that are not larger are left to the heuristic.
const FINE: usize = 16;

/// Builds the tree over tagged boxes, which are put in leaf order. `items` must not be empty.
pub(super) fn build(items: &mut Vec<Bounds>) -> Vec<BinaryNode> {
    let codes = sort(items);
    let mut nodes = Vec::with_capacity(items.len() / 2);
    let scratch = &mut vec![Bounds::ZERO; FINE.min(items.len())];
    Stretch { items, codes: &codes, scratch, first: 0, depth: 1 }.build(&mut nodes);
    nodes
}

/// Puts the boxes in order; returns their codes, each with where the box was.
fn sort(items: &mut Vec<Bounds>) -> Vec<(u32, u32)> {
    let all = centers_of(items);
    let cells = (1u32 << BITS) as f32;
    let factor = |axis: usize| {
        let factor = cells / (all.max(axis) - all.min(axis));
        if factor.is_finite() { factor } else { 0.0 }
    };
    let factor = [factor(0), factor(1), factor(2)];
    let code_of = |item: &Bounds| {
        let center = item.twice_center();
        let cell = |axis: usize| ((center[axis] - all.min(axis)) * factor[axis]) as u32;
        code([cell(0), cell(1), cell(2)], BITS)
    };
    let codes = sorted(items.iter().map(code_of).zip(0..).collect(), 3 * BITS);
    *items = codes.iter().map(|&(_, index)| items[index as usize]).collect();
    codes
}

/// Items in a row on the curve that become a subtree.
struct Stretch<'a> {
    items: &'a mut [Bounds],
    codes: &'a [(u32, u32)],
    /// For the heuristic; of no meaning.
    scratch: &'a mut [Bounds],
    /// Index of the first item in leaf order.
    first: u32,
    depth: usize,
}

impl Stretch<'_> {
    /// Appends the subtree to `nodes`.
    fn build(self, nodes: &mut Vec<BinaryNode>) {
        let Self { items, codes, scratch, first, depth } = self;
        let (index, count) = (nodes.len(), items.len());
        if count <= FINE {
            return Part::new(items, &mut scratch[..count], first, depth).build(nodes);
        }
        let middle = if depth + halvings(count) >= MAX_DEPTH { count / 2 } else { cut(codes) };
        nodes.push(BinaryNode { bounds: Bounds::EMPTY, first, count: count as u32, right: None });
        let ((left, right), (left_codes, right_codes)) = (items.split_at_mut(middle), codes.split_at(middle));
        let depth = depth + 1;
        Stretch { items: left, codes: left_codes, scratch, first, depth }.build(nodes);
        let second = nodes.len();
        Stretch { items: right, codes: right_codes, scratch, first: first + middle as u32, depth }.build(nodes);
        nodes[index].right = NonZeroU32::new(second as u32);
        nodes[index].bounds = nodes[index + 1].bounds.union(&nodes[second].bounds);
    }
}

/// Where the highest bit changes in which the codes differ; the middle where none does.
fn cut(codes: &[(u32, u32)]) -> usize {
    let differing = codes[0].0 ^ codes[codes.len() - 1].0;
    if differing == 0 {
        return codes.len() / 2;
    }
    let bit = 1 << differing.ilog2();
    codes.partition_point(|(code, _)| code & bit == 0)
}
