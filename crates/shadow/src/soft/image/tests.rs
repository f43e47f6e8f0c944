use std::f64::consts::FRAC_PI_4;

use glam::{DAffine3, DVec2, DVec3};
use umbriel_geometry::{Cuboid, Facets, Placement, Rectangle};

use super::*;

const MAP: usize = 512;

fn plate(edge: f64, height: f64) -> Facets {
    let placement = Placement::new(DAffine3::from_translation(DVec3::Y * height)).expect("regular");
    Facets::of_rectangle(&Rectangle { size: [edge; 2] }, &placement)
}

fn corners_of(facets: &[Facets]) -> Vec<DVec3> {
    facets.iter().flat_map(|facets| facets.positions().to_vec()).collect()
}

/// A light at the height 10 over a floor and a plate at the height 5.
fn shader(width: f64) -> SoftShader {
    let faces = [plate(20.0, 0.0), plate(4.0, 5.0)];
    let space = LightSpace::round(DVec3::Y * 10.0, DVec3::NEG_Y, corners_of(&faces), MAP);
    let mut shader = SoftShader::new(DepthMap::new(space, &faces), width);
    shader.prepare_average_depth(10.0);
    shader
}

fn on_floor(x: f64) -> Option<DVec3> {
    Some(DVec3::new(x, 0.0, 0.0))
}

fn blocker(shader: &SoftShader) -> Blocker {
    let oriented = OrientedBox::between(DVec3::new(-2.0, 4.9, -2.0), DVec3::new(2.0, 5.0, 2.0), &DAffine3::IDENTITY);
    Blocker::of(&outlines(&shader.map().space, &[oriented])).expect("a blocker")
}

#[test]
fn the_map_holds_the_depths_of_what_is_nearest() {
    let shader = shader(1.0);
    let map = shader.map();
    for (point, depth) in [(DVec3::ZERO, 5.0), (DVec3::new(3.5, 0.0, 3.5), 5.0), (DVec3::new(4.5, 0.0, 0.0), 10.0)] {
        let place = map.space.to_texels(map.space.to_light(point));
        let found = map.row(place.y as usize)[place.x as usize];
        assert!((f64::from(found) - depth).abs() < 1e-5, "{point}: {found}");
    }
    assert!((map.nearest() - 5.0).abs() < 1e-5);
}

#[test]
fn a_tilted_face_has_its_depths_at_the_texels_middles() {
    let placement = Placement::new(DAffine3::from_rotation_x(FRAC_PI_4)).expect("regular");
    let faces = [Facets::of_rectangle(&Rectangle { size: [4.0; 2] }, &placement)];
    let space = LightSpace::round(DVec3::Y * 10.0, DVec3::NEG_Y, corners_of(&faces), 64);
    let map = DepthMap::new(space, &faces);
    let [a, b, _, d] = [0, 1, 2, 3].map(|k| space.to_light(faces[0].positions()[k]));
    let normal = (b - a).cross(d - a);
    let mut checked = 0;
    for (row, column) in (0..64).flat_map(|row| (0..64).map(move |column| (row, column))) {
        let depth = f64::from(map.row(row)[column]);
        if depth.is_finite() {
            // The ray through the texel's middle meets the plane.
            let probe = (0..2).map(|k| k as f64);
            let slopes: Vec<DVec2> = probe.map(|z| space.to_texels(DVec3::new(z, z, 1.0))).collect();
            let slope = (DVec2::new(column as f64 + 0.5, row as f64 + 0.5) - slopes[0]) / (slopes[1] - slopes[0]);
            let expected = normal.dot(a) / normal.dot(slope.extend(1.0));
            assert!((depth - expected).abs() < 1e-5 * expected, "{row} {column}: {depth} {expected}");
            checked += 1;
        }
    }
    assert!(checked > 1000, "{checked}");
}

#[test]
fn all_kernels_give_the_penumbra_of_a_straight_edge() {
    // The plate's edge at x = 2 throws a penumbra of the light's width, as it stands half way: from x = 4 − w/2 to 4 + w/2.
    let width = 2.0;
    let shader = shader(width);
    let farthest = 10.0;
    let boxes = |kernel| SoftMethod::Boxes { kernel, quality: 1.0, blockers: vec![blocker(&shader)], farthest };
    let methods = [SoftMethod::Pcss, SoftMethod::AverageDepth, boxes(BoxKernel::Fixed), boxes(BoxKernel::OwnDistance)];
    for (method, tolerance) in methods.into_iter().zip([0.03, 0.2, 0.05, 0.05]) {
        for k in 0..=24 {
            let x = 2.0 + 0.15 * f64::from(k);
            let truth = ((x - 3.0) / 2.0).clamp(0.0, 1.0);
            let shade = f64::from(shader.shade(&[on_floor(x)], &method)[0]);
            assert!((shade - truth).abs() <= tolerance, "{method:?} at {x}: {shade} is not {truth}");
        }
    }
}

#[test]
fn the_plate_does_not_shadow_itself() {
    let shader = shader(1.0);
    let point = Some(DVec3::new(0.3, 5.0, 0.2));
    for method in [SoftMethod::Pcf { radius: 0.01 }, SoftMethod::Pcss, SoftMethod::AverageDepth] {
        assert_eq!(shader.shade(&[point], &method), [1.0], "{method:?}");
    }
    assert_eq!(shader.shade(&[None], &SoftMethod::Pcss), [1.0]);
}

#[test]
fn a_box_seen_from_above_has_four_corners_and_askew_six() {
    let space = LightSpace::round(DVec3::Y * 10.0, DVec3::NEG_Y, [], 64);
    let size = DVec3::splat(0.5);
    let at = |place: DVec3| OrientedBox::between(place - size, place + size, &DAffine3::IDENTITY);
    assert_eq!(outlines(&space, &[at(DVec3::ZERO)])[0].corners.len(), 4);
    assert_eq!(outlines(&space, &[at(DVec3::new(5.0, 0.0, 4.0))])[0].corners.len(), 6);
    // A small box behind a large one vanishes; before it, it stays.
    let large = OrientedBox::between(DVec3::new(-2.0, 4.0, -2.0), DVec3::new(2.0, 5.0, 2.0), &DAffine3::IDENTITY);
    assert_eq!(outlines(&space, &[at(DVec3::ZERO), large]).len(), 1);
    assert_eq!(outlines(&space, &[at(DVec3::Y * 7.0), large]).len(), 2);
}

#[test]
fn boxes_follow_their_placement() {
    let turned = DAffine3::from_rotation_y(FRAC_PI_4);
    let oriented = OrientedBox::between(DVec3::NEG_ONE, DVec3::ONE, &turned);
    let reach = oriented.corners.iter().map(|corner| corner.x).fold(0.0, f64::max);
    assert!((reach - 2f64.sqrt()).abs() < 1e-12);
    assert_eq!(Cuboid { size: [2.0; 3] }.corners().len(), 8);
}
