//! Looks at some of many: for faces under more facets than can be listed.
//!
//! Guarantee: which facets are looked at goes by them and by the face alone, whatever the order of objects, of facets and of axes. Memory: of an object over such a
//! face trees of every second, fourth, eighth facet and so on, as much again as its own tree; of an instance for each group of receivers.

use std::ops::ControlFlow;

use glam::DVec3;
use umbriel_bvh::BoxTree;
use umbriel_geometry::{Aabb, Point, blocking::Probe};

use super::{
    Among, LightFrame, Occluders, Trees, over,
    tickets::{self, halvings},
};
use crate::{
    bodies::Body,
    exact::{Own, face_blocks},
    fine::polygon_blocker::FacetId,
};

/// Some of the facets over a face: in each frame that sees the face those that are over it there, with their boxes.
pub(crate) struct Picked<'a>(Vec<(&'a LightFrame, Vec<(Aabb, FacetId)>)>);

/// What the items of a tree stand for.
enum Items<'a> {
    /// Facets of an object.
    Of(u32, &'a [u32]),
    /// Facets of all objects.
    All(&'a [FacetId]),
}

impl Items<'_> {
    fn facet(&self, item: u32) -> FacetId {
        match self {
            Self::Of(object, facets) => FacetId { object: *object, facet: facets[item as usize] },
            Self::All(facets) => facets[item as usize],
        }
    }
}

