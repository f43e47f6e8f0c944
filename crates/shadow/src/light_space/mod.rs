//! Light space in numbers: points and triangles as a light sees them, each with a bound on its error.
//!
//! Shadow rays become points (u, v) of a plane, and of two points on one ray the one that is nearer to the light has the
//! greater *nearness*, which is affine over every plane of the scene. So whether a triangle stands between a point and the
//! light is a matter of three edge functions and one plane in two dimensions ([`Footprint`]), for suns and lamps alike.
//!
//! Guarantee: whoever compares with the margins that are given here decides as exact arithmetic does (NUMERICS.md §12).

mod footprint;
mod view;

pub(crate) use footprint::{CornerError, Footprint};
pub(crate) use view::{Homogeneous, View, greater, lesser, power_of_two};
