//! The exact convex hull of points (quickhull: Barber, Dobkin and Huhdanpaa, "The quickhull algorithm for convex hulls",
//! ACM TOMS 22, 1996), with exact signs in place of its facet thickness.
//!
//! The surface of the hull so far is kept as triangles; coplanar ones may lie side by side. A point outside waits at one
//! triangle that it lies strictly in front of. The farthest one of a triangle is added: the triangles strictly before it
//! go, and new ones join it to their border, the horizon. In the end coplanar triangles become whole faces.
//!
//! Why degenerate points need no care of their own:
//! - The faces strictly before a point outside are a disc, so the horizon is one simple cycle.
//! - No new triangle is without area: a point on the line of a horizon edge lies in the planes of both its faces, but one
//!   of them is strictly before it.
//! - New triangles may lie in the plane of an old face: they extend it exactly by what the point sees of it.
//! - A point that waits at a triangle that goes either lies in the new hull or strictly before a new triangle: what it
//!   sees is connected, so it crosses the horizon somewhere, and the new plane there lies between the two old ones.
//!
//! About n log n steps in practice, n² at worst; memory for about two triangles a vertex and a number a point. Signs that floats cannot tell
//! (points in the plane of a face) take microseconds each.

use std::collections::VecDeque;

use glam::DVec3;

use super::{Brep, Flatness, seed, surface::Surface, surface::points};
use crate::{
    number::{AXES, NumberDefect, accept_point},
    predicates::{Target, side_value},
    topology::unify,
};

/// Why points have no hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum HullDefect {
    /// A coordinate outside the accepted range.
    #[error("point {point}: coordinate {} {defect}", AXES[*.axis])]
    Coordinate {
        /// Which point.
        point: usize,
        /// 0, 1 or 2.
        axis: usize,
        /// What is wrong with it.
        defect: NumberDefect,
    },
    /// More points than 32-bit indices can name.
    #[error("more than 2^28 points")]
    TooMany,
    /// No four points span space.
    #[error(transparent)]
    Flat(#[from] Flatness),
}

/// More points might make more half-edges than 32 bits can number.
const MAX_POINTS: usize = 1 << 28;

impl Brep {
    /// The convex hull of points, decided exactly.
    ///
    /// Points may repeat, lie inside, on faces or on edges; their order does not matter. The vertices are the extreme
    /// points in lexicographic order of their coordinates. Coplanar points make one face. A loop starts at its first
    /// vertex in that order, and faces are in lexicographic order of their loops.
    ///
    /// About O(n log n).
    ///
    /// # Errors
    /// [`HullDefect`].
    pub fn hull(points: impl IntoIterator<Item = DVec3>) -> Result<Self, HullDefect> {
        let accepted = points.into_iter().enumerate().map(|(point, position)| {
            accept_point(position.to_array()).map_err(|(axis, defect)| HullDefect::Coordinate { point, axis, defect })
        });
        let accepted = accepted.collect::<Result<Vec<_>, _>>()?;
        if accepted.len() > MAX_POINTS {
            return Err(HullDefect::TooMany);
        }
        let (positions, _) = unify(&accepted);
        let mut loops = faces(&positions)?;
        let vertices = keep_used(&positions, &mut loops);
        // The faces of a hull leave no edge open.
        Ok(Self::assemble(vertices, &loops).0)
    }
}

/// The whole faces of the hull of distinct positions in lexicographic order: canonical loops, sorted.
pub(super) fn faces(positions: &[DVec3]) -> Result<Vec<Vec<u32>>, Flatness> {
    let mut hull = Hull::start(positions, seed::tetrahedron(positions)?);
    while let Some(triangle) = hull.pending.pop_front() {
        if let Some(apex) = hull.waiting[triangle as usize].farthest() {
            hull.add(triangle, apex);
        }
    }
    Ok(hull.finished().whole_faces(positions))
}

/// The positions that loops name, in order; the loops are renumbered.
pub(super) fn keep_used(positions: &[DVec3], loops: &mut [Vec<u32>]) -> Vec<DVec3> {
    let mut number = vec![u32::MAX; positions.len()];
    loops.iter().flatten().for_each(|&vertex| number[vertex as usize] = 0);
    let mut vertices = Vec::new();
    for (position, number) in positions.iter().zip(&mut number).filter(|(_, number)| **number == 0) {
        *number = vertices.len() as u32;
        vertices.push(*position);
    }
    loops.iter_mut().flatten().for_each(|vertex| *vertex = number[*vertex as usize]);
    vertices
}

/// Points strictly in front of one triangle, the farthest one last.
#[derive(Clone, Debug, Default)]
struct Waiting {
    points: Vec<u32>,
    greatest_distance: f64,
}

impl Waiting {
    fn push(&mut self, point: u32, distance: f64) {
        self.points.push(point);
        if distance > self.greatest_distance {
            self.greatest_distance = distance;
        } else if let [.., farthest, new] = self.points.as_mut_slice() {
            std::mem::swap(farthest, new);
        }
    }

    fn farthest(&self) -> Option<u32> {
        self.points.last().copied()
    }
}

