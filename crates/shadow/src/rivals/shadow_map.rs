//! Shadow maps: what a light sees, as depths on a grid.
//!
//! Williams, "Casting curved shadows on curved surfaces" (SIGGRAPH 1978), on [`depth_map`](umbriel_visibility::depth_map). A sun's map is orthographic, as tight
//! as the scene allows; a lamp outside the scene has one perspective map, a lamp inside six, on the sides of a cube. A point is in
//! shadow if its texel is nearer by more than the bias: a constant share of a texel, and the depth that the surface's slope covers across the texel's
//! half diagonal (slope-scaled bias). No bound: borders are as jagged as texels, contacts leak by the bias, thin things fall between middles.

use std::{f64::consts::SQRT_2, time::Instant};

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::LightSource;
use umbriel_visibility::depth_map::{CurvedBodies, DepthMap, LightSpace};

use super::{Polygons, Rival, RivalAnswer, RivalPoint, RivalRefusal};

/// Lamps that see the scene within this slope have one map, others six.
const WIDEST_SLOPE: f64 = 2.0;

/// A depth map as rivals use it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowMap {
    /// Texels along an edge; a lamp inside the scene has six such maps.
    pub size: usize,
    /// Constant bias in texels.
    pub constant: f64,
    /// How much of the surface's slope is added, 1 for what a texel's half diagonal covers.
    pub slope: f64,
}

impl ShadowMap {
    /// A map of `size` × `size` texels with the usual biases.
    pub fn new(size: usize) -> Self {
        Self { size: size.max(1), constant: 0.1, slope: 1.0 }
    }
}

impl Rival for ShadowMap {
    fn name(&self) -> String {
        format!("shadow map {}", self.size)
    }

    fn answer(
        &self,
        polygons: &Polygons,
        light: &LightSource,
        points: &[RivalPoint],
    ) -> Result<RivalAnswer, RivalRefusal> {
        let begun = Instant::now();
        let none = CurvedBodies::default();
        let triangles = || (0..polygons.len()).into_par_iter().map(|triangle| polygons.corners(triangle));
        let spaces = spaces(polygons, light, self.size).into_iter();
        let maps: Vec<DepthMap> = spaces.map(|space| DepthMap::of_triangles(space, triangles(), &none)).collect();
        let build_seconds = begun.elapsed().as_secs_f64();
        let begun = Instant::now();
        let lit =
            points.par_iter().map(|point| point.is_turned_to(light) && self.is_lit(&maps, light, point)).collect();
        let texels = (maps.len() * self.size * self.size) as u64;
        let points_seconds = begun.elapsed().as_secs_f64();
        Ok(RivalAnswer { lit, build_seconds, points_seconds, rays: 0, looked_at: 0, pieces: texels, bytes: 4 * texels })
    }
}

impl ShadowMap {
    fn is_lit(&self, maps: &[DepthMap], light: &LightSource, point: &RivalPoint) -> bool {
        maps.iter().find_map(|map| self.is_lit_in(map, light, point)).unwrap_or(true)
    }

    /// Whether a point is lit; `None` for a point beyond the window.
    fn is_lit_in(&self, map: &DepthMap, light: &LightSource, point: &RivalPoint) -> Option<bool> {
        let space = &map.space;
        let seen = space.to_light(point.position);
        if !space.is_before(seen) {
            return None;
        }
        let at = space.to_texels(seen);
        let [column, row] =
            [at.x, at.y].map(|x| if x >= 0.0 && x < map.size() as f64 { x as usize } else { usize::MAX });
        if column == usize::MAX || row == usize::MAX {
            return None;
        }
        let texel = space.texel() * if light.is_sun() { 1.0 } else { seen.z };
        let to_light = (light.xyz() - light.w() * point.position).normalize_or_zero();
        // A slope steeper than a thousand counts as that: the bias stays finite.
        let cosine = (point.normal.normalize_or_zero().dot(to_light)).abs().max(1e-3);
        let tangent = (1.0 - cosine * cosine).max(0.0).sqrt() / cosine;
        let half_diagonal = 0.5 * SQRT_2;
        let depth = seen.z - texel * (self.constant + self.slope * half_diagonal * tangent);
        // A lamp that stands within the bias sees the point, for nothing is drawn so near.
        Some(f64::from(map.row(row)[column]) >= depth)
    }
}

/// What maps of a light look at: one space, or six round a lamp.
fn spaces(polygons: &Polygons, light: &LightSource, size: usize) -> Vec<LightSpace> {
    let corners = || polygons.mesh().positions().iter().copied();
    if light.is_sun() {
        return vec![LightSpace::parallel(-light.xyz(), corners(), size)];
    }
    let origin = light.xyz();
    let whole = LightSpace::round(origin, polygons.bounds().center() - origin, corners(), size);
    let is_before = |seen: DVec3| seen.z > 0.0 && seen.x.abs().max(seen.y.abs()) <= WIDEST_SLOPE * seen.z;
    if corners().all(|corner| is_before(whole.to_light(corner))) {
        return vec![whole];
    }
    let sides = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    sides.map(|forward| LightSpace::square(origin, forward, corners(), size)).to_vec()
}
