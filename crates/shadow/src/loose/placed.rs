//! The rectangles of all pieces in a view.
//!
//! A sun sees the triangles of a mesh eight at a time, lane by lane and without branches, so that the compiler makes vectors of them; a lamp, whose views leave
//! out what lies beside or behind, one by one. Cost: some nanoseconds a piece.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{
    gathered::Gathered,
    simd::{Kernel, Simd, dispatch},
};

use crate::{
    light_space::{View, greater, lesser},
    loose::{occupancy::Occupancy, pieces::Pieces},
};

/// Pieces are seen and listed in so many parts at most, by as many threads: each part has a number for each tile.
const PARTS: usize = 64;

/// A piece and its rectangle in the view: least u, v, greatest u, v.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) bounds: [f64; 4],
    pub(super) piece: u32,
    /// It turns the other way round than by its winding, as far as roundings tell; what belongs together.
    pub(super) is_reversed: bool,
}

/// Nothing.
pub(super) const NOWHERE: [f64; 4] = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];

/// A rectangle that holds two.
#[inline(always)]
pub(super) fn union([a, b, c, d]: [f64; 4], [e, f, g, h]: [f64; 4]) -> [f64; 4] {
    [lesser(e, a), lesser(f, b), greater(g, c), greater(h, d)]
}

/// All pieces that the view sees, in parts; of those that may meet a point if that is known. `error` is that of corners.
pub(super) fn see_all(pieces: &Pieces, view: &View, error: f64, occupancy: Option<&Occupancy>) -> Vec<Vec<Placed>> {
    let runs = pieces.runs();
    let parts = runs.par_chunks(runs.len().div_ceil(PARTS).max(1)).with_max_len(1);
    parts.map(|runs| dispatch(See { pieces, view: *view, error, occupancy, runs })).collect()
}

struct See<'a> {
    pieces: &'a Pieces<'a>,
    view: View,
    error: f64,
    occupancy: Option<&'a Occupancy>,
    runs: &'a [Range<u32>],
}

impl Kernel for See<'_> {
    type Output = Vec<Placed>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Vec<Placed> {
        let most = if self.occupancy.is_none() { self.runs.iter().map(ExactSizeIterator::len).sum() } else { 0 };
        let mut seen = Vec::with_capacity(most);
        for run in self.runs {
            match self.pieces.triangles(run) {
                Some((positions, triangles)) if self.view.is_sun() => {
                    self.see_triangles(run.start, positions, triangles, &mut seen);
                }
                _ => self.pieces.for_each(run.clone(), |piece, corners| {
                    if let Some(bounds) = self.view.bounds(corners, self.error) {
                        let nearest = || self.view.nearest(corners, self.error);
                        let is_reversed = matches!(*corners, [a, b, c] if self.view.is_reversed(&[a, b, c]));
                        self.keep(Placed { bounds, piece, is_reversed }, nearest, &mut seen);
                    }
                }),
            }
        }
        seen
    }
}

impl See<'_> {
    #[inline(always)]
    fn see_triangles(&self, first: u32, positions: &[DVec3], triangles: &[[u32; 3]], seen: &mut Vec<Placed>) {
        let (view, error) = (self.view, self.error);
        let mut corners = Gathered::<3, 8>::default();
        for (first, triangles) in (first..).step_by(8).zip(triangles.chunks(8)) {
            corners.gather(triangles, positions, 0);
            let (mut bounds, mut nearest, mut is_reversed) = ([[0.0; 8]; 4], [0.0; 8], [false; 8]);
            for lane in 0..8 {
                let triangle = [corners.at(0, lane), corners.at(1, lane), corners.at(2, lane)];
                let [u0, v0, u1, v1] = view.sun_bounds(&triangle, error);
                (bounds[0][lane], bounds[1][lane], bounds[2][lane], bounds[3][lane]) = (u0, v0, u1, v1);
                nearest[lane] = view.nearest(&triangle, error);
                is_reversed[lane] = view.is_reversed(&triangle);
            }
            for (lane, piece) in (0..triangles.len()).zip(first..) {
                let [u0, v0, u1, v1] = &bounds;
                let bounds = [u0[lane], v0[lane], u1[lane], v1[lane]];
                self.keep(Placed { bounds, piece, is_reversed: is_reversed[lane] }, || nearest[lane], seen);
            }
        }
    }

    /// Takes a piece unless no point can meet it.
    #[inline(always)]
    fn keep(&self, placed: Placed, nearest: impl Fn() -> f64, seen: &mut Vec<Placed>) {
        if self.occupancy.is_none_or(|occupancy| occupancy.may_meet(placed.bounds, nearest())) {
            seen.push(placed);
        }
    }
}
