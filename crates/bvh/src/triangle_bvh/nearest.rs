//! Nearest hit: which triangle does the ray meet first? For pictures.
//!
//! The f32 filter leaves out what is certainly missed; the rest is measured by the watertight test of Woop, Benthin
//! and Wald, "Watertight ray/triangle intersection", Journal of Computer Graphics Techniques 2(1), 2013, in f64. The
//! corners are sheared so that the ray becomes the z axis; the edge functions of two triangles that share an edge are
//! then exact negatives of one another, and zero counts as inside, so no ray slips between them. What breaks it: a
//! triangle that the ray sees edge-on is not hit, and t is a rounded number. Equal t goes to the lower triangle, so the
//! answer does not depend on the tree. Near boxes are visited first.

use glam::DVec3;
use umbriel_geometry::{
    Aabb,
    simd::{Float, Kernel, Mask, Simd},
};

use super::{
    TriangleBvh,
    boxes::box_spans,
    build::MAX_DEPTH,
    layout::WIDTH,
    pack_test,
    ray::{LocalRay, OUTWARD},
};
use crate::ray::Ray;

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Which triangle.
    pub triangle: u32,
    /// Parameter along the ray: the point is `origin + t direction`, rounded.
    pub t: f64,
    /// Weight of the triangle's second corner.
    pub u: f64,
    /// Weight of its third corner.
    pub v: f64,
}

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
    pub(super) ray: Ray,
    pub(super) local: LocalRay,
    pub(super) shear: Shear,
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
        let corners = self.bvh.corners(triangle);
        let Some(span) = self.ray.span(&Aabb::of(corners)) else { return };
        let is_nearer = |hit: &Hit| {
            hit.t < self.t_max || hit.t == self.t_max && nearest.is_none_or(|known| known.triangle > triangle)
        };
        if let Some(hit) = self.shear.hit(corners, triangle, span).filter(is_nearer) {
            self.t_max = hit.t;
            self.local.stop_at(hit.t);
            *nearest = Some(hit);
        }
    }
}

/// The change of coordinates that turns a ray into the unit z axis.
pub(super) struct Shear {
    origin: DVec3,
    axes: [usize; 3],
    /// Factors for x and y, and the scale of z.
    factors: DVec3,
}

impl Shear {
    /// `None` when there is no direction.
    pub(super) fn new(origin: DVec3, direction: DVec3) -> Option<Self> {
        let size = direction.abs();
        let z = (1..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best });
        if size[z].is_nan() || size[z] == 0.0 {
            return None;
        }
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let factors = DVec3::new(direction[x] / direction[z], direction[y] / direction[z], 1.0 / direction[z]);
        Some(Self { origin, axes: [x, y, z], factors })
    }

    /// A corner in the ray's coordinates. The same corner gets the same coordinates in every triangle.
    fn apply(&self, corner: DVec3) -> DVec3 {
        let away = corner - self.origin;
        let [x, y, z] = self.axes.map(|axis| away[axis]);
        DVec3::new(x - self.factors.x * z, y - self.factors.y * z, self.factors.z * z)
    }

    /// The hit with one triangle. `span` is where the ray is in the triangle's box, and t is kept inside: this undoes
    /// part of the rounding and makes the order of hits that of the boxes.
    fn hit(&self, corners: [DVec3; 3], triangle: u32, span: (f64, f64)) -> Option<Hit> {
        let [a, b, c] = corners.map(|corner| self.apply(corner));
        let weights = DVec3::new(cross(c, b), cross(a, c), cross(b, a));
        if weights.min_element() < 0.0 && weights.max_element() > 0.0 {
            return None;
        }
        let sum = weights.x + weights.y + weights.z;
        let t = weights.dot(DVec3::new(a.z, b.z, c.z)) / sum;
        // Zero over zero for an edge-on triangle is neither.
        (t > 0.0).then(|| Hit { triangle, t: t.min(span.1).max(span.0), u: weights.y / sum, v: weights.z / sum })
    }
}

/// Twice the area that the origin spans with a and b, seen along z.
fn cross(a: DVec3, b: DVec3) -> f64 {
    a.x * b.y - a.y * b.x
}
