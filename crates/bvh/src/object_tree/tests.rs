use glam::DVec3;

use super::*;

fn row(count: u32) -> Vec<Aabb> {
    (0..count).map(|n| Aabb::of([DVec3::X * f64::from(n), DVec3::X * f64::from(n) + DVec3::splat(0.5)])).collect()
}

/// Every object is below the root exactly once, every box is the smallest around its content.
fn assert_sound(tree: &ObjectTree, boxes: &[Aabb]) {
    let mut seen = vec![false; boxes.len()];
    let mut open = Vec::from_iter(tree.root());
    while let Some(index) = open.pop() {
        let children = tree.children_of(index);
        let content = match tree.object_of(index) {
            Some(object) => {
                assert!(!std::mem::replace(&mut seen[object as usize], true), "object {object} is there twice");
                boxes[object as usize]
            }
            None => {
                assert!((2..=WIDEST).contains(&children.len()), "{} children", children.len());
                children.iter().fold(Aabb::EMPTY, |sum, &child| sum.union(*tree.bounds_of(child)))
            }
        };
        assert_eq!(*tree.bounds_of(index), content);
        assert!(children.iter().all(|&child| child < index), "children come first");
        open.extend(children);
    }
    for (object, bounds) in boxes.iter().enumerate() {
        assert_eq!(seen[object], !bounds.is_empty(), "object {object}");
    }
}

#[test]
fn any_number_of_objects_makes_a_tree() {
    for count in [0, 1, 2, 8, 9, 1000] {
        let mut boxes = row(count);
        boxes.push(Aabb::EMPTY);
        let tree = ObjectTree::build(&boxes, &Families::default()).expect("no families, no defect");
        assert_sound(&tree, &boxes);
        assert_eq!(tree.objects(), boxes.len());
        assert_eq!(tree.bounds(), boxes.iter().fold(Aabb::EMPTY, |sum, b| sum.union(*b)));
    }
}

#[test]
fn families_are_kept_and_loose_objects_stand_at_the_top() {
    use Member::{Family, Object};
    let boxes = row(6);
    let families = Families {
        members: vec![vec![Object(0), Family(1), Object(1)], vec![Object(5), Object(4)], vec![]],
        roots: vec![Family(0), Family(2)],
    };
    let tree = ObjectTree::build(&boxes, &families).expect("a forest");
    assert_sound(&tree, &boxes);
    assert_eq!(tree.boxes(), 6 + 3, "six objects, two families, the top");
    let top = tree.root().expect("a root");
    let below: Vec<_> = tree.children_of(top).iter().map(|&child| tree.objects_below(child)).collect();
    assert_eq!(below, [vec![0, 1, 4, 5], vec![2], vec![3]], "one family, objects 2 and 3");
    assert_eq!(tree.objects_below(top), [0, 1, 2, 3, 4, 5]);
}

#[test]
fn deep_families_do_not_recurse() {
    let boxes = row(50_000);
    let member = |n: u32| vec![Member::Object(n), Member::Family(n + 1)];
    let mut members: Vec<_> = (0..49_999).map(member).collect();
    members.push(vec![Member::Object(49_999)]);
    let families = Families { members, roots: vec![Member::Family(0)] };
    let tree = ObjectTree::build(&boxes, &families).expect("a forest");
    assert_sound(&tree, &boxes);
}

#[test]
fn what_is_no_forest_is_refused() {
    use Member::{Family, Object};
    let refused = |members: &[&[Member]], roots: &[Member]| {
        let families = Families { members: members.iter().map(|m| m.to_vec()).collect(), roots: roots.to_vec() };
        ObjectTree::build(&row(2), &families).expect_err("no forest")
    };
    assert_eq!(refused(&[], &[Object(2)]), FamilyDefect::Unknown(Object(2)));
    assert_eq!(refused(&[&[Family(7)]], &[Family(0)]), FamilyDefect::Unknown(Family(7)));
    assert_eq!(refused(&[&[Object(0)]], &[Family(0), Object(0)]), FamilyDefect::Repeated(Object(0)));
    assert_eq!(refused(&[&[Family(0)]], &[Family(0)]), FamilyDefect::Repeated(Family(0)));
    assert_eq!(refused(&[&[Family(1)], &[Family(0)]], &[]), FamilyDefect::Unreachable(0));
}
