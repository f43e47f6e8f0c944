//! Eight triangles against one point, in the coordinates of a tile.
//!
//! All is in units of half a tile, from its middle: |s|, |t| ≤ 1 inside. Comparisons leave a margin on both sides, so each
//! triangle is certainly in the way, certainly not, or in doubt.
//!
//! **Margins.** With |a| + |b| ≤ 1, |s|, |t| ≤ 1 and c cut to at most 4, the value (a·s + b·t) + c is rounded five times in
//! f32 (unit roundoff v = 2^-24): products together by v, sums by 2v and by at most 6v, and the coefficients are rounded
//! by v·(1 + |c|) ≤ 5v; s and t by v/2. Where the decision is near, |value| < 1, |c| ≤ 2 and all of it is below 8v. Where
//! |value| ≥ 1 the error is below 16v, so the sign stands with every margin below 1/2. [`EDGE_MARGIN`] is 16v = 2^-20,
//! which leaves 8v for the error of the f64 edge function. Squares ([`Strip`]) take a·s + (b·t + c), one v more where it is near; they are widened by far more than that.
//!
//! The plane's value (p·s + q·t) + r is off by at most 8v·(|p| + |q| + |r|), and by |p| + |q| times what s and t are off. Near
//! the decision r is as large as the point's nearness n, give or take |p| + |q| and the margin itself. The margin
//! (|p| + |q|)·(place + 2^-19) + height, where `place` is what s and t are off by and `height` what n is off by and
//! 2^-19·(|n| + unit), is 32v times these sizes; what remains is for the error of the f64 plane.

use umbriel_geometry::simd::{F8, Float, Lanes, M8, Mask, Simd};

use crate::{
    light_space::{Footprint, greater, lesser},
    loose::surface::Share,
};

/// How far inside or outside an edge counts as certain, beside what the point is off by; units of half a tile.
pub(super) const EDGE_MARGIN: f32 = 1.0 / (1u32 << 20) as f32;
/// The same for nearness, in parts of it, a sun's in parts of its unit.
pub(super) const NEARNESS_MARGIN: f32 = 1.0 / (1u32 << 19) as f32;
/// Edge functions that are greater all over the tile are cut to this.
const EDGE_LIMIT: f64 = 4.0;
/// What lies farther out than this from the tile's middle is put there: no cell comes near it.
const BEYOND: f64 = 4.0;

/// Eight triangles; lanes that are not used have an edge that is −4 everywhere.
///
/// | edges: a, b, c of the first 96 | of the second 96 | of the third 96 | plane: p, q, r 96 |   384 bytes, six cache lines
#[repr(C, align(64))]
#[derive(Clone, Debug)]
pub(super) struct Group {
    edges: [[[f32; 8]; 3]; 3],
    plane: [[f32; 8]; 3],
}

const _: () = assert!(size_of::<Group>() == 384 && align_of::<Group>() == 64);

/// A point in the coordinates of a tile.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TilePoint {
    pub(super) s: f32,
    pub(super) t: f32,
    pub(super) nearness: f32,
    /// What s and t are off by, the slack box included.
    pub(super) place: f32,
    /// What the nearness is off by, with its [`NEARNESS_MARGIN`].
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

/// `N` points in the coordinates of a tile; as for [`TilePoint`], lane by lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct TilePoints<S: Lanes<N>, const N: usize> {
    pub(super) s: S::Float,
    pub(super) t: S::Float,
    pub(super) nearness: S::Float,
    pub(super) place: S::Float,
    pub(super) height: S::Float,
}

/// A group along a row of squares of a tile: its functions in s alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strip<S: Simd> {
    /// Half a square's edge, widened: what matters to points of a square lies within.
    half: F8<S>,
    edges: [F8<S>; 3],
    plane: F8<S>,
    /// |p| + |q|.
    slope: F8<S>,
    /// Whose bounds meet the row.
    meets: M8<S>,
}

/// Where a group's triangles are, how near each comes and how far it reaches, and which hide nothing for certain: their planes are not known, or they have holes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// Of each lane: least s and t, greatest s and t, rounded outward.
    bounds: [[f32; 8]; 4],
    nearest: [f32; 8],
    farthest: [f32; 8],
    pub(super) vague: u8,
    /// Which are of closed surfaces, and which turn the other way round than by their winding.
    pub(super) closed: u8,
    pub(super) reversed: u8,
}

