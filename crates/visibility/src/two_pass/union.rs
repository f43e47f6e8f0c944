//! The union of what occluders cover on one receiver.
//!
//! A sweep over all covers at once meets every crossing of their edges: the front and the back of a finely meshed body alone have thousands, and
//! borders between neighbours are swept though nothing ends there. So covers that lie near each other are united first, then these unions two by two: what is
//! inside is gone after the first steps, and later ones see outlines only.
//!
//! Cost: O(n log n) sweeps' steps for n covers that are neighbours in their order, and never more passes over an edge than [`passes`].

use i_overlay::{
    core::{fill_rule::FillRule, overlay_rule::OverlayRule},
    float::{overlay::FloatOverlay, single::SingleFloatOverlay},
};

use super::Region;

/// Covers united by one sweep.
const AT_ONCE: usize = 16;

/// What counter-clockwise contours cover, the better for contours that are neighbours in this order.
pub(super) fn union(covers: &[Vec<[f64; 2]>]) -> Vec<Region> {
    if covers.len() <= AT_ONCE {
        return FloatOverlay::with_subj(covers).overlay(OverlayRule::Subject, FillRule::NonZero);
    }
    let (first, second) = covers.split_at(covers.len() / 2);
    union(first).overlay(&union(second), OverlayRule::Union, FillRule::NonZero)
}

/// How often an edge may be rounded to the overlay's grid: in each union that it takes part in, and in the cut with the receiver.
pub(super) fn passes(covers: usize) -> u32 {
    covers.div_ceil(AT_ONCE).next_power_of_two().ilog2() + 2
}
