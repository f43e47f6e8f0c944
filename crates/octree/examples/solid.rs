//! A torus as an octree: volumes at every depth, a slice, and the leaves along a ray.

use std::error::Error;

use glam::DVec3;
use umbriel_geometry::{Facets, Mesh, Placement, Relation};
use umbriel_octree::{Ray, SolidOctree};

/// Divisions of both circles.
const N: u32 = 48;

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    let turn = |k: u32| f64::from(k) / f64::from(N) * std::f64::consts::TAU;
    let at = |i: u32, j: u32| {
        let reach = 2.0 + 0.75 * turn(j).cos();
        [reach * turn(i).cos(), 0.75 * turn(j).sin(), -reach * turn(i).sin()]
    };
    let name = |i: u32, j: u32| (i % N) * N + j % N;
    let squares = (0..N * N).map(|k| (k / N, k % N));
    let triangles = squares.clone().flat_map(|(i, j)| {
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    let mesh = Mesh::new(squares.map(|(i, j)| at(i, j)).collect(), triangles.collect())?;
    let tree = SolidOctree::build(&Facets::of_mesh(mesh, &Placement::IDENTITY), 7)?;

    println!("{} leaves; a smooth torus of these radii holds {:.3} m³", tree.relations().len(), 22.207);
    for depth in 3..=7 {
        let volume = tree.at_depth(depth).to_octree().volume();
        println!("depth {depth}: between {:.3} and {:.3} m³", volume.lower, volume.upper);
    }
    for z in (-16..=16).step_by(2) {
        let said = |x: i32| tree.relation_at(DVec3::new(f64::from(x), 0.0, f64::from(z)) * 0.1875);
        let line: String = (-16..=16).map(said).map(letter).collect();
        println!("{line}");
    }
    let ray = Ray::new(DVec3::new(-4.0, 0.1, 0.3), DVec3::X)?;
    let inside = tree.cast(&ray).filter(|(_, relation)| *relation == Relation::Inside);
    let length: f64 = inside.map(|(crossing, _)| crossing.exit - crossing.enter).sum();
    println!("a ray across runs through {length:.3} m of leaves in the torus");
    Ok(())
}

fn letter(relation: Option<Relation>) -> char {
    match relation {
        Some(Relation::Inside) => '#',
        Some(Relation::Boundary) => '+',
        Some(Relation::Outside) | None => '.',
    }
}
