use glam::DVec3;
use proptest::prelude::*;
use umbriel_geometry::Aabb;

use super::*;
use crate::{
    Families, Member,
    arbitrary::{boxes, light},
    cannot_shadow, may_shadow,
};

/// Families drawn at random: each family and each object lies in an earlier family, or at the top.
fn families(parents: &[usize], homes: &[usize], objects: usize) -> Families {
    let mut families = Families { members: vec![Vec::new(); parents.len()], roots: Vec::new() };
    let mut place = |home: usize, below: usize, member| match home % (below + 1) {
        0 => families.roots.push(member),
        family => families.members[family - 1].push(member),
    };
    for (family, &parent) in parents.iter().enumerate() {
        place(parent, family, Member::Family(family as u32));
    }
    for object in 0..objects {
        place(homes[object % homes.len()], parents.len(), Member::Object(object as u32));
    }
    families
}

fn expected(boxes: &[Aabb], light: &LightSource, receiver: usize) -> Vec<u32> {
    let meets = |occluder: usize| {
        let (a, b) = (&boxes[occluder], &boxes[receiver]);
        let is_own = occluder == receiver;
        is_own && a.is_empty() || (is_own || may_shadow(a, b, light)) && !cannot_shadow(a, b, light)
    };
    (0..boxes.len()).filter(|&occluder| meets(occluder)).map(|occluder| occluder as u32).collect()
}

/// How many blocks there are, and their pairs.
fn in_blocks(tree: &ObjectTree, light: &LightSource, is_receiver: impl Fn(u32) -> bool) -> (usize, Influences) {
    let (mut blocks, mut pairs) = (0, Vec::new());
    let register = |receivers: &[u32], occluders: &[u32]| {
        blocks += 1;
        for &receiver in receivers {
            pairs.extend(occluders.iter().map(|&occluder| (receiver, occluder)));
        }
        ControlFlow::Continue(())
    };
    let counts = for_each_influence(tree, light, is_receiver, register);
    (blocks, Influences::of_pairs(pairs, tree.objects(), counts))
}

