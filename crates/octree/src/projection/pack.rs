//! Eight triangles against a ray of the viewpoint, in f32: certainly met, in doubt, certainly missed.
//!
//! All rays share their origin (or direction), so what depends on the triangle alone is computed once. A corner is a
//! homogeneous point h of the face: its local coordinates, or (x, y, 1) for parallel rays. The ray d = (u, v, 1) meets the
//! triangle when the three edge functions N_a·d, N_a = h_b × h_c and so on, have the sign of D = h_a·N_a; the *nearness* of the plane
//! along d, 1/depth or −depth, is linear in d too: m·d with m = Σ k_a·N_a / D, k the corners' nearness times the factor that
//! makes h: 1, or −z (Blinn and Newell, "Clipping using homogeneous coordinates", SIGGRAPH 1978, for the coordinates;
//! Pineda, "A parallel algorithm for polygon rasterization", SIGGRAPH 1988, for the functions).
//!
//! *Errors.* Let H bound the corners' coordinates, δ their error, u = 2^-53, U = 2^-24.
//!
//! - N: two products of at most H² and a difference: 4u·2H² rounded, 4δH + 2δ² from the input: [`cross_error`].
//! - D: 3(H·ε + δ·|N|) + 6u·H·|N|, ε the error of N, |N| its sum of sizes. A triangle whose |D| is not four times that is
//!   edge-on: all is in doubt.
//! - Edge functions are scaled to |N| = 1. An edge with 3ε above U is always in doubt; for others rounding N and d to
//!   f32 costs 1U each, the direction's own error (at most [`MAX_SPREAD`] = U/4) and ε as much again, three products and two sums 3U: below
//!   [`EDGE_MARGIN`] = 8U, as |d| ≤ 1.
//! - m: with k relative to the first corner's for parallel rays, (Σ|k|ε + 2δ|N| + 4uΣ|k||N|)/|D| + |m|·(error of D)/|D| + δ;
//!   in f32 as above 8U·|m| more. Where that is no finite number nothing is known of the depth.

use glam::DVec3;
use umbriel_geometry::simd::{Float, Mask, Simd};

use super::frame::Kind;

/// Triangles of a pack.
pub(super) const WIDTH: usize = 8;

/// U of the header.
const U: f64 = f32::EPSILON as f64 / 2.0;

/// What an edge function may be off by.
const EDGE_MARGIN: f32 = 4.0 * f32::EPSILON;

/// Directions that are known less well are not tested here.
pub(super) const MAX_SPREAD: f64 = U / 4.0;

/// Larger nearness is left in doubt: it might overflow.
const MAX_NEARNESS: f64 = (1u64 << 60) as f64;

/// Up to eight triangles. Lanes that are left over repeat the first one. Seven cache lines.
// | edge functions: edge, axis, lane | nearness: axis, lane | its error | triangles |
// |               288                |          96          |    32     |    32     |
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Pack {
    edges: [[[f32; WIDTH]; 3]; 3],
    nearness: [[f32; WIDTH]; 3],
    nearness_error: [f32; WIDTH],
    pub(super) triangles: [u32; WIDTH],
}

const _: () = assert!(size_of::<Pack>() == 448);

/// A triangle's functions.
#[derive(Clone, Copy, Debug)]
struct Functions {
    edges: [DVec3; 3],
    nearness: DVec3,
    nearness_error: f64,
}

impl Functions {
    /// Of a triangle of which nothing is known.
    const IN_DOUBT: Self = Self { edges: [DVec3::ZERO; 3], nearness: DVec3::ZERO, nearness_error: f64::INFINITY };

    /// Of local corners, each coordinate off by `error` at most.
    fn new(corners: [DVec3; 3], error: f64, kind: Kind) -> Self {
        let is_parallel = kind == Kind::Parallel;
        let [a, b, c] = if is_parallel { corners.map(|corner| corner.with_z(1.0)) } else { corners };
        let size = a.abs().max(b.abs()).max(c.abs()).max_element();
        let normals = [b.cross(c), c.cross(a), a.cross(b)];
        let normal_error = cross_error(size, error);
        let sums = normals.map(|normal| normal.abs().element_sum());
        let volume = a.dot(normals[0]);
        let volume_error = 3.0 * (size * normal_error + error * sums[0]) + 6.0 * f64::EPSILON * size * sums[0];
        let is_known = volume.abs() > 4.0 * volume_error;
        if !is_known {
            return Self::IN_DOUBT;
        }
        let edge = |n: usize| {
            let is_known = 3.0 * normal_error <= U * sums[n];
            if is_known { normals[n] * (volume.signum() / sums[n]) } else { DVec3::ZERO }
        };
        let weights = if is_parallel { corners.map(|corner| corners[0].z - corner.z) } else { [1.0; 3] };
        let base = if is_parallel { DVec3::NEG_Z * corners[0].z } else { DVec3::ZERO };
        let slope = (0..3).fold(DVec3::ZERO, |sum, n| sum + normals[n] * weights[n]) / volume;
        let total = |term: &dyn Fn(usize) -> f64| (0..3).map(term).sum::<f64>();
        let own = total(&|n| weights[n].abs() * (normal_error + 4.0 * f64::EPSILON * sums[n]));
        let input = if is_parallel { total(&|n| 2.0 * error * sums[n]) } else { 0.0 };
        let slope_sum = slope.abs().element_sum();
        // Three components, each off by as much.
        let slope_error = (3.0 * own + input + slope_sum * volume_error) / volume.abs();
        let nearness = slope + base;
        let scale = nearness.abs().element_sum() + slope_sum;
        let nearness_error = slope_error * (1.0 + 8.0 * U) + error + 8.0 * U * scale;
        let is_tame = scale < MAX_NEARNESS && nearness_error < MAX_NEARNESS;
        let (nearness, nearness_error) =
            if is_tame { (nearness, nearness_error) } else { (DVec3::ZERO, f64::INFINITY) };
        Self { edges: [edge(0), edge(1), edge(2)], nearness, nearness_error }
    }
}

