use proptest::prelude::*;

use super::*;

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![(-8i32..=8).prop_map(|n| f64::from(n) * 0.25), -2.0..2.0f64]
}

fn point() -> impl Strategy<Value = DVec3> {
    proptest::array::uniform3(number()).prop_map(DVec3::from_array)
}

fn boxes() -> impl Strategy<Value = Vec<Aabb>> {
    let a_box = (point(), point(), 0.0..0.5f64).prop_map(|(a, b, share)| Aabb::of([a, a + (b - a) * share]));
    proptest::collection::vec(a_box, 1..60)
}

fn around(boxes: &[Aabb]) -> Cube {
    Cube::around(&boxes.iter().fold(Aabb::EMPTY, |sum, b| sum.union(*b))).expect("a finite box")
}

proptest! {
    #[test]
    fn an_octree_is_sound(boxes in boxes(), max_level in 0u8..6, leaf_items in 0usize..5) {
        let limits = Limits { max_level, leaf_items };
        let tree = LinearOctree::build(around(&boxes), &boxes, limits).expect("within limits");
        prop_assert_eq!(tree.check(&boxes), Ok(()));
        let extent = |item: &u32| tree.cube().lattice_box(&boxes[*item as usize]).expect("in the cube");
        for leaf in tree.leaves() {
            let is_full = leaf.items.len() > leaf_items && leaf.cell.level() < max_level;
            prop_assert!(!is_full || leaf.items.iter().all(|item| extent(item).covers(leaf.cell)));
        }
    }

    #[test]
    fn a_point_lies_in_one_leaf(boxes in boxes(), points in proptest::collection::vec(point(), 1..20)) {
        let limits = Limits { max_level: 8, leaf_items: 2 };
        let tree = LinearOctree::build(around(&boxes), &boxes, limits).expect("within limits");
        for point in points {
            let expected = tree.leaves().find(|leaf| tree.cube().octant_at(point, leaf.cell.level()) == Some(leaf.cell));
            let found = tree.leaf_at(point);
            prop_assert_eq!(found, expected);
            for (item, bounds) in (0u32..).zip(&boxes).filter(|(_, bounds)| bounds.contains(point)) {
                prop_assert!(found.is_some_and(|leaf| leaf.items.contains(&item)), "{bounds:?}");
            }
        }
    }

    #[test]
    fn the_leaves_of_a_cell_are_those_inside_it(boxes in boxes(), level in 0u8..5, place in any::<[u32; 3]>()) {
        let limits = Limits { max_level: 4, leaf_items: 1 };
        let tree = LinearOctree::build(around(&boxes), &boxes, limits).expect("within limits");
        let cell = Octant::at(level, place.map(|c| c & ((1 << level) - 1))).expect("within its level");
        let related = |leaf: &Leaf| cell.contains(leaf.cell) || leaf.cell.contains(cell);
        prop_assert!(tree.leaves_in(cell).eq(tree.leaves().filter(related)));
    }
}

#[test]
fn an_empty_cube_is_one_leaf() {
    let cube = Cube::around(&Aabb::of([DVec3::ZERO, DVec3::ONE])).expect("a box");
    let tree = LinearOctree::build(cube, &[], Limits { max_level: 21, leaf_items: 0 }).expect("within limits");
    assert_eq!((tree.len(), tree.is_empty(), tree.check(&[])), (1, false, Ok(())));
    assert_eq!(tree.leaf_at(DVec3::splat(0.5)), Some(Leaf { cell: Octant::ROOT, items: &[] }));
    assert_eq!(tree.leaf_at(DVec3::splat(1.5)), None);
    assert_eq!(tree.fullest_leaf().map(|leaf| leaf.items.len()), Some(0));
}

#[test]
fn coincident_items_do_not_divide_for_ever() {
    let whole = Aabb::of([DVec3::ZERO, DVec3::ONE]);
    let cube = Cube::around(&whole).expect("a box");
    let limits = Limits { max_level: 21, leaf_items: 1 };
    assert_eq!(LinearOctree::build(cube, &[whole; 9], limits).expect("within limits").len(), 1);
    let point = Aabb::of([DVec3::splat(0.3)]);
    let tree = LinearOctree::build(cube, &[point; 9], limits).expect("within limits");
    assert_eq!((tree.len(), tree.fullest_leaf().map(|leaf| leaf.cell.level())), (1 + 21 * 7, Some(21)));
    let deep = Limits { max_level: 22, leaf_items: 1 };
    assert_eq!(LinearOctree::build(cube, &[whole], deep), Err(BuildDefect::TooDeep(22)));
}

#[test]
fn a_foreign_tree_is_told() {
    let boxes = [Aabb::of([DVec3::ZERO]), Aabb::of([DVec3::ONE])];
    let tree =
        LinearOctree::build(around(&boxes), &boxes, Limits { max_level: 3, leaf_items: 1 }).expect("within limits");
    assert_eq!(tree.len(), 8);
    assert_eq!(tree.check(&boxes[..1]), Err(OctreeDefect::Items { leaf: 7 }));
    let cells = tree.partition.cells()[..7].to_vec();
    let torn = LinearOctree { partition: Partition::of_leaves(*tree.cube(), cells), ..tree.clone() };
    assert_eq!(torn.check(&boxes), Err(OctreeDefect::Gap { leaf: 7 }));
}
