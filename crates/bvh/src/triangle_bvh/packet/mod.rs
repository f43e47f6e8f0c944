//! Sixteen segments to one light at once.
//!
//! Segments to one light from points that lie together fill a thin shaft. A box is tested against the shaft, not
//! against the segments (Haines and Wallace 1991, as in `shaft.rs`), so a node costs the same for sixteen segments as
//! for one. A triangle's edges and the light span planes; the sign of their functions depends on where a segment is
//! seen from the light, and they are affine in those two coordinates. So their range over the segments' rectangle
//! shows most triangles to be missed by all, and some to block all. What is left is asked of each segment, and what is in
//! doubt then of the single ray.
//!
//! **Coordinates.** Let c be the middle of the origins, C = c − L (for a sun, its direction), k the axis where C is
//! largest, x = c + Δ an origin. An edge's normal n = (L − a) × e is orthogonal to L − a, so n·(x − L) is n·(x − a), and
//! (x − L)_k/C_k times n·(c − a) + n_i p + n_j q with p = (Δ_i − Δ_k C_i/C_k)·C_k/(C_k + Δ_k), q alike (for a sun the last
//! factor is 1). A packet is refused unless C_k + Δ_k ≥ C_k/2, so the factor in front is positive.
//!
//! `planes.rs` has the errors, [`super::shaft`] the boxes.

mod planes;
mod walk;

use glam::{DVec3, Vec3};
use umbriel_geometry::{
    LightSource,
    simd::{Float, Mask, Simd},
};

use super::{
    frame::Frame,
    layout::{Node, WIDTH},
    ray::{AXES, BEYOND, FAR, LEAST_SLOPE, OUTWARD, SLOPE_SLACK, U},
};

pub(super) use walk::Walk;

/// Segments in a packet.
pub(super) const PACKET: usize = 16;
/// Groups of eight of them.
const GROUPS: usize = PACKET / WIDTH;

/// Lights that are farther away, in sizes of the frame, are left to single rays: their squares would overflow.
const FARTHEST: f64 = (1u64 << 40) as f64;

/// A light in the frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalLight {
    /// The point; for a sun the direction towards it, its largest component ±1.
    pub(super) xyz: Vec3,
    pub(super) is_sun: bool,
    /// How far a component of `xyz` may be off.
    pub(super) error: f32,
}

impl LocalLight {
    /// `None` for a light that is too far away.
    pub(super) fn new(frame: &Frame, light: &LightSource) -> Option<Self> {
        let is_sun = light.is_sun();
        let exact = if is_sun { light.xyz() / light.xyz().abs().max_element() } else { frame.localise(light.xyz()) };
        let size = exact.abs().max_element();
        let rounded = exact.as_vec3();
        let error = (exact - rounded.as_dvec3()).abs().max_element() + size * f64::EPSILON;
        (size < FARTHEST).then_some(Self { xyz: rounded, is_sun, error: error as f32 * (1.0 + 4.0 * U) })
    }
}

/// Three coordinates of sixteen vectors.
type Vectors = [[[f32; WIDTH]; GROUPS]; 3];

/// Origins of segments, as the light sees them; see the header.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packet {
    /// Axis, group of eight, lane. Lanes that are left over repeat the first origin.
    origins: Vectors,
    /// Origins minus the middle.
    deltas: Vectors,
    /// Reciprocals of the directions, which are as long as the packet's along its main axis.
    reciprocals: Vectors,
    /// How far the boxes have to be widened, and where the segments end at the latest.
    widening: f32,
    end: f32,
    /// The coordinates p and q.
    seen: [[[f32; WIDTH]; GROUPS]; 2],
    /// How far a coordinate of an origin may be off, and how far p and q.
    error: f32,
    seen_error: f32,
    pub(super) middle: Vec3,
    /// Half the size of the box around the origins, errors included.
    pub(super) half: Vec3,
    /// The least and the greatest p and q.
    low: [f32; 2],
    high: [f32; 2],
    /// The axes of p, of q, and the main one.
    axes: [usize; 3],
}

impl Packet {
    const EMPTY: Self = Self {
        origins: [[[0.0; WIDTH]; GROUPS]; 3],
        deltas: [[[0.0; WIDTH]; GROUPS]; 3],
        reciprocals: [[[0.0; WIDTH]; GROUPS]; 3],
        widening: 0.0,
        end: 0.0,
        seen: [[[0.0; WIDTH]; GROUPS]; 2],
        error: 0.0,
        seen_error: 0.0,
        middle: Vec3::ZERO,
        half: Vec3::ZERO,
        low: [f32::INFINITY; 2],
        high: [f32::NEG_INFINITY; 2],
        axes: AXES[2],
    };

