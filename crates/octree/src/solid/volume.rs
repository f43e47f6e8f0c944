//! How much a solid holds: sums of cells, rounded outward.

use umbriel_geometry::Relation;

use super::SolidOctree;
use crate::morton::Octant;

/// A volume in cubic metres that lies between two numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeBounds {
    /// Not above the volume.
    pub lower: f64,
    /// Not below the volume.
    pub upper: f64,
}

impl VolumeBounds {
    pub(super) fn of(tree: &SolidOctree) -> Self {
        let (mut inside, mut boundary) = (0, 0);
        for (cell, relation) in tree.leaves() {
            match relation {
                Relation::Inside => inside += cells_in(cell),
                Relation::Boundary => boundary += cells_in(cell),
                Relation::Outside => {}
            }
        }
        let edge = tree.partition().cube().edge();
        Self { lower: volume(inside, edge, f64::next_down), upper: volume(inside + boundary, edge, f64::next_up) }
    }
}

/// How many cells of the deepest level are in `cell`; 2^63 in the root.
fn cells_in(cell: Octant) -> u64 {
    cell.range().end() - cell.range().start() + 1
}

/// The volume of that many cells of the deepest level in a cube with this edge; each rounding goes `outward`.
fn volume(cells: u64, edge: f64, outward: fn(f64) -> f64) -> f64 {
    let product = |a: f64, b: f64| {
        let rounded = a * b;
        if a.mul_add(b, -rounded) == 0.0 { rounded } else { outward(rounded) }
    };
    let nearest = cells as f64;
    let count = if nearest as u64 == cells { nearest } else { outward(nearest) };
    let share = count / (cells_in(Octant::ROOT) as f64);
    product(product(product(share, edge), edge), edge)
}
