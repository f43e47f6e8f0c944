//! Convex bodies from triangle meshes: coplanar triangles become whole faces.
//!
//! Vertices with equal coordinates are one vertex; triangles that name one vertex twice are dropped. The rest must be a
//! closed surface, convex at every edge, without folds, whose plane faces are those of the hull ([`Brep::new`]). That
//! suffices: the triangles of a plane face then all turn the same way, and their common border is one convex polygon, so
//! they cover it once and nothing beside it. Exact; O(n log n), memory for some copies of the mesh.

use glam::DVec3;

use super::{Brep, BrepDefect, Flatness, hull::keep_used, surface::Surface};
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
    /// An edge at which the surface folds back into its own plane.
    #[error("triangle {triangle}: the surface folds back on itself at the edge from vertex {from} to vertex {to}")]
    Fold {
        /// A triangle with that edge.
        triangle: usize,
        /// First vertex.
        from: u32,
        /// Second vertex.
        to: u32,
    },
    /// A triangle that does not hang together with the first one.
    #[error("triangle {triangle} does not hang together with the first one")]
    Apart {
        /// Which triangle.
        triangle: usize,
    },
    /// Convex at every edge, yet wound more than once, as over a pentagram.
    #[error("the surface winds more than once around its inside, at vertex {vertex} for one")]
    Wound {
        /// A vertex where this shows.
        vertex: u32,
    },
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
        let normals = surface.normals(&positions);
        if let Some(flat) = normals.iter().position(|normal| *normal == [Sign::Zero; 3]) {
            return Err(ConvexMeshDefect::NoArea { triangle: kept[flat] });
        }
        for half_edge in 0..surface.start.len() as u32 {
            let (triangle, from, to) = edge(half_edge);
            let turns = |half_edge: u32| normals[Surface::triangle_of(half_edge) as usize];
            match surface.bend(&positions, half_edge) {
                Sign::Positive => return Err(ConvexMeshDefect::InwardBend { triangle, from, to }),
                Sign::Zero if turns(half_edge) != turns(surface.twin[half_edge as usize]) => {
                    return Err(ConvexMeshDefect::Fold { triangle, from, to });
                }
                _ => {}
            }
        }
        if let Some(apart) = surface.first_apart() {
            return Err(ConvexMeshDefect::Apart { triangle: kept[apart as usize] });
        }
        Self::of_locally_convex(&surface, &positions).map_err(|defect| match defect {
            Wound::Flat(flatness) => ConvexMeshDefect::Flat(flatness),
            Wound::At(position) => {
                let vertex = mesh.positions().iter().position(|&other| other == position).unwrap_or(0) as u32;
                ConvexMeshDefect::Wound { vertex }
            }
        })
    }

    /// The body of a connected surface that is convex at every edge.
    fn of_locally_convex(surface: &Surface, positions: &[DVec3]) -> Result<Self, Wound> {
        let mut faces = surface.whole_faces(positions);
        let vertices = keep_used(positions, &mut faces);
        Self::new(vertices.clone(), &faces).map_err(|defect| match defect {
            BrepDefect::Flat(flatness) => Wound::Flat(flatness),
            BrepDefect::NotConvex { vertex, .. } => Wound::At(vertices[vertex as usize]),
            _ => Wound::At(positions[surface.start[0] as usize]),
        })
    }
}

/// What keeps a surface that is convex at every edge from being a body.
enum Wound {
    Flat(Flatness),
    At(DVec3),
}
