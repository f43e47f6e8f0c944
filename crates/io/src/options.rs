//! What a user may say about a scene besides the file, and what the file says besides the scene.

use std::{collections::BTreeMap, path::PathBuf, sync::Arc, time::Duration};

use glam::{DAffine3, DMat3, DVec3};
use umbriel_scene::{Scene, Sides};

use crate::{lightmap::LightmapLayout, sun::sun_from_angles};

/// Which axis of the file points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// +Y is up and −Z is north: nothing is turned.
    #[default]
    Y,
    /// +Z is up and +Y is north: the scene is turned about x, (x, y, z) ↦ (x, z, −y).
    Z,
}

impl UpAxis {
    /// The turn from the file's axes to y up. A permutation with signs, so it changes no digit.
    pub(crate) fn turn(self) -> DAffine3 {
        match self {
            Self::Y => DAffine3::IDENTITY,
            Self::Z => DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y)),
        }
    }
}

/// How to read a scene. The default takes everything as the file says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// Which axis points up; `None` as the file says, else +Y. Turns everything in the file: meshes, placements,
    /// lights given by coordinates, the camera.
    pub up: Option<UpAxis>,
    /// Where north lies, degrees clockwise from −Z seen from above (after the turn to y up); `None` as the file says,
    /// else 0. No coordinate changes: north only says what an azimuth is counted from.
    pub north_degrees: Option<f64>,
    /// Whether paths may lead out of the folder of the scene.
    pub outside: Outside,
    /// Which sides can be lit, for objects whose own entry does not say; `None` as the file says, else `Auto`.
    pub sides: Option<Sides>,
    /// What glTF's BLEND materials do to light.
    pub blend: Blend,
    /// Which nodes of a glTF are taken as the shapes of their colliders.
    pub colliders: Colliders,
    /// Which set of texture coordinates lays out light maps: 1 for glTF's `TEXCOORD_1`. The only set that an OBJ has
    /// (`vt`) stands for any. `None` reads no texture coordinates.
    pub lightmap_set: Option<u32>,
}

/// What BLEND materials do to light: they are a matter of degrees, and shadows here are not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// They block as if they were opaque.
    #[default]
    Block,
    /// They block nothing. As receivers they stay what they are.
    Ignore,
}

/// Which nodes are taken as the shapes of their colliders, bodies given by formulas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colliders {
    /// Those without a mesh.
    #[default]
    WithoutMesh,
    /// All that have one, in place of their meshes.
    InPlace,
}

/// Whether files outside the folder of the scene may be read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outside {
    /// A path that leads out, also through a symbolic link, is an error.
    #[default]
    Refused,
    /// All paths are followed.
    Allowed,
}

/// The detail that a scene file asks for; plain data for the layers above.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum DetailSetting {
    /// Octree depths.
    Depth {
        /// The finest depth at which decided cells are stored, at most `boundary`; `None` leaves the choice open.
        interior: Option<u8>,
        /// Where a cell stays undecided; 0 to 21.
        boundary: u8,
    },
    /// The edge of the smallest cell, metres; positive.
    Cell {
        /// Metres.
        edge: f64,
    },
    /// The share of the surface that may stay undecided.
    MaxUndecided {
        /// 0 to 1.
        share: f64,
    },
    /// How long to divide, from when the scene is loaded.
    Time {
        /// Positive.
        limit: Duration,
    },
    /// The bytes that a light's cells may take.
    Memory {
        /// Bytes.
        bytes: u64,
    },
    /// The cells are no smaller than a pixel of the scene's camera.
    Pixel {
        /// Rows of the picture; at least 1.
        rows: u32,
    },
}

/// Details of single objects and lights, by their indices in the scene: depths or cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OwnSettings {
    /// Objects as receivers; all objects of a mesh file have that of the entry which names it.
    pub objects: BTreeMap<usize, DetailSetting>,
    /// Lights.
    pub lights: BTreeMap<usize, DetailSetting>,
}

/// A scene, and what its file says besides.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// Ready to use: y up, metres.
    pub scene: Scene,
    /// The detail that a scene file asks for.
    pub detail: Option<DetailSetting>,
    /// The details that a scene file asks for single objects and lights.
    pub own: OwnSettings,
    /// Where north lies, degrees clockwise from −Z seen from above.
    pub north_degrees: f64,
    /// Which axis of the file points up.
    pub up: UpAxis,
    /// For each object its layout on a light map, if that was asked for and the file has one; instances share it.
    pub lightmaps: Vec<Option<Arc<LightmapLayout>>>,
    /// Every file that was read, absolute and without symbolic links.
    pub files: Vec<PathBuf>,
}

impl LoadedScene {
    /// The direction in which sunlight travels in this scene, from the sun's azimuth (degrees clockwise from the
    /// scene's north) and elevation (degrees above the horizon). See [`sun_from_angles`].
    pub fn sun_from_angles(&self, azimuth: f64, elevation: f64) -> [f64; 3] {
        sun_from_angles(self.north_degrees + azimuth, elevation)
    }

    /// A direction given in the file's axes, as this scene has it; no digit changes.
    pub fn direction(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self.up {
            UpAxis::Y => [x, y, z],
            // Adding 0 turns −0 into 0.
            UpAxis::Z => [x, z, -y + 0.0],
        }
    }
}
