//! Single points, exactly.

use std::{ops::ControlFlow, sync::OnceLock};

use glam::DVec3;
use rayon::prelude::*;
use umbriel_bvh::{BoxTree, Shaft};
use umbriel_geometry::{
    Aabb, Dyadic, Facets, LightSource, NumberDefect, Ring, Sign, Surd, accept_point, analytic::Surface,
    blocking::Probe, decisions::decide,
};
use umbriel_scene::{Object, Scene, Shape};

use crate::{
    bodies::{Bodies, Body},
    embedded::{Embedded, is_alone},
    exact::{Own, face_blocks, flat_face_is_turned_to, patch_probe, turned_to},
    fine::flat::flat_probe,
    receivers::flat_corners,
    search::{Flats, Lookup},
    slack::{Meaning, SlackBox},
    soft::polyhedra::Polyhedra,
};

/// A place to ask about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// The point (u, v) of a face: triangle (or side, or patch) `face` of object `object`, its corners in input order.
    Surface {
        /// Index into the scene's objects.
        object: usize,
        /// Face of the object.
        face: usize,
        /// First parameter.
        u: f64,
        /// Second parameter.
        v: f64,
    },
    /// World coordinates with a normal; stands for the slack box (half an ulp of `precision` a coordinate).
    Oriented {
        /// World coordinates, metres.
        position: [f64; 3],
        /// Which side is meant; any length but zero.
        normal: [f64; 3],
        /// The type the coordinates came in.
        precision: Precision,
    },
    /// A point in space.
    Free {
        /// World coordinates, metres.
        position: [f64; 3],
    },
}

/// The float type that a point's coordinates came in; sets the size of its slack box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 32-bit floats.
    Single,
    /// 64-bit floats.
    Double,
}

/// The answer to a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Whether the light reaches the place.
    pub lit: bool,
    /// Whether no surface was found at a place with a normal, so that it counted as a point in space.
    pub in_space: bool,
}

/// Why a query is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum QueryDefect {
    /// No such object.
    #[error("there is no such object")]
    NoObject,
    /// No such face.
    #[error("the object has no such face")]
    NoFace,
    /// (u, v) is not finite or outside the face.
    #[error("(u, v) lies outside the face")]
    OutsideFace,
    /// A coordinate of the point outside the accepted range; `axis` is 0, 1 or 2.
    #[error("{} {defect}", ["x", "y", "z"].get(*axis).unwrap_or(&"?"))]
    Coordinate {
        /// Which.
        axis: usize,
        /// Why.
        defect: NumberDefect,
    },
    /// A normal of length zero, or with a number that is not finite.
    #[error("the normal is zero or not finite")]
    Normal,
}

/// Exact answers to single points of a scene; builds what it needs on first use, so keep it for many points. For very many to
/// one light see [`Queries::prepare`].
#[derive(Debug)]
pub struct Queries<'a> {
    pub(crate) bodies: Bodies<'a>,
    pub(crate) objects: BoxTree,
    faces: Vec<OnceLock<BoxTree>>,
    polyhedra: Vec<OnceLock<Option<Polyhedra>>>,
    /// Of each object the solids that it bounds, once they were looked for ([`Queries::find_solids`]).
    solids: Vec<Option<Embedded>>,
    /// For trees of triangles, once a light asks for one.
    pub(crate) flats: OnceLock<Flats>,
    /// What is ready for single lights.
    pub(crate) lookups: Vec<Lookup>,
}

impl<'a> Queries<'a> {
    /// Ready to answer about `scene`; builds a tree over the objects' boxes.
    pub fn new(scene: &'a Scene) -> Self {
        let bodies = Bodies::new(scene);
        let boxes: Vec<Aabb> = scene.objects.par_iter().map(Object::bounds).collect();
        let objects = BoxTree::build(&boxes);
        let faces = boxes.iter().map(|_| OnceLock::new()).collect();
        let polyhedra = boxes.iter().map(|_| OnceLock::new()).collect();
        Self { faces, polyhedra, solids: Vec::new(), bodies, objects, flats: OnceLock::new(), lookups: Vec::new() }
    }

    /// Finds out which meshes bound solids: closed surfaces that meet themselves nowhere. [`Queries::lit_many`] then looks at half of their triangles where points lie on faces
    /// or in space, with the same answers. The same for all lights: worth its while for several pictures, or lights.
    ///
    /// Cost: about a microsecond a triangle, of instances each time, and some hundred bytes, mostly for a tree that single queries make, too.
    pub fn find_solids(&mut self) {
        let found = |object: usize| {
            let Body::Flat(facets) = self.bodies.get(object) else { return None };
            let found = Embedded::of(facets, || self.face_tree(object, facets))?;
            let is_alone = is_alone(&self.objects, &self.bodies.bounds(object));
            Some(Embedded { are_apart: found.are_apart && is_alone, ..found })
        };
        self.solids = (0..self.bodies.scene.objects.len()).map(found).collect();
    }

