//! What a bake answers.

use std::ops::AddAssign;

use umbriel_octree::Quadrant;

/// What is known of all points of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Verdict {
    /// Proved: every point is lit.
    Lit,
    /// Proved: no point is lit.
    Shadowed,
    /// Neither proved at the detail that was asked for.
    Undecided,
}

/// A part of one face: the square [i, i+1] × [j, j+1] / 2^level of the face's parameters, counted from one of its
/// corners: from the first, but on a triangle from the one opposite the longest side (of several the one with the lowest
/// number in the mesh: [`Facets::base`](umbriel_geometry::Facets::base)). On a triangle the square is cut by the longest side, which leaves half where i + j + 1 = 2^level.
/// [`Cell::point`] gives points in the face's own (u, v).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Cell {
    /// Face of the object: a triangle, a side of a box, a patch of an analytic body.
    pub face: u32,
    /// The corner of the face from which the parameters are counted.
    pub corner: u8,
    /// How often the face's parameter square was halved.
    pub level: u8,
    /// Along u.
    pub i: u32,
    /// Along v.
    pub j: u32,
    /// What is known.
    pub verdict: Verdict,
}

impl Cell {
    /// The cell `place` of a face.
    pub(crate) fn new(face: u32, corner: u8, place: Quadrant, verdict: Verdict) -> Self {
        let [i, j] = place.coordinates();
        Self { face, corner, level: place.level(), i, j, verdict }
    }

    /// The point (s, t) of the cell, both in 0..=1, in the parameters (u, v) of its face. Exact for dyadic s and t with
    /// few digits.
    pub fn point(&self, [s, t]: [f64; 2]) -> [f64; 2] {
        let edge = 1.0 / f64::from(1u32 << self.level);
        let (u, v) = ((f64::from(self.i) + s) * edge, (f64::from(self.j) + t) * edge);
        place_in_face(self.corner, [u, v])
    }
}

/// Parameters counted from a corner of a face, as those of the face itself.
pub(crate) fn place_in_face(corner: u8, [u, v]: [f64; 2]) -> [f64; 2] {
    match corner {
        1 => [1.0 - u - v, u],
        2 => [v, 1.0 - u - v],
        _ => [u, v],
    }
}

/// Lit area, square metres: the truth lies in `lower..=upper`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LitArea {
    /// Proved lit, rounded down.
    pub lower: f64,
    /// Not proved shadowed, rounded up.
    pub upper: f64,
    /// The lower area plus the lit share of 16 points in every undecided cell.
    pub estimate: f64,
}

/// Exact answers on the lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleCount {
    /// How many samples.
    pub samples: u64,
    /// How many of them are lit.
    pub lit: u64,
}

impl AddAssign for SampleCount {
    fn add_assign(&mut self, other: Self) {
        self.samples += other.samples;
        self.lit += other.lit;
    }
}

/// The answer to each sample of an object, a bit each, in the order of [`for_each_sample`](crate::for_each_sample).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SampleAnswers {
    words: Vec<u64>,
    len: u64,
}

impl SampleAnswers {
    /// Adds up to 64 answers: the low `count` bits, lowest first; higher ones are zero.
    pub(crate) fn push(&mut self, bits: u64, count: u32) {
        let shift = (self.len % 64) as u32;
        if shift == 0 {
            self.words.push(0);
        }
        *self.words.last_mut().expect("just made") |= bits << shift;
        if shift + count > 64 {
            self.words.push(bits >> (64 - shift));
        }
        self.len += u64::from(count);
    }

    /// How many samples.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Whether sample `index` is lit; `false` beyond the last.
    pub fn is_lit(&self, index: u64) -> bool {
        self.words.get((index / 64) as usize).is_some_and(|word| word >> (index % 64) & 1 == 1)
    }
}

