//! A pack's triangles as functions of where a segment is seen from the light.
//!
//! Coordinates are those of the packet. **Errors**, all in the maximum norm: α bounds L − a, λ the edges, χ the origins
//! minus corners and the rectangle; they are off by δ_l, 2e and e + o, with e the corners' error, o the origins', l the
//! light's, δ_l = l + e; D is the greatest Δ.
//!
//! - p is off by δ = 4o + D(16(l + o)/|C_k| + 48u): its terms by o + uD each, C_i/C_k by (2l + 4u|C|)/|C_k|, the factor by
//!   3(l + o)/|C_k| + 8u of itself, and it is at most 2.
//! - A determinant of rows with sizes r, s, t has a permanent of at most 6rst. So n·(c − a) is off by less than
//!   6.6(αλχ·12u + λχδ_l + 3αχe), n by a third of that over χ, and the sum of three terms rounds by 4u·8αλχ: together below
//!   αλ(120uχ + 4.4δ) + 9λχδ_l + 20αχe.
//! - The triangle's plane, with rows λ, λ, χ, is off by less than λ²(120uχ + 7(o + e)) + 28λχe; towards the light by less than
//!   6.6(λ²(12uα + δ_l) + 4λαe).

use glam::Vec3;
use umbriel_geometry::simd::{F8, Float, M8, Mask, Simd};

use super::{
    super::{
        layout::{Pack, WIDTH},
        ray::U,
    },
    LocalLight, Packet,
};

/// A pack's triangles as the light sees them: affine functions of p, q that are positive inside an edge, and the
/// triangle's own plane, positive on the light's side.
pub(super) struct Seen<V> {
    /// For ab, bc, ca: the value in the middle, the slopes along p and q.
    edges: [[V; 3]; 3],
    /// The value in the middle.
    depth: V,
    normal: [V; 3],
    edge_error: V,
    depth_error: V,
}

/// [`Seen`], to be read lane by lane.
pub(super) struct Spread {
    edges: [[[f32; WIDTH]; 3]; 3],
    depth: [f32; WIDTH],
    normal: [[f32; WIDTH]; 3],
    edge_error: [f32; WIDTH],
    depth_error: [f32; WIDTH],
}

/// A pack's triangles as the light sees them, and which are in doubt because the light is nearly in their plane.
#[inline(always)]
pub(super) fn look<S: Simd>(
    simd: S,
    pack: &Pack,
    light: &LocalLight,
    packet: &Packet,
    error: f32,
) -> (Seen<F8<S>>, M8<S>) {
    let (a, b, c) = (corner(simd, pack, 0), corner(simd, pack, 1), corner(simd, pack, 2));
    let (at, middle) = (point(simd, light.xyz), point(simd, packet.middle));
    let (ab, bc, ca) = (minus(b, a), minus(c, b), minus(a, c));
    let (from_a, from_b, from_c) = if light.is_sun { (at, at, at) } else { (minus(at, a), minus(at, b), minus(at, c)) };
    let (away_a, away_b) = (minus(middle, a), minus(middle, b));
    let normal = cross(ca, ab);
    let facing = dot(normal, from_a);
    let edges = [
        edge(turned(cross(from_a, ab), facing), away_a, packet),
        edge(turned(cross(from_b, bc), facing), away_b, packet),
        edge(turned(cross(from_c, ca), facing), away_a, packet),
    ];
    let normal = turned(normal, facing);
    let reach = size(from_a).max(size(from_b)).max(size(from_c));
    let length = size(ab).max(size(bc)).max(size(ca));
    let around = 4.0 * packet.half.max_element() + 2.0 * packet.error + 2.0 * error;
    let away = size(away_a) + length + simd.splat8(around);
    let light_error = light.error + error;
    let (e, l, rounding) = (simd.splat8(error), simd.splat8(light_error), simd.splat8(120.0 * U) * away);
    let area = length * length;
    let edge_error = reach
        * (length * (rounding + simd.splat8(4.4 * packet.seen_error)) + simd.splat8(20.0 * error) * away)
        + simd.splat8(9.0 * light_error) * length * away;
    let depth_error =
        area * (rounding + simd.splat8(7.0 * (packet.error + error))) + simd.splat8(28.0) * e * length * away;
    let facing_error =
        simd.splat8(6.6) * (area * (simd.splat8(12.0 * U) * reach + l) + simd.splat8(4.0) * e * length * reach);
    let least = simd.splat8(f32::MIN_POSITIVE);
    let is_doubtful = !facing.abs().gt(facing_error + least);
    let (edge_error, depth_error) = (edge_error + least, depth_error + least);
    (Seen { edges, depth: dot(normal, away_a), normal, edge_error, depth_error }, is_doubtful)
}

/// The function of an edge's plane with this normal.
#[inline(always)]
fn edge<V: Float<WIDTH>>(normal: [V; 3], away: [V; 3], packet: &Packet) -> [V; 3] {
    let [i, j, _] = packet.axes;
    [dot(normal, away), normal[i], normal[j]]
}

