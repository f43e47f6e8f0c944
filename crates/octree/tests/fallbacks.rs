//! Rays whose order of cells floats cannot tell: the comparison goes on in big numbers. NUMERICS.md, section 4.

use glam::DVec3;
use umbriel_geometry::{Aabb, decisions::Decisions};
use umbriel_octree::{Cube, Octant, Partition, Ray};

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
