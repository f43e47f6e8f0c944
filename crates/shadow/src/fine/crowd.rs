//! Faces in a crowd: under so many facets, and so many of them, that measuring all facets against all faces would take the square of the input.
//!
//! Such a face is divided without a list of what is over it. Cells with the fewest facets over them go on as any other ([`FlatFace::divide`]); for the rest up
//! to 1,024 facets over the face, picked evenly (fewer where more than 8,192 faces are crowded), are asked whether one of them covers the cell alone, and some of them together at the last. What some of the
//! occluders cover is in shadow whatever the others do, so a cell's verdict is a proof here too; but none of these is proved lit, and some stay undecided that all
//! facets together would prove shadowed (a sheet of small triangles). A face is divided so only where measuring what is over it comes to more than [`LEFT`] facets and its share, by area, of what all may have
//! together ([`PAIRS_BY_AREA`], [`PAIRS_BY_AREA_IN_SCENE`]): a floor has all of it measured. Guarantee for the others: [`PAIRS`] facets are measured for a face, [`PARTS`] for each of at most 64 cells, and
//! those picked are measured once each, by floats, and looked at for each of at most 85, fewer where there are more than 16,384 faces, whatever the detail; which they are goes by the light, the face and what may shadow it, not by their
//! order. Estimates of undecided cells ask the few parts alone, so they lean to lit. Cost: half a millisecond a face, some where very many facets are beside a
//! cell though their boxes hold it. Not bounded: samples are looked up one by one. The limit is one of each receiver by itself, whose occluders are asked object by
//! object; thousands of objects over each other are a [`throng`](crate::throng).

use std::ops::Range;

use umbriel_octree::Quadrant;

use super::{
    classify::Blockers,
    flat::{self, FLAT, FlatFace, count, count_samples},
    occluders::{
        Among, Candidates, Occluders,
        few::{Picked, Spot, bounds_of},
    },
    polygon_blocker::FacetId,
    receiver::Receiver,
    tally::{Tally, Units},
};
use crate::report::Verdict;

/// Facets that may be measured for cells of a face in a crowd.
pub(crate) const PAIRS: usize = 128;

/// Facets that floats leave in question, with what finding them takes, that any face of a crowd may be measured against: about as many as of [`PAIRS`] over its box.
const LEFT: usize = 32;

/// The finest level of cells: finer ones would be as many as the detail says, for each of thousands of faces.
const FINEST: u8 = 3;

/// Cells of the finest level that the faces of an object have together, at most, unless each has one: some ten microseconds each.
const CELLS: usize = 1 << 20;

/// Facets picked for a face, at least and at most; and for all of them together, between these.
const PICKED: Range<usize> = 128..1024;
const PICKS: usize = 1 << 23;

/// How many facets that do not cover a cell alone are measured together.
const PARTS: usize = 8;

/// Facets over a cell that are counted, and picked ones that are looked at for it, in the time in which one is held against it.
const COUNTED_A_PAIR: usize = 2;
const PICKED_A_PAIR: usize = 3;

/// Pairs that the faces of a receiver in a crowd may have together beside those that each may have, and those of a scene.
const PAIRS_BY_AREA: usize = 1 << 19;
const PAIRS_BY_AREA_IN_SCENE: usize = 1 << 17;

/// Pairs of a face and a facet over it that any receiver may have, and for each of its faces and the facets of its occluders: some seconds.
const FREE_PAIRS: usize = 1 << 22;
const PAIRS_EACH: usize = 256;

/// How many faces of a receiver tell at least whether it is in a crowd.
const ASKED: usize = 64;

/// Faces that are a crowd together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Members {
    count: usize,
    /// Of all, m².
    area: f64,
    /// Pairs that they may have together beside those that each may have.
    pairs_by_area: usize,
}

impl Members {
    /// The faces of a receiver.
    pub(crate) fn of_receiver(count: usize, area: f64) -> Self {
        Self { count, area, pairs_by_area: PAIRS_BY_AREA }
    }

    /// All faces of a scene.
    pub(crate) fn of_scene(count: usize, area: f64) -> Self {
        Self { count, area, pairs_by_area: PAIRS_BY_AREA_IN_SCENE }
    }