proptest! {
    #[test]
    fn the_result_is_that_of_all_pairs(
        boxes in boxes(), light in light(),
        parents in proptest::collection::vec(0usize..100, 0..20), homes in proptest::collection::vec(0usize..100, 1..40),
    ) {
        let tree = ObjectTree::build(&boxes, &families(&parents, &homes, boxes.len())).expect("a forest");
        let found = influences(&tree, &light, |_| true);
        for receiver in 0..boxes.len() {
            prop_assert_eq!(found.occluders_of(receiver as u32), &expected(&boxes, &light, receiver)[..]);
            prop_assert_eq!(occluders_of(&tree, &light, receiver as u32), expected(&boxes, &light, receiver));
        }
        let others = |receiver: u32| found.occluders_of(receiver).iter().filter(|&&occluder| occluder != receiver).count();
        let pairs: usize = (0..boxes.len() as u32).map(others).sum();
        prop_assert_eq!(found.counts().registered, pairs as u64);
    }

    #[test]
    fn blocks_hold_the_same_pairs(
        boxes in boxes(), light in light(), step in 1u32..4, wider in 0u32..5,
        parents in proptest::collection::vec(0usize..100, 0..20), homes in proptest::collection::vec(0usize..100, 1..40),
    ) {
        let wider = |bounds: &Aabb| Aabb { min: bounds.min - f64::from(wider), max: bounds.max + f64::from(wider) };
        let boxes: Vec<Aabb> = boxes.iter().map(wider).collect();
        let tree = ObjectTree::build(&boxes, &families(&parents, &homes, boxes.len())).expect("a forest");
        let is_receiver = |receiver: u32| receiver.is_multiple_of(step);
        let (one_by_one, (_, in_blocks)) = (influences(&tree, &light, is_receiver), in_blocks(&tree, &light, is_receiver));
        prop_assert_eq!((&one_by_one.starts, &one_by_one.occluders), (&in_blocks.starts, &in_blocks.occluders));
        prop_assert_eq!(one_by_one.counts().registered, in_blocks.counts().registered);
        prop_assert!(in_blocks.counts().tested <= one_by_one.counts().tested);
    }

    #[test]
    fn each_pair_of_objects_lies_below_one_pair_of_siblings(
        boxes in boxes(), light in light(),
        parents in proptest::collection::vec(0usize..100, 0..20), homes in proptest::collection::vec(0usize..100, 1..40),
    ) {
        let tree = ObjectTree::build(&boxes, &families(&parents, &homes, boxes.len())).expect("a forest");
        let pairs = level_pairs(&tree, &light);
        prop_assert_eq!(&pairs, &pairs_of_siblings(&tree, &light));
        let mut below = std::collections::HashMap::new();
        for pair in pairs {
            for receiver in tree.objects_below(pair.receiver) {
                for occluder in tree.objects_below(pair.occluder) {
                    *below.entry((receiver, occluder)).or_insert(0) += 1;
                }
            }
        }
        let found = influences(&tree, &light, |_| true);
        for receiver in 0..boxes.len() as u32 {
            for &occluder in found.occluders_of(receiver).iter().filter(|&&occluder| occluder != receiver) {
                prop_assert_eq!(below.get(&(receiver, occluder)), Some(&1));
            }
        }
    }

    #[test]
    fn without_exclusion_the_influences_are_the_same(boxes in boxes(), light in light(), step in 1u32..4) {
        let tree = ObjectTree::build(&boxes, &Families::default()).expect("no families, no defect");
        let is_receiver = |receiver: u32| receiver.is_multiple_of(step);
        let with = influences(&tree, &light, is_receiver);
        let without = influences_with(&tree, &light, is_receiver, Exclusion::Off);
        for receiver in 0..boxes.len() as u32 {
            prop_assert_eq!(with.occluders_of(receiver), without.occluders_of(receiver));
        }
        prop_assert_eq!(with.counts().registered, without.counts().registered);
        prop_assert_eq!(without.counts().excluded, 0);
        prop_assert!(with.counts().tested + with.counts().excluded <= without.counts().tested);
    }

    #[test]
    fn only_the_receivers_asked_for_are_tested(boxes in boxes(), light in light(), step in 2u32..9) {
        let tree = ObjectTree::build(&boxes, &Families::default()).expect("no families, no defect");
        let (all, some) = (influences(&tree, &light, |_| true), influences(&tree, &light, |r| r % step == 1));
        for receiver in 0..boxes.len() as u32 {
            let expected = if receiver % step == 1 { all.occluders_of(receiver) } else { &[] };
            prop_assert_eq!(some.occluders_of(receiver), expected);
        }
        prop_assert!(some.counts().tested <= all.counts().tested);
        prop_assert_eq!(influences(&tree, &light, |_| false).counts(), PairCounts::default());
    }
}

/// The pairs of siblings with influence, by two loops over the children of each node, sorted by level.
fn pairs_of_siblings(tree: &ObjectTree, light: &LightSource) -> Vec<LevelPair> {
    let mut pairs = Vec::new();
    let mut open = std::collections::VecDeque::from_iter(tree.root().map(|root| (1, root)));
    while let Some((level, parent)) = open.pop_front() {
        let siblings = tree.children_of(parent);
        for &receiver in siblings {
            for &occluder in siblings.iter().filter(|&&occluder| occluder != receiver) {
                let (a, b) = (tree.bounds_of(occluder), tree.bounds_of(receiver));
                if may_shadow(a, b, light) && !cannot_shadow(a, b, light) {
                    pairs.push(LevelPair { level, occluder, receiver });
                }
            }
        }
        open.extend(siblings.iter().map(|&child| (level + 1, child)));
    }
    pairs
}

