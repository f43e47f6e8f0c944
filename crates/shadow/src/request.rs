//! What is asked of a bake.

use std::{collections::BTreeMap, time::Duration};

use glam::DVec3;
use umbriel_scene::{Camera, Projection, Scene};

use crate::levels::TYPICAL_DEPTH;

/// How far undecided cells are divided.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Detail {
    /// Depths in the octree of an object's bounding cube (Xie et al. 2001): at depth d no cell is larger than the
    /// cube's edge / 2^d.
    Depth {
        /// The finest depth at which decided cells are stored; finer ones only count in the sums.
        interior: u8,
        /// Where a cell stays undecided; 21 at most.
        boundary: u8,
    },
    /// The edge of the smallest cell, metres.
    Cell {
        /// Metres; positive.
        edge: f64,
    },
    /// No cell smaller than a pixel of a camera: cells are divided as long as their halves reach at least as far as a pixel does where the cell is farthest from
    /// the eye. A pixel is as wide in all directions, as if the camera were turned to each point, and what it does not see is treated like what it sees.
    Pixel {
        /// Where the eye stands, world coordinates in metres.
        eye: DVec3,
        /// The width of a pixel at a distance of one metre, metres; positive.
        width: f64,
    },
    /// Faces are not divided: what is asked for is samples.
    Faces,
    /// Divide, where most is undecided for what it costs, until at most this share of the asked surface is undecided, or the boundary depth
    /// is 21.
    MaxUndecided {
        /// 0 to 1.
        share: f64,
    },
    /// Divide in the same order until the time is over, the one thing about a result that may differ from run to run; more time never gives wider
    /// bounds. The areas of all faces are added up whatever that takes; with samples, each face is looked at as a whole to decide them. The lights of the request share the time; not for many suns one after the
    /// other ([`bake_hours`](crate::bake_hours)), which have one depth.
    Time {
        /// Wall time from the beginning of the bake.
        limit: Duration,
    },
    /// Divide in the same order as long as the examined cells would fit, stored or not. For each light; what is needed on the way is not counted.
    Memory {
        /// Bytes.
        bytes: u64,
    },
}

impl Default for Detail {
    /// The source's typical depths, 4 and 8.
    fn default() -> Self {
        Self::Depth { interior: 4, boundary: TYPICAL_DEPTH }
    }
}

impl Detail {
    /// No cell smaller than a pixel of a camera whose picture has so many rows. In a parallel view all pixels are alike, so that it is [`Detail::Cell`].
    pub fn of_pixel(camera: &Camera, rows: u32) -> Self {
        match camera.projection {
            // Half of such a cell is as small as a pixel.
            Projection::Orthographic { height } => Self::Cell { edge: 2.0 * height / f64::from(rows) },
            Projection::Perspective { vertical_degrees } => {
                let width = 2.0 * libm::tan(0.5 * vertical_degrees.to_radians()) / f64::from(rows);
                Self::Pixel { eye: camera.eye, width }
            }
            _ => Self::default(),
        }
    }

    /// Whether it says by itself how far a face is divided; a limit spreads over all faces.
    pub fn is_fixed(&self) -> bool {
        matches!(self, Self::Depth { .. } | Self::Cell { .. } | Self::Pixel { .. })
    }
}

/// Details of single objects and lights, by their indices in the scene: only fixed ones ([`Detail::is_fixed`]), others are not looked at.
///
/// An object's own detail comes before that of a light, and this before that of the request. Where the request has a limit, its steps divide as far as these
/// let them, and what they leave undecided is not counted to a share. Where it asks for samples alone ([`Detail::Faces`]), and in [`bake_hours`](crate::bake_hours), nothing has a detail of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OwnDetails {
    /// Objects as receivers.
    pub objects: BTreeMap<usize, Detail>,
    /// Lights.
    pub lights: BTreeMap<usize, Detail>,
}

/// Exact answers on a lattice over the surface, besides the cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sampling {
    /// About this many samples over all asked receivers, spread by area; at least one a face.
    Count(u64),
    /// At most this far apart along both parameters of a face, metres.
    Spacing(f64),
}

/// How the cells of flat faces are proved. Proofs are proofs either way; how many cells stay undecided differs a little.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum CellMethod {
    /// Whichever is likely to be sooner, face by face.
    #[default]
    Auto,
    /// A quadtree that passes blockers down. Sharp where shadows end exactly between two cells; some microseconds a
    /// cell, and a look at every occluding face.
    Quadtree,
    /// The borders of shadows are rasterised, wherever nothing but flat faces shadows a face; a quadtree elsewhere.
    Borders,
}

/// What to compute.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// How fine.
    pub detail: Detail,
    /// What is finer or coarser than the rest.
    pub own: OwnDetails,
    /// Samples, if asked for.
    pub sampling: Option<Sampling>,
    /// Which lights of the scene.
    pub lights: Vec<usize>,
    /// Which objects as receivers; all objects are occluders.
    pub receivers: Vec<usize>,
    /// Whether the report keeps the cells, or sums only.
    pub keep_cells: bool,
    /// How the cells of flat faces are proved.
    pub method: CellMethod,
    /// What may be done for each light where the detail is fixed ([`Detail::is_fixed`]). The unit is a facet that is held against a
    /// cell, about a tenth of a microsecond; all that takes longer counts for more ([`typical_effort`](crate::typical_effort)). A light for which it is not enough is baked anew, as far as it goes: in the order of a limit, and no cell below those of the
    /// detail; of sixteen receivers or more some sixteenth comes first, and where these take far more than their part, all are taken to. The report counts such lights ([`Work::lights_cut_short`](crate::Work::lights_cut_short)). `None`: whatever it takes. Not for many suns one after the other.
    pub effort: Option<u64>,
}

impl Request {
    /// All lights, all receivers, sums only.
    pub fn everything(scene: &Scene, detail: Detail) -> Self {
        Self {
            detail,
            own: OwnDetails::default(),
            sampling: None,
            lights: (0..scene.lights.len()).collect(),
            receivers: (0..scene.objects.len()).collect(),
            keep_cells: false,
            method: CellMethod::Auto,
            effort: None,
        }
    }
}
