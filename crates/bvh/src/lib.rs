//! Boxes in trees: which boxes meet a box, lie along a segment to a light, or can shadow another.
//!
//! - [`BoxTree`]: a static binary tree over boxes, for anything that has a box.
//! - [`Shaft`]: can anything in this box stand between that box and the light? Never says no in vain.
//! - [`may_shadow`] and [`cannot_shadow`]: the influence of one box on another, and the proof that there is none.
//! - [`ObjectTree`] and [`influences`]: objects and families in a tree, and which objects may shadow which; [`level_pairs`]
//!   shows the step above the objects.
//! - [`TriangleBvh`]: does any triangle block this segment; which triangle does this ray hit first?
//!
//! Answers never depend on the shape of a tree: every query returns what a loop over all boxes would.
//! The layer is useful alone: no files, no threads, no dependency on the rest of umbriel but its geometry.

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(test)]
mod arbitrary;
mod box_tree;
mod coarse;
mod influence;
mod object_tree;
mod ray;
mod shaft;
mod triangle_bvh;

pub use box_tree::{BoxTree, NodePair, TreeDefect};
pub use coarse::{
    Exclusion, Influences, LevelPair, PairCounts, for_each_influence, influences, influences_with, level_pairs,
    occluders_of,
};
pub use influence::{cannot_shadow, may_shadow};
pub use object_tree::{Families, FamilyDefect, Member, NodeId, ObjectTree};
pub use ray::Ray;
pub use shaft::{Segment, Shaft};
pub use triangle_bvh::{BuildQuality, Hit, Steps, Towards, TriangleBvh, TriangleRay};
