//! A cell of a patch under analytic bodies: dozens in a list, or thousands in a [`swarm`](super::occluders::swarm).
//!
//! Measuring a body against a cell takes microseconds, and of a coarse cell it often tells nothing yet. So where many bodies are over a cell, those that hide its
//! middle are asked whether they cover it, and the others whether they miss it; each kind in the order of boxes in light space, from that end where an answer is
//! likeliest. Over a cell that may yet be divided, either is given up when [`PATIENCE`] bodies in a row have told nothing; over any other the second kind is as soon as one body
//! is in question. What was not asked stays in question; so does a body that hides some corners of the cell and others not, as floats tell: measuring it would prove nothing.
//! Guarantee: what is told of a cell is proved, and goes by the bodies and the cell, whatever the order of bodies and of axes (where the effort is spent nothing more is told, and what was is dropped). Cost: some fifty nanoseconds a body
//! over the cell, and microseconds each one that is measured.

use umbriel_geometry::analytic::HULL;

use super::{Occluders, Receiver, analytic_blocker::Influence, field::Weights, occluders::swarm::Above};
use crate::effort::{BODY, Spend};

/// Up to so many bodies all are asked.
const FEW: usize = 16;

/// BodiesOver that are looked at in the time in which a facet is held against a cell.
const LOOKED_A_FACET: usize = 2;

/// BodiesOver of a swarm that seem to cover a cell and are measured in vain.
const PROMISING: usize = 4;

/// BodiesOver in a row that tell nothing.
const PATIENCE: usize = 8;

/// A cell under bodies.
pub(super) struct Pile<'a, 'b> {
    pub(super) occluders: &'a Occluders<'b>,
    /// Its hull, and the corners of that.
    pub(super) receiver: &'a Receiver<'a, HULL>,
    pub(super) corners: &'a [Weights<HULL>],
    /// Its middle.
    pub(super) middle: &'a Receiver<'a, 1>,
    /// Whether it may yet be divided.
    pub(super) is_divisible: bool,
    pub(super) spend: Spend<'a>,
}

/// How far a body reaches beyond a cell, and the body.
type Promise = (f64, u32);

/// BodiesOver over a cell.
#[derive(Clone, Debug)]
pub(super) enum BodiesOver<'a> {
    /// These.
    Few(Vec<u32>),
    /// More than are listed: those of a swarm.
    Many(&'a Above<'a>),
}

impl BodiesOver<'_> {
    /// Whether there are none.
    pub(super) fn is_none(&self) -> bool {
        matches!(self, Self::Few(bodies) if bodies.is_empty())
    }
}

impl Default for BodiesOver<'_> {
    fn default() -> Self {
        Self::Few(Vec::new())
    }
}

impl Pile<'_, '_> {
    /// Those of some bodies that are in question; `None` if one covers the cell.
    pub(super) fn in_question<'s>(&self, bodies: &BodiesOver<'s>) -> Option<BodiesOver<'s>> {
        match bodies {
            BodiesOver::Few(bodies) => self.of_these(bodies).map(BodiesOver::Few),
            BodiesOver::Many(above) => self.of_swarm(above),
        }
    }

    fn of_swarm<'s>(&self, above: &'s Above<'s>) -> Option<BodiesOver<'s>> {
        if !(self.spend)(above.cost()) {
            return Some(BodiesOver::Many(above));
        }
        if let Some(bodies) = self.occluders.few_above(above, &self.receiver.points) {
            return self.of_these(&bodies).map(BodiesOver::Few);
        }
        let mut in_vain = 0;
        for group in self.occluders.promising(above, self.receiver) {
            if in_vain >= PROMISING || !(self.spend)(BODY * group.len() as u64) {
                break;
            }
            if group.iter().any(|&object| self.influence(object) == Influence::All) {
                return None;
            }
            in_vain += group.len();
        }
        Some(BodiesOver::Many(above))
    }

    fn of_these(&self, bodies: &[u32]) -> Option<Vec<u32>> {
        if bodies.len() <= FEW {
            let all: Vec<Promise> = bodies.iter().map(|&object| (0.0, object)).collect();
            return self.ask(std::iter::once(all.as_slice()), |_, _| false);
        }
        if !(self.spend)((bodies.len() / LOOKED_A_FACET) as u64) {
            return Some(bodies.to_vec());
        }
        let over = self.occluders.over_cell(bodies, &self.receiver.points);
        let hides = |&(_, object): &Promise| self.occluders.probably_blocks(object, self.middle);
        let (hiding, others): (Vec<Promise>, Vec<Promise>) = over.into_iter().partition(hides);
        let hiding = hiding.chunk_by(|a, b| a.0 == b.0);
        let mut left = self.ask(hiding, |_, in_vain| self.is_divisible && in_vain >= PATIENCE)?;
        // A cell that is not divided is not lit as soon as one of them is in question, and none of the others covers it.
        let is_undecided = !self.is_divisible && !left.is_empty();
        let others = others.chunk_by(|a, b| a.0 == b.0).rev();
        left.extend(self.ask(others, |left, in_vain| {
            if self.is_divisible { in_vain >= PATIENCE } else { is_undecided || left > 0 }
        })?);
        Some(left)
    }

    /// The same, in groups that promise the same each: a group is asked or left as a whole. Those after `is_given_up` are left, which is asked for each group, told
    /// how many are in question and how many told nothing in a row.
    fn ask<'p>(
        &self,
        groups: impl Iterator<Item = &'p [Promise]>,
        is_given_up: impl Fn(usize, usize) -> bool,
    ) -> Option<Vec<u32>> {
        let (mut left, mut in_vain) = (Vec::new(), 0);
        for group in groups {
            let first = left.len();
            // All of a group, whichever of them ends it: what is spent does not go by their order.
            let is_given_up = is_given_up(first, in_vain) || !(self.spend)(BODY * group.len() as u64);
            for &(_, object) in group {
                match if is_given_up { Influence::Unknown } else { self.influence(object) } {
                    Influence::None => {}
                    Influence::Unknown => left.push(object),
                    Influence::All => return None,
                }
            }
            let has_told = left.len() < first + group.len();
            in_vain = if has_told { 0 } else { in_vain + group.len() };
        }
        Some(left)
    }

    fn influence(&self, object: u32) -> Influence {
        if self.is_split(object) {
            return Influence::Unknown;
        }
        self.occluders.body(object, self.receiver).map_or(Influence::None, |body| body.influence(self.corners))
    }

    /// Whether floats say that a body hides some corners and others not, so that nothing can be proved.
    fn is_split(&self, object: u32) -> bool {
        let Some(glance) = self.occluders.glance(object) else { return false };
        let [first, others @ ..] = &self.receiver.points;
        let hides_first = glance.blocks(first.position);
        others.iter().any(|corner| glance.blocks(corner.position) != hides_first)
    }
}
