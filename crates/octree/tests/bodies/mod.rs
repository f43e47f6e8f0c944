//! Bodies to build octrees of.

use glam::DVec3;
use umbriel_geometry::{Facets, Mesh, Placement};

/// A mesh of closed octahedra.
pub(crate) fn octahedra(bodies: &[(DVec3, f64)]) -> Facets {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for &(centre, radius) in bodies {
        let first = positions.len() as u32;
        for step in [DVec3::X, DVec3::Y, DVec3::Z] {
            positions.extend([(centre + step * radius).to_array(), (centre - step * radius).to_array()]);
        }
        for signs in 0..8u32 {
            let [x, y, z] = [first + (signs & 1), first + 2 + (signs >> 1 & 1), first + 4 + (signs >> 2)];
            triangles.push(if signs.count_ones() % 2 == 1 { [x, z, y] } else { [x, y, z] });
        }
    }
    Facets::of_mesh(Mesh::new(positions, triangles).expect("finite and in range"), &Placement::IDENTITY)
}

/// A torus of 2·n² triangles.
#[allow(dead_code, reason = "only the benchmark asks")]
pub(crate) fn torus(n: u32) -> Facets {
    let turn = |k: u32| f64::from(k % n) / f64::from(n) * std::f64::consts::TAU;
    let at = |i: u32, j: u32| {
        let (a, b) = (turn(i), turn(j));
        let reach = 2.0 + 0.75 * b.cos();
        [reach * a.cos(), 0.75 * b.sin(), -reach * a.sin()]
    };
    let positions = (0..n * n).map(|k| at(k / n, k % n)).collect();
    let name = |i: u32, j: u32| (i % n) * n + j % n;
    let squares = (0..n * n).map(|k| (k / n, k % n));
    let triangles = squares.flat_map(|(i, j)| {
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    Facets::of_mesh(Mesh::new(positions, triangles.collect()).expect("finite and in range"), &Placement::IDENTITY)
}
