//! A ray against the eight boxes of a node. Rounded outward: never leaves out a box that the ray meets.

use umbriel_geometry::simd::{F8, Float, M8, Mask, Simd};

use super::{
    layout::Node,
    ray::{LocalRay, OUTWARD, Slabs},
};

/// Which of the boxes the ray may meet, a bit each.
#[inline(always)]
pub(super) fn boxes_met<S: Simd>(simd: S, node: &Node, ray: &LocalRay) -> u32 {
    box_spans(simd, node, ray).1.bits()
}

/// Where the ray enters the boxes, and which of them it may meet.
#[inline(always)]
pub(super) fn box_spans<S: Simd>(simd: S, node: &Node, ray: &LocalRay) -> (F8<S>, M8<S>) {
    let [near_x, near_y, near_z] = reached(simd, node, &ray.slabs.near, &ray.slabs.near_origin, &ray.slabs);
    let [far_x, far_y, far_z] = reached(simd, node, &ray.slabs.far, &ray.slabs.far_origin, &ray.slabs);
    let enter = near_x.max(near_y).max(near_z.max(simd.splat8(0.0)));
    let leave = far_x.min(far_y).min(far_z.min(simd.splat8(ray.box_end)));
    (enter, enter.le(leave * simd.splat8(OUTWARD)))
}

/// Where the ray reaches the planes of three rows, seen from `origin`.
#[inline(always)]
fn reached<S: Simd>(simd: S, node: &Node, rows: &[usize; 3], origin: &[f32; 3], slabs: &Slabs) -> [F8<S>; 3] {
    let mut reached = [simd.splat8(0.0); 3];
    for axis in 0..3 {
        let away = simd.load(&node.planes[rows[axis]]) - simd.splat8(origin[axis]);
        reached[axis] = away * simd.splat8(slabs.reciprocal[axis]);
    }
    reached
}
