//! Where few points lie in a light's views: what has none of them behind it is left out before anything is made of it.
//!
//! The problem: a picture sees some ten thousand points of a scene of many times as many triangles; no shadow ray comes near most of these. The way: a raster
//! over the rectangle that holds a view's points, a few cells a point; a cell holds how far from the light the farthest of its points is. A piece is left
//! out when no cell under its rectangle has a point as far as the piece or farther.
//!
//! Guarantee: a piece that is left out meets no shadow ray of a point, nor one from elsewhere in its slack box, nor that box.
//! Cost: some 30 ns a point (points of faces are gathered twice), some nanoseconds a piece.

use rayon::prelude::*;
use umbriel_geometry::LightSource;

use crate::{
    light_space::View,
    loose::{
        CHUNK, Points,
        on_faces::OnFaces,
        pieces::Pieces,
        placed::{NOWHERE, union},
        seen::{BLOCK, Block, PointError, Row},
    },
    query::Queries,
};

/// Worth its while where there are at most so many points a piece.
pub(super) const POINTS_A_PIECE: f64 = 1.0;
/// Cells of the raster a point, and at most so many along a side.
const CELLS_A_POINT: f64 = 8.0;
const MOST_CELLS: usize = 1024;
/// Pieces over more cells than this are kept without a look.
const MOST_LOOKS: usize = 256;

/// The points of one view.
#[derive(Debug)]
pub(super) struct Occupancy {
    /// Least and greatest u, v of a point.
    bounds: [f64; 4],
    /// What the u, v of points are off by.
    off: f64,
    /// Cells over a unit of u and v.
    density: [f64; 2],
    /// Cells along a side.
    side: usize,
    /// Row by row: none of the cell's points is less near than this; infinite where there is none.
    farthest: Vec<f32>,
}

/// A point in a view.
#[derive(Clone, Copy, Debug)]
struct Spot {
    view: usize,
    place: [f64; 2],
    /// It is no less near than this.
    nearness: f32,
}

/// What is seen of some points, and what places are off by at most.
struct Spots {
    spots: Vec<Spot>,
    off: f64,
}

impl Occupancy {
    /// One for each view; `None` where there are too many points a piece, or some that are too roughly known.
    pub(super) fn of(
        queries: &Queries,
        pieces: &Pieces,
        views: &[View],
        points: Points,
        light: &LightSource,
    ) -> Option<Vec<Self>> {
        if points.len() as f64 > POINTS_A_PIECE * f64::from(pieces.len()) {
            return None;
        }
        let starts: Vec<usize> = (0..points.len()).step_by(CHUNK).collect();
        let parts = starts.par_iter().map_init(OnFaces::default, |on_faces, &start| {
            let part = points.part(start, points.len().min(start + CHUNK));
            let size = part.size();
            let off = (part.slack(size), size);
            let see = |rows: &[[f64; 3]], (slack, size)| Spots::of(views, pieces, rows, slack, size);
            match part {
                Points::FreeSingle(rows) => see(&positions(rows), off),
                Points::FreeDouble(rows) => see(rows, off),
                Points::OrientedSingle(rows) => see(&positions(rows), off),
                Points::OrientedDouble(rows) => see(&positions(rows), off),
                Points::OnFaces(points) => {
                    // A point that is refused is told of where the others are answered.
                    on_faces.gather(queries, pieces, points, light).ok()?;
                    see(on_faces.rows(), on_faces.off())
                }
            }
        });
        let parts = parts.collect::<Option<Vec<Spots>>>()?;
        let off = parts.iter().fold(0.0, |off: f64, part| off.max(part.off));
        Some((0..views.len()).map(|view| Self::of_view(view, &parts, off)).collect())
    }

    fn of_view(view: usize, parts: &[Spots], off: f64) -> Self {
        let spots = || parts.iter().flat_map(|part| &part.spots).filter(|spot| spot.view == view);
        let bounds = spots().fold(NOWHERE, |bounds, &Spot { place: [u, v], .. }| union(bounds, [u, v, u, v]));
        let side = ((spots().count() as f64 * CELLS_A_POINT).sqrt() as usize).clamp(1, MOST_CELLS);
        let density = |length: f64| if length > 0.0 { side as f64 / length } else { 0.0 };
        let density = [density(bounds[2] - bounds[0]), density(bounds[3] - bounds[1])];
        let mut raster = Self { bounds, off, density, side, farthest: vec![f32::INFINITY; side * side] };
        for &Spot { place: [u, v], nearness, .. } in spots() {
            let cell = raster.cell(v, 1) * side + raster.cell(u, 0);
            raster.farthest[cell] = raster.farthest[cell].min(nearness);
        }
        raster
    }

    /// Monotone, roundings included: what lies between two places has a cell between theirs.
    #[inline(always)]
    fn cell(&self, place: f64, axis: usize) -> usize {
        (((place - self.bounds[axis]) * self.density[axis]).max(0.0) as usize).min(self.side - 1)
    }

    /// Whether a point may have the piece between itself and the light, or at it.
    #[inline(always)]
    pub(super) fn may_meet(&self, [u0, v0, u1, v1]: [f64; 4], nearest: f64) -> bool {
        let [u0, v0, u1, v1] = [u0 - self.off, v0 - self.off, u1 + self.off, v1 + self.off];
        let [least_u, least_v, most_u, most_v] = self.bounds;
        if u1 < least_u || u0 > most_u || v1 < least_v || v0 > most_v {
            return false;
        }
        let (left, right, low, high) = (self.cell(u0, 0), self.cell(u1, 0), self.cell(v0, 1), self.cell(v1, 1));
        let cells = (right - left + 1) * (high - low + 1);
        let has_farther = |row: usize| {
            let row = &self.farthest[row * self.side..][left..=right];
            row.iter().fold(false, |any, &farthest| any | (f64::from(farthest) <= nearest))
        };
        cells > MOST_LOOKS || (low..=high).any(has_farther)
    }
}

impl Spots {
    /// `None` where what places are off by is not known.
    fn of(views: &[View], pieces: &Pieces, rows: &[[f64; 3]], slack: f64, size: f64) -> Option<Self> {
        let error = PointError::of(&views[0], &pieces.bounds, slack, size);
        let (mut spots, mut off) = (Vec::with_capacity(rows.len()), 0.0);
        let mut block = Block::EMPTY;
        for rows in rows.chunks(BLOCK) {
            match views {
                [view] => block.see_sun(view, rows),
                _ => block.see_lamp(&views[0], rows),
            }
            for (view, place, nearness) in block.places(rows.len()) {
                let [place_off, nearness_off] = error.at(nearness)?;
                off = if place_off > off { place_off } else { off };
                spots.push(Spot { view, place, nearness: ((nearness - nearness_off) as f32).next_down() });
            }
        }
        Some(Self { spots, off })
    }
}

fn positions<T: Row>(rows: &[T]) -> Vec<[f64; 3]> {
    rows.iter().map(Row::position).collect()
}
