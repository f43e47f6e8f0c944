//! The linear octree against a plain octree with pointers, and rays against separating axes in exact numbers.

mod bodies;
mod pointer;

use glam::DVec3;
use proptest::prelude::*;
use umbriel_geometry::{Aabb, Dyadic, Region, Relation, Ring, Sign};
use umbriel_octree::{Cube, Direction, Octant, Ray, SolidOctree};

use bodies::octahedra;
use pointer::Node;

/// Numbers on the planes between cells, and others.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![2 => (-8i32..=8).prop_map(|n| f64::from(n) * 0.25), 1 => -2.0..2.0f64]
}

fn point() -> impl Strategy<Value = DVec3> {
    proptest::array::uniform3(number()).prop_map(DVec3::from_array)
}

fn bodies() -> impl Strategy<Value = Vec<(DVec3, f64)>> {
    let radius = prop_oneof![Just(0.5), Just(1.0), 0.2..1.2f64];
    proptest::collection::vec((point(), radius), 1..4)
}

/// A cube that holds all bodies, its planes on a grid.
fn cube() -> Cube {
    Cube::on_grid(&Aabb { min: DVec3::splat(-4.0), max: DVec3::splat(4.0) }, 21).expect("a cube of edge 8")
}

fn both(bodies: &[(DVec3, f64)], depth: u8) -> (SolidOctree, Node) {
    let region = octahedra(bodies);
    (SolidOctree::build_in(cube(), &region, depth).expect("on the grid"), Node::of(&region, &cube(), depth))
}

fn whole() -> Aabb {
    cube().bounds_of(Octant::ROOT)
}

