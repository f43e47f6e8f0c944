//! Eight occluders side by side, and the test of samples against them.
//!
//! Coordinates are floats, relative to the middle of a part of the window. A sample is blocked for certain when it is
//! inside a triangle and behind it by more than the errors, unblocked for certain when it is outside of an edge or
//! before the plane by more than the errors; else the pair is in doubt and must be decided exactly. NUMERICS.md, "Pairs of images".

use umbriel_geometry::simd::{F8, Float, M8, Mask, Simd};

use super::{
    soup::{Area, NEAR, Occluder},
    view::{Image, View},
};

/// How far an edge function may be off. Each difference of a corner and a sample is below 2·reach and off by
/// 2·error + 16u·reach; a product of two is rounded, and so is the difference of two products.
pub(super) fn tolerance(reach: f32, error: f32) -> f32 {
    (16.0 * error + 160.0 * ROUNDOFF * reach) * reach * 1.01
}

/// Unit roundoff of f32.
const ROUNDOFF: f32 = f32::EPSILON / 2.0;

/// Lanes of a pack.
pub(super) const LANES: usize = 8;

/// Eight triangles, counter-clockwise, relative to the middle of an area.
#[derive(Clone, Debug)]
pub(super) struct Pack {
    x: [[f32; LANES]; 3],
    y: [[f32; LANES]; 3],
    depth: [[f32; LANES]; 3],
    /// How far an edge function may be off.
    tolerance: [f32; LANES],
    /// Infinite where the triangle is so thin that its turn is in doubt: its plane then tells nothing. Else 0.
    thin: [f32; LANES],
    low: [[f32; LANES]; 2],
    high: [[f32; LANES]; 2],
    nearest: [f32; LANES],
    /// Numbers of the occluders in their tile.
    pub(super) items: [u32; LANES],
    /// The least depth of all lanes.
    pub(super) least: f32,
}

/// A sample, or eight, as the filter sees them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Samples<V> {
    pub(super) x: V,
    pub(super) y: V,
    pub(super) depth: V,
}

/// What the filter says of pairs, a lane each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome<M> {
    pub(super) blocked: M,
    pub(super) doubtful: M,
}

/// Triangles in the lanes of vectors.
struct Triangles<V> {
    x: [V; 3],
    y: [V; 3],
    depth: [V; 3],
    tolerance: V,
    thin: V,
}

impl Pack {
    /// Lanes that block nothing.
    fn empty() -> Self {
        let zero = [[0.0; LANES]; 3];
        Self {
            x: zero,
            y: zero,
            depth: zero,
            tolerance: [-1.0; LANES],
            thin: [0.0; LANES],
            low: [[f32::INFINITY; LANES]; 2],
            high: [[f32::NEG_INFINITY; LANES]; 2],
            nearest: [f32::INFINITY; LANES],
            items: [u32::MAX; LANES],
            least: f32::INFINITY,
        }
    }

    /// The occluders in packs, in the given order.
    pub(super) fn fill(packs: &mut Vec<Self>, occluders: &[Occluder], order: &[u32], area: &Area, view: &View) {
        packs.clear();
        let middle = area.center.map(|x| x as i32);
        let least_reach = (NEAR * area.half[0].max(area.half[1])) as f32;
        for items in order.chunks(LANES) {
            let mut pack = Self::empty();
            for (lane, &item) in items.iter().enumerate() {
                pack.set(lane, item, &occluders[item as usize].corners, middle, (least_reach, view.error as f32));
            }
            packs.push(pack);
        }
    }

