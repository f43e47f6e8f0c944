//! Closed forms, refusals, and the stored form.

mod bodies;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{Aabb, Cuboid, Facets, Placement, Region, Relation};
use umbriel_octree::{BuildDefect, Cube, CubesDiffer, Limits, LinearOctree, Octant, Partition, SolidOctree};

fn cuboid(size: [f64; 3], centre: DVec3) -> Facets {
    Facets::of_cuboid(&Cuboid { size }, &Placement::new(DAffine3::from_translation(centre)).expect("regular"))
}

fn cube() -> Cube {
    Cube::on_grid(&Aabb { min: DVec3::splat(-4.0), max: DVec3::splat(4.0) }, 21).expect("a cube of edge 8")
}

#[test]
fn volumes_of_a_box_close_in() {
    // The faces lie on planes between cells: of n + 2·2 cells along an axis that the closed box meets, two are boundary
    // at each end. (w − 2h)(…) is inside, (w + 2h)(…) is not outside.
    let size = [2.0, 3.0, 1.0];
    for depth in 4..8 {
        let tree = SolidOctree::build_in(cube(), &cuboid(size, DVec3::ZERO), depth).expect("on the grid");
        let edge = 8.0 / f64::from(1 << depth);
        let with = |change: f64| size.iter().map(|side| side + change * edge).product::<f64>();
        let volume = tree.volume();
        assert_eq!((volume.lower, volume.upper), (with(-2.0), with(2.0)), "depth {depth}");
    }
}

#[test]
fn volumes_hold_a_tetrahedral_number() {
    // An octahedron of radius r holds 4r³/3.
    for depth in 0..7 {
        let volume = SolidOctree::build(&bodies::octahedra(&[(DVec3::new(0.1, 0.2, 0.3), 1.5)]), depth)
            .expect("an extent")
            .volume();
        let exact = 4.0 / 3.0 * 1.5f64.powi(3);
        assert!(volume.lower <= exact && exact <= volume.upper, "{volume:?}");
        let edge = 4.0 / f64::from(1 << depth);
        assert!(volume.upper - volume.lower <= 60.0 * edge.max(0.1), "{volume:?} at depth {depth}");
    }
}

#[test]
fn set_operations_of_boxes_have_their_volumes() {
    let of = |centre: f64| {
        SolidOctree::build_in(cube(), &cuboid([2.0; 3], DVec3::new(centre, 0.0, 0.0)), 7).expect("on the grid")
    };
    let (a, b) = (of(0.0), of(1.0));
    for (tree, exact) in [(a.union(&b), 12.0), (a.intersection(&b), 4.0), (a.difference(&b), 4.0)] {
        let volume = tree.expect("one cube").volume();
        assert!(volume.lower < exact && exact < volume.upper, "{volume:?} around {exact}");
        assert!(volume.upper - volume.lower < 6.0, "{volume:?}");
    }
    let other = SolidOctree::build(&cuboid([2.0; 3], DVec3::ZERO), 3).expect("an extent");
    assert_eq!(a.union(&other), Err(CubesDiffer));
}

#[test]
fn what_cannot_be_built_is_refused() {
    let body = cuboid([2.0; 3], DVec3::ZERO);
    assert_eq!(SolidOctree::build(&body, 22), Err(BuildDefect::TooDeep(22)));
    assert_eq!(SolidOctree::build(&Facets::default(), 3), Err(BuildDefect::NoCube));
    let odd = Cube::new(DVec3::ZERO, 0.1).expect("in range");
    assert_eq!(SolidOctree::build_in(odd, &body, 21), Err(BuildDefect::Lattice(21)));
    let far = cuboid([1.0; 3], DVec3::splat(2f64.powi(45)));
    assert_eq!(SolidOctree::build(&far, 21), Err(BuildDefect::NoCube), "no floats between");
    assert!(SolidOctree::build(&far, 4).is_ok());
}

#[test]
fn grids_hold_their_boxes_and_their_planes_are_floats() {
    let numbers = [-3.7, -1.0, -0.1, 0.0, 1e-30, 0.3, 1.0, 1e6 + 0.1];
    for (a, b) in numbers.iter().flat_map(|&a| numbers.iter().map(move |&b| (a, b))).filter(|(a, b)| a < b) {
        let bounds = Aabb { min: DVec3::new(a, 0.0, a), max: DVec3::new(b, 0.0, b) };
        let cube = Cube::on_grid(&bounds, 9).expect("near the origin");
        let whole = cube.bounds_of(Octant::ROOT);
        assert!(whole.contains(bounds.min) && whole.contains(bounds.max), "{a} {b}");
        assert!(cube.edge() < 4.0 * (b - a).next_up(), "{a} {b}: {}", cube.edge());
        let step = cube.edge() / 512.0;
        let cell = Octant::at(9, [511, 17, 300]).expect("within its level");
        let low = cube.min() + DVec3::new(511.0, 17.0, 300.0) * step;
        assert_eq!(cube.bounds_of(cell), Aabb { min: low, max: low + DVec3::splat(step) });
    }
}

