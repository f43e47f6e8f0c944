//! The stored cells of one object in its linear octree: from a point of space to the cells there.
//!
//! Cells lie on faces, so they are found by their faces' parameters first. This is the other way in: the object's bounding
//! cube, divided where cells are (Xie et al. 2001, "Fine step"), sorted by Morton codes, without pointers.

use glam::DVec3;
use umbriel_geometry::{Aabb, Facets, PlacedAnalytic, Point};
use umbriel_octree::{BuildDefect, Cube, Limits, LinearOctree};
use umbriel_scene::Object;

use crate::report::Cell;

/// The corners of a cell are computed with a dozen roundings of the coordinates' size.
const CORNER_PADDING: f64 = 16.0 * f64::EPSILON;

/// Cells in a linear octree.
#[derive(Clone, Debug)]
pub struct CellOctree {
    tree: Option<LinearOctree>,
}

impl CellOctree {
    /// Sorts an object's cells into its bounding cube, `max_level` levels deep at most (21 or less), leaves of up to
    /// eight cells. O(cells in leaves × levels).
    ///
    /// # Errors
    /// [`BuildDefect`] for too deep a level or too many cells.
    ///
    /// # Panics
    /// If a cell names a face that the object does not have.
    pub fn new(object: &Object, cells: &[Cell], max_level: u8) -> Result<Self, BuildDefect> {
        let (facets, body) = (object.facets(), object.analytic());
        let boxes: Vec<Aabb> =
            cells.iter().map(|cell| bounds(object, (facets.as_ref(), body.as_ref()), cell)).collect();
        let limits = Limits { max_level, leaf_items: 8 };
        let cube = Cube::around(&object.bounds());
        let tree = cube.map(|cube| LinearOctree::build(cube, &boxes, limits)).transpose()?;
        Ok(Self { tree })
    }

    /// The octree; its items are indices of the cells. `None` for an object without extent.
    pub fn tree(&self) -> Option<&LinearOctree> {
        self.tree.as_ref()
    }

    /// Indices of the cells in the leaf that holds a point, world coordinates: all cells at that point are among them.
    pub fn cells_near(&self, point: DVec3) -> &[u32] {
        self.tree.as_ref().and_then(|tree| tree.leaf_at(point)).map_or(&[], |leaf| leaf.items)
    }
}

/// A box round a cell, rounded outward.
fn bounds(object: &Object, (facets, body): (Option<&Facets>, Option<&PlacedAnalytic>), cell: &Cell) -> Aabb {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|corner| cell.point(corner));
    let box_of = |points: [DVec3; 4]| {
        let tight = Aabb::of(points);
        tight.widened((tight.min.abs().max(tight.max.abs()) + tight.size()) * CORNER_PADDING)
    };
    match (facets, body) {
        (Some(facets), _) => {
            let numbers = facets.facet(cell.face as usize).corners();
            let at = |k: usize| facets.positions()[numbers[k] as usize];
            let (a, b, d) = (at(0), at(1), at(numbers.len() - 1));
            let face = facets.facet_bounds(cell.face as usize);
            let square = box_of(corners.map(|[u, v]| a + (b - a) * u + (d - a) * v));
            Aabb { min: square.min.max(face.min), max: square.max.min(face.max) }
        }
        (None, Some(body)) => {
            let [u, v] = cell.point([0.0, 0.0]);
            let hull = body.charts()[cell.face as usize].hull([u, v], 0.5f64.powi(i32::from(cell.level)));
            hull.placed(body.placement()).iter().map(Point::bounds).fold(Aabb::EMPTY, Aabb::union)
        }
        (None, None) => object.bounds(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Detail, Request, Silent, bake};
    use umbriel_geometry::{Analytic, Cuboid, LightSource, Placement};
    use umbriel_scene::{Light, Scene, Shape, Sides};

    #[test]
    fn every_cell_is_found_at_its_own_points() {
        let turned = glam::DAffine3::from_quat(glam::DQuat::from_xyzw(0.1, 0.7, 0.2, 0.3).normalize());
        let placement = Placement::new(turned).expect("regular");
        for shape in
            [Shape::Cuboid(Cuboid { size: [1.0, 2.0, 3.0] }), Shape::from(Analytic::Cone { radius: 2.0, height: 1.0 })]
        {
            let object = Object::new("body".into(), shape, placement, Sides::Auto).expect("a body");
            let source = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
            let lights = vec![Light::new("sun", source)];
            let scene = Scene { objects: [object].into(), lights, ..Scene::default() };
            let detail = Detail::Depth { interior: 4, boundary: 4 };
            let request = Request { keep_cells: true, ..Request::everything(&scene, detail) };
            let report = bake(&scene, &request, &Silent).expect("not cancelled");
            let cells = &report.lights[0].objects[0].cells;
            let object = &scene.objects[0];
            let octree = CellOctree::new(object, cells, 6).expect("few cells");
            let (facets, body) = (object.facets(), object.analytic());
            for (index, cell) in cells.iter().enumerate() {
                let [u, v] = cell.point([0.5, 0.5]);
                let middle = match (&facets, &body) {
                    (Some(facets), _) => {
                        let corners = facets.facet(cell.face as usize).corners();
                        let at = |k: usize| facets.positions()[corners[k] as usize];
                        at(0) + (at(1) - at(0)) * u + (at(3) - at(0)) * v
                    }
                    (None, Some(body)) => {
                        placement.map().transform_point3(body.charts()[cell.face as usize].point(u, v))
                    }
                    (None, None) => continue,
                };
                assert!(octree.cells_near(middle).contains(&(index as u32)), "{cell:?}");
            }
        }
    }
}
