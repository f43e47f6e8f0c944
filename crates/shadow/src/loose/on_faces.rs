//! Points given by face and parameters, as light space takes them: where floats put them, and which face is their own.
//!
//! A face does not hide its own points, so its pieces count neither as in the way nor as in doubt. Faces that are turned away are dark
//! without a look; points of curved bodies are left to single queries.

use glam::DVec3;
use umbriel_geometry::{Facets, LightSource, Sign, simd::dispatch};

use crate::{
    bodies::Body,
    exact::flat_face_is_lit,
    light_space::greater,
    loose::{
        filter::{Doubtful, Filter},
        grid::Grids,
        pieces::Pieces,
        sorted::Buckets,
    },
    query::{Place, Queries, QueryDefect},
};

/// The point (u, v) of a face: triangle (or side, or patch) `face` of object `object`, its corners in input order. Of 24 bytes, as pictures have millions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FacePoint {
    /// Index into the scene's objects.
    pub object: u32,
    /// Face of the object.
    pub face: u32,
    /// First parameter.
    pub u: f64,
    /// Second parameter.
    pub v: f64,
}

const _: () = assert!(size_of::<FacePoint>() == 24);

impl FacePoint {
    /// From the numbers of object and face that other types have. What 32 bits do not hold, which no scene has, becomes the greatest number.
    pub fn new(object: usize, face: usize, u: f64, v: f64) -> Self {
        let [object, face] = [object, face].map(|number| u32::try_from(number).unwrap_or(u32::MAX));
        Self { object, face, u, v }
    }

    /// The point as a single query takes it.
    pub fn place(self) -> Place {
        let Self { object, face, u, v } = self;
        Place::Surface { object: object as usize, face: face as usize, u, v }
    }
}

/// Points that light space may tell about.
#[derive(Debug, Default)]
pub(super) struct OnFaces {
    /// Where the points of faces that are turned to the light are; behind these there may be room for others.
    rows: Vec<[f64; 3]>,
    /// The faces that they lie on, or [`LEFT_OUT`].
    own: Vec<i32>,
    /// Which of the job's points each is.
    indices: Vec<u32>,
    /// How many there are.
    open: usize,
    /// How large a corner's coordinate is at most.
    size: f64,
    /// Points that are asked one by one.
    single: Vec<u32>,
}

/// What a thread has found out about faces under the light that is asked for. Scene and light are always the same.
#[derive(Debug, Default)]
pub(super) struct Faces {
    /// What is done with the points of each, counted from the first piece of its object, which has as many pieces as faces or more.
    kinds: Vec<u8>,
    /// Open faces met before, each where its number puts it: neighbouring rows of a picture meet the same ones.
    met: Vec<Met>,
}

/// So many points tell how many of all are on faces that are turned to the light.
const LOOKED_AT: usize = 256;
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

/// Stands for a face that is not looked at.
pub(super) const LEFT_OUT: i32 = -1;

/// A face that was not met yet: zero, as fresh memory is, so that of a table for a large scene only what is looked at is touched.
const UNKNOWN: u8 = 0;
/// A face that is turned away: its points are dark.
const DARK: u8 = 1;
/// A face whose points may be lit.
const OPEN: u8 = 2;

/// A scene under a light.
#[derive(Clone, Copy)]
pub(super) struct LitScene<'a> {
    pub(super) queries: &'a Queries<'a>,
    pub(super) pieces: &'a Pieces<'a>,
    pub(super) light: &'a LightSource,
}

/// Which way so many faces turn is found together.
const NEIGHBOURS: usize = 8;

