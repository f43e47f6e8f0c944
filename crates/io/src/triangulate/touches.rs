//! Places that an outline comes to more than once.
//!
//! How its edges follow each other there is a choice that leaves all areas as they are. Ears are cut rightly where each corner
//! has the inside between its edges: so two squares that touch in a point become two rings, a seam from a hole to its border
//! stays one, and a line between two bodies folds back. Counter-clockwise round a place edges that leave it (the inside begins)
//! and that come to it (it ends) take turns; where they do not, the outline crosses itself and is left as it is. O(n log n).

use std::{cmp::Ordering, collections::HashSet};

use robust::{Coord, orient2d};

use super::rings::Rings;

/// Sizes of coordinates at which [`orient2d`] neither overflows nor underflows: its signs are exact, and there is an order round a place.
const SIZES: std::ops::RangeInclusive<f64> = 1e-120..=1e120;

/// As many corners are compared each with each faster than otherwise.
const FEW: usize = 24;

/// An edge as it is seen from one of its ends.
#[derive(Clone, Copy)]
struct Spoke {
    toward: Coord<f64>,
    leaves: bool,
    /// The corner that it leaves from, or else the one at its other end.
    corner: usize,
}

/// Lets edges follow each other round the inside wherever an outline touches itself. Whether that changed anything.
pub(super) fn part(rings: &mut Rings) -> bool {
    if !has_shared_places(rings) {
        return false;
    }
    let mut corners: Vec<usize> = rings.left().collect();
    corners.sort_unstable_by_key(|&corner| bits(rings.at[corner]));
    let places = corners.chunk_by(|&a, &b| rings.at[a] == rings.at[b]);
    let shared: Vec<&[usize]> = places.filter(|visits| visits.len() > 1).collect();
    let mut has_changed = false;
    for visits in shared {
        for [leaving, coming] in wedges(rings, visits).unwrap_or_default() {
            if rings.neighbours(coming.corner)[1] != leaving.corner {
                rings.join(coming.corner, leaving.corner);
                has_changed = true;
            }
        }
    }
    has_changed
}

fn has_shared_places(rings: &Rings) -> bool {
    let at = &rings.at;
    if at.len() <= FEW {
        return (1..at.len()).any(|corner| at[..corner].contains(&at[corner]));
    }
    let mut known = HashSet::with_capacity(at.len());
    rings.left().any(|corner| !known.insert(bits(at[corner])))
}

/// The same for equal places: zeros of either sign are one.
fn bits(at: Coord<f64>) -> [u64; 2] {
    [(at.x + 0.0).to_bits(), (at.y + 0.0).to_bits()]
}

/// The edges at a place in pairs, the inside between them; `None` where edges do not take turns, or lie on each other all round.
fn wedges(rings: &Rings, visits: &[usize]) -> Option<Vec<[Spoke; 2]>> {
    let place = rings.at[visits[0]];
    let mut spokes: Vec<Spoke> = visits.iter().flat_map(|&visit| spokes_of(rings, visit)).collect();
    let is_sized = |number: f64| number == 0.0 || SIZES.contains(&number.abs());
    if !spokes.iter().map(|spoke| spoke.toward).chain([place]).all(|at| is_sized(at.x) && is_sized(at.y)) {
        return None;
    }
    spokes.sort_by(|a, b| order_round(place, a.toward, b.toward));
    let ways: Vec<&[Spoke]> = spokes.chunk_by(|a, b| order_round(place, a.toward, b.toward).is_eq()).collect();
    let leaving = |way: &[Spoke]| way.iter().filter(|spoke| spoke.leaves).count();
    // More edges that leave than come: before this way is the outside.
    let start = ways.iter().position(|way| 2 * leaving(way) > way.len())?;
    let mut ordered = Vec::with_capacity(spokes.len());
    for way in ways[start..].iter().chain(&ways[..start]) {
        let (mut leave, mut come) = (way.iter().filter(|spoke| spoke.leaves), way.iter().filter(|spoke| !spoke.leaves));
        for _ in 0..way.len() {
            ordered.push(*if ordered.len() % 2 == 0 { leave.next() } else { come.next() }?);
        }
    }
    Some(ordered.as_chunks().0.to_vec())
}

fn spokes_of(rings: &Rings, visit: usize) -> [Spoke; 2] {
    let [before, after] = rings.neighbours(visit);
    [
        Spoke { toward: rings.at[after], leaves: true, corner: visit },
        Spoke { toward: rings.at[before], leaves: false, corner: before },
    ]
}

/// The order counter-clockwise round a place, from +x.
fn order_round(place: Coord<f64>, a: Coord<f64>, b: Coord<f64>) -> Ordering {
    let is_later_half = |at: Coord<f64>| (at.y, at.x) < (place.y, place.x);
    // A zero of either sign.
    let turn = orient2d(place, a, b) + 0.0;
    is_later_half(a).cmp(&is_later_half(b)).then_with(|| 0.0f64.total_cmp(&turn))
}
