//! All facets of a scene in one tree, for scenes in which so much lies over everything that objects are not asked one by one.
//!
//! Beside the tree of all facets there are trees of every second facet, of every fourth and so on, by their [`tickets`], from which some of those over a face are
//! picked. Memory: some three hundred bytes a facet of the scene, those of instances included. O(n log n).

use std::ops::ControlFlow;

use umbriel_bvh::BoxTree;
use umbriel_geometry::{Aabb, Facets, Point};

use super::{Occluders, box_corners, corners_of, object_index::blocks};
use crate::{
    bodies::Body,
    fine::{crowd::Members, polygon_blocker::FacetId},
    receivers::area_of,
    sums::ExactSum,
    tickets,
};

/// A tree over facets of all objects.
type Tree = (BoxTree, Vec<FacetId>);

/// The facets of all objects of a scene that may block anything, as one light sees them.
pub(crate) struct Throng {
    /// At place n for each frame those halved n times. Analytic bodies are among all, each as its first facet, and in no other tree.
    halved: Vec<Vec<Tree>>,
    /// The area of all flat facets, m².
    area: f64,
}

/// A facet on its way into the trees of a frame.
struct Seen {
    bounds: Aabb,
    id: FacetId,
    halvings: u8,
}

impl Throng {
    /// Of these objects. Instances are placed one by one, and forgotten.
    pub(crate) fn new(occluders: &Occluders, objects: impl Iterator<Item = usize>) -> Self {
        let mut seen: Vec<Vec<Seen>> = occluders.frames.iter().map(|_| Vec::new()).collect();
        let mut area = ExactSum::default();
        for object in objects {
            occluders.bodies.look_at(object, |body| {
                see(occluders, object, body, &mut seen);
                if let Body::Flat(facets) = body {
                    area.add(area_of(facets));
                }
            });
        }
        let most = seen.iter().flatten().map(|facet| facet.halvings).max().unwrap_or(0);
        let halved = (0..=most).map(|times| seen.iter().map(|seen| tree_of(seen, times)).collect()).collect();
        Self { halved, area: area.nearest() }
    }

    /// All of it as one crowd: as many faces as there are facets that the light sees, which is more where it sees some in several frames.
    pub(crate) fn members(&self) -> Members {
        Members::of_scene(self.halved[0].iter().map(|(_, items)| items.len()).sum(), self.area)
    }

    /// How often the facets can be halved.
    pub(super) fn halvings(&self) -> usize {
        self.halved.len() - 1
    }

    /// The facets halved so often as a frame sees them.
    pub(super) fn halved(&self, times: usize, frame: usize) -> (&BoxTree, &[FacetId]) {
        let (tree, items) = &self.halved[times][frame];
        (tree, items)
    }

    /// Visits the facets whose boxes in a frame meet `query` (of an analytic body the first), until `visit` breaks.
    pub(super) fn for_each_meeting(
        &self,
        frame: usize,
        query: &Aabb,
        mut visit: impl FnMut(FacetId) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (tree, items) = self.halved(0, frame);
        tree.for_each_where(|bounds| bounds.meets(query), |item| visit(items[item as usize]))
    }
}

/// Adds the facets of an object to what each frame sees.
fn see(occluders: &Occluders, object: usize, body: &Body, seen: &mut [Vec<Seen>]) {
    let mut add = |facet: usize, points: &[Point], halvings: u8| {
        for (frame, seen) in occluders.frames.iter().zip(&mut *seen) {
            let id = FacetId { object: object as u32, facet: facet as u32 };
            seen.extend(frame.bounds(points).map(|bounds| Seen { bounds, id, halvings }));
        }
    };
    match body {
        Body::Flat(facets) => {
            let tickets = tickets_of(occluders, object, facets);
            for facet in (0..facets.len()).filter(|&facet| blocks(facets, facet)) {
                let (points, count) = corners_of(facets, facet);
                add(facet, &points[..count], tickets::halvings(tickets[facet]));
            }
        }
        Body::Analytic(_) => add(0, &box_corners(&occluders.bodies.bounds(object)), 0),
    }
}

fn tickets_of(occluders: &Occluders, object: usize, facets: &Facets) -> Vec<u64> {
    tickets::tickets(&occluders.bodies.scene.objects[object], facets)
}

fn tree_of(seen: &[Seen], times: u8) -> Tree {
    let left = || seen.iter().filter(|facet| facet.halvings >= times);
    let boxes: Vec<Aabb> = left().map(|facet| facet.bounds).collect();
    (BoxTree::build(&boxes), left().map(|facet| facet.id).collect())
}
