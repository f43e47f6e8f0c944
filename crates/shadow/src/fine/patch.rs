//! The fine step on one patch of a placed analytic body.
//!
//! A cell of a patch lies in the hull of eight points ([`Chart::hull`]); signs over the hull are signs over the cell ("curved
//! cells use outward depth bounds"). Whether the surface faces the light, and what the own body hides of it: [`SelfShadow`].

use glam::DVec3;
use umbriel_geometry::{
    Aabb, Approx, PlacedAnalytic, Point,
    analytic::{CellHull, Chart, HULL, Occupied, PatchArea},
};
use umbriel_octree::Quadrant;

use super::{
    Candidates, Occluders, Receiver,
    classify::Hull,
    field::Weights,
    flat::{Levels, PixelStop},
    lattice::Lattice,
    occluders::{Among, swarm::Above},
    pattern,
    pile::{BodiesOver, Pile},
    polygon_blocker::FacetId,
    self_shadow::{Facing, SelfShadow},
    tally::{Measure, Tally},
};
use crate::{
    effort::{MEASURED, PARTS, Spend},
    report::{Cell, Verdict},
};

/// One patch and all that may shadow it.
pub(crate) struct Patch<'a> {
    pub(crate) face: u32,
    pub(crate) object: u32,
    pub(crate) body: &'a PlacedAnalytic,
    /// The body's world box.
    pub(crate) bounds: Aabb,
    pub(crate) is_one_sided: bool,
    /// Three exact points of the patch's plane, if it is flat.
    pub(crate) plane: Option<[Point<'a>; 3]>,
    pub(crate) area: &'a PatchArea<'a>,
    pub(crate) occluders: &'a Occluders<'a>,
    /// What may shadow it; of curved bodies nothing goes by these where there is a swarm.
    pub(crate) among: Among<'a>,
    pub(crate) swarm: Option<Above<'a>>,
    pub(crate) levels: Levels,
    pub(crate) lattice: Option<Lattice>,
    /// The exact answer for a point (u, v) of the patch; `None` where there is no surface.
    pub(crate) is_lit_exactly: &'a (dyn Fn(f64, f64) -> Option<bool> + Sync),
    /// The same were the body alone.
    pub(crate) is_lit_alone_exactly: &'a (dyn Fn(f64, f64) -> Option<bool> + Sync),
    pub(crate) spend: Spend<'a>,
}

/// What a curved cell costs beside what is over it, and the density of its area at a point, in facets held against a cell.
const CELL: u64 = 24;
const TRIMMED_CELL: u64 = 48;
const DENSITY: u64 = 4;

/// How many times what is over a cell is looked up in the time in which a body in the way of each of 16 points is.
const LOOKED_UP_FOR_POINTS: u64 = 3;

/// Bodies that floats ask of a point in the time in which a facet is held against a cell.
const ASKED_A_FACET: u64 = 4;

/// How often a cell is divided before it is asked whether that tells anything.
const LEVELS_BEFORE_LOOKING: u8 = 4;

/// Cells of every second level are looked at by their finest parts.
const LEVELS_BETWEEN_LOOKS: u8 = 2;

/// Fewer levels above the finest one a cell has hardly more finest parts than would be looked at.
const LEVELS_BELOW_LOOKING: u8 = 3;

/// From this many facets in question, it is sooner to look up those over a point than to ask each.
const LOOK_UP: usize = 64;

/// What may shadow a cell.
#[derive(Clone, Debug, Default)]
struct Question<'a> {
    facets: Vec<FacetId>,
    bodies: BodiesOver<'a>,
}

