//! Which points of triangles lie at one position, and the surfaces that the triangles form by them.
//!
//! Found when first asked for. Instances of a mesh share what is found of the mesh itself: placing rounds, so it may bring vertices together that are apart,
//! but never takes equal ones apart; where the classes of equal vertices are those of the mesh, all else that is made of them is, too.

use std::sync::OnceLock;

use glam::DVec3;

use crate::{edge_uses::weld, topology::Topology};

/// Equal points, and what follows from them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Joints {
    /// For each point the first one at its position; nothing where no two points share one.
    firsts: Option<Vec<u32>>,
    topology: OnceLock<Topology>,
}

impl Joints {
    /// One look at all points.
    pub(crate) fn of(positions: &[DVec3]) -> Self {
        Self { firsts: weld(positions), topology: OnceLock::new() }
    }

    /// Whether the same points are equal, of as many.
    pub(crate) fn are_those_of(&self, other: &Self) -> bool {
        self.firsts == other.firsts
    }

    /// The first point at the position of this one.
    pub(crate) fn first_at(&self, point: u32) -> u32 {
        self.firsts.as_ref().map_or(point, |firsts| firsts[point as usize])
    }

    /// The surfaces that `triangles` form; the same ones each time.
    pub(crate) fn topology(&self, triangles: &[[u32; 3]]) -> &Topology {
        self.topology
            .get_or_init(|| Topology::of(triangles.iter().map(|corners| corners.map(|corner| self.first_at(corner)))))
    }
}
