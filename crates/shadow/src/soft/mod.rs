//! Soft shadows: lights that have an extent.
//!
//! [`Queries::visible_fraction`](crate::Queries::visible_fraction) tells how much of an area light a point sees, by closed forms and exact clipping
//! where these serve. [`soft_bake`] divides surfaces into lit, umbra and penumbra cells, each with bounds that hold for all of its points.
//! [`image`] holds the ways of pictures, without bounds.

mod bake;
mod between;
mod caps;
mod cell;
mod cover;
mod face;
mod fraction;
mod hidden;
mod horizon;
pub mod image;
mod limits;
mod normal;
mod occluders;
mod polygon;
pub(crate) mod polyhedra;
mod sums;
mod views;
mod window;

pub use bake::{AreaBounds, SoftCell, SoftLight, SoftObject, SoftRequest, soft_bake};
pub use fraction::Fraction;
