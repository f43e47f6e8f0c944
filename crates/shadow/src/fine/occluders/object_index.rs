//! The trees in which facets over a receiver are found: one an object and frame, built when first asked for.
//!
//! Instances of a mesh share one tree in the mesh's own coordinates; those that are receivers of a group have trees of their own until it is done. Cost: a look
//! at each facet and a sort for each frame.

use std::{
    ops::Range,
    sync::{Arc, OnceLock},
};

use rayon::prelude::*;
use umbriel_bvh::BoxTree;
use umbriel_geometry::{Aabb, Facets, Mesh, cut_out::Opacity};

use super::{
    LOOKS, LightFrame, Occluders, corners_of,
    facet_tree::{Entry, FacetTree, Grid},
};
use crate::{bodies::Body, fine::instance_tree::LocalFrame};

/// For each frame, a tree and the facets that its items stand for.
pub(super) type Trees = Vec<(BoxTree, Vec<u32>)>;

/// The same of some of its facets, once they are asked for; `None` if the clock came first.
pub(super) type Thinned = OnceLock<Option<Trees>>;

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
            let tree = |frame| {
                let grid = self.grid(object, frame);
                let entries = match self.bodies.get(object as usize) {
                    Body::Flat(facets) => self.entries(&grid, frame, facets, 0..facets.len())?,
                    Body::Analytic(_) => {
                        self.view_of_body(object, frame).map(|view| grid.entry(0, view)).into_iter().collect()
                    }
                };
                self.tree_of(grid, entries)
            };
            own((0..self.frames.len()).map(tree).collect())
        })
    }

    /// Builds trees of their own for these objects, on all threads, unless they have some: to be called before receivers look for them side by side, as one that
    /// waits for another's tree cannot help with it. Each object may be named once.
    pub(crate) fn prepare(&self, objects: Vec<u32>) {
        objects.into_par_iter().for_each(|object| {
            let Body::Flat(facets) = self.bodies.get(object as usize) else { return };
            let tree = |frame| {
                let grid = self.grid(object, frame);
                self.tree_of(grid, self.entries_side_by_side(&grid, frame, facets)?)
            };
            self.seen(object).index.get_or_init(|| own((0..self.frames.len()).into_par_iter().map(tree).collect()));
        });
    }

    /// What a tree over an object's facets counts in.
    fn grid(&self, object: u32, frame: usize) -> Grid {
        Grid::over(self.view_of_body(object, frame).copied().unwrap_or(Aabb::EMPTY))
    }

    fn tree_of(&self, grid: Grid, entries: Vec<Entry>) -> Option<FacetTree> {
        FacetTree::build_while(grid, entries, &|| !self.is_over())
    }

    /// Of the facets that are wanted; `None` if the clock came first.
    pub(super) fn trees_of(&self, facets: &Facets, is_wanted: impl Fn(usize) -> bool) -> Option<Trees> {
        let trees = self.frames.iter().map(|frame| {
            let (mut items, mut boxes) = (Vec::new(), Vec::new());
            self.for_each_box(frame, facets, (0..facets.len(), &is_wanted), |facet, bounds| {
                items.push(facet);
                boxes.push(bounds);
            })?;
            Some((BoxTree::build_while(&boxes, &|| !self.is_over())?, items))
        });
        trees.collect()
    }

    /// As [`Occluders::entries`] of all facets, on all threads.
    fn entries_side_by_side(&self, grid: &Grid, frame: usize, facets: &Facets) -> Option<Vec<Entry>> {
        let runs = (0..facets.len()).into_par_iter().step_by(LOOKS).map(|first| {
            let run = first..facets.len().min(first + LOOKS);
            self.entries(grid, frame, facets, run)
        });
        let mut runs = runs.collect::<Option<Vec<_>>>()?;
        if runs.len() == 1 { runs.pop() } else { Some(runs.concat()) }
    }

    /// Those of a range of facets that a frame sees and that may block, for a tree; `None` if the clock came first.
    fn entries(&self, grid: &Grid, frame: usize, facets: &Facets, range: Range<usize>) -> Option<Vec<Entry>> {
        let mut entries = Vec::with_capacity(range.len());
        let add = |facet, bounds| entries.push(grid.entry(facet, &bounds));
        self.for_each_box(&self.frames[frame], facets, (range, &|_| true), add)?;
        Some(entries)
    }

    /// Visits those of the wanted facets in a range that a frame sees and that may block, with their boxes; `None` if the clock came first.
    fn for_each_box(
        &self,
        frame: &LightFrame,
        facets: &Facets,
        (range, is_wanted): (Range<usize>, &impl Fn(usize) -> bool),
        mut visit: impl FnMut(u32, Aabb),
    ) -> Option<()> {
        for facet in range {
            if facet % LOOKS == 0 && self.is_over() {
                return None;
            }
            if is_wanted(facet) && blocks(facets, facet) {
                let (points, count) = corners_of(facets, facet);
                if let Some(bounds) = frame.bounds(&points[..count]) {
                    visit(facet as u32, bounds);
                }
            }
        }
        Some(())
    }
}

/// The trees, if the clock did not come first.
fn own(trees: Option<Vec<FacetTree>>) -> ObjectIndex {
    trees.map_or(ObjectIndex::Unbuilt, ObjectIndex::Own)
}

/// Whether a facet may block and blocks more than those before it; repeats may have other holes.
pub(super) fn blocks(facets: &Facets, facet: usize) -> bool {
    facets.opacity(facet) != Opacity::Clear && (facets.has_holes() || !facets.is_repeat(facet))
}
