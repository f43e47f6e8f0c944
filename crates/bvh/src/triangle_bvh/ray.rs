//! A ray in the tree's frame, made ready for boxes and triangles, with bounds on what was rounded away.
//!
//! The ray's main axis is that of the largest component of its direction; its parameter t is the way along it. The
//! triangle test shears the other two axes (Woop, Benthin and Wald 2013); the box test divides by the direction.
//!
//! **Boxes.** The direction's components are divided by the largest in f64, rounded to f32 and inverted, and a plane's
//! parameter is a rounded difference times that, rounded: a relative error of little more than 4u, u = 2^-24. So entry and
//! exit differ from their true values by less than a factor 1 + 9u between them, and the test allows [`OUTWARD`] = 1 + 16u.
//! The origin is moved outward by its error on either side. A component below 2^-40 moves the ray by less than 2^-37
//! across the frame, as it goes at most 2^3 along the main axis there: it is replaced by 2^-40, and the origin's error
//! grows by 2^-37.
//!
//! **An origin far outside** is moved along the ray to the frame's border, in f64: where the frame is small against its
//! distance, f32 would tell nothing there. **An origin that is known roughly**, up to a slack s, is a bundle of
//! segments to one light (or parallel ones to a sun). A fraction m of the way towards the light they are within |1 − m|·s of
//! each other; across the frame |m| is at most its width over the length of the way.

use glam::{DVec3, Vec3A};
use umbriel_geometry::LightSource;

use super::frame::Frame;

/// Half an ulp of f32 at 1.
pub(super) const U: f32 = f32::EPSILON / 2.0;

/// 1 + 16u; see the header.
pub(super) const OUTWARD: f32 = 1.0 + 8.0 * f32::EPSILON;

/// Least size of a component of the direction where boxes are concerned.
pub(super) const LEAST_SLOPE: f32 = 1.0 / (1u64 << 40) as f32;
/// What replacing smaller ones moves the ray by, at most; see the header.
pub(super) const SLOPE_SLACK: f32 = 8.0 * LEAST_SLOPE;

/// How far from the frame's centre an origin may lie before it is moved to the border.
pub(super) const FAR: f64 = 2.0;
/// More than the way along the main axis from an origin that is not far to any point of the frame.
pub(super) const BEYOND: f32 = 8.0;

/// An error that leaves everything in the frame in doubt, and overflows nowhere. Larger ones count as this.
const UNKNOWN: f64 = (1u64 << 20) as f64;

/// A ray as it is asked about, world coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    /// Where it ends, in lengths of `direction`.
    pub(super) end: f64,
    /// How far the true origin may be from `origin`, on each axis.
    pub(super) slack: f64,
}

impl Way {
    /// From a point to a light.
    #[inline(always)]
    pub(super) fn towards(light: &LightSource, origin: DVec3, slack: f64) -> Self {
        if light.is_sun() {
            Self { origin, direction: light.xyz(), end: f64::INFINITY, slack }
        } else {
            let direction = light.xyz() - origin;
            if direction == DVec3::ZERO && slack > 0.0 {
                // Any direction: its length of zero leaves everything in doubt.
                return Self { origin, direction: DVec3::X, end: 0.0, slack };
            }
            Self { origin, direction, end: 1.0, slack }
        }
    }
}

/// A ray, or a segment, in the frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalRay {
    /// The main axis comes last.
    pub(super) axes: [usize; 3],
    pub(super) origin: [f32; 3],
    /// Direction over its main component.
    pub(super) slope: [f32; 3],
    /// 1 or −1: the main component's sign.
    pub(super) forward: f32,
    /// Where the segment ends: t of the light, or a number beyond the frame.
    pub(super) end: f32,
    /// How far `end` may be off.
    pub(super) end_error: f32,
    /// How far the difference of a corner and the origin may be off on one axis, without its own rounding.
    pub(super) error: f32,
    /// The box test.
    pub(super) slabs: Slabs,
    /// Boxes entered behind this are of no interest.
    pub(super) box_end: f32,
    /// Lengths of the direction become t when multiplied by the first and lessened by the second.
    unit: [f64; 2],
}

/// The box test on x, y and z: rows of the near and the far planes in a node, origins for either, reciprocals of the
/// direction over the size of its main component.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slabs {
    pub(super) near: [usize; 3],
    pub(super) far: [usize; 3],
    pub(super) near_origin: [f32; 3],
    pub(super) far_origin: [f32; 3],
    pub(super) reciprocal: [f32; 3],
}