#[test]
fn a_plane_region_of_ones_own_can_be_built() {
    /// The half space y ≤ 0, in a box.
    struct Ground;
    impl Region for Ground {
        fn bounds(&self) -> Aabb {
            Aabb { min: DVec3::splat(-1.0), max: DVec3::ONE }
        }
        fn parts(&self) -> u32 {
            1
        }
        fn meets(&self, _: u32, cell: &Aabb) -> bool {
            cell.min.y <= 0.0 && 0.0 <= cell.max.y
        }
        fn encloses(&self, point: DVec3) -> bool {
            point.y < 0.0
        }
    }
    let tree = SolidOctree::build(&Ground, 4).expect("an extent");
    let volume = tree.volume();
    assert_eq!((volume.lower, volume.upper), (4.0 - 0.5, 4.0 + 0.5));
    assert_eq!(tree.relation_of(Octant::ROOT), Relation::Boundary);
    assert_eq!(tree.relation_at(DVec3::new(0.0, -0.5, 0.0)), Some(Relation::Inside));
}

#[test]
fn stored_octrees_come_back() {
    let tree = SolidOctree::build_in(cube(), &bodies::octahedra(&[(DVec3::splat(0.3), 1.7)]), 5).expect("on the grid");
    let text = serde_json::to_string(&tree).expect("plain data");
    assert_eq!(serde_json::from_str::<SolidOctree>(&text).expect("its own form"), tree);
    let text = serde_json::to_string(tree.partition()).expect("plain data");
    assert_eq!(&serde_json::from_str::<Partition>(&text).expect("its own form"), tree.partition());
    let boxes: Vec<Aabb> = (0..40).map(|n| Aabb::of([DVec3::splat(f64::from(n) * 0.1)])).collect();
    let odd = Cube::around(&boxes.iter().fold(Aabb::EMPTY, |sum, b| sum.union(*b))).expect("not empty");
    let items = LinearOctree::build(odd, &boxes, Limits { max_level: 9, leaf_items: 2 }).expect("within limits");
    let text = serde_json::to_string(&items).expect("plain data");
    assert_eq!(serde_json::from_str::<LinearOctree>(&text).expect("its own form"), items);
}

#[test]
fn hostile_content_is_refused() {
    let one = "4607182418800017408"; // 1.0
    let solid = |version: u32, edge: &str, leaves: &str| {
        let text = format!(r#"{{"version":{version},"cube":[0,0,0,{edge}],"leaves":[{leaves}]}}"#);
        serde_json::from_str::<SolidOctree>(&text).map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(solid(1, one, "0"), Ok(()));
    assert_eq!(solid(1, one, "1,1,1,1,1,1,1,65"), Ok(()));
    let nan = f64::NAN.to_bits().to_string();
    for (content, why) in [
        (solid(2, one, "0"), "version 2"),
        (solid(1, &nan, "0"), "the cube"),
        (solid(1, "13830554455654793216", "0"), "the cube"), // −1
        (solid(1, one, ""), "leaf 0"),
        (solid(1, one, "0,0"), "leaf 1"),
        (solid(1, one, "22"), "leaf 0"),
        (solid(1, one, "1,1,1,1,1,1,1"), "leaf 7"),
        (solid(1, one, "2,1"), "leaf 1"),
        (solid(1, one, "96"), "leaf 0"),
        (solid(1, one, "128"), "leaf 0"),
        (solid(1, one, "1,1,1,1,1,1,1,1"), "should be one"),
    ] {
        assert!(content.as_ref().is_err_and(|text| text.contains(why)), "{content:?}, not {why}");
    }
    for (ends, items) in [("", ""), ("1", ""), ("2", "3,3"), ("2", "4,3"), ("4294967295", "1")] {
        let text = format!(r#"{{"version":1,"cube":[0,0,0,{one}],"leaves":[0],"ends":[{ends}],"items":[{items}]}}"#);
        let error = serde_json::from_str::<LinearOctree>(&text).expect_err("out of order").to_string();
        assert!(error.contains("items of leaf"), "{error}");
    }
}
