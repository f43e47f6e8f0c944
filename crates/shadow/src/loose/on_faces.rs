//! Points given by face and parameters, as light space takes them: where floats put them, and which face is their own.
//!
//! A face does not hide its own points, so its pieces count neither as in the way nor as in doubt. Faces that are turned away are dark
//! without a look; points of curved bodies are left to single queries.

use glam::DVec3;
use umbriel_geometry::{Facets, LightSource, simd::dispatch};

use crate::{
    bodies::Body,
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

/// The points of a job that light space may tell about. Memory, and what was found out about faces, is kept from one job to the next.
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
    /// What is done with the points of each face, counted from the first piece of its object, which has as many pieces as faces or more.
    kinds: Vec<u8>,
    /// Open faces met before, each where its number puts it: neighbouring rows of a picture meet the same ones.
    met: Vec<Met>,
}

/// So many faces are remembered, a power of two.
const REMEMBERED: usize = 512;

/// An open face under the light that is asked for. Its points are where A + u·e + v·f says.
#[derive(Clone, Copy, Debug)]
struct Met {
    piece: u32,
    /// How large a corner's coordinate is at most.
    size: f64,
    corner: DVec3,
    edges: [DVec3; 2],
}

/// A face that was not met yet: zero, as fresh memory is, so that of a table for a large scene only what is looked at is touched.
const UNKNOWN: u8 = 0;
/// A face that is turned away: its points are dark.
const DARK: u8 = 1;
/// A face whose points may be lit.
const OPEN: u8 = 2;

/// The object of some points that follow each other.
#[derive(Clone, Copy)]
struct Here<'a> {
    queries: &'a Queries<'a>,
    light: &'a LightSource,
    object: usize,
    /// Its faces, where these are flat.
    facets: Option<&'a Facets>,
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
        if self.kinds.is_empty() {
            self.kinds = vec![UNKNOWN; pieces.len() as usize];
        }
        self.single.clear();
        (self.open, self.size) = (0, 0.0);
        let mut first = 0;
        for points in points.chunk_by(|a, b| a.object == b.object) {
            let here = Here::of(queries, points[0].object, light).ok_or(first)?;
            match (here.facets, pieces.of_object(here.object)) {
                (Some(facets), Some(of_object)) => self.gather_flat(&here, (facets, of_object), points, first)?,
                _ => self.gather_single(&here, points, first)?,
            }
            first += points.len();
        }
        Ok(())
    }

    /// Of an object with a piece or two for each face, from `piece` on; `first` is the first point's number.
    fn gather_flat(
        &mut self,
        here: &Here,
        (facets, (piece, is_halved)): (&Facets, (u32, bool)),
        points: &[FacePoint],
        first: usize,
    ) -> Result<(), usize> {
        let halves = u32::from(is_halved);
        let kinds = &mut self.kinds[piece as usize..][..facets.len()];
        // Points with u, v from 0 to 1 and u + v no greater than this surely lie on their faces.
        let reach = if is_halved { 2.0 } else { 1.0 - f64::EPSILON };
        // Copied, so that the loop has them in registers.
        let (mut open, mut size) = (self.open, self.size);
        for (index, &point) in (first..).zip(points) {
            let FacePoint { face, u, v, .. } = point;
            let is_inside = (u >= 0.0) & (v >= 0.0) & (u <= 1.0) & (v <= 1.0) & (u + v <= reach);
            if !is_inside && here.queries.surface_defect(point).is_some() {
                return Err(index);
            }
            let kind = kinds.get_mut(face).ok_or(index)?;
            if *kind == UNKNOWN {
                *kind = here.kind(face);
            }
            // Neighbours are mostly all dark or all open.
            if *kind == DARK {
                continue;
            }
            let own = piece + ((face as u32) << halves);
            let met = &mut self.met[own as usize % REMEMBERED];
            if met.piece != own {
                *met = Met::of(facets, face, own);
            }
            self.rows[open] = (met.corner + u * met.edges[0] + v * met.edges[1]).to_array();
            (self.own[open], self.indices[open]) = (own as i32, index as u32);
            size = greater(size, met.size);
            open += 1;
        }
        (self.open, self.size) = (open, size);
        Ok(())
    }

    /// Of bodies whose faces have no pieces of their own: curved ones, and any that are cut away as a whole.
    fn gather_single(&mut self, here: &Here, points: &[FacePoint], first: usize) -> Result<(), usize> {
        for (index, &point) in (first..).zip(points) {
            if here.queries.surface_defect(point).is_some() {
                return Err(index);
            }
            if here.kind(point.face) != DARK {
                self.single.push(index as u32);
            }
        }
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

impl<'a> Here<'a> {
    /// `None` if there is no such object.
    fn of(queries: &'a Queries<'a>, object: usize, light: &'a LightSource) -> Option<Self> {
        queries.bodies.scene.objects.get(object)?;
        let facets = match queries.bodies.get(object) {
            Body::Analytic(_) => None,
            Body::Flat(facets) => Some(facets),
        };
        Some(Self { queries, light, object, facets })
    }

    /// What is done with the points of a face.
    fn kind(&self, face: usize) -> u8 {
        let is_lit =
            self.facets.is_none() || flat_face_is_turned_to(&self.queries.bodies, self.object, face, self.light);
        if is_lit { OPEN } else { DARK }
    }
}

impl Met {
    /// No face has this number.
    const NONE: Self = Self { piece: u32::MAX, size: 0.0, corner: DVec3::ZERO, edges: [DVec3::ZERO; 2] };

    fn of(facets: &Facets, face: usize, piece: u32) -> Self {
        let facet = facets.facet(face);
        let corners = facet.corners();
        let at = |k: usize| facets.positions()[corners[k] as usize];
        let [a, b, d] = [at(0), at(1), at(corners.len() - 1)];
        let size = (0..corners.len()).map(|k| at(k).abs().max_element()).fold(0.0, f64::max);
        Self { piece, size, corner: a, edges: [b - a, d - a] }
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
