//! Convex bodies as boundary representations: faces, loops, edges, vertices.
//!
//! A convex face needs one loop. Half-edges are stored face by face, so a loop is a run of them; `twin` joins the two
//! half-edges of an edge.

use glam::DVec3;

use crate::{point::Point, predicates::side, ring::Sign};

/// Why a boundary representation is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BrepDefect {
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
    /// A vertex in front of a face.
    #[error("not convex: vertex {vertex} lies in front of face {face}")]
    NotConvex {
        /// Which face.
        face: usize,
        /// Which vertex.
        vertex: u32,
    },
    /// V − E + F is not 2.
    #[error("vertices − edges + faces is {0}, not 2")]
    Euler(i64),
}

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
    /// Checks and takes vertices (accepted numbers, local coordinates) and faces, each a loop of vertices,
    /// counter-clockwise seen from outside. Faces must be planar up to the rounding of their vertices; convexity is
    /// decided exactly on each face's first three vertices. O(faces · vertices).
    ///
    /// # Errors
    /// The first [`BrepDefect`].
    pub fn new(vertices: Vec<DVec3>, faces: &[Vec<u32>]) -> Result<Self, BrepDefect> {
        let mut half_edges = Vec::new();
        let mut loops = vec![0];
        for (face, corners) in faces.iter().enumerate() {
            let proper = corners.len() >= 3
                && corners.iter().enumerate().all(|(i, c)| (*c as usize) < vertices.len() && !corners[..i].contains(c));
            if !proper {
                return Err(BrepDefect::Loop { face });
            }
            half_edges.extend(corners.iter().map(|&start| HalfEdge { start, face: face as u32, twin: u32::MAX }));
            loops.push(half_edges.len() as u32);
        }
        let mut body = Self { vertices, half_edges, loops };
        body.join_twins()?;
        body.check_convex()?;
        let euler = body.vertices.len() as i64 - body.half_edges.len() as i64 / 2 + faces.len() as i64;
        if euler != 2 {
            return Err(BrepDefect::Euler(euler));
        }
        Ok(body)
    }

    fn join_twins(&mut self) -> Result<(), BrepDefect> {
        let mut ends: Vec<((u32, u32), u32)> =
            (0..self.half_edges.len() as u32).map(|h| ((self.half_edges[h as usize].start, self.end(h)), h)).collect();
        ends.sort_unstable();
        let find = |ends: &[((u32, u32), u32)], key| {
            let first = ends.partition_point(|entry| entry.0 < key);
            let count = ends[first..].iter().take_while(|entry| entry.0 == key).count();
            (count == 1).then(|| ends[first].1)
        };
        for &((from, to), half_edge) in &ends {
            let face = self.half_edges[half_edge as usize].face as usize;
            let open = BrepDefect::OpenEdge { face, from, to };
            find(&ends, (from, to)).ok_or(open)?;
            self.half_edges[half_edge as usize].twin = find(&ends, (to, from)).ok_or(open)?;
        }
        Ok(())
    }

    fn check_convex(&self) -> Result<(), BrepDefect> {
        for face in 0..self.face_count() {
            let corners: Vec<u32> = self.face(face).collect();
            let [a, b, c] = [0, 1, 2].map(|i| Point::exact(self.vertices[corners[i] as usize]));
            for vertex in 0..self.vertices.len() as u32 {
                let outside = side(&a, &b, &c, &Point::exact(self.vertices[vertex as usize])) == Sign::Positive;
                if outside && !corners.contains(&vertex) {
                    return Err(BrepDefect::NotConvex { face, vertex });
                }
            }
        }
        Ok(())
    }

    /// The vertices, local coordinates.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.loops.len() - 1
    }

    /// The vertices of a face's loop, counter-clockwise seen from outside.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn face(&self, face: usize) -> impl Iterator<Item = u32> + '_ {
        self.loop_of(face).map(|half_edge| self.half_edges[half_edge].start)
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

    /// The vertex a half-edge runs to.
    ///
    /// # Panics
    /// If there is no such half-edge.
    pub fn end(&self, half_edge: u32) -> u32 {
        let run = self.loop_of(self.half_edges[half_edge as usize].face as usize);
        let next = half_edge as usize + 1;
        self.half_edges[if next == run.end { run.start } else { next }].start
    }
}

/// A box centred at the local origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Edge lengths along x, y, z, metres; positive.
    pub size: [f64; 3],
}

impl Cuboid {
    /// The corner loops of the faces −x, +x, −y, +y, −z, +z; bit k of a corner's number picks the upper end of axis k.
    /// A face's parameter square has (0, 0) at its first corner, (1, 0) at its second and (0, 1) at its last.
    pub const FACES: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

    /// The eight corners, local coordinates; exact.
    pub fn corners(&self) -> [DVec3; 8] {
        let half = DVec3::from_array(self.size) * 0.5;
        std::array::from_fn(|i| {
            let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            half * DVec3::new(sign(0), sign(1), sign(2))
        })
    }

    /// The box as a boundary representation.
    ///
    /// # Errors
    /// [`BrepDefect`] when a size is not positive.
    pub fn brep(&self) -> Result<Brep, BrepDefect> {
        let faces: Vec<Vec<u32>> = Self::FACES.iter().map(|face| face.to_vec()).collect();
        Brep::new(self.corners().to_vec(), &faces)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> (Vec<DVec3>, Vec<Vec<u32>>) {
        let cube = Cuboid { size: [1.0, 2.0, 3.0] };
        (cube.corners().to_vec(), Cuboid::FACES.iter().map(|f| f.to_vec()).collect())
    }

    #[test]
    fn a_box_is_a_valid_convex_body() {
        let body = Cuboid { size: [1.0, 2.0, 3.0] }.brep().expect("a box");
        assert_eq!((body.vertices().len(), body.half_edges().len(), body.face_count()), (8, 24, 6));
        for h in 0..24 {
            let twin = body.half_edges()[h].twin;
            assert_eq!(body.half_edges()[twin as usize].twin as usize, h, "twins are mutual");
            assert_eq!(body.end(twin), body.half_edges()[h].start);
        }
    }

    #[test]
    fn defects_name_their_place() {
        let (vertices, mut faces) = cube();
        faces[3].reverse();
        assert!(matches!(Brep::new(vertices.clone(), &faces), Err(BrepDefect::OpenEdge { .. })));
        faces.remove(3);
        assert!(matches!(Brep::new(vertices, &faces), Err(BrepDefect::OpenEdge { .. })));
        let (mut vertices, faces) = cube();
        vertices[7] = DVec3::new(-2.0, -3.0, -4.0);
        assert!(matches!(Brep::new(vertices, &faces), Err(BrepDefect::NotConvex { .. })));
        let (vertices, mut faces) = cube();
        faces[0] = vec![0, 4, 4, 2];
        assert_eq!(Brep::new(vertices, &faces), Err(BrepDefect::Loop { face: 0 }));
    }
}
