//! The coarse step: which objects may shadow which, from their boxes alone (Xie, Yu, Hao and Sun, "The new algorithm of
//! shadow volume with LOD", Journal of the National University of Defense Technology 23(3), 2001).
//!
//! From the root down, the children of one parent are tested against each other in both directions; a pair without
//! influence is dropped with all that lies below it. A pair with influence is refined, the larger box first, until both
//! members are objects. Every pair of different objects lies below exactly one pair of siblings, so each is decided
//! once. A pair that a separating plane excludes ([`cannot_shadow`]) is not tested.
//!
//! Guarantee: the result is that of the two tests on every pair of objects, whatever the families, because both are
//! monotone in the boxes. Nothing is missing: a pair that is absent has no influence. What breaks it: nothing; boxes
//! that all overlap leave nothing to drop, and every pair is registered. Cost: the pairs that are not dropped, O(n²)
//! at worst, near O(n log n + registered) where few objects influence each other.

use umbriel_geometry::LightSource;

use crate::{
    influence::cannot_shadow,
    object_tree::{Content, Node, ObjectTree},
    shaft::Shaft,
};

#[cfg(test)]
mod tests;

/// What the coarse step did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PairCounts {
    /// Pairs of boxes tested for influence, on all levels.
    pub tested: u64,
    /// Pairs of different objects that may shadow one another.
    pub registered: u64,
    /// Pairs of boxes, on all levels, that a separating plane excluded and that were therefore not tested.
    pub excluded: u64,
}

/// For each receiver the objects that may shadow it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Influences {
    /// Where each object's occluders begin; one more than there are objects.
    starts: Vec<usize>,
    occluders: Vec<u32>,
    counts: PairCounts,
}

impl Influences {
    /// The objects that may shadow `receiver`, ascending, itself included; none for an object that was no receiver or
    /// is unknown.
    pub fn occluders_of(&self, receiver: u32) -> &[u32] {
        match (self.starts.get(receiver as usize), self.starts.get(receiver as usize + 1)) {
            (Some(&start), Some(&end)) => &self.occluders[start..end],
            _ => &[],
        }
    }

    /// What was done to find them.
    pub fn counts(&self) -> PairCounts {
        self.counts
    }

    /// Groups (receiver, occluder) pairs, in any order, by receiver.
    fn group(mut pairs: Vec<(u32, u32)>, objects: usize, counts: PairCounts) -> Self {
        pairs.sort_unstable();
        let starts = (0..=objects).map(|object| pairs.partition_point(|pair| (pair.0 as usize) < object)).collect();
        Self { starts, occluders: pairs.into_iter().map(|pair| pair.1).collect(), counts }
    }
}

/// The objects that may shadow each object that `is_receiver` names, for `light`.
///
/// Every receiver is its own possible occluder, untested and uncounted. Pairs whose receiver is not asked for are
/// neither tested nor counted.
pub fn influences(tree: &ObjectTree, light: &LightSource, is_receiver: impl Fn(u32) -> bool) -> Influences {
    let own = (0..tree.objects() as u32).filter(|&object| is_receiver(object)).map(|object| (object, object));
    let mut pairs: Vec<(u32, u32)> = own.collect();
    let mut search =
        Search { tree, light, wanted: wanted(tree, is_receiver), open: Vec::new(), counts: PairCounts::default() };
    let mut families = Vec::from_iter(tree.root());
    while let Some(family) = families.pop() {
        let siblings = tree.children_of(tree.node(family));
        for &receiver in siblings {
            let others = siblings.iter().copied().filter(|&other| other != receiver);
            search.test(receiver, others);
        }
        families.extend(siblings);
        search.refine(&mut pairs);
    }
    Influences::group(pairs, tree.objects(), search.counts)
}

/// For each node, whether a receiver lies below it.
fn wanted(tree: &ObjectTree, is_receiver: impl Fn(u32) -> bool) -> Vec<bool> {
    let mut wanted = Vec::with_capacity(tree.nodes().len());
    for node in tree.nodes() {
        let below = |wanted: &[bool]| tree.children_of(node).iter().any(|&child| wanted[child as usize]);
        wanted.push(match node.content {
            Content::Object(object) => is_receiver(object),
            Content::Nodes { .. } => below(&wanted),
        });
    }
    wanted
}

/// The pairs with influence that are still to be refined.
struct Search<'a> {
    tree: &'a ObjectTree,
    light: &'a LightSource,
    wanted: Vec<bool>,
    /// (receiver, occluder) nodes.
    open: Vec<(u32, u32)>,
    counts: PairCounts,
}

impl Search<'_> {
    /// Registers the pairs of `receiver` with those `occluders` that have influence on it.
    fn test(&mut self, receiver: u32, occluders: impl IntoIterator<Item = u32>) {
        if !self.wanted[receiver as usize] {
            return;
        }
        let bounds = &self.tree.node(receiver).bounds;
        let shaft = Shaft::new(bounds, self.light);
        for occluder in occluders {
            let candidate = &self.tree.node(occluder).bounds;
            if cannot_shadow(candidate, bounds, self.light) {
                self.counts.excluded += 1;
                continue;
            }
            self.counts.tested += 1;
            if shaft.may_meet(candidate) {
                self.open.push((receiver, occluder));
            }
        }
    }

    /// Refines all registered pairs down to objects.
    fn refine(&mut self, pairs: &mut Vec<(u32, u32)>) {
        while let Some((receiver, occluder)) = self.open.pop() {
            let tree = self.tree;
            let (below, above) = (tree.node(receiver), tree.node(occluder));
            if let (Content::Object(receiver), Content::Object(occluder)) = (below.content, above.content) {
                self.counts.registered += 1;
                pairs.push((receiver, occluder));
            } else if splits_first(below, above) {
                for &part in tree.children_of(below) {
                    self.test(part, [occluder]);
                }
            } else {
                self.test(receiver, tree.children_of(above).iter().copied());
            }
        }
    }
}

/// Whether `node` rather than `other` is split: the larger family.
fn splits_first(node: &Node, other: &Node) -> bool {
    match (node.content, other.content) {
        (Content::Object(_), _) => false,
        (_, Content::Object(_)) => true,
        _ => node.bounds.half_area() >= other.bounds.half_area(),
    }
}
