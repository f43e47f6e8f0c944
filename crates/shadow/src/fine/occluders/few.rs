//! Looks that end early: for faces under more facets than can be listed.

use std::ops::ControlFlow;

use glam::DVec3;
use umbriel_bvh::BoxTree;
use umbriel_geometry::{Aabb, Facets, LightSource, Point};

use super::{Candidates, ObjectIndex, Occluders, corners_of};
use crate::{
    bodies::Body,
    fine::{instance_tree::LocalFrame, polygon_blocker::FacetId},
};

/// Facets looked at for covers.
const LOOKS: usize = 256;

impl Occluders<'_> {
    /// No fewer than [`Occluders::candidates`] would find among `objects` over the hull of `points`; counting ends at `most`.
    pub(crate) fn count(&self, objects: &[u32], points: &[Point], most: usize) -> usize {
        let mut count = 0;
        let mut next = || {
            count += 1;
            if count < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        for (frame, view) in self.frames.iter().enumerate() {
            let Some(mut query) = view.bounds(points) else { continue };
            query.min.z = f64::NEG_INFINITY;
            for &object in objects {
                let ended = match self.index(object) {
                    ObjectIndex::Own(trees) => trees[frame].0.for_each_where(|b| b.meets(&query), |_| next()),
                    ObjectIndex::Instance(_, tree, frames) => frames[frame].for_each_near(tree, &query, |_| next()),
                    ObjectIndex::Unbuilt => ControlFlow::Continue(()),
                };
                if ended.is_break() {
                    return count;
                }
            }
        }
        count
    }

    /// Up to `most` facets of `objects` that are likely to cover the hull of `points`, the likeliest first: by floats without bounds, among the first
    /// [`LOOKS`] whose rectangles in light space hold that of the hull (of instances: that seem to hold its middle). What covers the hull is of this kind.
    pub(crate) fn likely_covers(&self, objects: &[u32], points: &[Point], most: usize) -> Candidates {
        let mut views = self.frames.iter().enumerate();
        // What covers the hull does so in every frame that sees it.
        let Some((frame, hull)) = views.find_map(|(frame, view)| Some((frame, view.bounds(points)?))) else {
            return Candidates::default();
        };
        let middle = points.iter().map(|point| point.position).sum::<DVec3>() / points.len() as f64;
        let mut likely =
            Likely { light: self.light, hull: points, middle, most, looks: 0, covers: Vec::new(), others: Vec::new() };
        for &object in objects {
            // Nothing is placed before something is found.
            let mut look = |facet| match self.bodies.get(object as usize) {
                Body::Flat(facets) => likely.look(facets, FacetId { object, facet }),
                _ => ControlFlow::Continue(()),
            };
            let ended = match self.index(object) {
                ObjectIndex::Own(trees) => holding(&trees[frame], &hull, &mut look),
                ObjectIndex::Instance(_, tree, frames) => near(tree, &frames[frame], hull, &mut look),
                ObjectIndex::Unbuilt => ControlFlow::Continue(()),
            };
            if ended.is_break() {
                break;
            }
        }
        let Likely { covers: mut facets, mut others, .. } = likely;
        facets.append(&mut others);
        facets.truncate(most);
        Candidates { facets, bodies: Vec::new() }
    }
}

/// Facets that seem to cover a hull, and others that seem to hide its middle.
struct Likely<'a> {
    light: &'a LightSource,
    hull: &'a [Point<'a>],
    middle: DVec3,
    most: usize,
    looks: usize,
    covers: Vec<FacetId>,
    others: Vec<FacetId>,
}

impl Likely<'_> {
    /// Goes on until a second cover is found: rounding may have it that the first is none.
    fn look(&mut self, facets: &Facets, id: FacetId) -> ControlFlow<()> {
        self.looks += 1;
        let (points, count) = corners_of(facets, id.facet as usize);
        let corners = &points.map(|point| point.position)[..count];
        if seems_to_hide(corners, self.middle, self.light) {
            let covers = self.hull.iter().all(|point| seems_to_hide(corners, point.position, self.light));
            let list = if covers { &mut self.covers } else { &mut self.others };
            if list.len() < self.most {
                list.push(id);
            }
        }
        if self.looks < LOOKS && self.covers.len() < 2 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}

/// Whether a convex facet stands between a point and the light, rounded.
fn seems_to_hide(corners: &[DVec3], point: DVec3, light: &LightSource) -> bool {
    let way = if light.is_sun() { light.xyz() } else { light.xyz() - point };
    let [a, b, c] = [0, 1, corners.len() - 1].map(|k| corners[k] - point);
    let normal = (b - a).cross(c - a);
    let (distance, approach) = (normal.dot(a), normal.dot(way));
    let is_between = distance * approach > 0.0 && (light.is_sun() || distance.abs() < approach.abs());
    is_between
        && corners.iter().enumerate().all(|(k, from)| {
            let to = corners[(k + 1) % corners.len()];
            (from - point).cross(to - point).dot(way) * approach >= 0.0
        })
}

/// Visits the facets whose rectangles hold that of a hull and that do not lie behind it.
fn holding(
    (tree, items): &(BoxTree, Vec<u32>),
    hull: &Aabb,
    visit: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let holds = |outer: &Aabb| {
        let across = |k: usize| outer.min[k] <= hull.min[k] && outer.max[k] >= hull.max[k];
        across(0) && across(1) && outer.min.z <= hull.max.z
    };
    tree.for_each_where(holds, |item| visit(items[item as usize]))
}

/// Visits the facets of an instance that may meet the ray through a hull's middle before the hull ends.
fn near(
    tree: &BoxTree,
    local: &LocalFrame,
    hull: Aabb,
    visit: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let middle = hull.center();
    local.for_each_near(tree, &Aabb { min: middle.with_z(f64::NEG_INFINITY), max: middle.with_z(hull.max.z) }, visit)
}
