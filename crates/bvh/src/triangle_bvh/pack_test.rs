//! Eight triangles against one ray in f32: which are certainly met, which are in doubt, which are certainly missed.
//!
//! The edge functions are those of Woop, Benthin and Wald, "Watertight ray/triangle intersection", Journal of Computer
//! Graphics Techniques 2(1), 2013; here each has a bound on its error, and a sign within the bound is not used.
//!
//! With u = 2^-24, let e bound the error of a corner minus the origin on an axis apart from its own rounding
//! ([`LocalRay::error`]), m the sheared coordinates' sizes, z those along the main axis, all of the triangle.
//!
//! - *Sheared coordinate* x − s·z, |s| ≤ 1: 2e from its input; u(m + z) for the difference on its axis, which is no
//!   larger than m + z; u·z for the one on the main axis; u·z for the rounding of s; u·z and u·m for the product and
//!   the sum. Together 2e + 4u(m + z), below ε = 2e + 4.5u(m + z).
//! - *Edge function* of two sheared corners: 4mε + 2ε² from its input and 4um² ≤ mε from its three roundings: below
//!   τ = 5.5ε(m + ε). What underflow takes is below the smallest normal number, which is added.
//! - *Depth.* It is the determinant of (a − o, b − a, c − a) over the sum D of the edge functions, up to signs. Three
//!   rounded rows cost (7 + 56u)u times the permanent (Shewchuk, "Adaptive precision floating-point arithmetic", 1997,
//!   §4.3); input errors of e, 2e and 2e on the rows cost 24e(m + z)² each, as differences of corners are at most
//!   2(m + z). D is off by 3τ + 2u|D|.

use umbriel_geometry::simd::{F8, Float, M8, Mask, Simd};

use super::{
    layout::{Pack, WIDTH},
    ray::{LocalRay, U},
};

/// What is known of a pack's triangles, one bit each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Verdicts {
    /// Certainly met, strictly between the ray's ends.
    pub(super) hits: u32,
    /// In doubt. All others are certainly missed.
    pub(super) doubts: u32,
}

impl Verdicts {
    /// Whether `decide` says yes to a triangle in doubt.
    #[inline(always)]
    pub(super) fn any_doubt(&self, pack: &Pack, mut decide: impl FnMut(u32) -> bool) -> bool {
        let mut doubts = self.doubts;
        while doubts != 0 {
            if decide(pack.triangles[doubts.trailing_zeros() as usize % WIDTH]) {
                return true;
            }
            doubts &= doubts - 1;
        }
        false
    }
}

/// A pack's corners as the ray sees them: two sheared coordinates, and the depth.
struct Seen<V> {
    x: [V; 3],
    y: [V; 3],
    z: [V; 3],
}

/// What the edge functions tell.
struct Edges<V> {
    /// Twice the areas opposite to a, b, c.
    values: [V; 3],
    /// τ of the header.
    tolerance: V,
    /// No coordinate of a corner minus the origin is larger.
    reach: V,
}

impl<V: Float<WIDTH>> Edges<V> {
    /// The least and the greatest of the values.
    #[inline(always)]
    fn extremes(&self) -> (V, V) {
        let [u, v, w] = self.values;
        (u.min(v).min(w), u.max(v).max(w))
    }

    /// Where the values do not certainly differ in sign.
    #[inline(always)]
    fn open(&self) -> V::Mask {
        let (least, most) = self.extremes();
        !(least.lt(-self.tolerance) & most.gt(self.tolerance))
    }
}

/// Which triangles the ray's line may cross, a bit each.
#[inline(always)]
pub(super) fn crossed<S: Simd>(simd: S, pack: &Pack, ray: &LocalRay) -> u32 {
    edge_functions(simd, &look(simd, pack, ray), ray).open().bits()
}

/// Tests all triangles of the pack.
#[inline(always)]
pub(super) fn test<S: Simd>(simd: S, pack: &Pack, ray: &LocalRay) -> Verdicts {
    let seen = look(simd, pack, ray);
    let edges = edge_functions(simd, &seen, ray);
    let open = edges.open();
    if !open.any() {
        return Verdicts { hits: 0, doubts: 0 };
    }
    let (least, most) = edges.extremes();
    let tolerance = edges.tolerance;
    let inside = least.gt(tolerance) | most.lt(-tolerance);
    let (between, beyond) = depths(simd, pack, &edges, ray);
    let hits = (inside & between).bits();
    Verdicts { hits, doubts: (open & !(inside & beyond)).bits() & !hits }
}