    /// The solids that are known of an object; they are apart if its box is, from those of other objects, too.
    pub(crate) fn solids(&self, object: usize) -> Option<&Embedded> {
        self.solids.get(object)?.as_ref()
    }

    /// Whether `place` is lit by `light`. Exact.
    ///
    /// # Errors
    /// [`QueryDefect`].
    pub fn lit(&self, place: &Place, light: &LightSource) -> Result<Answer, QueryDefect> {
        match *place {
            Place::Surface { object, face, u, v } => {
                let lit = self.surface_point_is_lit(object, face, [u, v], light)?;
                Ok(Answer { lit, in_space: false })
            }
            Place::Free { position } => {
                let position = accepted(position)?;
                Ok(Answer {
                    lit: !self.is_blocked::<Dyadic>(&Probe::at(position), Own::Nothing, light, Among::All),
                    in_space: false,
                })
            }
            Place::Oriented { position, normal, precision } => {
                let position = accepted(position)?;
                let normal = accepted_normal(normal)?;
                let slack = SlackBox::new(position, precision);
                Ok(self.oriented_is_lit(position, normal, &slack, light, Among::All))
            }
        }
    }

    /// Why a place is refused, if it is.
    pub(crate) fn refusal(&self, place: &Place) -> Option<QueryDefect> {
        match *place {
            Place::Surface { object, face, u, v } => self.surface_refusal(object, face, [u, v]),
            Place::Free { position } => accepted(position).err(),
            Place::Oriented { position, normal, .. } => accepted(position).and(accepted_normal(normal)).err(),
        }
    }

    /// Why the point (u, v) of a face is refused, if it is.
    fn surface_refusal(&self, object: usize, face: usize, [u, v]: [f64; 2]) -> Option<QueryDefect> {
        if let Err(defect) = self.check_square(object, face, [u, v]) {
            return Some(defect);
        }
        match self.bodies.get(object) {
            Body::Analytic(body) if patch_probe(body, face, u, v).is_none() => Some(QueryDefect::OutsideFace),
            _ => None,
        }
    }

    /// The polyhedra that a curved body lies between, where it has such.
    pub(crate) fn polyhedra(&self, object: u32) -> Option<&Polyhedra> {
        let Body::Analytic(placed) = self.bodies.get(object as usize) else { return None };
        self.polyhedra[object as usize].get_or_init(|| Polyhedra::of(placed.body(), placed.placement())).as_ref()
    }

    fn surface_point_is_lit(
        &self,
        object: usize,
        face: usize,
        [u, v]: [f64; 2],
        light: &LightSource,
    ) -> Result<bool, QueryDefect> {
        self.check_square(object, face, [u, v])?;
        Ok(match self.bodies.get(object) {
            Body::Flat(facets) => {
                let probe = flat_probe(&flat_corners(facets, face, 0), u, v);
                self.flat_point_is_lit((object, face), &probe, light, Among::All)
            }
            Body::Analytic(body) => {
                let probe = patch_probe(body, face, u, v).ok_or(QueryDefect::OutsideFace)?;
                self.curved_point_is_lit(object, body.charts()[face].surface, &probe, light, Among::All)
            }
        })
    }

    /// Whether there is such a face, and (u, v) lies in its square, or in its triangle.
    fn check_square(&self, object: usize, face: usize, [u, v]: [f64; 2]) -> Result<(), QueryDefect> {
        let body = self.bodies.scene.objects.get(object).ok_or(QueryDefect::NoObject)?;
        if face >= body.face_count() {
            return Err(QueryDefect::NoFace);
        }
        let is_in_square = (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v);
        let is_triangle = matches!(body.shape, Shape::Mesh(_) | Shape::Convex(_));
        // Rounding is monotone: only a rounded sum of 1 may hide a greater one.
        let is_beyond_exactly = || (Dyadic::new(1.0) - Dyadic::new(v) - Dyadic::new(u)).sign() == Sign::Negative;
        let is_beyond = || decide((u + v != 1.0).then_some(u + v > 1.0), is_beyond_exactly);
        if !is_in_square || is_triangle && is_beyond() { Err(QueryDefect::OutsideFace) } else { Ok(()) }
    }

    fn flat_point_is_lit(
        &self,
        (object, face): (usize, usize),
        probe: &Probe,
        light: &LightSource,
        among: Among,
    ) -> bool {
        flat_face_is_turned_to(&self.bodies, object, face, light)
            && !self.is_blocked(probe, Own::Face { object, face }, light, among)
    }

    fn curved_point_is_lit(
        &self,
        object: usize,
        surface: Surface,
        probe: &Probe<Surd>,
        light: &LightSource,
        among: Among,
    ) -> bool {
        let own = turned_to(&self.bodies, object, surface, probe, light);
        own.is_some_and(|own| !self.is_blocked(probe, own, light, among))
    }

