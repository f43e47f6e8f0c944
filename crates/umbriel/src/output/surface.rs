//! Where the cells of an object lie in the world: points, polygons and areas, for files that show them.
//!
//! Points are rounded floats: what is drawn, not what is decided.

use glam::DVec3;
use umbriel_geometry::{Approx, Facet, Facets, PlacedAnalytic, Placement, analytic::PatchArea};
use umbriel_scene::Object;
use umbriel_shadow::Cell;

/// On a curved body no polygon is coarser than a patch halved this often, so that it looks round.
const ROUND_LEVEL: u8 = 4;

/// The placed surface of an object, as a map from (u, v) of its faces.
pub(crate) struct Surface<'a> {
    placement: &'a Placement,
    form: Form,
}

enum Form {
    Flat(Facets),
    Curved(Box<PlacedAnalytic>),
    /// A shape without a map from (u, v); nothing of it is drawn.
    Unknown,
}

impl<'a> Surface<'a> {
    /// Costs a sort of the vertices of a mesh: keep it for all cells.
    pub(crate) fn of(object: &'a Object) -> Self {
        let curved = || object.analytic().map(|body| Form::Curved(Box::new(body)));
        let form = object.facets().map(Form::Flat).or_else(curved).unwrap_or(Form::Unknown);
        Self { placement: &object.placement, form }
    }

    /// The world point (u, v) of a face.
    pub(crate) fn point(&self, face: u32, [u, v]: [f64; 2]) -> Option<DVec3> {
        match &self.form {
            Form::Flat(facets) => {
                let corners = facets.facet(face as usize).corners();
                let at = |corner: u32| facets.positions()[corner as usize];
                let (first, second, last) = (at(corners[0]), at(corners[1]), at(corners[corners.len() - 1]));
                Some(first + u * (second - first) + v * (last - first))
            }
            Form::Curved(body) => {
                let chart = body.charts().get(face as usize)?;
                Some(self.placement.map().transform_point3(chart.point(u, v)))
            }
            Form::Unknown => None,
        }
    }

    /// Whether the face is a triangle, whose cells stop at one of its edges.
    fn is_triangle(&self, face: u32) -> bool {
        matches!(&self.form, Form::Flat(facets) if matches!(facets.facet(face as usize), Facet::Triangle(_)))
    }

    /// The parts of a cell that are drawn as one polygon each: the cell itself, or on a curved body finer ones. None
    /// beyond the edge of a triangle.
    pub(crate) fn parts(&self, cell: &Cell) -> Vec<Cell> {
        match &self.form {
            Form::Unknown => Vec::new(),
            Form::Flat(_) if self.is_triangle(cell.face) && is_beyond(cell) => Vec::new(),
            Form::Flat(_) => vec![*cell],
            Form::Curved(_) => split(cell, ROUND_LEVEL),
        }
    }

    /// The corners of a part's convex polygon in (u, v), counter-clockwise seen from the face's front.
    pub(crate) fn polygon(&self, part: &Cell) -> Vec<[f64; 2]> {
        let mut polygon = corners(part, self.is_triangle(part.face) && is_cut(part));
        if self.placement.is_mirrored() {
            polygon.reverse();
        }
        polygon
    }

    /// A point well inside a cell, in (u, v): its middle, or where a triangle's edge cuts it that of the inner half's square.
    pub(crate) fn middle(&self, cell: &Cell) -> [f64; 2] {
        let is_half = self.is_triangle(cell.face) && is_cut(cell);
        cell.point(if is_half { [0.25, 0.25] } else { [0.5, 0.5] })
    }

    /// The area of a cell, square metres, with its bound.
    pub(crate) fn area(&self, cell: &Cell) -> Approx {
        let face = cell.face as usize;
        match &self.form {
            Form::Unknown => Approx::exact(0.0),
            Form::Curved(body) => {
                let edge = 0.5f64.powi(i32::from(cell.level));
                PatchArea::new(&body.charts()[face], self.placement).of_cell(cell.point([0.0, 0.0]), edge)
            }
            Form::Flat(facets) => {
                let is_half = self.is_triangle(cell.face) && is_cut(cell);
                // A triangle is half of its parameter square. All factors are powers of two: nothing is rounded.
                let square = if self.is_triangle(cell.face) { 2.0 } else { 1.0 };
                let share = square * if is_half { 0.5 } else { 1.0 } * 0.25f64.powi(i32::from(cell.level));
                let area = facets.area(face);
                Approx { value: area.value * share, error: area.error * share }
            }
        }
    }
}

/// Whether the cell lies beyond the edge of a triangle that cuts others in half.
fn is_beyond(cell: &Cell) -> bool {
    u64::from(cell.i) + u64::from(cell.j) >= 1 << cell.level
}

/// Whether the edge of a triangle cuts the cell in half.
fn is_cut(cell: &Cell) -> bool {
    u64::from(cell.i) + u64::from(cell.j) + 1 == 1 << cell.level
}

