//! Rays looked up in the projection of an octree, for rays that start in one point or run parallel.
//!
//! After Wei, Geng and Zhang, "A ray intersection method based on octree spatial structure's projection", Journal of
//! Northwest University (Natural Science) 45(3), 2015: the boxes that a ray of a view meets are those whose projection holds
//! its pixel. So the leaves of a compact octree ([`tree`]), parallel to the view plane ([`frame`]), are projected once
//! ([`footprint`]) into maps ([`map`]), in packs of eight triangles ([`pack`]); a ray finds the packs of its leaves there, in ascending number, and
//! tests their triangles. The viewpoint may be an eye, a lamp (six maps round it) or a sun.
//!
//! - *Numbers.* The source numbers leaves section by section, and such numbers do not grow along every ray. Here they
//!   are those of the recursive front-to-back order of octants, which do; the source's order is [`Numbering::Sections`], and
//!   [`Projection::disorder`] counts what it gets wrong. Answers are the same.
//! - *Maps.* One over all leaves ([`Layout::OneMap`], the source's first mode), or one a section, walked front to back
//!   ([`Layout::MapPerSection`], its second).
//! - *Guarantee.* Maps and packs only leave out what is certainly missed, with every rounding bounded. [`Projection::any_hit`] is
//!   exactly the definition of blocking, [`Projection::nearest_hit`] finds what
//!   [`TriangleBvh::nearest_hit`](umbriel_bvh::TriangleBvh::nearest_hit) does, equal distances included.
//! - *Moving.* [`Projection::renewed`] makes anew what moved triangles touch, or touched ([`renew`]); the result is that of building.
//! - *Cost.* Building: O(triangles in leaves × levels + numbers in maps). A ray: a look-up and the packs of the leaves up to its hit. What breaks
//!   it: leaves seen edge-on and close to the viewpoint overlap in many cells; memory is bounded by coarser maps and a
//!   coarser tree.
//!
//! [`Projection::nearest_hit_by_descent`] and [`Projection::segments_by_descent`] find the same leaves by an ordinary traversal
//! ([`descent`]): the measure of what the maps save.

mod budget;
mod build;
mod descent;
mod disorder;
mod footprint;
mod frame;
mod grid;
mod map;
mod outline;
mod overlap;
mod pack;
mod query;
mod renew;
mod tasks;
#[cfg(test)]
mod tests;
mod tree;

use std::sync::Arc;

use glam::DVec3;
use umbriel_geometry::{Aabb, LightSource, Mesh};

use crate::morton::Octant;

use self::{
    frame::Frame,
    map::Map,
    pack::Pack,
    tree::{Root, Tree},
};

pub use frame::Viewpoint;
pub use query::{NotOfView, ProjectedSegments};
pub use renew::Renewal;

/// Why nothing can be projected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ProjectionDefect {
    /// A viewpoint outside the accepted range, a direction of length zero, or a picture whose axes lie in a plane.
    #[error("the viewpoint is no point, or has no direction")]
    NoView,
    /// A level that Morton codes of 64 bits cannot name.
    #[error("level {0} is deeper than 21")]
    TooDeep(u8),
    /// More triangles than 2^31.
    #[error("more than 2^31 triangles")]
    TooMany,
}

/// In which order a run lists its leaves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Numbering {
    /// The recursive front-to-back order of octants: grows along every ray, so that the first leaf with a hit inside ends it.
    #[default]
    FrontToBack,
    /// The source's: by the depth of upper faces, then by the distance from the viewpoint's foot, deeper leaves first. A ray
    /// ends where its hit is nearer than every remaining section.
    Sections,
}

/// How leaves are laid into maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// One map a face over all leaves: the source's mode 1.
    #[default]
    OneMap,
    /// One map a face and section: the source's mode 2.
    MapPerSection,
}

/// How a projection is built. Answers do not depend on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectionOptions {
    /// No leaf is deeper. 0..=21; more: fewer triangles a ray, larger maps.
    pub max_level: u8,
    /// A leaf above the greatest level holds no more triangles than this, unless halving it separates nothing.
    pub leaf_items: usize,
    /// In which order runs list leaves.
    pub numbering: Numbering,
    /// How leaves are laid into maps.
    pub layout: Layout,
    /// How many rays are expected: maps are as fine as so many rays pay for.
    pub rays: u64,
    /// Bytes that tree and maps may take together. Above, maps become coarser, then the tree.
    pub memory: usize,
}

impl ProjectionOptions {
    /// A good level for maps over a surface of so many triangles: it has 4 cells where its leaves halve, so a level less than
    /// half the logarithm of the triangles leaves a few in each leaf. An ordinary traversal is quickest two levels deeper.
    pub fn level_for(triangles: usize) -> u8 {
        let halvings = (triangles.max(1).ilog2() as u8).div_ceil(2);
        halvings.saturating_sub(1).clamp(1, Octant::MAX_LEVEL)
    }

