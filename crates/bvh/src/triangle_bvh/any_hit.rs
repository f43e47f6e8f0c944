//! Any hit: does some triangle block the way from a point to a light?
//!
//! Depth first through the boxes, in the order that the builder gave the children. A level of the stack holds a node
//! and those of its children that are still to be visited. The pack that blocked last is tried first (the shadow cache
//! of Haines and Greenberg, "The light buffer", IEEE Computer Graphics and Applications 6(9), 1986): neighbours tend to be
//! in the same shadow. The answer does not depend on it.

use umbriel_geometry::simd::{Kernel, Simd};

use super::{
    boxes::boxes_met,
    build::{MAX_DEPTH, Parts},
    layout::WIDTH,
    pack_test,
    ray::{LocalRay, Way},
};

/// Finds a pack with a triangle that blocks the ray.
pub(super) struct AnyHit<'a, D> {
    pub(super) parts: &'a Parts,
    pub(super) way: &'a Way,
    /// The pack to try first.
    pub(super) first: Option<u32>,
    /// Decides about a triangle in doubt.
    pub(super) decide: D,
}

// Through a reference, which goes into the kernel in a register: the processor would have to wait for a copy.
impl<D: FnMut(u32) -> bool> Kernel for &mut AnyHit<'_, D> {
    type Output = Option<u32>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<u32> {
        let ray = &LocalRay::new(&self.parts.frame, self.way, self.parts.corner_error)?;
        // Doubts are left to the walk, which comes to the pack if the ray does.
        if let Some(first) = self.first
            && pack_test::test(simd, &self.parts.packs[first as usize], ray).hits != 0
        {
            return Some(first);
        }
        let mut stack = [(0u32, 0u32); MAX_DEPTH];
        let mut depth = 0;
        let mut index = 0;
        let mut open = boxes_met(simd, &self.parts.nodes[0], ray);
        loop {
            while open == 0 {
                if depth == 0 {
                    return None;
                }
                depth -= 1;
                (index, open) = stack[depth];
            }
            let node = &self.parts.nodes[index as usize];
            let lane = open.trailing_zeros();
            open &= open - 1;
            let child = node.children[lane as usize % WIDTH];
            if node.leaves >> lane & 1 == 1 {
                if self.blocks(simd, ray, child) {
                    return Some(child);
                }
            } else {
                if open != 0 {
                    stack[depth] = (index, open);
                    depth += 1;
                }
                index = child;
                open = boxes_met(simd, &self.parts.nodes[index as usize], ray);
            }
        }
    }
}

impl<D: FnMut(u32) -> bool> AnyHit<'_, D> {
    #[inline(always)]
    fn blocks<S: Simd>(&mut self, simd: S, ray: &LocalRay, index: u32) -> bool {
        let pack = &self.parts.packs[index as usize];
        let verdicts = pack_test::test(simd, pack, ray);
        verdicts.hits != 0 || verdicts.any_doubt(pack, &mut self.decide)
    }
}
