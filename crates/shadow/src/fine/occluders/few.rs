//! Looks at some of many: for faces under more facets than can be listed.
//!
//! Guarantee: which facets are looked at goes by them and by the face alone, whatever the order of objects, of facets and of axes.

use std::ops::ControlFlow;

use glam::DVec3;
use umbriel_bvh::BoxTree;
use umbriel_geometry::{Aabb, Point, blocking::Probe};

use super::{
    Candidates, LightFrame, Occluders, Trees,
    lots::{self, last_share},
    over,
};
use crate::{
    bodies::Body,
    exact::{Own, face_blocks},
    fine::polygon_blocker::FacetId,
};

/// Facets at most that are looked at for a face.
const SAMPLED: usize = 1024;

/// Some of the facets over a face: in each frame that sees the face those that are over it there, with their boxes.
pub(crate) struct Sample<'a>(Vec<(&'a LightFrame, Vec<(Aabb, FacetId)>)>);

/// What is known of a cell by some of the facets over it.
pub(crate) enum Cover {
    /// One facet hides all of it.
    Found,
    /// None of those looked at does; some that hide its middle.
    Parts(Candidates),
}

impl Occluders<'_> {
    /// How many of `objects`' facets and bodies have boxes over the hull of `points`, each for every frame that sees it, so no fewer than
    /// [`Occluders::candidates`] finds; counting ends at `most`.
    pub(crate) fn count(&self, objects: &[u32], points: &[Point], most: usize) -> usize {
        let (mut count, ties) = (0, self.ties_over(points));
        for (frame, view) in self.frames.iter().enumerate() {
            let Some(query) = view.bounds(points).map(over) else { continue };
            for &object in objects {
                let ended = self.for_each_meeting(object, frame, &query, |facet| {
                    count += usize::from(self.is_over_in(&ties, FacetId { object, facet }));
                    if count < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
                });
                if ended.is_break() {
                    return count;
                }
            }
        }
        count
    }

    /// Facets of `objects` over the hull of `points`: of the densest share, the first left out, that has no more than [`SAMPLED`] there.
    pub(crate) fn sample(&self, objects: &[u32], points: &[Point]) -> Sample<'_> {
        let sparsest = objects.iter().map(|&object| self.shares(object).len()).max().unwrap_or(0);
        let shares = (0..sparsest).rev().map_while(|share| self.all_over(objects, share, points));
        shares.last().unwrap_or(Sample(Vec::new()))
    }

    /// What of a share is over a hull; `None` if it is more than [`SAMPLED`].
    fn all_over(&self, objects: &[u32], share: usize, points: &[Point]) -> Option<Sample<'_>> {
        let (mut left, ties) = (SAMPLED, self.ties_over(points));
        let mut sample = Sample(Vec::new());
        for (number, frame) in self.frames.iter().enumerate() {
            let Some(query) = frame.bounds(points).map(over) else { continue };
            let mut found = Vec::new();
            for (&object, shares) in objects.iter().map(|object| (object, self.shares(*object))) {
                let Some(trees) = shares.get(share) else { continue };
                let (tree, items): &(BoxTree, Vec<u32>) = &trees[number];
                let enter = |bounds: &Aabb| bounds.meets(&query).then_some((0.0, *bounds));
                tree.for_each_entered(enter, 0.0, |item, (_, bounds), _| {
                    let id = FacetId { object, facet: items[item as usize] };
                    if self.is_over_in(&ties, id) {
                        found.push((bounds, id));
                    }
                    // Past a negative parameter nothing is entered any more.
                    if found.len() <= left { 0.0 } else { -1.0 }
                });
                if found.len() > left {
                    return None;
                }
            }
            left -= found.len();
            sample.0.push((frame, found));
        }
        Some(sample)
    }

    /// Looks among a sample for a facet that covers a cell of its face, given by the cell's corners and its middle; else for up to `most` that hide the middle.
    /// Exact.
    pub(crate) fn cover(
        &self,
        (sample, own): (&Sample, FacetId),
        (corners, middle): (&[Probe], &Probe),
        most: usize,
    ) -> Cover {
        let points: Vec<Point> = corners.iter().map(|corner| corner.bounds).collect();
        let hides = |id: FacetId, point: &Probe| {
            face_blocks(self.bodies, (id.object as usize, id.facet as usize), point, Own::Nothing, self.light)
        };
        // What lies behind a convex facet is convex.
        let covers = |id: FacetId| self.is_solid(id) && corners.iter().all(|corner| hides(id, corner));
        let mut hiding = Vec::new();
        for id in self.that_may_cover(sample, &points) {
            if id != own && !self.is_beside(id, middle.bounds.position) && hides(id, middle) {
                if covers(id) {
                    return Cover::Found;
                }
                hiding.push((self.lots(id.object)[id.facet as usize], id));
            }
        }
        hiding.sort_unstable();
        // Of those with the same lot all or none.
        let is_end = |&end: &usize| end == 0 || hiding.get(end).is_none_or(|next| next.0 != hiding[end - 1].0);
        let end = (0..=most.min(hiding.len())).rev().find(is_end).unwrap_or(0);
        Cover::Parts(Candidates { facets: hiding[..end].iter().map(|&(_, id)| id).collect(), bodies: Vec::new() })
    }

    /// Those of a sample whose rectangle holds that of a hull, in every frame that sees this.
    fn that_may_cover<'s>(&'s self, sample: &'s Sample, points: &[Point]) -> impl Iterator<Item = FacetId> + 's {
        let mut seen = sample.0.iter().filter_map(|(frame, found)| Some((*frame, frame.bounds(points)?, found)));
        let first = seen.next();
        let others = seen.map(|(frame, hull, _)| (frame, hull)).chain(self.ties_over(points));
        let others: Vec<(&LightFrame, Aabb)> = others.collect();
        let holds_in_others = move |&id: &FacetId| {
            others.iter().all(|(frame, hull)| self.view_of(id, frame).is_some_and(|bounds| holds(&bounds, hull)))
        };
        let in_first = first.into_iter().flat_map(|(_, hull, found)| {
            found.iter().filter(move |(bounds, _)| holds(bounds, &hull)).map(|&(_, id)| id)
        });
        in_first.filter(holds_in_others)
    }

    /// Whether a facet surely does not hide a point, by floats (NUMERICS.md, "Crowds"): tells most of them in a few nanoseconds.
    fn is_beside(&self, id: FacetId, point: DVec3) -> bool {
        let Body::Flat(facets) = self.bodies.get(id.object as usize) else { return false };
        let is_sun = self.light.is_sun();
        let way = if is_sun { self.light.xyz() } else { self.light.xyz() - point };
        let corners = facets.facet(id.facet as usize).corners();
        let seen = |corner: &u32| facets.positions()[*corner as usize] - point;
        let sum = |v: DVec3| v.abs().element_sum();
        let mut from = corners.last().map_or(DVec3::ZERO, seen);
        let (mut is_left, mut is_right) = (false, false);
        for to in corners.iter().map(seen) {
            let turn = from.cross(to).dot(way);
            let reach = sum(from) + sum(to) + if is_sun { 0.0 } else { sum(way) };
            let product = reach * if is_sun { sum(way) } else { reach };
            let slack = 64.0 * f64::EPSILON * (sum(point) + reach) * product;
            (is_left, is_right) = (is_left || turn > slack, is_right || turn < -slack);
            from = to;
        }
        is_left && is_right
    }

    fn is_solid(&self, id: FacetId) -> bool {
        matches!(self.bodies.get(id.object as usize), Body::Flat(facets) if facets.holes(id.facet as usize).is_none())
    }

    /// The shares of an object's facets after the first, down to the last that is not empty: for each frame a tree and the facets that its items stand for.
    fn shares(&self, object: u32) -> &[Trees] {
        self.seen(object).shares.get_or_init(|| {
            let Body::Flat(facets) = self.bodies.get(object as usize) else { return Vec::new() };
            let lots = self.lots(object);
            let last = lots.iter().map(|&lot| last_share(lot)).max().unwrap_or(0);
            (1..=last).map_while(|share| self.trees_of(facets, |facet| last_share(lots[facet]) >= share)).collect()
        })
    }

    /// The lots of an object's facets; none of an analytic body.
    pub(crate) fn lots(&self, object: u32) -> &[u64] {
        self.seen(object).lots.get_or_init(|| match self.bodies.get(object as usize) {
            Body::Flat(facets) => lots::lots(&self.bodies.scene.objects[object as usize], facets),
            Body::Analytic(_) => Vec::new(),
        })
    }
}

/// Whether a box is over a hull and hides all of its rectangle, as far as boxes tell.
fn holds(bounds: &Aabb, hull: &Aabb) -> bool {
    let across = |k: usize| bounds.min[k] <= hull.min[k] && bounds.max[k] >= hull.max[k];
    across(0) && across(1) && bounds.min.z <= hull.max.z
}
