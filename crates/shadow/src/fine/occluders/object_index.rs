//! The trees in which facets over a receiver are found: one an object and frame, built when first asked for.
//!
//! Instances of a mesh share one tree in the mesh's own coordinates. Cost: a look at each facet and a sort for each frame.

use std::sync::Arc;

use umbriel_bvh::BoxTree;
use umbriel_geometry::{Aabb, Facets, Mesh, cut_out::Opacity};

use super::{LOOKS, Occluders, box_corners, corners_of};
use crate::{bodies::Body, fine::instance_tree::LocalFrame};

/// For each frame, a tree and the facets that its items stand for (an analytic body is item 0 of its own).
pub(super) type Trees = Vec<(BoxTree, Vec<u32>)>;

/// One object in light space.
pub(super) enum ObjectIndex {
    Own(Trees),
    /// An instance of a mesh: the tree that it shares with the others, and each frame in the coordinates of that.
    Instance(Arc<Mesh>, Arc<BoxTree>, Vec<LocalFrame>),
    /// The clock came first.
    Unbuilt,
}

impl Occluders<'_> {
    pub(super) fn index(&self, object: u32) -> &ObjectIndex {
        self.seen(object).index.get_or_init(|| {
            if let Some((mesh, tree)) = self.bodies.instance(object as usize) {
                let placement = &self.bodies.scene.objects[object as usize].placement;
                let local = |frame| LocalFrame::new(frame, placement, &tree.bounds());
                return ObjectIndex::Instance(
                    Arc::clone(mesh),
                    Arc::clone(tree),
                    self.frames.iter().map(local).collect(),
                );
            }
            match self.bodies.get(object as usize) {
                Body::Flat(facets) => self.trees_of(facets, |_| true).map_or(ObjectIndex::Unbuilt, ObjectIndex::Own),
                Body::Analytic(_) => self.index_analytic(&self.bodies.bounds(object as usize)),
            }
        })
    }

    /// Of the facets that are wanted; `None` if the clock came first.
    pub(super) fn trees_of(&self, facets: &Facets, is_wanted: impl Fn(usize) -> bool) -> Option<Trees> {
        let trees = self.frames.iter().map(|frame| {
            let (mut boxes, mut items) = (Vec::new(), Vec::new());
            for facet in 0..facets.len() {
                if facet % LOOKS == 0 && self.is_over() {
                    return None;
                }
                if !is_wanted(facet) || !blocks(facets, facet) {
                    continue;
                }
                let (points, count) = corners_of(facets, facet);
                if let Some(bounds) = frame.bounds(&points[..count]) {
                    boxes.push(bounds);
                    items.push(facet as u32);
                }
            }
            items.shrink_to_fit();
            Some((BoxTree::build_while(&boxes, &|| !self.is_over())?, items))
        });
        trees.collect()
    }

    fn index_analytic(&self, world: &Aabb) -> ObjectIndex {
        let corners = box_corners(world);
        let trees = self.frames.iter().map(|frame| {
            let boxes: Vec<Aabb> = frame.bounds(&corners).into_iter().collect();
            (BoxTree::build(&boxes), vec![0])
        });
        ObjectIndex::Own(trees.collect())
    }
}

/// Whether a facet may block and blocks more than those before it; repeats may have other holes.
pub(super) fn blocks(facets: &Facets, facet: usize) -> bool {
    facets.opacity(facet) != Opacity::Clear && (facets.has_holes() || !facets.is_repeat(facet))
}
