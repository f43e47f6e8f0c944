//! Convex bodies from triangle meshes: coplanar triangles become whole faces.
//!
//! Vertices with equal coordinates are one vertex; triangles that name one vertex twice are dropped. The rest must be a
//! closed surface, convex at every edge, and wind once around its inside. Exact; O(n log n).

use super::{Brep, BrepDefect, Flatness, surface::Surface};
use crate::{Mesh, ring::Sign, topology::unify};

/// Why a mesh is not the boundary of a convex body. Vertices and triangles are those of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ConvexMeshDefect {
    /// The mesh has no interior.
    #[error("the mesh is flat: {0}")]
    Flat(Flatness),
    /// An edge that is not used exactly once each way.
    #[error("triangle {triangle}: the edge from vertex {from} to vertex {to} is not used exactly once each way")]
    OpenEdge {
        /// A triangle with that edge.
        triangle: usize,
        /// First vertex.
        from: u32,
        /// Second vertex.
        to: u32,
    },
    /// A triangle whose three different corners lie on one line: it has no plane that could be compared.
    #[error("triangle {triangle} has no area")]
    NoArea {
        /// Which triangle.
        triangle: usize,
    },
    /// An edge at which the surface bends inward.
    #[error("triangle {triangle}: the surface bends inward at the edge from vertex {from} to vertex {to}")]
    InwardBend {
        /// A triangle with that edge.
        triangle: usize,
        /// First vertex.
        from: u32,
        /// Second vertex.
        to: u32,
    },
    /// Convex at every edge, yet in several pieces, or winding more than once.
    #[error("convex at every edge, but in several pieces or winding more than once around its inside")]
    NotOnce,
}

impl Brep {
    /// The body whose boundary a mesh is: vertices, faces and loops in the order of [`Brep::hull`].
    ///
    /// # Errors
    /// [`ConvexMeshDefect`], with a place in the mesh.
    pub fn of_mesh(mesh: &Mesh) -> Result<Self, ConvexMeshDefect> {
        let (positions, place) = unify(mesh.positions());
        let place_all = |corners: [u32; 3]| corners.map(|corner| place[corner as usize]);
        // The mesh's triangle behind each one that is kept.
        let kept: Vec<usize> = (0..mesh.triangles().len())
            .filter(|&triangle| {
                let [a, b, c] = place_all(mesh.triangles()[triangle]);
                a != b && b != c && c != a
            })
            .collect();
        if kept.is_empty() {
            return Err(ConvexMeshDefect::Flat(Flatness::Nothing));
        }
        let edge = |half_edge: u32| {
            let (triangle, corner) = (kept[half_edge as usize / 3], half_edge as usize % 3);
            let corners = mesh.triangles()[triangle];
            (triangle, corners[corner], corners[(corner + 1) % 3])
        };
        let surface = Surface::join(kept.iter().map(|&triangle| place_all(mesh.triangles()[triangle])))
            .map_err(edge)
            .map_err(|(triangle, from, to)| ConvexMeshDefect::OpenEdge { triangle, from, to })?;
        if let Some(flat) = (0..kept.len()).find(|&i| surface.has_no_area(&positions, i as u32)) {
            return Err(ConvexMeshDefect::NoArea { triangle: kept[flat] });
        }
        let half_edges = 0..3 * kept.len() as u32;
        if let Some(half_edge) = half_edges.into_iter().find(|&h| surface.bend(&positions, h) == Sign::Positive) {
            let (triangle, from, to) = edge(half_edge);
            return Err(ConvexMeshDefect::InwardBend { triangle, from, to });
        }
        let mut faces = surface.whole_faces(&positions);
        let vertices = super::hull::keep_used(&positions, &mut faces);
        Self::new(vertices, &faces).map_err(|defect| match defect {
            BrepDefect::Flat(flatness) => ConvexMeshDefect::Flat(flatness),
            _ => ConvexMeshDefect::NotOnce,
        })
    }
}
