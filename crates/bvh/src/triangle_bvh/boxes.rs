//! A ray against the eight boxes of a node. Rounded outward: never leaves out a box that the ray meets.

use umbriel_geometry::simd::{F8, Float, M8, Mask, Simd};

use super::{
    layout::Node,
    ray::{LocalRay, OUTWARD, Slab},
};

/// Which of the boxes the ray may meet, a bit each.
#[inline(always)]
pub(super) fn boxes_met<S: Simd>(simd: S, node: &Node, ray: &LocalRay) -> u32 {
    box_spans(simd, node, ray).1.bits()
}

/// Where the ray enters the boxes, and which of them it may meet.
#[inline(always)]
pub(super) fn box_spans<S: Simd>(simd: S, node: &Node, ray: &LocalRay) -> (F8<S>, M8<S>) {
    let [x, y, z] = &ray.slabs;
    let (near_x, near_y, near_z) = (near(simd, node, x), near(simd, node, y), near(simd, node, z));
    let (far_x, far_y, far_z) = (far(simd, node, x), far(simd, node, y), far(simd, node, z));
    let enter = near_x.max(near_y).max(near_z.max(simd.splat8(0.0)));
    let leave = far_x.min(far_y).min(far_z.min(simd.splat8(ray.box_end)));
    (enter, enter.le(leave * simd.splat8(OUTWARD)))
}

/// Where the ray reaches the near planes of one axis.
#[inline(always)]
fn near<S: Simd>(simd: S, node: &Node, slab: &Slab) -> F8<S> {
    (simd.load(&node.planes[slab.near]) - simd.splat8(slab.near_origin)) * simd.splat8(slab.reciprocal)
}

/// Where the ray reaches the far planes of one axis.
#[inline(always)]
fn far<S: Simd>(simd: S, node: &Node, slab: &Slab) -> F8<S> {
    (simd.load(&node.planes[slab.far]) - simd.splat8(slab.far_origin)) * simd.splat8(slab.reciprocal)
}
