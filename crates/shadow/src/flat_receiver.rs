//! One flat face of a receiver: which way its cells are proved, and with what.

use std::{borrow::Cow, sync::OnceLock};

use umbriel_geometry::{Facet, Facets, Point, blocking::Probe};
use umbriel_octree::Face;

use crate::{
    bodies::Body,
    exact::{Own, face_blocks, flat_face_is_turned_to},
    fine::{
        Blockers, Entry, FacetId, GiveUp, Receiver,
        crowd::{Crowd, Effort, PAIRS},
        flat,
        flat::{FLAT, FaceShape, FlatFace, Levels},
        lattice::Lattice,
        occluders::Among,
        raster::{self, Chain, Plane, Raster},
        tally::{Tally, Units},
    },
    levels,
    receivers::{Receivers, flat_corners},
    report::Verdict,
    request::CellMethod,
};

/// One face that is asked for.
pub(crate) struct FlatReceiver<'a> {
    all: &'a Receivers<'a>,
    id: FacetId,
    /// Objects that may shadow this one, in a throng this face, found when first asked for: faces that are turned away do not ask.
    objects: OnceLock<Cow<'a, [u32]>>,
    shape: FaceShape,
    corners: [Point<'a>; FLAT],
    levels: Levels,
    lattice: Option<Lattice>,
    is_cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> FlatReceiver<'a> {
    /// Face `face` of an object, divided down to `level` at most if that is given.
    pub(crate) fn new(
        all: &'a Receivers<'a>,
        object: usize,
        (facets, face): (&'a Facets, usize),
        level: Option<u8>,
        is_cancelled: &'a (dyn Fn() -> bool + Sync),
    ) -> Self {
        let is_triangle = matches!(facets.facet(face), Facet::Triangle(_));
        let domain = if is_triangle { Face::Triangle } else { Face::Square };
        let corner = facets.base(face).corner;
        let corners = flat_corners(facets, face, corner);
        let size = levels::FaceSize::of_flat(&corners, is_triangle);
        Self {
            all,
            id: FacetId { object: object as u32, facet: face as u32 },
            objects: OnceLock::new(),
            shape: FaceShape { face: face as u32, domain, corner },
            corners,
            levels: all.levels(object, &size, level),
            lattice: all.spacing.map(|spacing| Lattice::new(size.edges, spacing, is_triangle)),
            is_cancelled,
        }
    }

    /// Classifies the face.
    pub(crate) fn run(&self) -> Tally<Units> {
        let FacetId { object, facet } = self.id;
        if !flat_face_is_turned_to(self.all.bodies, object as usize, facet as usize, self.all.light) {
            return FlatFace::decided(self.shape, Verdict::Shadowed, self.levels, self.lattice);
        }
        let crowded = self.effort_in_crowd();
        let by_borders = if crowded.is_none() && self.suits_borders() { self.rasterise().ok() } else { None };
        by_borders.unwrap_or_else(|| self.divide(crowded))
    }

    /// Objects that may shadow this one; in a throng this face.
    fn objects(&self) -> &[u32] {
        self.objects.get_or_init(|| match &self.all.throng {
            Some(throng) => self.all.occluders.candidates(Among::Throng(throng), &self.corners).objects().into(),
            None => self.all.influences.occluders_of(self.id.object),
        })
    }

    /// What is looked through for what may shadow the face.
    fn among(&self) -> Among<'_> {
        let objects = self.all.throng.is_none().then(|| self.objects());
        self.all.among(objects)
    }

    /// Whether the face is one for [`raster`], and likely to be done sooner by it.
    fn suits_borders(&self) -> bool {
        let level = self.levels.finest;
        let method = self.all.request.method;
        // The borders are drawn on cells of one size.
        if method == CellMethod::Quadtree || level > raster::MOST_LEVEL || self.levels.pixel.is_some() {
            return false;
        }
        let (mut facets, mut others) = (0, Vec::new());
        for &object in self.objects().iter() {
            let (bodies, number) = (self.all.bodies, object as usize);
            if bodies.is_analytic(number) || bodies.has_holes(number) {
                others.push(object);
            } else {
                facets += bodies.face_count(number);
            }
        }
        let occluders = &self.all.occluders;
        let others = occluders.candidates(Among::Objects(&others), &self.corners);
        let meets_others = !others.bodies.is_empty() || others.facets.iter().any(|&id| id != self.id);
        if facets >= raster::MAX_FACETS || meets_others {
            return false;
        }
        let expected = || occluders.expected_facets(self.objects(), &self.corners);
        method == CellMethod::Borders || raster::is_sooner(level, facets, expected())
    }

    fn rasterise(&self) -> Result<Tally<Units>, GiveUp> {
        let (bodies, occluders) = (self.all.bodies, &self.all.occluders);
        let is_flat = |object: usize| !bodies.is_analytic(object) && !bodies.has_holes(object);
        let flat: Vec<u32> = self.objects().iter().copied().filter(|&object| is_flat(object as usize)).collect();
        let add = |object: u32, plane: &Plane, chain: &mut Chain| occluders.add_borders(object, plane, chain);
        let raster = Raster {
            shape: self.shape,
            levels: self.levels,
            lattice: self.lattice,
            is_lit_exactly: &|u, v| !self.point_is_blocked(u, v),
            is_cancelled: self.is_cancelled,
        };
        raster.run(&self.corners, self.all.light, occluders.turn(self.id), (&flat, &add))
    }

    /// Whether anything blocks the way from a point of the face to the light. Exact.
    fn point_is_blocked(&self, u: f64, v: f64) -> bool {
        let probe = flat::flat_probe(&self.corners, u, v);
        let candidates = self.all.occluders.candidates(self.among(), &[probe.bounds]);
        let facets = candidates.facets.iter().filter(|&&id| id != self.id);
        let facets = facets.map(|id| (id.object as usize, id.facet as usize));
        let bodies = candidates.bodies.iter().map(|&object| (object as usize, 0));
        let mut faces = facets.chain(bodies);
        faces.any(|face| face_blocks(self.all.bodies, face, &probe, Own::Nothing, self.all.light))
    }

    /// What is spent on this face if too much is over it, and over too many of its object, to measure all.
    fn effort_in_crowd(&self) -> Option<Effort> {
        let (all, object) = (self.all, self.id.object as usize);
        let Body::Flat(facets) = all.bodies.get(object) else { return None };
        // The object first: most are told by the numbers of their faces alone.
        let is_crowded = (all.throng.is_some() || all.is_in_crowd(object, facets, self.objects()))
            && all.occluders.count(self.among(), &self.corners, PAIRS + 1) > PAIRS;
        let faces = || all.throng.as_ref().map_or(facets.len(), |throng| throng.facets());
        is_crowded.then(|| Effort::of_each(faces()))
    }

    /// By a quadtree that passes the blockers in question down.
    fn divide(&self, crowded: Option<Effort>) -> Tally<Units> {
        let (bodies, light, occluders) = (self.all.bodies, self.all.light, &self.all.occluders);
        let corners = self.corners;
        let receiver = Receiver {
            points: corners,
            light,
            facing: Some(occluders.turn(self.id)),
            plane: Some([corners[0], corners[1], corners[FLAT - 1]]),
        };
        let blocks_exactly = |blockers: &Blockers<FLAT>, entry: Entry, probe: &Probe| {
            let FacetId { object, facet } = blockers.id(entry);
            face_blocks(bodies, (object as usize, facet as usize), probe, Own::Nothing, light)
        };
        let is_blocked = |u: f64, v: f64| self.point_is_blocked(u, v);
        let finest = crowded.map_or(u8::MAX, |effort| effort.finest).min(self.levels.finest);
        let under = |blockers| FlatFace {
            shape: self.shape,
            corners,
            blockers,
            levels: Levels { finest, ..self.levels },
            lattice: self.lattice,
            blocks_exactly: &blocks_exactly,
            is_blocked: &is_blocked,
            is_cancelled: self.is_cancelled,
        };
        if let Some(effort) = crowded {
            let crowd =
                Crowd { own: self.id, effort, receiver: &receiver, occluders, among: self.among(), under: &under };
            return crowd.run();
        }
        let mut candidates = occluders.candidates(self.among(), &corners);
        candidates.facets.retain(|&candidate| candidate != self.id);
        under(occluders.blockers(&candidates.facets, &candidates.bodies, &receiver)).run()
    }
}
