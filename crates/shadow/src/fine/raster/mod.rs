//! Proofs on large flat faces by their shadows' borders alone.
//!
//! The number of facets that cover a shadow ray changes only at silhouettes, at the rims of sheets, and where bodies pierce
//! the face's plane. So nothing else is drawn: for each light the border edges of each body ([`silhouette`], from its
//! [`edge_table`]); before a face they are clipped and cast onto it as directed segments with margins ([`chain`],
//! [`projection`]); tiles of 64 × 64 cells collect which cells they touch and how the winding changes from cell to cell
//! ([`tile`]). This is the winding rule of the fine step, for all cells of a face at once (Catmull 1984 and many rasterisers
//! since accumulate signed edges in this way; that it proves cells is NUMERICS.md, "Borders on a face").
//!
//! Guarantee: a cell is lit or shadowed only if all its points are. Cost: a look at each facet that may reach the plane, or some 100 ns for each that
//! is found over the face, about 20 ns a border edge, 10 ns a row of a segment, 100 ns a tile. What breaks it: facets that come too near to the light,
//! or a light hardly above the plane; such faces are given up ([`GiveUp`]).

mod beside;
mod bins;
mod blocks;
mod chain;
mod drawing;
pub(crate) mod edge_table;
mod estimate;
mod lowest;
mod open_cells;
mod projection;
mod segments;
pub(crate) mod silhouette;
mod span;
mod standing;
mod tally;
mod tile;

use umbriel_geometry::{LightSource, Point, Sign};
use umbriel_octree::Face;

use super::{
    flat::{FLAT, FaceShape, Levels},
    lattice::Lattice,
    tally::{Tally, Units},
};
use crate::effort::Spend;
use drawing::Drawing;
use projection::Projection;

pub(crate) use chain::{GiveUp, Occluder, Plane};
pub(crate) use edge_table::MAX_FACETS;
pub(crate) use segments::Chain;

/// Faces with fewer cells along an edge (as a power of two) are divided, which is sharper, while few facets are over them: each takes some 700 bytes there.
const LEAST_LEVEL: u8 = 5;
const FEW_FACETS: f64 = 16384.0;

/// With fewer facets over a face it is divided: that is sharper where shadows end exactly between two cells, as they often
/// do in small scenes, and quick enough.
const LEAST_FACETS: f64 = 200.0;

/// Beyond this there are too many tiles to look at each.
pub(crate) const MOST_LEVEL: u8 = 15;

/// The edge of a tile as a power of two, in cells.
pub(crate) const TILE_LEVEL: u8 = 6;

/// Whether drawing borders is likely to be sooner than dividing the face, given how many facets there are and how many
/// of them are expected to be over the face. A facet is looked at in about 8 ns here and takes about 2 µs there, a tile 100 ns.
pub(crate) fn is_sooner(level: u8, facets: usize, expected: f64) -> bool {
    if expected < LEAST_FACETS || level < LEAST_LEVEL && expected < FEW_FACETS {
        return false;
    }
    let tiles = 4f64.powi(i32::from(level) - i32::from(TILE_LEVEL));
    2000.0 * expected > 8.0 * facets as f64 + 100.0 * tiles
}

/// Adds the borders of a body, by its number.
pub(crate) type AddBody<'a> = &'a dyn Fn(u32, &Plane, &mut Chain) -> Result<(), GiveUp>;

/// One face and the borders on it.
pub(crate) struct Raster<'a> {
    pub(crate) shape: FaceShape,
    pub(crate) levels: Levels,
    pub(crate) lattice: Option<Lattice>,
    /// The exact answer for a point (u, v) of the face.
    pub(crate) is_lit_exactly: &'a (dyn Fn(f64, f64) -> bool + Sync),
    pub(crate) spend: Spend<'a>,
}

impl Raster<'_> {
    /// Classifies the whole face, which `bodies` may shadow.
    ///
    /// # Errors
    /// [`GiveUp`] where this method cannot; nothing is proved then.
    pub(crate) fn run(
        &self,
        corners: &[Point; FLAT],
        light: &LightSource,
        facing: Sign,
        (bodies, add): (&[u32], AddBody),
    ) -> Result<Tally<Units>, GiveUp> {
        let projection = Projection::new(corners, light, facing, self.cells() as f64).ok_or(GiveUp)?;
        let plane = Plane { corners, light, facing, projection, is_triangle: self.is_triangle() };
        let mut drawing = Drawing::new(self);
        for &body in bodies {
            if !(self.spend)(1) {
                break;
            }
            add(body, &plane, &mut drawing.chain)?;
            drawing.relieve();
        }
        Ok(drawing.finish())
    }

    fn is_triangle(&self) -> bool {
        self.shape.domain == Face::Triangle
    }

    /// Cells along an edge of the face.
    fn cells(&self) -> i64 {
        1 << self.levels.finest
    }
}
