//! Curved bodies by the thousand: one tree over those of a whole scene, asked cell by cell.
//!
//! The problem: where each of thousands of bodies has hundreds over it, lists of what may shadow each are the square of the scene, and cells that go through them tell
//! little. The way: what is over a cell is looked up in a tree over the boxes of all bodies in light space. Up to [`MANY`] are a list, as ever. Of more, the [`LOOKED_AT`]
//! whose boxes reach farthest beyond the cell are found: one of them may be proved to cover it. Guarantee: only what may shadow a receiver by the boxes of both
//! (the coarse step's test) is looked at, so what is found goes by the receiver's own occluders, whatever else the tree holds, and not by any order. What breaks it: long bodies across the axes, whose
//! boxes tell little. Cost: some microseconds a cell; O(n log n) to build, some 200 bytes a body and 200 more for each view of the light.

use std::{borrow::Cow, ops::ControlFlow};

use rayon::prelude::*;
use umbriel_bvh::{BoxTree, Shaft, cannot_shadow};
use umbriel_geometry::{
    Aabb, LightSource, Point,
    analytic::{Glance, HULL},
};

use super::{Occluders, box_corners};
use crate::fine::Receiver;

/// So many bodies over a cell are a list still.
pub(crate) const MANY: usize = 64;

/// Bodies that are looked at for a cell under more. All that promise as much as the last of them are, unless these are more than twice as many in all: then none of the last.
const LOOKED_AT: usize = 16;

/// What looking up what is over a cell costs, in facets held against it; and so many bodies over its patch make it one more.
const LOOKED_UP: u64 = 32;
const OVER_A_FACET: usize = 32;

/// Bodies over a patch are counted up to so many: under more, telling the best of them or the first one in the way takes no longer.
const COUNTED: usize = 512;

/// The curved bodies of a scene that may shadow anything, as one light sees them.
#[derive(Debug)]
pub(crate) struct Swarm {
    members: Vec<Member>,
    /// Whether nothing else may shadow anything.
    is_all: bool,
    /// For each object whether it is a member.
    is_member: Vec<bool>,
    /// Over the members, for each frame of the light.
    trees: Vec<BoxTree>,
}

/// A body, its box in the world, and what floats say of ways past it.
#[derive(Debug)]
struct Member {
    object: u32,
    bounds: Aabb,
    glance: Option<Glance>,
}

/// Those bodies of a swarm that may shadow one receiver.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Above<'a> {
    swarm: &'a Swarm,
    receiver: Aabb,
    light: &'a LightSource,
    shaft: Shaft,
    /// The receiver, or the object that it is like.
    own: u32,
    /// How many are over the patch that is looked at, up to [`COUNTED`]; 0 before that is known.
    count: usize,
}

impl Swarm {
    /// The curved ones of these objects, unless they are so few that they are listed in any case.
    pub(crate) fn new(occluders: &Occluders, objects: impl Iterator<Item = usize>) -> Option<Self> {
        let bodies = occluders.bodies;
        let (curved, others): (Vec<usize>, Vec<usize>) = objects.partition(|&object| bodies.is_analytic(object));
        if curved.len() <= MANY {
            return None;
        }
        let mut is_member = vec![false; bodies.scene.objects.len()];
        curved.iter().for_each(|&object| is_member[object] = true);
        let member = |object: usize| {
            let glance = occluders.glance(object as u32).cloned();
            Member { object: object as u32, bounds: bodies.bounds(object), glance }
        };
        let members: Vec<Member> = curved.into_par_iter().map(member).collect();
        let trees = occluders.frames.iter().map(|frame| {
            let view = |member: &Member| frame.bounds(&box_corners(&member.bounds)).unwrap_or(Aabb::EMPTY);
            BoxTree::build(&members.iter().map(view).collect::<Vec<_>>())
        });
        let trees = trees.collect();
        Some(Self { members, is_all: others.is_empty(), is_member, trees })
    }

