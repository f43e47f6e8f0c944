//! The coarse step: which objects may shadow which, from their boxes alone (Xie, Yu, Hao and Sun, "The new algorithm of
//! shadow volume with LOD", Journal of the National University of Defense Technology 23(3), 2001).
//!
//! 1. *Level by level* ([`level_pairs`]): from the root down, the children of one parent are tested against each other
//!    in both directions; a pair without influence is dropped with all that lies below it.
//! 2. *Down to the objects* ([`influences`]): a pair with influence is refined, the larger box first, until both
//!    members are objects. Every pair of different objects lies below exactly one pair of siblings, so each is decided
//!    once.
//! 3. *Exclusion*: a pair that a separating plane excludes ([`cannot_shadow`]) is not tested, on any level. The source
//!    records `[A] → [B]` in order to skip `[B] → [A]`; the plane needs no record, and holds for whole families.
//! 4. *Inclusion*, which is not the source's: where all boxes on either side of a pair have points in common, and the boxes of these points pass both tests, all pairs of objects below do,
//!    as the tests are monotone in both boxes; [`for_each_influence`] registers them as a block. So a pile of boxes through each other costs what its pairs of families cost.
//!
//! Guarantee: the result is that of the two tests on every pair of objects, whatever the families, because both are
//! monotone in the boxes. Nothing is missing: a pair that is absent has no influence. What breaks it: nothing; boxes
//! that all overlap leave nothing to drop, and every pair is registered. Cost: the pairs that are neither dropped nor in blocks, O(n²)
//! at worst, near O(n log n + registered) where few objects influence each other.

use std::ops::ControlFlow;

use umbriel_geometry::LightSource;

use crate::{
    influence::cannot_shadow,
    object_tree::{Below, NodeId, ObjectTree},
    shaft::Shaft,
};

#[cfg(test)]
mod tests;

/// A pair of siblings with influence: part of the receiver's box lies in the shadow space of the occluder's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelPair {
    /// How far below the root both stand: 1 for its children.
    pub level: u32,
    /// What may shadow: A in `[A] → [B]`.
    pub occluder: NodeId,
    /// What may be shadowed: B in `[A] → [B]`.
    pub receiver: NodeId,
}

/// What the coarse step did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PairCounts {
    /// Pairs of boxes tested for influence, on all levels; not those of common points.
    pub tested: u64,
    /// Pairs of different objects that may shadow one another.
    pub registered: u64,
    /// Pairs of boxes, on all levels, that a separating plane excluded and that were therefore not tested.
    pub excluded: u64,
}

/// Whether pairs of boxes that cannot influence each other are left untested. The influences found are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Exclusion {
    /// A pair that a separating plane excludes is not tested.
    #[default]
    Planes,
    /// Every pair is tested; the plane has a say about touching objects only. For measurements.
    Off,
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
    /// The objects that may shadow `receiver`, ascending, itself included unless it is flat; none for an object that was no receiver or
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

    /// Of (receiver, occluder) pairs in any order, among so many objects: what [`for_each_influence`] registers. O(n log n) in the pairs.
    pub fn of_pairs(mut pairs: Vec<(u32, u32)>, objects: usize, counts: PairCounts) -> Self {
        pairs.sort_unstable();
        let mut starts = Vec::with_capacity(objects + 1);
        for (place, &(receiver, _)) in pairs.iter().enumerate() {
            // Those up to this one that have no occluder before it.
            starts.resize((receiver as usize + 1).max(starts.len()), place);
        }
        starts.resize(objects + 1, pairs.len());
        Self { starts, occluders: pairs.into_iter().map(|pair| pair.1).collect(), counts }
    }
}

/// The pairs of siblings with influence for `light`, level by level from the top: the first step, for those who want
/// to see it. Cost: at most 56 tests a family.
pub fn level_pairs(tree: &ObjectTree, light: &LightSource) -> Vec<LevelPair> {
    Search::new(tree, light, &|_| true, Exclusion::Planes).level_pairs()
}

/// The objects that may shadow each object that `is_receiver` names, for `light`: the whole coarse step.
///
/// Every receiver is its own possible occluder, uncounted, but for one whose box is flat with the light off its plane ([`cannot_shadow`]). Pairs whose
/// receiver is not asked for are neither tested nor counted.
///
/// Source: Xie, Yu, Hao and Sun (2001), "coarse step". Cost: proportional to the pairs of boxes with influence, on all
/// levels; O(n²) where all boxes overlap, near O(n log n + registered) where few objects influence each other.
pub fn influences(tree: &ObjectTree, light: &LightSource, is_receiver: impl Fn(u32) -> bool) -> Influences {
    influences_with(tree, light, is_receiver, Exclusion::Planes)
}

