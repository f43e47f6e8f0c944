//! Triangles and convex solids that are given very often.
//!
//! A file may hold one triangle a hundred thousand times. Each of them has samples of its own, but what all of them block the first one blocks: a sample of
//! any of them is in the plane of all, and meets none. Only piles with one key are looked through: it costs nothing where there are none.

use std::collections::{HashMap, HashSet};

use umbriel_geometry::{Facet, Facets, cut_out::Opacity};

use super::{
    faces::{Face, Piece, Source},
    order::Order,
    volumes::Volume,
};

/// Volumes with one key that are no pile yet, at most.
const MOST_TOGETHER: usize = 128;

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

/// The numbers of those volumes that have the triangles of one before them, in the same order; of volumes in the order of their keys. Exact.
pub(super) fn repeated_volumes(volumes: &[Volume], keys: &[u64], sources: &[Source]) -> Vec<usize> {
    let (mut repeats, mut firsts, mut end) = (Vec::new(), HashSet::new(), 0);
    for pile in keys.chunk_by(|one, next| one == next) {
        let numbers = end..end + pile.len();
        end = numbers.end;
        if pile.len() <= MOST_TOGETHER {
            continue;
        }
        firsts.clear();
        repeats.extend(numbers.filter(|&number| {
            let volume = &volumes[number];
            !firsts.insert(triangles(volume, sources[volume.source as usize].facets))
        }));
    }
    repeats
}

/// The bits of the corners of a volume's triangles.
fn triangles(volume: &Volume, facets: &Facets) -> Vec<[u64; 3]> {
    let corners = volume.faces.clone().flat_map(|face| facets.facet(face).corners().to_vec());
    corners.map(|corner| bits(facets, corner)).collect()
}

/// The bits of an opaque triangle's corners, sorted; `None` of other faces.
fn corners(source: &Source, face: usize) -> Option<[[u64; 3]; 3]> {
    let facets = source.facets;
    let Facet::Triangle(corners) = facets.facet(face) else { return None };
    if !facets.are_floats() || facets.opacity(face) != Opacity::Opaque {
        return None;
    }
    let mut bits = corners.map(|corner| bits(facets, corner));
    bits.sort_unstable();
    Some(bits)
}

/// The bits of a corner's coordinates; adding 0 turns −0 into it.
fn bits(facets: &Facets, corner: u32) -> [u64; 3] {
    facets.positions()[corner as usize].to_array().map(|x| (x + 0.0).to_bits())
}
