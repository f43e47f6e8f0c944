//! Sixteen segments on their way through the tree.

use umbriel_geometry::simd::{Mask, Simd};

use super::{
    super::{
        build::{MAX_DEPTH, Parts},
        layout::{Pack, WIDTH},
        shaft::Shaft,
    },
    GROUPS, LocalLight, Packet,
    planes::{look, ranges, segments, spread},
};

/// Nodes and packs that a packet may visit before its segments go on alone: segments that are far apart have a wide
/// shaft.
const PATIENCE: u32 = 64;

/// What a pack does to a packet.
struct Verdicts {
    /// Segments that are certainly blocked.
    hits: u32,
    /// Segments that some triangle leaves in doubt.
    doubts: u32,
}

/// Sixteen segments on their way through the tree.
pub(in super::super) struct Walk<'a> {
    pub(in super::super) parts: &'a Parts,
    pub(in super::super) light: &'a LocalLight,
    pub(in super::super) packet: &'a Packet,
    /// Segments that are not known to be blocked.
    pub(in super::super) open: u32,
}

impl Walk<'_> {
    /// Walks until all are blocked, the tree is at its end, or patience is: true in the last case. `resolve` tells
    /// whether a segment in doubt is blocked by a pack. `last` is the pack to try first, and the last that blocked.
    #[inline(always)]
    pub(in super::super) fn walk<S: Simd>(
        &mut self,
        simd: S,
        last: &mut Option<u32>,
        mut resolve: impl FnMut(usize, &Pack) -> bool,
    ) -> bool {
        if let Some(last) = *last {
            self.open &= !self.test(simd, &self.parts.packs[last as usize]).hits;
        }
        *last = last.filter(|_| self.open == 0);
        let shaft = Shaft::towards(self.packet, self.light);
        let mut stack = [(0u32, 0u32); MAX_DEPTH];
        let (mut depth, mut index, mut visits) = (0, 0, 0);
        let mut children = shaft.boxes_met(simd, &self.parts.nodes[0]);
        while self.open != 0 {
            if children == 0 {
                if depth == 0 {
                    return false;
                }
                depth -= 1;
                (index, children) = stack[depth];
                continue;
            }
            visits += 1;
            if visits > PATIENCE {
                return true;
            }
            let node = &self.parts.nodes[index as usize];
            let lane = children.trailing_zeros();
            children &= children - 1;
            let child = node.children[lane as usize % WIDTH];
            if node.leaves >> lane & 1 == 0 {
                if children != 0 {
                    stack[depth] = (index, children);
                    depth += 1;
                }
                index = child;
                children = shaft.boxes_met(simd, &self.parts.nodes[index as usize]);
                continue;
            }
            let concerned = self.open & self.packet.segments_in(simd, node, lane as usize % WIDTH);
            if concerned == 0 {
                continue;
            }
            let pack = &self.parts.packs[child as usize];
            let mut verdicts = self.test(simd, pack);
            verdicts.doubts &= concerned & !verdicts.hits;
            while verdicts.doubts != 0 {
                let segment = verdicts.doubts.trailing_zeros();
                verdicts.doubts &= verdicts.doubts - 1;
                verdicts.hits |= u32::from(resolve(segment as usize, pack)) << segment;
            }
            if self.open & verdicts.hits != 0 {
                *last = Some(child);
                self.open &= !verdicts.hits;
            }
        }
        false
    }

    /// The pack against all segments that are open.
    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, pack: &Pack) -> Verdicts {
        let (seen, is_doubtful) = look(simd, pack, self.light, self.packet, self.parts.corner_error);
        let (missed, covering) = ranges(simd, &seen, self.packet);
        let doubtful = is_doubtful.bits();
        if covering.bits() & !doubtful != 0 {
            return Verdicts { hits: self.open, doubts: 0 };
        }
        let mut verdicts = Verdicts { hits: 0, doubts: 0 };
        let mut left = !missed.bits() & 0xff & !doubtful;
        if doubtful != 0 {
            verdicts.doubts = self.open;
        }
        if left == 0 {
            return verdicts;
        }
        let spread = spread(&seen);
        while left != 0 && self.open & !verdicts.hits != 0 {
            let lane = left.trailing_zeros() as usize % WIDTH;
            left &= left - 1;
            for group in 0..GROUPS {
                let (hits, doubts) = segments(simd, &spread, lane, self.packet, group);
                verdicts.hits |= hits << (group * WIDTH);
                verdicts.doubts |= doubts << (group * WIDTH);
            }
        }
        verdicts
    }
}
