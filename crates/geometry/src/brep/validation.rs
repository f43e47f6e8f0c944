//! When is a list of polygons the boundary of a convex body? When its faces are the faces of the hull of its vertices.
//!
//! Local tests alone do not decide that: a surface may be convex at every edge and yet wind twice around its inside, as
//! over a pentagram (Mehlhorn et al., "Checking geometric programs or verification of geometric structures",
//! Computational Geometry 12, 1999). Here the structure is checked first, so that errors name their element, and then
//! every face is looked up among those of the exact hull. A closed set of distinct faces of the hull is all of them.
//! O(n log n); only a refusal may cost faces · vertices.

use glam::DVec3;

use super::{
    Brep, Flatness, HalfEdge, hull,
    surface::{canonical_loop, first_apart, twins},
};
use crate::{
    number::{AXES, NumberDefect, accept_point},
    predicates::side,
    ring::Sign,
    topology::unify,
};

/// Why a boundary representation is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BrepDefect {
    /// A coordinate outside the accepted range.
    #[error("vertex {vertex}: coordinate {} {defect}", AXES[*.axis])]
    Coordinate {
        /// Which vertex.
        vertex: usize,
        /// 0, 1 or 2.
        axis: usize,
        /// What is wrong with it.
        defect: NumberDefect,
    },
    /// More vertices or corners of faces than 32-bit indices can name.
    #[error("more than 2^32 - 2 vertices or corners of faces")]
    TooMany,
    /// A loop with fewer than three vertices, or one that names a vertex twice or one that is not there.
    #[error("face {face}: its loop is not a polygon of the body's vertices")]
    Loop {
        /// Which face.
        face: usize,
    },
    /// An edge without exactly one twin that runs the other way.
    #[error("face {face}: the edge from vertex {from} to vertex {to} has no single twin")]
    OpenEdge {
        /// A face with that edge.
        face: usize,
        /// First vertex.
        from: u32,
        /// Second vertex.
        to: u32,
    },
    /// A vertex of no face.
    #[error("vertex {vertex} belongs to no face")]
    Unused {
        /// Which vertex.
        vertex: u32,
    },
    /// Two vertices at one position.
    #[error("vertices {first} and {second} have the same position")]
    Coincident {
        /// The one.
        first: u32,
        /// The other.
        second: u32,
    },
    /// A face that does not hang together with face 0.
    #[error("face {face} does not hang together with face 0")]
    Apart {
        /// Which face.
        face: usize,
    },
    /// V − E + F is not 2: the surface touches itself at a vertex, or has a hole through it.
    #[error("vertices − edges + faces is {0}, not 2")]
    Euler(i64),
    /// The body has no interior.
    #[error("the body is flat: {0}")]
    Flat(Flatness),
    /// A corner that does not lie in the plane of its face's first three corners.
    #[error("face {face} is not planar: vertex {vertex} lies off its plane")]
    NotPlanar {
        /// Which face.
        face: usize,
        /// Which vertex.
        vertex: u32,
    },
    /// A vertex in front of a face.
    #[error("not convex: vertex {vertex} lies in front of face {face}")]
    NotConvex {
        /// Which face.
        face: usize,
        /// Which vertex.
        vertex: u32,
    },
    /// A face that is not all of a side of the body: a neighbour lies in its plane, or a corner on a straight edge.
    #[error("face {face} is not a whole face: a neighbour lies in its plane, or a corner lies on a straight edge")]
    Partial {
        /// Which face.
        face: usize,
    },
}

impl Brep {
    /// Checks and takes vertices and faces, each a loop of vertices, counter-clockwise seen from outside. Vertices and
    /// faces keep their order and each loop its first corner.
    ///
    /// Everything is decided exactly on the numbers given. A face of more than three corners whose coordinates were
    /// rounded is hardly ever planar; [`Brep::hull`] of its vertices cuts it as the numbers say. O(n log n).
    ///
    /// # Errors
    /// The first [`BrepDefect`], in the order in which they are declared.
    pub fn new(vertices: Vec<DVec3>, faces: &[Vec<u32>]) -> Result<Self, BrepDefect> {
        let vertices = accept_vertices(&vertices)?;
        check_loops(&vertices, faces)?;
        let (body, open) = Self::assemble(vertices, faces);
        if let Some(half_edge) = open {
            let HalfEdge { start: from, face, .. } = body.half_edges[half_edge as usize];
            return Err(BrepDefect::OpenEdge { face: face as usize, from, to: body.end(half_edge) });
        }
        body.check_vertices()?;
        body.check_connected()?;
        body.check_hull()?;
        Ok(body)
    }

