//! Points given by face and parameters, as light space takes them: where floats put them, and which face is their own.
//!
//! A face does not hide its own points, so its pieces count neither as in the way nor as in doubt. Faces that are turned away are dark
//! without a look; points of curved bodies are left to single queries.

use glam::DVec3;
use umbriel_geometry::{Facet, Facets, LightSource, simd::dispatch};

use crate::{
    bodies::{Bodies, Body},
    exact::{flat_face_is_turned_to, patch_probe},
    loose::{
        filter::{Doubtful, Filter},
        grid::Grids,
        pieces::Pieces,
        sorted::Buckets,
    },
    query::{Place, Queries, QueryDefect},
};

/// The point (u, v) of a face: triangle (or side, or patch) `face` of object `object`, its corners in input order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FacePoint {
    /// Index into the scene's objects.
    pub object: usize,
    /// Face of the object.
    pub face: usize,
    /// First parameter.
    pub u: f64,
    /// Second parameter.
    pub v: f64,
}

impl FacePoint {
    /// The point as a single query takes it.
    pub fn place(self) -> Place {
        let Self { object, face, u, v } = self;
        Place::Surface { object, face, u, v }
    }
}

/// The points of a job that light space may tell about. Memory is kept from one job to the next.
#[derive(Debug, Default)]
pub(super) struct OnFaces {
    rows: Vec<[f64; 3]>,
    own: Vec<i32>,
    /// Which of the job's points each is.
    indices: Vec<u32>,
    /// What a coordinate is off by at most, and how large it is.
    slack: f64,
    size: f64,
    /// Points that are asked one by one.
    single: Vec<u32>,
    told: Vec<bool>,
    /// Faces met before, each where its number puts it: neighbouring rows of a picture meet the same ones.
    met: Vec<Option<Met>>,
}

/// So many faces are remembered, a power of two.
const REMEMBERED: usize = 512;

/// An object's face under the light that is asked for.
#[derive(Clone, Copy, Debug)]
struct Met {
    place: (usize, usize),
    /// Points with u, v from 0 to 1 and u + v no greater than this surely lie on it.
    reach: f64,
    kind: Kind,
}

/// What the points of a face have in common.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Dark,
    Single,
    Open(Open),
}

/// A face whose points are where A + u·e + v·f says.
#[derive(Clone, Copy, Debug)]
struct Open {
    corner: DVec3,
    edges: [DVec3; 2],
    /// What that is off by in any coordinate, and how large it is at most.
    slack: f64,
    size: f64,
    own: i32,
}

impl Open {
    /// With corners up to m in size and off by s, and u' = 2^-53: an edge is off by 2u'm, its multiple rounds by 2u'm; the sums, at most m and 3m in size, round by
    /// u'm and 3u'm: 12u'm in all, without second powers. A place is a sum of corners with weights of 3 at most, and lies between them.
    fn of(facets: &Facets, face: usize, own: i32) -> Self {
        let corners = facets.facet(face).corners();
        let at = |k: usize| facets.positions()[corners[k] as usize];
        let [a, b, d] = [at(0), at(1), at(corners.len() - 1)];
        let size = (0..corners.len()).map(|k| at(k).abs().max_element()).fold(0.0, f64::max);
        // Positions are within half an ulp.
        let slack = if facets.are_floats() { 0.0 } else { f64::EPSILON * size };
        let slack = 3.0 * slack + 8.0 * f64::EPSILON * size;
        Self { corner: a, edges: [b - a, d - a], slack, size: size + slack, own }
    }
}

