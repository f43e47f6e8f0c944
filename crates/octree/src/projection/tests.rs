use std::sync::Arc;

use glam::DVec3;
use umbriel_geometry::Mesh;

use super::{
    Layout, Numbering, Projection, ProjectionDefect, ProjectionOptions, Renewal, Viewpoint,
    budget::Budget,
    build::cell_box,
    footprint::Footprint,
    frame::Kind,
    map::{Map, Plan},
    pack::WIDTH,
};

/// A fixed sequence of numbers.
pub(super) struct Dice(pub(super) u64);

impl Dice {
    /// Between 0 and 1.
    pub(super) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Between −1 and 1.
    fn next(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    fn point(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}

/// Small triangles here and there: leaves of all sizes.
fn cloud(triangles: usize) -> Arc<Mesh> {
    let mut dice = Dice(3);
    let mut positions = Vec::new();
    for _ in 0..triangles {
        let (middle, size) = (dice.point(), 0.2 * dice.next().powi(4));
        positions.extend([0, 1, 2].map(|_| (middle + size * dice.point()).to_array()));
    }
    let indices = (0..triangles as u32).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
    Arc::new(Mesh::new(positions, indices).expect("numbers in range"))
}

fn viewpoints() -> [Viewpoint; 5] {
    let eye = DVec3::new(0.3, 1.9, -2.5);
    [
        Viewpoint::Point(DVec3::new(0.1, -0.2, 0.05)),
        Viewpoint::Point(eye),
        Viewpoint::Point(DVec3::ZERO),
        Viewpoint::Picture { eye, forward: -eye, right: DVec3::new(1.5, 0.0, 0.2), up: DVec3::Y },
        Viewpoint::Parallel(DVec3::new(0.3, -1.0, 0.2)),
    ]
}

fn built(viewpoint: Viewpoint, options: &ProjectionOptions) -> Projection {
    Projection::build(cloud(400), viewpoint, options).expect("a viewpoint")
}

#[test]
fn numbers_grow_along_every_ray_but_not_the_sources() {
    let fine = ProjectionOptions { leaf_items: 1, max_level: 7, ..ProjectionOptions::default() };
    let sections = ProjectionOptions { numbering: Numbering::Sections, ..fine };
    let mut dice = Dice(5);
    let targets: Vec<DVec3> = (0..4_000).map(|_| dice.point() * 2.0).collect();
    let disorder = |viewpoint, options| {
        let projection = built(viewpoint, options);
        targets.iter().filter(|&&x| projection.disorder(x) > 0).count()
    };
    for viewpoint in viewpoints() {
        assert_eq!(disorder(viewpoint, &fine), 0, "{viewpoint:?}");
    }
    let wrong: usize = viewpoints().into_iter().map(|viewpoint| disorder(viewpoint, &sections)).sum();
    assert!(wrong > 10, "the source's order fails on {wrong} rays");
}

#[test]
fn a_point_of_a_triangle_in_a_leaf_finds_its_pack_in_its_cell() {
    let mut dice = Dice(9);
    for viewpoint in viewpoints() {
        let mut found = 0;
        // Of few levels, leaves have several packs.
        for (rays, max_level) in [(1, 6), (1 << 16, 6), (1 << 24, 6), (1 << 24, 1)] {
            let options = ProjectionOptions { leaf_items: 1, max_level, rays, ..ProjectionOptions::default() };
            let projection = built(viewpoint, &options);
            let kind = projection.frame.kind;
            for (number, &cell) in (0u32..).zip(&projection.tree.cells) {
                // Corners and points of edges are as good as others.
                let items = projection.tree.items(number as usize);
                let chosen = items.len() / 2;
                let pack = projection.leaves[number as usize].first_pack + (chosen / WIDTH) as u32;
                let triangle = projection.corners(items[chosen]).map(|corner| projection.frame.local(corner));
                let [u, v] = [0, 1].map(|_| (dice.next() * 0.75 + 0.25).clamp(0.0, 0.5));
                let point = triangle[0] + (triangle[1] - triangle[0]) * u + (triangle[2] - triangle[0]) * v;
                let (min, max) = cell_box(&projection.root, cell);
                if point.cmplt(min).any() || point.cmpgt(max).any() {
                    continue;
                }
                found += 1;
                let size = point.abs().max_element();
                let (direction, face) = match kind {
                    Kind::Parallel => (point.with_z(1.0), 4),
                    _ => (point / size, 2 * axis_of(point) + usize::from(point[axis_of(point)] < 0.0)),
                };
                let place = [direction[(face / 2 + 1) % 3], direction[(face / 2 + 2) % 3]];
                if place.iter().any(|x| x.abs() > 1.0) {
                    continue;
                }
                for section in &projection.faces[face] {
                    let run = section.map.run_at(place, 0.0).expect("one cell");
                    assert!(run.contains(&pack), "{viewpoint:?}, leaf {number}, pack {pack}: {point}");
                    assert!(run.is_sorted_by(|a, b| a < b));
                }
            }
        }
        assert!(found > 100);
    }
}

fn axis_of(point: DVec3) -> usize {
    (0..3).fold(0, |best, axis| if point[axis].abs() > point[best].abs() { axis } else { best })
}

#[test]
fn memory_is_bounded_by_coarser_maps_and_trees() {
    let all = built(viewpoints()[0], &ProjectionOptions::default()).report();
    assert!(!all.is_coarsened);
    for memory in [1 << 16, 1 << 14, 1 << 12] {
        let report = built(viewpoints()[0], &ProjectionOptions { memory, ..ProjectionOptions::default() }).report();
        assert!(report.is_coarsened && report.tree_bytes + report.map_bytes < all.tree_bytes + all.map_bytes);
        assert!(report.depth == 0 || report.tree_bytes + report.map_bytes <= memory, "{report:?} within {memory}");
    }
}

#[test]
fn leaves_that_are_seen_everywhere_have_fewer_tiles_where_memory_ends() {
    // Parallel rays see boxes larger than the face in all 64 tiles that so many leaves ask for; 12 bytes each while they are sorted.
    let size = DVec3::splat(2.0);
    let everywhere = |leaf| (leaf, Footprint::new(Kind::Parallel, 4, -size, size).expect("a box"));
    let leaves: Vec<(u32, Footprint)> = (0..512).map(everywhere).collect();
    let of = |memory| {
        let budget = Budget::new(memory);
        let map = Map::new(&leaves, &Plan { rays: 0.0, max_fineness: 0, max_side: 1 << 16, budget: &budget });
        (map.side(), map.is_coarser(), map.len(), budget.is_over())
    };
    let most = 512 * 64 * 12;
    assert_eq!(of(most), (8, false, [64, 512 * 64], false));
    assert_eq!(of(most - 1), (4, true, [16, 512 * 16], false));
    // The least map is whole, whatever it takes.
    assert_eq!(of(0), (1, true, [1, 512], true));
}

#[test]
fn large_triangles_spend_no_more_memory_than_allowed_and_lose_nothing() {
    // Each meets all leaves on its way through the cube: hundreds of megabytes at the level asked for.
    let mut dice = Dice(13);
    let positions = (0..3 * 2_000).map(|_| dice.point().to_array()).collect();
    let mesh = Mesh::new(positions, (0..2_000).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect()).expect("in range");
    let (mesh, eye) = (Arc::new(mesh), DVec3::new(0.3, 0.4, -3.0));
    let built = |memory| {
        let options = ProjectionOptions { memory, max_level: 7, ..ProjectionOptions::default() };
        Projection::build(Arc::clone(&mesh), Viewpoint::Point(eye), &options).expect("a viewpoint")
    };
    let (small, least) = (built(1 << 23), built(1));
    let report = small.report();
    assert!(report.is_coarsened && report.tree_bytes + report.map_bytes <= 1 << 23, "{report:?}");
    for _ in 0..1_000 {
        let direction = dice.point() - eye;
        let hit =
            |projection: &Projection| projection.nearest_hit(eye, direction, f64::INFINITY).expect("a ray of the view");
        assert_eq!(hit(&small), hit(&least), "{direction}");
    }
}

/// The cloud after some of its triangles were moved: together, or one by one; within its box, as a rule.
fn moved(mesh: &Mesh, dice: &mut Dice) -> Arc<Mesh> {
    let mut triangles: Vec<[DVec3; 3]> =
        mesh.triangles().iter().map(|t| t.map(|corner| mesh.positions()[corner as usize])).collect();
    let (count, shift) = (1 + (dice.next().abs() * 4.0) as usize, dice.point() * 0.125);
    let is_far = dice.next() > 0.9;
    for _ in 0..count {
        let chosen = (dice.next().abs() * triangles.len() as f64) as usize % triangles.len();
        let limit = if is_far { 3.0 } else { 0.875 };
        triangles[chosen] = triangles[chosen].map(|x| (x + shift).clamp(DVec3::splat(-limit), DVec3::splat(limit)));
    }
    match (dice.next() * 5.0) as i32 {
        4 => triangles.push([dice.point(), dice.point(), dice.point()].map(|x| x * 0.5)),
        3 => _ = triangles.pop(),
        _ => {}
    }
    let count = triangles.len() as u32;
    let positions = triangles.iter().flatten().map(|x| x.to_array()).collect();
    Arc::new(Mesh::new(positions, (0..count).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect()).expect("in range"))
}

#[test]
fn what_is_renewed_is_what_is_built() {
    let mut dice = Dice(21);
    let (mut parts, mut wholes) = (0, 0);
    let one = ProjectionOptions { memory: 1 << 30, leaf_items: 2, max_level: 6, ..ProjectionOptions::default() };
    // Of many triangles a leaf has several packs.
    for options in [
        one,
        ProjectionOptions { memory: 1 << 16, ..one },
        ProjectionOptions { layout: Layout::MapPerSection, ..one },
        ProjectionOptions { leaf_items: 24, ..one },
    ] {
        for viewpoint in viewpoints() {
            let mut projection = built(viewpoint, &options);
            for step in 0..24 {
                let mesh = moved(&projection.mesh, &mut dice);
                let (renewed, renewal) = projection.renewed(Arc::clone(&mesh)).expect("a viewpoint");
                let truth = Projection::build(mesh, viewpoint, &options).expect("a viewpoint");
                assert!(renewed.tree == truth.tree, "{viewpoint:?}, step {step}: {renewal:?}");
                assert!(renewed.leaves == truth.leaves && renewed.packs == truth.packs);
                assert!(renewed.owners == truth.owners);
                assert!(renewed.faces == truth.faces, "{viewpoint:?}, step {step}: {renewal:?}");
                assert_eq!((renewed.report, renewed.options), (truth.report, truth.options));
                assert!(renewed.frame == truth.frame && renewed.root == truth.root && renewed.error == truth.error);
                assert!(renewal.is_whole || renewal.leaves < truth.report.leaves);
                (parts, wholes) = (parts + usize::from(!renewal.is_whole), wholes + usize::from(renewal.is_whole));
                projection = renewed;
            }
        }
    }
    assert!(parts > 100 && wholes > 100, "{parts} in part, {wholes} wholly");
}

#[test]
fn what_did_not_move_is_not_made_anew() {
    let projection = built(viewpoints()[1], &ProjectionOptions::default());
    let (same, renewal) = projection.renewed(Arc::clone(&projection.mesh)).expect("a viewpoint");
    assert_eq!(renewal, Renewal::default());
    assert!(same.tree == projection.tree && same.faces == projection.faces);
}

#[test]
fn numbers_of_leaves_with_several_packs_grow_along_rays() {
    let mut dice = Dice(5);
    for viewpoint in viewpoints() {
        let projection = built(viewpoint, &ProjectionOptions { max_level: 2, ..ProjectionOptions::default() });
        assert!(projection.packs.len() > projection.leaves.len());
        assert!((0..1_000).all(|_| projection.disorder(dice.point()) == 0), "{viewpoint:?}");
    }
}

#[test]
fn a_map_a_section_holds_what_one_map_holds() {
    let of = |layout| built(viewpoints()[3], &ProjectionOptions { layout, ..ProjectionOptions::default() }).report();
    let (one, many) = (of(Layout::OneMap), of(Layout::MapPerSection));
    assert_eq!((one.maps, one.leaves), (1, many.leaves));
    assert!(many.maps > 4);
}

#[test]
fn what_is_no_viewpoint_is_refused() {
    let refused = |viewpoint| Projection::build(cloud(4), viewpoint, &ProjectionOptions::default()).err();
    let flat = Viewpoint::Picture { eye: DVec3::ZERO, forward: DVec3::X, right: DVec3::Y, up: DVec3::Y };
    for viewpoint in [flat, Viewpoint::Parallel(DVec3::ZERO), Viewpoint::Point(DVec3::splat(f64::NAN))] {
        assert_eq!(refused(viewpoint), Some(ProjectionDefect::NoView), "{viewpoint:?}");
    }
    let deep = ProjectionOptions { max_level: 22, ..ProjectionOptions::default() };
    let error = Projection::build(cloud(4), viewpoints()[0], &deep).err();
    assert_eq!(error, Some(ProjectionDefect::TooDeep(22)));
}

#[test]
fn scenes_without_triangles_or_extent_are_scenes() {
    let empty = Arc::new(Mesh::new(Vec::new(), Vec::new()).expect("nothing"));
    let point = Arc::new(Mesh::new(vec![[1.0, 2.0, 3.0]], vec![[0, 0, 0]]).expect("a point"));
    for viewpoint in viewpoints() {
        for mesh in [&empty, &point] {
            let options = ProjectionOptions::default();
            let projection = Projection::build(Arc::clone(mesh), viewpoint, &options).expect("a viewpoint");
            assert!(!projection.any_hit(DVec3::new(-3.0, -2.0, -1.0)));
        }
    }
    let eye = DVec3::new(1.0, 2.0, 3.0);
    let at_eye = Projection::build(point, Viewpoint::Point(eye), &ProjectionOptions::default()).expect("a viewpoint");
    assert!(!at_eye.any_hit(eye) && !at_eye.any_hit(DVec3::ZERO));
}
