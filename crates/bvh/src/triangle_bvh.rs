//! A bounding volume hierarchy over triangles: any hit for proofs, nearest hit for pictures.
//!
//! *Any hit* hands candidates to an exact predicate of the caller's; the tree only leaves out triangles whose boxes
//! the segment misses for certain, so the decision is exactly that of a loop over all triangles.
//!
//! *Nearest hit* is the watertight test of Woop, Benthin and Wald, "Watertight ray/triangle intersection", Journal of
//! Computer Graphics Techniques 2(1), 2013, in f64. The corners are sheared so that the ray becomes the z axis; the
//! edge functions of two triangles that share an edge are then exact negatives of one another, and zero counts as
//! inside, so no ray slips between them. What breaks it: a triangle that the ray sees edge-on is not hit, and t is a
//! rounded number. Nothing is proved by it. Equal t goes to the lower triangle, so the answer does not depend on the
//! tree.

use std::{ops::ControlFlow, sync::Arc};

use glam::DVec3;
use umbriel_geometry::{Aabb, Mesh};

use crate::{box_tree::BoxTree, ray::Ray, shaft::Shaft};

#[cfg(test)]
mod tests;

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

/// The triangles of a mesh in a tree of boxes. Both sides of a triangle count. The mesh is shared, not copied.
#[derive(Clone, Debug)]
pub struct TriangleBvh {
    tree: BoxTree,
    mesh: Arc<Mesh>,
}

impl TriangleBvh {
    /// Builds the tree, in the coordinates of the mesh. O(n log n).
    pub fn build(mesh: Arc<Mesh>) -> Self {
        let boxes: Vec<Aabb> = mesh.triangles().iter().map(|triangle| Aabb::of(corners(&mesh, triangle))).collect();
        Self { tree: BoxTree::build(&boxes), mesh }
    }

    /// The tree over the triangles' boxes.
    pub fn tree(&self) -> &BoxTree {
        &self.tree
    }

    /// How many triangles.
    pub fn len(&self) -> usize {
        self.mesh.triangles().len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.mesh.triangles().is_empty()
    }

    /// The corners of a triangle.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        corners(&self.mesh, &self.mesh.triangles()[triangle as usize])
    }

    /// Whether `blocks` is true for any triangle whose box may meet the segment: a [`Segment`](crate::Segment) from a
    /// point to a light, or a [`Shaft`] where the point itself is only known to lie in a box.
    ///
    /// `blocks` decides about one triangle and is asked until it says yes, in no particular order.
    pub fn any_hit(&self, segment: impl Into<Shaft>, mut blocks: impl FnMut(u32) -> bool) -> bool {
        let visit = |triangle| if blocks(triangle) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        self.tree.for_each_in_shaft(&segment.into(), visit).is_break()
    }

    /// The first triangle that the ray `origin + t direction` hits for 0 < t ≤ `t_max`; the lower one of equals.
    ///
    /// `direction` may have any length but zero; t counts in that length. Rounded: for pictures, not for proofs.
    pub fn nearest_hit(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<Hit> {
        let (ray, shear) = (Ray::new(origin, direction), Shear::new(origin, direction)?);
        let mut nearest: Option<Hit> = None;
        self.tree.for_each_near(&ray, t_max, |triangle, span, t_max| {
            let is_nearer =
                |hit: &Hit| hit.t < t_max || hit.t == t_max && nearest.is_none_or(|known| known.triangle > triangle);
            let hit = shear.hit(self.corners(triangle), triangle, span).filter(is_nearer);
            nearest = hit.or(nearest);
            hit.map_or(t_max, |hit| hit.t)
        });
        nearest
    }
}

fn corners(mesh: &Mesh, triangle: &[u32; 3]) -> [DVec3; 3] {
    triangle.map(|index| mesh.positions()[index as usize])
}

/// The change of coordinates that turns a ray into the unit z axis.
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
    fn apply(&self, corner: DVec3) -> DVec3 {
        let away = corner - self.origin;
        let [x, y, z] = self.axes.map(|axis| away[axis]);
        DVec3::new(x - self.factors.x * z, y - self.factors.y * z, self.factors.z * z)
    }

    /// The hit with one triangle. `span` is where the ray is in the triangle's box, and t is kept inside: this undoes
    /// part of the rounding and makes the order of hits that of the boxes.
    fn hit(&self, corners: [DVec3; 3], triangle: u32, span: (f64, f64)) -> Option<Hit> {
        let [a, b, c] = corners.map(|corner| self.apply(corner));
        let weights = DVec3::new(cross(c, b), cross(a, c), cross(b, a));
        if weights.min_element() < 0.0 && weights.max_element() > 0.0 {
            return None;
        }
        let sum = weights.x + weights.y + weights.z;
        let t = weights.dot(DVec3::new(a.z, b.z, c.z)) / sum;
        // Zero over zero for an edge-on triangle is neither.
        (t > 0.0).then(|| Hit { triangle, t: t.min(span.1).max(span.0), u: weights.y / sum, v: weights.z / sum })
    }
}

/// Twice the area that the origin spans with a and b, seen along z.
fn cross(a: DVec3, b: DVec3) -> f64 {
    a.x * b.y - a.y * b.x
}
