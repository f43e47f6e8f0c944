//! Which edges of the occluders are borders: where the number of polygons that cover a point can change.
//!
//! Every polygon is turned counter-clockwise in the projection. An edge between two neighbours of a sheet is then used
//! once each way and cancels; silhouettes and open borders do not. Edges are compared by their end points' numbers,
//! which stand for exact positions, so no hash and no tolerance is involved.

use super::polygon_blocker::PolygonBlocker;

/// One edge of one polygon, in the direction of its counter-clockwise turn in the projection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct DirectedEdge {
    object: u32,
    low: u32,
    high: u32,
    /// From `low` to `high`, or back.
    forward: bool,
    /// The polygon's next corner: a name for the polygon that does not depend on the order of the faces.
    apex: u32,
    polygon: u32,
    side: u8,
}

impl DirectedEdge {
    /// The edge from the first to the second of three consecutive corners of a facet, side `side` of blocker
    /// `polygon`; `flipped` when the light sees the corners run clockwise.
    pub(crate) fn new(object: u32, [from, to, apex]: [u32; 3], flipped: bool, polygon: u32, side: u8) -> Self {
        Self { object, low: from.min(to), high: from.max(to), forward: (from < to) != flipped, apex, polygon, side }
    }
}

/// Writes the net multiplicity of every edge to one of the polygons that use it in the prevailing direction.
pub(crate) fn mark_borders<const N: usize>(polygons: &mut [PolygonBlocker<N>], mut edges: Vec<DirectedEdge>) {
    edges.sort_unstable();
    for uses in edges.chunk_by(|a, b| (a.object, a.low, a.high) == (b.object, b.low, b.high)) {
        let forward = uses.iter().filter(|usage| usage.forward).count();
        let backward = uses.len() - forward;
        let prevailing = uses.iter().find(|usage| usage.forward == (forward > backward));
        if let Some(border) = prevailing.filter(|_| forward != backward) {
            polygons[border.polygon as usize].border[border.side as usize] = forward.abs_diff(backward) as u32;
        }
    }
}