impl Occluders<'_> {
    /// How many of these facets and bodies have boxes over the hull of `points`, each for every frame that sees it, so no fewer than
    /// [`Occluders::candidates`] finds; counting ends at `most`.
    pub(crate) fn count(&self, among: Among, points: &[Point], most: usize) -> usize {
        let (mut count, ties) = (0, self.ties_over(points));
        for (frame, view) in self.frames.iter().enumerate() {
            let Some(query) = view.bounds(points).map(over) else { continue };
            let ended = self.for_each_among(among, frame, &query, |id| {
                count += usize::from(self.is_over_in(&ties, id));
                if count < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            });
            if ended.is_break() {
                return count;
            }
        }
        count
    }

    /// Those of these facets over the hull of `points`: halved as often as leaves no more than `limit`, once at least.
    pub(crate) fn pick(&self, among: Among, points: &[Point], limit: usize) -> Picked<'_> {
        let objects = match among {
            Among::Objects(objects) => self.seen_over(objects, points),
            Among::Throng(_) => Vec::new(),
        };
        let (among, most) = match among {
            Among::Objects(_) => {
                let most = objects.iter().map(|&object| self.thinned(object).len()).max().unwrap_or(0);
                (Among::Objects(&objects), most)
            }
            Among::Throng(throng) => (among, throng.halvings()),
        };
        let picks = (1..=most).rev().map_while(|times| self.all_over((among, times), points, limit));
        picks.last().unwrap_or(Picked(Vec::new()))
    }

    /// Those objects whose boxes are over the hull of `points`.
    fn seen_over(&self, objects: &[u32], points: &[Point]) -> Vec<u32> {
        let over = |object: &u32| {
            let views = self.frames.iter().enumerate();
            let mut views = views.filter_map(|(number, view)| Some((number, view.bounds(points).map(over)?)));
            views.any(|(number, query)| self.view_of_body(*object, number).is_some_and(|body| body.meets(&query)))
        };
        objects.iter().copied().filter(over).collect()
    }

    /// What is over a hull of the facets halved so often; `None` if it is more than `limit`.
    fn all_over(&self, (among, times): (Among, usize), points: &[Point], limit: usize) -> Option<Picked<'_>> {
        let (mut left, ties) = (limit, self.ties_over(points));
        let mut picked = Picked(Vec::new());
        for (number, frame) in self.frames.iter().enumerate() {
            let Some(query) = frame.bounds(points).map(over) else { continue };
            let mut found = Vec::new();
            for (tree, items) in self.halved(among, times, number) {
                let enter = |bounds: &Aabb| bounds.meets(&query).then_some((0.0, *bounds));
                tree.for_each_entered(enter, 0.0, |item, (_, bounds), _| {
                    let id = items.facet(item);
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
            picked.0.push((frame, found));
        }
        Some(picked)
    }

    /// The trees of these facets halved so often, once at least, in a frame.
    fn halved<'s>(&'s self, among: Among<'s>, times: usize, frame: usize) -> Vec<(&'s BoxTree, Items<'s>)> {
        let of_object = |&object: &u32| {
            let (tree, items) = &self.thinned(object).get(times - 1)?[frame];
            Some((tree, Items::Of(object, items)))
        };
        match among {
            Among::Objects(objects) => objects.iter().filter_map(of_object).collect(),
            Among::Throng(throng) => {
                let (tree, items) = throng.halved(times, frame);
                vec![(tree, Items::All(items))]
            }
        }
    }

    /// Whether one of the facets picked for a face covers a cell of it, given by the cell's corners. Exact, but for those whose rectangle does not hold that of the cell: they
    /// are passed over.
    pub(crate) fn is_covered(&self, (picked, own): (&Picked, FacetId), corners: &[Probe]) -> bool {
        // Most are beside a corner, which takes a few nanoseconds to tell. What lies behind a convex facet is convex.
        let covers = |id: FacetId| {
            self.is_solid(id)
                && !corners.iter().any(|corner| self.is_beside(id, &corner.bounds))
                && corners.iter().all(|corner| self.hides(id, corner))
        };
        self.that_may_cover(picked, &bounds_of(corners)).any(|id| id != own && covers(id))
    }

    /// Those of the same facets that hide the middle of a cell, with their tickets.
    pub(crate) fn hiding(
        &self,
        (picked, own): (&Picked, FacetId),
        (corners, middle): (&[Probe], &Probe),
    ) -> Vec<(u64, FacetId)> {
        let may_cover = self.that_may_cover(picked, &bounds_of(corners)).filter(|&id| id != own);
        let hiding = may_cover.filter(|&id| !self.is_beside(id, &middle.bounds) && self.hides(id, middle));
        hiding.map(|id| (self.tickets(id.object)[id.facet as usize], id)).collect()
    }

    /// Whether a facet hides a point. Exact.
    fn hides(&self, id: FacetId, point: &Probe) -> bool {
        face_blocks(self.bodies, (id.object as usize, id.facet as usize), point, Own::Nothing, self.light)
    }

    /// Those picked whose rectangle holds that of a hull, in every frame that sees this.
    fn that_may_cover<'s>(&'s self, picked: &'s Picked, points: &[Point]) -> impl Iterator<Item = FacetId> + 's {
        let mut seen = picked.0.iter().filter_map(|(frame, found)| Some((*frame, frame.bounds(points)?, found)));
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
    fn is_beside(&self, id: FacetId, point: &Point) -> bool {
        let Body::Flat(facets) = self.bodies.get(id.object as usize) else { return false };
        let (is_sun, x) = (self.light.is_sun(), point.position);
        let way = if is_sun { self.light.xyz() } else { self.light.xyz() - x };
        let corners = facets.facet(id.facet as usize).corners();
        let seen = |corner: &u32| facets.positions()[*corner as usize] - x;
        let sum = |v: DVec3| v.abs().element_sum();
        let doubt = 2.0 * sum(point.slack) + 2.0 * sum(point.rest);
        let mut from = corners.last().map_or(DVec3::ZERO, seen);
        let (mut is_left, mut is_right) = (false, false);
        for to in corners.iter().map(seen) {
            let turn = from.cross(to).dot(way);
            let reach = sum(from) + sum(to) + if is_sun { 0.0 } else { sum(way) };
            let product = reach * if is_sun { sum(way) } else { reach };
            let slack = (64.0 * f64::EPSILON * (sum(x) + reach) + doubt) * product;
            (is_left, is_right) = (is_left || turn > slack, is_right || turn < -slack);
            from = to;
        }
        is_left && is_right
    }

    fn is_solid(&self, id: FacetId) -> bool {
        matches!(self.bodies.get(id.object as usize), Body::Flat(facets) if facets.holes(id.facet as usize).is_none())
    }

    /// Trees of every second facet of an object, of every fourth and so on, down to the last ones that hold something.
    fn thinned(&self, object: u32) -> &[Trees] {
        self.seen(object).thinned.get_or_init(|| {
            let Body::Flat(facets) = self.bodies.get(object as usize) else { return Vec::new() };
            let tickets = self.tickets(object);
            let most = tickets.iter().map(|&ticket| halvings(ticket)).max().unwrap_or(0);
            (1..=most).map_while(|times| self.trees_of(facets, |facet| halvings(tickets[facet]) >= times)).collect()
        })
    }

    /// The tickets of an object's facets; none of an analytic body.
    pub(crate) fn tickets(&self, object: u32) -> &[u64] {
        self.seen(object).tickets.get_or_init(|| match self.bodies.get(object as usize) {
            Body::Flat(facets) => tickets::tickets(&self.bodies.scene.objects[object as usize], facets),
            Body::Analytic(_) => Vec::new(),
        })
    }
}

/// Where some points surely are.
pub(crate) fn bounds_of(probes: &[Probe]) -> Vec<Point<'static>> {
    probes.iter().map(|probe| probe.bounds).collect()
}

