//! Proofs on large flat faces by their shadows' borders alone.
//!
//! The number of facets that cover a shadow ray changes only at silhouettes, at the rims of sheets, and where bodies pierce
//! the face's plane. So nothing else is drawn: for each light the border edges of each body ([`silhouette`], from its
//! [`edge_table`]); before a face they are clipped and cast onto it as directed segments with margins ([`chain`],
//! [`projection`]); tiles of 64 × 64 cells collect which cells they touch and how the winding changes from cell to cell
//! ([`tile`]). This is the winding rule of the fine step, for all cells of a face at once (Catmull 1984 and many rasterisers
//! since accumulate signed edges in this way; that it proves cells is NUMERICS.md, "Borders on a face").
//!
//! Guarantee: a cell is lit or shadowed only if all its points are. Cost: a look at each facet that may reach the plane,
//! about 20 ns a border edge, 10 ns a row of a segment, 100 ns a tile. What breaks it: facets that come too near to the light,
//! or a light hardly above the plane; such faces are given up ([`GiveUp`]).

mod beside;
mod bins;
mod chain;
pub(crate) mod edge_table;
mod estimate;
mod projection;
pub(crate) mod silhouette;
mod span;
mod tally;
mod tile;

use rayon::prelude::*;
use umbriel_geometry::{LightSource, Point, Sign};
use umbriel_octree::Face;

use super::{
    flat::{FLAT, FaceShape, Levels},
    lattice::Lattice,
    tally::{Tally, Units},
};
use bins::Bins;
use estimate::Estimate;
use projection::Projection;
use span::{Walk, floor};
use tally::{Outcome, TileGrid, TileMasks};
use tile::{TILE, Tile, TilePlace};

pub(crate) use chain::{Chain, GiveUp, Occluder, Plane};
pub(crate) use edge_table::MAX_FACETS;

/// Faces with fewer cells along an edge (as a power of two) are divided, which is sharper, while few facets are over them: each takes some 700 bytes there.
const LEAST_LEVEL: u8 = 5;
const FEW_FACETS: f64 = 16384.0;

/// With fewer facets over a face it is divided: that is sharper where shadows end exactly between two cells, as they often
/// do in small scenes, and quick enough.
const LEAST_FACETS: f64 = 200.0;

/// Beyond this there are too many tiles to look at each.
pub(crate) const MOST_LEVEL: u8 = 15;

/// Whether drawing borders is likely to be sooner than dividing the face, given how many facets there are and how many
/// of them are expected to be over the face. A facet is looked at in about 8 ns here and takes about 2 µs there, a tile 100 ns.
pub(crate) fn is_sooner(level: u8, facets: usize, expected: f64) -> bool {
    if expected < LEAST_FACETS || level < LEAST_LEVEL && expected < FEW_FACETS {
        return false;
    }
    let tiles = 4f64.powi(i32::from(level) - 6);
    2000.0 * expected > 8.0 * facets as f64 + 100.0 * tiles
}

/// What may shadow the face, one body after the other.
pub(crate) type AddAll<'a> = &'a dyn Fn(&Plane, &mut Chain) -> Result<(), GiveUp>;

/// One face and the borders on it.
pub(crate) struct Raster<'a> {
    pub(crate) shape: FaceShape,
    pub(crate) levels: Levels,
    pub(crate) lattice: Option<Lattice>,
    /// The exact answer for a point (u, v) of the face.
    pub(crate) is_lit_exactly: &'a (dyn Fn(f64, f64) -> bool + Sync),
    pub(crate) is_cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl Raster<'_> {
    /// Classifies the whole face.
    ///
    /// # Errors
    /// [`GiveUp`] where this method cannot; nothing is proved then.
    pub(crate) fn run(
        &self,
        corners: &[Point; FLAT],
        light: &LightSource,
        facing: Sign,
        add_all: AddAll,
    ) -> Result<Tally<Units>, GiveUp> {
        let projection = Projection::new(corners, light, facing, self.cells() as f64).ok_or(GiveUp)?;
        let plane = Plane { corners, light, facing, projection, is_triangle: self.is_triangle() };
        let mut chain = Chain::default();
        add_all(&plane, &mut chain)?;
        let size = self.cells().min(TILE as i64);
        let tiles = (self.cells() / size) as usize;
        let bands_of = |segment| bands(Walk::of(segment).rows(0, self.cells()), size);
        let segments = Bins::new(tiles, chain.segments.iter().map(bands_of));
        let veils = chain.veils.iter().map(|veil| {
            let ys = || veil.corners.iter().map(|corner| corner[1]);
            let (low, high) = (ys().fold(f64::INFINITY, f64::min), ys().fold(f64::NEG_INFINITY, f64::max));
            bands(Walk::new([0.0, low], [0.0, high], f64::from(veil.margin)).rows(0, self.cells()), size)
        });
        let veils = Bins::new(tiles, veils);
        let rows: Vec<Vec<Outcome>> = (0..tiles)
            .into_par_iter()
            .map(|band| Band { raster: self, chain: &chain, number: band, size }.run(segments.of(band), veils.of(band)))
            .collect();
        Ok(TileGrid::new(self, size, rows.into_iter().flatten().collect()).finish())
    }

    fn is_triangle(&self) -> bool {
        self.shape.domain == Face::Triangle
    }

    /// Cells along an edge of the face.
    fn cells(&self) -> i64 {
        1 << self.levels.finest
    }
}

