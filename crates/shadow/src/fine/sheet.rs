//! Whether a face lies in the shadow of one sheet of triangles, told by a walk over that part of the sheet which is over it.
//!
//! The shadow that a dense mesh casts on its own faces is made of many triangles, none of which hides a face alone, in two, four or more layers. One
//! layer is enough. From a triangle that hides a point of the face the walk goes on across each side that may run over the face, to the only other
//! triangle there; it ends in vain at a silhouette, at a rim, and where the sheet is not strictly nearer than the face.
//!
//! Guarantee: a face that is told hidden is, border included (NUMERICS.md, "Winding", "A walk"). Cost: some 100 ns a triangle of the layer over the face.

use glam::DVec3;
use umbriel_geometry::{
    Facets, Point, Sign,
    predicates::{Target, side_filter},
};

use super::{
    clearance::{Clearance, Place},
    flat::FLAT,
    occluders::Occluders,
    polygon_blocker::FacetId,
    receiver::Receiver,
};
use crate::bodies::Body;

/// Triangles that a walk visits; what so many do not hide is asked of all occluders together.
const MOST: usize = 32;

impl Occluders<'_> {
    /// Whether the sheet about one of these facets hides a face.
    pub(crate) fn is_under_a_sheet(&self, facets: &[FacetId], clearance: &Clearance, face: &Receiver<FLAT>) -> bool {
        let middle = middle_of(face);
        // The middle of a face with corners close together may be rounded out of it.
        clearance.place(&middle).is_over()
            && facets.chunk_by(|a, b| a.object == b.object).any(|of_object| {
                let object = of_object[0].object;
                let Body::Flat(facets) = self.bodies.get(object as usize) else { return false };
                let walk = Walk { face, clearance, facets, turns: self.turns(object) };
                of_object.iter().any(|id| walk.may_begin(id.facet, &middle) && walk.hides(id.facet, &middle))
            })
    }
}

/// A face, and a surface of which some sheet may hide it.
struct Walk<'a> {
    face: &'a Receiver<'a, FLAT>,
    clearance: &'a Clearance<'a>,
    facets: &'a Facets,
    turns: &'a [Sign],
}

impl Walk<'_> {
    /// Whether the light may see a point inside of a triangle: in plain floats, which are right wherever their bounds tell anything.
    #[inline(always)]
    fn may_begin(&self, triangle: u32, point: &Point) -> bool {
        let Some(triangles) = self.facets.triangles() else { return false };
        let (light, positions) = (self.face.light, self.facets.positions());
        let way = if light.is_sun() { light.xyz() } else { light.xyz() - point.position };
        let [a, b, c] = triangles[triangle as usize].map(|corner| positions[corner as usize] - point.position);
        let sides = [a.cross(b).dot(way), b.cross(c).dot(way), c.cross(a).dot(way)];
        sides.iter().all(|&side| side > 0.0) || sides.iter().all(|&side| side < 0.0)
    }

    /// Whether the sheet about a triangle hides all of the face. `middle` is inside of the face as the light sees it.
    fn hides(&self, start: u32, middle: &Point) -> bool {
        let turn = self.turns[start as usize];
        let corners = self.corners(start);
        let is_inside = |side: usize| self.side_of(side_from(&corners, side), middle) == Some(turn);
        if turn == Sign::Zero || !(0..3).all(is_inside) {
            return false;
        }
        let mut visited = vec![start];
        let mut next = 0;
        while let Some(&triangle) = visited.get(next) {
            let corners = self.corners(triangle);
            let Some(places) = self.nearer(triangle, &corners) else { return false };
            for side in 0..3 {
                if self.is_beside(side_from(&corners, side), side_from(&places, side)) {
                    continue;
                }
                match self.facets.across(triangle as usize, side) {
                    Some(beyond) if self.turns[beyond as usize] == turn => {
                        if !visited.contains(&beyond) {
                            visited.push(beyond);
                        }
                    }
                    _ => return false,
                }
            }
            next += 1;
            if visited.len() > MOST {
                return false;
            }
        }
        true
    }

    /// Where the corners of a triangle without holes lie; `None` unless all are nearer to the light than the face's plane.
    fn nearer(&self, triangle: u32, corners: &[Point; 3]) -> Option<[Place; 3]> {
        if self.facets.holes(triangle as usize).is_some() {
            return None;
        }
        let places = corners.each_ref().map(|corner| self.clearance.place(corner));
        places.iter().all(|place| place.is_nearer()).then_some(places)
    }

    /// Whether a side surely does not run over the inside of the face: it lies beyond one border of it, or the face on one side of it.
    fn is_beside(&self, ends: [&Point; 2], [from, to]: [&Place; 2]) -> bool {
        if from.shares_outside(*to) {
            return true;
        }
        let mut sides = self.face.points.iter().map(|point| self.side_of(ends, point));
        let first = sides.next().flatten();
        first.is_some() && sides.all(|side| side == first)
    }

    /// On which side of the shadow plane through two points a third one lies.
    fn side_of(&self, [from, to]: [&Point; 2], point: &Point) -> Option<Sign> {
        side_filter(from, to, point, Target::Light(self.face.light)).sign()
    }

    fn corners(&self, triangle: u32) -> [Point<'_>; 3] {
        let corners = self.facets.facet(triangle as usize).corners();
        [0, 1, 2].map(|k| self.facets.point(corners[k]))
    }
}

