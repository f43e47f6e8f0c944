//! Looks at single faces: the first, which takes areas and signs only, and closer ones.

use umbriel_geometry::{Approx, Facet};
use umbriel_octree::Quadrant;

use super::{
    Until,
    open::{FaceId, Known, Open},
};
use crate::{
    bodies::Body,
    effort::Spend,
    exact::flat_face_is_turned_to,
    fine::tally::Cost,
    levels::FaceSize,
    progress::Progress,
    receivers::{Depth, FaceSums, Found, Job, Receivers, first_level, flat_corners},
    report::{Cell, SampleCount, Verdict},
    sums::FaceArea,
};

/// The first level where cells count, not the time that looks take.
const SPARING_LEVEL: u8 = 2;

/// Facets that are placed and asked for their borders in about the time of a cell.
const FACETS_A_CELL: f64 = 4.0;

/// What is known of a job's faces before anything else is looked at.
#[derive(Default)]
pub(super) struct First {
    pub(super) sums: FaceSums,
    pub(super) open: Vec<Open>,
    /// Cells kept or examined.
    pub(super) stored: u64,
}

/// Receivers whose faces are looked at one by one.
pub(super) struct Looks<'a> {
    pub(super) all: &'a Receivers<'a>,
    /// Whether cells count, so that first looks go no deeper than they must.
    pub(super) is_sparing: bool,
}

impl Looks<'_> {
    /// The areas of a job's faces and what is turned away; where samples are asked for, a look at each face as a whole that decides them.
    pub(super) fn first(&self, job: &Job, progress: &dyn Progress) -> First {
        let mut first = First::default();
        for face in job.faces.clone() {
            let id = FaceId { receiver: job.receiver as u32, face: face as u32 };
            let is_looked_at = self.all.spacing.is_some() || !self.is_turned(id);
            let found = if is_looked_at {
                self.all.look(job.receiver, face, Depth::To(0), &|_| !progress.is_cancelled())
            } else {
                self.unlooked(id)
            };
            if let Some(found) = found {
                first.add(id, found, is_looked_at);
            }
        }
        first
    }

    /// Whether some of the face may be lit as far as its own side tells.
    fn is_turned(&self, id: FaceId) -> bool {
        let object = self.object(id);
        match self.all.bodies.get(object) {
            Body::Flat(_) => flat_face_is_turned_to(self.all.bodies, object, id.face as usize, self.all.light),
            Body::Analytic(_) => !self.all.bodies.is_dark(object),
        }
    }

    fn object(&self, id: FaceId) -> usize {
        self.all.request.receivers[id.receiver as usize]
    }

    fn area(&self, id: FaceId) -> Approx {
        let face = id.face as usize;
        match self.all.bodies.get(self.object(id)) {
            Body::Flat(facets) => facets.area(face),
            Body::Analytic(body) => self.all.bodies.rough_area(self.object(id), body, face),
        }
    }

    /// A face of which nothing but the area is known; `None` without area.
    fn unlooked(&self, id: FaceId) -> Option<Found> {
        let area = self.area(id);
        let corner = match self.all.bodies.get(self.object(id)) {
            Body::Flat(facets) => facets.base(id.face as usize).corner,
            Body::Analytic(_) => 0,
        };
        let whole = || Cell::new(id.face, corner, Quadrant::ROOT, Verdict::Undecided);
        (area.upper() > 0.0).then(|| Found {
            area: FaceArea::unknown(area),
            cells: self.all.request.keep_cells.then(whole).into_iter().collect(),
            samples: SampleCount::default(),
            examined: 0,
            points: 0,
            cost: Cost::default(),
            is_crowded: false,
        })
    }

    /// What was known of a face.
    pub(super) fn before(&self, open: Open) -> Known {
        match open.known {
            Some(known) => *known,
            None => Known { cost: Cost::default(), stored: 1, area: FaceArea::unknown(self.area(open.id)) },
        }
    }

    /// The next look at a face; `None` if the clock caught it.
    pub(super) fn look(&self, open: &Open, until: &Until, spend: Spend) -> Option<Found> {
        if until.is_cancelled() {
            return None;
        }
        let depth = match &open.known {
            Some(known) => Depth::To(known.cost.level + known.levels_ahead()),
            None if self.is_sparing => Depth::To(SPARING_LEVEL),
            None => Depth::Paying(first_level(self.expected_over(open.id) as usize)),
        };
        let spend = |work| spend(work) && !until.is_cancelled();
        let found = self.all.look(open.id.receiver as usize, open.id.face as usize, depth, &spend)?;
        (!until.is_cancelled()).then_some(found)
    }

    /// What a look cost: where memory is the limit, cells alone.
    pub(super) fn cost_of(&self, found: &Found) -> Cost {
        if self.is_sparing { Cost { base: 0, cells: found.examined, ..found.cost } } else { found.cost }
    }

    /// What the next look at a face is expected to cost, in cells: a first one asks each facet over the face.
    pub(super) fn cost(&self, open: &Open) -> u64 {
        let facets = if open.known.is_none() { self.expected_over(open.id) } else { 0.0 };
        open.expected().saturating_add((facets / FACETS_A_CELL) as u64)
    }

    /// How many facets are expected over a face. In a throng none: nothing is measured there beyond some of them, and counting all would cost more.
    fn expected_over(&self, id: FaceId) -> f64 {
        let object = self.object(id);
        match self.all.bodies.get(object) {
            Body::Flat(facets) if self.all.throng.is_none() => {
                let objects = self.all.influences.occluders_of(object as u32);
                self.all.occluders.expected_facets(&objects, &flat_corners(facets, id.face as usize, 0))
            }
            _ => 0.0,
        }
    }

    /// The finest level that an octree has for a face.
    pub(super) fn deepest(&self, id: FaceId) -> u8 {
        let (object, face) = (self.object(id), id.face as usize);
        let size = match self.all.bodies.get(object) {
            Body::Flat(facets) => {
                let is_triangle = matches!(facets.facet(face), Facet::Triangle(_));
                FaceSize::of_flat(&flat_corners(facets, face, facets.base(face).corner), is_triangle)
            }
            Body::Analytic(body) => FaceSize::of_patch(&body.charts()[face], body.placement()),
        };
        self.all.levels(object, &size, None).finest
    }
}

impl First {
    fn add(&mut self, id: FaceId, found: Found, is_looked_at: bool) {
        let stored = found.examined.max(1);
        self.stored += stored;
        if !is_looked_at {
            self.open.push(Open::unknown(id, found.area.area));
        } else if found.area.undecided() > 0.0 && found.area.lit.upper.is_finite() {
            let known = Known { cost: found.cost, stored, area: found.area };
            self.open.push(Open::known(id, known));
        }
        self.sums.add(found);
    }
}
