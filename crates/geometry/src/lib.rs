//! Bodies, placements, lights and exact geometric decisions.
//!
//! Everything here answers questions of *sign*: on which side of a plane a point lies, whether a segment meets a
//! face. Signs are decided on the input numbers: a filter in floating point with a running error bound first
//! ([`Approx`]), big dyadic numbers where the filter is in doubt ([`Dyadic`]). No epsilon, no tessellation.
//!
//! [`simd`] holds vectors of floats for the layers above, with the same bits on every processor.
//!
//! The layer is useful alone: no files, no threads, no dependency on the rest of umbriel.

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod aabb;
pub mod analytic;
mod approx;
pub mod blocking;
mod box_columns;
mod brep;
pub mod cut_out;
mod decide;
pub mod decisions;
mod disjoint_sets;
mod dyadic;
pub mod edge_uses;
mod expansion;
mod facets;
pub mod gathered;
mod joints;
mod light;
mod measures;
mod mesh;
mod mesh_area;
mod number;
mod pair;
mod parallelogram;
mod placement;
mod point;
pub mod predicates;
mod rectangle;
mod region;
mod ring;
pub mod simd;
mod stretch;
mod surd;
mod topology;
mod turns;

pub use aabb::Aabb;
pub use analytic::{Analytic, AnalyticDefect, PlacedAnalytic};
pub use approx::Approx;
pub use box_columns::{BoxBlock, BoxColumns};
pub use brep::{
    Brep, BrepDefect, Convex, ConvexMeshDefect, Cuboid, Flatness, HalfEdge, HalfSpace, HalfSpaceDefect, HullDefect,
    Silhouette, canonical_loop,
};
pub use decide::Decide;
pub use disjoint_sets::DisjointSets;
pub use dyadic::Dyadic;
pub use facets::{Base, Corners, Facet, Facets, length_squared};
pub use light::{LightDefect, LightSource};
pub use measures::Measures;
pub use mesh::{Mesh, MeshDefect};
pub use mesh_area::MeshArea;
pub use number::{AXES, MAX_MAGNITUDE, MIN_MAGNITUDE, NumberDefect, accept, accept_point, power_of_two_below};
pub use pair::Pair;
pub use placement::{Placement, PlacementDefect};
pub use point::{Exact, ExactPoint, Image, Point};
pub use rectangle::Rectangle;
pub use region::{Region, Relation};
pub use ring::{Ring, Sign};
pub use surd::Surd;
pub use topology::{Component, Topology};
