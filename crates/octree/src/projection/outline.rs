//! What a leaf shows of itself: the projections of its triangles, strip by strip.
//!
//! A ray that hits a triangle in a leaf crosses the projections of both, so a map lists a leaf only where one of its
//! triangles is seen too. Leaves hold little of what their cells cover; on surfaces this leaves a ray two or three of them.
//!
//! *Error.* A corner's place x/z is off by 2e/z + u where its coordinates are by e ≤ slack/256; everything is widened by a
//! margin of 2·slack/z, z the least depth of a corner, more than a hundred times that. On an edge u is monotone in v, and rounding a
//! crossing with a strip's border is moving the border by less than the margin. Triangles too near for that have no outline, and
//! then their leaf is seen wherever its cell is.

use glam::DVec3;

use super::{footprint::RIM, frame::Kind};

/// The projections of a leaf's triangles.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    triangles: Box<[[[f64; 2]; 3]]>,
    margin: f64,
}

impl Outline {
    /// Of triangles by their local corners; `None` where one cannot be projected.
    pub(super) fn new(
        kind: Kind,
        face: usize,
        slack: f64,
        triangles: impl Iterator<Item = [DVec3; 3]>,
    ) -> Option<Self> {
        let (axis, sign) = (face / 2, if face.is_multiple_of(2) { 1.0 } else { -1.0 });
        let mut margin = 2.0 * slack;
        let project = |corner: DVec3, margin: &mut f64| {
            let depth = if kind == Kind::Parallel { 1.0 } else { sign * corner[axis] };
            *margin = if depth > 0.0 { margin.max(2.0 * slack / depth) } else { f64::INFINITY };
            [corner[(axis + 1) % 3] / depth, corner[(axis + 2) % 3] / depth]
        };
        let triangles = triangles.map(|corners| corners.map(|corner| project(corner, &mut margin))).collect();
        (margin < RIM).then_some(Self { triangles, margin })
    }

    /// The rows that it reaches.
    pub(super) fn rows(&self) -> [f64; 2] {
        let places = self.triangles.iter().flatten();
        let reach = places.fold(EMPTY, |[low, high], &[_, v]| [low.min(v), high.max(v)]);
        [reach[0] - self.margin, reach[1] + self.margin]
    }

    /// The columns that it reaches between two rows; empty (first > last) where it is not there.
    pub(super) fn columns(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let strip = [low - self.margin, high + self.margin];
        let reach = self.triangles.iter().fold(EMPTY, |reach, triangle| {
            let edges = [[0, 1], [1, 2], [2, 0]].map(|edge| edge.map(|corner| triangle[corner]));
            edges.into_iter().fold(reach, |reach, edge| with_edge(reach, edge, strip))
        });
        [reach[0] - self.margin, reach[1] + self.margin]
    }
}

const EMPTY: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// The range grown by what an edge reaches in a strip.
fn with_edge([low, high]: [f64; 2], [a, b]: [[f64; 2]; 2], strip: [f64; 2]) -> [f64; 2] {
    let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
    if b[1] < strip[0] || a[1] > strip[1] {
        return [low, high];
    }
    let at = |v: f64| a[0] + (b[0] - a[0]) * ((v - a[1]) / (b[1] - a[1])).clamp(0.0, 1.0);
    let first = if a[1] < strip[0] { at(strip[0]) } else { a[0] };
    let last = if b[1] > strip[1] { at(strip[1]) } else { b[0] };
    [low.min(first).min(last), high.max(first).max(last)]
}
