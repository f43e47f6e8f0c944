//! Few points of faces that are turned to the light, beside the triangles there are: a picture's, mostly.
//!
//! The problem: all that is made of a triangle (its place in an order, in a group, in cells) costs as much as some points do, and most triangles have none of the points
//! behind them. The way: points are gathered all before anything is made, which leaves those of faces that are turned to the light, and what lies before none of these is left out
//! ([`occupancy`](super::occupancy)). Guarantee: the answers are those of [`Queries::lit_many`]. Cost: some ten nanoseconds a point more, some fifty a triangle less.

use std::{
    mem,
    sync::{Mutex, PoisonError},
};

use rayon::prelude::*;

use crate::{
    light_space::View,
    loose::{
        CHUNK, FEWEST, LEAST_JOBS, Points, PointsError, fewest_of_job,
        grid::Grids,
        jobs::Job,
        occupancy::{Occupancy, Spots},
        on_faces::{FacePoint, LitScene, OnFaces, open_part},
    },
    progress::Progress,
};

/// Worth its while where at most so many points a piece are turned to the light, and so many are asked for in all.
const OPEN_POINTS_A_PIECE: f64 = 1.5;
const POINTS_A_PIECE: f64 = 64.0;

/// Parts of so many points are joined no further, however few of them are turned to the light.
const MOST_OF_JOB: usize = 1 << 24;

/// Points that follow each other, of which some are turned to the light.
pub(super) struct Part {
    /// The number of the first.
    first: usize,
    /// How many, those included that are dark.
    count: usize,
    turned: OnFaces,
}

impl<'a> LitScene<'a> {
    /// Whether there are few points beside the pieces, as far as some of them tell.
    pub(super) fn are_few(self, points: &[FacePoint]) -> bool {
        let (count, pieces) = (points.len() as f64, f64::from(self.pieces.len()));
        let most = OPEN_POINTS_A_PIECE * pieces;
        count <= most || count <= POINTS_A_PIECE * pieces && count * open_part(self, points) <= most
    }

    /// Fills in which points are lit, where nothing was said of them. False where cells cannot be numbered.
    pub(super) fn tell_few(
        self,
        points: &[FacePoint],
        lit: &mut [bool],
        progress: &dyn Progress,
    ) -> Result<bool, PointsError> {
        let parts = self.gathered(points, lit, progress)?;
        let Some(grids) = self.grids_before(&parts) else { return Ok(false) };
        let all: usize = parts.iter().map(|part| part.turned.len()).sum();
        let least = (all / LEAST_JOBS).clamp(fewest_of_job(&grids), CHUNK);
        let jobs = jobs(merged(parts, least), points, lit).into_par_iter();
        Points::OnFaces(points).for_each_job(self.queries, jobs, progress, "points", |room, job| {
            let doubtful = job.known.filter(&grids, job.answers, &mut room.buckets, &mut room.told);
            self.decide_all(job.points, doubtful, job.answers);
            Ok(())
        })?;
        Ok(true)
    }

    /// The points in parts, in their order.
    pub(super) fn gathered(
        self,
        points: &[FacePoint],
        lit: &mut [bool],
        progress: &dyn Progress,
    ) -> Result<Vec<Part>, PointsError> {
        let (all, parts) = (Points::OnFaces(points), Mutex::new(Vec::new()));
        let size = (points.len() / LEAST_JOBS).clamp(FEWEST, CHUNK);
        all.for_each_job(self.queries, all.jobs(lit, size), progress, "places of points", |room, job| {
            let (first, count) = (job.first, job.answers.len());
            room.on_faces.gather(&mut room.faces, self, &points[first..][..count])?;
            let part = Part { first, count, turned: room.on_faces.copied() };
            parts.lock().unwrap_or_else(PoisonError::into_inner).push(part);
            Ok(())
        })?;
        let mut parts = parts.into_inner().unwrap_or_else(PoisonError::into_inner);
        parts.sort_unstable_by_key(|part| part.first);
        Ok(parts)
    }

    /// The views' grids of what lies before some of these points. Cells have no sheets: surfaces have gaps where pieces are left out.
    pub(super) fn grids_before(self, parts: &[Part]) -> Option<Grids<'a>> {
        let views = View::all(self.light, &self.pieces.bounds);
        let spots = |part: &Part| Spots::of(&views, self.pieces, part.turned.rows(), part.turned.off());
        let spots: Option<Vec<Spots>> = parts.par_iter().map(spots).collect();
        let occupancies = spots.map(|spots| Occupancy::of(&views, self.pieces, &spots));
        let count = parts.iter().map(|part| part.turned.rows().len()).sum();
        Grids::of(self.pieces, views, count, occupancies.as_deref())
    }
}

/// Parts of at least so many points that are turned to the light, but for the last one.
fn merged(parts: Vec<Part>, least: usize) -> Vec<Part> {
    let mut merged: Vec<Part> = Vec::new();
    for part in parts {
        let is_small = |last: &&mut Part| last.turned.len() < least && last.count < MOST_OF_JOB;
        match merged.last_mut().filter(is_small) {
            Some(last) => {
                last.turned.append(&part.turned, last.count);
                last.count += part.count;
            }
            None => merged.push(part),
        }
    }
    merged
}

/// Each part with its points and their answers.
fn jobs<'a>(parts: Vec<Part>, points: &'a [FacePoint], mut lit: &'a mut [bool]) -> Vec<Job<'a, OnFaces>> {
    let job = |Part { first, count, turned }| {
        let (here, behind) = mem::take(&mut lit).split_at_mut(count);
        lit = behind;
        Job { first, points: Points::OnFaces(&points[first..][..count]), answers: here, known: turned }
    };
    parts.into_iter().map(job).collect()
}
