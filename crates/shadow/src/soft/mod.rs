//! Soft shadows: lights that have an extent.
//!
//! [`Queries::visible_fraction`](crate::Queries::visible_fraction) tells how much of an area light a point sees, by closed forms and exact clipping
//! where these serve.

mod caps;
mod fraction;
mod occluders;
mod polygon;
mod window;

pub use fraction::Fraction;
