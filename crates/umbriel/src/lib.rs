//! Shadows in object space with a known error: for every object and light, which parts of its surface are lit, which are
//! in shadow, and exactly how much is still undecided.
//!
//! This crate gathers the layers under one name; each is also a crate of its own. The command of the same name stands
//! on nothing else.
//!
//! ```
//! use umbriel::{geometry, scene, shadow};
//!
//! let floor = scene::Object::new(
//!     "floor".into(),
//!     scene::Shape::Rectangle(geometry::Rectangle { size: [4.0, 4.0] }),
//!     geometry::Placement::IDENTITY,
//!     scene::Sides::Auto,
//! )?;
//! let sun = scene::Light::new("sun", geometry::LightSource::sun([0.3, -1.0, 0.2])?);
//! let scene = scene::Scene { objects: [floor].into(), lights: vec![sun], ..Default::default() };
//! let request = shadow::Request::everything(&scene, shadow::Detail::default());
//! let report = shadow::bake(&scene, &request, &shadow::Silent)?;
//! assert_eq!(report.lights.len(), 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(feature = "test-support")]
pub mod adversarial;

pub use umbriel_bvh as bvh;
pub use umbriel_geometry as geometry;
pub use umbriel_io as io;
pub use umbriel_octree as octree;
pub use umbriel_scene as scene;
pub use umbriel_shadow as shadow;
pub use umbriel_visibility as visibility;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
