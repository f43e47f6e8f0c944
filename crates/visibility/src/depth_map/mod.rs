//! Depth maps: what a light's middle sees, as depths on a grid.
//!
//! Williams, "Casting curved shadows on curved surfaces" (SIGGRAPH 1978). A square window of N × N texels of [`LightSpace`]'s image. Flat faces are
//! rasterised at the texels' middles, their nearness affine over each; bands of rows in parallel, with the same bits for any number of threads.
//! Curved bodies are hit by a ray a texel in the rectangle of their boxes. f32: a picture, not a proof. O(triangles + texels covered).
//!
//! It is another depth buffer than that of [`hidden_surface`](crate::hidden_surface), which finds a camera's faces: that one decides ties exactly, so
//! it keeps a face and an f64 for each pixel and bounds for each face. A map has one f32 a texel, no faces, and a window that is as tight as the scene, off the
//! middle of the light's look.

mod columns;
mod curved;
mod drawn;
mod light_space;
#[cfg(test)]
mod tests;

use std::ops::Range;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use umbriel_geometry::Facets;

pub use curved::CurvedBodies;
pub use light_space::LightSpace;

/// Rows that one thread takes at a time.
const BAND: usize = 32;

/// Texels along the edge of a square whose smallest depth is known.
const SQUARE: usize = 16;

/// Depths from a light, metres along its look; infinite where it sees nothing.
#[derive(Clone, Debug)]
pub struct DepthMap {
    /// Where it lies.
    pub space: LightSpace,
    /// By rows, and [`Self::LANES`] infinities.
    depths: Vec<f32>,
    nearest: f32,
    /// The smallest depth of each square of [`SQUARE`] texels an edge, by rows.
    squares: Vec<f32>,
}

impl DepthMap {
    /// Depths in a group of [`Self::groups`].
    pub const LANES: usize = 16;

    /// What the light sees of flat faces and curved bodies.
    pub fn new(space: LightSpace, flat: &[Facets], curved: &CurvedBodies) -> Self {
        Self::of_triangles(space, flat.par_iter().flat_map_iter(triangles_of), curved)
    }

    /// What the light sees of triangles (world coordinates, metres) and curved bodies. Threads take bands of rows.
    pub fn of_triangles(
        space: LightSpace,
        triangles: impl ParallelIterator<Item = [DVec3; 3]>,
        curved: &CurvedBodies,
    ) -> Self {
        let drawn = drawn::project(&space, triangles);
        let rectangles = curved.rectangles(&space);
        let size = space.size();
        let mut depths = vec![f32::INFINITY; size * size + Self::LANES];
        let bands = drawn::by_band(&drawn, size);
        let rows = depths[..size * size].par_chunks_mut(size * BAND).zip(bands).enumerate();
        rows.for_each(|(band, (rows, triangles))| {
            let first = band * BAND;
            rows.fill(space.nearness_of_nothing());
            triangles.into_iter().for_each(|triangle| drawn[triangle as usize].draw(rows, first, size));
            rows.iter_mut().for_each(|texel| *texel = space.depth_of_nearness(*texel));
            for (row, line) in rows.chunks_mut(size).enumerate() {
                curved.draw_row(&space, &rectangles, first + row, line);
            }
        });
        let squares = least_of_squares(&depths[..size * size], size);
        let nearest = squares.iter().copied().fold(f32::INFINITY, f32::min);
        Self { space, depths, nearest, squares }
    }

    /// Texels along an edge.
    pub fn size(&self) -> usize {
        self.space.size()
    }

    /// The smallest depth; infinite for an empty map.
    pub fn nearest(&self) -> f32 {
        self.nearest
    }

    /// No texel of the window is nearer: O(texels / 256).
    pub fn nearest_in(&self, [columns, rows]: &[Range<usize>; 2]) -> f32 {
        let width = self.size().div_ceil(SQUARE);
        let squares = |texels: &Range<usize>| texels.start / SQUARE..texels.end.div_ceil(SQUARE);
        let lines = squares(rows).map(|row| &self.squares[row * width..][squares(columns)]);
        lines.flatten().copied().fold(f32::INFINITY, f32::min)
    }

    /// A row of depths.
    ///
    /// # Panics
    /// If the map has no such row.
    pub fn row(&self, row: usize) -> &[f32] {
        &self.depths[row * self.size()..(row + 1) * self.size()]
    }

    /// The depths of a row from a column on in groups, `count` of them and what follows up to a whole group.
    ///
    /// # Panics
    /// If the map has no such texels.
    #[inline(always)]
    pub fn groups(&self, row: usize, column: usize, count: usize) -> &[[f32; Self::LANES]] {
        let first = row * self.size() + column;
        self.depths[first..first + count.next_multiple_of(Self::LANES)].as_chunks().0
    }

    /// The texels within `radius` of a place, cut to the map: columns and rows.
    pub fn window(&self, middle: DVec2, radius: f64) -> Option<[Range<usize>; 2]> {
        let size = self.size() as f64;
        let range = |middle: f64| {
            // The texel that holds the middle is always part of it.
            let low = (middle - radius).round().min(middle.floor()).clamp(0.0, size);
            let high = (middle + radius).round().max(middle.floor() + 1.0).clamp(0.0, size);
            (low < high).then_some(low as usize..high as usize)
        };
        Some([range(middle.x)?, range(middle.y)?])
    }
}

/// The faces of a body, cut into triangles.
fn triangles_of(facets: &Facets) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    facets.iter().flat_map(|facet| {
        let numbers = facet.corners();
        let corner = |k: usize| facets.positions()[numbers[k] as usize];
        (2..numbers.len()).map(|k| [corner(0), corner(k - 1), corner(k)]).collect::<Vec<_>>()
    })
}

fn least_of_squares(depths: &[f32], size: usize) -> Vec<f32> {
    let least = |texels: &[f32]| texels.iter().copied().fold(f32::INFINITY, f32::min);
    let bands = depths.par_chunks(size * SQUARE).map(|band| {
        let mut squares = vec![f32::INFINITY; size.div_ceil(SQUARE)];
        for row in band.chunks(size) {
            squares.iter_mut().zip(row.chunks(SQUARE)).for_each(|(square, texels)| *square = square.min(least(texels)));
        }
        squares
    });
    bands.collect::<Vec<_>>().concat()
}
