//! Soft shadows in image space: fast, without bounds. For comparison with what object space knows.
//!
//! [`DepthMap`] is what the light's middle sees; [`SoftShader`] shades the points of a picture from it by one of the ways of [`SoftMethod`]. All take
//! a rectangle light for a square of the same area, as the sources do.

mod boxes;
mod depth_map;
mod filters;
#[cfg(test)]
mod tests;

pub use boxes::{Blocker, OrientedBox, Outline, outlines};
pub use depth_map::{DepthMap, LightSpace};
pub use filters::{BoxKernel, SoftMethod, SoftShader};