impl Extent {
    pub(super) const EMPTY: Self = Self {
        bounds: [[f32::INFINITY; 8], [f32::INFINITY; 8], [f32::NEG_INFINITY; 8], [f32::NEG_INFINITY; 8]],
        nearest: [f32::NEG_INFINITY; 8],
        farthest: [f32::INFINITY; 8],
        vague: 0,
        closed: 0,
        reversed: 0,
    };

    /// Puts a triangle into a lane.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, footprint: &Footprint) {
        let [u0, v0, u1, v1] = footprint.bounds;
        let [u0_to, v0_to, u1_to, v1_to] = &mut self.bounds;
        // Differences from a place in the tile round by less than what cells are widened by.
        (u0_to[lane], v0_to[lane]) = (-above(-greater(u0, -BEYOND)), -above(-greater(v0, -BEYOND)));
        (u1_to[lane], v1_to[lane]) = (above(lesser(u1, BEYOND)), above(lesser(v1, BEYOND)));
        self.nearest[lane] = above(greater(footprint.nearest, f64::from(f32::MIN)));
        self.farthest[lane] = -above(-footprint.farthest);
    }

    /// Leaves nothing in a lane that a cell could meet.
    #[inline(always)]
    pub(super) fn clear(&mut self, lane: usize) {
        for (to, empty) in self.bounds.iter_mut().zip(&Self::EMPTY.bounds) {
            to[lane] = empty[lane];
        }
        self.nearest[lane] = f32::NEG_INFINITY;
        self.vague &= !(1 << lane);
    }

    /// What these lanes may be to a sheet, given which the ray over the middle meets for certain and which it does not.
    #[inline(always)]
    fn share(&self, lanes: u8, met: u8, missed: u8) -> Share {
        let reversed = self.reversed & lanes;
        let is_known = lanes & (met | missed) & self.closed & !self.vague == lanes;
        let turns_one_way = reversed == 0 || reversed == lanes;
        if is_known && turns_one_way { Share::of((met & lanes).count_ones(), reversed != 0) } else { Share::NONE }
    }

    /// A rectangle that holds all.
    pub(super) fn bounds(&self) -> [f32; 4] {
        let [u0, v0, u1, v1] = &self.bounds;
        let least = |lanes: &[f32; 8]| lanes.iter().copied().fold(f32::INFINITY, f32::min);
        let most = |lanes: &[f32; 8]| lanes.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        [least(u0), least(v0), most(u1), most(v1)]
    }
}

/// What a group is to a square.
#[derive(Clone, Copy, Debug)]
pub(super) struct Over {
    /// No point of its triangles is nearer over the square.
    pub(super) nearest: f32,
    /// One of them covers the square and is nowhere less near; minus infinity if none does.
    pub(super) covered: f32,
    /// Which of them meet the square, a bit each.
    pub(super) lanes: u8,
    /// What these may be to a sheet over the square.
    pub(super) share: Share,
    /// None of them is less near over the square.
    pub(super) farthest: f32,
}

impl Group {
    /// A group without triangles.
    pub(super) const EMPTY: Self = Self { edges: [[[0.0; 8], [0.0; 8], [-4.0; 8]]; 3], plane: [[0.0; 8]; 3] };

