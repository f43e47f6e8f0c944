//! Curved bodies in a depth map: a ray a texel in the rectangle of their boxes.

use std::ops::Range;

use glam::{DVec2, DVec3};
use umbriel_bvh::Ray;
use umbriel_scene::{Scene, Shape};

use super::LightSpace;
use crate::{RayCaster, view::corners};

/// The curved bodies of a scene, ready to be drawn into maps.
#[derive(Debug)]
pub struct CurvedBodies {
    caster: RayCaster,
    /// Corners of their boxes, world coordinates.
    corners: Vec<[DVec3; 8]>,
}

/// None.
impl Default for CurvedBodies {
    fn default() -> Self {
        Self::new(&Scene::default())
    }
}

impl CurvedBodies {
    /// Those of a scene.
    pub fn new(scene: &Scene) -> Self {
        let objects = scene.objects.iter().enumerate();
        let curved: Vec<usize> = objects
            .filter(|(_, object)| matches!(object.shape, Shape::Analytic(_)))
            .map(|(number, _)| number)
            .collect();
        let corners = curved.iter().map(|&number| corners(&scene.objects[number].bounds())).collect();
        Self { caster: RayCaster::of_objects(scene, &curved), corners }
    }

    /// The corners of their boxes, world coordinates.
    pub fn corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.corners.iter().flatten().copied()
    }

    /// The columns and rows in which each body may be seen; all where its box reaches a lamp's plane.
    pub(super) fn rectangles(&self, space: &LightSpace) -> Vec<[Range<usize>; 2]> {
        let size = space.size();
        let rectangle = |corners: &[DVec3; 8]| {
            let seen = corners.map(|corner| space.to_light(corner));
            if seen.iter().any(|&corner| !space.is_before(corner)) {
                return [0..size, 0..size];
            }
            let places = seen.map(|corner| space.to_texels(corner));
            let low = places.iter().copied().fold(DVec2::INFINITY, DVec2::min);
            let high = places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
            let texel = |place: f64| place.clamp(0.0, size as f64) as usize;
            [texel(low.x)..texel(high.x + 1.0), texel(low.y)..texel(high.y + 1.0)]
        };
        self.corners.iter().map(rectangle).collect()
    }

    /// Draws what rays through the texels' middles meet in a row.
    pub(super) fn draw_row(
        &self,
        space: &LightSpace,
        rectangles: &[[Range<usize>; 2]],
        row: usize,
        depths: &mut [f32],
    ) {
        let in_row = rectangles.iter().filter(|[_, rows]| rows.contains(&row)).map(|[columns, _]| columns);
        let Some(columns) = in_row.cloned().reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)) else { return };
        for column in columns {
            let (origin, direction) = space.ray(column, row);
            let Some(hit) = self.caster.nearest(&Ray::new(origin, direction)) else { continue };
            depths[column] = depths[column].min(hit.distance as f32);
        }
    }
}
