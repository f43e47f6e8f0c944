//! Which surface a camera sees.
//!
//! - [`View`]: a camera with a picture's size; the rays through its pixels; a default that frames a scene.
//! - [`RayCaster`]: the object, face and (u, v) that a ray meets first, and so the picture of a view (ray casting).
//! - [`hidden_surface`]: the face in each pixel by depth buffer, scan line, Warnock, ray casting or depth sort: all the same.
//! - [`line_drawing`]: edges with hidden parts left out or dashed, shadows hatched (Roberts).
//! - [`portals`]: the objects that an eye or a light may reach through the portals of a scene's cells.
//! - [`depth_map`]: what a light's middle sees, as depths on a grid.
//! - [`two_pass`]: shadow polygons on planar faces, by projection and polygon overlay.
//! - [`Acceleration`]: how its rays find the triangles of a mesh; by itself the way that a [`CostModel`] says is quickest.
//!
//! The layer is useful alone: no files, and of shadows only the polygons of `two_pass` and the depths of `depth_map`.

mod acceleration;
pub mod depth_map;
pub mod hidden_surface;
pub mod line_drawing;
mod local;
mod polygon;
pub mod portals;
mod ray_casting;
pub mod two_pass;
mod view;

pub use acceleration::{Acceleration, Choice, CostModel, LookupCost, Sampled, StepCost};
pub use ray_casting::{RayCaster, SurfaceHit};
pub use umbriel_bvh::Ray;
pub use view::{EyeRays, View};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