    /// Puts a triangle into a lane. What is too far off is made vague: `unit` is 1 for a sun, 0 for a lamp. Whether its plane is known; a bound takes its place if not.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, footprint: &Footprint, unit: f32) -> bool {
        let [p, q, r] = footprint.plane;
        let sizes = p.abs() + q.abs() + r.abs() + f64::from(unit);
        // A plane at infinity is none.
        let is_plane = (footprint.plane_error <= sizes * f64::from(NEARNESS_MARGIN) * 0.25) & (sizes < f64::INFINITY);
        let is_sharp = footprint.edge_error <= f64::from(EDGE_MARGIN) * 0.5;
        let known = |coefficient: f64| if is_sharp { coefficient as f32 } else { 0.0 };
        for ([a, b, c], [a_to, b_to, c_to]) in footprint.edges.iter().zip(&mut self.edges) {
            (a_to[lane], b_to[lane], c_to[lane]) = (known(*a), known(*b), known(lesser(*c, EDGE_LIMIT)));
        }
        let or = |coefficient: f64, other: f64| (if is_plane { coefficient } else { other }) as f32;
        let [p_to, q_to, r_to] = &mut self.plane;
        (p_to[lane], q_to[lane], r_to[lane]) = (or(p, 0.0), or(q, 0.0), or(r, footprint.nearest));
        is_plane
    }

    /// Leaves nothing in a lane.
    #[inline(always)]
    pub(super) fn clear(&mut self, lane: usize) {
        for (to, empty) in self.edges.iter_mut().flatten().zip(Self::EMPTY.edges.iter().flatten()) {
            to[lane] = empty[lane];
        }
        self.plane.iter_mut().for_each(|to| to[lane] = 0.0);
    }

    /// Tests all eight, of which those in `vague` hide nothing for certain.
    #[inline(always)]
    pub(super) fn test<S: Simd>(&self, simd: S, vague: u8, point: &TilePoint) -> Said {
        let (s, t) = (simd.splat8(point.s), simd.splat8(point.t));
        let inside = affine(simd, &self.edges[0], s, t).min(affine(simd, &self.edges[1], s, t)).min(affine(
            simd,
            &self.edges[2],
            s,
            t,
        ));
        let margin = EDGE_MARGIN + point.place;
        let ahead = affine(simd, &self.plane, s, t) - simd.splat8(point.nearness);
        let slope = simd.load(&self.plane[0]).abs() + simd.load(&self.plane[1]).abs();
        let slack = slope * simd.splat8(point.place + NEARNESS_MARGIN) + simd.splat8(point.height);
        let is_blocked = inside.gt(simd.splat8(margin)) & ahead.gt(slack);
        let is_clear = inside.lt(simd.splat8(-margin)) | ahead.lt(-slack);
        if is_blocked.bits() & !u32::from(vague) != 0 { Said::Blocked } else { Said::Doubt((!is_clear).bits()) }
    }

    /// Tests one triangle against `N` points: which are blocked, and which are clear. A `vague` one hides nothing for certain.
    #[inline(always)]
    pub(super) fn test_points<S: Lanes<N>, const N: usize>(
        &self,
        simd: S,
        lane: usize,
        vague: u8,
        points: &TilePoints<S, N>,
    ) -> (u32, u32) {
        let TilePoints { s, t, nearness, place, height } = *points;
        let inside = affine_lane(simd, &self.edges[0], lane, s, t)
            .min(affine_lane(simd, &self.edges[1], lane, s, t))
            .min(affine_lane(simd, &self.edges[2], lane, s, t));
        let margin = simd.splat(EDGE_MARGIN) + place;
        let ahead = affine_lane(simd, &self.plane, lane, s, t) - nearness;
        let slope = self.plane[0][lane].abs() + self.plane[1][lane].abs();
        let slack = simd.splat(slope) * (place + simd.splat(NEARNESS_MARGIN)) + height;
        let is_blocked = inside.gt(margin) & ahead.gt(slack);
        let is_clear = inside.lt(-margin) | ahead.lt(-slack);
        let blocked = if vague >> lane & 1 == 0 { is_blocked.bits() } else { 0 };
        (blocked, is_clear.bits())
    }

    /// The group along the row of squares with the middle `t`; `half` their edge, widened. `None` where all lie beside the row.
    #[inline(always)]
    pub(super) fn strip<S: Simd>(&self, simd: S, t: f32, half: f32, extent: &Extent) -> Option<Strip<S>> {
        let (t, half) = (simd.splat8(t), simd.splat8(half));
        let [_, low, _, high] = &extent.bounds;
        let meets = !beside(simd, low, high, t, half);
        let [e, f, g] = &self.edges;
        let edges = [at_t(simd, e, t), at_t(simd, f, t), at_t(simd, g, t)];
        let slope = simd.load(&self.plane[0]).abs() + simd.load(&self.plane[1]).abs();
        meets.any().then(|| Strip { half, edges, plane: at_t(simd, &self.plane, t), slope, meets })
    }

    /// Which of the eight may meet the square of a row with the middle `s`, and how near.
    #[inline(always)]
    pub(super) fn over<S: Simd>(&self, simd: S, strip: &Strip<S>, s: f32, extent: &Extent, unit: f32) -> Option<Over> {
        let (s, half) = (simd.splat8(s), strip.half);
        let inside = at_s(simd, &self.edges[0], s, strip.edges[0])
            .min(at_s(simd, &self.edges[1], s, strip.edges[1]))
            .min(at_s(simd, &self.edges[2], s, strip.edges[2]));
        let margin = simd.splat8(EDGE_MARGIN);
        let [low, _, high, _] = &extent.bounds;
        let meets = strip.meets & !(inside.lt(-(half + margin)) | beside(simd, low, high, s, half));
        if !meets.any() {
            return None;
        }
        let here = at_s(simd, &self.plane, s, strip.plane);
        let band = (here.abs() + strip.slope + simd.splat8(unit)) * simd.splat8(NEARNESS_MARGIN);
        let reach = strip.slope * half + band;
        let never = simd.splat8(f32::NEG_INFINITY);
        let near = (here + reach).min(simd.load(&extent.nearest)).select(meets, never).to_array();
        let covers = inside.gt(half + margin);
        let below = here - reach;
        let covered = if covers.bits() & !u32::from(extent.vague) != 0 {
            let mut below = below.select(covers, never).to_array();
            for (lane, below) in below.iter_mut().enumerate() {
                *below = if extent.vague >> lane & 1 == 0 { *below } else { f32::NEG_INFINITY };
            }
            greatest(below)
        } else {
            f32::NEG_INFINITY
        };
        let lanes = meets.bits() as u8;
        // The function of an edge is off by less at the middle.
        let (is_in, is_out) = (inside.gt(margin + margin), inside.lt(-(margin + margin)));
        let share = extent.share(lanes, is_in.bits() as u8, is_out.bits() as u8);
        let farthest = below.max(simd.load(&extent.farthest));
        let farthest = -greatest((-farthest).select(meets, never).to_array());
        Some(Over { nearest: greatest(near), covered, lanes, share, farthest })
    }
}