impl OnFaces {
    /// Takes points instead of those before; scene and light are always the same. The first point that is refused is an error.
    pub(super) fn gather(
        &mut self,
        queries: &Queries,
        pieces: &Pieces,
        points: &[FacePoint],
        light: &LightSource,
    ) -> Result<(), usize> {
        self.rows.clear();
        self.own.clear();
        self.indices.clear();
        self.single.clear();
        (self.slack, self.size) = (0.0, 0.0);
        self.met.resize(REMEMBERED, None);
        self.rows.reserve(points.len());
        self.own.reserve(points.len());
        self.indices.reserve(points.len());
        let mut met = &Met::NONE;
        for (index, &point) in points.iter().enumerate() {
            let FacePoint { object, face, u, v } = point;
            if met.place != (object, face) {
                met = remembered(&mut self.met, queries, pieces, (object, face), light).ok_or(index)?;
                if let Kind::Open(Open { slack, size, .. }) = met.kind {
                    (self.slack, self.size) = (self.slack.max(slack), self.size.max(size));
                }
            }
            let is_inside = (u >= 0.0) & (v >= 0.0) & (u <= 1.0) & (v <= 1.0) & (u + v <= met.reach);
            if !is_inside && queries.surface_defect(point).is_some() {
                return Err(index);
            }
            match &met.kind {
                Kind::Dark => {}
                Kind::Single => self.single.push(index as u32),
                Kind::Open(Open { corner, edges: [e, f], own, .. }) => {
                    self.rows.push((*corner + u * *e + v * *f).to_array());
                    self.own.push(*own);
                    self.indices.push(index as u32);
                }
            }
        }
        Ok(())
    }

    /// Where floats put the points that light space may tell about.
    pub(super) fn rows(&self) -> &[[f64; 3]] {
        &self.rows
    }

    /// What coordinates of rows are off by, and how large they are, at most.
    pub(super) fn off(&self) -> (f64, f64) {
        (self.slack, self.size)
    }

    /// Fills in what is certain; what is left is returned.
    pub(super) fn filter(&mut self, grids: &Grids, lit: &mut [bool], buckets: &mut Buckets) -> Vec<Doubtful> {
        self.told.clear();
        self.told.resize(self.rows.len(), false);
        let (rows, own, slack, size) = (self.rows.as_slice(), self.own.as_slice(), self.slack, self.size);
        let mut doubtful = dispatch(Filter { grids, rows, own, slack, size, lit: &mut self.told, buckets });
        for (&index, &told) in self.indices.iter().zip(&self.told) {
            lit[index as usize] = told;
        }
        doubtful.iter_mut().for_each(|doubt| doubt.index = self.indices[doubt.index as usize]);
        doubtful.extend(self.single.iter().map(|&index| Doubtful { index, faces: None }));
        doubtful
    }
}

/// A face, as it is remembered; `None` if there is none.
fn remembered<'a>(
    met: &'a mut [Option<Met>],
    queries: &Queries,
    pieces: &Pieces,
    place: (usize, usize),
    light: &LightSource,
) -> Option<&'a Met> {
    let known = &mut met[place.0.wrapping_mul(97).wrapping_add(place.1) % REMEMBERED];
    if known.is_none_or(|met| met.place != place) {
        *known = Some(Met::of(&queries.bodies, pieces, place, light)?);
    }
    known.as_ref()
}

impl Met {
    /// No face has this number.
    const NONE: Self = Self { place: (usize::MAX, usize::MAX), reach: -1.0, kind: Kind::Dark };

    /// `None` if there is no such face.
    fn of(bodies: &Bodies, pieces: &Pieces, (object, face): (usize, usize), light: &LightSource) -> Option<Self> {
        bodies.scene.objects.get(object)?;
        let (reach, kind) = match bodies.get(object) {
            Body::Analytic(_) => (-1.0, Kind::Single),
            Body::Flat(facets) if face < facets.len() => {
                let is_triangle = matches!(facets.facet(face), Facet::Triangle(_));
                let kind = if flat_face_is_turned_to(bodies, object, face, light) {
                    let own = pieces.of_face(object, face).unwrap_or(u32::MAX) as i32;
                    Kind::Open(Open::of(facets, face, own))
                } else {
                    Kind::Dark
                };
                (if is_triangle { 1.0 - f64::EPSILON } else { 2.0 }, kind)
            }
            Body::Flat(_) => return None,
        };
        Some(Self { place: (object, face), reach, kind })
    }
}

impl Queries<'_> {
    /// Why a point of a face is refused, if it is.
    pub(crate) fn surface_defect(&self, point: FacePoint) -> Option<QueryDefect> {
        if let Err(defect) = self.check_square(point) {
            return Some(defect);
        }
        let FacePoint { object, face, u, v } = point;
        match self.bodies.get(object) {
            Body::Analytic(body) if patch_probe(body, face, u, v).is_none() => Some(QueryDefect::OutsideFace),
            _ => None,
        }
    }
}
