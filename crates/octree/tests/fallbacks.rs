//! Rays whose order of cells floats cannot tell: the comparison goes on in big numbers. Points whose cell rounded distances cannot
//! tell: what the roundings took away decides. Segments through edges of projected triangles. NUMERICS.md, section 4.

use std::sync::Arc;

use glam::DVec3;
use umbriel_geometry::{Aabb, Dyadic, Mesh, Ring, Sign, decisions::Decisions};
use umbriel_octree::{Cube, Octant, Partition, Projection, ProjectionOptions, Ray, Viewpoint};

#[test]
fn a_ray_through_an_edge_between_cells_is_told_exactly() {
    let cube = Cube::on_grid(&Aabb { min: DVec3::ZERO, max: DVec3::splat(8.0) }, 3).expect("a cube");
    let cells = (0..8).map(|number| Octant::ROOT.child(number).expect("not the finest")).collect();
    let partition = Partition::new(cube, cells).expect("eight cells fill the root");
    let middle = cube.min() + DVec3::splat(cube.edge() / 2.0);
    let crossed = |origin: DVec3| {
        let before = Decisions::of_thread();
        let ray = Ray::new(origin, DVec3::new(3.0, 6.0, 0.1)).expect("a ray");
        (partition.cast(&ray).count(), Decisions::of_thread() - before)
    };
    // Through the upright middle edge, a third of the direction away: that is no float, and both planes are met there.
    let (edge, decisions) = crossed(middle - DVec3::new(1.0, 2.0, 1.0));
    assert_eq!(edge, 4, "two cells before and behind, and the two beside the edge");
    assert!(decisions.exact > 0 && decisions.double > 0, "{decisions:?}");
    let (clear, decisions) = crossed(middle - DVec3::new(0.25, 1.75, 1.0));
    assert_eq!(clear, 3);
    assert_eq!(decisions.exact, 0, "{decisions:?}");
}

#[test]
fn a_point_beside_a_plane_that_is_no_float_is_in_its_own_cell() {
    let cube = Cube::around(&Aabb { min: DVec3::splat(0.1), max: DVec3::splat(0.8) }).expect("a cube");
    let (min, edge) = (0.1, cube.edge());
    let cells = f64::from(1u32 << Octant::MAX_LEVEL);
    let (mut rests_decided, mut below) = (0, 0);
    for plane in (1..1 << Octant::MAX_LEVEL).step_by(997) {
        let share = f64::from(plane) / cells;
        let near = min + edge * share;
        for x in [near.next_down(), near, near.next_up()] {
            let cell = cube.octant_at(DVec3::new(x, 0.5, 0.5), Octant::MAX_LEVEL).expect("a point of the cube");
            let [x_exact, min_exact, edge_exact] = [x, min, edge].map(Dyadic::new);
            let from_plane = x_exact - min_exact - edge_exact * Dyadic::new(share);
            let is_below = from_plane.sign() == Sign::Negative;
            assert_eq!(cell.coordinates()[0], plane - u32::from(is_below), "{x} beside plane {plane}");
            // The rounded numbers are equal: only their rests differ.
            rests_decided += usize::from(x - min == edge * share && from_plane.sign() != Sign::Zero);
            below += usize::from(is_below);
        }
    }
    assert!(rests_decided > 100 && below > 1000, "{rests_decided} by rests, {below} below");
}

#[test]
fn segments_through_an_edge_of_a_projected_triangle_go_to_big_numbers() {
    // The middle of the segment is the middle of an edge: L = a + (b − x), without rounding.
    let (a, b, x) = ([1.1, 1.7, 1.3], [1.9, 1.2, 1.6], [1.4, 1.5, 1.8]);
    let mesh = Arc::new(Mesh::new(vec![a, b, [1.2, 1.1, 1.9]], vec![[0, 1, 2]]).expect("a triangle"));
    let lamp = Viewpoint::Point(std::array::from_fn(|k| a[k] + (b[k] - x[k])).into());
    let projection = Projection::build(mesh, lamp, &ProjectionOptions::default()).expect("a projection");
    for mut segments in [projection.segments(), projection.segments_by_descent()] {
        let before = Decisions::of_thread();
        let hit = segments.any_hit(x.into());
        let decisions = Decisions::of_thread() - before;
        assert!(hit && decisions.exact > 0, "{decisions:?}");
    }
}
