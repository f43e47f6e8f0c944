//! One shadow ray a point, through a tree of triangles.
//!
//! The tree is that of [`umbriel_bvh`], eight children a node; sixteen neighbours share a walk elsewhere, here every point has its own ray, as in a
//! renderer. Its test of a triangle is exact for the float point, so what is wrong is wrong because the point was rounded. O(n log n) to
//! build, O(log n) a point. The triangles of the point's own face do not count.

use std::time::Instant;

use rayon::prelude::*;
use umbriel_bvh::TriangleBvh;
use umbriel_geometry::{
    Dyadic, LightSource, Point,
    blocking::{Probe, polygon_blocks},
};

use super::{Polygons, Rival, RivalAnswer, RivalPoint, RivalRefusal};

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
        let bvh = TriangleBvh::build(polygons.mesh().clone());
        let build_seconds = begun.elapsed().as_secs_f64();
        let begun = Instant::now();
        let chunks: Vec<Vec<bool>> = points.par_chunks(CHUNK).map(|chunk| cast(polygons, &bvh, light, chunk)).collect();
        let lit: Vec<bool> = chunks.concat();
        let rays = points.iter().filter(|point| point.is_turned_to(light)).count() as u64;
        // Positions and corners of the mesh, and about 80 bytes a triangle of tree.
        let bytes = 24 * polygons.mesh().positions().len() as u64 + 92 * polygons.len() as u64;
        let points_seconds = begun.elapsed().as_secs_f64();
        Ok(RivalAnswer { lit, build_seconds, points_seconds, rays, pieces: polygons.len() as u64, bytes })
    }
}

/// Whether each point is lit.
fn cast(polygons: &Polygons, bvh: &TriangleBvh, light: &LightSource, points: &[RivalPoint]) -> Vec<bool> {
    let mut towards = bvh.towards(*light);
    let is_lit = |point: &RivalPoint| {
        let probe = Probe::<Dyadic>::at(point.position);
        // The slack leaves the own face in doubt, so that it is asked about here.
        let blocks = |triangle: u32| {
            let corners = bvh.corners(triangle).map(Point::exact);
            !polygons.is_own(triangle as usize, point) && polygon_blocks(&corners, &probe, light)
        };
        point.is_turned_to(light) && !towards.any_hit_where(point.position, point.slack, blocks)
    };
    points.iter().map(is_lit).collect()
}
