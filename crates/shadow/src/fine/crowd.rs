//! Faces in a crowd: under so many facets, and so many of them, that measuring all facets against all faces would take the square of the input.
//!
//! Such a face is divided without a list of what is over it. Where so few facets are over a cell that the face's [`PAIRS`] suffice, it goes on as any
//! other ([`FlatFace::divide`]); else [`MANY`] facets that are likely to cover the cell are all that is tried. What some of the occluders cover is in shadow
//! whatever the others do, so a cell's verdict is a proof here too; but no cell is proved lit, and some stay undecided that all facets together would
//! prove shadowed (a sheet of small triangles). Guarantee: at most [`PAIRS`] facets a face and [`MANY`] + [`FEW`] a cell are measured, and there are no more than 85 cells
//! ([`FINEST`]), whatever the detail. Estimates of undecided cells ask these few facets as well, so they lean to lit. Cost: about a microsecond a facet measured, and
//! as much for ten looked at. Not bounded: all objects that may shadow the receiver are asked for each cell, and samples are looked up one by one. The limit is one of each
//! receiver by itself, so thousands of small objects over each other are the square of the input still.

use umbriel_geometry::Point;
use umbriel_octree::Quadrant;

use super::{
    classify::Blockers,
    flat::{self, FLAT, FlatFace, count, count_samples},
    occluders::Occluders,
    polygon_blocker::FacetId,
    receiver::Receiver,
    tally::{Tally, Units},
};
use crate::report::Verdict;

/// Facets that may be measured for a face in a crowd.
pub(crate) const PAIRS: usize = 128;

/// The finest level of cells: finer ones would be as many as the detail says, for each of thousands of faces.
pub(crate) const FINEST: u8 = 3;

/// How many likely covers of a cell are tried first, and in all.
const FEW: usize = 2;
const MANY: usize = 8;

/// Pairs of a face and a facet over it that any receiver may have, and for each of its faces and the facets of its occluders: some seconds.
const FREE_PAIRS: usize = 1 << 22;
const PAIRS_EACH: usize = 256;

/// How many faces of a receiver tell whether it is in a crowd, and how far the facets over one of them are counted.
const SAMPLES: usize = 64;
const MOST_COUNTED: usize = 1 << 16;

/// Whether a receiver of so many faces, under objects of so many facets, has too many pairs to measure them all; `count` tells how many facets are over a
/// face, up to a limit. Expected from every n-th face.
pub(crate) fn is_crowd(faces: usize, facets: usize, count: impl Fn(usize, usize) -> usize) -> bool {
    let allowed = FREE_PAIRS.saturating_add(faces.saturating_add(facets).saturating_mul(PAIRS_EACH));
    if faces.saturating_mul(facets) <= allowed {
        return false;
    }
    let step = faces.div_ceil(SAMPLES);
    let sampled = (0..faces).step_by(step);
    let (asked, pairs) = (sampled.len(), sampled.map(|face| count(face, MOST_COUNTED)).sum::<usize>());
    pairs.saturating_mul(faces) / asked > allowed
}

/// One face in a crowd.
pub(crate) struct Crowd<'a> {
    pub(crate) own: FacetId,
    pub(crate) receiver: &'a Receiver<'a, FLAT>,
    pub(crate) occluders: &'a Occluders<'a>,
    /// What may shadow the face.
    pub(crate) objects: &'a [u32],
    /// The face under these blockers alone.
    pub(crate) under: &'a dyn Fn(Blockers<'a, FLAT>) -> FlatFace<'a>,
}

impl Crowd<'_> {
    /// Classifies the whole face.
    pub(crate) fn run(&self) -> Tally<Units> {
        let (mut tally, mut left) = (Tally::new(), PAIRS);
        self.divide(&(self.under)(Blockers::none()), Quadrant::ROOT, &mut left, &mut tally);
        tally
    }

    /// Classifies a cell of the bare face, with so many pairs left.
    fn divide(&self, bare: &FlatFace, place: Quadrant, left: &mut usize, tally: &mut Tally<Units>) {
        if (bare.is_cancelled)() {
            return;
        }
        let corners = bare.shape.domain.corners(place);
        let points: Vec<Point> = corners.map(|[u, v]| flat::flat_probe(&self.receiver.points, u, v).bounds).collect();
        let over = self.occluders.count(self.objects, &points, *left + 1);
        if over <= *left {
            *left -= over;
            let mut candidates = self.occluders.candidates(self.objects, &points);
            candidates.facets.retain(|&facet| facet != self.own);
            let face = (self.under)(self.occluders.blockers(&candidates, self.receiver));
            return face.divide(place, &face.blockers.entries(), tally);
        }
        tally.examined += 1;
        let likely = self.under_likely_covers(bare, place, &points);
        match likely {
            None => {
                count(tally, bare.shape, place, Verdict::Shadowed, bare.levels);
                count_samples(tally, bare.lattice, place, Verdict::Shadowed);
            }
            Some(face) if bare.is_finest(place) => {
                count(tally, bare.shape, place, Verdict::Undecided, bare.levels);
                face.estimate(place, &face.blockers.entries(), tally);
                bare.look_samples_up(place, tally);
            }
            Some(_) => bare.shape.domain.children(place).for_each(|part| self.divide(bare, part, left, tally)),
        }
    }

    /// The face under facets that are likely to cover a cell, given by its corners, and do not; `None` if they do.
    fn under_likely_covers(&self, bare: &FlatFace, place: Quadrant, points: &[Point]) -> Option<FlatFace<'_>> {
        let hull = bare.hull(place);
        let mut likely = self.occluders.likely_covers(self.objects, points, MANY);
        likely.facets.retain(|&facet| facet != self.own);
        let covers = |face: &FlatFace| {
            face.blockers.classify(&hull, &face.blockers.entries(), &mut Vec::new()) == Verdict::Shadowed
        };
        let first = (self.under)(self.occluders.blockers(&likely.first(FEW), self.receiver));
        if covers(&first) {
            return None;
        }
        let all = if likely.facets.len() <= FEW {
            first
        } else {
            (self.under)(self.occluders.blockers(&likely, self.receiver))
        };
        (!covers(&all)).then_some(all)
    }
}
