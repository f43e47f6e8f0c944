//! One object at a time: its placed faces, and every check that needs no other object.

use glam::DVec3;
use umbriel_geometry::{Aabb, Facets};
use umbriel_scene::{Object, Scene, Shape};

use crate::request::Detail;

use super::{
    coordinates,
    defect::{Defect, DefectKind, Place},
    detail, edges,
    lamps::{Chosen, Seen},
    planes::PlaneKey,
    plate::eye_of,
};

/// What is known of an object when its faces are gone again.
#[derive(Debug, Default)]
pub(super) struct Examined {
    pub(super) is_curved: bool,
    pub(super) faces: usize,
    /// Square metres, rounded.
    pub(super) area: f64,
    pub(super) defects: Vec<Defect>,
    /// The number of each face's plane.
    pub(super) planes: Vec<PlaneKey>,
    /// What each chosen light sees of it.
    pub(super) seen: Vec<Seen>,
}

impl Examined {
    pub(super) fn new(scene: &Scene, number: usize, detail: Detail, lights: &Chosen) -> Self {
        let object = &scene.objects[number];
        let Some(facets) = object.facets() else {
            return Self { is_curved: true, seen: lights.see_curved(), ..Self::default() };
        };
        let surface = Surface::new(Place::Object(number), object, &facets);
        let plane = |face: usize| if surface.has_area(face) { PlaneKey::of(&facets, face) } else { PlaneKey::None };
        Self {
            is_curved: false,
            faces: facets.len(),
            area: surface.area_of(0..facets.len()),
            defects: defects(&surface, detail),
            planes: (0..facets.len()).map(plane).collect(),
            seen: lights.see(&surface),
        }
    }

    /// The same of another object that repeats this one.
    pub(super) fn of_copy(&self, place: Place) -> Self {
        let defects = self.defects.iter().map(|&defect| Defect { place, ..defect }).collect();
        Self { defects, planes: Vec::new(), seen: self.seen.clone(), ..*self }
    }
}

fn defects(surface: &Surface, detail: Detail) -> Vec<Defect> {
    let mut defects = vec![no_surface(surface), flat_faces(surface)];
    if let Shape::Mesh(mesh) = &surface.object.shape {
        defects.extend(edges::defects(surface));
        defects.extend([duplicates(surface), slivers(surface)]);
        defects.push(coordinates::defect(surface, mesh));
        defects.push(coordinates::unreferenced(surface, mesh));
        defects.extend([detail::small_faces(surface, detail), detail::small_components(surface, detail)]);
    }
    defects.into_iter().flatten().collect()
}

/// The placed faces of an object, with what all checks ask for.
#[derive(Debug)]
pub(super) struct Surface<'a> {
    pub(super) place: Place,
    pub(super) object: &'a Object,
    pub(super) facets: &'a Facets,
    /// The box of all faces.
    pub(super) bounds: Aabb,
    /// A point off each face's plane; `None` for a face without area.
    pub(super) eyes: Vec<Option<DVec3>>,
    /// Square metres, rounded; exactly zero for a face without area.
    pub(super) areas: Vec<f64>,
}

impl<'a> Surface<'a> {
    fn new(place: Place, object: &'a Object, facets: &'a Facets) -> Self {
        let eyes: Vec<Option<DVec3>> = (0..facets.len()).map(|face| eye_of(facets, face)).collect();
        let area = |(face, eye): (usize, &Option<DVec3>)| eye.map_or(0.0, |_| facets.area(face).value);
        let areas = eyes.iter().enumerate().map(area).collect();
        Self { place, object, facets, bounds: facets.bounds(), eyes, areas }
    }

    pub(super) fn has_area(&self, face: usize) -> bool {
        self.eyes[face].is_some()
    }

    /// The sum over some faces, square metres.
    pub(super) fn area_of(&self, faces: impl IntoIterator<Item = usize>) -> f64 {
        faces.into_iter().map(|face| self.areas[face]).sum()
    }

    /// The component of a face.
    pub(super) fn component(&self, face: usize) -> usize {
        self.facets.topology().component_of[face] as usize
    }

    /// The areas of the components.
    pub(super) fn component_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.facets.topology().components.len()];
        self.areas.iter().enumerate().for_each(|(face, area)| areas[self.component(face)] += area);
        areas
    }

    /// The corners' positions.
    pub(super) fn corners(&self, face: usize) -> impl Iterator<Item = DVec3> + Clone {
        let corners = self.facets.facet(face).corners();
        (0..corners.len()).map(move |k| self.facets.positions()[corners[k] as usize])
    }

    /// The length of the longest edge, metres, rounded.
    pub(super) fn longest_edge(&self, face: usize) -> f64 {
        let corners = self.corners(face);
        let next = corners.clone().cycle().skip(1);
        corners.zip(next).map(|(from, to)| from.distance(to)).fold(0.0, f64::max)
    }

    /// The height of a triangle over its longest edge, metres, rounded; zero without area.
    pub(super) fn height(&self, face: usize) -> f64 {
        if self.has_area(face) { 2.0 * self.areas[face] / self.longest_edge(face) } else { 0.0 }
    }

    /// A defect of some faces; none without faces.
    pub(super) fn of_faces(&self, kind: DefectKind, faces: &[usize]) -> Option<Defect> {
        let area = self.area_of(faces.iter().copied());
        (!faces.is_empty()).then(|| Defect::new(kind, self.place, faces.len(), area))
    }

    /// All faces that are so.
    pub(super) fn faces_that(&self, is_so: impl Fn(usize) -> bool) -> Vec<usize> {
        (0..self.facets.len()).filter(|&face| is_so(face)).collect()
    }
}

fn no_surface(surface: &Surface) -> Option<Defect> {
    let is_bare = surface.eyes.iter().all(Option::is_none);
    is_bare.then(|| Defect::new(DefectKind::NoSurface, surface.place, 1, 0.0))
}

fn flat_faces(surface: &Surface) -> Option<Defect> {
    surface.of_faces(DefectKind::ZeroAreaFaces, &surface.faces_that(|face| !surface.has_area(face)))
}

fn slivers(surface: &Surface) -> Option<Defect> {
    let is_sliver = |face: usize| {
        surface.has_area(face) && surface.longest_edge(face) > DefectKind::SLIVER_ASPECT * surface.height(face)
    };
    surface.of_faces(DefectKind::Slivers, &surface.faces_that(is_sliver))
}

/// Triangles with the same three corners as an earlier one, in whichever order.
fn duplicates(surface: &Surface) -> Option<Defect> {
    let corners = |face: usize| {
        let mut corners = surface.facets.welded(face).corners().to_vec();
        corners.sort_unstable();
        (corners, face)
    };
    let mut sorted: Vec<(Vec<u32>, usize)> = (0..surface.facets.len()).map(corners).collect();
    sorted.sort_unstable();
    let repeats = sorted.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1);
    surface.of_faces(DefectKind::DuplicateFaces, &repeats.collect::<Vec<_>>())
}