/// The corners of a cell in its face's parameters, counter-clockwise; of its lower half only if `half`.
fn corners(cell: &Cell, half: bool) -> Vec<[f64; 2]> {
    let steps: &[[f64; 2]] =
        if half { &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] } else { &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] };
    steps.iter().map(|&step| cell.point(step)).collect()
}

/// The cell, or its descendants at `level` when it is coarser.
fn split(cell: &Cell, level: u8) -> Vec<Cell> {
    let steps = level.saturating_sub(cell.level);
    let part = |i: u32, j: u32| Cell {
        level: cell.level + steps,
        i: (cell.i << steps) + i,
        j: (cell.j << steps) + j,
        ..*cell
    };
    (0..1u32 << steps).flat_map(|j| (0..1u32 << steps).map(move |i| part(i, j))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbriel_geometry::{Analytic, Cuboid, Mesh};
    use umbriel_scene::{Shape, Sides};
    use umbriel_shadow::Verdict;

    fn object(shape: Shape, scale: DVec3) -> Object {
        let placement = Placement::new(glam::DAffine3::from_scale(scale)).expect("regular");
        Object::new("body".into(), shape, placement, Sides::Auto).expect("a body")
    }

    fn cell(face: u32, level: u8, i: u32, j: u32) -> Cell {
        Cell { face, corner: 0, level, i, j, verdict: Verdict::Lit }
    }

    /// The areas of the quarters of a face add up to the whole, and to that of their polygons.
    #[test]
    fn areas_of_flat_cells_are_exact_parts() {
        let triangle = Mesh::new(vec![[0.0; 3], [4.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]]).expect("a mesh");
        let cuboid = object(Shape::Cuboid(Cuboid { size: [1.0, 2.0, 3.0] }), DVec3::ONE);
        let triangle = object(Shape::Mesh(triangle.into()), DVec3::ONE);
        for (object, whole, cells) in [(&triangle, 4.0, 3), (&cuboid, 6.0, 4)] {
            let surface = Surface::of(object);
            let quarters = [cell(0, 1, 0, 0), cell(0, 1, 1, 0), cell(0, 1, 0, 1), cell(0, 1, 1, 1)];
            let sum: f64 = quarters[..cells].iter().map(|quarter| surface.area(quarter).value).sum();
            assert_eq!((sum, surface.area(&cell(0, 0, 0, 0)).value), (whole, whole));
            let parts = quarters.iter().flat_map(|quarter| surface.parts(quarter));
            let drawn: f64 = parts.map(|part| drawn_area(&surface, &surface.polygon(&part))).sum();
            assert_eq!(drawn, whole);
        }
    }

    fn drawn_area(surface: &Surface, polygon: &[[f64; 2]]) -> f64 {
        let points: Vec<DVec3> = polygon.iter().map(|&corner| surface.point(0, corner).expect("a point")).collect();
        let parts = points.windows(2).map(|pair| (pair[0] - points[0]).cross(pair[1] - points[0]));
        0.5 * parts.sum::<DVec3>().length()
    }

    #[test]
    fn areas_of_curved_cells_add_up_to_the_body() {
        let sphere = || Shape::from(Analytic::Sphere { radius: 1.0 });
        let pi = std::f64::consts::PI;
        let e = 3f64.sqrt() / 2.0;
        let spheroid = 2.0 * pi * (1.0 + 2.0 / e * e.asin());
        for (scale, truth) in [(DVec3::splat(2.0), 16.0 * pi), (DVec3::new(1.0, 1.0, -2.0), spheroid)] {
            let object = object(sphere(), scale);
            let surface = Surface::of(&object);
            let faces = (0..6).flat_map(|face| split(&cell(face, 0, 0, 0), 2));
            let areas: Vec<Approx> = faces.map(|cell| surface.area(&cell)).collect();
            let sum: f64 = areas.iter().map(|area| area.value).sum();
            let error: f64 = areas.iter().map(|area| area.error).sum();
            assert!((sum - truth).abs() < error && error < 2e-3 * truth, "{sum} is not {truth} ± {error}");
            assert!((sum - truth).abs() < 1e-5 * truth, "{sum} is not {truth}");
        }
    }

    #[test]
    fn polygons_look_outward_under_mirrors_too() {
        for scale in [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0)] {
            let object = object(Shape::from(Analytic::Sphere { radius: 2.0 }), scale);
            let surface = Surface::of(&object);
            let volume: f64 = (0..6)
                .flat_map(|face| surface.parts(&cell(face, 0, 0, 0)))
                .map(|part| {
                    let polygon = surface.polygon(&part);
                    let at = |k: usize| surface.point(part.face, polygon[k]).expect("a point");
                    at(0).dot(at(1).cross(at(2)) + at(2).cross(at(3))) / 6.0
                })
                .sum();
            let exact = 4.0 / 3.0 * std::f64::consts::PI * 8.0;
            assert!(volume > 0.98 * exact && volume < exact, "{volume} is not {exact}");
        }
    }
}