    /// Enough bytes for a surface of so many triangles: a kibibyte each, of which ordinary scenes take less than half, between 64 MiB and 2 GiB. Piles of triangles
    /// that lie over each other everywhere would take any number.
    pub fn memory_for(triangles: usize) -> usize {
        triangles.saturating_mul(1 << 10).clamp(1 << 26, 1 << 31)
    }

    /// How many places in leaves the triangles of a mesh are expected to have at [`ProjectionOptions::level_for`] their number: building goes with it.
    /// A triangle of area A and perimeter P that lies anyhow meets 1 + 3P/4h + 3A/2h² cells of edge h on average (the principal kinematic formula; Santaló, "Integral
    /// Geometry and Geometric Probability", 1976, III.15). O(triangles).
    pub fn expected_items(mesh: &Mesh) -> f64 {
        let corners = |triangle: &[u32; 3]| triangle.map(|corner| mesh.positions()[corner as usize]);
        let (_, items) = Self::expected_items_of(mesh.triangles().iter().map(corners), &mesh.bounds());
        items
    }

    /// The same for triangles wherever they are stored, all of them in `bounds`; with their number.
    pub fn expected_items_of(triangles: impl Iterator<Item = [DVec3; 3]>, bounds: &Aabb) -> (usize, f64) {
        let (mut count, mut perimeters, mut areas) = (0, 0.0, 0.0);
        for [a, b, c] in triangles {
            count += 1;
            perimeters += a.distance(b) + b.distance(c) + c.distance(a);
            areas += 0.5 * (b - a).cross(c - a).length();
        }
        if count == 0 {
            return (0, 0.0);
        }
        let cell = bounds.size().max_element() * 0.5f64.powi(i32::from(Self::level_for(count)));
        (count, count as f64 + 0.75 * perimeters / cell + 1.5 * areas / (cell * cell))
    }
}

impl Default for ProjectionOptions {
    /// For a million rays, within 2 GiB: leaves of one pack, as deep as there are few triangles in them.
    fn default() -> Self {
        Self {
            max_level: 10,
            leaf_items: pack::WIDTH,
            numbering: Numbering::default(),
            layout: Layout::default(),
            rays: 1 << 20,
            memory: 1 << 31,
        }
    }
}

/// What was built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProjectionReport {
    /// Level of the deepest leaf.
    pub depth: u8,
    /// Leaves of the octree.
    pub leaves: usize,
    /// Places of triangles in leaves.
    pub items: usize,
    /// Maps over all faces and sections.
    pub maps: usize,
    /// Their cells.
    pub cells: usize,
    /// Numbers of packs in the cells: of eight triangles of a leaf at most.
    pub numbers: usize,
    /// Bytes of the octree: nodes, leaves, triangles made ready.
    pub tree_bytes: usize,
    /// Bytes of the maps.
    pub map_bytes: usize,
    /// Whether maps or tree are coarser than asked for, to stay within [`ProjectionOptions::memory`].
    pub is_coarsened: bool,
}

/// A leaf as rays look at it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Leaf {
    /// Its cell, in the cube's coordinates.
    min: [f32; 3],
    edge: f32,
    first_pack: u32,
    packs: u32,
}

impl Leaf {
    /// The leaf's own of all packs.
    fn packs_of<'a>(&self, packs: &'a [Pack]) -> &'a [Pack] {
        &packs[self.first_pack as usize..(self.first_pack + self.packs) as usize]
    }
}

/// The maps of a face.
#[derive(Clone, Debug, PartialEq)]
struct Section {
    /// Least depth of a leaf in it; −∞ where one map holds all.
    near: f64,
    map: Map,
}

/// A mesh made ready for the rays of one viewpoint. Both sides of a triangle count. The mesh is shared, not copied.
/// Projections are equal where all that was built is, to the bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Projection {
    mesh: Arc<Mesh>,
    viewpoint: Viewpoint,
    light: LightSource,
    options: ProjectionOptions,
    frame: Frame,
    /// Bound on the error of a corner's local coordinates.
    error: f64,
    root: Root,
    tree: Tree,
    leaves: Vec<Leaf>,
    packs: Vec<Pack>,
    /// The leaf of each pack.
    owners: Vec<u32>,
    /// By face; empty where the face has no maps.
    faces: [Vec<Section>; 6],
    report: ProjectionReport,
}

impl Projection {
    /// What was built.
    pub fn report(&self) -> ProjectionReport {
        self.report
    }

    /// Where the rays come from.
    pub fn viewpoint(&self) -> &Viewpoint {
        &self.viewpoint
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }
}
