//! Receivers of which not even the faces are known: where a clock runs, a mesh of many faces must not cost more than its turn.

use std::{
    cmp::{Ordering, Reverse},
    collections::BinaryHeap,
};

use rayon::prelude::*;
use umbriel_geometry::Approx;

use super::{
    Until,
    looks::{First, Looks},
};
use crate::{progress::Progress, receivers::Receivers};

/// Listing the faces of a mesh costs about as much as so many cells, besides one for each face.
const CELLS_A_MESH: usize = 32;

/// Faces that are listed in one step, so that threads have something to do.
const FACES_A_STEP: usize = 1 << 14;

/// A receiver whose area is known, and how many faces it has.
pub(super) struct Unlisted {
    /// Its place in the request.
    pub(super) receiver: usize,
    pub(super) area: Approx,
    faces: usize,
    /// Square metres for a cell of work.
    worth: f64,
}

/// Receivers that wait for their faces to be listed, the one of most worth first.
#[derive(Default)]
pub(super) struct Waiting(BinaryHeap<Unlisted>);

impl Waiting {
    /// The meshes among the receivers.
    pub(super) fn of(receivers: &Receivers) -> Self {
        let objects = receivers.request.receivers.par_iter().enumerate();
        let unlisted: Vec<Unlisted> = objects
            .filter_map(|(receiver, &object)| {
                let area = receivers.bodies.rough_mesh_area(object).filter(|area| area.error.is_finite())?;
                let faces = receivers.bodies.face_count(object);
                let mut unlisted = Unlisted { receiver, area, faces, worth: area.value };
                unlisted.worth /= unlisted.cost() as f64;
                Some(unlisted)
            })
            .collect();
        Self(unlisted.into())
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Unlisted> {
        self.0.iter()
    }

    /// What is to be listed before faces of this worth are looked at, some at a time; what is worth the same comes first.
    pub(super) fn next_step(&mut self, worth: Option<f64>) -> Vec<Unlisted> {
        let (mut step, mut faces): (Vec<Unlisted>, usize) = (Vec::new(), 0);
        while let Some(next) = self.0.peek() {
            let is_tie = step.last().is_some_and(|last| last.worth == next.worth);
            let is_worth_less = worth.is_some_and(|worth| next.worth < worth);
            if is_worth_less || faces >= FACES_A_STEP && !is_tie {
                break;
            }
            faces += next.faces;
            step.extend(self.0.pop());
        }
        step
    }
}

impl Unlisted {
    /// What listing the faces is expected to cost, in cells.
    pub(super) fn cost(&self) -> u64 {
        (CELLS_A_MESH + self.faces) as u64
    }

    /// The faces, by jobs; `None` if the clock caught it.
    pub(super) fn list(&self, looks: &Looks, until: &Until) -> Option<Vec<First>> {
        let jobs = looks.all.jobs_of(self.receiver);
        jobs.map(|job| (!until.is_cancelled()).then(|| looks.first(&job, until))).collect()
    }
}

impl Ord for Unlisted {
    fn cmp(&self, other: &Self) -> Ordering {
        self.worth.total_cmp(&other.worth).then_with(|| Reverse(self.receiver).cmp(&Reverse(other.receiver)))
    }
}

impl PartialOrd for Unlisted {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Unlisted {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Unlisted {}