    fn set(&mut self, lane: usize, item: u32, corners: &[Image; 3], middle: [i32; 2], (reach, error): (f32, f32)) {
        let [a, b, c] = corners;
        let cross = |p: &Image, q: &Image| {
            let away = |r: &Image| [i64::from(r.x) - i64::from(a.x), i64::from(r.y) - i64::from(a.y)];
            let ([px, py], [qx, qy]) = (away(p), away(q));
            px * qy - py * qx
        };
        let doubled = cross(b, c);
        let corners = if doubled < 0 { [a, c, b] } else { [a, b, c] };
        let mut reach = reach;
        for (k, corner) in corners.into_iter().enumerate() {
            let (x, y) = ((corner.x - middle[0]) as f32, (corner.y - middle[1]) as f32);
            reach = reach.max(x.abs()).max(y.abs());
            (self.x[k][lane], self.y[k][lane], self.depth[k][lane]) = (x, y, corner.depth);
            (self.low[0][lane], self.low[1][lane]) = (self.low[0][lane].min(x), self.low[1][lane].min(y));
            (self.high[0][lane], self.high[1][lane]) = (self.high[0][lane].max(x), self.high[1][lane].max(y));
            self.nearest[lane] = self.nearest[lane].min(corner.depth);
        }
        let tolerance = tolerance(reach, error);
        let is_thin = doubled.unsigned_abs() as f32 <= 8.0 * tolerance;
        (self.tolerance[lane], self.thin[lane]) =
            if is_thin { (4.0 * tolerance, f32::INFINITY) } else { (tolerance, 0.0) };
        self.items[lane] = item;
        self.least = self.least.min(self.nearest[lane]);
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S) -> Triangles<F8<S>> {
        let load = |values: &[[f32; LANES]; 3]| [simd.load(&values[0]), simd.load(&values[1]), simd.load(&values[2])];
        Triangles {
            x: load(&self.x),
            y: load(&self.y),
            depth: load(&self.depth),
            tolerance: simd.load(&self.tolerance),
            thin: simd.load(&self.thin),
        }
    }

    #[inline(always)]
    fn splat<S: Simd>(&self, simd: S, lane: usize) -> Triangles<F8<S>> {
        let splat = |values: &[[f32; LANES]; 3]| {
            [simd.splat8(values[0][lane]), simd.splat8(values[1][lane]), simd.splat8(values[2][lane])]
        };
        Triangles {
            x: splat(&self.x),
            y: splat(&self.y),
            depth: splat(&self.depth),
            tolerance: simd.splat8(self.tolerance[lane]),
            thin: simd.splat8(self.thin[lane]),
        }
    }

    /// One sample against all eight.
    #[inline(always)]
    pub(super) fn test_one<S: Simd>(&self, simd: S, sample: &Samples<f32>, depth_error: f32) -> Outcome<M8<S>> {
        let samples = Samples { x: simd.splat8(sample.x), y: simd.splat8(sample.y), depth: simd.splat8(sample.depth) };
        test(simd, &self.lanes(simd), &samples, depth_error)
    }

    /// Eight samples against one triangle.
    #[inline(always)]
    pub(super) fn test_eight<S: Simd>(
        &self,
        simd: S,
        lane: usize,
        samples: &Samples<F8<S>>,
        depth_error: f32,
    ) -> Outcome<M8<S>> {
        test(simd, &self.splat(simd, lane), samples, depth_error)
    }

    /// The lanes whose boxes meet the box low..high, widened by `margin`, and that are not beyond `farthest`.
    #[inline(always)]
    pub(super) fn overlapping<S: Simd>(&self, simd: S, low: [f32; 2], high: [f32; 2], farthest: f32) -> u32 {
        let apart = |k: usize| {
            let (least, most) = (simd.load(&self.low[k]), simd.load(&self.high[k]));
            most.lt(simd.splat8(low[k])) | least.gt(simd.splat8(high[k]))
        };
        let beyond = simd.load(&self.nearest).gt(simd.splat8(farthest));
        (!(apart(0) | apart(1) | beyond)).bits()
    }

