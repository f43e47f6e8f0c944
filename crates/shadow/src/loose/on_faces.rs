//! Points given by face and parameters, as light space takes them: where floats put them, and which face is their own.
//!
//! A face does not hide its own points, so its pieces count neither as in the way nor as in doubt. Faces that are turned away are dark
//! without a look; points of curved bodies are left to single queries.

use glam::DVec3;
use umbriel_geometry::{Facet, LightSource, simd::dispatch};

use crate::{
    bodies::{Bodies, Body},
    exact::{flat_face_is_turned_to, patch_probe},
    light_space::greater,
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
    /// Where the points of faces that are turned to the light are; behind these there is room for all others.
    rows: Vec<[f64; 3]>,
    own: Vec<i32>,
    /// Which of the job's points each is.
    indices: Vec<u32>,
    /// How many there are.
    open: usize,
    /// How large a corner's coordinate is at most.
    size: f64,
    /// Points that are asked one by one.
    single: Vec<u32>,
    told: Vec<bool>,
    /// Faces met before, each where its number puts it: neighbouring rows of a picture meet the same ones.
    met: Vec<Met>,
}

/// So many faces are remembered, a power of two.
const REMEMBERED: usize = 512;

/// An object's face under the light that is asked for.
#[derive(Clone, Copy, Debug)]
struct Met {
    place: (usize, usize),
    kind: Kind,
    /// The face's first piece.
    own: i32,
    /// Points with u, v from 0 to 1 and u + v no greater than this surely lie on it.
    reach: f64,
    /// Points are where A + u·e + v·f says, if it is [`Kind::Open`].
    corner: DVec3,
    edges: [DVec3; 2],
    /// How large a corner's coordinate is at most.
    size: f64,
}

/// What is done with the points of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Dark,
    Single,
    Open,
}

/// What the coordinates of a point are off by, in parts of the greatest coordinate of a corner.
///
/// With corners up to m in size, positions within half an ulp, u'm, and u' = 2^-53: an edge is off by 2u'm, its multiple rounds by 2u'm; the sums, at most m and 3m in
/// size, round by u'm and 3u'm: 12u'm in all, without second powers. A place is a sum of corners with weights of 3 at most, and lies between them.
const OFF: f64 = 11.0 * f64::EPSILON;

impl OnFaces {
    /// Takes points instead of those before; scene and light are always the same. The first point that is refused is an error.
    pub(super) fn gather(
        &mut self,
        queries: &Queries,
        pieces: &Pieces,
        points: &[FacePoint],
        light: &LightSource,
    ) -> Result<(), usize> {
        if self.rows.len() < points.len() {
            self.rows.resize(points.len(), [0.0; 3]);
            self.own.resize(points.len(), 0);
            self.indices.resize(points.len(), 0);
        }
        self.met.resize(REMEMBERED, Met::NONE);
        self.single.clear();
        let (mut open, mut size) = (0, 0.0f64);
        for (index, &point) in points.iter().enumerate() {
            let FacePoint { object, face, u, v } = point;
            let met = &mut self.met[object.wrapping_mul(97).wrapping_add(face) % REMEMBERED];
            if met.place != (object, face) {
                *met = Met::of(&queries.bodies, pieces, (object, face), light).ok_or(index)?;
            }
            let is_inside = (u >= 0.0) & (v >= 0.0) & (u <= 1.0) & (v <= 1.0) & (u + v <= met.reach);
            if !is_inside && queries.surface_defect(point).is_some() {
                return Err(index);
            }
            if met.kind == Kind::Single {
                self.single.push(index as u32);
            }
            // Without a branch: a point that is not open is overwritten by the next one. Faces and kinds change every few points.
            self.rows[open] = (met.corner + u * met.edges[0] + v * met.edges[1]).to_array();
            (self.own[open], self.indices[open]) = (met.own, index as u32);
            open += usize::from(met.kind == Kind::Open);
            size = greater(size, met.size);
        }
        (self.open, self.size) = (open, size);
        Ok(())
    }

    /// Where floats put the points that light space may tell about.
    pub(super) fn rows(&self) -> &[[f64; 3]] {
        &self.rows[..self.open]
    }

    /// What coordinates of rows are off by, and how large they are, at most.
    pub(super) fn off(&self) -> (f64, f64) {
        (OFF * self.size, self.size + OFF * self.size)
    }

    /// Fills in what is certain; what is left is returned.
    pub(super) fn filter(&mut self, grids: &Grids, lit: &mut [bool], buckets: &mut Buckets) -> Vec<Doubtful> {
        self.told.clear();
        self.told.resize(self.open, false);
        let (rows, own, (slack, size)) = (&self.rows[..self.open], &self.own[..self.open], self.off());
        let mut doubtful = dispatch(Filter { grids, rows, own, slack, size, lit: &mut self.told, buckets });
        for (&index, &told) in self.indices.iter().zip(&self.told) {
            lit[index as usize] = told;
        }
        doubtful.iter_mut().for_each(|doubt| doubt.index = self.indices[doubt.index as usize]);
        doubtful.extend(self.single.iter().map(|&index| Doubtful { index, faces: None }));
        doubtful
    }
}

impl Met {
    /// No face has this number.
    const NONE: Self = Self {
        place: (usize::MAX, usize::MAX),
        kind: Kind::Dark,
        own: 0,
        reach: -1.0,
        corner: DVec3::ZERO,
        edges: [DVec3::ZERO; 2],
        size: 0.0,
    };

    /// `None` if there is no such face.
    fn of(bodies: &Bodies, pieces: &Pieces, place: (usize, usize), light: &LightSource) -> Option<Self> {
        let (object, face) = place;
        bodies.scene.objects.get(object)?;
        let facets = match bodies.get(object) {
            Body::Analytic(_) => return Some(Self { place, kind: Kind::Single, ..Self::NONE }),
            Body::Flat(facets) if face < facets.len() => facets,
            Body::Flat(_) => return None,
        };
        let facet = facets.facet(face);
        let reach = if matches!(facet, Facet::Triangle(_)) { 1.0 - f64::EPSILON } else { 2.0 };
        if !flat_face_is_turned_to(bodies, object, face, light) {
            return Some(Self { place, reach, ..Self::NONE });
        }
        // A body that is cut away has no pieces: its points have no face among them.
        let Some(own) = pieces.of_face(object, face) else {
            return Some(Self { place, kind: Kind::Single, reach, ..Self::NONE });
        };
        let corners = facet.corners();
        let at = |k: usize| facets.positions()[corners[k] as usize];
        let [a, b, d] = [at(0), at(1), at(corners.len() - 1)];
        Some(Self {
            place,
            kind: Kind::Open,
            own: own as i32,
            reach,
            corner: a,
            edges: [b - a, d - a],
            size: (0..corners.len()).map(|k| at(k).abs().max_element()).fold(0.0, f64::max),
        })
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
