//! The depth map of an area light: what its middle sees, as depths on a grid.
//!
//! Williams, "Casting curved shadows on curved surfaces" (SIGGRAPH 1978). Light space has its origin in the light's middle and z along the light's
//! normal; the image is the plane of slopes x/z, y/z, a square window of N × N texels. Triangles are rasterised at the texels' middles, 1/z affine
//! over each; bands of rows in parallel, with the same bits for any number of threads. f32: a picture, not a proof. O(texels covered).

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;
use umbriel_geometry::Facets;

use crate::triangle_rows::columns;

/// Rows that one thread takes at a time.
const BAND: usize = 32;

/// Light space and the window of the map.
#[derive(Clone, Copy, Debug)]
pub struct LightSpace {
    origin: DVec3,
    /// World to light: rows right, up, forward.
    turn: DMat3,
    /// Slopes of the window's low corner.
    low: DVec2,
    /// Slope from one texel to the next.
    texel: f64,
    /// Texels along an edge.
    size: usize,
}

impl LightSpace {
    /// The space of a light at `origin` that looks along `forward`, with a window round the slopes of `points` (world coordinates, metres).
    /// Points that are not before the light do not count.
    pub fn round(origin: DVec3, forward: DVec3, points: impl IntoIterator<Item = DVec3>, size: usize) -> Self {
        let forward = forward.normalize_or(DVec3::NEG_Y);
        let (right, up) = forward.any_orthonormal_pair();
        let turn = DMat3::from_cols(right, up, forward).transpose();
        let seen = points.into_iter().map(|point| turn * (point - origin)).filter(|seen| seen.z > 0.0);
        let slopes = seen.map(|seen| seen.truncate() / seen.z);
        let (low, high) =
            slopes.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), s| (low.min(s), high.max(s)));
        let edge = (high - low).max_element();
        if !(edge > 0.0 && edge.is_finite()) {
            return Self { origin, turn, low: DVec2::NEG_ONE, texel: 2.0 / size as f64, size };
        }
        // A texel free on every side.
        let texel = edge / (size.max(4) - 2) as f64;
        let middle = 0.5 * (low + high);
        Self { origin, turn, low: middle - DVec2::splat(0.5 * texel * size as f64), texel, size }
    }

    /// A point in light space: x, y, and z along the light's normal, metres.
    pub fn to_light(&self, point: DVec3) -> DVec3 {
        self.turn * (point - self.origin)
    }

    /// Where a point in light space lies on the map, in texels.
    pub fn to_texels(&self, seen: DVec3) -> DVec2 {
        (seen.truncate() / seen.z - self.low) / self.texel
    }

    /// The slope from one texel to the next.
    pub fn texel(&self) -> f64 {
        self.texel
    }
}

/// Depths from a light, metres along its normal; infinite where it sees nothing.
#[derive(Clone, Debug)]
pub struct DepthMap {
    /// Where it lies.
    pub space: LightSpace,
    depths: Vec<f32>,
    nearest: f32,
    /// The smallest depth of each square of [`SQUARE`] texels an edge, by rows.
    squares: Vec<f32>,
}

/// Texels along the edge of a square whose smallest depth is known.
const SQUARE: usize = 16;

impl DepthMap {
    /// What the light sees of flat faces.
    pub fn new<'a>(space: LightSpace, occluders: impl IntoIterator<Item = &'a Facets>) -> Self {
        let triangles: Vec<Projected> = occluders.into_iter().flat_map(|facets| project(&space, facets)).collect();
        let size = space.size;
        let mut depths = vec![f32::INFINITY; size * size];
        depths.par_chunks_mut(size * BAND).enumerate().for_each(|(band, rows)| {
            let first = band * BAND;
            triangles.iter().for_each(|triangle| triangle.draw(rows, first, size));
        });
        let nearest = depths.iter().copied().fold(f32::INFINITY, f32::min);
        let squares = least_of_squares(&depths, size);
        Self { space, depths, nearest, squares }
    }

    /// Texels along an edge.
    pub fn size(&self) -> usize {
        self.space.size
    }

    /// The smallest depth; infinite for an empty map.
    pub fn nearest(&self) -> f32 {
        self.nearest
    }

    /// No texel of the window is nearer: O(texels / 256).
    pub fn nearest_in(&self, [columns, rows]: &[std::ops::Range<usize>; 2]) -> f32 {
        let width = self.space.size.div_ceil(SQUARE);
        let squares = |texels: &std::ops::Range<usize>| texels.start / SQUARE..texels.end.div_ceil(SQUARE);
        let lines = squares(rows).map(|row| &self.squares[row * width..][squares(columns)]);
        lines.flatten().copied().fold(f32::INFINITY, f32::min)
    }

    /// A row of depths.
    pub fn row(&self, row: usize) -> &[f32] {
        &self.depths[row * self.space.size..(row + 1) * self.space.size]
    }

    /// The texels within `radius` of a place, cut to the map: columns and rows.
    pub fn window(&self, middle: DVec2, radius: f64) -> Option<[std::ops::Range<usize>; 2]> {
        let size = self.space.size as f64;
        let range = |middle: f64| {
            // The texel that holds the middle is always part of it.
            let low = (middle - radius).round().min(middle.floor()).clamp(0.0, size);
            let high = (middle + radius).round().max(middle.floor() + 1.0).clamp(0.0, size);
            (low < high).then_some(low as usize..high as usize)
        };
        Some([range(middle.x)?, range(middle.y)?])
    }
}

