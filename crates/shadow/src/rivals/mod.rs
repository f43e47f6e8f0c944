//! The other ways to find hard shadows, made as well as they usually are, for comparison.
//!
//! [`ShadowVolume`] (Crow 1977), [`ShadowMap`] (Williams 1978), [`PointRays`] (one ray a point through a tree of triangles) and
//! [`Literal`] (the method of Xie et al. 2001 as its words go) answer the same question behind one trait, [`Rival`]: which of these points
//! of the surface are lit? None of them knows how far it is off; the exact answers tell.
//!
//! All work on [`Polygons`]: the placed faces of a scene, with curved bodies cut into triangles. Surface that is turned away from the light is
//! dark for each of them without any work, as in any renderer; a point of a curved body is not shadowed by the triangles of that body,
//! which only stand for it.

mod clip;
mod literal;
mod polygons;
mod rays;
mod shadow_map;
mod shadow_volume;

use umbriel_geometry::LightSource;

pub use literal::{Faults, Literal};
pub(crate) use polygons::triangles_of;
pub use polygons::{Polygons, RivalPoint};
pub use rays::PointRays;
pub use shadow_map::ShadowMap;
pub use shadow_volume::ShadowVolume;

/// A way to tell which points of a surface are lit.
pub trait Rival: Sync {
    /// What it is called in tables, its settings included.
    fn name(&self) -> String;

    /// Whether each point is lit. Everything that depends on the light is made here, so that its time counts.
    ///
    /// # Errors
    /// [`RivalRefusal`] when it cannot take the scene.
    fn answer(
        &self,
        polygons: &Polygons,
        light: &LightSource,
        points: &[RivalPoint],
    ) -> Result<RivalAnswer, RivalRefusal>;
}

/// What a rival says, and what it did for it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RivalAnswer {
    /// Whether each point is lit.
    pub lit: Vec<bool>,
    /// Wall seconds for what is made before the first point is looked at: a tree, a map, shadow volumes, marked cells.
    pub build_seconds: f64,
    /// Wall seconds for the points.
    pub points_seconds: f64,
    /// Rays cast; 0 for what casts none.
    pub rays: u64,
    /// How often a point was put to a polygon of a shadow volume; 0 for what has none.
    pub looked_at: u64,
    /// What is made: triangles of a tree, texels, polygons of shadow volumes, marked cells.
    pub pieces: u64,
    /// Bytes that what is made takes, as far as it is counted.
    pub bytes: u64,
}

/// Why a rival gives no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RivalRefusal {
    /// More work than the rival was given.
    #[error("more than {limit} rays; it was given no more")]
    TooManyRays {
        /// Rays it may cast.
        limit: u64,
    },
}