/// How a · x of the box's corners compares with a · (the points): by separating axes, exactly.
fn separated(axis: &[Dyadic; 3], cell: &Aabb, points: &[DVec3]) -> bool {
    let dot = |x: DVec3| (0..3).fold(Dyadic::zero(), |sum, i| sum + axis[i].clone() * Dyadic::new(x[i]));
    let corner = |n: usize| {
        let pick = |i: usize| if n >> i & 1 == 0 { cell.min[i] } else { cell.max[i] };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let heights: Vec<Dyadic> = (0..8).map(|n| dot(corner(n))).collect();
    let is = |sign: Sign| points.iter().all(|&x| heights.iter().all(|height| (dot(x) - height.clone()).sign() == sign));
    is(Sign::Positive) || is(Sign::Negative)
}

/// Whether the closed segment or ray meets the closed box.
fn meets(cell: &Aabb, origin: DVec3, end: Result<DVec3, DVec3>) -> bool {
    let along: [Dyadic; 3] = std::array::from_fn(|i| match end {
        Ok(to) => Dyadic::new(to[i]) - Dyadic::new(origin[i]),
        Err(direction) => Dyadic::new(direction[i]),
    });
    let zero = Dyadic::zero;
    let crosses = (0..3).map(|i| {
        let mut axis = [zero(), zero(), zero()];
        axis[(i + 1) % 3] = -along[(i + 2) % 3].clone();
        axis[(i + 2) % 3] = along[(i + 1) % 3].clone();
        axis
    });
    let beside = (0..3).any(|i| match end {
        Ok(to) => origin[i].max(to[i]) < cell.min[i] || origin[i].min(to[i]) > cell.max[i],
        Err(along) => (origin[i] < cell.min[i] && along[i] <= 0.0) || (origin[i] > cell.max[i] && along[i] >= 0.0),
    });
    !beside && !crosses.into_iter().any(|axis| separated(&axis, cell, &[origin]))
}

/// Checks a cast against all leaves.
fn check_cast(tree: &SolidOctree, ray: &Ray, origin: DVec3, end: Result<DVec3, DVec3>) -> Result<(), TestCaseError> {
    let crossings: Vec<_> = tree.cast(ray).map(|(crossing, _)| crossing).collect();
    prop_assert!(crossings.is_sorted_by(|a, b| a.enter <= b.enter));
    prop_assert!(crossings.iter().all(|crossing| crossing.enter <= crossing.exit));
    let mut found: Vec<usize> = crossings.iter().map(|crossing| crossing.leaf).collect();
    found.sort_unstable();
    let bounds = |leaf: usize| tree.partition().cube().bounds_of(tree.partition().cells()[leaf]);
    let expected: Vec<usize> = (0..tree.relations().len()).filter(|&leaf| meets(&bounds(leaf), origin, end)).collect();
    prop_assert_eq!(found, expected);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn same_leaves_and_points(bodies in bodies(), depth in 0u8..6, points in proptest::collection::vec(point(), 30)) {
        let (tree, rival) = both(&bodies, depth);
        prop_assert_eq!(tree.leaves().collect::<Vec<_>>(), rival.list());
        prop_assert_eq!(tree.partition().check(), Ok(()));
        for point in points {
            prop_assert_eq!(tree.relation_at(point), Some(rival.at(whole(), point)));
        }
        for cut in 0..=depth {
            let view = tree.at_depth(cut);
            prop_assert_eq!(view.leaves().collect::<Vec<_>>(), rival.cut(cut).list());
            prop_assert!(view.leaves().eq(view.to_octree().leaves()));
        }
    }

    #[test]
    fn every_leaf_says_what_the_region_says(bodies in bodies(), depth in 0u8..5) {
        let region = octahedra(&bodies);
        let (tree, _) = both(&bodies, depth);
        for (cell, relation) in tree.leaves() {
            prop_assert_eq!(relation, region.relation(&cube().bounds_of(cell)));
        }
    }

    #[test]
    fn same_set_operations(a in bodies(), b in bodies(), depths in (0u8..5, 0u8..5)) {
        let ((a, rival_a), (b, rival_b)) = (both(&a, depths.0), both(&b, depths.1));
        let not = |relation| match relation {
            Relation::Inside => Relation::Outside,
            Relation::Outside => Relation::Inside,
            Relation::Boundary => Relation::Boundary,
        };
        let difference = |a: Relation, b: Relation| match b {
            Relation::Inside => Relation::Outside,
            Relation::Outside => a,
            Relation::Boundary => if a == Relation::Outside { a } else { b },
        };
        let expected = [Ord::max as fn(Relation, Relation) -> Relation, Ord::min, difference];
        let found = [a.union(&b), a.intersection(&b), a.difference(&b)];
        for (found, rule) in found.into_iter().zip(expected) {
            let found = found.expect("one cube");
            prop_assert_eq!(found.partition().check(), Ok(()));
            prop_assert_eq!(found.leaves().collect::<Vec<_>>(), rival_a.combined(&rival_b, rule).list());
        }
        prop_assert!(a.complement().leaves().map(|(cell, said)| (cell, not(said))).eq(a.leaves()));
        prop_assert_eq!(a.complement().complement(), a);
    }

    #[test]
    fn neighbours_are_the_leaves_that_touch(bodies in bodies(), depth in 0u8..4, pick in any::<prop::sample::Index>()) {
        let (tree, _) = both(&bodies, depth);
        let (partition, leaf) = (tree.partition(), pick.index(tree.relations().len()));
        let bounds = |leaf: usize| cube().bounds_of(partition.cells()[leaf]);
        let own = bounds(leaf);
        let others: Vec<usize> = (0..partition.cells().len()).filter(|&other| other != leaf).collect();
        let touching: Vec<usize> = others.iter().copied().filter(|&other| own.meets(&bounds(other))).collect();
        prop_assert_eq!(partition.touching(leaf), touching);
        for direction in Direction::all() {
            // The part of the leaf's own closed cell that lies in that direction, moved out by half the finest cell.
            let cell = partition.cells()[leaf];
            let beside = cell.neighbour(direction).map(|beside| cube().bounds_of(beside));
            let shared = beside.map(|beside| Aabb { min: own.min.max(beside.min), max: own.max.min(beside.max) });
            let expected: Vec<usize> = others.iter().copied().filter(|&other| {
                let overlaps = |a: &Aabb, b: &Aabb| (0..3).all(|i| a.min[i] < b.max[i] && b.min[i] < a.max[i]);
                let (Some(beside), Some(shared)) = (&beside, &shared) else { return false };
                overlaps(&bounds(other), beside) && bounds(other).meets(shared) && touches_whole_axes(&bounds(other), shared)
            }).collect();
            prop_assert_eq!(partition.neighbours(leaf, direction), expected, "{:?}", direction);
        }
    }

    #[test]
    fn rays_meet_the_leaves_that_they_meet(bodies in bodies(), depth in 0u8..4, origin in point(), along in point()) {
        let (tree, _) = both(&bodies, depth);
        prop_assume!(along != DVec3::ZERO);
        check_cast(&tree, &Ray::new(origin, along).expect("in range"), origin, Err(along))?;
        let to = along * 3.0;
        check_cast(&tree, &Ray::segment(origin, to).expect("in range"), origin, Ok(to))?;
    }

    #[test]
    fn rays_along_planes_and_edges(bodies in bodies(), start in proptest::array::uniform3(-8i32..=8), steps in proptest::array::uniform3(-1i32..=1), scale in 1e-3..1e3f64) {
        prop_assume!(steps != [0; 3]);
        let (tree, _) = both(&bodies, 3);
        let origin = DVec3::from_array(start.map(|n| f64::from(n) * 0.5));
        let along = DVec3::from_array(steps.map(f64::from)) * scale;
        check_cast(&tree, &Ray::new(origin, along).expect("in range"), origin, Err(along))?;
    }

    #[test]
    fn rays_in_cubes_off_any_grid(min in point(), edge in 0.1..3.0f64, origin in point(), to in point()) {
        // Planes that are no floats: only that none is missed can be seen with boxes rounded inward.
        let cube = Cube::new(min, edge).expect("in range");
        let cells = (0..8).filter_map(|n| Octant::ROOT.child(n)).flat_map(|cell| cell.children()).collect();
        let partition = umbriel_octree::Partition::new(cube, cells).expect("all cells of level 2");
        let found: Vec<usize> = partition.cast(&Ray::segment(origin, to).expect("in range")).map(|c| c.leaf).collect();
        for (leaf, &cell) in partition.cells().iter().enumerate() {
            let outer = cube.bounds_of(cell);
            let inward = |x: DVec3, turn: fn(f64) -> f64| DVec3::new(turn(turn(x.x)), turn(turn(x.y)), turn(turn(x.z)));
            let inner = Aabb { min: inward(outer.min, f64::next_up), max: inward(outer.max, f64::next_down) };
            prop_assert!(!meets(&inner, origin, Ok(to)) || found.contains(&leaf));
            prop_assert!(meets(&outer, origin, Ok(to)) || !found.contains(&leaf));
        }
    }
}

/// Whether `other` shares more than its rim with a common face or edge: an overlap along every axis on which it extends.
fn touches_whole_axes(other: &Aabb, shared: &Aabb) -> bool {
    (0..3).all(|i| shared.min[i] == shared.max[i] || (other.min[i] < shared.max[i] && shared.min[i] < other.max[i]))
}
