//! What texels of a window hide a receiver: those before its plane.
//!
//! A window that is wider than a texel reads depths of the receiver itself, which on a slope are nearer than the point in its middle on one side. Its
//! tangent plane has a depth number that is affine over the map ([`LightSpace`]), so each texel is held against the plane's
//! depth there (receiver-plane depth bias: Isidoro, "Shadow mapping: GPU-based tips and techniques", Game Developers Conference 2006, with derivatives of
//! the picture; here the plane is known). The plane is followed until its depth number has changed by half: at grazing planes windows
//! reach farther, and the slope is made gentler there.

use std::ops::Range;

use glam::{DVec2, DVec3};
use umbriel_geometry::simd::{F16, Float, Kernel, M16, Mask, Simd};
use umbriel_visibility::depth_map::{DepthMap, LightSpace};

const LANES: usize = DepthMap::LANES;

/// How many texels a point's depth is granted beside the slope of its plane, for a texel stands for its middle: what is steeper by no more than this
/// (neighbouring faces, curved ones) does not shadow itself.
const BIAS_TEXELS: f64 = 1.5;

/// How much of its depth number a plane may change within a window.
const FOLLOWED: f64 = 0.5;

/// A point of a picture: where it is, and which way its surface looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// World coordinates, metres.
    pub position: DVec3,
    /// Of any length and sign; zero where there is no plane.
    pub normal: DVec3,
}

/// A receiver on the map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Receiver {
    /// In texels.
    pub(super) place: DVec2,
    /// Where it is on the image.
    pub(super) image: DVec2,
    pub(super) depth: f64,
    number: f64,
    /// Of the depth number from texel to texel.
    change: DVec2,
}

/// Which depths hide: those with `depth · number < least` for a lamp, `depth − number < least` for a sun, where `number` is that of the receiver's
/// plane, affine over the window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limit {
    /// At the middle of the window's first texel.
    first: f32,
    per_column: f32,
    per_row: f32,
    least: f32,
    is_parallel: bool,
    /// The number in the window for which a texel of a given depth is least likely to be free.
    nearest: f64,
}

impl Receiver {
    /// `None` where the map does not look.
    pub(super) fn new(space: &LightSpace, point: &SurfacePoint) -> Option<Self> {
        let seen = space.to_light(point.position);
        space.is_before(seen).then(|| Self {
            place: space.to_texels(seen),
            image: space.image(seen),
            depth: seen.z,
            number: space.depth_number(seen.z),
            change: space.change_of_plane(space.direction_to_light(point.normal), seen),
        })
    }

    /// What hides it in a window.
    pub(super) fn limit(&self, space: &LightSpace, [columns, rows]: &[Range<usize>; 2]) -> Limit {
        let first = DVec2::new(columns.start as f64 + 0.5, rows.start as f64 + 0.5) - self.place;
        let last = first + DVec2::new((columns.len() - 1) as f64, (rows.len() - 1) as f64);
        let most = self.change.abs().dot(first.abs().max(last.abs()));
        let gentler = (FOLLOWED * self.number / most).min(1.0);
        let change = self.change * gentler;
        let is_parallel = space.is_parallel();
        let bias = BIAS_TEXELS * space.texel();
        let reached = most * gentler;
        Limit {
            first: (self.number + change.dot(first)) as f32,
            per_column: change.x as f32,
            per_row: change.y as f32,
            least: if is_parallel { -bias } else { 1.0 - bias } as f32,
            is_parallel,
            nearest: if is_parallel { self.number + reached } else { self.number - reached },
        }
    }
}

impl Limit {
    /// Whether depths from this one on hide nowhere in the window.
    pub(super) fn frees(&self, depth: f32) -> bool {
        let (depth, least) = (f64::from(depth), f64::from(self.least));
        if self.is_parallel { depth - self.nearest >= least } else { depth * self.nearest >= least }
    }
}

/// What a window holds before the receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Nearer {
    /// Texels.
    pub(super) count: u32,
    /// Of their depths.
    pub(super) sum: f32,
}

/// Counts the texels of a window that hide, and adds up their depths if `SUMS`.
pub(super) struct CountNearer<'a, const SUMS: bool> {
    pub(super) map: &'a DepthMap,
    pub(super) window: &'a [Range<usize>; 2],
    pub(super) limit: Limit,
}

impl<const SUMS: bool> Kernel for CountNearer<'_, SUMS> {
    type Output = Nearer;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Nearer {
        if self.limit.is_parallel { self.count::<S, true>(simd) } else { self.count::<S, false>(simd) }
    }
}

impl<const SUMS: bool> CountNearer<'_, SUMS> {
    #[inline(always)]
    fn count<S: Simd, const PARALLEL: bool>(self, simd: S) -> Nearer {
        let Self { map, window: [columns, rows], limit } = self;
        let mut ramp = [0.0; LANES];
        let mut lane = 0;
        while lane < LANES {
            ramp[lane] = lane as f32 * limit.per_column;
            lane += 1;
        }
        let (ramp, least) = (simd.load(&ramp), simd.splat16(limit.least));
        let (mut count, mut sums) = (0, simd.splat16(0.0));
        for row in rows.clone() {
            let start = limit.first + (row - rows.start) as f32 * limit.per_row;
            let mut left = columns.len();
            for (group, depths) in map.groups(row, columns.start, columns.len()).iter().enumerate() {
                let number = simd.splat16(start + (group * LANES) as f32 * limit.per_column) + ramp;
                let depths: F16<S> = simd.load(depths);
                let against = if PARALLEL { depths - number } else { depths * number };
                let mut hides: M16<S> = against.lt(least);
                if left < LANES {
                    hides = hides & simd.mask16((1 << left) - 1);
                }
                count += hides.bits().count_ones();
                if SUMS {
                    sums = sums + depths.select(hides, simd.splat16(0.0));
                }
                left = left.saturating_sub(LANES);
            }
        }
        let mut sum = 0.0;
        for lane in sums.to_array() {
            sum += lane;
        }
        Nearer { count, sum }
    }
}
