//! Nearest hit: which triangle does the ray meet first? For pictures.
//!
//! The f32 filter leaves out what is certainly missed; the rest is measured by [`TriangleRay`]. Equal t goes to the lower
//! triangle, so the answer does not depend on the tree. Near boxes are visited first.

use std::ops::Add;

use umbriel_geometry::simd::{Float, Kernel, Mask, Simd};

use super::{
    TriangleBvh,
    boxes::box_spans,
    layout::WIDTH,
    pack_test,
    ray::{LocalRay, OUTWARD, Way},
    triangle_ray::{Hit, TriangleRay},
};

/// A box to be visited, and where the ray enters it.
#[derive(Clone, Copy, Default)]
pub(super) struct Visit {
    pub(super) enter: f32,
    /// What is in the box, in whatever way the search names it.
    pub(super) link: u32,
}

const _: () = assert!(size_of::<Visit>() == 8);

/// Marks packs among links to nodes and packs.
const LEAF: u32 = 1 << 31;

/// Visits that rays wait with as a rule. Clearing room for all that a tree may ask for would take longer than some rays.
const USUAL: usize = 48;

/// The boxes that are still to be visited, the last one first.
pub(super) struct Waiting {
    usual: [Visit; USUAL],
    count: usize,
    /// What has no room there; newer than all of it.
    more: Vec<Visit>,
}

impl Waiting {
    pub(super) fn new() -> Self {
        Self { usual: [Visit::default(); USUAL], count: 0, more: Vec::new() }
    }

    #[inline(always)]
    fn push(&mut self, visit: Visit) {
        if self.count < USUAL {
            self.usual[self.count] = visit;
            self.count += 1;
        } else {
            self.more.push(visit);
        }
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<Visit> {
        if self.count == USUAL
            && let Some(visit) = self.more.pop()
        {
            return Some(visit);
        }
        self.count = self.count.checked_sub(1)?;
        Some(self.usual[self.count % USUAL])
    }

    /// The nearest of the children that are met, a bit each; the others wait, the farthest longest.
    #[inline(always)]
    pub(super) fn nearest_of(
        &mut self,
        mut met: u32,
        enter: [f32; WIDTH],
        link: impl Fn(usize) -> u32,
    ) -> Option<Visit> {
        if met == 0 {
            return None;
        }
        let mut visit = || {
            let lane = met.trailing_zeros() as usize % WIDTH;
            met &= met - 1;
            (Visit { enter: enter[lane], link: link(lane) }, met != 0)
        };
        let (first, has_more) = visit();
        if !has_more {
            return Some(first);
        }
        let mut sorted = [first; WIDTH];
        let mut count = 1;
        loop {
            let (next, has_more) = visit();
            let mut at = count;
            while at > 0 && sorted[at - 1].enter < next.enter {
                sorted[at] = sorted[at - 1];
                at -= 1;
            }
            sorted[at] = next;
            count += 1;
            if !has_more {
                break;
            }
        }
        sorted[..count - 1].iter().for_each(|&visit| self.push(visit));
        Some(sorted[count - 1])
    }
}

/// What the search for a nearest hit looked at: its cost, whatever the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Steps {
    /// Nodes, of eight boxes each.
    pub nodes: u32,
    /// Packs of eight triangles, tested in f32.
    pub packs: u32,
    /// Triangles that were measured in f64.
    pub triangles: u32,
    /// Rays that hit something.
    pub hits: u32,
}

impl Add for Steps {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            nodes: self.nodes + other.nodes,
            packs: self.packs + other.packs,
            triangles: self.triangles + other.triangles,
            hits: self.hits + other.hits,
        }
    }
}

/// Finds the nearest hit for 0 < t ≤ `t_max`.
pub(super) struct Nearest<'a, const COUNTED: bool> {
    pub(super) bvh: &'a TriangleBvh,
    pub(super) way: Way,
    pub(super) local: LocalRay,
    /// Made ready for triangles when the first is measured: most rays of a picture meet the boxes of none, or of one.
    pub(super) ray: Option<TriangleRay>,
    pub(super) t_max: f64,
    /// The nearest so far.
    pub(super) hit: Option<Hit>,
    /// Stays zero unless `COUNTED`; without the hit.
    pub(super) steps: Steps,
}

// Through a reference, which goes into the kernel in a register.
impl<const COUNTED: bool> Kernel for &mut Nearest<'_, COUNTED> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let mut waiting = Waiting::new();
        let mut next = Some(Visit::default());
        while let Some(Visit { enter, link }) = next {
            if enter > self.local.box_end * OUTWARD {
                next = waiting.pop();
            } else if link & LEAF != 0 {
                self.measure(simd, link & !LEAF);
                next = waiting.pop();
            } else {
                self.steps.nodes += u32::from(COUNTED);
                next = self.open(simd, link, &mut waiting).or_else(|| waiting.pop());
            }
        }
    }
}

impl<const COUNTED: bool> Nearest<'_, COUNTED> {
    /// What was looked at.
    pub(super) fn steps(&self) -> Steps {
        Steps { hits: u32::from(self.hit.is_some()), ..self.steps }
    }

    /// The nearest child that the ray may meet; the others wait.
    #[inline(always)]
    fn open<S: Simd>(&self, simd: S, node: u32, waiting: &mut Waiting) -> Option<Visit> {
        let node = &self.bvh.parts.nodes[node as usize];
        let (enter, met) = box_spans(simd, node, &self.local);
        let link = |lane: usize| node.children[lane] | ((node.leaves >> lane & 1) * LEAF);
        waiting.nearest_of(met.bits(), enter.to_array(), link)
    }

    /// Measures the triangles of a pack that are not certainly missed.
    #[inline(always)]
    pub(super) fn measure<S: Simd>(&mut self, simd: S, pack: u32) {
        self.steps.packs += u32::from(COUNTED);
        let pack = &self.bvh.parts.packs[pack as usize];
        // Whether it is nearer tells the measure.
        let mut candidates = pack_test::crossed(simd, pack, &self.local);
        while candidates != 0 {
            let triangle = pack.triangles[candidates.trailing_zeros() as usize % WIDTH];
            candidates &= candidates - 1;
            self.measure_one(triangle);
        }
    }

    fn measure_one(&mut self, triangle: u32) {
        self.steps.triangles += u32::from(COUNTED);
        let is_nearer = |hit: &Hit| {
            hit.t < self.t_max || hit.t == self.t_max && self.hit.is_none_or(|known| known.triangle > triangle)
        };
        if self.ray.is_none() {
            self.ray = TriangleRay::new(self.way.origin, self.way.direction);
        }
        let Some(ray) = &self.ray else { return };
        if let Some(hit) = ray.hit_within(self.bvh.corners(triangle), triangle, self.t_max).filter(is_nearer) {
            self.t_max = hit.t;
            self.local.stop_at(hit.t);
            self.hit = Some(hit);
        }
    }
}
