//! What can stand in the way, numbered through: triangles, halves of parallelograms, analytic bodies as wholes.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use umbriel_geometry::{Aabb, Facet, Facets, LightSource, cut_out::Opacity};

use crate::{
    bodies::{Bodies, Body},
    loose::turned::Turned,
    query::Queries,
};

/// Pieces of a run at most.
const RUN: u32 = 2048;

/// The place of an object without pieces.
const NO_PLACE: u32 = u32::MAX;

/// All pieces of a scene.
pub(super) struct Pieces<'a> {
    objects: Vec<Numbered<'a>>,
    /// Of each object of the scene its place among these, or [`NO_PLACE`].
    places: Vec<u32>,
    count: u32,
    /// Holds them all.
    pub(super) bounds: Aabb,
    /// How far corners may be from where floats put them, in any coordinate.
    pub(super) slack: f64,
    /// Whether it is asked which are of closed surfaces.
    with_surfaces: bool,
}

/// The pieces of one object.
struct Numbered<'a> {
    /// Number of its first piece.
    first: u32,
    object: usize,
    body: &'a Body,
    /// Two pieces a face.
    is_halved: bool,
    bounds: Aabb,
    /// Which of its faces are looked at, where not all of them are; each is one piece then.
    turned: Option<Turned<'a>>,
}

/// Triangles of one object that follow each other.
pub(super) struct Triangles<'a> {
    /// Number of the first, as a piece and as a face.
    pub(super) first: u32,
    face: usize,
    pub(super) positions: &'a [DVec3],
    pub(super) all: &'a [[u32; 3]],
    turned: Option<&'a Turned<'a>>,
}

impl Triangles<'_> {
    /// Whether all are looked at.
    #[inline(always)]
    pub(super) fn are_all_kept(&self) -> bool {
        self.turned.is_none()
    }

    /// Those that are looked at, with their numbers as pieces.
    #[inline(always)]
    pub(super) fn kept(&self) -> impl Iterator<Item = (u32, &[u32; 3])> {
        let is_kept = |at: usize| self.turned.is_none_or(|turned| turned.is_kept(self.face + at));
        (self.first..).zip(self.all).enumerate().filter(move |(at, _)| is_kept(*at)).map(|(_, piece)| piece)
    }
}

/// One piece.
pub(super) enum Piece {
    Triangle {
        /// Each known to the pieces' slack.
        corners: [DVec3; 3],
        /// It is of a closed surface, which is known exactly.
        is_closed: bool,
    },
    /// A triangle with holes: it may block where it is met.
    CutOut([DVec3; 3]),
    /// A curved body may be anywhere inside its box.
    Box(Aabb),
}

impl<'a> Pieces<'a> {
    /// Places every object of the scene. `None` when 32 bits cannot number the pieces.
    pub(super) fn of(bodies: &'a Bodies) -> Option<Self> {
        let count = bodies.scene.objects.len();
        let (objects, places) = (Vec::new(), vec![NO_PLACE; count]);
        let mut pieces = Self { objects, places, count: 0, bounds: Aabb::EMPTY, slack: 0.0, with_surfaces: false };
        for object in 0..count {
            let (bounds, body) = (bodies.bounds(object), bodies.get(object));
            let (faces, is_halved) = match body {
                Body::Flat(facets) => (facets.len(), facets.iter().any(|face| face.corners().len() == 4)),
                Body::Analytic(_) => (1, false),
            };
            // A body may be cut away as a whole.
            let faces = if bounds.is_empty() { 0 } else { faces };
            let count = u32::try_from(faces << u32::from(is_halved)).ok()?;
            if count > 0 {
                pieces.places[object] = pieces.objects.len() as u32;
                pieces.objects.push(Numbered { first: pieces.count, object, body, is_halved, bounds, turned: None });
                pieces.count = pieces.count.checked_add(count)?;
                pieces.bounds = pieces.bounds.union(bounds);
                if matches!(body, Body::Flat(facets) if !facets.are_floats()) {
                    // Positions are within half an ulp.
                    pieces.slack = pieces.slack.max(f64::EPSILON * bounds.magnitude());
                }
            }
        }
        Some(pieces)
    }

    /// Leaves out what need not be looked at of solids ([`turned`](super::turned)), for points that lie on faces, or anywhere.
    pub(super) fn leave_out(&mut self, queries: &'a Queries, light: &LightSource, on_faces: bool) {
        for numbered in &mut self.objects {
            if let Body::Flat(facets) = numbered.body {
                numbered.turned = Turned::of(queries, (numbered.object, facets), light, on_faces);
            }
        }
    }

    /// Asks which pieces are of closed surfaces: of each object all threads find that, before tiles are made that would wait for it.
    pub(super) fn find_surfaces(&mut self) {
        self.with_surfaces = true;
        self.objects.par_iter().for_each(|numbered| {
            if let Body::Flat(facets) = numbered.body
                && facets.are_floats()
            {
                facets.is_closed(0);
            }
        });
    }

