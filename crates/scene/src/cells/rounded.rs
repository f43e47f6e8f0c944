//! Cells and portals whose corners are rounded.
//!
//! A corner stands for the box round it that reaches its slack to all sides. What cannot be told of all points of the boxes is not refused
//! (portals off their walls, bends inward), and counts as met (objects and eyes at the boundary of a cell). Without slack all is decided exactly.

use glam::DVec3;
use umbriel_geometry::{
    Brep, ConvexMeshDefect, Mesh, Point, Sign,
    predicates::{self, Target},
};

/// A point with the box that it stands for.
pub(super) fn boxed(position: DVec3, slack: f64) -> Point<'static> {
    Point::within(position, DVec3::splat(slack))
}

/// What a turn about the origin may round a coordinate by: an ulp of the greatest one of some points.
pub(super) fn ulp(points: impl Iterator<Item = DVec3>) -> f64 {
    let greatest = points.fold(0.0_f64, |greatest, point| greatest.max(point.abs().max_element()));
    greatest.next_up() - greatest
}

/// The side of the plane of three boxes on which a fourth surely lies; `None` where all of them may have points in one plane.
pub(super) fn apart(a: &Point, b: &Point, c: &Point, x: &Point) -> Option<Sign> {
    let is_exact = a.slack + b.slack + c.slack + x.slack == DVec3::ZERO;
    let sign = if is_exact {
        Some(predicates::side(a, b, c, x))
    } else {
        predicates::side_filter(a, b, c, Target::Point(x)).sign()
    };
    sign.filter(|&sign| sign != Sign::Zero)
}

/// The convex body of a closed mesh (world coordinates, metres) whose vertices are rounded by up to `slack` a coordinate. Flat faces
/// of several triangles that rounding bends inward are taken: the body is the hull of the vertices then, which holds that of the mesh.
///
/// # Errors
/// As [`Brep::of_mesh`], where rounding does not explain it.
pub fn convex_body(mesh: &Mesh, slack: f64) -> Result<Brep, ConvexMeshDefect> {
    Brep::of_mesh(mesh).or_else(|defect| {
        let is_bend = matches!(defect, ConvexMeshDefect::InwardBend { .. });
        if !is_bend || slack <= 0.0 || !is_nearly_convex(mesh, slack) {
            return Err(defect);
        }
        Brep::hull(mesh.positions().iter().copied()).map_err(|_| defect)
    })
}

/// Whether no vertex is surely beyond a triangle of its mesh. O(triangles · vertices).
fn is_nearly_convex(mesh: &Mesh, slack: f64) -> bool {
    let vertices: Vec<Point> = mesh.positions().iter().map(|&position| boxed(position, slack)).collect();
    mesh.triangles().iter().all(|triangle| {
        let [a, b, c] = triangle.map(|corner| &vertices[corner as usize]);
        vertices.iter().all(|vertex| apart(a, b, c, vertex) != Some(Sign::Positive))
    })
}
