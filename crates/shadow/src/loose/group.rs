//! Eight triangles against one point, in the coordinates of a cell.
//!
//! All is in units of half a cell, from its middle: |s|, |t| ≤ 1 inside. Comparisons leave a margin on both sides, so each
//! triangle is certainly in the way, certainly not, or in doubt.
//!
//! **Margins.** With |a| + |b| ≤ 1, |s|, |t| ≤ 1 and c cut to at most 4, the value (a·s + b·t) + c is rounded five times in
//! f32 (unit roundoff v = 2^-24): products together by v, sums by 2v and by at most 6v, and the coefficients are rounded
//! by v·(1 + |c|) ≤ 5v; s and t by v/2. Where the decision is near, |value| < 1, |c| ≤ 2 and all of it is below 8v. Where
//! |value| ≥ 1 the error is below 16v, so the sign stands with every margin below 1/2. [`EDGE_MARGIN`] is 16v = 2^-20,
//! which leaves 8v for the error of the f64 edge function (checked when the group is made).
//!
//! The plane's value (p·s + q·t) + r is off by at most 8v·(|p| + |q| + |r|), and by |p| + |q| times what s and t are off. Near
//! the decision r is as large as the point's nearness n, give or take |p| + |q| and the margin itself. So the margin
//! slope·(place + 2^-19) + |n|·2^-19 + height holds, where `place` and `height` are what the point's (s, t) and n are off by, and
//! `slope` is |p| + |q| and 2^19 times the error of the f64 plane.

use umbriel_geometry::simd::{Float, Lanes, Mask, Simd};

/// How far inside or outside an edge counts as certain, beside what the point is off by; units of half a cell.
pub(super) const EDGE_MARGIN: f32 = 1.0 / (1u32 << 20) as f32;
/// The same for nearness, in parts of it.
pub(super) const NEARNESS_MARGIN: f32 = 1.0 / (1u32 << 19) as f32;
/// Edge functions that are greater all over the cell are cut to this.
pub(super) const EDGE_LIMIT: f64 = 4.0;

/// Eight triangles; lanes that are not used have an edge that is −4 everywhere.
///
/// | edges: a, b, c, 3 × 96 | p, q, r 96 | slope 32 | pieces 32 | nearest, padding 32 |   bytes
#[repr(C, align(32))]
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) edges: [[[f32; 8]; 3]; 3],
    pub(super) plane: [[f32; 8]; 3],
    pub(super) slope: [f32; 8],
    pub(super) pieces: [u32; 8],
    /// No point of these triangles, or of those of later groups of the cell, is nearer inside the cell.
    pub(super) nearest: f32,
}

const _: () = assert!(size_of::<Group>() == 480 && align_of::<Group>() == 32);

/// A point in the coordinates of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellPoint {
    pub(super) s: f32,
    pub(super) t: f32,
    pub(super) nearness: f32,
    /// What s and t are off by, and a bound for them as parts of the point's slack box.
    pub(super) place: f32,
    /// What the nearness is off by, with its share of [`NEARNESS_MARGIN`].
    pub(super) height: f32,
}

/// What one group says about one point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Said {
    /// One of the triangles stands between every point of the slack box and the light.
    Blocked,
    /// These lanes may stand in the way, or meet the slack box; the others do not.
    Doubt(u32),
}

impl Group {
    /// A group without triangles.
    pub(super) const EMPTY: Self = Self {
        edges: [[[0.0; 8], [0.0; 8], [-4.0; 8]]; 3],
        plane: [[0.0; 8]; 3],
        slope: [0.0; 8],
        pieces: [0; 8],
        nearest: f32::NEG_INFINITY,
    };

    /// Tests all eight.
    #[inline(always)]
    pub(super) fn test<S: Simd>(&self, simd: S, point: &CellPoint) -> Said {
        let (s, t) = (simd.splat8(point.s), simd.splat8(point.t));
        let affine = |[a, b, c]: &[[f32; 8]; 3]| (simd.load(a) * s + simd.load(b) * t) + simd.load(c);
        let inside = affine(&self.edges[0]).min(affine(&self.edges[1])).min(affine(&self.edges[2]));
        let margin = EDGE_MARGIN + point.place;
        let ahead = affine(&self.plane) - simd.splat8(point.nearness);
        let slack = simd.load(&self.slope) * simd.splat8(point.place + NEARNESS_MARGIN) + simd.splat8(point.height);
        let is_blocked = inside.gt(simd.splat8(margin)) & ahead.gt(slack);
        let is_clear = inside.lt(simd.splat8(-margin)) | ahead.lt(-slack);
        if is_blocked.any() { Said::Blocked } else { Said::Doubt((!is_clear).bits()) }
    }
}
