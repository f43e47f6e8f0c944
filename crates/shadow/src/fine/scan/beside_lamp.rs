//! Samples that all but touch a lamp.
//!
//! A view takes the samples in its window; in which of six windows a sample lies is rounded. Near the lamp that rounding is as large as
//! the sample's distance, and none of the views may take it. Such samples are decided exactly (NUMERICS.md, "What is left out").

use glam::DVec3;
use umbriel_geometry::{Facets, LightSource};

use super::{layout::FaceLattice, lit_bits::LitBits, sampler::Sampled};
use crate::{
    bodies::Bodies,
    exact::{Own, face_blocks},
    fine::flat::flat_probe,
    receivers::flat_corners,
};

/// A sample is near a lamp within this share of the greatest coordinate, seen from there, of its face.
const NEAR: f64 = 1.0 / (1u32 << 20) as f64;

/// Decides the samples near a lamp, whatever the views said of them. Exact. O(faces) where the box of an object holds the lamp, and
/// O(samples) for faces that pass it by so closely.
pub(super) fn decide_beside_lamp(bodies: &Bodies, light: &LightSource, objects: &[Sampled], lit: &[LitBits]) {
    if light.is_sun() {
        return;
    }
    for (object, lit) in objects.iter().zip(lit) {
        if object.receives.is_some() && is_near(object.bounds.min, object.bounds.max, light.xyz()).is_some() {
            let (facets, slack) = (object.facets, object.facets.slack());
            for face in (0..facets.len()).filter(|&face| may_be_near(facets, face, (light.xyz(), slack))) {
                decide_on_face(bodies, light, objects, (object, face), lit);
            }
        }
    }
}

/// False where the box of a face surely is farther from the lamp than [`is_near`] asks for: all but a few faces are told by their rounded
/// corners, none of which leaves out more than `slack`.
#[inline]
fn may_be_near(facets: &Facets, face: usize, (lamp, slack): (DVec3, f64)) -> bool {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &corner in facets.facet(face).corners().iter() {
        let way = facets.positions()[corner as usize] - lamp;
        (low, high) = (low.min(way), high.max(way));
    }
    let reach = low.abs().max(high.abs()).max_element();
    let rounding = 8.0 * f64::EPSILON * (lamp.abs().max_element() + reach);
    let near = 2.0 * (NEAR * reach + slack) + rounding;
    low.max_element() <= near && high.min_element() >= -near
}

/// How near to a lamp a point between two corners of a box is near it; `None` where the whole box is farther away.
fn is_near(min: DVec3, max: DVec3, lamp: DVec3) -> Option<f64> {
    let (low, high) = (min - lamp, max - lamp);
    let near = NEAR * low.abs().max(high.abs()).max_element();
    (low.max_element() <= near && high.min_element() >= -near).then_some(near)
}

fn decide_on_face(
    bodies: &Bodies,
    light: &LightSource,
    objects: &[Sampled],
    (own, face): (&Sampled, usize),
    lit: &LitBits,
) {
    let bounds = own.facets.facet_bounds(face);
    let (Some((layout, is_lit)), Some(near)) = (own.receives, is_near(bounds.min, bounds.max, light.xyz())) else {
        return;
    };
    let lattice = layout.face(face);
    let FaceLattice { lattice: points, corner, first_byte } = lattice;
    if points.counts()[0] == 0 || !is_lit(face, None) {
        return;
    }
    let corners = flat_corners(own.facets, face, corner);
    let [first, next, last] = [0, 1, 3].map(|k| corners[k].position - light.xyz());
    for row in 0..points.counts()[0] {
        let u = points.coordinate(0, row);
        for column in 0..points.row_len(row) {
            let v = points.coordinate(1, column);
            let way = first + (next - first) * u + (last - first) * v;
            if way.abs().max_element() > near {
                continue;
            }
            let (probe, own) = (flat_probe(&corners, u, v), Own::Face { object: own.object as usize, face });
            let blocks = |object: &Sampled| {
                let number = object.object as usize;
                (0..object.facets.len()).any(|face| face_blocks(bodies, (number, face), &probe, own, light))
            };
            let byte = first_byte + u64::from(row) * lattice.row_bytes() + u64::from(column / 8);
            lit.assign(byte, column % 8, !objects.iter().any(blocks));
        }
    }
}