/// Which lanes lie beside a square along one axis.
#[inline(always)]
fn beside<S: Simd>(simd: S, low: &[f32; 8], high: &[f32; 8], middle: F8<S>, half: F8<S>) -> M8<S> {
    (simd.load(high) - middle).lt(-half) | (simd.load(low) - middle).gt(half)
}

/// b·t + c of all lanes.
#[inline(always)]
fn at_t<S: Simd>(simd: S, [_, b, c]: &[[f32; 8]; 3], t: F8<S>) -> F8<S> {
    simd.load(b) * t + simd.load(c)
}

/// a·s and what [`at_t`] says.
#[inline(always)]
fn at_s<S: Simd>(simd: S, [a, ..]: &[[f32; 8]; 3], s: F8<S>, at_t: F8<S>) -> F8<S> {
    simd.load(a) * s + at_t
}

/// The nearest whole number to one from 0 up to below 2^16, without a branch.
#[inline(always)]
pub(super) fn whole(x: f32) -> u32 {
    // As with floats of 64 bits in `grid`: it is the low bits of the sum.
    const WHOLE: f32 = 1.5 * (1u32 << 23) as f32;
    (x + WHOLE).to_bits() & 0xffff
}

/// A float of 32 bits that is no less than a value from the least of them on. Without branches, where `f32::next_up` has some.
#[inline(always)]
pub(super) fn above(value: f64) -> f32 {
    let near = value as f32;
    near + (near.abs() * f32::EPSILON + f32::MIN_POSITIVE)
}

/// a·s + b·t + c of all lanes at one place.
#[inline(always)]
fn affine<S: Simd>(simd: S, [a, b, c]: &[[f32; 8]; 3], s: F8<S>, t: F8<S>) -> F8<S> {
    (simd.load(a) * s + simd.load(b) * t) + simd.load(c)
}

/// a·s + b·t + c of one lane at `N` places.
#[inline(always)]
fn affine_lane<S: Lanes<N>, const N: usize>(
    simd: S,
    [a, b, c]: &[[f32; 8]; 3],
    lane: usize,
    s: S::Float,
    t: S::Float,
) -> S::Float {
    (simd.splat(a[lane]) * s + simd.splat(b[lane]) * t) + simd.splat(c[lane])
}

#[inline(always)]
fn greatest([a, b, c, d, e, f, g, h]: [f32; 8]) -> f32 {
    // One instruction where `f32::max` looks for NaN. A plane that overflows may be one; it covers nothing then.
    let greater = |a: f32, b: f32| if a > b { a } else { b };
    greater(greater(greater(a, b), greater(c, d)), greater(greater(e, f), greater(g, h)))
}
