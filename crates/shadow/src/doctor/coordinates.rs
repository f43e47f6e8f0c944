//! Coordinates: how far positions were rounded before anything was computed, and vertices without use.
//!
//! Two roundings are known: that of the placed vertex (half an ulp of f64), and that of a file that stores single
//! precision (half an ulp of f32, seen from numbers that all fit 24 bits and use nearly all of them). What a decimal file
//! left out is unknown.

use glam::DVec3;
use umbriel_geometry::Mesh;

use super::{
    defect::{Defect, DefectKind, Note},
    surface::Surface,
};

/// Rounding that is told whatever the size of the object: a millimetre is what buildings are measured to.
const TOLD_ALWAYS: f64 = 1e-3;

/// Rounding that is told as a part of the object's size, and lost faces as a part of its surface.
const TOLD_SHARE: f64 = 1e-3;

/// Numbers with fewer digits than these were hardly rounded to single precision, which keeps 24.
const ROUNDED_DIGITS: u32 = 20;

/// All faces where rounding is large against a millimetre or the object; else those that are no higher than a step
/// between two numbers, whose shape is not to be trusted, if they are a noticeable part of the surface.
pub(super) fn defect(surface: &Surface, mesh: &Mesh) -> Option<Defect> {
    let rounding = rounding(surface, mesh);
    let is_large = rounding > TOLD_ALWAYS || rounding > TOLD_SHARE * surface.bounds.size().max_element();
    let is_lost = |face: usize| surface.has_area(face) && surface.height(face) <= 2.0 * rounding;
    let faces = surface.faces_that(|face| if is_large { surface.has_area(face) } else { is_lost(face) });
    let defect = surface.of_faces(DefectKind::CoarseCoordinates, &faces)?.with(Note::Rounding(rounding));
    let whole = surface.area_of(0..surface.facets.len());
    (defect.area > TOLD_SHARE * whole).then_some(defect)
}

/// How far a placed coordinate may be off, metres.
fn rounding(surface: &Surface, mesh: &Mesh) -> f64 {
    let placed = largest(surface.facets.positions()).max_element();
    let placing = 0.5 * (placed.next_up() - placed);
    if !is_single_precision(mesh) {
        return placing;
    }
    let stored = largest(mesh.positions()).to_array().map(|x| 0.5 * f64::from((x as f32).next_up() - x as f32));
    let matrix = surface.object.placement.map().matrix3;
    let moved = matrix.x_axis.abs() * stored[0] + matrix.y_axis.abs() * stored[1] + matrix.z_axis.abs() * stored[2];
    moved.max_element().max(placing)
}

/// The largest size along each axis.
fn largest(positions: &[DVec3]) -> DVec3 {
    positions.iter().fold(DVec3::ZERO, |largest, position| largest.max(position.abs()))
}

/// Whether the coordinates look as if they were rounded to single precision.
fn is_single_precision(mesh: &Mesh) -> bool {
    let mut most = 0;
    for coordinate in mesh.positions().iter().flat_map(|position| position.to_array()) {
        if f64::from(coordinate as f32) != coordinate {
            return false;
        }
        most = most.max(digits(coordinate));
    }
    most >= ROUNDED_DIGITS
}

/// How many binary digits a number has, from its first to its last one.
fn digits(number: f64) -> u32 {
    if number == 0.0 { 0 } else { 53_u32.saturating_sub(number.to_bits().trailing_zeros()).max(1) }
}

/// Vertices that no triangle names.
pub(super) fn unreferenced(surface: &Surface, mesh: &Mesh) -> Option<Defect> {
    let mut is_used = vec![false; mesh.positions().len()];
    mesh.triangles().iter().flatten().for_each(|&corner| is_used[corner as usize] = true);
    let count = is_used.iter().filter(|used| !**used).count();
    (count > 0).then(|| Defect::new(DefectKind::UnreferencedVertices, surface.place, count, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_of_numbers() {
        assert_eq!([0.0, 1.0, -0.5, 3.0, 1.25, 0.1].map(digits), [0, 1, 1, 2, 3, 52]);
        assert_eq!(digits(f64::from(0.1_f32)), 24);
    }

    #[test]
    fn single_precision_is_recognised() {
        let mesh = |x: f64| Mesh::new(vec![[x, 0.0, 2.0]], Vec::new()).expect("a mesh");
        assert!(is_single_precision(&mesh(f64::from(0.1_f32))));
        assert!(!is_single_precision(&mesh(0.1)), "it has more digits");
        assert!(!is_single_precision(&mesh(0.25)), "nothing was rounded");
    }
}
