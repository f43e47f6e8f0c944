//! Convex bodies as boundary representations: faces, loops, edges, vertices.
//!
//! The structure is the half-edge form of Müller and Preparata ("Finding the intersection of two convex polyhedra",
//! Theoretical Computer Science 7, 1978). A convex face needs one loop. Half-edges are stored face by face, so a loop is
//! a run of them; `twin` joins the two half-edges of an edge.
//!
//! A [`Brep`] is always the whole boundary of one convex body with interior, by exact signs: every face is a planar,
//! strictly convex polygon, no two faces lie in one plane, no vertex lies on an edge or in a face. So any three corners
//! of a face span its plane, and V − E + F = 2. It is made from points ([`Brep::hull`]), half-spaces
//! ([`Brep::of_half_spaces`]), a convex mesh ([`Brep::of_mesh`]), a box ([`Cuboid::brep`]) or its own faces
//! ([`Brep::new`]).

use glam::DVec3;

use crate::{Aabb, point::Point};

mod convex;
mod convex_mesh;
mod cuboid;
mod half_spaces;
mod hull;
mod seed;
mod silhouette;
mod surface;
#[cfg(test)]
mod tests;
mod validation;

pub use convex::Convex;
pub use convex_mesh::ConvexMeshDefect;
pub use cuboid::Cuboid;
pub use half_spaces::{HalfSpace, HalfSpaceDefect};
pub use hull::HullDefect;
pub use seed::Flatness;
pub use silhouette::Silhouette;
pub use surface::canonical_loop;
pub use validation::BrepDefect;

/// A half-edge: it starts at `start` and runs to the start of the next half-edge of its loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HalfEdge {
    /// Vertex it starts from.
    pub start: u32,
    /// The face on its left.
    pub face: u32,
    /// The half-edge of the same edge that runs the other way.
    pub twin: u32,
}

/// A closed convex body.
#[derive(Clone, Debug, PartialEq)]
pub struct Brep {
    vertices: Vec<DVec3>,
    half_edges: Vec<HalfEdge>,
    /// Where each face's loop begins in `half_edges`; one more entry at the end.
    loops: Vec<u32>,
}

impl Brep {
    /// The vertices, in the coordinates that the body was made from.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.loops.len() - 1
    }

    /// Number of edges.
    pub fn edge_count(&self) -> usize {
        self.half_edges.len() / 2
    }

    /// The vertices of a face's loop, counter-clockwise seen from outside.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn face(&self, face: usize) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.half_edges[self.loop_of(face)].iter().map(|half_edge| half_edge.start)
    }

    /// The half-edges, face by face.
    pub fn half_edges(&self) -> &[HalfEdge] {
        &self.half_edges
    }

    /// The half-edges of a face, as a range of [`Brep::half_edges`].
    ///
    /// # Panics
    /// If there is no such face.
    pub fn loop_of(&self, face: usize) -> std::ops::Range<usize> {
        self.loops[face] as usize..self.loops[face + 1] as usize
    }

    /// The half-edge that follows in the same loop.
    ///
    /// # Panics
    /// If there is no such half-edge.
    pub fn next(&self, half_edge: u32) -> u32 {
        let run = self.loop_of(self.half_edges[half_edge as usize].face as usize);
        let next = half_edge as usize + 1;
        if next == run.end { run.start as u32 } else { next as u32 }
    }

    /// The vertex a half-edge runs to.
    ///
    /// # Panics
    /// If there is no such half-edge.
    pub fn end(&self, half_edge: u32) -> u32 {
        self.half_edges[self.next(half_edge) as usize].start
    }

    /// The faces cut into triangles: each face, in order, as a fan from its first corner. No triangle is without area.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        (0..self.face_count()).flat_map(|face| {
            let corners = &self.half_edges[self.loop_of(face)];
            corners[1..].windows(2).map(|edge| [corners[0].start, edge[0].start, edge[1].start])
        })
    }

    /// The box of the vertices.
    pub fn bounds(&self) -> Aabb {
        Aabb::of(self.vertices.iter().copied())
    }

    /// Three corners that span a face's plane, its outside in front of them.
    fn plane(&self, face: usize) -> [Point<'static>; 3] {
        let first = self.loop_of(face).start;
        [0, 1, 2].map(|corner| self.vertex(self.half_edges[first + corner].start))
    }

    /// A vertex, ready for predicates.
    fn vertex(&self, vertex: u32) -> Point<'static> {
        Point::exact(self.vertices[vertex as usize])
    }
}
