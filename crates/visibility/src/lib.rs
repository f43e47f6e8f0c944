//! Which surface a camera sees.
//!
//! - [`View`]: a camera with a picture's size; the rays through its pixels; a default that frames a scene.
//! - [`RayCaster`]: the object, face and (u, v) that a ray meets first, and so the picture of a view (ray casting).
//!
//! The layer is useful alone: no files, nothing about shadows.

mod local;
mod ray_casting;
mod view;

pub use ray_casting::{RayCaster, SurfaceHit};
pub use umbriel_bvh::Ray;
pub use view::View;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