fn least_of_squares(depths: &[f32], size: usize) -> Vec<f32> {
    let least = |texels: &[f32]| texels.iter().copied().fold(f32::INFINITY, f32::min);
    let bands = depths.par_chunks(size * SQUARE).map(|band| {
        let mut squares = vec![f32::INFINITY; size.div_ceil(SQUARE)];
        for row in band.chunks(size) {
            squares.iter_mut().zip(row.chunks(SQUARE)).for_each(|(square, texels)| *square = square.min(least(texels)));
        }
        squares
    });
    bands.collect::<Vec<_>>().concat()
}

/// A triangle on the map: corners in texels, and its 1/z as an affine function of them.
struct Projected {
    corners: [DVec2; 3],
    /// 1/z at texel (0, 0), and its change to the next column and row.
    inverse: DVec3,
    rows: [usize; 2],
}

/// The triangles of a body on the map, cut where they reach the light's plane.
fn project(space: &LightSpace, facets: &Facets) -> Vec<Projected> {
    let bounds = facets.bounds();
    let reach = (bounds.center() - space.origin).length() + bounds.size().length();
    // Nearer than this share of the scene a slope has no place on a map.
    let near = reach / 4096.0;
    let faces = facets.iter().flat_map(|facet| {
        let numbers = facet.corners();
        let mut polygon: Vec<DVec3> =
            numbers.iter().map(|&number| space.to_light(facets.positions()[number as usize])).collect();
        crate::soft::window::cut(&mut polygon, |point| point.z - near);
        (2..polygon.len()).map(|k| [polygon[0], polygon[k - 1], polygon[k]]).collect::<Vec<_>>()
    });
    faces.filter_map(|corners| Projected::new(space, corners)).collect()
}

impl Projected {
    fn new(space: &LightSpace, seen: [DVec3; 3]) -> Option<Self> {
        let mut corners = seen.map(|point| space.to_texels(point));
        let mut inverse = seen.map(|point| 1.0 / point.z);
        let area = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]);
        if area == 0.0 || !area.is_finite() {
            return None;
        }
        if area < 0.0 {
            corners.swap(1, 2);
            inverse.swap(1, 2);
        }
        let [u, v] = [corners[1] - corners[0], corners[2] - corners[0]];
        let [p, q] = [inverse[1] - inverse[0], inverse[2] - inverse[0]];
        let slope = DVec2::new(p * v.y - q * u.y, q * u.x - p * v.x) / area.abs();
        let at_origin = inverse[0] - slope.dot(corners[0]);
        let row = |y: f64| y.clamp(0.0, space.size as f64) as usize;
        let low = corners.iter().map(|corner| corner.y).fold(f64::INFINITY, f64::min);
        let high = corners.iter().map(|corner| corner.y).fold(f64::NEG_INFINITY, f64::max);
        Some(Self {
            corners,
            inverse: DVec3::new(at_origin, slope.x, slope.y),
            rows: [row(low - 0.5), row(high + 1.0)],
        })
    }

    /// Draws the rows of a band that begins with row `first`.
    fn draw(&self, band: &mut [f32], first: usize, size: usize) {
        for row in self.rows[0].max(first)..self.rows[1].min(first + band.len() / size) {
            let Some(columns) = columns(&self.corners, row, size) else { continue };
            let y = row as f64 + 0.5;
            let start = self.inverse.x + self.inverse.z * y + self.inverse.y * (columns.start as f64 + 0.5);
            let line = &mut band[(row - first) * size..][columns];
            for (k, depth) in line.iter_mut().enumerate() {
                *depth = depth.min((1.0 / (start + self.inverse.y * k as f64)) as f32);
            }
        }
    }
}
