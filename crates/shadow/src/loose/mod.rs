//! Many points given by coordinates or by faces, exactly and fast.
//!
//! The problem: whether a light reaches each of millions of loose points, with the answers of [`Queries::lit`]. The way is that
//! of light space: every shadow ray is a point (u, v) of a plane there. The plane is cut into tiles, tiles into cells of about
//! the size of a triangle; a cell holds the triangles over it, nearest to the light first, eight to a [`group`]. Points are [`sorted`] by
//! cell; each looks into its own cell alone, up to sixteen of a cell at a time, in f32 with a derived margin. The few points
//! that the margin cannot tell, and those whose slack box may meet a surface, are decided exactly.
//!
//! Guarantee: the answers are those of the definition. A point that some triangle certainly hides, all of its slack box at once and
//! without touching it, is in shadow whatever else may be at the point: a surface point in the box is hidden too, and a point in
//! space as well. If no triangle comes near the box or its shadow, the point is in space and lit. All other points are asked
//! one by one. A point that is given by its face ([`on_faces`]) stands for itself, and that face does not hide it: what else is in doubt is asked
//! exactly.
//!
//! Cost: some 200 ns a triangle, in each view that sees it; 10 to 30 ns a point where neighbours in the list are neighbours in
//! space, 15 to 60 ns where they are strewn; a doubtful point less than a microsecond, one in contact
//! with a surface some microseconds. Where u, v of many points cannot be told from each other (scenes that are far from the
//! origin, in f32) every point is doubtful, and under a lamp that is far from the scene many are.

mod decide;
mod few;
mod filter;
mod grid;
mod group;
mod jobs;
mod listed;
mod occupancy;
mod on_faces;
mod order;
mod pieces;
mod placed;
mod points;
mod seen;
mod sorted;
mod surface;
mod tile;
mod turned;

#[cfg(test)]
mod tests;

use filter::{Doubtful, Filter};
use grid::Grids;
use jobs::{Job, Room};
use occupancy::{Occupancy, Spots};
pub use on_faces::FacePoint;
use on_faces::LitScene;
use pieces::Pieces;
pub use points::Points;
use umbriel_geometry::{LightSource, simd::dispatch};

use crate::{
    light_space::View,
    progress::{Cancelled, Progress},
    query::{Place, Queries, QueryDefect},
};

