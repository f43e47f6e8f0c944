//! Samples of flat receivers: occluders scan-converted over the receivers' own lattices.
//!
//! Problem: millions of points on planar faces, each lit or not under one light, exactly. In the light's own space ([`view`]) a
//! shadow ray is a point, an occluder is a triangle, and both an edge of it and the line in which it meets a receiver's
//! plane are linear in the row and the column of the receiver's lattice: in each row an occluder hides an interval of
//! columns, for certain up to a derived band ([`spans`]). Samples in such a band, or under a triangle with holes, are decided exactly. A convex solid is one occluder, its
//! outline and the planes of its faces ([`volumes`], [`shade`]). All other faces are sorted along the light's image ([`order`]); these and
//! the solids lie under trees of boxes ([`tree`]); receivers that are neighbours there gather the occluders over them together
//! ([`batch`]).
//!
//! Source: scan conversion of polygons (Wylie, Romney, Evans and Erdahl 1967) over the irregular samples of shadow rays (Aila and
//! Laine 2004; Johnson, Lee, Burns and Mark 2005); trees packed along a space-filling curve (Kamel and Faloutsos 1993).
//! Guarantee: every answer is the exact one; NUMERICS.md, "Samples by scan conversion". Cost: some hundred nanoseconds a face and a few a
//! sample; memory some 80 bytes a triangle, and a bit a sample.

mod axes;
mod batch;
mod beside_lamp;
mod bunch;
mod clip;
mod doubts;
mod faces;
mod group;
mod hull;
mod images;
mod large;
mod layout;
mod lit_bits;
mod order;
mod pack;
mod patch;
mod repeats;
mod sampler;
mod shade;
mod spans;
mod view;
mod volumes;

#[cfg(test)]
mod tests;

use super::packed_tree as tree;

pub(crate) use {
    layout::{Layout, LitSamples},
    lit_bits::LitBits,
    sampler::{IsLit, RUNS, Sampled, sample},
};
