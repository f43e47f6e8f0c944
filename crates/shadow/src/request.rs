//! What is asked of a bake.

use std::time::Duration;

use umbriel_scene::Scene;

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
    /// Faces are not divided: what is asked for is samples.
    Faces,
    /// Divide, where most is undecided for what it costs, until at most this share of the asked surface is undecided, or the boundary depth
    /// is 21.
    MaxUndecided {
        /// 0 to 1.
        share: f64,
    },
    /// Divide in the same order until the time is over, the one thing about a result that may differ from run to run; more time never gives wider
    /// bounds. Every receiver is looked at once whatever that takes. The lights of the request share the time; not for many suns one after the
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
}

impl Request {
    /// All lights, all receivers, sums only.
    pub fn everything(scene: &Scene, detail: Detail) -> Self {
        Self {
            detail,
            sampling: None,
            lights: (0..scene.lights.len()).collect(),
            receivers: (0..scene.objects.len()).collect(),
            keep_cells: false,
            method: CellMethod::Auto,
        }
    }
}