    /// Those of some objects that are no members.
    pub(crate) fn others<'o>(&self, objects: impl FnOnce() -> Cow<'o, [u32]>) -> Cow<'o, [u32]> {
        if self.is_all {
            return Cow::default();
        }
        let mut objects = objects().into_owned();
        objects.retain(|&object| !self.is_member[object as usize]);
        objects.into()
    }

    /// What of it may shadow an object with this box; `own` is the object, or the one that it is like.
    pub(crate) fn above<'a>(&'a self, receiver: Aabb, light: &'a LightSource, own: u32) -> Above<'a> {
        Above { swarm: self, receiver, light, shaft: Shaft::new(&receiver, light), own, count: 0 }
    }
}

impl Above<'_> {
    /// What looking up what is over a cell costs, in facets held against it.
    pub(in crate::fine) fn cost(&self) -> u64 {
        LOOKED_UP + (self.count / OVER_A_FACET) as u64
    }

    /// Whether a body may shadow the receiver, by the coarse step.
    fn holds(&self, body: &Member) -> bool {
        body.object != self.own
            && self.shaft.may_meet(&body.bounds)
            && !cannot_shadow(&body.bounds, &self.receiver, self.light)
    }
}

impl Occluders<'_> {
    /// Visits the bodies over the hull of `points`, those that several frames of a lamp see several times, until `visit` breaks.
    fn for_each_above(
        &self,
        above: &Above,
        points: &[Point],
        mut visit: impl FnMut(&Member) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let cells = self.cells_over(points);
        let (seen, ties) = cells.split_at(cells.partition_point(|(view, _)| *view < self.frames.len()));
        seen.iter().try_for_each(|(view, cell)| {
            let meets = |bounds: &Aabb| bounds.meets(cell);
            above.swarm.trees[*view].for_each_where(meets, |item| {
                let body = &above.swarm.members[item as usize];
                let is_visited = above.holds(body) && ties.iter().all(|tie| self.has_body_over(tie, body.object));
                if is_visited { visit(body) } else { ControlFlow::Continue(()) }
            })
        })
    }

    /// Whether this is true of a body over the hull of `points`.
    pub(crate) fn any_above(&self, above: &Above, points: &[Point], is_it: impl Fn(u32) -> bool) -> bool {
        let visit = |body: &Member| if is_it(body.object) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        self.for_each_above(above, points, visit).is_break()
    }

    /// The bodies over the hull of `points`, ascending, unless they are more than [`MANY`].
    pub(in crate::fine) fn few_above(&self, above: &Above, points: &[Point]) -> Option<Vec<u32>> {
        let mut found = Vec::new();
        let _ = self.for_each_above(above, points, |body| {
            if !found.contains(&body.object) {
                found.push(body.object);
            }
            if found.len() > MANY { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        found.sort_unstable();
        (found.len() <= MANY).then_some(found)
    }

    /// With how many of them are over the hull of `points`, a part of the receiver, up to [`COUNTED`]; those that several frames of a lamp see count several times.
    pub(in crate::fine) fn counted<'s>(&self, above: &Above<'s>, points: &[Point]) -> Above<'s> {
        let mut count = 0;
        let _ = self.for_each_above(above, points, |_| {
            count += 1;
            if count < COUNTED { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        Above { count, ..*above }
    }

    /// Those of the bodies that promise most to cover a hull of which floats say that they hide all of its corners, the best first, in groups that promise the same.
    pub(in crate::fine) fn promising(&self, above: &Above, hull: &Receiver<HULL>) -> Vec<Vec<u32>> {
        let hides_all = |glance: &Glance| hull.points.iter().all(|point| glance.blocks(point.position));
        let covers = |&(_, body): &(f64, &Member)| {
            // Of some floats say nothing.
            body.glance.as_ref().is_none_or(hides_all).then_some(body.object)
        };
        let best = self.best_above(above, &hull.points);
        best.chunk_by(|a, b| a.0 == b.0).map(|group| group.iter().filter_map(covers).collect()).collect()
    }

    /// A body of which floats say that it hides a point: this one, if it does; or how many are over the point where none hides it.
    pub(in crate::fine) fn probably_hides(
        &self,
        above: &Above,
        point: &Receiver<1>,
        first: Option<u32>,
    ) -> Result<u32, u64> {
        let is_over = |object: &u32| self.is_body_over(*object, &point.points);
        if let Some(first) = first.filter(|&first| self.probably_blocks(first, point)).filter(is_over) {
            return Ok(first);
        }
        let (mut found, mut count) = (None, 0);
        let _ = self.for_each_above(above, &point.points, |body| {
            count += 1;
            let hides = match &body.glance {
                Some(glance) => glance.blocks(point.points[0].position),
                None => self.probably_blocks(body.object, point),
            };
            found = hides.then_some(body.object);
            if hides { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        found.ok_or(count)
    }

    /// Whether a body is over the hull of `points` by its boxes, so that which body was asked before does not matter.
    fn is_body_over(&self, object: u32, points: &[Point]) -> bool {
        let cells = self.cells_over(points);
        let (seen, ties) = cells.split_at(cells.partition_point(|(view, _)| *view < self.frames.len()));
        let meets = |cell: &(usize, Aabb)| self.has_body_over(cell, object);
        seen.iter().any(meets) && ties.iter().all(meets)
    }

    fn has_body_over(&self, (view, cell): &(usize, Aabb), object: u32) -> bool {
        self.view_of_body(object, *view).is_some_and(|body| body.meets(cell))
    }

    /// [`LOOKED_AT`] bodies or few more that promise by their boxes most to cover the hull of `points`, with how much, negative: the best first.
    fn best_above<'s>(&self, above: &Above<'s>, points: &[Point]) -> Vec<(f64, &'s Member)> {
        let cells = self.views_of(points);
        let Some(((first, cell), others)) = cells.split_first() else { return Vec::new() };
        let enter = |bounds: &Aabb| Some((-self.promise(bounds, cell)?, ()));
        let mut best: Vec<(f64, &Member)> = Vec::new();
        above.swarm.trees[*first].for_each_entered(enter, 0.0, |item, (entry, ()), most| {
            let body = &above.swarm.members[item as usize];
            let entry = self.least_promise(body.object, others).map(|promise| entry.max(-promise));
            let Some(entry) = entry.filter(|entry| *entry <= most && above.holds(body)) else { return most };
            best.insert(best.partition_point(|(other, _)| *other <= entry), (entry, body));
            let Some(&(worst, _)) = best.get(LOOKED_AT - 1) else { return most };
            best.truncate(best.partition_point(|(entry, _)| *entry <= worst));
            worst
        });
        if let Some(&(worst, _)) = best.last().filter(|_| best.len() > 2 * LOOKED_AT) {
            best.retain(|(entry, _)| *entry < worst);
        }
        best
    }

    /// What a body promises in all of these views of a cell.
    fn least_promise(&self, object: u32, cells: &[(usize, Aabb)]) -> Option<f64> {
        let promise = |(view, cell): &(usize, Aabb)| self.promise(self.view_of_body(object, *view)?, cell);
        cells.iter().try_fold(f64::INFINITY, |least, cell| Some(promise(cell)?.min(least)))
    }

    /// How far a box in light space reaches beyond that of a cell, to its sides and to the front: in metres under a sun, in parts of the way from a lamp. `None` if it does not, so that the body
    /// covers no such cell.
    fn promise(&self, body: &Aabb, cell: &Aabb) -> Option<f64> {
        let (low, high) = (cell.min - body.min, body.max - cell.max);
        let promise = if self.light.is_sun() {
            low.min_element().min(high.x).min(high.y)
        } else {
            // Boxes end where the frame does, which says nothing of the body.
            let to_side = |reach: f64, end: f64| if end.abs() == 1.0 && reach == 0.0 { f64::INFINITY } else { reach };
            let to_sides = to_side(low.x, cell.min.x).min(to_side(low.y, cell.min.y));
            let to_others = to_side(high.x, cell.max.x).min(to_side(high.y, cell.max.y));
            to_sides.min(to_others).min(low.z / cell.max.z)
        };
        (promise >= 0.0).then_some(promise)
    }
}

#[cfg(test)]
mod tests;
