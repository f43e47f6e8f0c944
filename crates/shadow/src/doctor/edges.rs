//! Edges: which do not cancel, which are used twice in one direction, which have three faces or more; and closed
//! components that are wound inside out.
//!
//! The sign of a component's volume is exact: a sum of determinants with a running bound, in exact arithmetic where the
//! bound leaves it open. O(n log n).

use umbriel_geometry::{
    Approx, Dyadic, Facet, Ring, Sign,
    decisions::decide,
    predicates::{Target, exact_side, side_value},
};

use super::{
    defect::{Defect, DefectKind},
    surface::Surface,
};

/// One use of an edge by a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Use {
    /// Its ends, the lower point first.
    ends: [u32; 2],
    is_upward: bool,
    face: u32,
}

/// All defects of the edges and components of a triangle mesh.
pub(super) fn defects(surface: &Surface) -> Vec<Option<Defect>> {
    let uses = uses(surface);
    let edges = || uses.chunk_by(|a, b| a.ends == b.ends);
    let areas = surface.component_areas();
    vec![
        open(surface, &areas),
        inconsistent(surface, edges().filter(|edge| edge.len() == 2 && edge[0].is_upward == edge[1].is_upward), &areas),
        non_manifold(surface, edges().filter(|edge| edge.len() > 2)),
        inside_out(surface, &areas),
    ]
}

fn uses(surface: &Surface) -> Vec<Use> {
    let mut uses = Vec::with_capacity(3 * surface.facets.len());
    for face in 0..surface.facets.len() {
        let Facet::Triangle([a, b, c]) = surface.facets.welded(face) else { continue };
        let directed = [(a, b), (b, c), (c, a)].into_iter().filter(|(from, to)| from != to);
        uses.extend(directed.map(|(from, to)| Use {
            ends: [from.min(to), from.max(to)],
            is_upward: from < to,
            face: face as u32,
        }));
    }
    uses.sort_unstable();
    uses
}

fn open(surface: &Surface, areas: &[f64]) -> Option<Defect> {
    let components = &surface.facets.topology().components;
    let count: usize = components.iter().map(|component| component.open_edges).sum();
    let area = components.iter().zip(areas).filter(|(component, _)| !component.is_closed()).map(|(_, area)| area).sum();
    (count > 0).then(|| Defect::new(DefectKind::OpenEdges, surface.place, count, area))
}

fn inconsistent<'a>(surface: &Surface, edges: impl Iterator<Item = &'a [Use]>, areas: &[f64]) -> Option<Defect> {
    let mut components: Vec<usize> = edges.map(|edge| surface.component(edge[0].face as usize)).collect();
    let count = components.len();
    components.sort_unstable();
    components.dedup();
    let area = components.iter().map(|&component| areas[component]).sum();
    (count > 0).then(|| Defect::new(DefectKind::InconsistentOrientation, surface.place, count, area))
}

fn non_manifold<'a>(surface: &Surface, edges: impl Iterator<Item = &'a [Use]> + Clone) -> Option<Defect> {
    let count = edges.clone().count();
    let mut faces: Vec<usize> = edges.flatten().map(|one| one.face as usize).collect();
    faces.sort_unstable();
    faces.dedup();
    let area = surface.area_of(faces);
    (count > 0).then(|| Defect::new(DefectKind::NonManifoldEdges, surface.place, count, area))
}

fn inside_out(surface: &Surface, areas: &[f64]) -> Option<Defect> {
    let topology = surface.facets.topology();
    let mut faces: Vec<usize> = surface.faces_that(|face| surface.facets.is_closed(face));
    faces.sort_by_key(|&face| topology.component_of[face]);
    let components = faces.chunk_by(|&a, &b| topology.component_of[a] == topology.component_of[b]);
    let inverted = components.filter(|faces| volume_sign(surface, faces) == Sign::Negative);
    let (count, area) = inverted
        .map(|faces| areas[surface.component(faces[0])])
        .fold((0, 0.0), |(count, sum), area| (count + 1, sum + area));
    (count > 0).then(|| Defect::new(DefectKind::InsideOut, surface.place, count, area))
}

/// The sign of the volume within a closed component: positive when the fronts look outward. Exact.
fn volume_sign(surface: &Surface, faces: &[usize]) -> Sign {
    let facets = surface.facets;
    let corners = |face: &usize| {
        let corners = facets.facet(*face).corners();
        [corners[0], corners[1], corners[2]].map(|corner| facets.point(corner))
    };
    let base = corners(&faces[0])[0];
    // A base point behind a face adds volume.
    let behind = faces.iter().fold(Approx::exact(0.0), |sum, face| {
        let [a, b, c] = corners(face);
        sum - side_value(&a, &b, &c, Target::Point(&base))
    });
    let sign = decide(behind.sign(), || {
        let base = base.to_exact::<Dyadic>();
        let exact = faces.iter().fold(Dyadic::zero(), |sum, face| {
            let [a, b, c] = corners(face).map(|corner| corner.to_exact());
            sum - exact_side(&a, &b, &c, &base)
        });
        exact.sign()
    });
    if facets.is_mirrored() { sign.flipped() } else { sign }
}
