//! Octrees of placed analytic bodies: volumes by their closed forms, cells by points of the bodies.

use std::f64::consts::PI;

use glam::{DAffine3, DQuat, DVec3};
use umbriel_geometry::{Analytic, PlacedAnalytic, Placement, Point, Region, Relation, Sign};
use umbriel_octree::{SolidOctree, VolumeBounds};

/// Sheared, turned, stretched, mirrored and off the grid.
fn askew() -> DAffine3 {
    let turn = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.0, -2.0, 0.75),
        DQuat::from_xyzw(0.5, 0.1, -0.7, 0.5).normalize(),
        DVec3::new(10.0, -3.0, 0.1),
    );
    turn * DAffine3::from_cols_array(&[1.0, 0.2, 0.0, 0.1, 1.0, -0.4, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0])
}

fn placed(body: Analytic, map: DAffine3) -> PlacedAnalytic {
    PlacedAnalytic::new(body, Placement::new(map).expect("regular")).expect("a body")
}

fn ball_as_quadric() -> Analytic {
    let mut matrix = [[0.0; 4]; 4];
    (0..3).for_each(|k| matrix[k][k] = 1.0);
    matrix[3][3] = -1.0;
    Analytic::Quadric { matrix, within: [[-3.0; 3], [0.0, 3.0, 3.0]] }
}

/// Bodies and their volumes.
fn bodies() -> Vec<(Analytic, f64)> {
    vec![
        (Analytic::Sphere { radius: 1.5 }, PI * 4.5),
        (Analytic::Ellipsoid { radii: [1.0, 0.5, 2.0] }, PI * 4.0 / 3.0),
        (Analytic::Cylinder { radius: 0.5, height: 2.0 }, PI * 0.5),
        (Analytic::Cone { radius: 1.0, height: 1.5 }, PI * 0.5),
        (Analytic::Frustum { bottom_radius: 0.5, top_radius: 1.0, height: 1.5 }, PI * 0.875),
        (Analytic::Capsule { radius: 0.5, height: 2.0 }, PI * (0.5 + 1.0 / 6.0)),
        (Analytic::Paraboloid { radius: 1.0, height: 1.0 }, PI * 0.5),
        // ∫ waist² + (end² − waist²)·(2y/h)² = h·(2·waist² + end²)/3.
        (Analytic::Hyperboloid { waist_radius: 0.5, end_radius: 1.0, height: 2.0 }, PI),
        (ball_as_quadric(), PI * 2.0 / 3.0),
        (Analytic::Disk { radius: 1.0 }, 0.0),
    ]
}

fn volume(body: &PlacedAnalytic, depth: u8) -> VolumeBounds {
    SolidOctree::build(body, depth).expect("an extent").volume()
}

#[test]
fn volumes_of_all_bodies_are_held() {
    for map in [DAffine3::IDENTITY, askew()] {
        for (body, local) in bodies() {
            let exact = local * map.matrix3.determinant().abs();
            let placed = placed(body, map);
            let [coarse, fine] = [4, 5].map(|depth| volume(&placed, depth));
            for held in [coarse, fine] {
                assert!(held.lower <= exact && exact <= held.upper, "{body:?}: {exact} and {held:?}");
            }
            assert!(coarse.lower <= fine.lower && fine.upper <= coarse.upper, "{body:?}: {coarse:?} and {fine:?}");
        }
    }
}

#[test]
fn volumes_of_an_ellipsoid_and_a_cone_close_in() {
    for body in [Analytic::Ellipsoid { radii: [1.0, 0.5, 2.0] }, Analytic::Cone { radius: 1.0, height: 1.5 }] {
        let map = askew();
        let (_, local) = bodies().into_iter().find(|(other, _)| *other == body).expect("among them");
        let exact = local * map.matrix3.determinant().abs();
        let placed = placed(body, map);
        let mut width = f64::INFINITY;
        for depth in 5..=8 {
            let tree = SolidOctree::build(&placed, depth).expect("an extent");
            let held = tree.volume();
            assert!(held.lower <= exact && exact <= held.upper, "{body:?} at depth {depth}: {exact} and {held:?}");
            // Half the edge: about half the width.
            assert!(held.upper - held.lower < 0.6 * width, "{body:?} at depth {depth}: {held:?} after {width}");
            width = held.upper - held.lower;
            assert!(width < shell(&placed, diagonal(&tree, depth)), "{body:?} at depth {depth}: {width}");
        }
    }
}

fn diagonal(tree: &SolidOctree, depth: u8) -> f64 {
    tree.partition().cube().edge() / f64::from(1 << depth) * 3f64.sqrt()
}

/// More than all points within `distance` of a convex body's surface: Steiner's formula outside, less than that inside,
/// with the area and the mean width of the box around the body, which are not below the body's.
fn shell(body: &PlacedAnalytic, distance: f64) -> f64 {
    let size = Region::bounds(body).size();
    let area = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    let mean_curvature = PI * (size.x + size.y + size.z);
    2.0 * area * distance + mean_curvature * distance.powi(2) + 4.0 / 3.0 * PI * distance.powi(3)
}

#[test]
fn a_balls_boundary_stays_within_a_cells_diagonal() {
    // Steiner: cells that meet the surface lie between the parallel surfaces at the distance of a diagonal.
    let (radius, depth) = (1.5f64, 6);
    let tree = SolidOctree::build(&placed(Analytic::Sphere { radius }, DAffine3::IDENTITY), depth).expect("an extent");
    let diagonal = diagonal(&tree, depth);
    let held = tree.volume();
    let ball = |radius: f64| 4.0 / 3.0 * PI * radius.powi(3);
    assert!(ball(radius - diagonal) < held.lower && held.upper < ball(radius + diagonal), "{held:?}");
}

#[test]
fn points_lie_in_cells_of_their_side() {
    for (body, _) in bodies() {
        let placed = placed(body, askew());
        let tree = SolidOctree::build(&placed, 5).expect("an extent");
        let (bounds, mut seen) = (Region::bounds(&placed), 0);
        for number in 0..4000u32 {
            // A lattice that fills space evenly and hits no plane between cells.
            let share = DVec3::new(0.819_172_513, 0.671_043_607, 0.549_700_478) * f64::from(number);
            let x = bounds.min + (bounds.max - bounds.min) * share.fract();
            let expected = match placed.side(&Point::exact(x), false) {
                Sign::Negative => Relation::Inside,
                Sign::Zero => Relation::Boundary,
                Sign::Positive => Relation::Outside,
            };
            let relation = tree.relation_at(x).expect("in the cube");
            assert!(relation == expected || relation == Relation::Boundary, "{body:?} at {x}: {relation:?}");
            seen += u32::from(relation == Relation::Inside);
        }
        assert!(seen > 0 || !body.is_closed(), "{body:?} has cells inside");
    }
}
