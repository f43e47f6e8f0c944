//! Placed planar faces as a region.
//!
//! The surface is every facet, closed and open components alike. The solid is where the winding number of the closed
//! components is positive (Jacobson, Kavan & Sorkine-Hornung, "Robust Inside-Outside Segmentation using Generalized
//! Winding Numbers", SIGGRAPH 2013, for the idea; here it is an integer because only closed components count). So
//! overlapping bodies are united, a component of negative volume is a cavity of the body around it, and alone it encloses
//! nothing; open components enclose nothing.

use glam::DVec3;

use super::{Region, overlap, winding};
use crate::{
    aabb::Aabb,
    facets::{Facet, Facets},
};

impl Region for Facets {
    fn bounds(&self) -> Aabb {
        Self::bounds(self)
    }

    fn parts(&self) -> u32 {
        // Facets are made from meshes, whose triangles are counted by 32-bit numbers.
        self.len() as u32
    }

    fn meets(&self, part: u32, cell: &Aabb) -> bool {
        match self.facet(part as usize) {
            Facet::Triangle(corners) => overlap::meets(&corners.map(|corner| self.point(corner)), cell),
            Facet::Parallelogram(corners) => overlap::meets(&corners.map(|corner| self.point(corner)), cell),
        }
    }

    fn encloses(&self, point: DVec3) -> bool {
        self.windings(point).into_iter().sum::<i64>() > 0
    }
}

impl Facets {
    /// How often each component goes round a point that is on no surface; of the open ones 0. Exact. Positive where the surface looks away from the point.
    /// O(facets): most are rejected by their coordinates.
    pub fn windings(&self, point: DVec3) -> Vec<i64> {
        let topology = self.topology();
        let mut windings = vec![0; topology.components.len()];
        for facet in (0..self.len()).filter(|&facet| self.is_closed(facet)) {
            let crossings = match self.facet(facet) {
                Facet::Triangle(corners) => self.crossing(corners, point),
                Facet::Parallelogram([a, b, c, d]) => self.crossing([a, b, c], point) + self.crossing([a, c, d], point),
            };
            windings[topology.component_of[facet] as usize] += if self.is_mirrored() { -crossings } else { crossings };
        }
        windings
    }

    fn crossing(&self, corners: [u32; 3], point: DVec3) -> i64 {
        i64::from(winding::crossing(&corners.map(|corner| self.point(corner)), point))
    }
}
