//! Which surface a camera sees.
//!
//! - [`View`]: a camera with a picture's size; the rays through its pixels; a default that frames a scene.
//! - [`RayCaster`]: the object, face and (u, v) that a ray meets first, and so the picture of a view (ray casting).
//! - [`Acceleration`]: how its rays find the triangles of a mesh; by itself the way that a [`CostModel`] says is quickest.
//!
//! The layer is useful alone: no files, nothing about shadows.

mod acceleration;
mod local;
mod ray_casting;
mod view;

pub use acceleration::{Acceleration, Choice, CostModel, RayCost};
pub use ray_casting::{RayCaster, SurfaceHit};
pub use umbriel_bvh::Ray;
pub use view::View;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
