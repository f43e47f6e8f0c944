//! Points parted into jobs, which threads take one after the other.

use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicU64, AtomicUsize, Ordering},
};

use rayon::prelude::*;

use crate::{
    loose::{
        Points, PointsError,
        on_faces::{Faces, OnFaces},
        sorted::Buckets,
    },
    progress::{Cancelled, Progress},
    query::{Queries, QueryDefect},
};

/// Points that follow each other, the places of their answers, and what is already known of them.
pub(super) struct Job<'a, T = ()> {
    /// The number of the first.
    pub(super) first: usize,
    pub(super) points: Points<'a>,
    pub(super) answers: &'a mut [bool],
    pub(super) known: T,
}

/// What a thread keeps from one job to the next: fresh memory costs as much as sorting into it.
#[derive(Debug, Default)]
pub(super) struct Room {
    pub(super) buckets: Buckets,
    pub(super) faces: Faces,
    pub(super) on_faces: OnFaces,
    pub(super) told: Vec<bool>,
}

impl<'a> Points<'a> {
    /// Jobs of so many points.
    pub(super) fn jobs(self, answers: &'a mut [bool], size: usize) -> impl ParallelIterator<Item = Job<'a>> {
        answers.par_chunks_mut(size).enumerate().map(move |(job, answers)| {
            let first = job * size;
            Job { first, points: self.part(first, first + answers.len()), answers, known: () }
        })
    }

    /// Lets threads do the jobs that these points were parted into; the first point of a job that is refused ends it.
    pub(super) fn for_each_job<'j, T: Send>(
        self,
        queries: &Queries,
        jobs: impl ParallelIterator<Item = Job<'j, T>>,
        progress: &dyn Progress,
        phase: &str,
        run: impl Fn(&mut Room, Job<T>) -> Result<(), usize> + Sync,
    ) -> Result<(), PointsError> {
        let (done, total) = (AtomicU64::new(0), self.len() as u64);
        let refused = AtomicUsize::new(usize::MAX);
        let rooms = Mutex::new(Vec::new());
        let take = || rooms.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default();
        let leave = |room: Room| rooms.lock().unwrap_or_else(PoisonError::into_inner).push(room);
        jobs.try_for_each(|job| {
            if progress.is_cancelled() {
                return Err(Cancelled);
            }
            let (first, count) = (job.first, job.points.len() as u64);
            let mut room = take();
            let outcome = run(&mut room, job);
            leave(room);
            if let Err(index) = outcome {
                refused.fetch_min(first + index, Ordering::Relaxed);
            }
            progress.advance(phase, done.fetch_add(count, Ordering::Relaxed) + count, total);
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
}
