//! Boxes in trees: which boxes meet a box, lie along a segment to a light, or can shadow another.
//!
//! - [`BoxTree`]: a static binary tree over boxes, for anything that has a box.
//! - [`Shaft`]: can anything in this box stand between that box and the light? Never says no in vain.
//!
//! Answers never depend on the shape of a tree: every query returns what a loop over all boxes would.
//! The layer is useful alone: no files, no threads, no dependency on the rest of umbriel but its geometry.

mod box_tree;
mod ray;
mod shaft;

pub use box_tree::{BoxTree, TreeDefect};
pub use ray::Ray;
pub use shaft::{Segment, Shaft, may_shadow};