/// Points a cell that make it worth its while to sort by cells.
const POINTS_A_CELL: usize = 4;
/// A job takes at least so many points, and at most so many: what is sorted should stay in the processor's caches.
const SMALLEST_JOB: usize = 1 << 16;
const LARGEST_JOB: usize = 1 << 20;
/// So many jobs keep threads busy, of fewer points where there are not enough. Not a matter of how many threads there are: counts of decisions depend on how points are parted.
const LEAST_JOBS: usize = 16;
/// Jobs of fewer points than [`CHUNK`] go where each goes through no more cells than this for a point, and never below so many points.
const CELLS_GONE_THROUGH: usize = 8;
const FEWEST: usize = 1 << 10;
/// Points of faces a piece from which on it is worth its while to know which pieces are of closed surfaces ([`surface`]).
const SURFACE_POINTS_A_PIECE: f64 = 4.0;
/// Points in space a piece up to which it is worth its while to leave out what none of them is behind ([`occupancy`]).
const SPACE_POINTS_A_PIECE: f64 = 1.0;
/// Points that are looked at one by one are few to a job.
const CHUNK: usize = 4096;

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
    /// cost is some 200 ns a triangle (under a lamp, for each of its six views that sees it); 10 to 30 ns a point where neighbours in
    /// the list are neighbours in space, up to 60 ns where they are strewn.
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
            self.ask_all(points, light, &mut lit, progress)?;
            return Ok(lit);
        }
        // One way to the threads and back, not one for each step.
        rayon::scope(|_| self.look(points, light, &mut lit, progress))?;
        Ok(lit)
    }

    /// Asks each point on its own.
    fn ask_all(
        &self,
        points: Points,
        light: &LightSource,
        lit: &mut [bool],
        progress: &dyn Progress,
    ) -> Result<(), PointsError> {
        points.for_each_job(self, points.jobs(lit, CHUNK), progress, "points", |_, Job { points, answers, .. }| {
            points.check(self)?;
            answers.iter_mut().enumerate().for_each(|(index, lit)| *lit = self.ask(&points.place(index), light));
            Ok(())
        })
    }

    /// Looks into light space for all points.
    fn look(
        &self,
        points: Points,
        light: &LightSource,
        lit: &mut [bool],
        progress: &dyn Progress,
    ) -> Result<(), PointsError> {
        // More pieces or cells than can be numbered: asked one by one.
        let Some(mut pieces) = Pieces::of(&self.bodies) else { return self.ask_all(points, light, lit, progress) };
        if points.are_themselves() {
            pieces.leave_out(self, light, matches!(points, Points::OnFaces(_)));
        }
        if let Points::OnFaces(points) = points {
            let at = LitScene { queries: self, pieces: &pieces, light };
            if at.are_few(points) && at.tell_few(points, lit, progress)? {
                return Ok(());
            }
            if points.len() as f64 > SURFACE_POINTS_A_PIECE * f64::from(pieces.len()) {
                pieces.find_surfaces();
            }
        }
        let Some(grids) = self.grids(&pieces, points, light) else {
            return self.ask_all(points, light, lit, progress);
        };
        let at = LitScene { queries: self, pieces: &pieces, light };
        let size = (grids.cells as usize * POINTS_A_CELL).clamp(SMALLEST_JOB, LARGEST_JOB);
        let size = size.min(points.len() / LEAST_JOBS).max(fewest_of_job(&grids));
        points.for_each_job(self, points.jobs(lit, size), progress, "points", |room, Job { points, answers, .. }| {
            // Points of faces are looked at while they are gathered.
            let size = points.checked_size(self)?;
            let doubtful = self.filter(at, &grids, points, size, answers, room)?;
            at.decide_all(points, doubtful, answers);
            Ok(())
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
        points.for_each_job(self, points.jobs(&mut in_space, CHUNK), progress, "points", |_, job| {
            job.points.check(self)?;
            for (index, in_space) in job.answers.iter_mut().enumerate() {
                *in_space = self.is_in_space(&job.points.place(index));
            }
            Ok(())
        })?;
        Ok(in_space)
    }

    /// The views' grids for these points. What few points in space have nothing to do with is left out.
    fn grids<'p>(&self, pieces: &'p Pieces<'p>, points: Points, light: &LightSource) -> Option<Grids<'p>> {
        let views = View::all(light, &pieces.bounds);
        let are_few = points.len() as f64 <= SPACE_POINTS_A_PIECE * f64::from(pieces.len());
        let spots = if are_few { Spots::of_points(&views, pieces, points) } else { None };
        let occupancies = spots.map(|spots| Occupancy::of(&views, pieces, &spots));
        Grids::of(pieces, views, points.len(), occupancies.as_deref())
    }

    /// Fills in what is certain; what is left is returned. The first point of a face that is refused is an error.
    ///
    /// What points are off by depends on the largest of their coordinates. Where that is larger than the scene's, a few points may be far
    /// away: smaller parts keep the others from being taken as roughly known, too.
    fn filter(
        &self,
        at: LitScene,
        grids: &Grids,
        part: Points,
        size: f64,
        lit: &mut [bool],
        room: &mut Room,
    ) -> Result<Vec<Doubtful>, usize> {
        if size > FAR * grids.size && part.len() > CHUNK {
            let half = part.len() / 2;
            let (first, second) = lit.split_at_mut(half);
            let [before, behind] = [part.part(0, half), part.part(half, part.len())];
            let mut doubtful = self.filter(at, grids, before, before.size(), first, room)?;
            let behind = self.filter(at, grids, behind, behind.size(), second, room)?;
            doubtful.extend(behind.into_iter().map(|doubt| Doubtful { index: doubt.index + half as u32, ..doubt }));
            return Ok(doubtful);
        }
        let slack = part.slack(size);
        let (own, Room { buckets, faces, on_faces, told }) = (&[], room);
        Ok(match part {
            Points::FreeSingle(rows) => dispatch(Filter { grids, rows, own, slack, size, lit, buckets }),
            Points::FreeDouble(rows) => dispatch(Filter { grids, rows, own, slack, size, lit, buckets }),
            Points::OrientedSingle(rows) => dispatch(Filter { grids, rows, own, slack, size, lit, buckets }),
            Points::OrientedDouble(rows) => dispatch(Filter { grids, rows, own, slack, size, lit, buckets }),
            Points::OnFaces(points) => {
                on_faces.gather(faces, at, points)?;
                on_faces.filter(grids, lit, buckets, told)
            }
        })
    }

    /// One point on its own; the points were checked.
    fn ask(&self, place: &Place, light: &LightSource) -> bool {
        self.lit(place, light).is_ok_and(|answer| answer.lit)
    }
}

/// Jobs of fewer points would go through too many cells for each.
fn fewest_of_job(grids: &Grids) -> usize {
    (grids.cells as usize / CELLS_GONE_THROUGH).clamp(FEWEST, CHUNK)
}

/// Points whose coordinates are this many times those of the scene are far away.
const FAR: f64 = 4.0;