/// Which triangles certainly block none of the segments, and which certainly all.
#[inline(always)]
pub(super) fn ranges<S: Simd>(simd: S, seen: &Seen<F8<S>>, packet: &Packet) -> (M8<S>, M8<S>) {
    let (least_ab, greatest_ab) = range(simd, seen.edges[0], packet);
    let (least_bc, greatest_bc) = range(simd, seen.edges[1], packet);
    let (least_ca, greatest_ca) = range(simd, seen.edges[2], packet);
    let half = point(simd, packet.half);
    let [x, y, z] = seen.normal;
    let by = dot([x.abs(), y.abs(), z.abs()], half);
    let greatest = greatest_ab.min(greatest_bc).min(greatest_ca);
    let least = least_ab.min(least_bc).min(least_ca);
    let missed = greatest.lt(-seen.edge_error) | (seen.depth - by).gt(seen.depth_error);
    let covering = least.gt(seen.edge_error) & (seen.depth + by).lt(-seen.depth_error);
    (missed, covering)
}

/// The least and the greatest value of an edge's function over the packet's rectangle.
#[inline(always)]
fn range<S: Simd>(simd: S, [value, p, q]: [F8<S>; 3], packet: &Packet) -> (F8<S>, F8<S>) {
    let (low_p, high_p) = (p * simd.splat8(packet.low[0]), p * simd.splat8(packet.high[0]));
    let (low_q, high_q) = (q * simd.splat8(packet.low[1]), q * simd.splat8(packet.high[1]));
    (value + low_p.min(high_p) + low_q.min(high_q), value + low_p.max(high_p) + low_q.max(high_q))
}

/// One triangle against eight segments: which it certainly blocks, and which it may block.
#[inline(always)]
pub(super) fn segments<S: Simd>(simd: S, seen: &Spread, lane: usize, packet: &Packet, group: usize) -> (u32, u32) {
    let (p, q) = (simd.load(&packet.seen[0][group]), simd.load(&packet.seen[1][group]));
    let ab = value(simd, &seen.edges[0], lane, p, q);
    let bc = value(simd, &seen.edges[1], lane, p, q);
    let ca = value(simd, &seen.edges[2], lane, p, q);
    let [x, y, z] = &packet.deltas;
    let by = dot(lane_of(simd, &seen.normal, lane), [simd.load(&x[group]), simd.load(&y[group]), simd.load(&z[group])]);
    let depth = simd.splat8(seen.depth[lane]) + by;
    let (edge_error, depth_error) = (simd.splat8(seen.edge_error[lane]), simd.splat8(seen.depth_error[lane]));
    let least = ab.min(bc).min(ca);
    let hits = least.gt(edge_error) & depth.lt(-depth_error);
    let missed = least.lt(-edge_error) | depth.gt(depth_error);
    (hits.bits(), (!(hits | missed)).bits())
}

/// An edge's function.
#[inline(always)]
fn value<S: Simd>(simd: S, [at, p, q]: &[[f32; WIDTH]; 3], lane: usize, along: F8<S>, across: F8<S>) -> F8<S> {
    simd.splat8(at[lane]) + simd.splat8(p[lane]) * along + simd.splat8(q[lane]) * across
}

#[inline(always)]
pub(super) fn spread<V: Float<WIDTH>>(seen: &Seen<V>) -> Spread {
    let [ab, bc, ca] = seen.edges;
    Spread {
        edges: [arrays(ab), arrays(bc), arrays(ca)],
        depth: seen.depth.to_array(),
        normal: arrays(seen.normal),
        edge_error: seen.edge_error.to_array(),
        depth_error: seen.depth_error.to_array(),
    }
}

#[inline(always)]
fn arrays<V: Float<WIDTH>>([x, y, z]: [V; 3]) -> [[f32; WIDTH]; 3] {
    [x.to_array(), y.to_array(), z.to_array()]
}

/// One lane of three arrays in all lanes.
#[inline(always)]
fn lane_of<S: Simd>(simd: S, [x, y, z]: &[[f32; WIDTH]; 3], lane: usize) -> [F8<S>; 3] {
    [simd.splat8(x[lane]), simd.splat8(y[lane]), simd.splat8(z[lane])]
}

#[inline(always)]
fn corner<S: Simd>(simd: S, pack: &Pack, corner: usize) -> [F8<S>; 3] {
    let [x, y, z] = &pack.corners[corner];
    [simd.load(x), simd.load(y), simd.load(z)]
}

#[inline(always)]
fn point<S: Simd>(simd: S, point: Vec3) -> [F8<S>; 3] {
    [simd.splat8(point.x), simd.splat8(point.y), simd.splat8(point.z)]
}

#[inline(always)]
fn minus<V: Float<WIDTH>>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn cross<V: Float<WIDTH>>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn dot<V: Float<WIDTH>>(a: [V; 3], b: [V; 3]) -> V {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn turned<V: Float<WIDTH>>(vector: [V; 3], sign: V) -> [V; 3] {
    [vector[0].flip_sign(sign), vector[1].flip_sign(sign), vector[2].flip_sign(sign)]
}

/// The maximum norm.
#[inline(always)]
fn size<V: Float<WIDTH>>(vector: [V; 3]) -> V {
    vector[0].abs().max(vector[1].abs()).max(vector[2].abs())
}
