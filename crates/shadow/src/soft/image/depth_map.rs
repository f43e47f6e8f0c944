//! The depth map of an area light: what its middle sees, as depths on a grid.
//!
//! Williams, "Casting curved shadows on curved surfaces" (SIGGRAPH 1978). A square window of N × N texels of [`LightSpace`]'s image. Flat faces are
//! rasterised at the texels' middles, their depth numbers affine over each; bands of rows in parallel, with the same bits for any number of threads.
//! Curved bodies are hit by a ray a texel in the rectangle of their boxes. f32: a picture, not a proof. O(texels covered).

use std::ops::Range;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use umbriel_geometry::{Aabb, Facets};
use umbriel_scene::{Scene, Shape};
use umbriel_visibility::{Ray, RayCaster};

use super::light_space::LightSpace;
use crate::triangle_rows::columns;

/// Rows that one thread takes at a time.
const BAND: usize = 32;

/// Numbers that are read beyond a row's end, at most: kernels take so many at a time.
pub(super) const LANES: usize = 16;

/// Depths from a light, metres along its look; infinite where it sees nothing.
#[derive(Clone, Debug)]
pub struct DepthMap {
    /// Where it lies.
    pub space: LightSpace,
    /// By rows, and [`LANES`] infinities.
    depths: Vec<f32>,
    nearest: f32,
    /// The smallest depth of each square of [`SQUARE`] texels an edge, by rows.
    squares: Vec<f32>,
}

/// Texels along the edge of a square whose smallest depth is known.
const SQUARE: usize = 16;

/// The curved bodies of a scene, ready to be drawn into maps.
#[derive(Debug)]
pub struct CurvedBodies {
    caster: RayCaster,
    /// Corners of their boxes, world coordinates.
    corners: Vec<[DVec3; 8]>,
}

impl CurvedBodies {
    /// Those of a scene.
    pub fn new(scene: &Scene) -> Self {
        let objects = scene.objects.iter().enumerate();
        let curved: Vec<usize> = objects
            .filter(|(_, object)| matches!(object.shape, Shape::Analytic(_)))
            .map(|(number, _)| number)
            .collect();
        let corners = curved.iter().map(|&number| corners_of(&scene.objects[number].bounds())).collect();
        Self { caster: RayCaster::of_objects(scene, &curved), corners }
    }

    /// The corners of their boxes, world coordinates.
    pub fn corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.corners.iter().flatten().copied()
    }

    /// The columns and rows in which a body may be seen; all where its box reaches the light's plane.
    fn rectangles<'a>(&'a self, space: &'a LightSpace) -> impl Iterator<Item = [Range<usize>; 2]> + 'a {
        let size = space.size();
        self.corners.iter().map(move |corners| {
            let seen = corners.map(|corner| space.to_light(corner));
            if seen.iter().any(|&corner| !space.is_before(corner)) {
                return [0..size, 0..size];
            }
            let places = seen.map(|corner| space.to_texels(corner));
            let low = places.iter().copied().fold(DVec2::INFINITY, DVec2::min);
            let high = places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
            let texel = |place: f64| place.clamp(0.0, size as f64) as usize;
            [texel(low.x)..texel(high.x + 1.0), texel(low.y)..texel(high.y + 1.0)]
        })
    }
}

fn corners_of(bounds: &Aabb) -> [DVec3; 8] {
    let place = |corner: usize, axis: usize| if corner >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
    std::array::from_fn(|corner| DVec3::new(place(corner, 0), place(corner, 1), place(corner, 2)))
}

impl DepthMap {
    /// What the light sees of flat faces and curved bodies.
    pub fn new<'a>(space: LightSpace, flat: impl IntoIterator<Item = &'a Facets>, curved: &CurvedBodies) -> Self {
        let triangles: Vec<Projected> = flat.into_iter().flat_map(|facets| project(&space, facets)).collect();
        let rectangles: Vec<[Range<usize>; 2]> = curved.rectangles(&space).collect();
        let size = space.size();
        let mut depths = vec![f32::INFINITY; size * size + LANES];
        depths[..size * size].par_chunks_mut(size * BAND).enumerate().for_each(|(band, rows)| {
            let first = band * BAND;
            triangles.iter().for_each(|triangle| triangle.draw(rows, first, size));
            for (row, line) in rows.chunks_mut(size).enumerate() {
                cast(&space, &curved.caster, &rectangles, first + row, line);
            }
        });
        let nearest = depths.iter().copied().fold(f32::INFINITY, f32::min);
        let squares = least_of_squares(&depths[..size * size], size);
        Self { space, depths, nearest, squares }
    }

    /// Texels along an edge.
    pub fn size(&self) -> usize {
        self.space.size()
    }

    /// The smallest depth; infinite for an empty map.
    pub fn nearest(&self) -> f32 {
        self.nearest
    }

    /// No texel of the window is nearer: O(texels / 256).
    pub fn nearest_in(&self, [columns, rows]: &[Range<usize>; 2]) -> f32 {
        let width = self.size().div_ceil(SQUARE);
        let squares = |texels: &Range<usize>| texels.start / SQUARE..texels.end.div_ceil(SQUARE);
        let lines = squares(rows).map(|row| &self.squares[row * width..][squares(columns)]);
        lines.flatten().copied().fold(f32::INFINITY, f32::min)
    }

    /// A row of depths.
    pub fn row(&self, row: usize) -> &[f32] {
        &self.depths[row * self.size()..(row + 1) * self.size()]
    }

    /// The depths of a row from a column on in groups of [`LANES`], `count` of them and what follows up to a whole group.
    #[inline(always)]
    pub(super) fn groups(&self, row: usize, column: usize, count: usize) -> &[[f32; LANES]] {
        let first = row * self.size() + column;
        self.depths[first..first + count.next_multiple_of(LANES)].as_chunks().0
    }

    /// The texels within `radius` of a place, cut to the map: columns and rows.
    pub fn window(&self, middle: DVec2, radius: f64) -> Option<[Range<usize>; 2]> {
        let size = self.size() as f64;
        let range = |middle: f64| {
            // The texel that holds the middle is always part of it.
            let low = (middle - radius).round().min(middle.floor()).clamp(0.0, size);
            let high = (middle + radius).round().max(middle.floor() + 1.0).clamp(0.0, size);
            (low < high).then_some(low as usize..high as usize)
        };
        Some([range(middle.x)?, range(middle.y)?])
    }
}

