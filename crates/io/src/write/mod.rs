//! Plain data in, files out: tables, coloured meshes, grids with numbers on them, pictures.
//!
//! Nothing here knows what a shadow is. Every file is written beside its target first and renamed when it is whole
//! ([`Staged`]), so nobody ever sees half a file.

mod atomic;
mod csv;
mod glb;
mod png;
mod svg;
mod vtu;

pub use atomic::{Staged, WriteError, check_target};
pub use csv::{PointColumns, PointRow, PointTable, PointsError, Table, read_points, write_rows};
pub use glb::{ColoredMesh, write_glb};
pub use png::{GrayPicture, Picture, write_gray_png, write_png, write_png_parts};
pub use svg::{LineArt, LineLayer, write_svg};
pub use vtu::{GridArray, GridValues, PolygonGrid, write_vtu};
