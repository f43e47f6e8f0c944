//! Triangles that are given very often.
//!
//! A file may hold one triangle a hundred thousand times. Each of them has samples of its own, but what all of them block the first one blocks: a sample of
//! any of them is in the plane of all, and meets none. Only piles of faces with one key are looked through: it costs nothing where there are none.

use std::collections::{HashMap, HashSet};

use umbriel_geometry::{Facet, cut_out::Opacity};

use super::{
    faces::{Face, Piece, Source},
    order::Order,
};

/// The faces of piles that have the corners of one before them, in whichever order. Exact.
pub(super) fn repeats(sources: &[Source], order: &Order) -> HashSet<Face> {
    let (mut repeats, mut firsts) = (HashSet::new(), HashMap::new());
    for pile in &order.piles {
        firsts.clear();
        for piece in order.pieces[pile.clone()].iter().filter(|&&piece| piece != Piece::NONE) {
            let face = piece.face();
            let Some(corners) = corners(&sources[face.source as usize], face.number as usize) else { continue };
            // A face that is cut has several pieces.
            if *firsts.entry(corners).or_insert(face) != face {
                repeats.insert(face);
            }
        }
    }
    repeats
}

/// The bits of an opaque triangle's corners, sorted; `None` of other faces.
fn corners(source: &Source, face: usize) -> Option<[[u64; 3]; 3]> {
    let facets = source.facets;
    let Facet::Triangle(corners) = facets.facet(face) else { return None };
    if !facets.are_floats() || facets.opacity(face) != Opacity::Opaque {
        return None;
    }
    // Adding 0 turns −0 into it.
    let mut bits = corners.map(|corner| facets.positions()[corner as usize].to_array().map(|x| (x + 0.0).to_bits()));
    bits.sort_unstable();
    Some(bits)
}
