//! One flat face of a receiver: which way its cells are proved, and with what.

use std::{borrow::Cow, sync::OnceLock};

use umbriel_geometry::{Facet, Facets, Point, blocking::Probe};
use umbriel_octree::{Face, Quadrant};

use crate::{
    bodies::Body,
    effort::{MEASURED, Spend},
    exact::{Own, face_blocks, flat_face_is_lit},
    fine::{
        Blockers, Clearance, Entry, FacetId, GiveUp, Receiver,
        crowd::{Crowd, Means},
        flat,
        flat::{FLAT, FaceShape, FlatFace, Levels},
        lattice::Lattice,
        occluders::Among,
        raster::{self, Chain, Plane, Raster},
        tally::{Cost, Tally, Units, cell_units},
    },
    levels,
    receivers::{Depth, Receivers, flat_corners},
    report::Verdict,
    request::CellMethod,
};

/// Cells of a quadtree that take as long as finding what may shadow a face.
const CELLS_A_FACE: u64 = 64;

/// Facets that are looked at for their borders in the time of a cell of a quadtree.
const FACETS_A_CELL: u64 = 50;

/// Tiles that are settled in the time of a cell of a quadtree.
const TILES_A_CELL: u64 = 4;

/// Undecided cells that are drawn in the time of a cell of a quadtree.
const DRAWN_A_CELL: u64 = 4;

/// What counting a facet in a crowd costs, with the looks that go with it, in facets held against a cell; and how many facets are looked at for their borders for the cost
/// of one.
const BURDEN: u64 = 10;
const DRAWN_A_FACET: usize = 4;

/// All facets of a body are looked at in the time in which so many times fewer are found over a face and put together.
const FOUND_A_FACET: usize = 12;

/// A face is a needle if rounding may change its area by this part of it: it is a million million times as long as it is high.
const NEEDLE: f64 = 1.0 / 4096.0;

/// What is drawn on a face by [`raster`].
struct Drawn {
    /// The facets that are found over the face, rather than all of the bodies that may shadow it.
    are_found: bool,
    /// What that costs, in looks at facets.
    looks: usize,
}

/// One face that is asked for.
pub(crate) struct FlatReceiver<'a> {
    all: &'a Receivers<'a>,
    id: FacetId,
    /// Objects that may shadow this one, in a throng this face, found when first asked for: faces that are turned away do not ask.
    objects: OnceLock<Cow<'a, [u32]>>,
    shape: FaceShape,
    corners: [Point<'a>; FLAT],
    size: levels::FaceSize,
    depth: Depth,
    levels: Levels,
    lattice: Option<Lattice>,
    spend: Spend<'a>,
}

impl<'a> FlatReceiver<'a> {
    /// Face `face` of an object.
    pub(crate) fn new(
        all: &'a Receivers<'a>,
        object: usize,
        (facets, face): (&'a Facets, usize),
        depth: Depth,
        spend: Spend<'a>,
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
            size,
            depth,
            levels: all.levels(object, &size, depth.level(0)),
            lattice: all.spacing.map(|spacing| Lattice::new(size.edges, spacing, is_triangle)),
            spend,
        }
    }

    /// Classifies the face.
    pub(crate) fn run(&self) -> Tally<Units> {
        let FacetId { object, facet } = self.id;
        let turn = Some(self.all.occluders.turn(self.id));
        if !flat_face_is_lit(self.all.bodies, (object as usize, facet as usize), self.all.light, turn) {
            return FlatFace::decided(self.shape, Verdict::Shadowed, self.levels, self.lattice);
        }
        // Samples of it are decided one by one all the same.
        if self.lattice.is_none() && self.is_needle() {
            return self.told(Verdict::Undecided, 0);
        }
        let crowded = self.means_in_crowd();
        let drawn = if crowded.is_none() { self.suits_borders() } else { None };
        let by_borders = drawn.and_then(|drawn| self.draw(&drawn).ok());
        by_borders.unwrap_or_else(|| self.divide(crowded))
    }

