//! Which edges of the occluders are borders: where the number of polygons that cover a point can change.
//!
//! Every polygon is turned counter-clockwise in the projection. An edge between two neighbours of a sheet is then used
//! once each way and cancels; silhouettes and open borders do not. Edges are compared by their end points' numbers,
//! which stand for exact positions, so no hash and no tolerance is involved.

use umbriel_geometry::DisjointSets;

use super::polygon_blocker::PolygonBlocker;

/// One edge of one polygon, in the direction of its counter-clockwise turn in the projection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct DirectedEdge {
    object: u32,
    low: u32,
    high: u32,
    /// From `low` to `high`, or back.
    forward: bool,
    polygon: u32,
    side: u8,
}

impl DirectedEdge {
    /// The edge between two corners of a facet, side `side` of blocker `polygon`; `flipped` when the light sees the
    /// corners run clockwise.
    pub(crate) fn new(object: u32, [from, to]: [u32; 2], flipped: bool, polygon: u32, side: u8) -> Self {
        Self { object, low: from.min(to), high: from.max(to), forward: (from < to) != flipped, polygon, side }
    }
}

/// What a polygon's edge is to the sum of all polygons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Border {
    /// How many more polygons lie inside than outside of the edge: 0 inside a sheet, and on all polygons outside.
    pub(crate) net: u32,
    /// How many polygons lie inside. They share the border: what proves for one of them that it does not matter proves it for all.
    pub(crate) users: u32,
    /// A number for the edge, the same on all of them.
    pub(crate) edge: u32,
}

impl Border {
    /// Where a polygon ends at the receiver.
    pub(crate) const CUT: Self = Self { net: 1, users: 1, edge: 0 };
}

/// Marks the edges whose uses do not cancel on all polygons that use them in the prevailing direction: to choose one of
/// these would be to ask for an order of theirs. Polygons that share an edge are of one sheet.
pub(crate) fn mark_borders<const N: usize>(polygons: &mut [PolygonBlocker<N>], mut edges: Vec<DirectedEdge>) {
    edges.sort_unstable();
    let mut sheets = DisjointSets::new(polygons.len());
    let uses_of_edges = edges.chunk_by(|a, b| (a.object, a.low, a.high) == (b.object, b.low, b.high));
    for (edge, uses) in (0..).zip(uses_of_edges) {
        let forward = uses.iter().filter(|usage| usage.forward).count();
        let backward = uses.len() - forward;
        uses.windows(2).for_each(|pair| sheets.join(pair[0].polygon, pair[1].polygon));
        let border = Border { net: forward.abs_diff(backward) as u32, users: forward.max(backward) as u32, edge };
        if border.net > 0 {
            for usage in uses.iter().filter(|usage| usage.forward == (forward > backward)) {
                polygons[usage.polygon as usize].border[usage.side as usize] = border;
            }
        }
    }
    for (polygon, number) in polygons.iter_mut().zip(0..) {
        polygon.sheet = sheets.root(number);
    }
}
