//! Divides a cube along a spiral and prints how many leaves each level has.

use std::error::Error;

use glam::DVec3;
use umbriel_geometry::Aabb;
use umbriel_octree::{Cube, Limits, LinearOctree};

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    let at = |step: u32| {
        let turn = f64::from(step) / 40.0;
        DVec3::new(turn.cos() * turn, f64::from(step) / 50.0, turn.sin() * turn)
    };
    let boxes: Vec<Aabb> = (0..1000).map(|step| Aabb::of([at(step), at(step + 1)])).collect();
    let whole = boxes.iter().fold(Aabb::EMPTY, |sum, bounds| sum.union(*bounds));
    let cube = Cube::around(&whole).ok_or("the spiral is empty")?;
    let tree = LinearOctree::build(cube, &boxes, Limits { max_level: 10, leaf_items: 2 })?;

    println!("{} boxes, a cube of edge {:.1}, {} leaves", boxes.len(), cube.edge(), tree.len());
    for level in 0..=10 {
        let of_level = || tree.leaves().filter(|leaf| leaf.cell.level() == level);
        let empty = of_level().filter(|leaf| leaf.items.is_empty()).count();
        println!("level {level:2}: {:5} leaves, {empty:5} of them empty", of_level().count());
    }
    Ok(())
}
