//! Closed triangulated surfaces by half-edges, and the whole faces that their coplanar triangles make up.

use glam::DVec3;

use super::seed::normal_signs;
use crate::{point::Point, predicates::side, ring::Sign};

/// A closed surface of triangles. Half-edge 3t + i runs from corner i of triangle t to its next corner.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    /// Where each half-edge starts.
    pub(super) start: Vec<u32>,
    /// The half-edge that runs the other way.
    pub(super) twin: Vec<u32>,
}

impl Surface {
    /// Joins triangles to a closed surface.
    ///
    /// # Errors
    /// A half-edge without exactly one twin.
    pub(super) fn join(triangles: impl Iterator<Item = [u32; 3]>) -> Result<Self, u32> {
        let start: Vec<u32> = triangles.flatten().collect();
        let ends = (0..).zip(&start).map(|(half_edge, &from)| (from, start[Self::next(half_edge) as usize]));
        let (twin, open) = twins(ends);
        open.map_or(Ok(Self { start, twin }), Err)
    }

    pub(super) fn len(&self) -> usize {
        self.start.len() / 3
    }

    pub(super) fn next(half_edge: u32) -> u32 {
        if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 }
    }

    pub(super) fn triangle_of(half_edge: u32) -> u32 {
        half_edge / 3
    }

    pub(super) fn end(&self, half_edge: u32) -> u32 {
        self.start[Self::next(half_edge) as usize]
    }

    pub(super) fn corners(&self, triangle: u32) -> [u32; 3] {
        [0, 1, 2].map(|i| self.start[3 * triangle as usize + i])
    }

    /// The first triangle that does not hang together with triangle 0, if there is one.
    pub(super) fn first_apart(&self) -> Option<u32> {
        let across = |half_edge: u32| Self::triangle_of(self.twin[half_edge as usize]);
        first_apart(self.len(), |triangle| (3 * triangle..3 * triangle + 3).map(across))
    }

    /// The signs of each triangle's normal. Of triangles in one plane, those with equal signs face the same way.
    pub(super) fn normals(&self, positions: &[DVec3]) -> Vec<[Sign; 3]> {
        let normal = |triangle: u32| {
            let [a, b, c] = self.corners(triangle).map(|corner| positions[corner as usize]);
            normal_signs(a, b, c)
        };
        (0..self.len() as u32).map(normal).collect()
    }

    /// On which side of the triangle at a half-edge the far corner of the triangle across it lies; negative where the
    /// surface is convex.
    pub(super) fn bend(&self, positions: &[DVec3], half_edge: u32) -> Sign {
        let [a, b, c] = points(positions, self.corners(Self::triangle_of(half_edge)));
        let across = Self::next(Self::next(self.twin[half_edge as usize]));
        let [far] = points(positions, [self.start[across as usize]]);
        side(&a, &b, &c, &far)
    }

    /// The loops of the plane faces that the triangles make up, canonical: coplanar neighbours become one face, and
    /// corners where only two faces meet are left out. A face with holes gives several loops.
    pub(super) fn whole_faces(&self, positions: &[DVec3]) -> Vec<Vec<u32>> {
        let face_of = self.coplanar_groups(positions);
        let face_at = |half_edge: u32| face_of[Self::triangle_of(half_edge) as usize];
        let face_across = |half_edge: u32| face_at(self.twin[half_edge as usize]);
        let mut walked = vec![false; self.start.len()];
        let mut loops = Vec::new();
        for first in 0..self.start.len() as u32 {
            if walked[first as usize] || face_at(first) == face_across(first) {
                continue;
            }
            let (mut corners, mut half_edge) = (Vec::new(), first);
            while !std::mem::replace(&mut walked[half_edge as usize], true) {
                // Around the end of this half-edge, inside the face, to the next one on its border.
                let mut next = Self::next(half_edge);
                while face_at(next) == face_across(next) {
                    next = Self::next(self.twin[next as usize]);
                }
                if face_across(half_edge) != face_across(next) {
                    corners.push(self.start[next as usize]);
                }
                half_edge = next;
            }
            loops.push(canonical_loop(corners));
        }
        loops.sort_unstable();
        loops
    }

    /// The number of each triangle's plane face: neighbours share it where the edge between them does not bend.
    fn coplanar_groups(&self, positions: &[DVec3]) -> Vec<u32> {
        let mut group_of = vec![u32::MAX; self.len()];
        let mut open = Vec::new();
        for first in 0..self.len() as u32 {
            if group_of[first as usize] != u32::MAX {
                continue;
            }
            open.push(first);
            while let Some(triangle) = open.pop() {
                if std::mem::replace(&mut group_of[triangle as usize], first) == first {
                    continue;
                }
                for half_edge in 3 * triangle..3 * triangle + 3 {
                    let across = Self::triangle_of(self.twin[half_edge as usize]);
                    if group_of[across as usize] == u32::MAX && self.bend(positions, half_edge) == Sign::Zero {
                        open.push(across);
                    }
                }
            }
        }
        group_of
    }
}

/// The first of `count` faces that cannot be reached from face 0 from neighbour to neighbour, if there is one.
pub(super) fn first_apart<N: IntoIterator<Item = u32>>(count: usize, neighbours: impl Fn(u32) -> N) -> Option<u32> {
    let mut is_reached = vec![false; count];
    let mut open = vec![0];
    while let Some(face) = open.pop() {
        if !std::mem::replace(&mut is_reached[face as usize], true) {
            open.extend(neighbours(face).into_iter().filter(|&next| !is_reached[next as usize]));
        }
    }
    is_reached.iter().position(|&reached| !reached).map(|face| face as u32)
}

/// The twin of each half-edge, given by its ends; and the least half-edge on an edge that is not used exactly once each
/// way, if there is one.
pub(super) fn twins(ends: impl Iterator<Item = (u32, u32)>) -> (Vec<u32>, Option<u32>) {
    let mut uses: Vec<(u32, u32, bool, u32)> =
        (0..).zip(ends).map(|(half_edge, (from, to))| (from.min(to), from.max(to), from > to, half_edge)).collect();
    uses.sort_unstable();
    let mut twin = vec![u32::MAX; uses.len()];
    let mut open = None;
    for edge in uses.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        match *edge {
            [(from, to, false, there), (_, _, true, back)] if from != to => {
                (twin[there as usize], twin[back as usize]) = (back, there);
            }
            _ => open = edge.iter().map(|usage| usage.3).chain(open).min(),
        }
    }
    (twin, open)
}

/// The positions of some vertices, ready for predicates.
pub(super) fn points<const N: usize>(positions: &[DVec3], vertices: [u32; N]) -> [Point<'static>; N] {
    vertices.map(|vertex| Point::exact(positions[vertex as usize]))
}

/// The same loop of vertices, begun at its least one.
pub fn canonical_loop(mut corners: Vec<u32>) -> Vec<u32> {
    if let Some(least) = (0..corners.len()).min_by_key(|&i| corners[i]) {
        corners.rotate_left(least);
    }
    corners
}