    /// All eight against the convex hull of four points of a plane, seen from the front or the back.
    #[inline(always)]
    pub(super) fn test_hull<S: Simd>(&self, simd: S, hull: &[Samples<f32>; 4], depth_error: f32) -> Hold {
        let triangles = self.lanes(simd);
        let all = simd.mask8(0xff);
        let (mut outside, mut inside, mut nearer, mut beyond) = ([all; 3], all, all, [all; 2]);
        for point in hull {
            let samples = Samples { x: simd.splat8(point.x), y: simd.splat8(point.y), depth: simd.splat8(point.depth) };
            let weights = weights(&triangles, &samples);
            let [out_a, out_b, out_c] = weights.map(|weight| weight.lt(-triangles.tolerance));
            outside = [outside[0] & out_a, outside[1] & out_b, outside[2] & out_c];
            inside = inside & weights[0].min(weights[1]).min(weights[2]).gt(triangles.tolerance);
            let sides = plane_sides(simd, &triangles, &samples, weights, depth_error);
            nearer = nearer & sides[0];
            // Two reasons that must each hold at all points: they do not mix.
            beyond = [beyond[0] & sides[1], beyond[1] & sides[2]];
        }
        let missed = outside[0] | outside[1] | outside[2] | beyond[0] | beyond[1];
        Hold { missed: missed.bits(), covered: (inside & nearer).bits() }
    }
}

/// What is certain of eight triangles and a hull: edge functions and depths over a plane are affine in the image, so what holds
/// at the corners of a hull holds in all of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hold {
    /// The triangle blocks no point of the hull.
    pub(super) missed: u32,
    /// The triangle blocks every point of the hull.
    pub(super) covered: u32,
}

/// The edge functions at the samples: those opposite the first, second and third corner.
#[inline(always)]
fn weights<V: Float<8>>(triangles: &Triangles<V>, samples: &Samples<V>) -> [V; 3] {
    let [ax, bx, cx] = [triangles.x[0] - samples.x, triangles.x[1] - samples.x, triangles.x[2] - samples.x];
    let [ay, by, cy] = [triangles.y[0] - samples.y, triangles.y[1] - samples.y, triangles.y[2] - samples.y];
    [bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx]
}

/// Where the planes are certainly nearer than the samples, where they are certainly beyond, and where all corners are: the
/// mean of depth differences, weighted by the edge functions.
#[inline(always)]
fn plane_sides<S: Simd>(
    simd: S,
    triangles: &Triangles<F8<S>>,
    samples: &Samples<F8<S>>,
    weights: [F8<S>; 3],
    depth_error: f32,
) -> [M8<S>; 3] {
    let [a, b, c] =
        [triangles.depth[0] - samples.depth, triangles.depth[1] - samples.depth, triangles.depth[2] - samples.depth];
    let plane = weights[0] * a + weights[1] * b + weights[2] * c;
    let size = a.abs().max(b.abs()).max(c.abs());
    // Depths are off by `depth_error` and some roundings of their size; weights by the tolerance.
    let off = simd.splat8(depth_error) + simd.splat8(16.0 * ROUNDOFF) * (size + samples.depth.abs());
    let total = weights[0].abs() + weights[1].abs() + weights[2].abs();
    let slack = (total * off + simd.splat8(3.0) * triangles.tolerance * size) * simd.splat8(1.01) + triangles.thin;
    [plane.lt(-slack), plane.gt(slack), a.min(b).min(c).gt(off)]
}

/// The test of samples: edge functions, and where a sample may be inside, planes.
#[inline(always)]
fn test<S: Simd>(simd: S, triangles: &Triangles<F8<S>>, samples: &Samples<F8<S>>, depth_error: f32) -> Outcome<M8<S>> {
    let weights = weights(triangles, samples);
    let least = weights[0].min(weights[1]).min(weights[2]);
    let maybe = least.ge(-triangles.tolerance);
    let none = simd.mask8(0);
    if !maybe.any() {
        return Outcome { blocked: none, doubtful: none };
    }
    let [nearer, beyond, all_beyond] = plane_sides(simd, triangles, samples, weights, depth_error);
    let blocked = maybe & least.gt(triangles.tolerance) & nearer;
    Outcome { blocked, doubtful: maybe & !blocked & !(beyond | all_beyond) }
}