/// The object of some points that follow each other.
#[derive(Clone, Copy)]
struct Here<'a> {
    at: LitScene<'a>,
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
    /// Takes points instead of those before. The first one that is refused is an error.
    pub(super) fn gather(&mut self, faces: &mut Faces, at: LitScene, points: &[FacePoint]) -> Result<(), usize> {
        faces.met.resize(REMEMBERED, Met::NONE);
        if faces.kinds.is_empty() {
            faces.kinds = vec![UNKNOWN; at.pieces.len() as usize];
        }
        self.make_room(points.len());
        let mut first = 0;
        while let Some(point) = points.get(first) {
            let here = Here::of(at, point.object as usize).ok_or(first)?;
            let points = &points[first..];
            first += match (here.facets, at.pieces.of_object(here.object)) {
                (Some(facets), Some(of_object)) => {
                    self.gather_flat(faces, &here, (facets, of_object), points, first)?
                }
                _ => self.gather_single(&here, points, first)?,
            };
        }
        Ok(())
    }

    /// Forgets all points, and has room for so many.
    #[inline(never)]
    fn make_room(&mut self, count: usize) {
        self.single.clear();
        (self.open, self.size) = (0, 0.0);
        if self.rows.len() < count {
            self.rows.resize(count, [0.0; 3]);
            self.own.resize(count, 0);
            self.indices.resize(count, 0);
        }
    }

    /// Of an object with a piece or two for each face, from `piece` on; `first` is the first point's number. How many points are of it.
    fn gather_flat(
        &mut self,
        faces: &mut Faces,
        here: &Here,
        (facets, (piece, is_halved)): (&Facets, (u32, bool)),
        points: &[FacePoint],
        first: usize,
    ) -> Result<usize, usize> {
        let halves = u32::from(is_halved);
        let kinds = &mut faces.kinds[piece as usize..][..facets.len()];
        let are_left_out = here.at.pieces.turned(here.object).is_some_and(|turned| turned.is_entered);
        // Points with u, v from 0 on that reach no farther than this surely lie on their faces.
        let limit = if is_halved { 1.0 } else { 1.0 - f64::EPSILON };
        // Copied, so that the loop has them in registers.
        let (mut open, mut size) = (self.open, self.size);
        let mut count = 0;
        for (index, &point) in (first..).zip(points) {
            let FacePoint { object, face, u, v } = point;
            if object as usize != here.object {
                break;
            }
            let reach = if is_halved { greater(u, v) } else { u + v };
            let is_inside = (u >= 0.0) & (v >= 0.0) & (reach <= limit);
            if !is_inside && here.at.queries.surface_defect(point).is_some() {
                return Err(index);
            }
            let face = face as usize;
            let kind = match *kinds.get(face).ok_or(index)? {
                UNKNOWN => here.find_kinds(facets, face, kinds),
                kind => kind,
            };
            count += 1;
            // Neighbours are mostly all dark or all open.
            if kind == DARK {
                continue;
            }
            let own = piece + ((face as u32) << halves);
            let met = &mut faces.met[own as usize % REMEMBERED];
            if met.piece != own {
                *met = Met::of(facets, face, own);
            }
            self.rows[open] = (met.corner + u * met.edges[0] + v * met.edges[1]).to_array();
            self.own[open] = if are_left_out { LEFT_OUT } else { own as i32 };
            self.indices[open] = index as u32;
            size = greater(size, met.size);
            open += 1;
        }
        (self.open, self.size) = (open, size);
        Ok(count)
    }

    /// Of bodies whose faces have no pieces of their own: curved ones, and any that are cut away as a whole.
    fn gather_single(&mut self, here: &Here, points: &[FacePoint], first: usize) -> Result<usize, usize> {
        let points = points.split(|point| point.object as usize != here.object).next().unwrap_or_default();
        for (index, &point) in (first..).zip(points) {
            if here.at.queries.surface_defect(point).is_some() {
                return Err(index);
            }
            if here.kind(point.face as usize, None) != DARK {
                self.single.push(index as u32);
            }
        }
        Ok(points.len())
    }

    /// The same points, without room for others.
    pub(super) fn copied(&self) -> Self {
        let mut copy = Self { size: self.size, ..Self::default() };
        copy.append(self, 0);
        copy
    }

    /// Adds points that come behind `before` others, where there is no room for others.
    pub(super) fn append(&mut self, then: &Self, before: usize) {
        let shifted = |index: &u32| index + before as u32;
        self.rows.extend_from_slice(then.rows());
        self.own.extend_from_slice(&then.own[..then.open]);
        self.indices.extend(then.indices[..then.open].iter().map(shifted));
        self.single.extend(then.single.iter().map(shifted));
        self.open += then.open;
        self.size = greater(self.size, then.size);
    }

    /// How many points there are that may be lit.
    pub(super) fn len(&self) -> usize {
        self.open + self.single.len()
    }

    /// Where floats put the points that light space may tell about.
    pub(super) fn rows(&self) -> &[[f64; 3]] {
        &self.rows[..self.open]
    }

    /// What coordinates of rows are off by, and how large they are, at most.
    pub(super) fn off(&self) -> (f64, f64) {
        (OFF * self.size, self.size + OFF * self.size)
    }

    /// Fills in what is certain, where `lit` was false; what is left is returned.
    pub(super) fn filter(
        &self,
        grids: &Grids,
        lit: &mut [bool],
        buckets: &mut Buckets,
        told: &mut Vec<bool>,
    ) -> Vec<Doubtful> {
        told.clear();
        told.resize(self.open, false);
        let (rows, own, (slack, size)) = (self.rows(), &self.own[..self.open], self.off());
        let mut doubtful = dispatch(Filter { grids, rows, own, slack, size, lit: told, buckets });
        for (&index, &told) in self.indices.iter().zip(&*told) {
            lit[index as usize] = told;
        }
        doubtful.iter_mut().for_each(|doubt| doubt.index = self.indices[doubt.index as usize]);
        doubtful.extend(self.single.iter().map(|&index| Doubtful { index, faces: None }));
        doubtful
    }
}

