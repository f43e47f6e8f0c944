//! What a scene is: objects with their placements, families of objects, lights, a camera, cells and portals.
//!
//! A scene is plain data, ready to use: every number in it has been accepted, every placement is regular, every
//! index is in range. Readers (`umbriel-io`) and programs build it; the layers above only look at it.

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod alike;
mod camera;
mod cells;
mod family;
mod finding;
mod light;
mod object;
mod objects;

pub use alike::first_alike;
pub use camera::{Camera, Projection};
pub use cells::{CellDefect, CellEntry, CellGraph, Overlap, Portal, Region, SceneCell, convex_body};
pub use family::{Family, FamilyTree, Member};
pub use finding::{Finding, FindingKind};
pub use light::{Extent, ExtentDefect, Light};
pub use object::{Object, ObjectDefect, PartBox, Placed, Shape, Sides};
pub use objects::Objects;

/// Objects, lights, and what a file said besides.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The bodies, each placed; names are unique.
    pub objects: Objects,
    /// How the objects group into families; names objects by their index.
    pub families: FamilyTree,
    /// The lights; names are unique.
    pub lights: Vec<Light>,
    /// The camera of the file, if it has one.
    pub camera: Option<Camera>,
    /// The cells and portals, made for the objects as they are; empty where nothing is said of them.
    pub cells: CellGraph,
    /// What was taken otherwise than the file says.
    pub findings: Vec<Finding>,
}
