//! Where few points lie in a light's views: what has none of them behind it is left out before anything is made of it.
//!
//! The problem: a picture sees some ten thousand points of a scene of many times as many triangles; no shadow ray comes near most of these. The way: a raster
//! over the rectangle that holds a view's points; a cell holds how far from the light the farthest of its points is, and so do cells of two by two of them, and so on (Greene, Kass and
//! Miller 1993, "Hierarchical Z-buffer visibility", section 3). A piece is left out when no cell under its rectangle has a point as far as the piece or farther; that is asked of nine cells, of
//! the smallest kind that nine of are enough.
//!
//! Guarantee: a piece that is left out meets no shadow ray of a point, nor one from elsewhere in its slack box, nor that box.
//! Cost: some five nanoseconds a point, and as many a piece.

use rayon::prelude::*;
use umbriel_geometry::simd::{Kernel, Simd, dispatch};

use crate::{
    light_space::{View, greater, lesser},
    loose::{
        CHUNK, Points,
        grid::{WHOLE, low_bits},
        group::above,
        pieces::Pieces,
        placed::{NOWHERE, union},
        seen::{BLOCK, Block, PointError, Row},
    },
};

/// Cells of the raster a point, and a piece, at most, before sides are made powers of two; and at most so many along a side.
const CELLS_A_POINT: f64 = 8.0;
const CELLS_A_PIECE: f64 = 1.0;
const MOST_CELLS: u32 = 1024;

/// The points of one view.
#[derive(Debug)]
pub(super) struct Occupancy {
    /// The smallest cells along u and v.
    along: [Cells; 2],
    /// What the u, v of points are off by.
    off: f64,
    /// Of cells of each size, the smallest first, row by row: none of the cell's points is less near than this; infinite where there is none.
    farthest: Vec<Vec<f32>>,
}

/// Cells along an axis, as many as a power of two.
#[derive(Clone, Copy, Debug)]
struct Cells {
    /// The least and the greatest place of a point.
    least: f64,
    most: f64,
    /// Cells over a unit.
    density: f64,
    count: u32,
}

/// The cells under a rectangle.
#[derive(Clone, Copy, Default)]
struct Under {
    left: u32,
    low: u32,
    right: u32,
    high: u32,
    /// Whether there are points on all sides of it, or within.
    is_among: bool,
}

/// What is seen of some points in each view, and what that is off by at most.
#[derive(Debug)]
pub(super) struct Spots {
    of_views: Vec<Columns>,
    off: f64,
    nearness_off: f64,
}

/// Points in one view.
#[derive(Clone, Debug, Default)]
struct Columns {
    u: Vec<f64>,
    v: Vec<f64>,
    nearness: Vec<f64>,
}

impl Occupancy {
    /// One for each view.
    pub(super) fn of(views: &[View], pieces: &Pieces, parts: &[Spots]) -> Vec<Self> {
        let off = parts.iter().fold(0.0, |off: f64, part| off.max(part.off));
        (0..views.len()).into_par_iter().map(|view| Self::of_view(view, pieces, parts, off)).collect()
    }

    fn of_view(view: usize, pieces: &Pieces, parts: &[Spots], off: f64) -> Self {
        let columns = || parts.iter().map(|part| &part.of_views[view]);
        let [u0, v0, u1, v1] = columns().fold(NOWHERE, |bounds, columns| union(bounds, columns.bounds()));
        let points: usize = columns().map(|columns| columns.u.len()).sum();
        let cells = (points as f64 * CELLS_A_POINT).min(f64::from(pieces.len()) * CELLS_A_PIECE);
        let side = (cells.sqrt() as u32).clamp(1, MOST_CELLS).next_power_of_two();
        let along = [Cells::between(u0, u1, side), Cells::between(v0, v1, side)];
        let mut farthest = vec![f32::INFINITY; (side * side) as usize];
        for part in parts {
            let (columns, off) = (&part.of_views[view], part.nearness_off);
            dispatch(Fill { along, columns, off, farthest: &mut farthest });
        }
        Self { along, off, farthest: with_larger(farthest, side as usize) }
    }