/// The bands that rows lie in.
fn bands(rows: std::ops::Range<i64>, size: i64) -> std::ops::Range<usize> {
    if rows.is_empty() { 0..0 } else { (rows.start / size) as usize..((rows.end - 1) / size + 1) as usize }
}

/// A row of tiles.
struct Band<'a> {
    raster: &'a Raster<'a>,
    chain: &'a Chain,
    number: usize,
    size: i64,
}

impl Band<'_> {
    fn run(&self, segments: &[u32], veils: &[u32]) -> Vec<Outcome> {
        let tiles = (self.raster.cells() / self.size) as usize;
        let segment_bins = Bins::new(tiles, segments.iter().map(|&k| self.tiles_of_segment(k)));
        let veil_bins = Bins::new(tiles, veils.iter().map(|&k| self.tiles_of_veil(k)));
        let mut tile = Tile::new();
        let mut carry = [0; TILE];
        (0..tiles)
            .map(|number| {
                let place = TilePlace {
                    column: number as i64 * self.size,
                    row: self.number as i64 * self.size,
                    size: self.size,
                };
                if self.is_off(&place) || (self.raster.is_cancelled)() {
                    return Outcome::Off;
                }
                let [in_segments, in_veils] = [(&segment_bins, segments), (&veil_bins, veils)]
                    .map(|(bins, all)| bins.of(number).iter().map(move |&k| all[k as usize] as usize));
                if in_segments.len() == 0 && in_veils.len() == 0 {
                    return Outcome::clear(carry[0]);
                }
                tile.move_to(place);
                in_segments.clone().for_each(|k| tile.add(&self.chain.segments[k]));
                in_veils.for_each(|k| tile.add_veil(&self.chain.veils[k]));
                self.settle(&tile, &mut carry, in_segments)
            })
            .collect()
    }

    fn settle(&self, tile: &Tile, carry: &mut [i32; TILE], segments: impl Iterator<Item = usize>) -> Outcome {
        let before = *carry;
        let proofs = tile.settle(carry);
        let masks = TileMasks::new(self.raster, tile.place, &proofs);
        if let Some(outcome) = masks.whole() {
            return outcome;
        }
        let level = self.raster.levels.finest;
        let mut estimate = Estimate::new(tile, &masks.open, &masks.halves, &before, level);
        segments.for_each(|k| estimate.add(tile, &masks.open, &self.chain.segments[k]));
        Outcome::Mixed(Box::new(masks.tally(self.raster, &estimate)))
    }

    /// Whether no cell of the tile is on the face.
    fn is_off(&self, place: &TilePlace) -> bool {
        self.raster.is_triangle() && place.column + place.row >= self.raster.cells()
    }

    fn tiles_of_segment(&self, segment: u32) -> std::ops::Range<usize> {
        let first = self.number as i64 * self.size;
        let [low, high] = Walk::of(&self.chain.segments[segment as usize]).reach_over(first, first + self.size);
        // A crossing counts from the next middle of a cell on, which may be in the next tile.
        self.tiles_in(low, high + 1.0)
    }

    fn tiles_of_veil(&self, veil: u32) -> std::ops::Range<usize> {
        let veil = &self.chain.veils[veil as usize];
        let margin = f64::from(veil.margin);
        let xs = || veil.corners.iter().map(|corner| corner[0]);
        self.tiles_in(xs().fold(f64::INFINITY, f64::min) - margin, xs().fold(f64::NEG_INFINITY, f64::max) + margin)
    }

    /// The tiles that a range of x meets; what is left of the face counts for the first one.
    fn tiles_in(&self, low: f64, high: f64) -> std::ops::Range<usize> {
        let (last, size) = (self.raster.cells() - 1, self.size);
        let first = floor(low).max(0) / size;
        let end = floor(high).clamp(0, last) / size + 1;
        first as usize..end.max(first) as usize
    }
}