    /// Whether any of these faces meets the open segment from the point to the light.
    pub(crate) fn is_blocked<R: Ring>(&self, probe: &Probe<R>, own: Own, light: &LightSource, among: Among) -> bool {
        if let Among::Faces(faces) = among {
            return faces.iter().any(|&face| face_blocks(&self.bodies, face, probe, own, light));
        }
        if let Some(lookup) = self.lookup(light) {
            return self.is_blocked_by(lookup, probe, own);
        }
        let shaft = Shaft::new(&probe.bounds.bounds(), light);
        let blocks = |object: u32| match self.object_blocks(object as usize, &shaft, probe, own, light) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        self.objects.for_each_in_shaft(&shaft, blocks).is_break()
    }

    /// Whether a face of an object meets the open segment from the point to the light, which is in the shaft.
    pub(crate) fn object_blocks<R: Ring>(
        &self,
        object: usize,
        shaft: &Shaft,
        probe: &Probe<R>,
        own: Own,
        light: &LightSource,
    ) -> bool {
        let meets = |face: usize| face_blocks(&self.bodies, (object, face), probe, own, light);
        match self.bodies.get(object) {
            Body::Analytic(_) => meets(0),
            Body::Flat(facets) => {
                let visit = |face: u32| match meets(face as usize) {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                };
                self.face_tree(object, facets).for_each_in_shaft(shaft, visit).is_break()
            }
        }
    }

    pub(crate) fn face_tree(&self, object: usize, facets: &Facets) -> &BoxTree {
        self.faces[object].get_or_init(|| {
            let boxes: Vec<Aabb> = (0..facets.len()).map(|face| facets.facet_bounds(face)).collect();
            BoxTree::build(&boxes)
        })
    }

    /// Any surface point of the slack box that is turned the right way has a right answer: if all agree it is theirs,
    /// and otherwise either answer is right.
    pub(crate) fn oriented_is_lit(
        &self,
        position: DVec3,
        normal: DVec3,
        slack: &SlackBox,
        light: &LightSource,
        among: Among,
    ) -> Answer {
        let meaning = |object, face| {
            let is_one_sided = self.bodies.is_one_sided(object, face);
            Meaning { normal, is_one_sided, light }
        };
        let mut is_on_surface = false;
        for (object, face) in self.faces_near(slack, among) {
            let found = match self.bodies.get(object) {
                Body::Flat(facets) => slack.point_on_face(facets, face).and_then(|point| {
                    is_on_surface = true;
                    let is_meant = meaning(object, face).is_of_face(facets, face);
                    is_meant.then(|| self.flat_point_is_lit((object, face), &point, light, among))
                }),
                Body::Analytic(body) => {
                    let found = slack.point_on_analytic(body, Some(&meaning(object, 0)));
                    found.and_then(|(found, is_meant)| {
                        is_on_surface = true;
                        is_meant.then(|| self.curved_point_is_lit(object, found.surface, &found.probe, light, among))
                    })
                }
            };
            if let Some(lit) = found {
                return Answer { lit, in_space: false };
            }
        }
        // On a surface whose lit side looks the other way, the side that is meant gets no light.
        let lit = !is_on_surface && !self.is_blocked::<Dyadic>(&Probe::at(position), Own::Nothing, light, among);
        Answer { lit, in_space: !is_on_surface }
    }

    /// The faces whose boxes meet a slack box, in order; a curved body counts as one.
    fn faces_near(&self, slack: &SlackBox, among: Among) -> Vec<(usize, usize)> {
        let mut near = Vec::new();
        match among {
            Among::Faces(faces) => near.extend(faces),
            Among::All => self.objects.for_each_meeting(&slack.bounds, |object| {
                let object = object as usize;
                match self.bodies.get(object) {
                    Body::Analytic(_) => near.push((object, 0)),
                    Body::Flat(facets) => self
                        .face_tree(object, facets)
                        .for_each_meeting(&slack.bounds, |face| near.push((object, face as usize))),
                }
            }),
        }
        near.sort_unstable();
        near.dedup();
        near
    }
}

/// The faces that a point is held against, of each curved body one.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Among<'a> {
    /// All of the scene.
    All,
    /// None but these can stand in the way of the point or any other of its slack box, or have a point in there.
    Faces(&'a [(usize, usize)]),
}

/// A point whose coordinates are accepted.
fn accepted(position: [f64; 3]) -> Result<DVec3, QueryDefect> {
    accept_point(position).map_err(|(axis, defect)| QueryDefect::Coordinate { axis, defect })
}

/// A normal of any length but zero.
fn accepted_normal(normal: [f64; 3]) -> Result<DVec3, QueryDefect> {
    let normal = DVec3::from_array(normal);
    if normal.is_finite() && normal != DVec3::ZERO { Ok(normal) } else { Err(QueryDefect::Normal) }
}
