use proptest::prelude::*;
use umbriel_geometry::LightSource;

use super::*;
use crate::{
    Segment,
    arbitrary::{point, whole_light, whole_point},
};

fn bvh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> TriangleBvh {
    let positions = positions.iter().map(DVec3::to_array).collect();
    TriangleBvh::build(Arc::new(Mesh::new(positions, triangles).expect("a sound mesh")))
}

fn soup(corners: Vec<[DVec3; 3]>) -> TriangleBvh {
    let triangles = (0..corners.len() as u32).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
    bvh(corners.into_iter().flatten().collect(), triangles)
}

/// Whether the closed triangle crosses the open segment; exact on whole numbers. In-plane contact is left out.
fn crosses(corners: [DVec3; 3], segment: &Segment) -> bool {
    let (light, w) = (segment.light.xyz(), segment.light.w());
    let [a, b, c] = corners.map(|corner| corner - segment.origin);
    let way = light - segment.origin * w;
    let normal = (b - a).cross(c - a);
    let (start, end) = (-normal.dot(a), normal.dot(way) - w * normal.dot(a));
    let sides = [way.dot(a.cross(b)), way.dot(b.cross(c)), way.dot(c.cross(a))];
    start * end < 0.0 && (sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0))
}

fn a_triangle() -> impl Strategy<Value = [DVec3; 3]> {
    (point(), proptest::array::uniform3(point())).prop_map(|(at, corners)| corners.map(|corner| at + corner * 0.25))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn any_hit_is_that_of_a_loop(
        corners in proptest::collection::vec(proptest::array::uniform3(whole_point()), 0..40),
        origin in whole_point(), light in whole_light(),
    ) {
        let segment = Segment::new(origin, light);
        let bvh = soup(corners.clone());
        let found = bvh.any_hit(segment, |triangle| crosses(bvh.corners(triangle), &segment));
        prop_assert_eq!(found, corners.iter().any(|&corners| crosses(corners, &segment)));
    }

    #[test]
    fn nearest_hit_is_that_of_a_loop(
        corners in proptest::collection::vec(a_triangle(), 0..150),
        copies in 0usize..5, origin in point(), direction in point(), t_max in prop_oneof![Just(f64::INFINITY), 0.0..3.0f64],
    ) {
        // Coincident triangles: the lower one wins.
        let corners: Vec<_> = corners.iter().chain(&corners[..copies.min(corners.len())]).copied().collect();
        let single = |(index, &corners): (usize, &[DVec3; 3])| {
            soup(vec![corners]).nearest_hit(origin, direction, t_max).map(|hit| Hit { triangle: index as u32, ..hit })
        };
        let nearer = |a: Hit, b: Hit| if b.t < a.t { b } else { a };
        let expected = corners.iter().enumerate().filter_map(single).reduce(nearer);
        prop_assert_eq!(soup(corners).nearest_hit(origin, direction, t_max), expected);
    }

    #[test]
    fn a_hit_is_where_it_says(corners in a_triangle(), weights in [0.0..1.0f64, 0.0..1.0], origin in point()) {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let [u, v] = if weights[0] + weights[1] > 1.0 { weights.map(|w| 1.0 - w) } else { weights };
        let target = a + (b - a) * u + (c - a) * v;
        // Only rays that see the triangle well: the tolerance below is for those.
        let steepness = normal.normalize_or_zero().dot((target - origin).normalize_or_zero()).abs();
        prop_assume!(normal.length() > 1e-2 && steepness > 0.1 && (u > 0.01 && v > 0.01 && u + v < 0.99));
        let hit = soup(vec![corners]).nearest_hit(origin, target - origin, f64::INFINITY).expect("aimed at it");
        prop_assert!((hit.t - 1.0).abs() < 1e-9 && (hit.u - u).abs() < 1e-9 && (hit.v - v).abs() < 1e-9, "{hit:?}");
    }

    #[test]
    fn no_ray_leaves_a_closed_surface(
        heights in proptest::collection::vec(0.25..4.0f64, 26), inside in proptest::array::uniform3(-0.05..0.05f64),
        edge in any::<prop::sample::Index>(), along in 0.0..=1.0f64,
    ) {
        // The 26 lattice directions around a cube, each pushed out by another length, joined over the cube's faces.
        let (positions, triangles) = star(&heights);
        let origin = DVec3::from_array(inside) * 0.1;
        let corners = triangles[edge.index(triangles.len())].map(|index| positions[index as usize]);
        let target = corners[0] + (corners[1] - corners[0]) * along;
        let bvh = bvh(positions, triangles);
        prop_assert!(bvh.nearest_hit(origin, target - origin, f64::INFINITY).is_some());
    }
}

/// A closed surface around the origin with 26 corners and 48 triangles.
fn star(heights: &[f64]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let lattice: Vec<DVec3> = (0..27)
        .filter(|&n| n != 13)
        .map(|n| DVec3::new(f64::from(n % 3 - 1), f64::from(n / 3 % 3 - 1), f64::from(n / 9 - 1)))
        .collect();
    let index = |p: DVec3| lattice.iter().position(|&q| q == p).expect("on the lattice") as u32;
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let at = |i: f64, j: f64| {
                let mut p = DVec3::ZERO;
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, i, j);
                index(p)
            };
            for (i, j) in [(-1.0, -1.0), (-1.0, 0.0), (0.0, -1.0), (0.0, 0.0)] {
                let [a, b, c, d] = [at(i, j), at(i + 1.0, j), at(i + 1.0, j + 1.0), at(i, j + 1.0)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    let positions = lattice.iter().zip(heights).map(|(p, height)| p.normalize() * *height).collect();
    (positions, triangles)
}

#[test]
fn the_mesh_is_shared() {
    let mesh = Arc::new(Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).expect("a mesh"));
    let trees = [TriangleBvh::build(Arc::clone(&mesh)), TriangleBvh::build(Arc::clone(&mesh))];
    assert_eq!(Arc::strong_count(&mesh), 1 + trees.len());
}

#[test]
fn a_ray_without_direction_hits_nothing() {
    let bvh = soup(vec![[DVec3::X, DVec3::Y, DVec3::Z]]);
    assert_eq!(bvh.nearest_hit(DVec3::ZERO, DVec3::ZERO, f64::INFINITY), None);
    assert_eq!(bvh.nearest_hit(DVec3::ZERO, DVec3::ONE, 0.3), None, "the triangle is at 1/3");
    assert!(!bvh.is_empty() && bvh.len() == 1 && bvh.tree().len() == 1);
}

#[test]
fn a_shaft_stands_for_a_point_that_is_known_roughly() {
    let bvh = soup(vec![[DVec3::new(-1.0, 1.0, -1.0), DVec3::new(1.0, 1.0, -1.0), DVec3::new(0.0, 1.0, 1.0)]]);
    let sun = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun overhead");
    let beside = DVec3::new(1.5, 0.0, 0.0);
    assert!(!bvh.any_hit(Segment::new(beside, sun), |_| true));
    let rough = Aabb { min: beside, max: beside }.widened(DVec3::splat(0.75));
    assert!(bvh.any_hit(Shaft::new(&rough, &sun), |_| true));
}
