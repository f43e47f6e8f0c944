//! Nearest hit: which triangle does the ray meet first? For pictures.
//!
//! The f32 filter leaves out what is certainly missed; the rest is measured by [`TriangleRay`]. Equal t goes to the lower
//! triangle, so the answer does not depend on the tree. Near boxes are visited first.

use umbriel_geometry::simd::{Float, Kernel, Mask, Simd};

use super::{
    TriangleBvh,
    boxes::box_spans,
    build::MAX_DEPTH,
    layout::WIDTH,
    pack_test,
    ray::{LocalRay, OUTWARD},
    triangle_ray::{Hit, TriangleRay},
};

/// A box to be visited, and where the ray enters it.
#[derive(Clone, Copy, Default)]
struct Visit {
    enter: f32,
    child: u32,
    is_leaf: bool,
}

/// Finds the nearest hit for 0 < t ≤ `t_max`.
pub(super) struct Nearest<'a> {
    pub(super) bvh: &'a TriangleBvh,
    pub(super) ray: TriangleRay,
    pub(super) local: LocalRay,
    pub(super) t_max: f64,
}

impl Kernel for Nearest<'_> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> Option<Hit> {
        let mut nearest = None;
        let mut stack = [Visit::default(); WIDTH * MAX_DEPTH];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let Visit { enter, child, is_leaf } = stack[depth];
            if enter > self.local.box_end * OUTWARD {
                continue;
            }
            if is_leaf {
                self.measure(simd, child, &mut nearest);
                continue;
            }
            let node = &self.bvh.parts.nodes[child as usize];
            let (enter, met) = box_spans(simd, node, &self.local);
            let (enter, mut met) = (enter.to_array(), met.bits());
            let first = depth;
            while met != 0 {
                let lane = met.trailing_zeros() as usize % WIDTH;
                met &= met - 1;
                let is_leaf = node.leaves >> lane & 1 == 1;
                stack[depth] = Visit { enter: enter[lane], child: node.children[lane], is_leaf };
                depth += 1;
            }
            far_first(&mut stack[first..depth]);
        }
        nearest
    }
}

/// Sorts a few visits so that the nearest is popped first.
#[inline(always)]
fn far_first(visits: &mut [Visit]) {
    for end in 1..visits.len() {
        let mut at = end;
        while at > 0 && visits[at - 1].enter < visits[at].enter {
            visits.swap(at - 1, at);
            at -= 1;
        }
    }
}

impl Nearest<'_> {
    /// Measures the triangles of a pack that are not certainly missed.
    #[inline(always)]
    fn measure<S: Simd>(&mut self, simd: S, pack: u32, nearest: &mut Option<Hit>) {
        let pack = &self.bvh.parts.packs[pack as usize];
        let verdicts = pack_test::test(simd, pack, &self.local);
        let mut candidates = verdicts.hits | verdicts.doubts;
        while candidates != 0 {
            let triangle = pack.triangles[candidates.trailing_zeros() as usize % WIDTH];
            candidates &= candidates - 1;
            self.measure_one(triangle, nearest);
        }
    }

    fn measure_one(&mut self, triangle: u32, nearest: &mut Option<Hit>) {
        let is_nearer = |hit: &Hit| {
            hit.t < self.t_max || hit.t == self.t_max && nearest.is_none_or(|known| known.triangle > triangle)
        };
        if let Some(hit) = self.ray.hit(self.bvh.corners(triangle), triangle).filter(is_nearer) {
            self.t_max = hit.t;
            self.local.stop_at(hit.t);
            *nearest = Some(hit);
        }
    }
}