/// Draws what rays through the texels' middles meet in a row.
fn cast(space: &LightSpace, caster: &RayCaster, rectangles: &[[Range<usize>; 2]], row: usize, line: &mut [f32]) {
    let in_row = rectangles.iter().filter(|[_, rows]| rows.contains(&row)).map(|[columns, _]| columns);
    let Some(columns) = in_row.cloned().reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)) else { return };
    for column in columns {
        let (origin, direction) = space.ray(column, row);
        let Some(hit) = caster.nearest(&Ray::new(origin, direction)) else { continue };
        line[column] = line[column].min(hit.distance as f32);
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

/// A triangle on the map: corners in texels, and its depth number as an affine function of them.
struct Projected {
    corners: [DVec2; 3],
    /// The depth number at texel (0, 0), and its change to the next column and row.
    number: DVec3,
    rows: [usize; 2],
    is_parallel: bool,
}

/// The triangles of a body on the map, cut where they reach a lamp's plane.
fn project(space: &LightSpace, facets: &Facets) -> Vec<Projected> {
    let bounds = facets.bounds();
    // Nearer than this share of the scene a slope has no place on a map.
    let near = space.reach(bounds.center(), bounds.size()) / 4096.0;
    let faces = facets.iter().flat_map(|facet| {
        let numbers = facet.corners();
        let mut polygon: Vec<DVec3> =
            numbers.iter().map(|&number| space.to_light(facets.positions()[number as usize])).collect();
        if !space.is_parallel() {
            crate::soft::window::cut(&mut polygon, |point| point.z - near);
        }
        (2..polygon.len()).map(|k| [polygon[0], polygon[k - 1], polygon[k]]).collect::<Vec<_>>()
    });
    faces.filter_map(|corners| Projected::new(space, corners)).collect()
}

impl Projected {
    fn new(space: &LightSpace, seen: [DVec3; 3]) -> Option<Self> {
        let mut corners = seen.map(|point| space.to_texels(point));
        let mut numbers = seen.map(|point| space.depth_number(point.z));
        let area = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]);
        if area == 0.0 || !area.is_finite() {
            return None;
        }
        if area < 0.0 {
            corners.swap(1, 2);
            numbers.swap(1, 2);
        }
        let [u, v] = [corners[1] - corners[0], corners[2] - corners[0]];
        let [p, q] = [numbers[1] - numbers[0], numbers[2] - numbers[0]];
        let slope = DVec2::new(p * v.y - q * u.y, q * u.x - p * v.x) / area.abs();
        let at_origin = numbers[0] - slope.dot(corners[0]);
        let row = |y: f64| y.clamp(0.0, space.size() as f64) as usize;
        let low = corners.iter().map(|corner| corner.y).fold(f64::INFINITY, f64::min);
        let high = corners.iter().map(|corner| corner.y).fold(f64::NEG_INFINITY, f64::max);
        Some(Self {
            corners,
            number: DVec3::new(at_origin, slope.x, slope.y),
            rows: [row(low - 0.5), row(high + 1.0)],
            is_parallel: space.is_parallel(),
        })
    }

    /// Draws the rows of a band that begins with row `first`.
    fn draw(&self, band: &mut [f32], first: usize, size: usize) {
        for row in self.rows[0].max(first)..self.rows[1].min(first + band.len() / size) {
            let Some(columns) = columns(&self.corners, row, size) else { continue };
            let y = row as f64 + 0.5;
            let start = self.number.x + self.number.z * y + self.number.y * (columns.start as f64 + 0.5);
            let line = &mut band[(row - first) * size..][columns];
            for (k, depth) in line.iter_mut().enumerate() {
                let number = start + self.number.y * k as f64;
                *depth = depth.min(if self.is_parallel { number } else { 1.0 / number } as f32);
            }
        }
    }
}