/// What is known of both ends of a side.
fn side_from<T>(corners: &[T; 3], side: usize) -> [&T; 2] {
    [&corners[side], &corners[(side + 1) % 3]]
}

/// A point about the middle of a face; rounded, so that it may lie beside the face's plane.
fn middle_of(face: &Receiver<FLAT>) -> Point<'static> {
    Point::exact(0.25 * (face.points.iter().map(|corner| corner.position).sum::<DVec3>()))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use umbriel_geometry::{LightSource, Mesh, Placement, blocking::Probe};
    use umbriel_scene::{Object, Scene, Shape, Sides};

    use super::*;
    use crate::{
        bodies::Bodies,
        exact::{Own, face_blocks},
        receivers::flat_corners,
    };

    const STEPS: u32 = 12;

    /// Two triangles for each square of a grid over (-1, 1) × (-1, 1), `height` over the floor; some left out.
    fn grid(height: impl Fn(f64, f64) -> [f64; 3], is_left_out: impl Fn(u32) -> bool) -> Shape {
        let at = |k: u32| f64::from(k) / f64::from(STEPS) * 2.0 - 1.0;
        let points = (0..(STEPS + 1) * (STEPS + 1)).map(|k| height(at(k % (STEPS + 1)), at(k / (STEPS + 1))));
        let corners = (0..STEPS * STEPS).map(|k| k / STEPS * (STEPS + 1) + k % STEPS);
        let triangles = corners.flat_map(|k| [[k, k + STEPS + 1, k + 1], [k + 1, k + STEPS + 1, k + STEPS + 2]]);
        let kept = (0..).zip(triangles).filter(|&(number, _)| !is_left_out(number));
        Shape::Mesh(Arc::new(Mesh::new(points.collect(), kept.map(|(_, corners)| corners).collect()).expect("a mesh")))
    }

    /// A floor, and above it a sheet: with folds that overhang, with holes, down to the floor in the middle.
    fn sheet_over_floor(fold: f64, hole: u32) -> Scene {
        let floor = grid(|x, z| [x + 0.013 * z, 0.02 * x * z, z], |_| false);
        let bumpy =
            |x: f64, z: f64| [x + fold * libm::sin(9.0 * x + z), 0.3 * (x * x + z * z) + fold * libm::cos(9.0 * x), z];
        let sheet = grid(bumpy, |number| hole > 0 && number % hole == 7);
        let object =
            |shape| Object::new("sheet".to_owned(), shape, Placement::IDENTITY, Sides::Two).expect("an object");
        Scene { objects: [object(floor), object(sheet)].into(), ..Scene::default() }
    }

    /// How many faces of the floor are told hidden, of how many that are; each is asked at some of its points.
    fn told_hidden(scene: &Scene, light: &LightSource) -> [usize; 2] {
        let bodies = Bodies::new(scene);
        let occluders = Occluders::new(&bodies, light);
        let Body::Flat(floor) = bodies.get(0) else { panic!("a mesh is flat") };
        let Body::Flat(sheet) = bodies.get(1) else { panic!("a mesh is flat") };
        let all: Vec<FacetId> = (0..sheet.len() as u32).map(|facet| FacetId { object: 1, facet }).collect();
        let [mut told, mut hidden] = [0; 2];
        for number in 0..floor.len() {
            let points = flat_corners(floor, number, 0);
            let face = Receiver {
                points,
                light,
                facing: Some(floor.turn(number, light)),
                plane: Some([points[0], points[1], points[3]]),
            };
            let Some(clearance) = Clearance::of(&face) else { continue };
            let is_told = occluders.is_under_a_sheet(&all, &clearance, &face);
            let is_hidden = [[0, 0], [8, 0], [0, 8], [4, 0], [4, 4], [0, 4], [2, 2], [5, 1], [1, 5], [1, 1]]
                .iter()
                .all(|weights| {
                    let [u, v] = weights.map(|weight| 0.125 * f64::from(weight));
                    let probe: Probe = Probe::on_face([points[0], points[1], points[3]], u, v);
                    (0..sheet.len()).any(|facet| face_blocks(&bodies, (1, facet), &probe, Own::Nothing, light))
                });
            assert!(is_hidden || !is_told, "face {number} under {light:?}");
            told += usize::from(is_told);
            hidden += usize::from(is_hidden);
        }
        [told, hidden]
    }

    #[test]
    fn what_is_told_hidden_is() {
        let suns = [[0.1, -1.0, 0.2], [1.0, -0.4, 0.3]].map(LightSource::sun);
        let lamps = [[0.2, 1.5, 0.1], [-0.6, 0.31, 0.4]].map(LightSource::point);
        for light in suns.into_iter().chain(lamps).map(|light| light.expect("a light")) {
            for (fold, hole) in [(0.0, 0), (0.0, 50), (0.03, 90), (0.15, 200), (0.3, 0)] {
                let [told, hidden] = told_hidden(&sheet_over_floor(fold, hole), &light);
                // Plain sheets are told but for faces under their rim, and where they touch the floor.
                assert!(
                    fold > 0.1 || 10 * told > 6 * hidden,
                    "{told} of {hidden} under {light:?}, folds {fold}, holes {hole}"
                );
            }
        }
    }
}
