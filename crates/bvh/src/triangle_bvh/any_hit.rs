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
    layout::{Pack, WIDTH},
    pack_test,
    ray::{LocalRay, Way},
};

/// What is left to visit.
pub(super) type Stack = [(u32, u32); MAX_DEPTH];

/// Finds a pack with a triangle that blocks the ray.
pub(super) struct AnyHit<'a, D> {
    pub(super) parts: &'a Parts,
    pub(super) way: &'a Way,
    /// The pack to try first.
    pub(super) first: Option<u32>,
    /// Nodes, and those of their children that are still to be visited. Of no meaning before and after.
    pub(super) stack: &'a mut Stack,
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
        // Lent, as clearing one for each ray would take longer than a node.
        let AnyHit { parts, stack, decide, .. } = self;
        let mut depth = 0;
        let mut index = 0;
        let mut open = boxes_met(simd, &parts.nodes[0], ray);
        loop {
            while open == 0 {
                if depth == 0 {
                    return None;
                }
                depth -= 1;
                (index, open) = stack[depth];
            }
            let node = &parts.nodes[index as usize];
            let lane = open.trailing_zeros();
            open &= open - 1;
            let child = node.children[lane as usize % WIDTH];
            if node.leaves >> lane & 1 == 1 {
                if blocks(simd, ray, &parts.packs[child as usize], &mut *decide) {
                    return Some(child);
                }
            } else {
                if open != 0 {
                    stack[depth] = (index, open);
                    depth += 1;
                }
                index = child;
                open = boxes_met(simd, &parts.nodes[index as usize], ray);
            }
        }
    }
}

/// Whether a triangle of the pack blocks the ray.
#[inline(always)]
fn blocks<S: Simd>(simd: S, ray: &LocalRay, pack: &Pack, decide: impl FnMut(u32) -> bool) -> bool {
    let verdicts = pack_test::test(simd, pack, ray);
    verdicts.hits != 0 || verdicts.any_doubt(pack, decide)
}
