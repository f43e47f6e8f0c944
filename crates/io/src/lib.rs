//! Scenes in, tables, meshes and pictures out.
//!
//! [`load`] reads scene files (`.toml`), glTF 2.0 (`.gltf`, `.glb`), Wavefront OBJ, STL and PLY into a
//! [`Scene`](umbriel_scene::Scene), strictly: a fault is an error that names its place, and what is taken otherwise
//! than the file says is a finding. [`mod@npy`] has NumPy's tables of points. [`surface_findings`] looks at the surfaces themselves. [`read_suns`] reads tables of
//! suns. [`mod@write`] holds the writers.
//!
//! Numbers are read as f64 (32-bit floats become f64 exactly), nothing is welded, rounded or dropped. Files outside the
//! folder of the scene are refused unless [`Outside::Allowed`] says otherwise. Nothing is fetched from a network.
//!
//! What is written out in a file is read, however much it is; what a file multiplies is limited. A scene may hold 2^23
//! triangles (counted for every instance) and eight for every byte of its files, three times as many vertices, 2^18 objects, families and lights and one for
//! every four bytes, 2^24 decoded elements of accessors and one for every byte, 2^25 texels of cut-outs and four for every byte, and 2^30 pairs of a vertex and
//! a box of its object and 64 for every byte. Names have 200 characters at most.

mod error;
mod findings;
mod folder;
mod gltf;
mod ledger;
mod lightmap;
mod load;
mod memory;
mod model;
mod names;
pub mod npy;
mod obj;
mod options;
mod picture;
mod ply;
mod rooms;
mod scene_file;
mod stl;
mod sun;
mod suns;
mod text;
mod tokens;
mod transform;
mod triangulate;
pub mod write;
mod z_up;

pub use error::{LoadError, LoadProblem};
pub use findings::surface_findings;
pub use lightmap::LightmapLayout;
pub use load::{load, load_bytes};
pub use memory::{MemoryPeak, peak_memory_bytes};
pub use names::printable;
pub use options::{Blend, Colliders, DetailSetting, LoadOptions, LoadedScene, Outside, OwnSettings, UpAxis};
pub use sun::sun_from_angles;
pub use suns::{SunPlace, SunRow, SunsError, duration_of_hours, read_suns};

/// The examples of the README, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