#[inline(always)]
fn look<S: Simd>(simd: S, pack: &Pack, ray: &LocalRay) -> Seen<F8<S>> {
    let [a, b, c] = &pack.corners;
    let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) = (see(simd, a, ray), see(simd, b, ray), see(simd, c, ray));
    Seen { x: [ax, bx, cx], y: [ay, by, cy], z: [az, bz, cz] }
}

/// One corner of all triangles: sheared coordinates and depth.
#[inline(always)]
fn see<S: Simd>(simd: S, corner: &[[f32; WIDTH]; 3], ray: &LocalRay) -> [F8<S>; 3] {
    let [i, j, k] = ray.axes;
    let x = simd.load(&corner[i]) - simd.splat8(ray.origin[i]);
    let y = simd.load(&corner[j]) - simd.splat8(ray.origin[j]);
    let z = simd.load(&corner[k]) - simd.splat8(ray.origin[k]);
    [x - simd.splat8(ray.slope[i]) * z, y - simd.splat8(ray.slope[j]) * z, z]
}

#[inline(always)]
fn edge_functions<S: Simd>(simd: S, seen: &Seen<F8<S>>, ray: &LocalRay) -> Edges<F8<S>> {
    let Seen { x: [ax, bx, cx], y: [ay, by, cy], z: [az, bz, cz] } = *seen;
    let values = [cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax];
    let size = ax.abs().max(ay.abs()).max(bx.abs()).max(by.abs().max(cx.abs()).max(cy.abs()));
    let depth = az.abs().max(bz.abs()).max(cz.abs());
    let reach = size + depth;
    let error = simd.splat8(2.0 * ray.error) + simd.splat8(4.5 * U) * reach;
    let tolerance = simd.splat8(5.5) * error * (size + error) + simd.splat8(f32::MIN_POSITIVE);
    Edges { values, tolerance, reach }
}

/// Which triangles that are certainly crossed are certainly crossed between the ray's ends, and which certainly not.
#[inline(always)]
fn depths<S: Simd>(simd: S, pack: &Pack, edges: &Edges<F8<S>>, ray: &LocalRay) -> (M8<S>, M8<S>) {
    let (volume, volume_error) = volume(simd, pack, edges.reach, ray);
    let [u, v, w] = edges.values;
    let sum = u + v + w;
    let size = sum.abs();
    // The depth times |sum|, along the ray.
    let depth = volume.flip_sign(sum) * simd.splat8(-ray.forward);
    let left = size * simd.splat8(ray.end) - depth;
    let left_error = volume_error
        + size * simd.splat8(ray.end_error + 3.0 * U * ray.end.abs())
        + edges.tolerance * simd.splat8(4.0 * ray.end.abs());
    let between = depth.gt(volume_error) & left.gt(left_error);
    let beyond = depth.lt(-volume_error) | left.lt(-left_error);
    (between, beyond)
}

/// The determinant (a − o, b − a, c − a), and a bound on its error.
#[inline(always)]
fn volume<S: Simd>(simd: S, pack: &Pack, reach: F8<S>, ray: &LocalRay) -> (F8<S>, F8<S>) {
    let [a, b, c] = &pack.corners;
    let (ax, ay, az) = (simd.load(&a[0]), simd.load(&a[1]), simd.load(&a[2]));
    let (bx, by, bz) = (simd.load(&b[0]) - ax, simd.load(&b[1]) - ay, simd.load(&b[2]) - az);
    let (cx, cy, cz) = (simd.load(&c[0]) - ax, simd.load(&c[1]) - ay, simd.load(&c[2]) - az);
    let [ox, oy, oz] = ray.origin;
    let (ax, ay, az) = (ax - simd.splat8(ox), ay - simd.splat8(oy), az - simd.splat8(oz));
    let (p, q, r) = (by * cz, bz * cx, bx * cy);
    let (s, t, w) = (bz * cy, bx * cz, by * cx);
    let volume = ax * (p - s) + ay * (q - t) + az * (r - w);
    let permanent = ax.abs() * (p.abs() + s.abs()) + ay.abs() * (q.abs() + t.abs()) + az.abs() * (r.abs() + w.abs());
    let wide = reach + simd.splat8(2.0 * ray.error);
    let error =
        simd.splat8(8.0 * U) * permanent + simd.splat8(80.0 * ray.error) * wide * wide + simd.splat8(f32::MIN_POSITIVE);
    (volume, error)
}