impl LocalRay {
    /// The way in the frame; `corner_error` bounds how far the tree's corners are off on an axis.
    ///
    /// `None` where it certainly misses the frame, or has no direction.
    #[inline(always)]
    pub(super) fn new(frame: &Frame, way: &Way, corner_error: f32) -> Option<Self> {
        let (main, component) = main_component(way.direction);
        let along = component.abs();
        if along.is_nan() || along <= 0.0 {
            return None;
        }
        // One unit along the main axis.
        let (slope, forward) = (way.direction * (1.0 / component), 1f32.copysign(component as f32));
        let step = along * frame.scale();
        let mut start = frame.localise(way.origin);
        let reach = start.abs().max_element();
        let (mut end, mut error, mut advance) = (way.end * step, frame.error(reach), 0.0);
        if way.slack > 0.0 {
            error += way.slack * frame.scale() * (2.0 + f64::from(BEYOND) / end);
        }
        if reach > FAR {
            let forward = slope * f64::from(forward);
            let (way_in, slack) = way_to_frame(start, forward, error)?;
            (advance, error) = (way_in, error + slack);
            (start, end) = (start + forward * advance, end - advance);
        }
        if error.is_nan() || error >= UNKNOWN {
            (start, end, error, advance) = (DVec3::ZERO, f64::INFINITY, UNKNOWN, 0.0);
        }
        let rounded = start.as_vec3a();
        error += (start - rounded.as_dvec3()).abs().max_element();
        // The widened origins are rounded too: by 2u of at most the reach, which the last term covers.
        let error = error as f32 * (1.0 + 4.0 * U);
        let widening = error + SLOPE_SLACK + 4.0 * U * rounded.abs().max_element();
        let slope = slope.as_vec3a();
        let (end, end_error) =
            if end < f64::from(BEYOND) { (end as f32, error + end.abs() as f32 * 2.0 * U) } else { (BEYOND, 1.0) };
        Some(Self {
            axes: AXES[main],
            origin: rounded.to_array(),
            slope: slope.to_array(),
            forward,
            end,
            end_error,
            error: error + corner_error,
            slabs: Slabs::new(rounded, slope * forward, widening),
            box_end: (end + end_error) * OUTWARD,
            unit: [step, advance],
        })
    }

    /// Makes boxes that are entered behind `t`, in lengths of the direction, uninteresting.
    pub(super) fn stop_at(&mut self, t: f64) {
        self.box_end = (t * self.unit[0] - self.unit[1]) as f32 * OUTWARD + self.error;
    }
}

/// For each main axis the three axes, in an order that keeps right hands right.
pub(super) const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// The axis of the largest component, and this component.
#[inline(always)]
fn main_component(direction: DVec3) -> (usize, f64) {
    let DVec3 { x, y, z } = direction.abs();
    if x >= y && x >= z {
        (0, direction.x)
    } else if z > y {
        (2, direction.z)
    } else {
        (1, direction.y)
    }
}

impl Slabs {
    /// `direction` is over the size of its main component. Near planes are met earlier, far ones later, by `widening`.
    #[inline(always)]
    fn new(origin: Vec3A, direction: Vec3A, widening: f32) -> Self {
        let reciprocal = Vec3A::ONE / direction.abs().max(Vec3A::splat(LEAST_SLOPE));
        let outward = Vec3A::splat(widening).copysign(direction);
        let backward = direction.is_negative_bitmask() as usize;
        let (mut near, mut far) = ([0, 1, 2], [3, 4, 5]);
        for axis in 0..3 {
            let back = 3 * (backward >> axis & 1);
            (near[axis], far[axis]) = (near[axis] + back, far[axis] - back);
        }
        Self {
            near,
            far,
            near_origin: (origin + outward).to_array(),
            far_origin: (origin - outward).to_array(),
            reciprocal: reciprocal.copysign(direction).to_array(),
        }
    }
}

/// How far a point outside, known up to `error` on each axis, may go along the ray without passing the frame's border, wherever it is, and how far
/// it may then be off beside that. `None` where the ray leads away.
#[cold]
fn way_to_frame(start: DVec3, slope: DVec3, error: f64) -> Option<(f64, f64)> {
    let mut longest = 0.0f64;
    for axis in 0..3 {
        let outside = start[axis].abs() - 1.0;
        // Roundings leave a point at the border in doubt; it is taken as inside.
        if outside > 1e-9 + error {
            let speed = -slope[axis] * start[axis].signum();
            if speed <= 0.0 {
                return None;
            }
            longest = longest.max((outside - error) / speed);
        }
    }
    let slack = (start.abs().max_element() + longest) * 8.0 * f64::EPSILON;
    Some((longest.min(f64::MAX), slack))
}
