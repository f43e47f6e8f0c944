//! Surface that the asked detail is too coarse for: faces and components that fit into one cell.

use umbriel_geometry::{Aabb, Facet};

use crate::{
    levels::{self, FaceSize, MAX_DEPTH},
    request::Detail,
};

use super::{
    defect::{Defect, DefectKind, Note},
    surface::Surface,
};

/// So much of a surface may stay undivided without a word.
const LEFT_ALONE: f64 = 0.01;

/// Faces that are not divided at the asked detail, and the depth that divides nearly all surface.
pub(super) fn small_faces(surface: &Surface, detail: Detail) -> Option<Defect> {
    let whole = surface.area_of(0..surface.facets.len());
    let faces = surface.faces_that(|face| surface.has_area(face) && !is_divided(surface, face, detail));
    let defect = surface.of_faces(DefectKind::SmallFaces, &faces)?;
    if defect.area <= LEFT_ALONE * whole {
        return None;
    }
    // What each depth is the first to divide.
    let mut divided = [0.0; MAX_DEPTH as usize + 1];
    for &face in &faces {
        let at = |depth: u8| is_divided(surface, face, Detail::Depth { interior: 0, boundary: depth });
        divided[usize::from((0..MAX_DEPTH).find(|&depth| at(depth)).unwrap_or(MAX_DEPTH))] += surface.areas[face];
    }
    let mut left = defect.area;
    let depth = (0..MAX_DEPTH).find(|&depth| {
        left -= divided[usize::from(depth)];
        left <= LEFT_ALONE * whole
    });
    Some(defect.with(Note::Depth(depth.unwrap_or(MAX_DEPTH))))
}

fn is_divided(surface: &Surface, face: usize, detail: Detail) -> bool {
    let facets = surface.facets;
    let corners: Vec<_> = facets.facet(face).corners().iter().map(|&corner| facets.point(corner)).collect();
    let size = FaceSize::of_flat(&corners, matches!(facets.facet(face), Facet::Triangle(_)));
    levels::of_face(detail, false, &surface.bounds, &size).finest > 0
}

/// Components that are no larger than a cell.
pub(super) fn small_components(surface: &Surface, detail: Detail) -> Option<Defect> {
    let count = surface.facets.topology().components.len();
    let cube = surface.bounds.size().max_element();
    let edge = match detail {
        Detail::Depth { boundary, .. } => cube / f64::from(1u32 << boundary.min(MAX_DEPTH)),
        Detail::Cell { edge } => edge,
        _ => return None,
    };
    let mut boxes = vec![Aabb::EMPTY; count];
    for face in 0..surface.facets.len() {
        let bounds = &mut boxes[surface.component(face)];
        *bounds = bounds.union(surface.facets.facet_bounds(face));
    }
    let areas = surface.component_areas();
    let small = boxes.iter().zip(areas).filter(|(bounds, area)| *area > 0.0 && bounds.size().max_element() <= edge);
    let (small, area) = small.fold((0, 0.0), |(small, sum), (_, area)| (small + 1, sum + area));
    (small > 0 && count > 1).then(|| Defect::new(DefectKind::SmallComponents, surface.place, small, area))
}
