//! Many points given by coordinates or by faces, exactly and fast.
//!
//! The problem: whether a light reaches each of millions of loose points, with the answers of [`Queries::lit`]. The way is that
//! of light space: every shadow ray is a point (u, v) of a plane there. The plane is cut into tiles, tiles into cells of about
//! the size of a triangle; a cell holds the triangles over it, nearest to the light first, eight to a [`group`]. Points are [`sorted`] by
//! cell; each looks into its own cell alone, eight of a cell at a time, in f32 with a derived margin. The few points
//! that the margin cannot tell, and those whose slack box may meet a surface, are decided exactly.
//!
//! Guarantee: the answers are those of the definition. A point that some triangle certainly hides, all of its slack box at once and
//! without touching it, is in shadow whatever else may be at the point: a surface point in the box is hidden too, and a point in
//! space as well. If no triangle comes near the box or its shadow, the point is in space and lit. All other points are asked
//! one by one. A point that is given by its face ([`on_faces`]) stands for itself, and that face does not hide it: what else is in doubt is asked
//! exactly.
//!
//! Cost: some 200 ns a triangle and view; 30 to 40 ns a point where neighbours in the list are neighbours in
//! space, 50 to 70 ns where they are strewn; a doubtful point less than a microsecond, one in contact
//! with a surface some microseconds. Where u, v of many points cannot be told from each other (scenes that are far from the
//! origin, in f32) every point is doubtful, and under a lamp that is far from the scene many are.

mod decide;
mod filter;
mod grid;
mod group;
mod listed;
mod occupancy;
mod on_faces;
mod pieces;
mod placed;
mod seen;
mod sorted;
mod tile;

#[cfg(test)]
mod tests;

use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicU64, AtomicUsize, Ordering},
};

use filter::{Doubtful, Filter};
use grid::Grids;
use occupancy::Occupancy;
pub use on_faces::FacePoint;
use on_faces::OnFaces;
use pieces::Pieces;
use rayon::prelude::*;
use sorted::Buckets;
use umbriel_geometry::{LightSource, accept, simd::dispatch};

use crate::{
    light_space::View,
    progress::{Cancelled, Progress},
    query::{Place, Precision, Queries, QueryDefect},
};