/// Whether a box is over a hull and hides all of its rectangle, as far as boxes tell.
fn holds(bounds: &Aabb, hull: &Aabb) -> bool {
    let across = |k: usize| bounds.min[k] <= hull.min[k] && bounds.max[k] >= hull.max[k];
    across(0) && across(1) && bounds.min.z <= hull.max.z
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use umbriel_geometry::{LightSource, Mesh, Placement};
    use umbriel_scene::{Object, Scene, Shape, Sides};

    use super::*;
    use crate::bodies::Bodies;

    /// Triangles round the origin, corners at places of an irrational grid.
    fn strewn(count: u32) -> Scene {
        let step = [0.754_877_666, 0.569_840_291, 0.438_579_021];
        let at = |k: u32| step.map(|step: f64| (step * f64::from(k)).fract() * 4.0 - 2.0);
        let mesh =
            Mesh::new((0..3 * count).map(at).collect(), (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect());
        let shape = Shape::Mesh(Arc::new(mesh.expect("a mesh")));
        let object = Object::new("strewn".to_owned(), shape, Placement::IDENTITY, Sides::Two).expect("an object");
        Scene { objects: vec![object], ..Scene::default() }
    }

    /// Points behind inner points, edges and corners of triangles, an ulp or so to each side.
    #[test]
    fn what_hides_a_point_is_never_beside_it() {
        let scene = strewn(200);
        let bodies = Bodies::new(&scene);
        let Body::Flat(facets) = bodies.get(0) else { panic!("a mesh is flat") };
        let (mut hidden, mut beside, mut asked) = (0, 0, 0);
        for light in [LightSource::sun([0.3, -1.0, 0.2]), LightSource::point([0.5, 40.0, 0.25])] {
            let light = light.expect("a light");
            let occluders = Occluders::new(&bodies, &light);
            for facet in 0..200 {
                let [a, b, c] = [0, 1, 2].map(|k| facets.positions()[3 * facet + k]);
                for place in [0.25 * (a + b) + 0.5 * c, 0.5 * (a + b), 0.75 * a + 0.25 * c, b] {
                    let way = if light.is_sun() { light.xyz() } else { light.xyz() - place };
                    let behind = place - 1.25 * way;
                    for k in 0..27 {
                        let nudged = DVec3::from_array([1, 3, 9].map(|n| f64::from(k / n % 3 - 1)));
                        let x: Probe = Probe::at(behind + nudged * f64::EPSILON);
                        let id = FacetId { object: 0, facet: facet as u32 };
                        let hides = face_blocks(&bodies, (0, facet), &x, Own::Nothing, &light);
                        let is_beside = occluders.is_beside(id, &x.bounds);
                        assert!(!(hides && is_beside), "triangle {facet} at {place} under {light:?}");
                        let far = Point::exact(behind + 0.1 * (behind - place).cross(DVec3::X));
                        (hidden, asked) = (hidden + usize::from(hides), asked + 1);
                        beside += usize::from(occluders.is_beside(id, &far));
                    }
                }
            }
        }
        assert!(4 * hidden > asked && 4 * beside > asked, "{hidden} hidden, {beside} beside, of {asked}");
    }
}
