//! A bumpy knot, a city of boxes, a field of spheres, foliage.

use std::f64::consts::TAU;

use anyhow::Result;
use glam::DVec3;
use umbriel_scene::{Scene, Sides};

use super::{
    bodies::{Closing, cuboid, ground, sheet},
    object, on_a_plane, scene,
};
use crate::fixtures::{
    SplitMix64,
    meshes::{TriangleMesh, icosphere},
};

/// A tube along a trefoil, which winds twice round the axis and three times round a torus, with bumps of several sizes; two
/// triangles a step. Strands never meet: they are 1.7 apart, the tube is at most 1.2 thick.
pub(crate) fn knot(around: u32, across: u32) -> Result<Scene> {
    let (reach, radius) = (2.2, 0.85);
    let body = sheet([around, across], Closing::Torus, |along, round| {
        let (turn, roll, angle) = (2.0 * TAU * along, 3.0 * TAU * along, TAU * round);
        let axis = DVec3::new(libm::cos(turn), 0.0, libm::sin(turn));
        let outward = axis * libm::cos(roll) + DVec3::Y * libm::sin(roll);
        // Across the tube: outward from the torus, and along its surface at a right angle to the curve.
        let forward = DVec3::new(-axis.z, 0.0, axis.x) * 2.0 * (reach + radius * libm::cos(roll))
            + (DVec3::Y * libm::cos(roll) - axis * libm::sin(roll)) * 3.0 * radius;
        let sideward = forward.cross(outward).normalize();
        let bumps = 0.08 * libm::sin(90.0 * TAU * along) * libm::sin(8.0 * angle)
            + 0.05 * libm::sin(TAU * 31.0 * along + 5.0 * angle)
            + 0.02 * libm::sin(TAU * 211.0 * along - 23.0 * angle);
        let tube = (outward * libm::cos(angle) + sideward * libm::sin(angle)) * 0.5 * (1.0 + bumps);
        axis * reach + outward * radius + tube
    });
    on_a_plane(&body)
}

/// Houses on lots of 20 m, most of them low and a few of them towers, on a plane; a lamp over the middle.
pub(crate) fn city(houses: u32) -> Result<Scene> {
    let mut random = SplitMix64::new(1);
    let row = f64::from(houses).sqrt().ceil() as u32;
    let mut mesh = TriangleMesh::default();
    for house in 0..houses {
        let lot = DVec3::new(f64::from(house % row), 0.0, f64::from(house / row)) * 20.0;
        let (width, depth) = (random.between(8.0, 17.0), random.between(8.0, 17.0));
        // The product of three numbers is small most of the time.
        let height = 6.0 + 144.0 * (0..3).map(|_| random.between(0.0, 1.0)).product::<f64>();
        let corner = lot + DVec3::new(random.between(0.0, 19.0 - width), 0.0, random.between(0.0, 19.0 - depth));
        mesh.append(&cuboid(corner, corner + DVec3::new(width, height, depth)));
    }
    let edge = 20.0 * f64::from(row);
    let plane = ground([-50.0; 2], [edge + 50.0; 2], 0.0);
    let lamp = DVec3::new(0.5 * edge + 3.0, 260.0, 0.5 * edge - 7.0);
    scene(vec![object("ground", &plane, Sides::One)?, object("houses", &mesh, Sides::One)?], lamp)
}

/// Spheres of several sizes in the air over a plane, some of them in one another.
pub(super) fn field() -> Result<Scene> {
    let mut random = SplitMix64::new(2);
    let sphere = icosphere(4);
    let mut objects = vec![object("ground", &ground([-5.0; 2], [105.0; 2], 0.0), Sides::One)?];
    for number in 0..1000 {
        let radius = random.between(0.5, 2.0);
        let [x, z] = [0, 1].map(|_| random.between(0.0, 100.0));
        let middle = DVec3::new(x, random.between(radius + 0.1, 12.0), z);
        let mesh = sphere.clone().map(|point| middle + point * radius);
        objects.push(object(format!("sphere {number}"), &mesh, Sides::One)?);
    }
    scene(objects, DVec3::new(50.3, 25.0, 49.1))
}

/// Leaves, which have two sides, in all directions between two heights over a plane.
pub(super) fn foliage() -> Result<Scene> {
    let mut random = SplitMix64::new(3);
    let mut leaves = TriangleMesh::default();
    for _ in 0..200_000 {
        let [x, y, z] = [(0.0, 80.0), (2.0, 14.0), (0.0, 80.0)].map(|(from, to)| random.between(from, to));
        let middle = DVec3::new(x, y, z);
        let first = leaves.positions.len() as u32;
        let corner = |random: &mut SplitMix64| DVec3::from_array([0; 3].map(|_| random.between(-0.2, 0.2)));
        leaves.positions.extend([0; 3].map(|_| middle + corner(&mut random)));
        leaves.triangles.push([first, first + 1, first + 2]);
    }
    let plane = ground([-10.0; 2], [90.0; 2], 0.0);
    let objects = vec![object("ground", &plane, Sides::One)?, object("leaves", &leaves, Sides::Two)?];
    scene(objects, DVec3::new(41.0, 30.0, 38.0))
}
