//! Soft shadows in image space: fast, without bounds. For comparison with what object space knows.
//!
//! A [depth map](umbriel_visibility::depth_map) is what the light's middle sees, in the space of [`light_space`]; [`SoftShader`] shades the points of a picture from it by one of the ways of [`SoftMethod`]. All take
//! a rectangle light, or a ball of light, for a square of the same area, as the sources do, and a sun's disk for a square of its diameter.

mod area_light;
mod blocker_grid;
mod box_tree;
mod boxes;
mod filters;
mod receiver;
#[cfg(test)]
mod tests;

pub use area_light::light_space;
pub use box_tree::{BoxTree, Cut, hide_others, may_hide_itself};
pub use boxes::{Blocker, OrientedBox, Outline, covering_outlines, visible_outlines};
pub use filters::{BoxKernel, SoftMethod, SoftShader};
pub use receiver::SurfacePoint;