    /// Whether a point may have a piece between itself and the light, or at it; `nearest` is how near the piece comes.
    #[inline(always)]
    pub(super) fn may_meet(&self, bounds: [f64; 4], nearest: f64) -> bool {
        self.has_behind(&self.under(bounds), nearest)
    }

    /// The same of eight, column by column.
    #[inline(always)]
    pub(super) fn may_meet_eight(&self, bounds: &[[f64; 8]; 4], nearest: &[f64; 8]) -> [bool; 8] {
        let (mut under, mut is_met) = ([Under::default(); 8], [false; 8]);
        for (lane, under) in under.iter_mut().enumerate() {
            *under = self.under([bounds[0][lane], bounds[1][lane], bounds[2][lane], bounds[3][lane]]);
        }
        for (lane, is_met) in is_met.iter_mut().enumerate() {
            *is_met = self.has_behind(&under[lane], nearest[lane]);
        }
        is_met
    }

    #[inline(always)]
    fn under(&self, [u0, v0, u1, v1]: [f64; 4]) -> Under {
        let ([along_u, along_v], off) = (self.along, self.off);
        let [u0, v0, u1, v1] = [u0 - off, v0 - off, u1 + off, v1 + off];
        Under {
            left: along_u.at(u0),
            low: along_v.at(v0),
            right: along_u.at(u1),
            high: along_v.at(v1),
            is_among: along_u.meet(u0, u1) & along_v.meet(v0, v1),
        }
    }

    #[inline(always)]
    fn has_behind(&self, &Under { left, low, right, high, is_among }: &Under, nearest: f64) -> bool {
        // Of cells that are at least half as large as the rectangle it meets three at most, along each side.
        let size = (u32::BITS - ((right - left) | (high - low)).leading_zeros()).saturating_sub(1);
        let (cells, side) = (&self.farthest[size as usize], self.along[0].count >> size);
        let [left, right, low, high] = [left, right, low, high].map(|cell| cell >> size);
        let is_behind = |u: u32, v: u32| f64::from(cells[(v * side + u) as usize]) <= nearest;
        let middle = if left < right { left + 1 } else { left };
        let has_behind = |v: u32| is_behind(left, v) | is_behind(middle, v) | is_behind(right, v);
        let between = if low < high { low + 1 } else { low };
        is_among & (has_behind(low) | has_behind(between) | has_behind(high))
    }
}

impl Cells {
    fn between(least: f64, most: f64, count: u32) -> Self {
        let density = if most > least { f64::from(count) / (most - least) } else { 0.0 };
        Self { least, most, density, count }
    }

    /// The cell nearest to a place. Monotone, roundings included: what lies between two places has a cell between theirs.
    #[inline(always)]
    fn at(&self, place: f64) -> u32 {
        let along = (place - self.least) * self.density - 0.5;
        low_bits(lesser(greater(along, 0.0), f64::from(self.count - 1)) + WHOLE)
    }

    /// Whether points lie on both sides of an interval, or within.
    #[inline(always)]
    fn meet(&self, from: f64, to: f64) -> bool {
        (to >= self.least) & (from <= self.most)
    }
}

/// With cells of two by two, until there is one.
fn with_larger(smallest: Vec<f32>, side: usize) -> Vec<Vec<f32>> {
    let larger = |(cells, side): &(Vec<f32>, usize)| {
        let pairs = |rows: &[f32]| {
            let (low, high) = rows.split_at(*side);
            let two_by_two = low.chunks_exact(2).zip(high.chunks_exact(2));
            two_by_two.map(|(low, high)| low[0].min(low[1]).min(high[0].min(high[1]))).collect::<Vec<f32>>()
        };
        (*side > 1).then(|| (cells.chunks_exact(2 * side).flat_map(pairs).collect(), side / 2))
    };
    std::iter::successors(Some((smallest, side)), larger).map(|(cells, _)| cells).collect()
}

/// Puts points into cells.
struct Fill<'a> {
    along: [Cells; 2],
    columns: &'a Columns,
    /// What their nearness is off by.
    off: f64,
    farthest: &'a mut [f32],
}

