//! Which houses of a small town may shadow which, from their boxes alone.

use std::error::Error;

use glam::DVec3;
use umbriel_bvh::{Families, ObjectTree, influences};
use umbriel_geometry::{Aabb, LightSource};

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    let ground = Aabb { min: DVec3::ZERO, max: DVec3::new(40.0, 0.0, 40.0) };
    let house = |n: u32| {
        let min = DVec3::new(f64::from(n % 40), 0.0, f64::from(n / 40));
        Aabb { min, max: min + DVec3::new(0.75, 0.5 + f64::from(n % 7) * 0.25, 0.75) }
    };
    let boxes: Vec<Aabb> = std::iter::once(ground).chain((0..1600).map(house)).collect();
    let tree = ObjectTree::build(&boxes, &Families::default())?;

    for (name, direction) in [("noon", [0.0, -1.0, 0.3]), ("evening", [1.0, -0.1, 0.1])] {
        let found = influences(&tree, &LightSource::sun(direction)?, |_receiver| true);
        let counts = found.counts();
        println!("{name}: {} of {} pairs may matter", counts.registered, boxes.len() * (boxes.len() - 1));
        println!("  {} pairs of boxes tested, {} excluded by a plane", counts.tested, counts.excluded);
        println!("  house 820 may lie in the shadow of {} others", found.occluders_of(821).len() - 1);
    }
    Ok(())
}
