//! One ray against single triangles, in f64: where does it meet them? For pictures.
//!
//! The watertight test of Woop, Benthin and Wald, "Watertight ray/triangle intersection", Journal of Computer Graphics
//! Techniques 2(1), 2013. The corners are sheared so that the ray becomes the z axis; the edge functions of two triangles
//! that share an edge are then exact negatives of one another, and zero counts as inside, so no ray slips between them.
//! What breaks it: a triangle that the ray sees edge-on is not hit, and t is a rounded number.

use glam::DVec3;
use umbriel_geometry::Aabb;

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

/// A ray made ready for triangles: what [`TriangleBvh::nearest_hit`](crate::TriangleBvh::nearest_hit) measures hits with,
/// for other structures that are to find the same ones.
#[derive(Clone, Copy, Debug)]
pub struct TriangleRay {
    ray: Ray,
    shear: Shear,
}

impl TriangleRay {
    /// The points `origin + t direction`, t > 0; `None` when there is no direction.
    pub fn new(origin: DVec3, direction: DVec3) -> Option<Self> {
        Some(Self { ray: Ray::new(origin, direction), shear: Shear::new(origin, direction)? })
    }

    /// The hit with the triangle that has these corners. O(1).
    pub fn hit(&self, corners: [DVec3; 3], triangle: u32) -> Option<Hit> {
        self.hit_within(corners, triangle, f64::INFINITY)
    }

    /// As [`TriangleRay::hit`], of the hits with t ≤ `t_max`; others may be left out.
    #[inline]
    pub(super) fn hit_within(&self, corners: [DVec3; 3], triangle: u32, t_max: f64) -> Option<Hit> {
        let span = self.ray.span(&Aabb::of(corners)).filter(|span| span.0 <= t_max)?;
        self.shear.hit(corners, triangle, span)
    }
}

/// The change of coordinates that turns a ray into the unit z axis.
#[derive(Clone, Copy, Debug)]
struct Shear {
    origin: DVec3,
    axes: [usize; 3],
    /// Factors for x and y, and the scale of z.
    factors: DVec3,
}

impl Shear {
    /// `None` when there is no direction.
    fn new(origin: DVec3, direction: DVec3) -> Option<Self> {
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
    #[inline]
    fn apply(&self, corner: DVec3) -> DVec3 {
        let away = corner - self.origin;
        let [x, y, z] = self.axes.map(|axis| away[axis]);
        DVec3::new(x - self.factors.x * z, y - self.factors.y * z, self.factors.z * z)
    }

    /// The hit with one triangle. `span` is where the ray is in the triangle's box, and t is kept inside: this undoes
    /// part of the rounding and makes the order of hits that of the boxes.
    fn hit(&self, corners: [DVec3; 3], triangle: u32, span: (f64, f64)) -> Option<Hit> {
        let [a, b, c] = corners;
        let (a, b, c) = (self.apply(a), self.apply(b), self.apply(c));
        let weights = DVec3::new(cross(c, b), cross(a, c), cross(b, a));
        if weights.min_element() < 0.0 && weights.max_element() > 0.0 {
            return None;
        }
        let sum = weights.x + weights.y + weights.z;
        let t = weights.dot(DVec3::new(a.z, b.z, c.z)) / sum;
        // Zero over zero for an edge-on triangle is neither. Where its weights are rounding alone, the ray may leave the box where it begins.
        let kept = t.min(span.1).max(span.0);
        (t > 0.0 && kept > 0.0).then(|| Hit { triangle, t: kept, u: weights.y / sum, v: weights.z / sum })
    }
}

/// Twice the area that the origin spans with a and b, seen along z.
fn cross(a: DVec3, b: DVec3) -> f64 {
    a.x * b.y - a.y * b.x
}
