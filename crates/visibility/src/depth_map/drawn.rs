//! Triangles drawn into a band of a depth map's rows.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{BAND, LightSpace, columns::columns};
use crate::polygon;

/// A triangle on the map: corners in texels, and its nearness as an affine function of them.
pub(super) struct Drawn {
    corners: [DVec2; 3],
    /// At texel (0, 0), and its change to the next column and row.
    nearness: DVec3,
    rows: [usize; 2],
}

/// Triangles on the map, cut where a lamp has them too near. O(triangles); threads take triangles.
pub(super) fn project(space: &LightSpace, triangles: impl ParallelIterator<Item = [DVec3; 3]>) -> Vec<Drawn> {
    let parts = triangles.flat_map_iter(|corners| {
        let mut polygon = corners.map(|corner| space.to_light(corner)).to_vec();
        if polygon.iter().any(|&point| !space.is_drawn(point)) {
            let values: Vec<f64> = polygon.iter().map(|point| point.z - space.near()).collect();
            polygon = polygon::cut(&polygon, &values);
        }
        (2..polygon.len()).filter_map(move |k| Drawn::new(space, [polygon[0], polygon[k - 1], polygon[k]]))
    });
    parts.collect()
}

/// The triangles that reach each band of rows.
pub(super) fn by_band(drawn: &[Drawn], size: usize) -> Vec<Vec<u32>> {
    let mut bands = vec![Vec::new(); size.div_ceil(BAND)];
    for (number, Drawn { rows: [first, end], .. }) in drawn.iter().enumerate() {
        bands[..end.div_ceil(BAND)].iter_mut().skip(first / BAND).for_each(|band| band.push(number as u32));
    }
    bands
}

impl Drawn {
    fn new(space: &LightSpace, seen: [DVec3; 3]) -> Option<Self> {
        let corners = seen.map(|point| space.to_texels(point));
        let nearness = seen.map(|point| space.nearness(point.z));
        let [u, v] = [corners[1] - corners[0], corners[2] - corners[0]];
        let area = u.perp_dot(v);
        if area == 0.0 || !area.is_finite() {
            return None;
        }
        let [p, q] = [nearness[1] - nearness[0], nearness[2] - nearness[0]];
        let slope = DVec2::new(p * v.y - q * u.y, q * u.x - p * v.x) / area;
        let at_origin = nearness[0] - slope.dot(corners[0]);
        let row = |y: f64| y.clamp(0.0, space.size() as f64) as usize;
        let low = corners.iter().map(|corner| corner.y).fold(f64::INFINITY, f64::min);
        let high = corners.iter().map(|corner| corner.y).fold(f64::NEG_INFINITY, f64::max);
        Some(Self {
            corners,
            nearness: DVec3::new(at_origin, slope.x, slope.y),
            rows: [row(low - 0.5), row(high + 1.0)],
        })
    }

    /// Draws the rows of a band that begins with row `first`: the greatest nearness stays.
    pub(super) fn draw(&self, band: &mut [f32], first: usize, size: usize) {
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
