//! One shadow ray a point, through a tree of triangles.
//!
//! The tree is that of [`umbriel_bvh`], eight children a node; sixteen neighbours share a walk elsewhere, here every point has its own ray, as in a
//! renderer. Its test of a triangle is exact for the float point, so what is wrong is wrong because the point was rounded, or because triangles stand for
//! a curved body. O(n log n) to build, O(log n) a point. The triangles of the point's own face do not count; curved bodies have trees of their own, so that
//! those of the point's own body do not, either.

use std::{ops::ControlFlow, sync::Arc, time::Instant};

use glam::DVec3;
use rayon::prelude::*;
use umbriel_bvh::{BoxTree, Shaft, Towards, TriangleBvh};
use umbriel_geometry::{
    Aabb, Dyadic, LightSource, Mesh, Point,
    blocking::{Probe, polygon_blocks},
};

use super::{Polygons, Rival, RivalAnswer, RivalPoint, RivalRefusal, polygons::triangles_of};

/// Points that one thread takes at a time.
const CHUNK: usize = 4096;

/// One ray a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PointRays;

impl Rival for PointRays {
    fn name(&self) -> String {
        "rays".into()
    }

    fn answer(
        &self,
        polygons: &Polygons,
        light: &LightSource,
        points: &[RivalPoint],
    ) -> Result<RivalAnswer, RivalRefusal> {
        let begun = Instant::now();
        let trees = Trees::new(polygons);
        let build_seconds = begun.elapsed().as_secs_f64();
        let begun = Instant::now();
        let chunks: Vec<Vec<bool>> = points.par_chunks(CHUNK).map(|chunk| trees.cast(light, chunk)).collect();
        let lit: Vec<bool> = chunks.concat();
        let rays = points.iter().filter(|point| point.is_turned_to(light)).count() as u64;
        // Positions and corners of the mesh, and about 80 bytes a triangle of tree.
        let bytes = 24 * polygons.mesh().positions().len() as u64 + 92 * polygons.len() as u64;
        let points_seconds = begun.elapsed().as_secs_f64();
        Ok(RivalAnswer { lit, build_seconds, points_seconds, rays, looked_at: 0, pieces: polygons.len() as u64, bytes })
    }
}

/// The trees that rays go through.
struct Trees<'a> {
    polygons: &'a Polygons<'a>,
    /// Of all flat objects.
    flat: TriangleBvh,
    /// The triangles of `flat` as the polygons number them.
    numbers: Vec<u32>,
    /// Of each curved body.
    curved: Vec<(u32, TriangleBvh)>,
    /// Over the boxes of these.
    boxes: BoxTree,
}

impl<'a> Trees<'a> {
    fn new(polygons: &'a Polygons<'a>) -> Self {
        let bodies: Vec<u32> = (0..polygons.boxes().len() as u32).filter(|&k| polygons.is_curved(k as usize)).collect();
        let is_flat = |&triangle: &u32| !polygons.is_curved(polygons.owner(triangle as usize).object as usize);
        let numbers: Vec<u32> = (0..polygons.len() as u32).filter(is_flat).collect();
        let flat = if bodies.is_empty() {
            Arc::clone(polygons.mesh())
        } else {
            let corners = |&triangle: &u32| polygons.mesh().triangles()[triangle as usize];
            part(polygons.mesh().positions(), numbers.iter().map(corners).collect())
        };
        let tree = |&object: &u32| {
            let facets = polygons.facets(object as usize);
            let triangles = triangles_of(facets).into_iter().map(|(corners, _)| corners).collect();
            (object, TriangleBvh::build(part(facets.positions(), triangles)))
        };
        let curved = bodies.par_iter().map(tree).collect();
        let boxes: Vec<Aabb> = bodies.iter().map(|&object| polygons.boxes()[object as usize]).collect();
        Self { polygons, flat: TriangleBvh::build(flat), numbers, curved, boxes: BoxTree::build(&boxes) }
    }

    /// Whether each point is lit.
    fn cast(&self, light: &LightSource, points: &[RivalPoint]) -> Vec<bool> {
        let mut flat = self.flat.towards(*light);
        let mut curved: Vec<Towards> = self.curved.iter().map(|(_, tree)| tree.towards(*light)).collect();
        let is_lit = |point: &RivalPoint| {
            point.is_turned_to(light)
                && !self.flat_blocks(&mut flat, light, point)
                && !self.curved_blocks(&mut curved, light, point)
        };
        points.iter().map(is_lit).collect()
    }

    fn flat_blocks(&self, towards: &mut Towards, light: &LightSource, point: &RivalPoint) -> bool {
        let probe = Probe::<Dyadic>::at(point.position);
        // The slack leaves the own face in doubt, so that it is asked about here.
        let blocks = |triangle: u32| {
            let corners = self.flat.corners(triangle).map(Point::exact);
            let number = self.numbers[triangle as usize] as usize;
            !self.polygons.is_own(number, point) && polygon_blocks(&corners, &probe, light)
        };
        towards.any_hit_where(point.position, point.slack, blocks)
    }

    fn curved_blocks(&self, towards: &mut [Towards], light: &LightSource, point: &RivalPoint) -> bool {
        let bounds = Aabb::of([point.position]).widened(DVec3::splat(point.slack));
        let walk = self.boxes.for_each_in_shaft(&Shaft::new(&bounds, light), |body| {
            let is_own = self.curved[body as usize].0 == point.object;
            if !is_own && towards[body as usize].any_hit(point.position) {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        walk.is_break()
    }
}

/// Some triangles over placed positions.
fn part(positions: &[DVec3], triangles: Vec<[u32; 3]>) -> Arc<Mesh> {
    let positions = positions.iter().map(DVec3::to_array).collect();
    Arc::new(Mesh::new(positions, triangles).expect("placed faces have accepted corners"))
}