/// Boxes of a town: a grid of blocks on the ground, every house standing on one floor.
fn town(side: u32) -> Vec<Aabb> {
    let floor = Aabb { min: DVec3::ZERO, max: DVec3::new(f64::from(side), 0.0, f64::from(side)) };
    let house = |n: u32| {
        let min = DVec3::new(f64::from(n % side), 0.0, f64::from(n / side));
        Aabb { min, max: min + DVec3::new(0.75, f64::from(n * 7 % 5) * 0.25, 0.75) }
    };
    std::iter::once(floor).chain((0..side * side).map(house)).collect()
}

#[test]
fn thousands_of_boxes_need_few_tests() {
    let boxes = town(55);
    let tree = ObjectTree::build(&boxes, &Families::default()).expect("no families, no defect");
    for light in [LightSource::sun([1.0, -1.0, 0.5]), LightSource::point([27.3, 0.6, 27.3])] {
        let light = light.expect("a light");
        let found = influences(&tree, &light, |_| true);
        for receiver in 0..boxes.len() {
            assert_eq!(found.occluders_of(receiver as u32), expected(&boxes, &light, receiver), "receiver {receiver}");
        }
        let (counts, all) = (found.counts(), (boxes.len() * (boxes.len() - 1)) as u64);
        assert!(counts.tested + counts.excluded < all / 5, "{counts:?} of {all} pairs");
    }
}

/// Three piles of boxes that have points in common, one over another and one beside, and a box far away.
fn piles() -> Vec<Aabb> {
    let part = |k: u32, step: u32| f64::from(k * step % 97) / 97.0;
    let of_pile = |k: u32| {
        let middle = [DVec3::ZERO, DVec3::new(1.0, 20.0, 0.5), DVec3::new(40.0, 1.0, 0.0)][(k % 3) as usize];
        let (min, max) = ([part(k, 31), part(k, 47), part(k, 61)], [part(k, 13), part(k, 71), part(k, 89)]);
        Aabb { min: middle - DVec3::from(min) - 0.125, max: middle + DVec3::from(max) + 0.125 }
    };
    (0..600).map(of_pile).chain([Aabb { min: DVec3::splat(500.0), max: DVec3::splat(501.0) }]).collect()
}

#[test]
fn piles_are_registered_in_blocks() {
    let boxes = piles();
    let tree = ObjectTree::build(&boxes, &Families::default()).expect("no families, no defect");
    for light in [
        LightSource::sun([0.0, -1.0, 0.0]),
        LightSource::sun([-1.0, -0.03, 0.01]),
        LightSource::point([0.5, 60.0, 0.25]),
    ] {
        let light = light.expect("a light");
        for step in [1, 2] {
            let is_receiver = |receiver: u32| receiver.is_multiple_of(step);
            let (blocks, found) = in_blocks(&tree, &light, is_receiver);
            let (counts, pairs) = (found.counts(), found.occluders.len());
            assert!(counts.registered > 100_000 / u64::from(step), "{counts:?}");
            assert!(blocks < pairs / 10 && counts.tested < counts.registered / 6, "{blocks} of {pairs}, {counts:?}");
            for receiver in 0..boxes.len() {
                let expected =
                    if is_receiver(receiver as u32) { expected(&boxes, &light, receiver) } else { Vec::new() };
                assert_eq!(found.occluders_of(receiver as u32), expected, "{receiver}");
            }
        }
    }
}

#[test]
fn a_floor_and_a_house_take_one_test() {
    let boxes = [Aabb::of([DVec3::ZERO, DVec3::new(9.0, 0.0, 9.0)]), Aabb::of([DVec3::ONE, DVec3::new(2.0, 0.0, 2.0)])];
    let tree = ObjectTree::build(&boxes, &Families::default()).expect("no families, no defect");
    let found = influences(&tree, &LightSource::sun([0.3, -1.0, 0.2]).expect("a sun above"), |_| true);
    // The floor is flat.
    assert_eq!((found.occluders_of(0), found.occluders_of(1)), (&[1][..], &[1][..]));
    assert_eq!(found.counts(), PairCounts { tested: 1, registered: 1, excluded: 1 });
    assert_eq!(found.occluders_of(2), &[] as &[u32], "there is no such object");
}
