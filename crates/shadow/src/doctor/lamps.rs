//! Lights: lamps inside closed bodies or on faces, faces that a light sees edge-on, suns below the horizon, lights that
//! no surface is turned to.
//!
//! All of it is exact: sides, contact, and how often a body goes round a lamp ([`umbriel_geometry::Facets::windings`]). O(faces) a light.

use glam::DVec3;
use umbriel_geometry::{LightSource, Point, Sign, predicates::side};
use umbriel_scene::Scene;

use super::{
    defect::{Defect, DefectKind, Note, Place},
    surface::{Examined, Surface},
};

/// The lights that are looked at.
#[derive(Debug)]
pub(super) struct Chosen(Vec<(usize, LightSource)>);

/// How many faces, and how large.
#[derive(Clone, Copy, Debug, Default)]
struct Faces {
    count: usize,
    area: f64,
}

impl Faces {
    fn add(&mut self, area: f64) {
        self.count += 1;
        self.area += area;
    }
}

/// What one light sees of one object.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    /// Whether any surface has a lit side turned to the light.
    is_turned: bool,
    edge_on: Faces,
    /// Faces that the lamp lies on.
    touched: Faces,
    /// Closed components around the lamp.
    around: Faces,
}

impl Chosen {
    pub(super) fn new(scene: &Scene, lights: &[usize]) -> Self {
        Self(lights.iter().map(|&light| (light, scene.lights[light].source)).collect())
    }

    /// A curved body has a side for every light.
    pub(super) fn see_curved(&self) -> Vec<Seen> {
        vec![Seen { is_turned: true, ..Seen::default() }; self.0.len()]
    }

    pub(super) fn see(&self, surface: &Surface) -> Vec<Seen> {
        self.0.iter().map(|(_, light)| see(surface, light)).collect()
    }

    /// What is odd about the lights, once all objects are seen.
    pub(super) fn defects(&self, examined: &[Examined]) -> Vec<Defect> {
        let of_light = |(index, &(number, light)): (usize, &(usize, LightSource))| {
            defects_of(Place::Light(number), &light, index, examined)
        };
        self.0.iter().enumerate().flat_map(of_light).collect()
    }
}

fn see(surface: &Surface, light: &LightSource) -> Seen {
    let mut seen = Seen::default();
    let is_near = !light.is_sun() && surface.bounds.contains(light.xyz());
    for face in (0..surface.facets.len()).filter(|&face| surface.has_area(face)) {
        let is_one_sided = surface.object.is_one_sided(|| surface.facets.is_closed(face));
        match surface.facets.light_side(face, light) {
            Sign::Zero => {
                seen.edge_on.add(surface.areas[face]);
                if is_near && touches(surface, face, light.xyz()) {
                    seen.touched.add(surface.areas[face]);
                }
            }
            side => seen.is_turned |= side == Sign::Positive || !is_one_sided,
        }
    }
    if is_near && seen.touched.count == 0 {
        seen.around = around(surface, light.xyz());
    }
    seen
}

/// Whether a point of a face's plane lies on the face.
fn touches(surface: &Surface, face: usize, point: DVec3) -> bool {
    let Some(eye) = surface.eyes[face] else { return false };
    let (point, eye) = (Point::exact(point), Point::exact(eye));
    let corners: Vec<Point> =
        surface.facets.facet(face).corners().iter().map(|&corner| surface.facets.point(corner)).collect();
    let turn = side(&corners[0], &corners[1], &corners[corners.len() - 1], &eye);
    let is_inside =
        |k: usize| side(&corners[k], &corners[(k + 1) % corners.len()], &point, &eye).times(turn) != Sign::Negative;
    (0..corners.len()).all(is_inside)
}

/// The closed one-sided components that look away from a point inside them; none where they and cavities cancel.
fn around(surface: &Surface, point: DVec3) -> Faces {
    let mut around = Faces::default();
    let windings = surface.facets.windings(point);
    if windings.iter().sum::<i64>() > 0 && surface.object.is_one_sided(|| true) {
        let areas = surface.component_areas();
        windings.iter().zip(areas).filter(|(winding, _)| **winding > 0).for_each(|(_, area)| around.add(area));
    }
    around
}

fn defects_of(place: Place, light: &LightSource, index: usize, examined: &[Examined]) -> Vec<Defect> {
    let whole: f64 = examined.iter().map(|object| object.area).sum();
    let seen = || examined.iter().map(|object| &object.seen[index]);
    let sum = |kind: DefectKind, faces: fn(&Seen) -> Faces| {
        let all = seen()
            .map(faces)
            .fold(Faces::default(), |sum, faces| Faces { count: sum.count + faces.count, area: sum.area + faces.area });
        (all.count > 0).then(|| Defect::new(kind, place, all.count, all.area))
    };
    let body = seen().position(|seen| seen.around.count > 0);
    let inside = sum(DefectKind::LampInsideBody, |seen| seen.around)
        .map(|defect| body.map_or(defect, |body| defect.with(Note::Body(body))));
    let is_below = light.is_sun() && light.xyz().y < 0.0;
    let is_lost = !examined.is_empty() && !seen().any(|seen| seen.is_turned);
    let of_all = |kind: DefectKind| Defect::new(kind, place, 1, whole);
    [
        inside,
        sum(DefectKind::LampOnSurface, |seen| seen.touched),
        sum(DefectKind::EdgeOnFaces, |seen| seen.edge_on),
        is_below.then(|| of_all(DefectKind::SunBelowHorizon)),
        is_lost.then(|| of_all(DefectKind::NothingTurned)),
    ]
    .into_iter()
    .flatten()
    .collect()
}
