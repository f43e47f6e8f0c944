//! The points of one row that a polygon may hold: each is put to the polygon's edges, unless all lie inside, and to its depth, eight at a time.
//!
//! No branch depends on a point, so a block becomes vector code at every level; the same operations in the same order give the same answers at all of them.
//! Cost: a sum of products for the depth and for each edge, and 36 bytes of memory a point.

use std::ops::Range;

use umbriel_geometry::simd::{Kernel, Simd, dispatch};

use super::{screen::Cone, sheets::SheetOwner};

/// Points of a block.
const BLOCK: usize = 8;

/// Points by their numbers, column by column.
#[derive(Debug, Default)]
pub(super) struct Columns {
    /// x/z and y/z as the eye sees them.
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    /// 1/z.
    pub(super) nearness: Vec<f64>,
    /// Object and face.
    pub(super) owner: Vec<u64>,
}

impl Columns {
    pub(super) fn owner_of(object: u32, face: u32) -> u64 {
        u64::from(object) << 32 | u64::from(face)
    }

    pub(super) fn of(&self, range: Range<usize>) -> Points<'_> {
        Points {
            x: &self.x[range.clone()],
            y: &self.y[range.clone()],
            nearness: &self.nearness[range.clone()],
            owner: &self.owner[range],
        }
    }
}

/// Some of the points.
pub(super) struct Points<'a> {
    x: &'a [f64],
    y: &'a [f64],
    nearness: &'a [f64],
    owner: &'a [u64],
}

/// Points that a polygon may hold, and their counts.
pub(super) struct Run<'a> {
    pub(super) cone: &'a Cone,
    pub(super) points: Points<'a>,
    pub(super) counts: &'a mut [i32],
    /// Whether the polygon is known to hold all of them.
    pub(super) is_inside: bool,
}

impl Run<'_> {
    /// Adds the polygon to the counts of the points that it lies beyond.
    pub(super) fn draw(self) {
        if self.counts.len() < BLOCK { self.fill() } else { dispatch(self) }
    }

    #[inline(always)]
    fn fill(self) {
        let leaves = self.cone.leaves;
        match self.cone.owner {
            SheetOwner::Nobody => self.fill_by(|beyond, _, _| beyond),
            // Seen from the light's side, the own face lies beyond.
            SheetOwner::Face { object, face } => {
                let (own, of_own) = (Columns::owner_of(object, face), leaves < 0);
                self.fill_by(|beyond, held, owner| match (owner == own, of_own) {
                    (false, _) => beyond,
                    (true, true) => held,
                    (true, false) => 0,
                });
            }
            SheetOwner::Body { object } => {
                let own = u64::from(object);
                self.fill_by(|beyond, _, owner| if owner >> 32 == own { 0 } else { beyond });
            }
        }
    }

    #[inline(always)]
    fn fill_by(self, decide: impl Fn(i32, i32, u64) -> i32) {
        if self.is_inside { self.fill_inside(decide) } else { self.fill_within(decide) }
    }

    /// As [`Run::fill_within`] without edges, point by point: blocks of so little would be gathered, not loaded.
    #[inline(always)]
    fn fill_inside(self, decide: impl Fn(i32, i32, u64) -> i32) {
        let Run { cone, points: Points { x, y, nearness, owner }, counts, .. } = self;
        for ((((x, y), nearness), &owner), count) in x.iter().zip(y).zip(nearness).zip(owner).zip(counts) {
            let own = cone.nearness.x * x + cone.nearness.y * y + cone.nearness.z;
            let beyond = if own < *nearness { cone.leaves } else { 0 };
            *count += decide(beyond, cone.leaves, owner);
        }
    }

    /// `decide` has the last word on what is added: by what it would be as the polygon lies beyond the point or not, by what it would be if it did, and by
    /// the point's owner.
    #[inline(always)]
    fn fill_within(self, decide: impl Fn(i32, i32, u64) -> i32) {
        let Run { cone, points, counts, .. } = self;
        let (x, x_rest) = points.x.as_chunks::<BLOCK>();
        let (y, y_rest) = points.y.as_chunks::<BLOCK>();
        let (nearness, nearness_rest) = points.nearness.as_chunks::<BLOCK>();
        let (owner, owner_rest) = points.owner.as_chunks::<BLOCK>();
        let (counts, counts_rest) = counts.as_chunks_mut::<BLOCK>();
        for ((((x, y), nearness), owner), counts) in x.iter().zip(y).zip(nearness).zip(owner).zip(counts) {
            fill_block(cone, [x, y, nearness], owner, counts, &decide);
        }
        for (k, count) in counts_rest.iter_mut().enumerate() {
            let columns = [&[x_rest[k]], &[y_rest[k]], &[nearness_rest[k]]];
            fill_block(cone, columns, &[owner_rest[k]], std::array::from_mut(count), &decide);
        }
    }
}

/// A block of points: each test is made for all of them before the next one, without a branch.
#[inline(always)]
fn fill_block<const N: usize>(
    cone: &Cone,
    [x, y, nearness]: [&[f64; N]; 3],
    owner: &[u64; N],
    counts: &mut [i32; N],
    decide: impl Fn(i32, i32, u64) -> i32,
) {
    let mut held = [cone.leaves; N];
    for (edge, least) in cone.edges.iter().zip(cone.least) {
        for k in 0..N {
            let value = edge.x * x[k] + edge.y * y[k] + edge.z;
            held[k] = if value >= least { held[k] } else { 0 };
        }
    }
    for k in 0..N {
        let own = cone.nearness.x * x[k] + cone.nearness.y * y[k] + cone.nearness.z;
        let beyond = if own < nearness[k] { held[k] } else { 0 };
        counts[k] += decide(beyond, held[k], owner[k]);
    }
}

impl Kernel for Run<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.fill();
    }
}