/// One object under one light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectReport {
    /// Index into the scene's objects.
    pub object: usize,
    /// Surface area, square metres, each face once.
    pub area: f64,
    /// By how much the true area may differ from `area`, square metres; infinite where nothing is known of some face.
    pub area_error: f64,
    /// How much of it is lit.
    pub lit: LitArea,
    /// The stored cells if they were asked for, in the order of faces and, within a face, of Morton codes.
    pub cells: Vec<Cell>,
    /// The samples, if asked for.
    pub samples: Option<SampleCount>,
    /// Each sample's answer, if the request keeps cells and its detail is [`Detail::Faces`](crate::Detail::Faces); only
    /// for flat objects that no curved body may shadow.
    pub answers: Option<SampleAnswers>,
}

impl ObjectReport {
    /// Area that is neither proved lit nor proved shadowed, square metres.
    pub fn undecided(&self) -> f64 {
        self.lit.upper - self.lit.lower
    }
}

/// All asked objects under one light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightReport {
    /// Index into the scene's lights.
    pub light: usize,
    /// One report a receiver, in the order of the request.
    pub objects: Vec<ObjectReport>,
}

/// What was done; the names are those of the JSON contract.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Pairs of boxes tested for influence; of equal objects (same shape, same place) one is looked at. Where too much lies over everything to go through
    /// all pairs of objects, this and the next two are those that were looked at.
    pub pairs_tested: u64,
    /// Pairs of objects that may shadow one another; equal ones count each.
    pub pairs_registered: u64,
    /// Pairs left out because the opposite direction is proved to exclude them; of equal objects one is looked at.
    pub pairs_excluded: u64,
    /// Receivers whose surface was divided into cells; equal ones have one answer and count once.
    pub octrees_built: u64,
    /// Cells examined; of equal receivers once.
    pub cells: u64,
    /// Points decided one by one; of equal receivers once.
    pub rays: u64,
    /// Decisions that went to exact arithmetic; where a mesh has instances, some are made once more or less by chance.
    pub exact_fallbacks: u64,
    /// Lights for which the effort was spent before the detail was reached ([`Request::effort`](crate::Request::effort)).
    pub lights_cut_short: u64,
    /// Receivers, each under each light, some of whose surface is undecided because too much lies over too many faces to measure all of it; of equal ones once.
    pub objects_crowded: u64,
    /// What cells and portals spared; zeros in a scene without them.
    pub portals: PortalWork,
}

/// What the lights of a scene with cells reach, added up over the lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PortalWork {
    /// Cells that light enters.
    pub cells: u64,
    /// Times that light passes a portal.
    pub passages: u64,
    /// Objects that light may reach, which are modelled.
    pub objects: u64,
    /// Objects that no light of a lamp can reach: as occluders they are not modelled at all.
    pub objects_left_out: u64,
    /// Asked receivers among these: all of their surface is in shadow, and only its area is computed.
    pub receivers_left_out: u64,
    /// Lights that reach none of the asked receivers; for these, nothing else is modelled.
    pub lights_left_out: u64,
    /// Lights in no cell, which are taken to reach everything.
    pub lights_outside: u64,
}

impl AddAssign for PortalWork {
    fn add_assign(&mut self, other: Self) {
        self.cells += other.cells;
        self.passages += other.passages;
        self.objects += other.objects;
        self.objects_left_out += other.objects_left_out;
        self.receivers_left_out += other.receivers_left_out;
        self.lights_left_out += other.lights_left_out;
        self.lights_outside += other.lights_outside;
    }
}

impl Work {
    /// Adds what was done elsewhere.
    pub(crate) fn add(&mut self, other: &Self) {
        self.pairs_tested += other.pairs_tested;
        self.pairs_registered += other.pairs_registered;
        self.pairs_excluded += other.pairs_excluded;
        self.octrees_built += other.octrees_built;
        self.cells += other.cells;
        self.rays += other.rays;
        self.exact_fallbacks += other.exact_fallbacks;
        self.lights_cut_short += other.lights_cut_short;
        self.objects_crowded += other.objects_crowded;
        self.portals += other.portals;
    }
}

/// Wall time of the phases, seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Time {
    /// The coarse step.
    pub coarse: f64,
    /// The fine step.
    pub fine: f64,
}

/// The whole answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// One report a light, in the order of the request.
    pub lights: Vec<LightReport>,
    /// Counters.
    pub work: Work,
    /// Wall times.
    pub time: Time,
}