    /// What one of them of this area may have over it and be measured against all of that still: [`LEFT`], and its share by area.
    pub(crate) fn allowed(&self, area: f64) -> usize {
        let share = if area < self.area { area / self.area } else { 1.0 };
        LEFT + (share * self.pairs_by_area as f64) as usize
    }

    /// How far each of the others is gone into.
    pub(crate) fn means(&self) -> Means {
        let finest = (1..=FINEST).rev().find(|&level| self.count << (2 * level) <= CELLS).unwrap_or(0);
        Means { finest, picked: (PICKS / self.count.max(1)).clamp(PICKED.start, PICKED.end) }
    }
}

/// How far a face in a crowd is gone into: less where very many are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Means {
    /// The finest level of cells.
    pub(crate) finest: u8,
    /// Facets that are picked at most.
    picked: usize,
}

/// Pairs that so many faces may have with so many facets over them.
pub(crate) fn allowed(faces: usize, facets: usize) -> usize {
    FREE_PAIRS.saturating_add(faces.saturating_add(facets).saturating_mul(PAIRS_EACH))
}

/// Whether faces, those of a receiver or of all, have more pairs with the facets over them than are allowed. Expected from the faces halved as often as leaves
/// enough of them, by how often each can be halved ([`halvings`](crate::tickets::halvings)); `count` tells how many facets are over a face, up to a limit.
pub(crate) fn is_crowd(halvings: &[u8], allowed: usize, count: impl Fn(usize, usize) -> usize) -> bool {
    let faces = halvings.len();
    let left_after = |times: u8| halvings.iter().filter(|&&own| own >= times).count();
    let times = (0..u8::MAX).take_while(|&times| times == 0 || left_after(times) >= ASKED).last().unwrap_or(0);
    let most = allowed.saturating_mul(left_after(times)) / faces.max(1);
    let mut asked = (0..faces).filter(|&face| halvings[face] >= times);
    // Ends where it is known to be too many.
    let left = asked.try_fold(most, |left, face| left.checked_sub(count(face, left + 1)));
    left.is_none()
}

/// One face in a crowd.
pub(crate) struct Crowd<'a> {
    pub(crate) own: FacetId,
    pub(crate) means: Means,
    pub(crate) receiver: &'a Receiver<'a, FLAT>,
    pub(crate) occluders: &'a Occluders<'a>,
    /// What may shadow the face.
    pub(crate) among: Among<'a>,
    /// The face under these blockers alone.
    pub(crate) under: &'a dyn Fn(Blockers<'a, FLAT>) -> FlatFace<'a>,
}

impl<'a> Crowd<'a> {
    /// Classifies the whole face, level by level: so which cells have all that is over them measured does not go by their order.
    pub(crate) fn run(&self) -> Tally<Units> {
        let bare = (self.under)(Blockers::none());
        let picked = self.occluders.pick(self.among, self.receiver, self.means.picked);
        let (mut done, mut level, mut left) = (Vec::new(), vec![Quadrant::ROOT], PAIRS);
        let cost = (PAIRS / COUNTED_A_PAIR + picked.len() / PICKED_A_PAIR) as u64;
        while !level.is_empty() && (bare.spend)(level.len() as u64 * cost) {
            let many = self.take_affordable(&mut level, &bare, &mut left);
            done.extend(level.iter().map(|&place| (place, self.under_all(&bare, place))));
            level = Vec::new();
            for place in many {
                let (tally, is_open) = self.under_picked(&bare, &picked, place);
                done.push((place, tally));
                level.extend(bare.shape.domain.children(place).filter(|_| is_open));
            }
        }
        done.sort_unstable_by_key(|(place, _)| *place);
        done.into_iter().fold(Tally::new(), |mut sum, (_, tally)| {
            sum.append(tally);
            sum
        })
    }

