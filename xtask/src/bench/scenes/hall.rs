//! An interior: a hall of bricks with two rows of fluted columns, beams under the open sky, drapes, and a lamp inside.
//!
//! Its triangles are of very different sizes, some of them long and thin.

use std::f64::consts::TAU;

use anyhow::Result;
use glam::DVec3;
use umbriel_scene::{Scene, Sides};

use super::{
    bodies::{Closing, cuboid, ground, sheet},
    object, scene,
};
use crate::fixtures::{SplitMix64, meshes::TriangleMesh};

/// Length, height and width, metres.
const SIZE: DVec3 = DVec3::new(36.0, 12.0, 16.0);
/// Where columns stand: their number in a row, and the distance of a row from its wall.
const COLUMNS: u32 = 11;
const AISLE: f64 = 3.8;

pub(super) fn hall() -> Result<Scene> {
    let floor = ground([0.0; 2], [SIZE.x, SIZE.z], 0.0);
    let objects = vec![
        object("floor", &floor, Sides::One)?,
        object("walls", &walls(), Sides::One)?,
        object("columns", &columns(), Sides::One)?,
        object("beams", &beams(), Sides::One)?,
        object("rails", &rails(), Sides::One)?,
        object("vessels", &vessels(), Sides::One)?,
        object("drapes", &drapes(), Sides::Two)?,
    ];
    scene(objects, DVec3::new(16.3, 4.9, 8.4))
}

/// The distance along the hall of a column.
fn column_place(column: u32) -> f64 {
    3.5 + (SIZE.x - 7.0) * f64::from(column) / f64::from(COLUMNS - 1)
}

/// The two rows, as distances across the hall.
fn rows() -> [f64; 2] {
    [AISLE, SIZE.z - AISLE]
}

/// Bricks of uneven depth along all four sides, one layer shifted against the next.
fn walls() -> TriangleMesh {
    let mut random = SplitMix64::new(4);
    let (length, height) = (0.6, 0.3);
    let mut mesh = TriangleMesh::default();
    for layer in 0..(SIZE.y / height) as u32 {
        let shift = if layer % 2 == 0 { 0.0 } else { 0.5 * length };
        let low = height * f64::from(layer);
        let mut brick = |along: f64, is_end: bool, is_far: bool| {
            let depth = random.between(0.15, 0.25);
            let extent = if is_end { SIZE.x } else { SIZE.z };
            // Bricks begin outside and reach a little into the hall; across from the near end to the far one.
            let across = if is_far { [extent - depth + 0.2, extent + 0.2] } else { [-0.2, depth - 0.2] };
            let min = DVec3::new(along, low, across[0]);
            let max = DVec3::new(along + 0.97 * length, low + 0.95 * height, across[1]);
            let turn = |v: DVec3| if is_end { DVec3::new(v.z, v.y, v.x) } else { v };
            mesh.append(&cuboid(turn(min), turn(max)));
        };
        for (extent, is_end) in [(SIZE.x, false), (SIZE.z, true)] {
            for number in 0..(extent / length) as u32 {
                let along = shift + length * f64::from(number);
                brick(along, is_end, false);
                brick(along, is_end, true);
            }
        }
    }
    mesh
}

/// Fluted columns that swell at their ends.
fn columns() -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for column in 0..COLUMNS {
        for row in rows() {
            let foot = DVec3::new(column_place(column), 0.0, row);
            mesh.append(&sheet([96, 24], Closing::Tube, |around, up| {
                let (angle, swell) = (TAU * around, libm::exp(-12.0 * up) + libm::exp(-12.0 * (1.0 - up)));
                let radius = 0.38 * (1.0 - 0.15 * up + 0.3 * swell) * (1.0 + 0.05 * libm::cos(16.0 * angle));
                foot + DVec3::new(radius * libm::cos(angle), 7.0 * up, radius * libm::sin(angle))
            }));
        }
    }
    mesh
}

/// Galleries on the columns, and beams across the open middle.
fn beams() -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for [near, far] in [[0.0, AISLE + 0.4], [SIZE.z - AISLE - 0.4, SIZE.z]] {
        mesh.append(&cuboid(DVec3::new(0.0, 7.0, near), DVec3::new(SIZE.x, 7.3, far)));
    }
    for column in 0..COLUMNS {
        let along = column_place(column);
        mesh.append(&cuboid(DVec3::new(along - 0.15, 11.0, 0.0), DVec3::new(along + 0.15, 11.5, SIZE.z)));
    }
    mesh
}

/// Thin bars along the galleries under a rail.
fn rails() -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for row in rows() {
        let bar =
            |along: f64| cuboid(DVec3::new(along - 0.02, 7.3, row - 0.02), DVec3::new(along + 0.02, 8.2, row + 0.02));
        (0..170).for_each(|number| mesh.append(&bar(1.0 + 0.2 * f64::from(number))));
        mesh.append(&cuboid(DVec3::new(0.9, 8.2, row - 0.05), DVec3::new(35.0, 8.3, row + 0.05)));
    }
    mesh
}

/// Round vessels on the floor of the hall's middle.
fn vessels() -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for column in (0..COLUMNS).step_by(2) {
        for across in [6.2, SIZE.z - 6.2] {
            let foot = DVec3::new(column_place(column), 0.01, across);
            mesh.append(&sheet([64, 32], Closing::Tube, |around, up| {
                let radius = 0.2 + 0.35 * libm::sin(0.1 + 2.8 * up);
                let angle = TAU * around;
                foot + DVec3::new(radius * libm::cos(angle), 1.1 * up, radius * libm::sin(angle))
            }));
        }
    }
    mesh
}

/// Folded cloth between every other pair of columns.
fn drapes() -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for (number, column) in (0..COLUMNS - 1).step_by(2).enumerate() {
        for row in rows() {
            let (from, to) = (column_place(column) + 0.6, column_place(column + 1) - 0.6);
            let phase = number as f64 + row;
            mesh.append(&sheet([120, 70], Closing::Open, |along, down| {
                let fold = 0.16 * libm::sin(24.0 * along + phase) * (0.3 + down) + 0.1 * libm::sin(5.0 * down + phase);
                DVec3::new(from + (to - from) * along, 6.8 - 4.2 * down, row + fold)
            }));
        }
    }
    mesh
}
