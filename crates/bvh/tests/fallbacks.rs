//! Segments that floats of 32 bits cannot tell: triangles in doubt go to 64 bits and then to big numbers. NUMERICS.md, section 4.

use std::sync::Arc;

use glam::DVec3;
use umbriel_bvh::TriangleBvh;
use umbriel_geometry::{LightSource, Mesh, decisions::Decisions};

/// Two triangles with a common edge, 1 m above the ground; the light comes down at a slant.
fn two_triangles() -> TriangleBvh {
    let positions = vec![[0.0, 1.0, 0.0], [0.5, 1.0, 0.0], [0.0, 1.0, 0.5], [0.5, 1.0, 0.5]];
    TriangleBvh::build(Arc::new(Mesh::new(positions, vec![[0, 1, 2], [3, 2, 1]]).expect("a mesh")))
}

#[test]
fn segments_near_a_border_go_on_to_exact_arithmetic() {
    let bvh = two_triangles();
    let mut segments = bvh.towards(LightSource::sun([0.25, -1.0, 0.125]).expect("a sun"));
    let mut any_hit = |x: f64| {
        let before = Decisions::of_thread();
        let hit = segments.any_hit(DVec3::new(x, 0.0, 0.25));
        (hit, Decisions::of_thread() - before)
    };
    // The border of the shadow is at x = 0.75 on the ground.
    let (hit, decisions) = any_hit(0.6);
    assert!(hit && decisions.double + decisions.exact == 0, "clear: {decisions:?}");
    let (hit, decisions) = any_hit(0.75 + 0.5f64.powi(40));
    assert!(!hit && decisions.double > 0 && decisions.exact == 0, "too near for 32 bits: {decisions:?}");
    let (hit, decisions) = any_hit(0.75);
    assert!(hit && decisions.pair > 0 && decisions.exact == 0, "on the border: {decisions:?}");
    let (hit, decisions) = any_hit(0.75f64.next_up());
    assert!(!hit && decisions.pair > 0 && decisions.exact == 0, "one ulp outside: {decisions:?}");
}

#[test]
fn segments_through_an_edge_with_all_its_digits_go_to_big_numbers() {
    // The middle of the segment is the middle of an edge: L = a + (b − x), without rounding.
    let (a, b, x) = ([1.1, 1.7, 1.3], [1.9, 1.2, 1.6], [1.4, 1.5, 1.8]);
    let mesh = Mesh::new(vec![a, b, [1.2, 1.1, 1.9]], vec![[0, 1, 2]]).expect("a triangle");
    let bvh = TriangleBvh::build(Arc::new(mesh));
    let lamp = LightSource::point(std::array::from_fn(|k| a[k] + (b[k] - x[k]))).expect("a lamp");
    let before = Decisions::of_thread();
    let hit = bvh.towards(lamp).any_hit(x.into());
    let decisions = Decisions::of_thread() - before;
    assert!(hit && decisions.exact > 0, "{decisions:?}");
}
