//! Morton codes and a pointerless, sorted octree.
//!
//! - [`Octant`] and [`Quadrant`]: cells of the halved cube and square, named by Morton codes, in Morton order.
//! - [`Cube`]: the bounding cube of an object, its lattice of cells, decided exactly.
//! - [`Partition`]: the leaves of an octree as a sorted list: location, neighbours, rays, levels of detail.
//! - [`LinearOctree`]: a partition with the items that meet each leaf.
//! - [`SolidOctree`]: a partition with leaves inside, outside and on the boundary of a solid; set operations, volumes.
//! - [`Projection`]: leaves of an octree projected from a viewpoint; rays from there are looked up.
//! - [`Face`]: the cells of a face's parameters, square or cut to a triangle.
//!
//! The layer is useful alone: no files, no threads, no dependency on the rest of umbriel but its geometry and
//! the triangles' rays of its BVH. Feature `serde`: octrees can be stored. Feature `rayon`: projections are built with
//! several threads.

mod cast;
mod cube;
mod direction;
mod linear;
mod morton;
mod partition;
mod projection;
mod quad;
mod solid;
#[cfg(feature = "serde")]
mod stored;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub use cast::{Cast, Crossing, Ray, RayDefect};
pub use cube::{Cube, LatticeBox, depth_of_length};
pub use direction::Direction;
pub use linear::{BuildDefect, Leaf, Limits, LinearOctree, OctreeDefect};
pub use morton::{Code, Octant, Quadrant, decode2, decode3, encode2, encode3};
pub use partition::{Gap, Partition};
pub use projection::{
    Layout, NotOfView, Numbering, ProjectedSegments, Projection, ProjectionDefect, ProjectionOptions, ProjectionReport,
    Renewal, Viewpoint,
};
pub use quad::Face;
pub use solid::{CubesDiffer, SolidOctree, SolidView, VolumeBounds};
#[cfg(feature = "serde")]
pub use stored::StoredDefect;
