//! Placed facets with holes: what of a facet blocks.

use super::{FaceCutOut, Opacity};
use crate::{
    blocking::{Probe, polygon_blocks},
    facets::Facets,
    light::LightSource,
    mesh::Mesh,
    ring::Ring,
};

impl Facets {
    /// Whether any facet has holes.
    pub fn has_holes(&self) -> bool {
        self.mesh().is_some_and(Mesh::has_holes)
    }

    /// Whether a facet has holes.
    ///
    /// # Panics
    /// If there is no such facet.
    #[inline]
    pub fn opacity(&self, facet: usize) -> Opacity {
        self.mesh().map_or(Opacity::Opaque, |mesh| mesh.opacity(facet))
    }

    /// How a facet with holes is cut out; `None` for one that is all opaque or all clear.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn holes(&self, facet: usize) -> Option<FaceCutOut<'_>> {
        self.mesh().filter(|mesh| mesh.opacity(facet) == Opacity::Mixed)?.cut_out(facet)
    }

    /// Whether an opaque point of a facet lies on the open segment from `x` to the light. Exact.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn blocks<R: Ring>(&self, facet: usize, x: &Probe<R>, light: &LightSource) -> bool {
        if self.opacity(facet) == Opacity::Clear {
            return false;
        }
        let numbers = self.facet(facet).corners();
        let mut corners = [self.point(numbers[0]); 4];
        for (point, &corner) in corners.iter_mut().zip(numbers.iter()) {
            *point = self.point(corner);
        }
        let corners = &corners[..numbers.len()];
        let is_opaque = |holes: FaceCutOut| holes.is_opaque_at([&corners[0], &corners[1], &corners[2]], x, light);
        polygon_blocks(corners, x, light) && self.holes(facet).is_none_or(is_opaque)
    }
}