impl Patch<'_> {
    /// Classifies the whole patch.
    pub(crate) fn run(&self) -> Tally<Approx> {
        let mut tally = Tally::new();
        let hull = self.hull(Quadrant::ROOT).placed(self.body.placement());
        let Candidates { facets, mut bodies } = self.occluders.candidates(self.among, &hull);
        bodies.retain(|&object| object != self.object);
        if !(self.spend)(MEASURED * facets.len() as u64) {
            // Nobody takes what is found.
            return tally;
        }
        let above = self.swarm.as_ref().map(|above| self.occluders.counted(above, &hull));
        let bodies = above.as_ref().map_or(BodiesOver::Few(bodies), BodiesOver::Many);
        self.divide((Quadrant::ROOT, Occupied::Partly), None, &Question { facets, bodies }, &mut tally);
        tally
    }

    /// The body and the light.
    fn self_shadow(&self) -> SelfShadow<'_> {
        SelfShadow {
            body: self.body,
            surface: self.chart().surface,
            plane: self.plane.as_ref(),
            is_one_sided: self.is_one_sided,
            source: self.occluders.light,
            light: self.occluders.light_at(self.object, self.body),
        }
    }

    fn chart(&self) -> &Chart {
        &self.body.charts()[self.face as usize]
    }

    /// How much of a cell is surface; `within` tells it of a cell that it is a part of. Where a quadric touches its box the surface alone does not tell, but there is
    /// none outside of the body's own box.
    fn occupied(&self, place: Quadrant, within: Occupied) -> Occupied {
        if within == Occupied::Whole {
            return within;
        }
        let is_within_reach = || {
            let points = self.hull(place).placed(self.body.placement());
            points.iter().map(Point::bounds).fold(Aabb::EMPTY, Aabb::union).meets(&self.bounds)
        };
        match self.chart().occupied(place.low_corner(), place.edge()) {
            Occupied::Partly if !is_within_reach() => Occupied::Nowhere,
            occupied => occupied,
        }
    }

    /// Whether a cell is not divided any more, since of none of its 64 parts anything is told: a border runs through some of them only, and so do the two or three rows of
    /// parts along which a body touches its box, but where surfaces that all but coincide, or all but run along the light, are less than roundings apart, all levels say nothing.
    fn is_blurred(&self, place: Quadrant, occupied: Occupied) -> bool {
        let mut parts = place.children().flat_map(Quadrant::children).flat_map(Quadrant::children);
        place.level() > 0 && place.level() >= LEVELS_BEFORE_LOOKING && parts.all(|part| !self.is_told(part, occupied))
    }

    /// Whether an undecided cell, surface all over, is not divided any more, since of its finest parts at 16 points all over it none is decided: a border runs through some
    /// parts only, but where another surface is closer than the finest cells are curved, hardly any part is ever told. What is undecided at a finer level is so at a coarser
    /// one: a finer level gives up no cell that a coarser one divides. (Of a swarm hardly any: what promises most differs from cell to cell.)
    fn is_unclear_to_the_end(&self, place: Quadrant, question: &Question) -> bool {
        let (level, finest) = (place.level(), self.levels.finest);
        if level < LEVELS_BEFORE_LOOKING || level % LEVELS_BETWEEN_LOOKS != 0 || level + LEVELS_BELOW_LOOKING > finest {
            return false;
        }
        let ([u, v], edge) = (place.low_corner(), place.edge());
        let number = |parameter: f64| (parameter * 2f64.powi(i32::from(finest))) as u32;
        if !(self.spend)(pattern::POINTS as u64 * (CELL + question.facets.len() as u64)) {
            return false;
        }
        let mut parts = pattern::points(place).filter_map(|[s, t]| {
            let at = [number(u + s * edge), number(v + t * edge)];
            Quadrant::at(finest, at)
        });
        parts.all(|part| self.judge(part, question, false).0 == Verdict::Undecided)
    }

    /// Whether it is known of a part of a cell that it is no surface, or that it is, and what the body does to the light on it.
    fn is_told(&self, part: Quadrant, within: Occupied) -> bool {
        match self.occupied(part, within) {
            Occupied::Nowhere => true,
            Occupied::Partly => false,
            Occupied::Whole => self.self_shadow().facing(&self.hull(part)) != Facing::Unknown,
        }
    }

    /// Parts of a cell that is decided are only divided where they are partly surface, for their areas; `known` is that
    /// verdict. `within` tells how much of the cell that is divided is surface: all parts of a whole one are whole.
    fn divide<'s>(
        &'s self,
        (place, within): (Quadrant, Occupied),
        known: Option<Verdict>,
        question: &Question<'s>,
        tally: &mut Tally<Approx>,
    ) {
        let occupied = self.occupied(place, within);
        if occupied == Occupied::Nowhere {
            return;
        }
        tally.examined += 1;
        let is_divisible = !self.is_finest(place);
        let (mut verdict, mut left) = match known {
            Some(verdict) => (verdict, Question::default()),
            None => self.judge(place, question, is_divisible),
        };
        let is_open = occupied == Occupied::Partly || verdict == Verdict::Undecided;
        let is_unclear = || {
            let is_asked = occupied == Occupied::Whole && verdict == Verdict::Undecided;
            is_asked && self.is_unclear_to_the_end(place, &left)
        };
        let is_given_up = is_divisible && (is_open && self.is_blurred(place, occupied) || is_unclear());
        if is_given_up && known.is_none() {
            // As if it were the finest level, so that a finer one tells no less.
            (verdict, left) = self.judge(place, question, false);
        }
        let is_decided = verdict != Verdict::Undecided;
        let whole = || self.area_of(place);
        let counted = || self.area_to_count(place, is_decided, occupied);
        if let Some(area) = if is_given_up { Some(whole()) } else { counted() } {
            self.count((place, occupied), verdict, &area, &left, tally);
        } else if (self.spend)(PARTS * (self.cost_of_cell() + left.facets.len() as u64)) {
            for part in place.children() {
                self.divide((part, occupied), is_decided.then_some(verdict), &left, tally);
            }
        }
    }

    /// What a cell costs beside what is over it.
    fn cost_of_cell(&self) -> u64 {
        if self.chart().is_trimmed() { TRIMMED_CELL } else { CELL }
    }

    fn area_of(&self, place: Quadrant) -> Approx {
        let (area, points) = self.area.of_cell_counted(place.low_corner(), place.edge());
        if points > 0 {
            // What is spent in vain ends at the next division.
            (self.spend)(DENSITY * points);
        }
        area
    }

    /// The area of a cell, unless it is to be divided. Cells that may be kept are surface all over, as far as the detail goes; sums are the same where none are.
    fn area_to_count(&self, place: Quadrant, is_decided: bool, occupied: Occupied) -> Option<Approx> {
        let (at, edge) = (place.low_corner(), place.edge());
        if is_decided && occupied == Occupied::Whole || self.is_finest(place) {
            Some(self.area_of(place))
        } else if is_decided && place.level() > self.levels.interior {
            self.area.of_cut_cell(at, edge, 0.5f64.powi(i32::from(self.levels.finest)))
        } else {
            None
        }
    }

    /// Whether a cell is not divided any more.
    fn is_finest(&self, place: Quadrant) -> bool {
        let is_a_pixel = |stop: PixelStop| {
            let points = self.hull(place).placed(self.body.placement());
            stop.is_met(place.level(), points.iter().map(|point| point.position).sum::<DVec3>() / HULL as f64)
        };
        place.level() == self.levels.finest || self.levels.pixel.is_some_and(is_a_pixel)
    }

    /// What is proved of a cell, and what is in question if it is undecided.
    fn judge<'s>(&'s self, place: Quadrant, question: &Question<'s>, is_divisible: bool) -> (Verdict, Question<'s>) {
        let hull = self.hull(place);
        let points = hull.placed(self.body.placement());
        match self.self_shadow().facing(&hull) {
            Facing::Dark => (Verdict::Shadowed, Question::default()),
            Facing::Turned => self.classify(place, points, question, is_divisible),
            Facing::Unknown => match self.classify(place, points, question, is_divisible) {
                (Verdict::Lit, left) => (Verdict::Undecided, left),
                judged => judged,
            },
        }
    }

    /// What others do to a cell in the hull of some points.
    fn classify<'s>(
        &'s self,
        place: Quadrant,
        points: [Point; HULL],
        question: &Question<'s>,
        is_divisible: bool,
    ) -> (Verdict, Question<'s>) {
        let unit = |k: usize| -> Weights<HULL> { std::array::from_fn(|l| f64::from(u8::from(k == l))) };
        let cell = Hull::new((0..HULL).map(unit), [1.0 / HULL as f64; HULL]);
        let receiver = Receiver { points, light: self.occluders.light, facing: None, plane: self.plane };
        let ([u, v], half) = (place.low_corner(), 0.5 * place.edge());
        let pile = Pile {
            occluders: self.occluders,
            receiver: &receiver,
            corners: cell.corners(),
            middle: &self.point([u + half, v + half]),
            is_divisible,
            spend: self.spend,
        };
        let Some(bodies) = pile.in_question(&question.bodies) else {
            return (Verdict::Shadowed, Question::default());
        };
        let mut left = Question { bodies, facets: Vec::new() };
        let blockers = self.occluders.blockers(&question.facets, &[], &receiver);
        let mut entries = Vec::new();
        let under_facets = blockers.classify(&cell, &blockers.entries(), &mut entries);
        left.facets = entries.into_iter().map(|entry| blockers.id(entry)).collect();
        match under_facets {
            Verdict::Lit if !left.bodies.is_none() => (Verdict::Undecided, left),
            verdict => (verdict, left),
        }
    }

    fn hull(&self, place: Quadrant) -> CellHull {
        self.chart().hull(place.low_corner(), place.edge())
    }

    /// How many of 16 points of an undecided cell are likely to be lit, by floats, with this in question.
    fn count_probably_lit(&self, (place, occupied): (Quadrant, Occupied), left: &Question) -> u64 {
        let ([u, v], edge) = (place.low_corner(), place.edge());
        let is_turned = self.self_shadow().facing(&self.hull(place)) == Facing::Turned;
        let is_lit_alone = |[u, v]: [f64; 2]| match is_turned {
            true => occupied == Occupied::Whole || self.chart().occupied([u, v], 0.0) != Occupied::Nowhere,
            false => (self.is_lit_alone_exactly)(u, v) == Some(true),
        };
        let mut last = None;
        let is_lit = |&[s, t]: &[f64; 2]| {
            let at = [u + s * edge, v + t * edge];
            is_lit_alone(at) && self.is_probably_clear(&self.point(at), left, &mut last)
        };
        pattern::points(place).filter(is_lit).count() as u64
    }

    /// Whether floats say that nothing is in a point's way. The body that was in the last one's way is asked first: it is likely to be in the next one's, too.
    fn is_probably_clear(&self, point: &Receiver<1>, question: &Question, last: &mut Option<u32>) -> bool {
        let hides = |object: &u32| self.occluders.probably_blocks(*object, point);
        *last = match &question.bodies {
            BodiesOver::Few(bodies) => last.filter(hides).or_else(|| bodies.iter().copied().find(hides)),
            BodiesOver::Many(above) => {
                // How many were asked in vain goes by no order; it is spent where the next cell is divided.
                let hiding = self.occluders.probably_hides(above, point, *last);
                hiding.map_err(|asked| (self.spend)(asked / ASKED_A_FACET)).ok()
            }
        };
        last.is_none() && !self.is_probably_behind(&question.facets, point)
    }

    /// Whether floats say that one of some facets is in a point's way.
    fn is_probably_behind(&self, facets: &[FacetId], point: &Receiver<1>) -> bool {
        let looked_up = (facets.len() >= LOOK_UP).then(|| self.occluders.candidates(self.among, &point.points).facets);
        let blockers = self.occluders.blockers(looked_up.as_deref().unwrap_or(facets), &[], point);
        blockers.entries().into_iter().any(|entry| blockers.probably_blocks(entry, &[1.0]))
    }

    /// A point of the patch.
    fn point(&self, [u, v]: [f64; 2]) -> Receiver<'_, 1> {
        let points = [self.chart().bounded_point(self.body.placement(), u, v)];
        Receiver { points, light: self.occluders.light, facing: None, plane: self.plane }
    }

    fn count(
        &self,
        (place, occupied): (Quadrant, Occupied),
        verdict: Verdict,
        area: &Approx,
        left: &Question,
        tally: &mut Tally<Approx>,
    ) {
        match verdict {
            Verdict::Lit => tally.lit.add(area),
            Verdict::Shadowed => tally.shadowed.add(area),
            Verdict::Undecided => {
                if let BodiesOver::Many(above) = &left.bodies {
                    // What is spent in vain ends at the next division.
                    (self.spend)(LOOKED_UP_FOR_POINTS * above.cost());
                }
                tally.undecided.add(area);
                tally.likely.add(&area.part(self.count_probably_lit((place, occupied), left)));
                tally.points += 16;
            }
        }
        if self.levels.keeps(place, verdict) {
            tally.cells.push(Cell::new(self.face, 0, place, verdict));
        }
        for [u, v] in self.lattice.iter().flat_map(|lattice| lattice.points(place)) {
            let is_whole = self.chart().occupied([u, v], 0.0) == Occupied::Whole;
            let lit = match verdict {
                Verdict::Lit if is_whole => Some(true),
                Verdict::Shadowed if is_whole => Some(false),
                _ => {
                    tally.points += 1;
                    (self.is_lit_exactly)(u, v)
                }
            };
            tally.samples.samples += u64::from(lit.is_some());
            tally.samples.lit += u64::from(lit == Some(true));
        }
    }
}
