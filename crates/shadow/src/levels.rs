//! Detail in the user's terms, as levels of a face's parameter square.
//!
//! At depth d an object's octree has cells with its bounding cube's edge / 2^d. A face is divided until none of its
//! cells reaches farther than that, from any of its points to any other: so a cell always fits a leaf.

use glam::DVec3;
use umbriel_geometry::{Aabb, Placement, Point, analytic::Chart, length_squared};
use umbriel_octree::Octant;

use crate::{
    fine::flat::{Levels, PixelStop},
    request::Detail,
};

/// The deepest octree: 21 levels, three axes of 21 bits in a 64-bit Morton code.
pub(crate) const MAX_DEPTH: u8 = Octant::MAX_LEVEL;

/// The source's depth for borders.
pub(crate) const TYPICAL_DEPTH: u8 = 8;

/// The lengths of a face that its division depends on, metres, rounded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceSize {
    /// Edges along the two parameters.
    pub(crate) edges: [f64; 2],
    /// Longest edge.
    longest_edge: f64,
    /// Greatest distance of two points of the whole face.
    whole: f64,
    /// Greatest distance of two points of a square cell, times 2^level.
    square: f64,
    /// The box of a flat face.
    bounds: Option<Aabb>,
}

impl FaceSize {
    /// Of a flat face with these corners (first, second, …, last).
    pub(crate) fn of_flat(corners: &[Point], is_triangle: bool) -> Self {
        let bounds = Some(Aabb::of(corners.iter().map(|corner| corner.position)));
        let [a, b, d] = [0, 1, corners.len() - 1].map(|k| corners[k].position);
        let edges = [length(b - a), length(d - a)];
        let (falling, rising) = (length(b - d), length((b - a) + (d - a)));
        let longest_edge = edges[0].max(edges[1]);
        let square = falling.max(rising);
        if is_triangle {
            let longest_edge = longest_edge.max(falling);
            Self { edges, longest_edge, whole: longest_edge, square, bounds }
        } else {
            Self { edges, longest_edge, whole: square, square, bounds }
        }
    }

    /// Of a patch of a curved body: cells are no longer than the patch's greatest steps, divided alike.
    pub(crate) fn of_patch(chart: &Chart, placement: &Placement) -> Self {
        let edges = chart.steps(placement);
        let square = edges[0].hypot(edges[1]);
        Self { edges, longest_edge: edges[0].max(edges[1]), whole: square, square, bounds: None }
    }

    /// How often the face must be halved for its cells to reach no farther than `limit`.
    fn level_within(&self, limit: f64) -> u8 {
        if self.whole <= limit { 0 } else { halvings(self.square, limit).max(1) }
    }
}

/// The length of a vector; the axes may change places without changing it.
pub(crate) fn length(v: DVec3) -> f64 {
    length_squared(v).sqrt()
}

/// How often `length` must be halved to be at most `limit`.
fn halvings(mut length: f64, limit: f64) -> u8 {
    let mut level = 0;
    while length > limit && level < MAX_DEPTH + 1 {
        length *= 0.5;
        level += 1;
    }
    level
}

/// The levels of a face of this size, in an object with these bounds; none below the whole face where the object has no points.
pub(crate) fn of_face(detail: Detail, keep_cells: bool, bounds: &Aabb, size: &FaceSize) -> Levels {
    if bounds.is_empty() {
        return Levels { finest: 0, interior: 0, keep_cells, pixel: None };
    }
    let cube = bounds.size().max_element();
    let at_depth = |depth: u8| size.level_within(cube / f64::from(1u32 << depth.min(MAX_DEPTH)));
    let (finest, interior) = match detail {
        Detail::Depth { interior, boundary } => (at_depth(boundary), at_depth(interior)),
        Detail::Cell { edge } => {
            let level = halvings(size.longest_edge, edge);
            (level, level)
        }
        Detail::Faces => (0, 0),
        Detail::Pixel { eye, width } => {
            return pixel_levels((eye, width), keep_cells, bounds, size, at_depth(MAX_DEPTH));
        }
        Detail::MaxUndecided { .. } => (at_depth(MAX_DEPTH), at_depth(MAX_DEPTH)),
        // Where depths are asked one by one, these never come here; elsewhere they mean the typical one.
        Detail::Time { .. } | Detail::Memory { .. } => (at_depth(TYPICAL_DEPTH), at_depth(TYPICAL_DEPTH)),
    };
    Levels { finest, interior, keep_cells, pixel: None }
}

/// The levels at which cells have the size of a pixel: one for all of a face that is seen from about the same distance.
fn pixel_levels((eye, width): (DVec3, f64), keep_cells: bool, bounds: &Aabb, size: &FaceSize, deepest: u8) -> Levels {
    let face = size.bounds.unwrap_or(*bounds);
    let nearest = length(eye.clamp(face.min, face.max) - eye);
    let farthest = length((face.min - eye).abs().max((face.max - eye).abs()));
    let stop = PixelStop { eye, width, reach: size.square };
    let [near, far] = [nearest, farthest]
        .map(|distance| (0..deepest).find(|&level| stop.is_met_at(level, distance)).unwrap_or(deepest));
    Levels { finest: near, interior: near, keep_cells, pixel: (near != far).then_some(stop) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(corners: &[[f64; 3]], is_triangle: bool, depth: u8) -> u8 {
        let corners: Vec<Point> = corners.iter().map(|&corner| Point::exact(corner.into())).collect();
        let size = FaceSize::of_flat(&corners, is_triangle);
        let bounds = Aabb { min: DVec3::ZERO, max: DVec3::splat(8.0) };
        of_face(Detail::Depth { interior: 0, boundary: depth }, false, &bounds, &size).finest
    }

    #[test]
    fn a_cell_fits_a_leaf() {
        // A right triangle with legs 6 and 8: its square cells reach 10 across at level 0.
        let right = [[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 6.0, 0.0]];
        assert_eq!(levels(&right, true, 0), 1, "10 > 8");
        assert_eq!(levels(&right, true, 3), 4, "10 / 16 ≤ 1");
        let square = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]];
        assert_eq!(levels(&square, false, 1), 1, "the diagonal is longer than 4");
        assert_eq!(levels(&square, false, 0), 0);
    }
}
