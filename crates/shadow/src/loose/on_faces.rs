//! Points given by face and parameters, as light space takes them: where floats put them, and which pieces are their own.
//!
//! A face does not hide its own points, so its pieces count neither as in the way nor as in doubt. Faces that are turned away are dark
//! without a look; points of curved bodies are left to single queries.

use glam::DVec3;
use umbriel_geometry::{Facet, Facets, LightSource, simd::dispatch};

use crate::{
    bodies::{Bodies, Body},
    exact::{flat_face_is_turned_to, patch_probe},
    loose::{
        Points,
        filter::{Doubtful, Filter},
        grid::Grids,
        pieces::Pieces,
        sorted::Buckets,
    },
    query::{Place, Queries, QueryDefect},
    receivers::flat_corners,
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
    own: Vec<[u32; 2]>,
    /// Which of the job's points each is.
    indices: Vec<u32>,
    /// What a coordinate is off by at most.
    slack: f64,
    /// Points that are asked one by one.
    single: Vec<u32>,
    told: Vec<bool>,
}

/// What the points of a face have in common.
enum Kind {
    Dark,
    Single,
    Open(Open),
}

/// A face whose points are where A + u·e + v·f says.
struct Open {
    corner: DVec3,
    edges: [DVec3; 2],
    /// What that is off by in any coordinate.
    slack: f64,
    own: [u32; 2],
}

impl Open {
    /// With corners up to m in size and off by s, and u' = 2^-53: an edge is off by 2u'm, its multiple rounds by 2u'm; the sums, at most m and 3m in size, round by
    /// u'm and 3u'm: 12u'm in all, without second powers. A place is a sum of corners with weights of 3 at most.
    fn of(facets: &Facets, face: usize, own: [u32; 2]) -> Self {
        let [a, b, _, d] = flat_corners(facets, face, 0);
        let corners = [&a, &b, &d];
        let size = corners.into_iter().map(|corner| corner.position.abs().max_element()).fold(0.0, f64::max);
        let slack = corners.into_iter().map(|corner| corner.slack.max_element()).fold(0.0, f64::max);
        Self {
            corner: a.position,
            edges: [b.position - a.position, d.position - a.position],
            slack: 3.0 * slack + 8.0 * f64::EPSILON * size,
            own,
        }
    }
}

impl OnFaces {
    /// Takes points, which must be places of the scene's faces, instead of those before.
    pub(super) fn gather(&mut self, bodies: &Bodies, pieces: &Pieces, points: &[FacePoint], light: &LightSource) {
        self.rows.clear();
        self.own.clear();
        self.indices.clear();
        self.single.clear();
        self.slack = 0.0;
        let (mut last, mut kind) = (None, Kind::Dark);
        for (index, &FacePoint { object, face, u, v }) in (0..).zip(points) {
            if last != Some((object, face)) {
                (last, kind) = (Some((object, face)), kind_of(bodies, pieces, (object, face), light));
                if let Kind::Open(Open { slack, .. }) = kind {
                    self.slack = self.slack.max(slack);
                }
            }
            match &kind {
                Kind::Dark => {}
                Kind::Single => self.single.push(index),
                Kind::Open(Open { corner, edges: [e, f], own, .. }) => {
                    self.rows.push((*corner + u * *e + v * *f).to_array());
                    self.own.push(*own);
                    self.indices.push(index);
                }
            }
        }
    }

    /// Fills in what is certain; what is left is returned.
    pub(super) fn filter(&mut self, grids: &Grids, lit: &mut [bool], buckets: &mut Buckets) -> Vec<Doubtful> {
        self.told.clear();
        self.told.resize(self.rows.len(), false);
        let (rows, own, slack) = (self.rows.as_slice(), self.own.as_slice(), self.slack);
        let size = Points::FreeDouble(rows).size();
        let mut doubtful = dispatch(Filter { grids, rows, own, slack, size, lit: &mut self.told, buckets });
        for (&index, &told) in self.indices.iter().zip(&self.told) {
            lit[index as usize] = told;
        }
        doubtful.iter_mut().for_each(|doubt| doubt.index = self.indices[doubt.index as usize]);
        doubtful.extend(self.single.iter().map(|&index| Doubtful { index, pieces: None }));
        doubtful
    }
}

fn kind_of(bodies: &Bodies, pieces: &Pieces, (object, face): (usize, usize), light: &LightSource) -> Kind {
    match bodies.get(object) {
        Body::Analytic(_) => Kind::Single,
        Body::Flat(_) if !flat_face_is_turned_to(bodies, object, face, light) => Kind::Dark,
        // What has holes has no pieces: nothing of it is among those in doubt.
        Body::Flat(facets) => Kind::Open(Open::of(facets, face, pieces.of_face(object, face).unwrap_or([u32::MAX, 0]))),
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

    /// Whether each of these points is taken. Quick where neighbours in the list lie on one flat face.
    pub(crate) fn are_accepted(&self, points: impl Iterator<Item = FacePoint>) -> impl Iterator<Item = bool> {
        // The face of the last point, if it is flat, and how far u + v surely stays inside of it where u, v ≤ 1.
        let (mut last, mut reach) = (None, 0.0);
        points.map(move |point| {
            let FacePoint { object, face, u, v } = point;
            let is_inside = (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v) && u + v <= reach;
            if is_inside && last == Some((object, face)) {
                return true;
            }
            let is_accepted = self.surface_defect(point).is_none();
            last = None;
            if is_accepted && let Body::Flat(facets) = self.bodies.get(object) {
                let is_triangle = matches!(facets.facet(face), Facet::Triangle(_));
                (last, reach) = (Some((object, face)), if is_triangle { 1.0 - f64::EPSILON } else { 2.0 });
            }
            is_accepted
        })
    }
}
