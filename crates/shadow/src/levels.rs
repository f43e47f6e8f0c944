//! Detail in the user's terms, as levels of a face's parameter square.
//!
//! At depth d an object's octree has cells of its bounding cube's edge / 2^d. A face with longest edge e is halved until
//! e / 2^level is no larger than that.

use umbriel_geometry::{Aabb, Facets};

use crate::{fine::flat::Levels, request::Detail};

/// The deepest octree: 21 levels, three axes of 21 bits in a 64-bit Morton code.
pub(crate) const MAX_DEPTH: u8 = 21;

/// How often `edge` must be halved to be at most `limit`.
fn halvings(edge: f64, limit: f64) -> u8 {
    let mut level = 0;
    let mut length = edge;
    while length > limit && level < MAX_DEPTH {
        length *= 0.5;
        level += 1;
    }
    level
}

/// The levels of a face with this longest edge, in an object with these bounds, all in metres.
pub(crate) fn of_face(detail: Detail, keep_cells: bool, bounds: &Aabb, longest_edge: f64) -> Levels {
    let cube = bounds.size().max_element();
    let at_depth = |depth: u8| halvings(longest_edge, cube * (-f64::from(depth.min(MAX_DEPTH))).exp2());
    let (finest, stored) = match detail {
        Detail::Depth { interior, boundary } => (at_depth(boundary), at_depth(interior)),
        Detail::Cell { edge } => {
            let level = halvings(longest_edge, edge);
            (level, level)
        }
        Detail::MaxUndecided { .. } => (at_depth(MAX_DEPTH), at_depth(MAX_DEPTH)),
    };
    Levels { finest, stored: keep_cells.then_some(stored) }
}

/// The edges of a flat face along u and along v, and the longest of all its edges, rounded.
pub(crate) fn edges(facets: &Facets, facet: usize) -> ([f64; 2], f64) {
    let corners = facets.facet(facet).corners();
    let at = |k: usize| facets.positions()[corners[k % corners.len()] as usize];
    let length = |k: usize| at(k).distance(at(k + 1));
    let along = [length(0), at(0).distance(at(corners.len() - 1))];
    ((along), (0..corners.len()).map(length).fold(0.0, f64::max))
}
