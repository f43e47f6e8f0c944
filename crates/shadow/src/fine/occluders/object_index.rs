//! The trees in which facets over a receiver are found: one an object and frame, built when first asked for.
//!
//! Instances of a mesh share one tree in the mesh's own coordinates; those that are receivers of a group have trees of their own until it is done. Cost: a look
//! at each facet and a sort for each frame.

use std::{ops::Range, sync::Arc};

use rayon::prelude::*;
use umbriel_bvh::BoxTree;
use umbriel_geometry::{Aabb, Facets, Mesh, cut_out::Opacity};

use super::{LOOKS, LightFrame, Occluders, box_corners, corners_of, facet_tree::FacetTree};
use crate::{bodies::Body, fine::instance_tree::LocalFrame};

/// For each frame, a tree and the facets that its items stand for.
pub(super) type Trees = Vec<(BoxTree, Vec<u32>)>;

/// One object in light space.
pub(super) enum ObjectIndex {
    /// A tree for each frame; an analytic body is facet 0 of its own.
    Own(Vec<FacetTree>),
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
                Body::Flat(facets) => self.facet_trees(facets).map_or(ObjectIndex::Unbuilt, ObjectIndex::Own),
                Body::Analytic(_) => self.index_analytic(&self.bodies.bounds(object as usize)),
            }
        })
    }

    /// Builds trees of their own for these objects, on all threads, unless they have some: to be called before receivers look for them side by side, as one that
    /// waits for another's tree cannot help with it. Each object may be named once.
    pub(crate) fn prepare(&self, objects: Vec<u32>) {
        objects.into_par_iter().for_each(|object| {
            let Body::Flat(facets) = self.bodies.get(object as usize) else { return };
            let tree = |frame| self.tree_of(self.boxes_side_by_side(frame, facets)?);
            let trees = || self.frames.par_iter().map(tree).collect::<Option<_>>();
            self.seen(object).index.get_or_init(|| trees().map_or(ObjectIndex::Unbuilt, ObjectIndex::Own));
        });
    }

    /// Of all facets that may block; `None` if the clock came first.
    fn facet_trees(&self, facets: &Facets) -> Option<Vec<FacetTree>> {
        let tree = |frame| self.tree_of(self.boxes(frame, facets, 0..facets.len(), |_| true)?);
        self.frames.iter().map(tree).collect()
    }

    fn tree_of(&self, boxes: Vec<(u32, Aabb)>) -> Option<FacetTree> {
        FacetTree::build_while(&boxes, &|| !self.is_over())
    }

    /// Of the facets that are wanted; `None` if the clock came first.
    pub(super) fn trees_of(&self, facets: &Facets, is_wanted: impl Fn(usize) -> bool) -> Option<Trees> {
        let trees = self.frames.iter().map(|frame| {
            let boxes = self.boxes(frame, facets, 0..facets.len(), &is_wanted)?;
            let (items, boxes): (Vec<u32>, Vec<Aabb>) = boxes.into_iter().unzip();
            Some((BoxTree::build_while(&boxes, &|| !self.is_over())?, items))
        });
        trees.collect()
    }

    /// As [`Occluders::boxes`] of all facets, on all threads.
    fn boxes_side_by_side(&self, frame: &LightFrame, facets: &Facets) -> Option<Vec<(u32, Aabb)>> {
        let runs = (0..facets.len()).into_par_iter().step_by(LOOKS).map(|first| {
            let run = first..facets.len().min(first + LOOKS);
            self.boxes(frame, facets, run, |_| true)
        });
        Some(runs.collect::<Option<Vec<_>>>()?.concat())
    }

    /// Those of the wanted facets in a range that a frame sees and that may block, with their boxes; `None` if the clock came first.
    fn boxes(
        &self,
        frame: &LightFrame,
        facets: &Facets,
        range: Range<usize>,
        is_wanted: impl Fn(usize) -> bool,
    ) -> Option<Vec<(u32, Aabb)>> {
        let mut boxes = Vec::with_capacity(range.len());
        for facet in range {
            if facet % LOOKS == 0 && self.is_over() {
                return None;
            }
            if is_wanted(facet) && blocks(facets, facet) {
                let (points, count) = corners_of(facets, facet);
                boxes.extend(frame.bounds(&points[..count]).map(|bounds| (facet as u32, bounds)));
            }
        }
        Some(boxes)
    }

    fn index_analytic(&self, world: &Aabb) -> ObjectIndex {
        let corners = box_corners(world);
        let tree =
            |frame: &LightFrame| self.tree_of(frame.bounds(&corners).map(|bounds| (0, bounds)).into_iter().collect());
        self.frames.iter().map(tree).collect::<Option<_>>().map_or(ObjectIndex::Unbuilt, ObjectIndex::Own)
    }
}

/// Whether a facet may block and blocks more than those before it; repeats may have other holes.
pub(super) fn blocks(facets: &Facets, facet: usize) -> bool {
    facets.opacity(facet) != Opacity::Clear && (facets.has_holes() || !facets.is_repeat(facet))
}