/// [`influences`] with or without exclusion: the same influences, other counts.
pub fn influences_with(
    tree: &ObjectTree,
    light: &LightSource,
    is_receiver: impl Fn(u32) -> bool,
    exclusion: Exclusion,
) -> Influences {
    let mut pairs = Vec::new();
    let register = |receivers: &[u32], occluders: &[u32]| {
        pairs
            .extend(receivers.iter().flat_map(|&receiver| occluders.iter().map(move |&occluder| (receiver, occluder))));
        ControlFlow::Continue(())
    };
    let counts = search(tree, light, &is_receiver, exclusion, None, register);
    Influences::of_pairs(pairs, tree.objects(), counts)
}

/// Registers each (receiver, occluder) pair of [`influences`], in no order that means anything, until `register` breaks; answers what was done. `register` takes receivers and occluders of
/// which each pair is one; a pair of an object with itself comes alone. Where boxes have points in common fewer pairs are tested than for [`influences`]. Nothing is stored: memory is linear in the objects, however many pairs there are.
pub fn for_each_influence(
    tree: &ObjectTree,
    light: &LightSource,
    is_receiver: impl Fn(u32) -> bool,
    register: impl FnMut(&[u32], &[u32]) -> ControlFlow<()>,
) -> PairCounts {
    search(tree, light, &is_receiver, Exclusion::Planes, Some(&tree.below()), register)
}

/// The objects that may shadow one receiver, found by themselves: what [`Influences::occluders_of`] answers for it, by two tests a box that is looked at.
/// None for an object without a box, other than itself.
pub fn occluders_of(tree: &ObjectTree, light: &LightSource, receiver: u32) -> Vec<u32> {
    let Some(node) = tree.node_of(receiver) else { return vec![receiver] };
    let bounds = tree.bounds_of(node);
    let (shaft, mut found, mut open) = (Shaft::new(bounds, light), Vec::new(), Vec::from_iter(tree.root()));
    if !cannot_shadow(bounds, bounds, light) {
        found.push(receiver);
    }
    while let Some(next) = open.pop() {
        let occluder = tree.bounds_of(next);
        if next != node && !cannot_shadow(occluder, bounds, light) && shaft.may_meet(occluder) {
            found.extend(tree.object_of(next));
            open.extend(tree.children_of(next));
        }
    }
    found.sort_unstable();
    found
}

fn search(
    tree: &ObjectTree,
    light: &LightSource,
    is_receiver: &impl Fn(u32) -> bool,
    exclusion: Exclusion,
    below: Option<&Below>,
    mut register: impl FnMut(&[u32], &[u32]) -> ControlFlow<()>,
) -> PairCounts {
    let mut is_own: Vec<bool> = (0..tree.objects() as u32).map(is_receiver).collect();
    for (object, _) in tree.boxed_objects().filter(|(_, bounds)| cannot_shadow(bounds, bounds, light)) {
        is_own[object as usize] = false;
    }
    let mut own = (0u32..).zip(is_own).filter(|(_, is_own)| *is_own);
    if own.try_for_each(|(object, _)| register(&[object], &[object])).is_break() {
        return PairCounts::default();
    }
    let mut search = Search::new(tree, light, is_receiver, exclusion);
    let siblings = search.level_pairs();
    search.open.extend(siblings.iter().map(|pair| (pair.receiver, pair.occluder)));
    let _ = search.refine(below, is_receiver, register);
    search.counts
}

/// The pairs with influence that are still to be refined.
struct Search<'a> {
    tree: &'a ObjectTree,
    light: &'a LightSource,
    exclusion: Exclusion,
    /// For each node whether a receiver lies at or below it.
    wanted: Vec<bool>,
    /// (receiver, occluder) nodes.
    open: Vec<(NodeId, NodeId)>,
    counts: PairCounts,
}

impl<'a> Search<'a> {
    fn new(
        tree: &'a ObjectTree,
        light: &'a LightSource,
        is_receiver: &impl Fn(u32) -> bool,
        exclusion: Exclusion,
    ) -> Self {
        let wanted = tree.mark(is_receiver);
        Self { tree, light, exclusion, wanted, open: Vec::new(), counts: PairCounts::default() }
    }