/// What a component of a cross product may be off by, of vectors with components of at most `size`, off by `error`.
fn cross_error(size: f64, error: f64) -> f64 {
    4.0 * f64::EPSILON * size * size + error * (4.0 * size + 2.0 * error)
}

/// What a ray is tested with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    /// Its direction.
    pub(super) direction: [f32; 3],
    /// Planes that are certainly farther than the first or nearer than the second are of no interest. For segments to the
    /// viewpoint: the bounds of the end's nearness.
    pub(super) nearness: [f32; 2],
}

impl Probe {
    #[inline(always)]
    pub(super) fn new(direction: DVec3, nearness: [f32; 2]) -> Self {
        let DVec3 { x, y, z } = direction;
        Self { direction: [x as f32, y as f32, z as f32], nearness }
    }
}

/// What is known of a pack's triangles, one bit each; the others are certainly missed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Verdicts {
    /// Certainly met, certainly nearer than the probe's end.
    pub(super) hits: u32,
    /// In doubt.
    pub(super) doubts: u32,
}

impl Pack {
    /// Of at least one and at most eight triangles, given with their local corners.
    pub(super) fn new(triangles: impl Iterator<Item = (u32, [DVec3; 3])>, error: f64, kind: Kind) -> Self {
        let mut pack = Self {
            edges: [[[0.0; WIDTH]; 3]; 3],
            nearness: [[0.0; WIDTH]; 3],
            nearness_error: [f32::INFINITY; WIDTH],
            triangles: [0; WIDTH],
        };
        for (filled, (name, corners)) in triangles.take(WIDTH).enumerate() {
            let functions = Functions::new(corners, error, kind);
            // The lanes that are left over are the first triangle's.
            let lanes = if filled == 0 { 0..WIDTH } else { filled..filled + 1 };
            lanes.for_each(|lane| pack.set(lane, name, &functions));
        }
        pack
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, name: u32, functions: &Functions) {
        self.triangles[lane] = name;
        for axis in 0..3 {
            for edge in 0..3 {
                self.edges[edge][axis][lane] = functions.edges[edge][axis] as f32;
            }
            self.nearness[axis][lane] = functions.nearness[axis] as f32;
        }
        self.nearness_error[lane] = (functions.nearness_error as f32).next_up();
    }

    /// Segments to the viewpoint: what is certainly met between its ends, and what is in doubt.
    #[inline(always)]
    pub(super) fn test_segment<S: Simd>(&self, simd: S, probe: &Probe) -> Verdicts {
        let least = self.least(simd, probe);
        let maybe = !least.lt(simd.splat8(-EDGE_MARGIN));
        if !maybe.any() {
            return Verdicts { hits: 0, doubts: 0 };
        }
        let (nearness, error) = (self.nearness_at(simd, probe), simd.load(&self.nearness_error));
        let [low, high] = probe.nearness.map(|nearness| simd.splat8(nearness));
        let hits = (least.gt(simd.splat8(EDGE_MARGIN)) & (nearness - error).gt(high)).bits();
        let doubts = (maybe & !(nearness + error).lt(low)).bits() & !hits;
        Verdicts { hits, doubts }
    }

    /// Rays: what may be met between the probe's bounds.
    #[inline(always)]
    pub(super) fn test_ray<S: Simd>(&self, simd: S, probe: &Probe) -> u32 {
        let maybe = !self.least(simd, probe).lt(simd.splat8(-EDGE_MARGIN));
        if !maybe.any() {
            return 0;
        }
        let (nearness, error) = (self.nearness_at(simd, probe), simd.load(&self.nearness_error));
        let [low, high] = probe.nearness.map(|nearness| simd.splat8(nearness));
        (maybe & !(nearness + error).lt(low) & !(nearness - error).gt(high)).bits()
    }

    /// The least edge function.
    #[inline(always)]
    fn least<S: Simd>(&self, simd: S, probe: &Probe) -> umbriel_geometry::simd::F8<S> {
        let [x, y, z] = probe.direction;
        let (x, y, z) = (simd.splat8(x), simd.splat8(y), simd.splat8(z));
        let [a, b, c] = &self.edges;
        let a = simd.load(&a[0]) * x + simd.load(&a[1]) * y + simd.load(&a[2]) * z;
        let b = simd.load(&b[0]) * x + simd.load(&b[1]) * y + simd.load(&b[2]) * z;
        let c = simd.load(&c[0]) * x + simd.load(&c[1]) * y + simd.load(&c[2]) * z;
        a.min(b).min(c)
    }

    #[inline(always)]
    fn nearness_at<S: Simd>(&self, simd: S, probe: &Probe) -> umbriel_geometry::simd::F8<S> {
        let [x, y, z] = probe.direction;
        let [m, n, o] = &self.nearness;
        simd.load(m) * simd.splat8(x) + simd.load(n) * simd.splat8(y) + simd.load(o) * simd.splat8(z)
    }
}