    /// Joins proper loops over `vertices`. Also the least half-edge that has no single twin, if there is one.
    pub(super) fn assemble(vertices: Vec<DVec3>, faces: &[Vec<u32>]) -> (Self, Option<u32>) {
        let (mut half_edges, mut loops) = (Vec::new(), vec![0]);
        for (face, corners) in faces.iter().enumerate() {
            half_edges.extend(corners.iter().map(|&start| HalfEdge { start, face: face as u32, twin: u32::MAX }));
            loops.push(half_edges.len() as u32);
        }
        let mut body = Self { vertices, half_edges, loops };
        let ends = (0..).zip(&body.half_edges).map(|(half_edge, at)| (at.start, body.end(half_edge)));
        let (twin_of, open) = twins(ends);
        for (half_edge, twin) in body.half_edges.iter_mut().zip(twin_of) {
            half_edge.twin = twin;
        }
        (body, open)
    }

    fn check_vertices(&self) -> Result<(), BrepDefect> {
        let mut used = vec![false; self.vertices.len()];
        self.half_edges.iter().for_each(|half_edge| used[half_edge.start as usize] = true);
        if let Some(vertex) = used.iter().position(|used| !used) {
            return Err(BrepDefect::Unused { vertex: vertex as u32 });
        }
        let (distinct, place) = unify(&self.vertices);
        let mut vertex_at = vec![u32::MAX; distinct.len()];
        for (second, &place) in (0..).zip(&place) {
            let first = std::mem::replace(&mut vertex_at[place as usize], second);
            if first != u32::MAX {
                return Err(BrepDefect::Coincident { first, second });
            }
        }
        Ok(())
    }

    fn check_connected(&self) -> Result<(), BrepDefect> {
        let across = |half_edge: usize| self.half_edges[self.half_edges[half_edge].twin as usize].face;
        if self.face_count() > 0
            && let Some(face) = first_apart(self.face_count(), |face| self.loop_of(face as usize).map(across))
        {
            return Err(BrepDefect::Apart { face: face as usize });
        }
        let euler = self.vertices.len() as i64 - self.edge_count() as i64 + self.face_count() as i64;
        if euler == 2 { Ok(()) } else { Err(BrepDefect::Euler(euler)) }
    }

    /// Looks every face up among the faces of the hull of the vertices.
    fn check_hull(&self) -> Result<(), BrepDefect> {
        let (positions, place) = unify(&self.vertices);
        let expected = hull::faces(&positions).map_err(BrepDefect::Flat)?;
        let wrong: Vec<usize> = (0..self.face_count())
            .filter(|&face| {
                let corners = canonical_loop(self.face(face).map(|vertex| place[vertex as usize]).collect());
                expected.binary_search(&corners).is_err()
            })
            .collect();
        let Some(&face) = wrong.first() else { return Ok(()) };
        let first = |defect: fn(&Self, usize) -> Option<BrepDefect>| wrong.iter().find_map(|&face| defect(self, face));
        Err(first(Self::bend_of).or_else(|| first(Self::vertex_before)).unwrap_or(BrepDefect::Partial { face }))
    }

    /// A corner of a face off its plane.
    fn bend_of(&self, face: usize) -> Option<BrepDefect> {
        let [a, b, c] = self.plane(face);
        let mut corners = self.face(face);
        let vertex = corners.find(|&vertex| side(&a, &b, &c, &self.vertex(vertex)) != Sign::Zero)?;
        Some(BrepDefect::NotPlanar { face, vertex })
    }

    /// A vertex in front of a face.
    fn vertex_before(&self, face: usize) -> Option<BrepDefect> {
        let [a, b, c] = self.plane(face);
        let mut vertices = 0..self.vertices.len() as u32;
        let vertex = vertices.find(|&vertex| side(&a, &b, &c, &self.vertex(vertex)) == Sign::Positive)?;
        Some(BrepDefect::NotConvex { face, vertex })
    }
}

fn accept_vertices(vertices: &[DVec3]) -> Result<Vec<DVec3>, BrepDefect> {
    let accepted = vertices.iter().enumerate().map(|(vertex, position)| {
        accept_point(position.to_array()).map_err(|(axis, defect)| BrepDefect::Coordinate { vertex, axis, defect })
    });
    accepted.collect()
}

fn check_loops(vertices: &[DVec3], faces: &[Vec<u32>]) -> Result<(), BrepDefect> {
    let corners: usize = faces.iter().map(Vec::len).sum();
    if vertices.len() >= u32::MAX as usize || corners >= u32::MAX as usize {
        return Err(BrepDefect::TooMany);
    }
    // The last face that named each vertex.
    let mut named_by = vec![usize::MAX; vertices.len()];
    for (face, corners) in faces.iter().enumerate() {
        let mut is_new = |&vertex: &u32| match named_by.get_mut(vertex as usize) {
            Some(last) => std::mem::replace(last, face) != face,
            None => false,
        };
        if corners.len() < 3 || !corners.iter().all(&mut is_new) {
            return Err(BrepDefect::Loop { face });
        }
    }
    Ok(())
}
