//! Shadow maps: what a light sees, as depths on a grid.
//!
//! Williams, "Casting curved shadows on curved surfaces" (SIGGRAPH 1978). A sun's map is orthographic, as tight as the scene allows; a lamp outside the
//! scene has one perspective map, a lamp inside six, on the sides of a cube. Depth is kept as a *nearness* that is affine over a texel's plane:
//! minus the distance for a sun, its inverse for a lamp. Triangles are rasterised at the texels' middles, bands of rows in parallel. A point is in
//! shadow if its texel is nearer by more than the bias: a constant share of a texel, and the depth that the surface's slope covers across the texel's
//! half diagonal (slope-scaled bias). No bound: borders are as jagged as texels, contacts leak by the bias, thin things fall between middles.

use std::time::Instant;

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;
use umbriel_geometry::LightSource;

use super::{Polygons, Rival, RivalAnswer, RivalPoint, RivalRefusal, clip::keep_positive};
use crate::triangle_rows::columns;

/// Rows that one thread takes at a time.
const BAND: usize = 32;

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
        let maps: Vec<Map> =
            windows(polygons, light, self.size).into_iter().map(|view| Map::new(view, polygons)).collect();
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
    fn is_lit(&self, maps: &[Map], light: &LightSource, point: &RivalPoint) -> bool {
        maps.iter().find_map(|map| map.is_lit(self, light, point)).unwrap_or(true)
    }
}

/// What a map looks at.
#[derive(Clone, Copy, Debug)]
struct Window {
    /// A lamp's place; for a sun, any point.
    origin: DVec3,
    /// World to light: right, up, forward.
    turn: DMat3,
    is_sun: bool,
    low: DVec2,
    texel: f64,
    size: usize,
    /// Nothing nearer than this is drawn, metres; a lamp's only.
    near: f64,
}

/// The windows of a light: one, or six round a lamp.
fn windows(polygons: &Polygons, light: &LightSource, size: usize) -> Vec<Window> {
    let bounds = polygons.bounds();
    let is_sun = light.is_sun();
    let origin = if is_sun { bounds.center() } else { light.xyz() };
    let to_middle = if is_sun { -light.xyz() } else { bounds.center() - origin };
    let near = (bounds.size().length() + to_middle.length()) / 4096.0;
    let corners = || polygons.mesh().positions().iter().copied();
    let turned = |forward: DVec3| {
        let (right, up) = forward.any_orthonormal_pair();
        DMat3::from_cols(right, up, forward).transpose()
    };
    let turn = turned(to_middle.normalize_or(DVec3::NEG_Y));
    let whole = Window { origin, turn, is_sun, low: DVec2::ZERO, texel: 1.0, size, near };
    let is_before = |seen: DVec3| seen.z > near && seen.x.abs().max(seen.y.abs()) <= WIDEST_SLOPE * seen.z;
    if is_sun || corners().all(|corner| is_before(whole.seen(corner))) {
        let places = corners().map(|corner| whole.place(whole.seen(corner)));
        let (low, high) = places.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        // A texel free on every side.
        let texel = (high - low).max_element().max(f64::MIN_POSITIVE) / size.saturating_sub(2).max(1) as f64;
        let low = 0.5 * (low + high) - DVec2::splat(0.5 * texel * size as f64);
        return vec![Window { low, texel, ..whole }];
    }
    let sides = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let side =
        |forward: DVec3| Window { turn: turned(forward), low: DVec2::NEG_ONE, texel: 2.0 / size as f64, ..whole };
    sides.map(side).to_vec()
}

impl Window {
    /// A point in light space.
    fn seen(&self, point: DVec3) -> DVec3 {
        self.turn * (point - self.origin)
    }

    /// Where a point in light space lies on the plane of the map.
    fn place(&self, seen: DVec3) -> DVec2 {
        if self.is_sun { seen.truncate() } else { seen.truncate() / seen.z }
    }

    /// Greater is nearer; affine over the map for the points of a plane.
    fn nearness(&self, depth: f64) -> f64 {
        if self.is_sun { -depth } else { 1.0 / depth }
    }
}

/// The nearnesses that a window sees.
struct Map {
    window: Window,
    nearness: Vec<f32>,
}

impl Map {
    fn new(window: Window, polygons: &Polygons) -> Self {
        let drawn: Vec<Drawn> = (0..polygons.len())
            .into_par_iter()
            .flat_map_iter(|triangle| drawn(&window, polygons.corners(triangle)))
            .collect();
        let size = window.size;
        let mut nearness = vec![f32::NEG_INFINITY; size * size];
        let bands = by_band(&drawn, size);
        nearness.par_chunks_mut(size * BAND).zip(bands).enumerate().for_each(|(band, (rows, triangles))| {
            triangles.into_iter().for_each(|triangle| drawn[triangle as usize].draw(rows, band * BAND, size));
        });
        Self { window, nearness }
    }

