//! Where the method read literally is wrong, and by which of its rules.
//!
//! The way from the whole box down to a point is gone again, pair by pair: where it ends is what decided about the point. Cost: as many rays and tests of membership
//! a wrong point and pair as there are depths, eight times.

use std::sync::atomic::AtomicU64;

use rayon::prelude::*;
use umbriel_bvh::may_shadow;
use umbriel_geometry::LightSource;

use super::{Literal, Mark, Method, Pair, corners, part, place_of};
use crate::rivals::{Polygons, Rival, RivalPoint, RivalRefusal};

/// How many of some points the method is wrong about, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Points that were looked at.
    pub points: u64,
    /// Lit points in a box whose eight corners are in shadow: eight hits prove nothing where the occluder is concave.
    pub eight_hits: u64,
    /// Lit points in a box of the last depth that is in shadow for the most part.
    pub dark_border: u64,
    /// Dark points in a box all of whose rays pass what shadows them: eight misses.
    pub eight_misses: u64,
    /// Dark points in a box in shadow that was taken for no part of the receiver: it slips between eight corners.
    pub membership: u64,
    /// Dark points in a box of the last depth that is lit for the most part.
    pub lit_border: u64,
    /// Dark points that nothing but their own object shadows: it is never asked.
    pub own_shadow: u64,
}

/// How the way to a point ends in one pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// Marked, because of eight hits or of half of them.
    Marked { by_eight: bool },
    /// No ray met the occluder.
    Missed,
    /// No corner was part of the receiver.
    NoMember,
    /// Too few hits at the last depth.
    LitBorder,
}

impl Faults {
    /// All wrong points.
    pub fn wrong(&self) -> u64 {
        let Self { eight_hits, dark_border, eight_misses, membership, lit_border, own_shadow, .. } = self;
        eight_hits + dark_border + eight_misses + membership + lit_border + own_shadow
    }

    fn and(self, other: Self) -> Self {
        Self {
            points: self.points + other.points,
            eight_hits: self.eight_hits + other.eight_hits,
            dark_border: self.dark_border + other.dark_border,
            eight_misses: self.eight_misses + other.eight_misses,
            membership: self.membership + other.membership,
            lit_border: self.lit_border + other.lit_border,
            own_shadow: self.own_shadow + other.own_shadow,
        }
    }
}

impl Literal {
    /// What the method is wrong about; `truth` says of each point whether it is lit.
    ///
    /// # Errors
    /// As of [`Rival::answer`].
    pub fn faults(
        &self,
        polygons: &Polygons,
        light: &LightSource,
        points: &[RivalPoint],
        truth: &[bool],
    ) -> Result<Faults, RivalRefusal> {
        let stated = self.answer(polygons, light, points)?.lit;
        let method = Method::new(polygons, light);
        let fault = |(point, (&is_lit, &is_stated_lit)): (&RivalPoint, (&bool, &bool))| match (is_lit, is_stated_lit) {
            (true, false) => method.why_dark(*self, point),
            (false, true) => method.why_lit(*self, point),
            _ => Faults { points: 1, ..Faults::default() },
        };
        let answers = truth.par_iter().zip(&stated);
        Ok(points.par_iter().zip(answers).map(fault).reduce(Faults::default, Faults::and))
    }
}

impl Method<'_> {
    /// The rule that put a lit point into the dark; that it is not turned to the light by its rounded normal counts as a border.
    fn why_dark(&self, method: Literal, point: &RivalPoint) -> Faults {
        let rays = AtomicU64::new(0);
        let mut ends = self.pairs(method, point.object as usize, &rays).map(|pair| pair.end(point));
        let by_eight = ends.any(|end| end == End::Marked { by_eight: true });
        Faults { points: 1, eight_hits: by_eight.into(), dark_border: (!by_eight).into(), ..Faults::default() }
    }

    /// The rule by which a dark point stayed lit, in the first pair whose occluder shadows it.
    fn why_lit(&self, method: Literal, point: &RivalPoint) -> Faults {
        let rays = AtomicU64::new(0);
        let mut pairs = self.pairs(method, point.object as usize, &rays);
        let shadows = |pair: &Pair| pair.occluder.bvh.towards(*self.light).any_hit(point.position);
        let end = pairs.find(shadows).map(|pair| pair.end(point));
        let is = |one: Option<End>| u64::from(end == one);
        Faults {
            points: 1,
            own_shadow: is(None),
            eight_misses: is(Some(End::Missed)),
            membership: is(Some(End::NoMember)),
            // A box that was marked does not hold the point when this is rounded.
            lit_border: u64::from(matches!(end, Some(End::LitBorder | End::Marked { .. }))),
            ..Faults::default()
        }
    }
}

impl Pair<'_> {
    /// What decides about a point.
    fn end(&self, point: &RivalPoint) -> End {
        let mut towards = self.occluder.bvh.towards(*self.light);
        for depth in 0.. {
            let place = place_of(&self.receiver.bounds, depth, point.position);
            let cell = part(&self.receiver.bounds, place);
            let hits = corners(&cell).into_iter().filter(|&corner| towards.any_hit(corner)).count();
            let is_last = depth == self.method.boundary;
            let may_be_met = || depth < self.method.interior && may_shadow(&self.occluder.bounds, &cell, self.light);
            match hits {
                8 => return self.end_of_mark(depth, point),
                1.. if is_last && 2 * hits < 8 => return End::LitBorder,
                1.. if is_last => {
                    return if self.members(place) > 0 { End::Marked { by_eight: false } } else { End::NoMember };
                }
                0 if !may_be_met() => return End::Missed,
                _ => {}
            }
        }
        End::Missed
    }

    /// The same within a box in shadow.
    fn end_of_mark(&self, first: u8, point: &RivalPoint) -> End {
        for depth in first.. {
            match self.members(place_of(&self.receiver.bounds, depth, point.position)) {
                0 => return End::NoMember,
                8 => break,
                _ if depth >= self.method.interior => break,
                _ => {}
            }
        }
        End::Marked { by_eight: true }
    }

    /// How many corners of a box lie in or on the receiver.
    fn members(&self, place: Mark) -> usize {
        let cell = part(&self.receiver.bounds, place);
        corners(&cell).into_iter().filter(|&corner| self.receiver.holds(corner)).count()
    }
}