    /// Tests the children of each parent against each other, level by level.
    fn level_pairs(&mut self) -> Vec<LevelPair> {
        let tree = self.tree;
        let mut pairs = Vec::new();
        let mut parents = Vec::from_iter(tree.root());
        for level in 1.. {
            for siblings in parents.iter().map(|&parent| tree.children_of(parent)) {
                for &receiver in siblings {
                    self.test(receiver, siblings.iter().copied().filter(|&other| other != receiver));
                }
            }
            let registered = self.open.drain(..);
            pairs.extend(registered.map(|(receiver, occluder)| LevelPair { level, occluder, receiver }));
            parents = parents.iter().flat_map(|&parent| tree.children_of(parent)).copied().collect();
            if parents.is_empty() {
                break;
            }
        }
        pairs
    }

    /// Registers the pairs of `receiver` with those `occluders` that have influence on it.
    fn test(&mut self, receiver: NodeId, occluders: impl IntoIterator<Item = NodeId>) {
        if !self.wanted[ObjectTree::index(receiver)] {
            return;
        }
        let shaft = Shaft::new(self.tree.bounds_of(receiver), self.light);
        for occluder in occluders {
            if self.has_influence(occluder, receiver, &shaft) {
                self.open.push((receiver, occluder));
            }
        }
    }

    /// Whether the occluder may shadow the receiver, whose shaft is given.
    fn has_influence(&mut self, occluder: NodeId, receiver: NodeId, shaft: &Shaft) -> bool {
        let (tree, light) = (self.tree, self.light);
        let bounds = tree.bounds_of(occluder);
        let is_excluded = || cannot_shadow(bounds, tree.bounds_of(receiver), light);
        if self.exclusion == Exclusion::Planes && is_excluded() {
            self.counts.excluded += 1;
            return false;
        }
        self.counts.tested += 1;
        // Only of objects: to whatever level exclusion goes, the influences are those of this test on objects.
        let is_pair_of_objects = || tree.object_of(occluder).is_some() && tree.object_of(receiver).is_some();
        let is_contact = || self.exclusion == Exclusion::Off && is_pair_of_objects() && is_excluded();
        shaft.may_meet(bounds) && !is_contact()
    }

    /// Refines all registered pairs down to objects, or to blocks where it is known what the objects below nodes have in common, until `register` breaks.
    fn refine(
        &mut self,
        below: Option<&Below>,
        is_receiver: &impl Fn(u32) -> bool,
        mut register: impl FnMut(&[u32], &[u32]) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let tree = self.tree;
        while let Some((receiver, occluder)) = self.open.pop() {
            match (tree.object_of(receiver), tree.object_of(occluder)) {
                (Some(receiver), Some(occluder)) => {
                    self.counts.registered += 1;
                    register(&[receiver], &[occluder])?;
                }
                _ if let Some(below) = below.filter(|below| self.is_block(below, receiver, occluder)) => {
                    let receivers = below.objects(receiver).iter().copied().filter(|&object| is_receiver(object));
                    let (receivers, occluders) = (receivers.collect::<Vec<_>>(), below.objects(occluder));
                    self.counts.registered += receivers.len() as u64 * occluders.len() as u64;
                    register(&receivers, occluders)?;
                }
                (None, None) if is_smaller(tree, receiver, occluder) => self.split_occluder(receiver, occluder),
                (None, _) => self.split_receiver(receiver, occluder),
                (Some(_), None) => self.split_occluder(receiver, occluder),
            }
        }
        ControlFlow::Continue(())
    }

    /// Whether each object below the one node influences each below the other for certain.
    fn is_block(&self, below: &Below, receiver: NodeId, occluder: NodeId) -> bool {
        let [to, from] = [receiver, occluder].map(|node| below.common(node));
        !to.is_empty()
            && !from.is_empty()
            && !cannot_shadow(from, to, self.light)
            && Shaft::new(to, self.light).may_meet(from)
    }

    fn split_occluder(&mut self, receiver: NodeId, occluder: NodeId) {
        self.test(receiver, self.tree.children_of(occluder).iter().copied());
    }

    fn split_receiver(&mut self, receiver: NodeId, occluder: NodeId) {
        for &part in self.tree.children_of(receiver) {
            self.test(part, [occluder]);
        }
    }
}

/// Whether the box of `node` is the smaller one by its surface.
fn is_smaller(tree: &ObjectTree, node: NodeId, other: NodeId) -> bool {
    tree.bounds_of(node).half_area() < tree.bounds_of(other).half_area()
}