    /// All pieces in runs of one object each; none is long.
    pub(super) fn runs(&self) -> Vec<Range<u32>> {
        let ends = self.objects.iter().skip(1).map(|numbered| numbered.first).chain([self.count]);
        let runs = self.objects.iter().zip(ends).flat_map(|(numbered, end)| {
            let starts = (numbered.first..end).step_by(RUN as usize);
            starts.map(move |start| start..end.min(start.saturating_add(RUN)))
        });
        runs.collect()
    }

    /// The corners of each piece of a run; of a curved body those of its box.
    #[inline(always)]
    pub(super) fn for_each(&self, run: Range<u32>, mut visit: impl FnMut(u32, &[DVec3])) {
        let numbered = &self.objects[self.place_of(run.start)];
        let first = numbered.first;
        match numbered.body {
            Body::Analytic(_) => visit(run.start, &numbered.bounds.corners()),
            Body::Flat(facets) => run.for_each(|piece| {
                visit(piece, &corners(facets, (piece - first) as usize, numbered.is_halved));
            }),
        }
    }

    /// The triangles of a run and the points that they are of; `None` where the object's faces are something else.
    #[inline(always)]
    pub(super) fn triangles(&self, run: &Range<u32>) -> Option<Triangles<'_>> {
        let numbered = &self.objects[self.place_of(run.start)];
        let Body::Flat(facets) = numbered.body else { return None };
        let [from, to] = [run.start, run.end].map(|piece| (piece - numbered.first) as usize);
        let (first, all) = (run.start, &facets.triangles()?[from..to]);
        Some(Triangles { first, face: from, positions: facets.positions(), all, turned: numbered.turned.as_ref() })
    }

    pub(super) fn len(&self) -> u32 {
        self.count
    }

    /// The first piece of an object, and whether each of its faces has two; `None` where it has no pieces.
    pub(super) fn of_object(&self, object: usize) -> Option<(u32, bool)> {
        self.objects.get(self.places[object] as usize).map(|numbered| (numbered.first, numbered.is_halved))
    }

    /// How the faces of an object are turned, if that was asked for.
    pub(super) fn turned(&self, object: usize) -> Option<&Turned<'a>> {
        self.objects.get(self.places[object] as usize)?.turned.as_ref()
    }

    /// Object and face of a piece.
    pub(super) fn face(&self, piece: u32) -> (usize, usize) {
        let numbered = &self.objects[self.place_of(piece)];
        let index = (piece - numbered.first) as usize;
        (numbered.object, index >> u32::from(numbered.is_halved))
    }

    /// A piece, and the first one of its face. `hint` remembers where the last one was found: neighbours in number are found at once.
    #[inline(always)]
    pub(super) fn get(&self, piece: u32, hint: &mut usize) -> (Piece, u32) {
        let is_here = |numbered: &Numbered, next: Option<&Numbered>| {
            numbered.first <= piece && next.is_none_or(|next| piece < next.first)
        };
        if !self.objects.get(*hint).is_some_and(|numbered| is_here(numbered, self.objects.get(*hint + 1))) {
            *hint = self.place_of(piece);
        }
        let numbered = &self.objects[*hint];
        match numbered.body {
            Body::Analytic(_) => (Piece::Box(numbered.bounds), piece),
            Body::Flat(facets) => {
                let index = (piece - numbered.first) as usize;
                let corners = corners(facets, index, numbered.is_halved);
                let halves = u32::from(numbered.is_halved);
                let first = numbered.first + (index >> halves << halves) as u32;
                match facets.opacity(index >> halves) {
                    Opacity::Opaque => {
                        let is_closed = || match &numbered.turned {
                            Some(turned) => turned.is_closed(index),
                            None => facets.are_floats() && facets.is_closed(index >> halves),
                        };
                        (Piece::Triangle { corners, is_closed: self.with_surfaces && is_closed() }, first)
                    }
                    Opacity::Mixed | Opacity::Clear => (Piece::CutOut(corners), first),
                }
            }
        }
    }

    fn place_of(&self, piece: u32) -> usize {
        self.objects.partition_point(|numbered| numbered.first <= piece) - 1
    }
}

#[inline]
fn corners(facets: &Facets, index: usize, is_halved: bool) -> [DVec3; 3] {
    let corners = match facets.facet(index >> u32::from(is_halved)) {
        Facet::Triangle(corners) => corners,
        Facet::Parallelogram([a, b, c, _]) if index.is_multiple_of(2) => [a, b, c],
        Facet::Parallelogram([a, _, c, d]) => [a, c, d],
    };
    corners.map(|corner| facets.positions()[corner as usize])
}
