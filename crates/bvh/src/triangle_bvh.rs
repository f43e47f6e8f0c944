//! A bounding volume hierarchy over triangles, eight children a node, for rays and segments.
//!
//! Boxes and triangles lie in memory as f32, eight side by side ([`layout`]); one ray is tested against eight at once
//! (Wald, Benthin and Boulos, "Getting rid of packets", IEEE Symposium on Interactive Ray Tracing 2008). Guarantee:
//! boxes are rounded outward and never miss in vain; the f32 test of a triangle has a derived error bound
//! ([`pack_test`]), and what it leaves in doubt is decided by exact arithmetic or by the caller. So `any_hit` is
//! exactly the definition of blocking ([`umbriel_geometry::blocking`]) over all triangles.

mod any_hit;
mod any_hits;
mod bounds;
mod boxes;
mod build;
mod bundle;
mod check;
mod frame;
mod layout;
mod morton;
mod nearest;
mod pack_test;
mod packet;
mod ray;
mod shaft;
#[cfg(test)]
mod tests;
mod triangle_ray;

use std::{ops::Add, sync::Arc};

use glam::DVec3;
use umbriel_geometry::{
    LightSource, Mesh,
    decisions::{Level, count},
    simd,
};

use self::{
    any_hit::{AnyHit, Stack},
    any_hits::{AnyHits, Segments},
    build::{MAX_DEPTH, Parts},
    bundle::{BUNDLE, Bundle},
    morton::morton_order,
    nearest::Nearest,
    ray::{LocalRay, Way},
};
use crate::{box_tree::TreeDefect, ray::Ray, shaft::Segment};

pub use build::BuildQuality;
pub use nearest::Steps;
pub use triangle_ray::{Hit, TriangleRay};

/// The triangles of a mesh in a tree of boxes. Both sides of a triangle count. The mesh is shared, not copied.
#[derive(Clone, Debug)]
pub struct TriangleBvh {
    parts: Parts,
    mesh: Arc<Mesh>,
}

impl TriangleBvh {
    /// So many rays share a walk in [`TriangleBvh::nearest_hits`].
    pub const BUNDLE: usize = BUNDLE;

    /// Builds a good tree, in the coordinates of the mesh. O(n log n).
    pub fn build(mesh: Arc<Mesh>) -> Self {
        Self::build_with(mesh, BuildQuality::Good)
    }

    /// Builds a tree, in the coordinates of the mesh. Answers do not depend on the quality.
    pub fn build_with(mesh: Arc<Mesh>, quality: BuildQuality) -> Self {
        Self { parts: build::build(&mesh, quality), mesh }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
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
    #[inline]
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.mesh.triangles()[triangle as usize].map(|index| self.mesh.positions()[index as usize])
    }

