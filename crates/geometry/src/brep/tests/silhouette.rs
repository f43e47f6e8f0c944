use glam::{DAffine3, DQuat};

use super::*;
use crate::{
    Facets, LightSource, Placement, Rectangle,
    blocking::{Probe, polygon_blocks},
};

fn light(is_sun: bool, at: DVec3) -> LightSource {
    let made = if is_sun { LightSource::sun(at.to_array()) } else { LightSource::point(at.to_array()) };
    made.unwrap_or(LightSource::point([9.0, 8.0, 7.0]).expect("a lamp"))
}

fn some_face_blocks(body: &Brep, x: DVec3, light: &LightSource) -> bool {
    (0..body.face_count()).any(|face| {
        let corners: Vec<Point> = body.face(face).map(|vertex| body.vertex(vertex)).collect();
        polygon_blocks(&corners, &Probe::<crate::Dyadic>::at(x), light)
    })
}

proptest! {
    #[test]
    fn exact_corners_are_decided(cloud in lattice_cloud(), is_sun: bool, at in lattice_point(4), turn in 0.0..1.0f64) {
        let Ok(body) = Brep::hull(cloud) else { return Ok(()) };
        let light = light(is_sun, at);
        let Some(silhouette) = body.silhouette(&light) else { return Ok(()) };
        // Corners that are no floats, within half an ulp of a lattice point's surroundings.
        let map = DAffine3::from_rotation_translation(DQuat::from_rotation_y(turn), DVec3::NEG_Y);
        let facets = Facets::of_rectangle(&Rectangle { size: [2.0, 4.0] }, &Placement::new(map).expect("regular"));
        for corner in 0..4 {
            let x = facets.point(corner);
            let blocked = (0..body.face_count()).any(|face| {
                let corners: Vec<Point> = body.face(face).map(|vertex| body.vertex(vertex)).collect();
                let bounds = Point::within(x.position, x.slack);
                polygon_blocks(&corners, &Probe::<crate::Dyadic>::new(bounds, || x.to_exact()), &light)
            });
            prop_assert_eq!(silhouette.blocks(&x), blocked);
        }
    }

    #[test]
    fn the_outline_decides_as_the_faces_do(
        cloud in lattice_cloud(), is_sun: bool, at in lattice_point(4), x in proptest::collection::vec(lattice_point(6), 1..20),
    ) {
        let Ok(body) = Brep::hull(cloud) else { return Ok(()) };
        let light = light(is_sun, at);
        let Some(silhouette) = body.silhouette(&light) else {
            let inside = (0..body.face_count()).all(|face| body.light_side(face, &light) != Sign::Positive);
            prop_assert!(!light.is_sun() && inside);
            return Ok(());
        };
        for &x in x.iter().chain(body.vertices()) {
            prop_assert_eq!(silhouette.blocks(&Point::exact(x)), some_face_blocks(&body, x, &light), "at {}", x);
        }
        let blocked: Vec<Point> = x.iter().map(|&x| Point::exact(x)).filter(|x| silhouette.blocks(x)).collect();
        prop_assert!(silhouette.covers(blocked.iter().copied()));
        prop_assert_eq!(silhouette.covers(x.iter().map(|&x| Point::exact(x))), blocked.len() == x.len());
        // Halves and thirds of the way between covered points are covered.
        for pair in blocked.windows(2) {
            let between = pair[0].position * 0.5 + pair[1].position * 0.5;
            prop_assert!(some_face_blocks(&body, between, &light));
        }
    }

    #[test]
    fn outlines_are_simple_cycles(cloud in lattice_cloud(), is_sun: bool, at in lattice_point(4)) {
        let Ok(body) = Brep::hull(cloud) else { return Ok(()) };
        let light = light(is_sun, at);
        let Some(silhouette) = body.silhouette(&light) else { return Ok(()) };
        let outline = silhouette.outline();
        let starts: BTreeSet<u32> = outline.iter().map(|&h| body.half_edges()[h as usize].start).collect();
        prop_assert_eq!(starts.len(), outline.len(), "no vertex twice");
        for (&h, &next) in outline.iter().zip(outline.iter().cycle().skip(1)) {
            prop_assert_eq!(body.end(h), body.half_edges()[next as usize].start);
        }
        // All half-edges between seen and other faces, not only one cycle of them.
        let is_seen = |face: u32| body.light_side(face as usize, &light) == Sign::Positive;
        let expected: BTreeSet<u32> = (0..body.half_edges().len() as u32)
            .filter(|&h| {
                let half_edge = body.half_edges()[h as usize];
                is_seen(half_edge.face) && !is_seen(body.half_edges()[half_edge.twin as usize].face)
            })
            .collect();
        prop_assert_eq!(outline.iter().copied().collect::<BTreeSet<u32>>(), expected);
        prop_assert_eq!(outline.iter().min(), outline.first());
        prop_assert!(silhouette.seen_faces().iter().all(|&face| is_seen(face)));
    }
}

#[test]
fn a_cube_and_its_shadow() {
    let cube = Cuboid { size: [2.0; 3] }.brep().expect("a cube");
    let lamp = |at: [f64; 3]| LightSource::point(at).expect("a lamp");
    for inside in [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [1.0; 3]] {
        assert!(cube.silhouette(&lamp(inside)).is_none(), "inside, on a face, on an edge, on a corner");
    }
    let lengths = [([0.0, 5.0, 0.0], 4, 1), ([5.0, 5.0, 0.0], 6, 2), ([5.0, 5.0, 5.0], 6, 3), ([5.0, 1.0, 0.0], 4, 1)];
    for (at, edges, faces) in lengths {
        let lamp = lamp(at);
        let silhouette = cube.silhouette(&lamp).expect("outside");
        assert_eq!((silhouette.outline().len(), silhouette.seen_faces().len()), (edges, faces));
    }
    let overhead = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun overhead");
    let shadow = cube.silhouette(&overhead).expect("a sun is outside");
    let corner = |x: f64, y: f64, z: f64| Point::exact(DVec3::new(x, y, z));
    let floor =
        |half: f64| [(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, z)| corner(x, -4.0, z));
    assert!(shadow.covers(floor(1.0)), "up to the outline");
    assert!(!shadow.covers(floor(1.0_f64.next_up())));
    assert!(!shadow.blocks(&corner(0.0, 1.0, 0.0)), "contact on the lit side");
    assert!(shadow.blocks(&corner(0.0, 0.0, 0.0)), "inside, under the lid");
    assert!(shadow.blocks(&corner(0.0, -1.0, 0.0)), "contact on the far side is blocked by the near one");
}
