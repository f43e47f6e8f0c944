//! Any hit for many segments to one light: packets of sixteen, and single rays where they do not pay.
//!
//! Packets are made of neighbours in the list; points in no order are put along Morton's curve first. A packet that
//! visits much is made of points that are far apart, and its segments go on one by one.

use glam::DVec3;
use umbriel_geometry::{
    Dyadic, LightSource, Point,
    blocking::{Probe, polygon_blocks, polygon_blocks_filter},
    decisions::{Level, count},
    simd::{Kernel, Simd},
};

use super::{
    TriangleBvh,
    any_hit::{AnyHit, Stack},
    build::MAX_DEPTH,
    layout::Pack,
    pack_test,
    packet::{LocalLight, PACKET, Packet, Walk},
    ray::{LocalRay, Way},
};

/// Which of the segments are blocked.
pub(super) struct AnyHits<'a> {
    pub(super) segments: Segments<'a>,
    pub(super) origins: &'a [DVec3],
    /// In which order to take them; empty for the given one.
    pub(super) order: &'a [u32],
    pub(super) blocked: &'a mut [bool],
}

/// Segments to one light.
#[derive(Clone, Copy)]
pub(super) struct Segments<'a> {
    pub(super) bvh: &'a TriangleBvh,
    pub(super) light: LightSource,
}

impl Kernel for AnyHits<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let light = LocalLight::new(&self.segments.bvh.parts.frame, &self.segments.light);
        let (mut last, mut last_single, mut stack) = (None, None, [(0, 0); MAX_DEPTH]);
        let mut settled = 0;
        for first in (0..self.origins.len()).step_by(PACKET) {
            let count = PACKET.min(self.origins.len() - first);
            let (mut origins, mut indices) = ([self.origins[self.index(first)]; PACKET], [0; PACKET]);
            for (lane, (origin, index)) in origins.iter_mut().zip(&mut indices).enumerate().take(count) {
                *index = self.index(first + lane);
                *origin = self.origins[*index];
            }
            let valid = u32::MAX >> (32 - count);
            // Segments of which something was in doubt.
            let mut asked = 0;
            let (mut hits, mut open) = (0, valid);
            if let Some(light) = &light {
                (hits, open) = self.segments.packet(simd, light, &origins, valid, &mut last, &mut asked);
            }
            while open != 0 {
                let lane = open.trailing_zeros() as usize % PACKET;
                open &= open - 1;
                let ask = || asked |= 1 << lane;
                last_single = self.segments.single(simd, origins[lane], last_single, &mut stack, ask);
                hits |= u32::from(last_single.is_some()) << lane;
            }
            for (lane, &index) in indices.iter().enumerate().take(count) {
                self.blocked[index] = hits >> lane & 1 == 1;
            }
            settled += u64::from((valid & !asked).count_ones());
        }
        count(Level::Single, settled);
    }
}

impl AnyHits<'_> {
    #[inline(always)]
    fn index(&self, place: usize) -> usize {
        self.order.get(place).map_or(place, |&index| index as usize)
    }
}

impl Segments<'_> {
    /// Of the valid segments those that are blocked, and those that have to go on one by one; those of which something was in doubt
    /// are added to `asked`.
    #[inline(always)]
    fn packet<S: Simd>(
        &self,
        simd: S,
        light: &LocalLight,
        origins: &[DVec3; PACKET],
        valid: u32,
        last: &mut Option<u32>,
        asked: &mut u32,
    ) -> (u32, u32) {
        let parts = &self.bvh.parts;
        let Some(packet) = Packet::new(simd, &parts.frame, light, origins) else { return (0, valid) };
        let mut walk = Walk { parts, light, packet: &packet, open: valid };
        let is_unfinished = walk
            .walk(simd, last, |segment, pack| self.resolve(simd, origins[segment], pack, || *asked |= 1 << segment));
        (valid & !walk.open, if is_unfinished { walk.open } else { 0 })
    }

    /// Whether a triangle blocks the segment from `origin`, by definition.
    #[inline(never)]
    pub(super) fn exact(&self, origin: DVec3, triangle: u32) -> bool {
        let [a, b, c] = self.bvh.corners(triangle);
        let corners = [Point::exact(a), Point::exact(b), Point::exact(c)];
        if let Some(blocks) = polygon_blocks_filter(&corners, &Point::exact(origin), &self.light) {
            count(Level::Double, 1);
            return blocks;
        }
        polygon_blocks::<Dyadic>(&corners, &Probe::at(origin), &self.light)
    }

    #[inline(always)]
    fn way(&self, origin: DVec3) -> Way {
        Way::towards(&self.light, origin, 0.0)
    }

    /// Whether a triangle of the pack blocks the segment from `origin`; `ask` hears of each one in doubt.
    #[inline(always)]
    fn resolve<S: Simd>(&self, simd: S, origin: DVec3, pack: &Pack, mut ask: impl FnMut()) -> bool {
        let parts = &self.bvh.parts;
        let Some(ray) = LocalRay::new(&parts.frame, &self.way(origin), parts.corner_error) else { return false };
        let verdicts = pack_test::test(simd, pack, &ray);
        let decide = |triangle| {
            ask();
            self.exact(origin, triangle)
        };
        verdicts.hits != 0 || verdicts.any_doubt(pack, decide)
    }

    /// The segment on its own: the pack that blocks it.
    #[inline(always)]
    fn single<S: Simd>(
        &self,
        simd: S,
        origin: DVec3,
        first: Option<u32>,
        stack: &mut Stack,
        mut ask: impl FnMut(),
    ) -> Option<u32> {
        let decide = |triangle| {
            ask();
            self.exact(origin, triangle)
        };
        (&mut AnyHit { parts: &self.bvh.parts, way: &self.way(origin), first, stack, decide }).run(simd)
    }
}
