//! Soft shadows in image space: fast, without bounds. For comparison with what object space knows.
//!
//! [`DepthMap`] is what the light's middle sees; [`SoftShader`] shades the points of a picture from it by one of the ways of [`SoftMethod`]. All take
//! a rectangle light, or a ball of light, for a square of the same area, as the sources do, and a sun's disk for a square of its diameter.

mod blocker_grid;
mod box_tree;
mod boxes;
mod depth_map;
mod filters;
mod light_space;
mod receiver;
#[cfg(test)]
mod tests;

pub use box_tree::{BoxTree, Cut, hide_others, may_hide_itself};
pub use boxes::{Blocker, OrientedBox, Outline, visible_outlines};
pub use depth_map::{CurvedBodies, DepthMap};
pub use filters::{BoxKernel, SoftMethod, SoftShader};
pub use light_space::LightSpace;
pub use receiver::SurfacePoint;