/// Points by coordinates, world, metres; or by faces. A normal may have any length but zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Points<'a> {
    /// Points in space, coordinates that were 32-bit floats.
    FreeSingle(&'a [[f32; 3]]),
    /// Points in space.
    FreeDouble(&'a [[f64; 3]]),
    /// Position and normal; each point stands for half an ulp of its 32-bit coordinates.
    OrientedSingle(&'a [[f32; 6]]),
    /// Position and normal; each point stands for half an ulp of its 64-bit coordinates.
    OrientedDouble(&'a [[f64; 6]]),
    /// Points of faces.
    OnFaces(&'a [FacePoint]),
}

/// Points a cell that make it worth its while to sort by cells.
const POINTS_A_CELL: usize = 4;
/// A job takes at least so many points, and at most so many: what is sorted should stay in the processor's caches.
const SMALLEST_JOB: usize = 1 << 16;
const LARGEST_JOB: usize = 1 << 20;
/// So many jobs keep threads busy, of fewer points where there are not enough. Not a matter of how many threads there are: counts of decisions depend on how points are parted.
const LEAST_JOBS: usize = 16;
/// Each job goes once through all cells, whose number over this is fewest points; so are these, whatever the cells.
const CELLS_A_POINT: usize = 8;
const FEWEST: usize = 1 << 10;
/// Points that are looked at one by one are few to a job.
const CHUNK: usize = 4096;

impl Points<'_> {
    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Self::FreeSingle(rows) => rows.len(),
            Self::FreeDouble(rows) => rows.len(),
            Self::OrientedSingle(rows) => rows.len(),
            Self::OrientedDouble(rows) => rows.len(),
            Self::OnFaces(points) => points.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One point, as a single query takes it.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn place(&self, index: usize) -> Place {
        let wide = |row: [f32; 6]| row.map(f64::from);
        let oriented = |[x, y, z, nx, ny, nz]: [f64; 6], precision| Place::Oriented {
            position: [x, y, z],
            normal: [nx, ny, nz],
            precision,
        };
        match self {
            Self::FreeSingle(rows) => Place::Free { position: rows[index].map(f64::from) },
            Self::FreeDouble(rows) => Place::Free { position: rows[index] },
            Self::OrientedSingle(rows) => oriented(wide(rows[index]), Precision::Single),
            Self::OrientedDouble(rows) => oriented(rows[index], Precision::Double),
            Self::OnFaces(points) => points[index].place(),
        }
    }

    /// The first point that a single query would refuse is an error.
    fn check(&self, queries: &Queries) -> Result<(), usize> {
        // Every 32-bit float that is finite is accepted; NaN compares as false.
        let single = |row: &[f32]| size_of_vector(row.iter().map(|&x| f64::from(x))) < f64::INFINITY;
        let double = |row: &[f64]| row.iter().all(|&x| accept(x).is_ok());
        let normal = |size: f64| size > 0.0 && size < f64::INFINITY;
        let normal_single = |row: &[f32]| normal(size_of_vector(row.iter().map(|&x| f64::from(x))));
        let normal_double = |row: &[f64]| row.iter().all(|x| x.is_finite()) && row.iter().any(|&x| x != 0.0);
        // In 32 bits sums of finite numbers may overflow; then the numbers are looked at again.
        let sum = |row: &[f32]| row.iter().fold(0.0, |sum, x| sum + x.abs());
        let is_fine = |row: &[f32; 6]| {
            let (position, normal) = (sum(&row[..3]), sum(&row[3..]));
            (position < f32::INFINITY) & (normal > 0.0) & (normal < f32::INFINITY)
        };
        let refused = match self {
            Self::OrientedSingle(rows) if rows.iter().fold(true, |all, row| all & is_fine(row)) => None,
            Self::FreeSingle(rows) => rows.iter().position(|row| !single(row)),
            Self::FreeDouble(rows) => rows.iter().position(|row| !double(row)),
            Self::OrientedSingle(rows) => rows.iter().position(|row| !(single(&row[..3]) && normal_single(&row[3..]))),
            Self::OrientedDouble(rows) => rows.iter().position(|row| !(double(&row[..3]) && normal_double(&row[3..]))),
            Self::OnFaces(points) => points.iter().position(|&point| queries.surface_defect(point).is_some()),
        };
        refused.map_or(Ok(()), Err)
    }

    /// Lets threads fill in what is said of parts of the points; the first point of a part that is refused ends it.
    fn for_each_part(
        &self,
        queries: &Queries,
        answers: &mut [bool],
        size: usize,
        progress: &dyn Progress,
        fill: impl Fn(&mut Room, Self, &mut [bool]) -> Result<(), usize> + Sync,
    ) -> Result<(), PointsError> {
        let (done, total) = (AtomicU64::new(0), self.len() as u64);
        let refused = AtomicUsize::new(usize::MAX);
        // What a job leaves here another takes up: fresh memory costs as much as sorting into it.
        let rooms = Mutex::new(Vec::new());
        let take = || rooms.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default();
        let leave = |room: Room| rooms.lock().unwrap_or_else(PoisonError::into_inner).push(room);
        answers.par_chunks_mut(size).enumerate().try_for_each(|(job, answers)| {
            if progress.is_cancelled() {
                return Err(Cancelled);
            }
            let mut room = take();
            let filled = fill(&mut room, self.part(job * size, job * size + answers.len()), answers);
            leave(room);
            if let Err(index) = filled {
                refused.fetch_min(job * size + index, Ordering::Relaxed);
            }
            let now = done.fetch_add(answers.len() as u64, Ordering::Relaxed) + answers.len() as u64;
            progress.advance("points", now, total);
            Ok(())
        })?;
        match refused.into_inner() {
            usize::MAX => Ok(()),
            index => {
                let defect = queries.refusal(&self.place(index)).unwrap_or(QueryDefect::OutsideFace);
                Err(PointsError::Refused { index, defect })
            }
        }
    }

    fn part(&self, from: usize, to: usize) -> Self {
        match self {
            Self::FreeSingle(rows) => Self::FreeSingle(&rows[from..to]),
            Self::FreeDouble(rows) => Self::FreeDouble(&rows[from..to]),
            Self::OrientedSingle(rows) => Self::OrientedSingle(&rows[from..to]),
            Self::OrientedDouble(rows) => Self::OrientedDouble(&rows[from..to]),
            Self::OnFaces(points) => Self::OnFaces(&points[from..to]),
        }
    }

    /// What a coordinate of a slack box differs from the point's by at most, for points no greater than `size`.
    fn slack(&self, size: f64) -> f64 {
        match self {
            Self::FreeSingle(_) | Self::FreeDouble(_) | Self::OnFaces(_) => 0.0,
            Self::OrientedSingle(_) => size * 2f64.powi(-24) + 2f64.powi(-150),
            Self::OrientedDouble(_) => size * f64::EPSILON * 0.5,
        }
    }

    /// The greatest magnitude of a coordinate that is given.
    fn size(&self) -> f64 {
        // Axis by axis, so that no comparison waits for the last one.
        fn greatest<const N: usize>(rows: &[[f32; N]]) -> f64 {
            let mut most = [0.0f32; 3];
            for row in rows {
                for (most, x) in most.iter_mut().zip(row) {
                    *most = if x.abs() > *most { x.abs() } else { *most };
                }
            }
            f64::from(most[0].max(most[1]).max(most[2]))
        }
        fn greatest_double<const N: usize>(rows: &[[f64; N]]) -> f64 {
            let mut most = [0.0f64; 3];
            for row in rows {
                for (most, x) in most.iter_mut().zip(row) {
                    *most = if x.abs() > *most { x.abs() } else { *most };
                }
            }
            most[0].max(most[1]).max(most[2])
        }
        match self {
            Self::FreeSingle(rows) => greatest(rows),
            Self::FreeDouble(rows) => greatest_double(rows),
            Self::OrientedSingle(rows) => greatest(rows),
            Self::OrientedDouble(rows) => greatest_double(rows),
            Self::OnFaces(_) => 0.0,
        }
    }
}

/// What a thread keeps from one job to the next.
#[derive(Debug, Default)]
struct Room {
    buckets: Buckets,
    on_faces: OnFaces,
}

/// Why many points have no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PointsError {
    /// A point is refused: the first one.
    #[error("point {index}: {defect}")]
    Refused {
        /// Which, from 0.
        index: usize,
        /// What is wrong with it.
        defect: QueryDefect,
    },
    /// The computation was told to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl Queries<'_> {
    /// Whether each point is lit by `light`: the answers of [`Queries::lit`], point by point, exact.
    ///
    /// What [`Queries::prepare`] made ready for the light is used. Without it the
    /// cost is some 200 ns a triangle (under a lamp, for each of its six views that sees it); 30 to 40 ns a point where neighbours in
    /// the list are neighbours in space, up to 70 ns where they are strewn.
    /// Points in contact with a surface, or behind a triangle with holes, cost some microseconds each.
    ///
    /// # Errors
    /// [`PointsError`] for a coordinate that is not accepted or a normal of length zero, and when told to stop.
    pub fn lit_many(
        &self,
        points: Points,
        light: &LightSource,
        progress: &dyn Progress,
    ) -> Result<Vec<bool>, PointsError> {
        let mut lit = vec![false; points.len()];
        if self.lookup(light).is_some() {
            points.for_each_part(self, &mut lit, CHUNK, progress, |_, part, lit| {
                part.check(self)?;
                lit.iter_mut().enumerate().for_each(|(index, lit)| *lit = self.ask(&part.place(index), light));
                Ok(())
            })?;
            return Ok(lit);
        }
        // One way to the threads and back, not one for each step.
        rayon::scope(|_| self.look(points, light, &mut lit, progress))?;
        Ok(lit)
    }

    /// Looks into light space for all points.
    fn look(
        &self,
        points: Points,
        light: &LightSource,
        lit: &mut [bool],
        progress: &dyn Progress,
    ) -> Result<(), PointsError> {
        let pieces = Pieces::of(&self.bodies);
        let grids = pieces.as_ref().and_then(|pieces| self.grids(pieces, points, light));
        let cells = grids.as_ref().map_or(0, |grids| grids.cells as usize);
        let size = (cells * POINTS_A_CELL).clamp(SMALLEST_JOB, LARGEST_JOB);
        let fewest = (cells / CELLS_A_POINT).clamp(FEWEST, CHUNK);
        let size = size.min(points.len() / LEAST_JOBS).max(fewest);
        points.for_each_part(self, lit, size, progress, |room, part, lit| match (&pieces, &grids) {
            (Some(pieces), Some(grids)) => {
                // Points of faces are looked at while they are gathered.
                if !matches!(part, Points::OnFaces(_)) {
                    part.check(self)?;
                }
                let doubts = self.filter((pieces, grids), part, light, lit, room)?;
                for doubt in doubts {
                    let index = doubt.index as usize;
                    lit[index] = self.decide(pieces, &part.place(index), &doubt, light);
                }
                Ok(())
            }
            // More pieces or cells than can be numbered.
            _ => {
                part.check(self)?;
                lit.iter_mut().enumerate().for_each(|(index, lit)| *lit = self.ask(&part.place(index), light));
                Ok(())
            }
        })
    }

    /// For each point whether it has a normal and no surface in its slack box: it is taken as a point in space.
    ///
    /// Cost: a microsecond a point with a normal.
    ///
    /// # Errors
    /// As [`Queries::lit_many`].
    pub fn in_space_many(&self, points: Points, progress: &dyn Progress) -> Result<Vec<bool>, PointsError> {
        let mut in_space = vec![false; points.len()];
        points.for_each_part(self, &mut in_space, CHUNK, progress, |_, part, in_space| {
            part.check(self)?;
            for (index, in_space) in in_space.iter_mut().enumerate() {
                *in_space = self.is_in_space(&part.place(index));
            }
            Ok(())
        })?;
        Ok(in_space)
    }

    /// The views' grids for these points.
    fn grids<'p>(&self, pieces: &'p Pieces<'p>, points: Points, light: &LightSource) -> Option<Grids<'p>> {
        let views = View::all(light, &pieces.bounds);
        let occupancies = Occupancy::of(self, pieces, &views, points, light);
        Grids::of(pieces, views, points.len(), occupancies.as_deref())
    }

    /// Fills in what is certain; what is left is returned. The first point of a face that is refused is an error.
    ///
    /// What points are off by depends on the largest of their coordinates. Where that is larger than the scene's, a few points may be far
    /// away: smaller parts keep the others from being taken as roughly known, too.
    fn filter(
        &self,
        (pieces, grids): (&Pieces, &Grids),
        part: Points,
        light: &LightSource,
        lit: &mut [bool],
        room: &mut Room,
    ) -> Result<Vec<Doubtful>, usize> {
        let size = part.size();
        if size > FAR * grids.size && part.len() > CHUNK {
            let half = part.len() / 2;
            let (first, second) = lit.split_at_mut(half);
            let mut doubtful = self.filter((pieces, grids), part.part(0, half), light, first, room)?;
            let behind = self.filter((pieces, grids), part.part(half, part.len()), light, second, room);
            let behind = behind.map_err(|index| index + half)?.into_iter();
            doubtful.extend(behind.map(|doubt| Doubtful { index: doubt.index + half as u32, ..doubt }));
            return Ok(doubtful);
        }
        let slack = part.slack(size);
        let (own, Room { buckets, on_faces }) = (&[], room);
        Ok(match part {
            Points::FreeSingle(rows) => dispatch(Filter { grids, rows, own, slack, size, lit, buckets }),
            Points::FreeDouble(rows) => dispatch(Filter { grids, rows, own, slack, size, lit, buckets }),
            Points::OrientedSingle(rows) => dispatch(Filter { grids, rows, own, slack, size, lit, buckets }),
            Points::OrientedDouble(rows) => dispatch(Filter { grids, rows, own, slack, size, lit, buckets }),
            Points::OnFaces(points) => {
                on_faces.gather(self, pieces, points, light)?;
                on_faces.filter(grids, lit, buckets)
            }
        })
    }

    /// One point on its own; the points were checked.
    fn ask(&self, place: &Place, light: &LightSource) -> bool {
        self.lit(place, light).is_ok_and(|answer| answer.lit)
    }
}

/// The sum of magnitudes: of 32-bit numbers it is finite if they are, and zero for zeros alone.
#[inline(always)]
fn size_of_vector(coordinates: impl Iterator<Item = f64>) -> f64 {
    coordinates.fold(0.0, |sum, x| sum + x.abs())
}

/// Points whose coordinates are this many times those of the scene are far away.
const FAR: f64 = 4.0;