    /// Leaves the cells with the fewest facets over them, as long as so many pairs are left, and returns the others. Of cells with equally many all or none.
    fn take_affordable(&self, cells: &mut Vec<Quadrant>, bare: &FlatFace, left: &mut usize) -> Vec<Quadrant> {
        let over =
            |place: Quadrant| self.occluders.count(self.among, &bounds_of(&self.corners(bare, place)), *left + 1);
        let mut counted: Vec<(usize, Quadrant)> = cells.iter().map(|&place| (over(place), place)).collect();
        counted.sort_unstable();
        let mut taken = 0;
        for equal in counted.chunk_by(|a, b| a.0 == b.0) {
            let Some(rest) = left.checked_sub(equal.len() * equal[0].0) else { break };
            (*left, taken) = (rest, taken + equal.len());
        }
        *cells = counted.iter().map(|&(_, place)| place).collect();
        cells.split_off(taken)
    }

    /// Classifies a cell under all facets over it.
    fn under_all(&self, bare: &FlatFace, place: Quadrant) -> Tally<Units> {
        let mut tally = Tally::new();
        let points = bounds_of(&self.corners(bare, place));
        let face = self.under_these(self.occluders.candidates(self.among, &points));
        face.divide(place, &face.blockers.entries(), &mut tally);
        tally
    }

    /// Classifies a cell under the facets picked for its face, and tells whether it is to be divided.
    fn under_picked(&self, bare: &FlatFace, picked: &Picked, place: Quadrant) -> (Tally<Units>, bool) {
        let mut tally = Tally::new();
        tally.examined += 1;
        let corners = self.corners(bare, place);
        if self.occluders.is_covered((picked, self.own), &corners) {
            shadowed(bare, place, &mut tally);
        } else if !bare.is_finest(place) {
            return (tally, true);
        } else {
            let middle = self.spot(bare, bare.shape.middle(place));
            let hiding = self.occluders.hiding((picked, self.own), (&corners, &middle));
            self.under_parts(bare, parts_of(hiding), place, &mut tally);
        }
        (tally, false)
    }

    /// Classifies a cell of the finest level under some facets that hide its middle.
    fn under_parts(&self, bare: &FlatFace, parts: Candidates, place: Quadrant, tally: &mut Tally<Units>) {
        let face = self.under_these(parts);
        let entries = face.blockers.entries();
        if face.blockers.classify(&bare.shape.hull(place), &entries, &mut Vec::new()) == Verdict::Shadowed {
            return shadowed(bare, place, tally);
        }
        count(tally, bare.shape, place, Verdict::Undecided, bare.levels);
        face.estimate(place, &entries, tally);
        bare.look_samples_up(place, tally);
    }

    fn corners(&self, bare: &FlatFace, place: Quadrant) -> Vec<Spot<'a>> {
        bare.shape.domain.corners(place).map(|corner| self.spot(bare, corner)).collect()
    }

    /// A corner or the middle of a cell.
    fn spot(&self, bare: &FlatFace, [u, v]: [f64; 2]) -> Spot<'a> {
        Spot { probe: flat::flat_probe(&self.receiver.points, u, v), weights: bare.shape.weights(u, v) }
    }

    /// The face under some facets alone.
    fn under_these(&self, mut candidates: Candidates) -> FlatFace<'_> {
        candidates.facets.retain(|&facet| facet != self.own);
        (self.under)(self.occluders.blockers(&candidates.facets, &candidates.bodies, self.receiver))
    }
}

/// [`PARTS`] of some facets, by their tickets; of those with the same ticket all or none.
fn parts_of(mut hiding: Vec<(u64, FacetId)>) -> Candidates {
    hiding.sort_unstable();
    let is_end = |&end: &usize| end == 0 || hiding.get(end).is_none_or(|next| next.0 != hiding[end - 1].0);
    let end = (0..=PARTS.min(hiding.len())).rev().find(is_end).unwrap_or(0);
    Candidates { facets: hiding[..end].iter().map(|&(_, id)| id).collect(), bodies: Vec::new() }
}

fn shadowed(face: &FlatFace, place: Quadrant, tally: &mut Tally<Units>) {
    count(tally, face.shape, place, Verdict::Shadowed, face.levels);
    count_samples(tally, face.lattice, place, Verdict::Shadowed);
}
