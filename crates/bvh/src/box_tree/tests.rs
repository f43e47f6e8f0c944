use std::ops::ControlFlow;

use glam::DVec3;
use proptest::prelude::*;
use umbriel_geometry::{Aabb, LightSource};

use super::*;
use crate::arbitrary::{a_box, boxes, light, point};

fn sorted(mut ids: Vec<u32>) -> Vec<u32> {
    ids.sort_unstable();
    ids
}

fn brute_force(boxes: &[Aabb], accept: impl Fn(&Aabb) -> bool) -> Vec<u32> {
    (0u32..).zip(boxes).filter(|(_, bounds)| !bounds.is_empty() && accept(bounds)).map(|(id, _)| id).collect()
}

proptest! {
    #[test]
    fn a_tree_is_sound(boxes in boxes()) {
        let tree = BoxTree::build(&boxes);
        prop_assert_eq!(tree.check(&boxes), Ok(()));
        prop_assert_eq!(tree.bounds(), boxes.iter().fold(Aabb::EMPTY, |sum, b| sum.union(*b)));
        prop_assert_eq!(tree.len(), boxes.len());
    }

    #[test]
    fn meetings_are_those_of_a_loop(boxes in boxes(), query in a_box()) {
        let mut found = Vec::new();
        BoxTree::build(&boxes).for_each_meeting(&query, |id| found.push(id));
        prop_assert_eq!(sorted(found), brute_force(&boxes, |b| b.meets(&query)));
    }

    #[test]
    fn pairs_that_meet_are_those_of_two_loops(boxes in boxes(), least in 0..40usize) {
        let tree = BoxTree::build(&boxes);
        let mut found = Vec::new();
        for part in tree.meeting_parts(least) {
            let end = tree.for_each_meeting_pair(part, |a, b| {
                found.push([a.min(b), a.max(b)]);
                ControlFlow::Continue(())
            });
            prop_assert_eq!(end, ControlFlow::Continue(()));
        }
        found.sort_unstable();
        let count = boxes.len();
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
        let meet = |&[a, b]: &[usize; 2]| !boxes[a].is_empty() && boxes[a].meets(&boxes[b]);
        let expected: Vec<[u32; 2]> = pairs.filter(meet).map(|pair| pair.map(|item| item as u32)).collect();
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn segments_find_what_a_loop_finds(boxes in boxes(), origin in point(), light in light()) {
        let segment = Segment::new(origin, light);
        let mut found = Vec::new();
        let end = BoxTree::build(&boxes).for_each_along(&segment, |id| {
            found.push(id);
            ControlFlow::Continue(())
        });
        prop_assert_eq!(end, ControlFlow::Continue(()));
        prop_assert_eq!(sorted(found), brute_force(&boxes, |b| segment.shaft().may_meet(b)));
    }

    #[test]
    fn rays_find_what_a_loop_finds(boxes in boxes(), origin in point(), direction in point(), t_max in 0.0..4.0f64) {
        let ray = Ray::new(origin, direction);
        let mut found = Vec::new();
        BoxTree::build(&boxes).for_each_near(&ray, t_max, |id, _, t_max| {
            found.push(id);
            t_max
        });
        let expected = brute_force(&boxes, |b| ray.span(b).is_some_and(|(enter, _)| enter <= t_max));
        prop_assert_eq!(sorted(found), expected);
    }

    #[test]
    fn a_shrinking_ray_keeps_the_nearest_box(boxes in boxes(), origin in point(), direction in point()) {
        let ray = Ray::new(origin, direction);
        let mut nearest = f64::INFINITY;
        BoxTree::build(&boxes).for_each_near(&ray, nearest, |_, (enter, _), t_max| {
            nearest = nearest.min(enter);
            t_max.min(enter)
        });
        let spans = boxes.iter().filter(|b| !b.is_empty()).filter_map(|b| ray.span(b));
        prop_assert_eq!(nearest, spans.fold(f64::INFINITY, |least, (enter, _)| least.min(enter)));
    }

    #[test]
    fn the_order_of_the_boxes_does_not_matter(boxes in boxes(), query in a_box()) {
        let reversed: Vec<Aabb> = boxes.iter().rev().copied().collect();
        let visits = |boxes: &[Aabb]| {
            let mut count = 0;
            let _ = BoxTree::build(boxes).for_each_where(
                |b| {
                    count += 1;
                    b.meets(&query)
                },
                |_| ControlFlow::Continue(()),
            );
            count
        };
        prop_assert_eq!(visits(&boxes), visits(&reversed));
    }
}

#[test]
fn hostile_boxes_keep_the_tree_shallow() {
    let point = |x: f64| Aabb { min: DVec3::splat(x), max: DVec3::splat(x) };
    let geometric: Vec<Aabb> = (-2000..2000).map(|n| point(2f64.powf(f64::from(n) / 10.0))).collect();
    let equal = vec![point(1.0); 10_000];
    let everywhere = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
    let half = Aabb { min: DVec3::ZERO, max: DVec3::INFINITY };
    let endless: Vec<Aabb> = (0..300).map(|n| [everywhere, half, point(f64::from(n))][n as usize % 3]).collect();
    let huge: Vec<Aabb> = (0..100).map(|n| point(f64::MAX * (f64::from(n) / 50.0 - 1.0))).collect();
    for boxes in [geometric, equal, endless, huge] {
        assert_eq!(BoxTree::build(&boxes).check(&boxes), Ok(()));
    }
}

#[test]
fn a_foreign_tree_is_told() {
    let boxes = [Aabb::of([DVec3::ZERO]), Aabb::of([DVec3::ONE])];
    let tree = BoxTree::build(&boxes);
    assert_eq!(tree.check(&boxes[..1]), Err(TreeDefect::Length { tree: 2, given: 1 }));
    assert_eq!(tree.check(&[boxes[0], boxes[0]]), Err(TreeDefect::Item { item: 1 }));
    assert_eq!(tree.check(&[boxes[0], Aabb::EMPTY]), Err(TreeDefect::Item { item: 1 }));
}

#[test]
fn a_visit_can_end_the_walk() {
    let boxes = vec![Aabb::of([DVec3::ZERO, DVec3::ONE]); 50];
    let segment = Segment::new(DVec3::splat(-1.0), LightSource::point([2.0; 3]).expect("a light"));
    let mut visits = 0;
    let end = BoxTree::build(&boxes).for_each_along(&segment, |_| {
        visits += 1;
        if visits == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert_eq!((end, visits), (ControlFlow::Break(()), 3));
}

#[test]
fn a_tree_over_nothing_answers_nothing() {
    let tree = BoxTree::build(&[]);
    assert!(tree.is_empty() && tree.bounds().is_empty());
    tree.for_each_meeting(&Aabb::of([DVec3::ZERO]), |_| unreachable!("there is no item"));
}

#[test]
fn a_tree_is_built_as_long_as_it_may_be() {
    let at = |k: u32| DVec3::new(f64::from(k % 101), f64::from(k % 103), f64::from(k % 107));
    let boxes: Vec<Aabb> = (0..20_000).map(|k| Aabb { min: at(k), max: at(k) + 1.0 }).collect();
    let asked = std::cell::Cell::new(0);
    let count = || {
        asked.set(asked.get() + 1);
        true
    };
    let tree = BoxTree::build_while(&boxes, &count).expect("it goes on");
    assert_eq!(tree.check(&boxes), Ok(()));
    // Some fourteen levels of 20,000 looks.
    assert!((15..60).contains(&asked.get()), "asked {} times", asked.get());
    assert!(BoxTree::build_while(&boxes, &|| false).is_none());
}