    /// Sixteen origins. `None` where the light lies among them, or one lies far outside of the frame.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, frame: &Frame, light: &LocalLight, origins: &[DVec3; PACKET]) -> Option<Self> {
        let mut packet = Self::EMPTY;
        let (mut low, mut high, mut off) = (Vec3::INFINITY, Vec3::NEG_INFINITY, DVec3::ZERO);
        for (index, &origin) in origins.iter().enumerate() {
            let exact = frame.localise(origin);
            let rounded = exact.as_vec3();
            off = off.max((exact - rounded.as_dvec3()).abs());
            (low, high) = (low.min(rounded), high.max(rounded));
            for axis in 0..3 {
                packet.origins[axis][index / WIDTH][index % WIDTH] = rounded[axis];
            }
        }
        let reach = low.abs().max(high.abs()).max_element();
        if f64::from(reach) > FAR {
            return None;
        }
        packet.error = (off.max_element() + frame.error(FAR)) as f32 * (1.0 + 4.0 * U);
        packet.middle = (low + high) * 0.5;
        // Rounded: the middle and the size by u of the reach each.
        packet.half = (high - low) * 0.5 + Vec3::splat(packet.error + 4.0 * U * reach);
        let farthest = packet.half.max_element();
        let way = if light.is_sun { light.xyz } else { packet.middle - light.xyz };
        let size = way.abs();
        packet.axes = AXES[if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) }];
        let length = size[packet.axes[2]];
        if !light.is_sun && length <= 2.0 * (farthest + light.error) {
            return None;
        }
        let sources = 16.0 * (light.error + packet.error) / length + 48.0 * U;
        packet.seen_error = 4.0 * packet.error + farthest * sources;
        packet.widening = 3.0 * (light.error + packet.error) + SLOPE_SLACK + 4.0 * U * (reach + farthest);
        packet.end = if light.is_sun { BEYOND } else { BEYOND.min((length + farthest) * OUTWARD + light.error) };
        packet.see(simd, light, way);
        Some(packet)
    }

    /// Fills what depends on the light; `way` leads from it to the middle.
    #[inline(always)]
    fn see<S: Simd>(&mut self, simd: S, light: &LocalLight, way: Vec3) {
        let [i, j, k] = self.axes;
        let (one, length) = (simd.splat8(1.0), simd.splat8(way[k].abs()));
        let (mut low, mut high) = ([simd.splat8(f32::INFINITY); 2], [simd.splat8(f32::NEG_INFINITY); 2]);
        for group in 0..GROUPS {
            let mut deltas = [one; 3];
            for (axis, delta) in deltas.iter_mut().enumerate() {
                let origin = simd.load(&self.origins[axis][group]);
                let at = simd.splat8(light.xyz[axis]);
                let slope = if light.is_sun { at } else { (at - origin) / length };
                let least = simd.splat8(LEAST_SLOPE);
                let reciprocal = one / least.select(slope.abs().lt(least), slope);
                *delta = origin - simd.splat8(self.middle[axis]);
                self.deltas[axis][group] = delta.to_array();
                self.reciprocals[axis][group] = reciprocal.to_array();
            }
            let along = simd.splat8(way[k]);
            let factor = if light.is_sun { one } else { along / (along + deltas[k]) };
            for (side, axis) in [i, j].into_iter().enumerate() {
                let seen = (deltas[axis] - deltas[k] * simd.splat8(way[axis] / way[k])) * factor;
                self.seen[side][group] = seen.to_array();
                (low[side], high[side]) = (low[side].min(seen), high[side].max(seen));
            }
        }
        for side in 0..2 {
            for lane in 0..WIDTH {
                self.low[side] = self.low[side].min(low[side].to_array()[lane]);
                self.high[side] = self.high[side].max(high[side].to_array()[lane]);
            }
        }
    }

    /// Which segments may meet a node's box, a bit each.
    #[inline(always)]
    fn segments_in<S: Simd>(&self, simd: S, node: &Node, lane: usize) -> u32 {
        let mut met = 0;
        for group in 0..GROUPS {
            let (mut enter, mut leave) = (simd.splat8(0.0), simd.splat8(self.end));
            for axis in 0..3 {
                let low = simd.splat8(node.planes[axis][lane] - self.widening);
                let high = simd.splat8(node.planes[axis + 3][lane] + self.widening);
                let (origin, reciprocal) =
                    (simd.load(&self.origins[axis][group]), simd.load(&self.reciprocals[axis][group]));
                let (one, other) = ((low - origin) * reciprocal, (high - origin) * reciprocal);
                enter = enter.max(one.min(other));
                leave = leave.min(one.max(other));
            }
            met |= enter.le(leave * simd.splat8(OUTWARD)).bits() << (group * WIDTH);
        }
        met
    }
}