impl Kernel for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { along: [along_u, along_v], columns: Columns { u, v, nearness }, off, farthest } = self;
        let (mut cells, mut far) = ([0; BLOCK], [0.0; BLOCK]);
        for ((u, v), nearness) in u.chunks(BLOCK).zip(v.chunks(BLOCK)).zip(nearness.chunks(BLOCK)) {
            for (index, ((&u, &v), &nearness)) in u.iter().zip(v).zip(nearness).enumerate() {
                cells[index] = along_v.at(v) * along_u.count + along_u.at(u);
                far[index] = -above(greater(off - nearness, f64::from(f32::MIN)));
            }
            for (&cell, &far) in cells.iter().zip(&far).take(u.len()) {
                let farthest = &mut farthest[cell as usize];
                *farthest = if far < *farthest { far } else { *farthest };
            }
        }
    }
}

impl Spots {
    /// Of points in space, in parts; `None` where what places are off by is not known.
    pub(super) fn of_points(views: &[View], pieces: &Pieces, points: Points) -> Option<Vec<Self>> {
        let starts: Vec<usize> = (0..points.len()).step_by(CHUNK).collect();
        let parts = starts.par_iter().map(|&start| {
            let part = points.part(start, points.len().min(start + CHUNK));
            let size = part.size();
            let off = (part.slack(size), size);
            match part {
                Points::FreeSingle(rows) => Self::of(views, pieces, rows, off),
                Points::FreeDouble(rows) => Self::of(views, pieces, rows, off),
                Points::OrientedSingle(rows) => Self::of(views, pieces, rows, off),
                Points::OrientedDouble(rows) => Self::of(views, pieces, rows, off),
                Points::OnFaces(_) => None,
            }
        });
        parts.collect()
    }

    /// `None` where what places are off by is not known.
    pub(super) fn of<T: Row>(views: &[View], pieces: &Pieces, rows: &[T], (slack, size): (f64, f64)) -> Option<Self> {
        let error = PointError::of(&views[0], &pieces.bounds, slack, size);
        let of_views = dispatch(See { views, rows });
        // Both errors grow with the nearness.
        let greatest = |columns: &Columns| extremes(&columns.nearness).map(f64::abs).into_iter().fold(0.0, greater);
        let greatest = of_views.iter().filter(|columns| !columns.u.is_empty()).map(greatest).fold(0.0, greater);
        let [off, nearness_off] = error.at(greatest)?;
        Some(Self { of_views, off, nearness_off })
    }
}

impl Columns {
    /// Least and greatest u, v.
    fn bounds(&self) -> [f64; 4] {
        let ([u0, u1], [v0, v1]) = (extremes(&self.u), extremes(&self.v));
        [u0, v0, u1, v1]
    }
}

/// The least and the greatest number.
fn extremes(numbers: &[f64]) -> [f64; 2] {
    // Lane by lane, so that no comparison waits for the last one.
    let (mut least, mut most) = ([f64::INFINITY; 8], [f64::NEG_INFINITY; 8]);
    for numbers in numbers.chunks(8) {
        for (lane, &number) in numbers.iter().enumerate() {
            (least[lane], most[lane]) = (lesser(number, least[lane]), greater(number, most[lane]));
        }
    }
    [least.into_iter().fold(f64::INFINITY, lesser), most.into_iter().fold(f64::NEG_INFINITY, greater)]
}

/// Sees points in the views that they are in.
struct See<'a, T> {
    views: &'a [View],
    rows: &'a [T],
}

impl<T: Row> Kernel for See<'_, T> {
    type Output = Vec<Columns>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Vec<Columns> {
        let Self { views, rows } = self;
        let mut of_views = vec![Columns::default(); views.len()];
        let mut block = Block::EMPTY;
        for rows in rows.chunks(BLOCK) {
            if let ([view], [columns]) = (views, of_views.as_mut_slice()) {
                block.see_sun(view, rows);
                let [u, v, nearness] = block.columns(rows.len());
                columns.u.extend_from_slice(u);
                columns.v.extend_from_slice(v);
                columns.nearness.extend_from_slice(nearness);
            } else {
                block.see_lamp(&views[0], rows);
                let [u, v, nearness] = block.columns(rows.len());
                for (index, &view) in block.views(rows.len()).iter().enumerate() {
                    let columns = &mut of_views[view as usize];
                    columns.u.push(u[index]);
                    columns.v.push(v[index]);
                    columns.nearness.push(nearness[index]);
                }
            }
        }
        of_views
    }
}