/// How many of some points, as a part of all, are on faces that are turned to the light: of a few that are strewn over the list. Those that are refused do not count.
pub(super) fn open_part(at: LitScene, points: &[FacePoint]) -> f64 {
    let is_open = |point: &&FacePoint| {
        let (object, face) = (point.object as usize, point.face as usize);
        let here = Here::of(at, object);
        here.is_some_and(|here| here.facets.is_none_or(|facets| face < facets.len() && here.kind(face, None) == OPEN))
    };
    let some = || points.iter().step_by(points.len().div_ceil(LOOKED_AT).max(1));
    some().filter(is_open).count() as f64 / some().len().max(1) as f64
}

impl<'a> Here<'a> {
    /// `None` if there is no such object.
    fn of(at: LitScene<'a>, object: usize) -> Option<Self> {
        at.queries.bodies.scene.objects.get(object)?;
        let facets = match at.queries.bodies.get(object) {
            Body::Analytic(_) => None,
            Body::Flat(facets) => Some(facets),
        };
        Some(Self { at, object, facets })
    }

    /// What is done with the points of a face.
    fn kind(&self, face: usize, turn: Option<Sign>) -> u8 {
        let is_lit = self.facets.is_none()
            || flat_face_is_lit(&self.at.queries.bodies, (self.object, face), self.at.light, turn);
        if is_lit { OPEN } else { DARK }
    }

    /// The same, found with those of its neighbours.
    #[cold]
    fn find_kinds(&self, facets: &Facets, face: usize, kinds: &mut [u8]) -> u8 {
        let mut next = face - face % NEIGHBOURS;
        if let Some(turned) = self.at.pieces.turned(self.object) {
            kinds[face] = self.kind(face, Some(turned.turn(face)));
            return kinds[face];
        }
        facets.for_each_turn::<NEIGHBOURS>(next..kinds.len().min(next + NEIGHBOURS), self.at.light, |turn| {
            kinds[next] = self.kind(next, Some(turn));
            next += 1;
        });
        kinds[face]
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
        self.refusal(&point.place())
    }
}