/// The hull of the points added so far.
struct Hull<'a> {
    positions: &'a [DVec3],
    surface: Surface,
    is_alive: Vec<bool>,
    /// Triangles that went; new ones take their places.
    gone: Vec<u32>,
    waiting: Vec<Waiting>,
    /// Triangles that may have points waiting, the oldest first: the hull grows on all sides alike, which keeps the number
    /// of triangles around a vertex, and so the work for a point that waits, small.
    pending: VecDeque<u32>,
    /// The new triangle whose horizon edge starts at a vertex; of use only while a point is added.
    on_horizon: Vec<u32>,
}

impl<'a> Hull<'a> {
    fn start(positions: &'a [DVec3], [a, b, c, d]: [u32; 4]) -> Self {
        let start = vec![a, b, c, b, a, d, c, b, d, a, c, d];
        let twin = vec![3, 6, 9, 0, 11, 7, 1, 5, 10, 2, 8, 4];
        let mut hull = Self {
            positions,
            surface: Surface { start, twin },
            is_alive: vec![true; 4],
            gone: Vec::new(),
            waiting: vec![Waiting::default(); 4],
            pending: (0..4).collect(),
            on_horizon: vec![0; positions.len()],
        };
        hull.assign(0..positions.len() as u32, &[0, 1, 2, 3]);
        hull
    }

    /// Twice the area of a triangle times the height of a point above it; the sign is exact.
    fn height(&self, triangle: u32, point: u32) -> f64 {
        let [a, b, c] = points(self.positions, self.surface.corners(triangle));
        let [x] = points(self.positions, [point]);
        side_value(&a, &b, &c, Target::Point(&x)).value
    }

    /// Lets each point wait at the first of the triangles that it lies strictly in front of; drops it if there is none.
    fn assign(&mut self, points: impl IntoIterator<Item = u32>, triangles: &[u32]) {
        for point in points {
            let mut heights = triangles.iter().map(|&triangle| (triangle, self.height(triangle, point)));
            if let Some((triangle, height)) = heights.find(|&(_, height)| height > 0.0) {
                self.waiting[triangle as usize].push(point, height);
            }
        }
    }

    /// Adds a point that lies strictly in front of a triangle.
    fn add(&mut self, triangle: u32, apex: u32) {
        let (horizon, orphans) = self.remove_before(triangle, apex);
        let corners = |outer: u32| [self.surface.end(outer), self.surface.start[outer as usize], apex];
        let sides: Vec<[u32; 3]> = horizon.iter().map(|&outer| corners(outer)).collect();
        let new: Vec<u32> = sides.into_iter().map(|side| self.place(side)).collect();
        for (&triangle, &outer) in new.iter().zip(&horizon) {
            self.pair(3 * triangle, outer);
            let following = self.on_horizon[self.surface.start[outer as usize] as usize];
            self.pair(3 * triangle + 1, 3 * following + 2);
        }
        self.pending.extend(&new);
        self.assign(orphans.into_iter().filter(|&point| point != apex), &new);
    }

    /// Removes the triangles strictly before a point, from one of them on. The half-edges that stay along the horizon,
    /// and the points that waited at what went.
    fn remove_before(&mut self, triangle: u32, apex: u32) -> (Vec<u32>, Vec<u32>) {
        let (mut horizon, mut orphans) = (Vec::new(), Vec::new());
        let mut open = vec![triangle];
        self.is_alive[triangle as usize] = false;
        while let Some(triangle) = open.pop() {
            self.gone.push(triangle);
            orphans.append(&mut std::mem::take(&mut self.waiting[triangle as usize]).points);
            for half_edge in 3 * triangle..3 * triangle + 3 {
                let outer = self.surface.twin[half_edge as usize];
                let across = Surface::triangle_of(outer);
                if !self.is_alive[across as usize] {
                    continue;
                }
                if self.height(across, apex) > 0.0 {
                    self.is_alive[across as usize] = false;
                    open.push(across);
                } else {
                    horizon.push(outer);
                }
            }
        }
        (horizon, orphans)
    }

    /// Puts the triangle from a horizon edge to the apex where one has gone, or at the end; its edges are paired later.
    fn place(&mut self, corners: [u32; 3]) -> u32 {
        let triangle = self.gone.pop().unwrap_or_else(|| {
            let new = self.surface.len() as u32;
            self.surface.start.extend(corners);
            self.surface.twin.extend([u32::MAX; 3]);
            self.is_alive.push(true);
            self.waiting.push(Waiting::default());
            new
        });
        let first = 3 * triangle as usize;
        self.surface.start[first..first + 3].copy_from_slice(&corners);
        self.is_alive[triangle as usize] = true;
        self.on_horizon[corners[0] as usize] = triangle;
        triangle
    }

    fn pair(&mut self, half_edge: u32, twin: u32) {
        self.surface.twin[half_edge as usize] = twin;
        self.surface.twin[twin as usize] = half_edge;
    }

    /// The surface without the triangles that went.
    fn finished(self) -> Surface {
        let alive = (0..self.surface.len()).filter(|&triangle| self.is_alive[triangle]);
        let mut number = vec![u32::MAX; self.surface.len()];
        for (new, triangle) in (0..).zip(alive) {
            number[triangle] = new;
        }
        let kept = (0..self.surface.start.len()).filter(|half_edge| self.is_alive[half_edge / 3]);
        let renumbered = |half_edge: u32| 3 * number[half_edge as usize / 3] + half_edge % 3;
        let (start, twin) =
            kept.map(|half_edge| (self.surface.start[half_edge], renumbered(self.surface.twin[half_edge]))).unzip();
        Surface { start, twin }
    }
}
