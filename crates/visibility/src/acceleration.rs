//! How the rays of a view find the triangles of a mesh: by a BVH, by an octree, or looked up in the octree's projection.
//!
//! All ways give the same hits. Which is quickest depends on the mesh and on how many rays there are: a projection is built for
//! one viewpoint, so its building must pay in one picture. The model is linear: so many rays through a mesh of n triangles take
//! rays · (base + doubling · log₂ n) + triangle · n nanoseconds, where the last term is building, and touching everything
//! for the first time. `cargo xtask calibrate` measures the coefficients.

use std::sync::Arc;

use glam::DAffine3;
use umbriel_bvh::{Hit, Ray, TriangleBvh};
use umbriel_octree::{Projection, ProjectionOptions, Viewpoint};

use crate::view::Beam;

/// How rays find the triangles of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Acceleration {
    /// By a bounding volume hierarchy.
    Bvh,
    /// By an octree, from its root down.
    Octree,
    /// By maps of an octree's projection from the viewpoint.
    Projection,
    /// By what a [`CostModel`] says is quickest.
    #[default]
    Auto,
}

/// What rays cost one way, nanoseconds; see the header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayCost {
    /// Of any ray.
    pub base: f64,
    /// More for each doubling of the triangles.
    pub doubling: f64,
    /// Of each triangle, whatever the rays.
    pub triangle: f64,
}

impl RayCost {
    /// Nanoseconds for so many rays through so many triangles.
    pub fn nanoseconds(&self, rays: u64, triangles: usize) -> f64 {
        let (rays, triangles) = (rays as f64, triangles.max(1) as f64);
        rays * (self.base + self.doubling * triangles.log2()) + self.triangle * triangles
    }
}

/// What decides for [`Acceleration::Auto`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostModel {
    /// The BVH, which is there already.
    pub bvh: RayCost,
    /// The octree, built.
    pub octree: RayCost,
    /// The projection, built.
    pub projection: RayCost,
}

impl CostModel {
    /// After the figures of `docs/projection.md`, on one thread. `cargo xtask calibrate` finds those of another machine.
    pub const MEASURED: Self = Self {
        bvh: RayCost { base: 0.0, doubling: 9.5, triangle: 0.0 },
        octree: RayCost { base: 100.0, doubling: 14.0, triangle: 7000.0 },
        projection: RayCost { base: 45.0, doubling: 4.0, triangle: 8500.0 },
    };
}

impl Default for CostModel {
    fn default() -> Self {
        Self::MEASURED
    }
}

/// An octree is built only where it should take less than this share of the BVH's time: a model is no measurement.
const CLEARLY: f64 = 0.9;

/// How the rays of a view find the triangles of an object, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Index into the scene's objects.
    pub object: usize,
    /// What was chosen; never [`Acceleration::Auto`].
    pub chosen: Acceleration,
    /// Triangles of the object.
    pub triangles: usize,
    /// Rays that are expected to come near it.
    pub rays: u64,
    /// Nanoseconds that the model expects: BVH, octree, projection.
    pub expected: [f64; 3],
}

impl Choice {
    pub(crate) fn new(
        object: usize,
        acceleration: Acceleration,
        triangles: usize,
        rays: u64,
        costs: &CostModel,
    ) -> Self {
        let expected = [costs.bvh, costs.octree, costs.projection].map(|cost| cost.nanoseconds(rays, triangles));
        let [bvh, octree, projection] = expected;
        let chosen = match acceleration {
            Acceleration::Auto if octree.min(projection) > CLEARLY * bvh => Acceleration::Bvh,
            Acceleration::Auto if octree < projection => Acceleration::Octree,
            Acceleration::Auto => Acceleration::Projection,
            asked => asked,
        };
        Self { object, chosen, triangles, rays, expected }
    }
}

/// A mesh made ready for the rays of a view.
#[derive(Debug)]
pub(crate) struct Prepared {
    projection: Projection,
    is_looked_up: bool,
}

impl Prepared {
    /// What was chosen; or the BVH after all, where the view cannot be projected.
    pub(crate) fn new(choice: Choice, bvh: &TriangleBvh, to_local: &DAffine3, beam: &Beam) -> (Choice, Option<Self>) {
        let is_looked_up = choice.chosen == Acceleration::Projection;
        if choice.chosen == Acceleration::Bvh {
            return (choice, None);
        }
        let viewpoint = match *beam {
            Beam::Perspective { eye, forward, right, up } => Viewpoint::Picture {
                eye: to_local.transform_point3(eye),
                forward: to_local.transform_vector3(forward),
                right: to_local.transform_vector3(right),
                up: to_local.transform_vector3(up),
            },
            Beam::Parallel { direction } => Viewpoint::Parallel(to_local.transform_vector3(direction)),
        };
        let options = ProjectionOptions {
            max_level: ProjectionOptions::level_for(choice.triangles) + if is_looked_up { 0 } else { 2 },
            // Without maps to speak of where nothing is looked up.
            rays: if is_looked_up { choice.rays } else { 0 },
            ..ProjectionOptions::default()
        };
        match Projection::build(Arc::clone(bvh.mesh()), viewpoint, &options) {
            Ok(projection) => (choice, Some(Self { projection, is_looked_up })),
            Err(_) => (Choice { chosen: Acceleration::Bvh, ..choice }, None),
        }
    }

    /// The nearest hit of a local ray; `None` for one that is not of the view.
    pub(crate) fn nearest_hit(&self, ray: &Ray, t_max: f64) -> Option<Option<Hit>> {
        let Ray { origin, direction, .. } = *ray;
        let found = if self.is_looked_up {
            self.projection.nearest_hit(origin, direction, t_max)
        } else {
            self.projection.nearest_hit_by_descent(origin, direction, t_max)
        };
        found.ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_rays_pay_for_a_projection_and_few_do_not() {
        let chosen = |rays, triangles| Choice::new(0, Acceleration::Auto, triangles, rays, &CostModel::MEASURED).chosen;
        assert_eq!(chosen(1 << 24, 1 << 12), Acceleration::Projection);
        assert_eq!(chosen(1 << 8, 1 << 20), Acceleration::Bvh);
        assert_eq!(chosen(0, 0), Acceleration::Bvh);
        let asked = Choice::new(0, Acceleration::Octree, 1 << 20, 1, &CostModel::MEASURED);
        assert_eq!(asked.chosen, Acceleration::Octree, "what is asked for is done");
    }
}
