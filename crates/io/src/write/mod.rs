//! Plain data in, files out: tables, coloured meshes, pictures.
//!
//! Nothing here knows what a shadow is. Every file is written beside its target first and renamed when it is whole
//! ([`Staged`]), so nobody ever sees half a file.

mod atomic;
mod csv;
mod glb;
mod png;

pub use atomic::{Staged, WriteError, check_target};
pub use csv::{PointColumns, PointRow, PointTable, PointsError, Table, read_points};
pub use glb::{ColoredMesh, write_glb};
pub use png::{Picture, write_png};