    /// Whether the face is so thin that floats hardly tell its sides apart: each decision would be an exact one, about no area to speak of.
    fn is_needle(&self) -> bool {
        let Body::Flat(facets) = self.all.bodies.get(self.id.object as usize) else { return false };
        let area = facets.area(self.id.facet as usize);
        area.error >= NEEDLE * area.value
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

    /// Whether the face is one for [`raster`], and likely to be done sooner by it; then with the facets of what bodies.
    fn suits_borders(&self) -> Option<Drawn> {
        let level = self.levels.finest;
        let method = self.all.request.method;
        // The borders are drawn on cells of one size.
        if method == CellMethod::Quadtree || level > raster::MOST_LEVEL || self.levels.pixel.is_some() {
            return None;
        }
        let bodies = self.all.bodies;
        let drawn = self.objects().iter().filter(|&&object| self.is_drawn(object));
        let facets: usize = drawn.map(|&object| bodies.face_count(object as usize)).sum();
        let occluders = &self.all.occluders;
        let expected = occluders.expected_facets(self.objects(), &self.corners);
        let found = FOUND_A_FACET * expected.ceil() as usize;
        let drawn = Drawn { are_found: found < facets, looks: found.min(facets) };
        if facets >= raster::MAX_FACETS
            || method != CellMethod::Borders && !raster::is_sooner(level, drawn.looks, expected)
        {
            return None;
        }
        let others: Vec<u32> = self.objects().iter().copied().filter(|&object| !self.is_drawn(object)).collect();
        let others = occluders.candidates(Among::Objects(&others), &self.corners);
        let meets_others = !others.bodies.is_empty() || others.facets.iter().any(|&id| id != self.id);
        (!meets_others).then_some(drawn)
    }

    /// Whether an object can be drawn by its borders.
    fn is_drawn(&self, object: u32) -> bool {
        let bodies = self.all.bodies;
        !bodies.is_analytic(object as usize) && !bodies.has_holes(object as usize)
    }

    /// By borders, and what that cost.
    fn draw(&self, drawn: &Drawn) -> Result<Tally<Units>, GiveUp> {
        if !(self.spend)((drawn.looks / DRAWN_A_FACET) as u64) {
            return Ok(self.told(Verdict::Undecided, 0));
        }
        let mut tally = self.rasterise(drawn)?;
        let level = self.levels.finest;
        let open = tally.undecided / cell_units(level, false);
        let tiles = 1u64 << (2 * level.saturating_sub(raster::TILE_LEVEL));
        tally.cost = Cost {
            level,
            base: drawn.looks as u64 / FACETS_A_CELL + tiles / TILES_A_CELL,
            cells: (open / DRAWN_A_CELL).max(1),
        };
        Ok(tally)
    }

    fn rasterise(&self, drawn: &Drawn) -> Result<Tally<Units>, GiveUp> {
        let occluders = &self.all.occluders;
        let flat: Vec<u32> = self.objects().iter().copied().filter(|&object| self.is_drawn(object)).collect();
        let found = drawn.are_found.then(|| occluders.candidates(self.among(), &self.corners).facets_by_object());
        let flat = found.as_ref().map_or(flat, |found| found.keys().copied().collect());
        let add = |object: u32, plane: &Plane, chain: &mut Chain| {
            let some = found.as_ref().map(|found| found[&object].as_slice());
            occluders.add_borders((object, some), plane, chain)
        };
        let raster = Raster {
            shape: self.shape,
            levels: self.levels,
            lattice: self.lattice,
            is_lit_exactly: &|u, v| !self.point_is_blocked(u, v),
            spend: self.spend,
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

    /// How far this face is gone into if too much is over it, and over too many of its object, to measure all.
    fn means_in_crowd(&self) -> Option<Means> {
        let (all, FacetId { object, facet }) = (self.all, self.id);
        let Body::Flat(facets) = all.bodies.get(object as usize) else { return None };
        // The object first: most are told by the numbers of their faces alone.
        let crowd = match &all.throng {
            Some(throng) => throng.members(),
            None => all.crowd_of(object as usize, facets, self.objects())?,
        };
        let allowed = crowd.allowed(facets.area(facet as usize).value);
        let burden = all.occluders.burden(self.among(), &self.receiver(), allowed + 1);
        // What is spent in vain ends at the next step.
        (self.spend)(BURDEN * burden as u64);
        (burden > allowed).then(|| crowd.means())
    }

    /// What blockers are measured against.
    fn receiver(&self) -> Receiver<'a, FLAT> {
        Receiver::of_face(self.corners, self.all.light, self.all.occluders.turn(self.id))
    }

    /// By a quadtree that passes the blockers in question down.
    fn divide(&self, crowded: Option<Means>) -> Tally<Units> {
        let (bodies, light, occluders) = (self.all.bodies, self.all.light, &self.all.occluders);
        let corners = self.corners;
        let receiver = self.receiver();
        let blocks_exactly = |blockers: &Blockers<FLAT>, entry: Entry, probe: &Probe| {
            let FacetId { object, facet } = blockers.id(entry);
            face_blocks(bodies, (object as usize, facet as usize), probe, Own::Nothing, light)
        };
        let is_blocked = |u: f64, v: f64| self.point_is_blocked(u, v);
        let under = |levels: Levels, blockers| FlatFace {
            shape: self.shape,
            corners,
            blockers,
            levels,
            lattice: self.lattice,
            blocks_exactly: &blocks_exactly,
            is_blocked: &is_blocked,
            spend: self.spend,
        };
        if let Some(means) = crowded {
            let levels = Levels { finest: means.finest.min(self.levels.finest), ..self.levels };
            let under = |blockers| under(levels, blockers);
            let crowd =
                Crowd { own: self.id, means, receiver: &receiver, occluders, among: self.among(), under: &under };
            let tally = Self::costing(0, self.levels.finest, crowd.run());
            return Tally { is_crowded: tally.undecided > 0, ..tally };
        }
        let mut candidates = occluders.candidates(self.among(), &corners);
        candidates.facets.retain(|&candidate| candidate != self.id);
        let measured = candidates.facets.len() + candidates.bodies.len();
        if !(self.spend)(MEASURED * measured as u64) {
            return self.told(Verdict::Undecided, measured);
        }
        let clearance = Clearance::of(&receiver);
        if let Some(face) = &clearance {
            if occluders.is_under_a_sheet(&candidates.facets, face, &receiver) {
                return self.told(Verdict::Shadowed, 0);
            }
            occluders.leave_out_clear(&mut candidates.facets, face);
            if candidates.facets.is_empty() && candidates.bodies.is_empty() {
                return self.told(Verdict::Lit, measured);
            }
        }
        let levels = self.all.levels(self.id.object as usize, &self.size, self.depth.level(measured));
        let whole = self.shape.hull(Quadrant::ROOT);
        let cover = |blockers: &Blockers<FLAT>| blockers.cover(&whole);
        let blockers = occluders.blockers_until(&candidates, (&receiver, clearance.as_ref()), cover);
        Self::costing(measured, levels.finest, under(levels, blockers).run())
    }

    /// Told as a whole.
    fn told(&self, verdict: Verdict, measured: usize) -> Tally<Units> {
        let tally = FlatFace::decided(self.shape, verdict, self.levels, self.lattice);
        Self::costing(measured, self.levels.finest, Tally { examined: 1, ..tally })
    }

    /// A quadtree's sums with what they cost: measuring a facet or a body takes about as long as a cell.
    fn costing(measured: usize, level: u8, tally: Tally<Units>) -> Tally<Units> {
        Tally { cost: Cost { level, base: CELLS_A_FACE + measured as u64, cells: tally.examined }, ..tally }
    }
}
