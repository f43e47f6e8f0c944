//! What a pack shows of itself: the projections of its triangles, row by row.
//!
//! A ray that hits a triangle in a leaf crosses the projections of both, so a map lists a pack only where one of its
//! triangles is seen too. Packs hold little of what their leaves' cells cover; on surfaces this leaves a ray two or three of them.
//!
//! What the triangles reach in a row of cells is what their edges reach there, and an edge is looked at in the rows that it crosses, no others:
//! O(edges + rows that they cross).
//!
//! *Error.* Let e bound what a corner's coordinates are off by, z the least depth of a corner as computed, and q a point of a triangle that
//! is seen on the face, at the place x/d with |x/d| ≤ 1 + [`RIM`]. The same mean of the computed corners is a point q′ within e of q on each axis, at a
//! depth d′ ≥ z, and x′/d′ − x/d = (x′ − x)/d′ + (x/d)·(d − d′)/d′, less than 3e/z. Where the corners themselves are seen does not matter:
//! far outside the face they may be off by more. Places of the computed corners are a reciprocal and a product of coordinates ≤ 1, so rounding
//! moves them, and the means of them, by less than 3u/z, u = 2^-53. Everything is widened by a margin of 2·slack/z, which is 512·max(e, 2u)/z at least
//! ([`Root`](super::tree::Root)): more than a hundred times both together. On an edge u is monotone in v, and rounding a
//! crossing with a row's border (six roundings of what the edge spans, at most 2/z) is less than what is left. Rows are looked for within
//! twice the margin, so rounding their borders loses none. Triangles too near for that have no outline, and
//! then their pack is seen wherever the leaf's cell is.

use std::ops::Range;

use glam::DVec3;

use super::{
    footprint::RIM,
    frame::Kind,
    grid::{cells_between, strip},
};

/// The projections of a pack's triangles.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    /// Their projected corners: 48 bytes a triangle, where edges that know their slopes take 120.
    triangles: Box<[[[f64; 2]; 3]]>,
    margin: f64,
    /// The columns and the rows that it reaches.
    pub(super) reach: [[f64; 2]; 2],
    /// The triangles' areas together.
    pub(super) area: f64,
}

/// A projected edge, from its lower end (v) to its upper one.
struct Edge {
    u: [f64; 2],
    v: [f64; 2],
    /// How u grows with v; infinite or no number where v does not change.
    slope: f64,
}

impl Edge {
    fn new(a: [f64; 2], b: [f64; 2]) -> Self {
        let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        Self { u: [a[0], b[0]], v: [a[1], b[1]], slope: (b[0] - a[0]) / (b[1] - a[1]) }
    }

    fn of([a, b, c]: [[f64; 2]; 3]) -> [Self; 3] {
        [Self::new(a, b), Self::new(b, c), Self::new(c, a)]
    }

    /// The range grown by what the edge reaches in a strip that it meets.
    #[inline(always)]
    fn widen(&self, [low, high]: [f64; 2], strip: [f64; 2]) -> [f64; 2] {
        // Asked for between its ends only, so that the slope is finite.
        let at = |v: f64| self.u[0] + self.slope * (v - self.v[0]);
        let first = if self.v[0] < strip[0] { at(strip[0]) } else { self.u[0] };
        let last = if self.v[1] > strip[1] { at(strip[1]) } else { self.u[1] };
        [low.min(first).min(last), high.max(first).max(last)]
    }
}

impl Outline {
    /// Of triangles by their local corners; `None` where one cannot be projected.
    pub(super) fn new(
        kind: Kind,
        face: usize,
        slack: f64,
        triangles: impl ExactSizeIterator<Item = [DVec3; 3]>,
    ) -> Option<Self> {
        let (axis, sign) = (face / 2, if face.is_multiple_of(2) { 1.0 } else { -1.0 });
        let (mut nearest, mut area, mut reach) = (f64::INFINITY, 0.0, [EMPTY; 2]);
        let mut projected = Vec::with_capacity(triangles.len());
        for corners in triangles {
            let [a, b, c] = corners.map(|corner| {
                let depth = if kind == Kind::Parallel { 1.0 } else { sign * corner[axis] };
                nearest = nearest.min(depth);
                let scale = depth.recip();
                let place = [corner[(axis + 1) % 3] * scale, corner[(axis + 2) % 3] * scale];
                reach = [0, 1].map(|k| [reach[k][0].min(place[k]), reach[k][1].max(place[k])]);
                place
            });
            if nearest <= 0.0 {
                return None;
            }
            area += 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
            projected.push([a, b, c]);
        }
        let margin = 2.0 * slack * nearest.recip().max(1.0);
        let reach = reach.map(|[low, high]| [low - margin, high + margin]);
        (margin < RIM).then(|| Self { triangles: projected.into(), margin, reach, area })
    }

    /// The columns that it reaches in each of some rows of so many `cells`; empty (first > last) where it is not there.
    pub(super) fn columns(&self, cells: u32, rows: Range<u32>, columns: &mut Vec<[f64; 2]>) {
        columns.clear();
        let row = strip(rows.start, cells);
        if rows.len() == 1 && row[0] <= self.reach[1][0] && self.reach[1][1] <= row[1] {
            columns.push(self.reach[0]);
            return;
        }
        columns.resize(rows.len(), EMPTY);
        let near = 2.0 * self.margin;
        let all = [row[0] - near, strip(rows.end - 1, cells)[1] + near];
        let edges = self.triangles.iter().flat_map(|&triangle| Edge::of(triangle));
        for edge in edges.filter(|edge| edge.v[0] <= all[1] && edge.v[1] >= all[0]) {
            let met = cells_between([edge.v[0] - near, edge.v[1] + near], cells);
            for row in met.start.max(rows.start)..met.end.min(rows.end) {
                let [low, high] = strip(row, cells);
                let strip = [low - self.margin, high + self.margin];
                if edge.v[0] <= strip[1] && edge.v[1] >= strip[0] {
                    let reach = &mut columns[(row - rows.start) as usize];
                    *reach = edge.widen(*reach, strip);
                }
            }
        }
        for reach in columns {
            *reach = [reach[0] - self.margin, reach[1] + self.margin];
        }
    }
}

const EMPTY: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];