    /// Bytes that the tree takes, without its mesh.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.parts.nodes) + size_of_val(&*self.parts.packs)
    }

    /// Checks the tree against its mesh: boxes nest, every triangle is there once, the depth is bounded. O(n).
    ///
    /// # Errors
    /// The first [`TreeDefect`].
    pub fn check(&self) -> Result<(), TreeDefect> {
        check::check(self)
    }

    /// Whether any triangle blocks the open segment: exactly what [`polygon_blocks`](umbriel_geometry::blocking::polygon_blocks) says of all of them. Contact at
    /// its ends does not block. For many segments to one light, [`TriangleBvh::towards`] is faster.
    pub fn any_hit(&self, segment: &Segment) -> bool {
        self.towards(segment.light).any_hit(segment.origin)
    }

    /// Segments to one light.
    pub fn towards(&self, light: LightSource) -> Towards<'_> {
        Towards { bvh: self, light, last: None, stack: [(0, 0); MAX_DEPTH] }
    }

    /// The first triangle that the ray `origin + t direction` hits for 0 < t ≤ `t_max`; the lower one of equals.
    ///
    /// `direction` may have any length but zero; t counts in that length. Rounded: for pictures, not for proofs.
    pub fn nearest_hit(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<Hit> {
        let mut search = self.search::<false>(origin, direction, t_max)?;
        simd::dispatch(&mut search);
        search.hit
    }

    /// [`TriangleBvh::nearest_hit`] of many rays, each with its own `t_max`. Sixteen that follow each other share one walk, which pays where they go nearly the same
    /// way, as those of neighbouring pixels do; answers do not depend on it.
    pub fn nearest_hits(&self, rays: &[(Ray, f64)]) -> Vec<Option<Hit>> {
        let mut hits = Vec::with_capacity(rays.len());
        let mut searches = [const { None }; BUNDLE];
        for rays in rays.chunks(BUNDLE) {
            let (is_done, _) = self.in_a_bundle::<false>(rays, &mut searches);
            hits.extend(rays.iter().zip(&searches).map(|((ray, t_max), search)| {
                let known = search.as_ref().and_then(|search| search.hit);
                let end = known.map_or(*t_max, |hit| hit.t);
                if is_done { known } else { self.nearest_hit(ray.origin, ray.direction, end) }
            }));
        }
        hits
    }

    /// What [`TriangleBvh::nearest_hits`] looks at for the same rays.
    pub fn nearest_hits_steps(&self, rays: &[(Ray, f64)]) -> Steps {
        let mut steps = Steps::default();
        let mut searches = [const { None }; BUNDLE];
        for rays in rays.chunks(BUNDLE) {
            let (is_done, nodes) = self.in_a_bundle::<true>(rays, &mut searches);
            let found = searches.iter().flatten().map(Nearest::steps).fold(Steps::default(), Steps::add);
            steps = steps + Steps { nodes: found.nodes + nodes, ..found };
            if !is_done {
                let single = |(ray, t_max): &(Ray, f64)| self.nearest_steps(ray.origin, ray.direction, *t_max);
                steps = rays.iter().map(single).fold(Steps { hits: steps.hits - found.hits, ..steps }, Steps::add);
            }
        }
        steps
    }

    /// Searches for the nearest hits of at most [`BUNDLE`] rays together: whether that came to an end, and how many nodes were looked at.
    fn in_a_bundle<'a, const COUNTED: bool>(
        &'a self,
        rays: &[(Ray, f64)],
        searches: &mut [Option<Nearest<'a, COUNTED>>; BUNDLE],
    ) -> (bool, u32) {
        searches.fill_with(|| None);
        let Some(mut bundle) = Bundle::new(self, rays, searches) else { return (false, 0) };
        let is_done = simd::dispatch(&mut bundle);
        (is_done, bundle.nodes)
    }

    /// What [`TriangleBvh::nearest_hit`] looks at for the same ray.
    pub fn nearest_steps(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Steps {
        let Some(mut search) = self.search::<true>(origin, direction, t_max) else { return Steps::default() };
        simd::dispatch(&mut search);
        search.steps()
    }

    #[inline(always)]
    fn search<const COUNTED: bool>(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<Nearest<'_, COUNTED>> {
        let way = Way { origin, direction, end: t_max, slack: 0.0 };
        let local = LocalRay::new(&self.parts.frame, &way, self.parts.corner_error)?;
        Some(Nearest { bvh: self, way, local, ray: None, t_max, hit: None, steps: Steps::default() })
    }
}

/// Segments from many points to one light. What the last one met is tried first for the next one, so neighbours should
/// follow each other; answers do not depend on it.
#[derive(Clone, Debug)]
pub struct Towards<'a> {
    bvh: &'a TriangleBvh,
    light: LightSource,
    /// The pack that blocked the last segment.
    last: Option<u32>,
    /// For the walk through the tree.
    stack: Stack,
}

impl Towards<'_> {
    /// Whether any triangle blocks the open segment from `origin` to the light: exactly what [`polygon_blocks`](umbriel_geometry::blocking::polygon_blocks) says of
    /// all of them.
    #[inline]
    pub fn any_hit(&mut self, origin: DVec3) -> bool {
        let segments = Segments { bvh: self.bvh, light: self.light };
        self.any_hit_where(origin, 0.0, |triangle| segments.exact(origin, triangle))
    }

    /// [`Towards::any_hit`] of many points, neighbours next to each other in the list: sixteen of them share one walk.
    pub fn any_hits(&self, origins: &[DVec3]) -> Vec<bool> {
        self.any_hits_along(origins, &[])
    }

    /// [`Towards::any_hit`] of many points in no order, at most 2^32: they are sorted, then as [`Towards::any_hits`].
    pub fn any_hits_unordered(&self, origins: &[DVec3]) -> Vec<bool> {
        self.any_hits_along(origins, &morton_order(origins))
    }

    fn any_hits_along(&self, origins: &[DVec3], order: &[u32]) -> Vec<bool> {
        let mut blocked = vec![false; origins.len()];
        let segments = Segments { bvh: self.bvh, light: self.light };
        simd::dispatch(AnyHits { segments, origins, order, blocked: &mut blocked });
        blocked
    }

    /// As [`Towards::any_hit`] for a point that is not a float: it is within `slack` of `origin` on every axis, and
    /// `decide` tells whether a triangle blocks its segment. It is asked about triangles in doubt only, until it says yes, in
    /// no particular order; those that the point lies on are always in doubt.
    #[inline]
    pub fn any_hit_where(&mut self, origin: DVec3, slack: f64, mut decide: impl FnMut(u32) -> bool) -> bool {
        let parts = &self.bvh.parts;
        let way = Way::towards(&self.light, origin, slack);
        let mut is_settled = true;
        let decide = |triangle| {
            is_settled = false;
            decide(triangle)
        };
        self.last = simd::dispatch(&mut AnyHit { parts, way: &way, first: self.last, stack: &mut self.stack, decide });
        count(Level::Single, u64::from(is_settled));
        self.last.is_some()
    }
}