    /// Whether a point is lit; `None` for a point beyond the window.
    fn is_lit(&self, bias: &ShadowMap, light: &LightSource, point: &RivalPoint) -> Option<bool> {
        let window = &self.window;
        let seen = window.seen(point.position);
        if !window.is_sun && seen.z <= 0.0 {
            return None;
        }
        let at = (window.place(seen) - window.low) / window.texel;
        let [column, row] =
            [at.x, at.y].map(|x| if x >= 0.0 && x < window.size as f64 { x as usize } else { usize::MAX });
        if column == usize::MAX || row == usize::MAX {
            return None;
        }
        let texel = window.texel * if window.is_sun { 1.0 } else { seen.z };
        let to_light = (light.xyz() - light.w() * point.position).normalize_or_zero();
        // A slope steeper than a thousand counts as that: the bias stays finite.
        let cosine = (point.normal.normalize_or_zero().dot(to_light)).abs().max(1e-3);
        let tangent = (1.0 - cosine * cosine).max(0.0).sqrt() / cosine;
        let half_diagonal = 0.5 * std::f64::consts::SQRT_2;
        let depth = seen.z - texel * (bias.constant + bias.slope * half_diagonal * tangent);
        // A lamp that stands within the bias sees the point.
        if !window.is_sun && depth <= 0.0 {
            return Some(true);
        }
        let nearest = f64::from(self.nearness[row * window.size + column]);
        Some(nearest <= window.nearness(depth))
    }
}

/// The triangles that reach each band of rows.
fn by_band(drawn: &[Drawn], size: usize) -> Vec<Vec<u32>> {
    let mut bands = vec![Vec::new(); size.div_ceil(BAND)];
    for (number, Drawn { rows: [first, end], .. }) in drawn.iter().enumerate() {
        bands[..end.div_ceil(BAND)].iter_mut().skip(first / BAND).for_each(|band| band.push(number as u32));
    }
    bands
}

/// A triangle on the map: corners in texels, and its nearness as an affine function of them.
struct Drawn {
    corners: [DVec2; 3],
    /// At texel (0, 0), and its change to the next column and row.
    nearness: DVec3,
    rows: [usize; 2],
}

/// A triangle cut where a lamp has it too near, as triangles.
fn drawn(window: &Window, corners: [DVec3; 3]) -> impl Iterator<Item = Drawn> + use<> {
    let mut polygon: Vec<DVec3> = corners.iter().map(|&corner| window.seen(corner)).collect();
    if !window.is_sun {
        keep_positive(&mut polygon, |point| point.z - window.near);
    }
    let window = *window;
    (2..polygon.len()).filter_map(move |k| Drawn::new(&window, [polygon[0], polygon[k - 1], polygon[k]]))
}

impl Drawn {
    fn new(window: &Window, seen: [DVec3; 3]) -> Option<Self> {
        let corners = seen.map(|point| (window.place(point) - window.low) / window.texel);
        let nearness = seen.map(|point| window.nearness(point.z));
        let [u, v] = [corners[1] - corners[0], corners[2] - corners[0]];
        let area = u.perp_dot(v);
        if area == 0.0 || !area.is_finite() {
            return None;
        }
        let [p, q] = [nearness[1] - nearness[0], nearness[2] - nearness[0]];
        let slope = DVec2::new(p * v.y - q * u.y, q * u.x - p * v.x) / area;
        let row = |y: f64| y.clamp(0.0, window.size as f64) as usize;
        let low = corners.iter().map(|corner| corner.y).fold(f64::INFINITY, f64::min);
        let high = corners.iter().map(|corner| corner.y).fold(f64::NEG_INFINITY, f64::max);
        let at_origin = nearness[0] - slope.dot(corners[0]);
        Some(Self {
            corners,
            nearness: DVec3::new(at_origin, slope.x, slope.y),
            rows: [row(low - 0.5), row(high + 1.0)],
        })
    }

    /// Draws the rows of a band that begins with row `first`.
    fn draw(&self, band: &mut [f32], first: usize, size: usize) {
        for row in self.rows[0].max(first)..self.rows[1].min(first + band.len() / size) {
            let Some(columns) = columns(&self.corners, row, size) else { continue };
            let y = row as f64 + 0.5;
            let start = self.nearness.x + self.nearness.z * y + self.nearness.y * (columns.start as f64 + 0.5);
            let line = &mut band[(row - first) * size..][columns];
            for (k, nearness) in line.iter_mut().enumerate() {
                *nearness = nearness.max((start + self.nearness.y * k as f64) as f32);
            }
        }
    }
}
