//! The asked receivers under one light, cut into jobs of some faces each.

use std::{borrow::Cow, ops::Range, sync::Arc};

use umbriel_geometry::{
    Approx, Facet, Facets, LightSource, PlacedAnalytic, Point, Surd, analytic::PatchArea, blocking::Probe,
};

use crate::{
    bake::Stage,
    bodies::{Bodies, Body},
    by_object::ByObject,
    coarse::Influences,
    effort::Spend,
    exact::{Own, face_blocks, patch_probe, turned_to},
    fine::{
        Candidates, Occluders,
        crowd::{self, Members},
        flat::{FLAT, Levels},
        lattice::{Lattice, Spacing},
        occluders::{
            Among,
            swarm::{Above, MANY, Swarm},
            throng::Throng,
        },
        patch::Patch,
        tally::{Cost, Tally, Units, cell_units},
    },
    flat_receiver::FlatReceiver,
    levels,
    report::{Cell, LitArea, ObjectReport, SampleCount},
    request::{Detail, Request},
    sums::{AreaSums, ExactSum, FaceArea},
    tickets::halvings,
};

/// Faces that one job takes.
const FACES_PER_JOB: usize = 64;

/// Some faces of one receiver.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    /// Index into the request's receivers.
    pub(crate) receiver: usize,
    pub(crate) faces: Range<usize>,
}

/// How deep a look at a face goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Depth {
    /// As far as the detail says.
    Asked,
    /// Down to this level at most.
    To(u8),
    /// Down to this level, or deeper where measuring what may shadow the face costs more than the cells there.
    Paying(u8),
}

/// A first look goes so deep at least: finding what may shadow a face costs as much.
const FIRST_LEVEL: u8 = 4;

/// The level of which the cells cost as much as measuring [`MEASURED`] facets and bodies; they are twice as many a level.
const PAID_LEVEL: u8 = 2;
const MEASURED: usize = 16;

/// The deepest level of a first look.
const DEEPEST_FIRST: u8 = 8;

/// The level of a first look at a face under so many facets and bodies.
pub(crate) fn first_level(measured: usize) -> u8 {
    let paid = PAID_LEVEL + (1 + measured / MEASURED).ilog2() as u8;
    paid.clamp(FIRST_LEVEL, DEEPEST_FIRST)
}

impl Depth {
    /// The level, if it is not the detail's, of a face under so many facets and bodies.
    pub(crate) fn level(self, measured: usize) -> Option<u8> {
        match self {
            Self::Asked => None,
            Self::To(level) => Some(level),
            Self::Paying(level) => Some(level.max(first_level(measured))),
        }
    }
}

/// What a look at one face found out.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) area: FaceArea,
    pub(crate) cells: Vec<Cell>,
    pub(crate) samples: SampleCount,
    /// Cells examined.
    pub(crate) examined: u64,
    /// Points decided one by one.
    pub(crate) points: u64,
    pub(crate) cost: Cost,
    /// Whether some is undecided because the face is in a crowd.
    pub(crate) is_crowded: bool,
}

/// What was found out about some faces.
#[derive(Debug, Default)]
pub(crate) struct FaceSums {
    pub(crate) areas: AreaSums,
    pub(crate) cells: Vec<Cell>,
    pub(crate) samples: SampleCount,
    pub(crate) examined: u64,
    pub(crate) points: u64,
    /// Whether any face had to be divided.
    pub(crate) divided: bool,
    /// Whether some is undecided because faces are in a crowd.
    pub(crate) is_crowded: bool,
}

/// All receivers of a request under one light.
pub(crate) struct Receivers<'a> {
    pub(crate) bodies: &'a Bodies<'a>,
    pub(crate) light: &'a LightSource,
    pub(crate) request: &'a Request,
    pub(crate) detail: Detail,
    /// What the light has of its own.
    own: Option<Detail>,
    pub(crate) influences: &'a Influences<'a>,
    pub(crate) occluders: Occluders<'a>,
    /// How far apart samples are.
    pub(crate) spacing: Option<Spacing>,
    /// The faces of each object that are a crowd, once that is asked.
    crowds: Arc<ByObject<Option<Members>>>,
    /// Whether there is not enough effort for the detail: areas are only integrated roughly.
    pub(crate) is_cut_short: bool,
    /// The whole scene, if all of it is one.
    pub(crate) throng: Option<Arc<Throng>>,
    /// The curved bodies, where a receiver may have more of them over it than are listed.
    swarm: Option<Arc<Swarm>>,
}

impl<'a> Receivers<'a> {
    /// Builds nothing yet but the trees of a throng and of a swarm, if the scene is one.
    pub(crate) fn new(
        stage: &'a Stage<'a>,
        occluders: Occluders<'a>,
        own: Option<Detail>,
        influences: &'a Influences<'a>,
        is_throng: bool,
    ) -> Self {
        let Stage { bodies, request, spacing, coarse, .. } = stage;
        let crowds = Arc::new(ByObject::new(bodies.scene.objects.len()));
        let throng = is_throng.then(|| Arc::new(Throng::new(&occluders, coarse.occluders())));
        let is_curved = |&object: &usize| bodies.is_analytic(object);
        let may_be_swarm =
            (is_throng || influences.has_longer_list_than(MANY)) && request.receivers.iter().any(is_curved);
        let swarm = may_be_swarm.then(|| Swarm::new(&occluders, coarse.occluders())).flatten().map(Arc::new);
        let (light, detail) = (occluders.light, request.detail);
        Self {
            bodies,
            light,
            request,
            detail,
            own,
            influences,
            occluders,
            spacing: *spacing,
            crowds,
            is_cut_short: false,
            throng,
            swarm,
        }
    }

    /// The same with instances in `bodies`, which are those of a group ([`Bodies::of_group`]).
    pub(crate) fn of_group<'g>(&'g self, bodies: &'g Bodies<'g>) -> Receivers<'g> {
        let all: &Receivers<'g> = self;
        Receivers {
            bodies,
            occluders: Occluders::of_group(bodies, &self.occluders),
            crowds: Arc::clone(&self.crowds),
            throng: self.throng.clone(),
            swarm: self.swarm.clone(),
            ..*all
        }
    }

    /// Builds what the faces of these receivers look through time and again: over a face lie mostly faces of the same object, and the tree that its instances
    /// share takes five times as long to look through.
    pub(crate) fn prepare(&self, group: &[usize]) {
        let objects = group.iter().map(|&receiver| self.request.receivers[receiver]);
        if self.throng.is_none() {
            let instances = objects.filter(|&object| self.bodies.is_instance(object));
            self.occluders.prepare(instances.map(|object| object as u32).collect());
        }
    }

    /// The jobs of a receiver, in the order of its faces; the patches of a curved body one by one.
    pub(crate) fn jobs_of(&self, receiver: usize) -> impl ExactSizeIterator<Item = Job> + use<> {
        let object = self.request.receivers[receiver];
        let faces = self.bodies.face_count(object);
        let step = if self.bodies.is_analytic(object) { 1 } else { FACES_PER_JOB };
        (0..faces).step_by(step).map(move |first| Job { receiver, faces: first..(first + step).min(faces) })
    }

    /// Classifies the faces of a job, and with them all copies of them; those that are left when nothing more may be spent are left out.
    pub(crate) fn run(&self, job: &Job, spend: Spend) -> FaceSums {
        let mut sums = FaceSums::default();
        let copied = self.copied(self.request.receivers[job.receiver]);
        let is_copy = |face: usize| copied.is_some_and(|facets| facets.is_copy(face));
        for face in job.faces.clone().filter(|&face| !is_copy(face)).take_while(|_| spend(1)) {
            if let Some(found) = self.look(job.receiver, face, Depth::Asked, spend) {
                let copies = copied.into_iter().flat_map(|facets| facets.copies(face));
                copies.for_each(|copy| sums.add(found.of_copy(copy)));
                sums.add(found);
            }
        }
        sums
    }

    /// The facets of an object if some are copies: these have the answers of the first ones, as what lies in a face's plane never shadows it, whatever its holes.
    fn copied(&self, object: usize) -> Option<&Facets> {
        match self.bodies.get(object) {
            Body::Flat(facets) if facets.repeat_count() > 0 => Some(facets),
            _ => None,
        }
    }

    /// Puts the cells of an object's faces in the order of the faces: those of copies came with the first ones.
    pub(crate) fn sort_cells(&self, receiver: usize, cells: &mut [Cell]) {
        if self.copied(self.request.receivers[receiver]).is_some() {
            cells.sort_by_key(|cell| cell.face);
        }
    }

    /// Classifies a face. `None` for a face without area.
    pub(crate) fn look(&self, receiver: usize, face: usize, depth: Depth, spend: Spend) -> Option<Found> {
        let object = self.request.receivers[receiver];
        match self.bodies.get(object) {
            Body::Flat(facets) if facets.area(face).upper() == 0.0 => None,
            Body::Flat(facets) => {
                let tally = FlatReceiver::new(self, object, (facets, face), depth, spend).run();
                Some(Found::on_flat(facets, face, tally))
            }
            Body::Analytic(body) => Some(Found::on_patch(self.look_at_patch(object, (body, face), depth, spend))),
        }
    }

    /// How deep to divide a face of this size, and what to keep; down to `level` at most if that is given.
    pub(crate) fn levels(&self, object: usize, size: &levels::FaceSize, level: Option<u8>) -> Levels {
        let own = self.request.own.objects.get(&object).copied().or(self.own);
        let own = own.filter(|own| own.is_fixed() && self.detail != Detail::Faces);
        let detail = own.unwrap_or(self.detail);
        let levels = levels::of_face(detail, self.request.keep_cells, &self.bodies.bounds(object), size);
        let finest = level.map_or(levels.finest, |level| level.min(levels.finest));
        Levels { finest, ..levels }
    }

    /// An object's faces as a crowd, if there are too many pairs of them and of what is over them, among the facets of `occluders`, to measure them all.
    pub(crate) fn crowd_of(&self, object: usize, facets: &Facets, occluders: &[u32]) -> Option<Members> {
        *self.crowds.get_or_init(object, || {
            let of_occluders = occluders.iter().map(|&object| self.bodies.distinct_faces(object as usize)).sum();
            let allowed = crowd::allowed(facets.len(), of_occluders);
            let among = Among::Objects(occluders);
            let over = |face: usize, most| self.occluders.burden_of_face(among, (object, facets, face), most);
            let halvings = || self.occluders.tickets(object as u32).iter().map(|&ticket| halvings(ticket));
            let is_crowd = facets.len().saturating_mul(of_occluders) > allowed
                && crowd::is_crowd(&halvings().collect::<Vec<_>>(), allowed, over);
            is_crowd.then(|| Members::of_receiver(facets.len(), area_of(facets)))
        })
    }

    fn look_at_patch(
        &self,
        object: usize,
        (body, face): (&PlacedAnalytic, usize),
        depth: Depth,
        spend: Spend,
    ) -> Tally<Approx> {
        let chart = &body.charts()[face];
        let size = levels::FaceSize::of_patch(chart, body.placement());
        // Nothing may shadow what no light reaches.
        let above = self.swarm.as_deref().filter(|_| !self.bodies.is_dark(object)).map(|swarm| {
            let own = self.influences.first_of(object);
            swarm.above(self.bodies.bounds(object), self.light, own as u32)
        });
        let objects = self.throng.is_none().then(|| self.objects_over_patch(object));
        let among = self.among(objects.as_deref());
        let with_own = |u: f64, v: f64, is_blocked: &dyn Fn(Own, &Probe<Surd>) -> bool| {
            let probe = patch_probe(body, face, u, v)?;
            let own = turned_to(self.bodies, object, chart.surface, &probe, self.light);
            Some(own.is_some_and(|own| !is_blocked(own, &probe)))
        };
        let own_blocks = |own: Own, probe: &Probe<Surd>| face_blocks(self.bodies, (object, 0), probe, own, self.light);
        let is_blocked = |own: Own, probe: &Probe<Surd>| {
            above.is_some() && own_blocks(own, probe) || self.point_is_blocked((among, above.as_ref()), own, probe)
        };
        let exact = chart.plane_points().map(|points| points.map(|local| body.placement().exact(local)));
        let plane = exact.as_ref().map(|points| std::array::from_fn(|k| points[k].bounded()));
        let levels = self.levels(object, &size, depth.level(0));
        let area = PatchArea::new(chart, body.placement());
        let area = &if self.is_cut_short { area.rough() } else { area };
        let patch = Patch {
            face: face as u32,
            object: object as u32,
            body,
            bounds: self.bodies.bounds(object),
            is_one_sided: self.bodies.is_one_sided(object, face),
            plane,
            area,
            occluders: &self.occluders,
            among,
            swarm: above,
            levels,
            lattice: self.spacing.map(|spacing| Lattice::new(size.edges, spacing, false)),
            is_lit_exactly: &|u, v| with_own(u, v, &is_blocked),
            is_lit_alone_exactly: &|u, v| with_own(u, v, &own_blocks),
            spend,
        };
        let mut tally = patch.run();
        tally.cost = Cost { level: levels.finest, base: 0, cells: tally.examined };
        if self.bodies.is_dark(object) {
            tally.darken();
        }
        tally
    }

    /// What is looked through for what may shadow a receiver: these objects, unless the scene is a throng.
    pub(crate) fn among<'s>(&'s self, objects: Option<&'s [u32]>) -> Among<'s> {
        match &self.throng {
            Some(throng) => Among::Throng(throng),
            None => Among::Objects(objects.unwrap_or_default()),
        }
    }

    /// Objects that may shadow a patch, those of a swarm left out.
    fn objects_over_patch(&self, object: usize) -> Cow<'_, [u32]> {
        let all = || self.influences.occluders_of(object as u32);
        self.swarm.as_ref().map_or_else(all, |swarm| swarm.others(all))
    }

    /// Whether anything of these blocks the way from a point to the light, curved bodies of the swarm if there is one. Exact.
    fn point_is_blocked(&self, (among, above): (Among, Option<&Above>), own: Own, probe: &Probe<Surd>) -> bool {
        let blocks = |face: (usize, usize)| face_blocks(self.bodies, face, probe, own, self.light);
        let body_blocks = |object: u32| blocks((object as usize, 0));
        let Candidates { facets, bodies } = self.occluders.candidates(among, &[probe.bounds]);
        let any_body_blocks = || match above {
            Some(above) => self.occluders.any_above(above, &[probe.bounds], body_blocks),
            None => bodies.into_iter().any(body_blocks),
        };
        facets.iter().any(|id| blocks((id.object as usize, id.facet as usize))) || any_body_blocks()
    }
}

impl Found {
    fn on_flat(facets: &Facets, face: usize, tally: Tally<Units>) -> Self {
        let area = facets.area(face);
        let all = cell_units(0, matches!(facets.facet(face), Facet::Triangle(_)));
        let share = |units: Units| scaled(area, units, all);
        let possible = share(all - tally.shadowed.min(all));
        let face = FaceArea::new(area, share(tally.lit), possible, share(tally.lit + tally.likely));
        Self::of(tally, face)
    }

    fn on_patch(tally: Tally<Approx>) -> Self {
        let possible = tally.lit + tally.undecided;
        let face = FaceArea::new(possible + tally.shadowed, tally.lit, possible, tally.lit + tally.likely);
        Self::of(tally, face)
    }

    /// The same of another face, for which nothing had to be done.
    fn of_copy(&self, face: usize) -> Self {
        let cells = self.cells.iter().map(|&cell| Cell { face: face as u32, ..cell }).collect();
        Self { cells, examined: 0, points: 0, ..*self }
    }

    fn of<M>(tally: Tally<M>, area: FaceArea) -> Self {
        let Tally { cells, samples, examined, points, cost, is_crowded, .. } = tally;
        Self { area, cells, samples, examined, points, cost, is_crowded }
    }
}

impl FaceSums {
    /// Adds a face.
    pub(crate) fn add(&mut self, mut found: Found) {
        self.areas.add(&found.area);
        self.cells.append(&mut found.cells);
        self.samples += found.samples;
        self.examined += found.examined;
        self.points += found.points;
        self.divided |= found.examined > 1;
        self.is_crowded |= found.is_crowded;
    }

    /// Adds other faces. Areas are exact, so the order of faces does not matter to them.
    pub(crate) fn append(&mut self, mut other: Self) {
        self.areas.append(other.areas);
        self.cells.append(&mut other.cells);
        self.samples += other.samples;
        self.examined += other.examined;
        self.points += other.points;
        self.divided |= other.divided;
        self.is_crowded |= other.is_crowded;
    }

    /// What is told of an object whose faces these are.
    pub(crate) fn report(mut self, object: usize, request: &Request) -> ObjectReport {
        // Cells came face by face; what is kept has no room for more.
        self.cells.shrink_to_fit();
        let (area, area_error) = self.areas.area();
        let AreaSums { lower, upper, estimate, .. } = self.areas;
        let (lower, upper) = (lower.rounded_down(), upper.rounded_up());
        ObjectReport {
            object,
            area,
            area_error,
            lit: LitArea { lower, upper, estimate: estimate.nearest().clamp(lower, upper) },
            cells: self.cells,
            samples: request.sampling.map(|_| self.samples),
            answers: None,
        }
    }
}

/// The area of all faces, m², the same whatever their order.
pub(crate) fn area_of(facets: &Facets) -> f64 {
    let mut all = ExactSum::default();
    facets.areas().for_each(|area| all.add(area.value));
    all.nearest()
}

/// The corners of a flat face, from corner `first` of a triangle on: first, second, third (or the first again), last.
pub(crate) fn flat_corners(facets: &Facets, face: usize, first: u8) -> [Point<'_>; FLAT] {
    let point = |corner: u32| facets.point(corner);
    match facets.facet(face) {
        Facet::Triangle(corners) => {
            let [a, b, c] = [0, 1, 2].map(|k| point(corners[(usize::from(first) + k) % 3]));
            [a, b, a, c]
        }
        Facet::Parallelogram(corners) => corners.map(point),
    }
}

/// The area of `units` out of `all`; nothing and everything are exact shares.
fn scaled(area: Approx, units: Units, all: Units) -> Approx {
    if units == all {
        return area;
    }
    let share = units as f64 / all as f64;
    if units == 0 { Approx::exact(0.0) } else { area * Approx { value: share, error: share * f64::EPSILON } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_first_look_goes_deeper_where_more_is_measured() {
        let levels = [0, 3, 7, 15, 1000].map(|times| Depth::Paying(0).level(times * MEASURED));
        assert_eq!(levels, [4, 4, 5, 6, 8].map(Some));
        // What is expected before anything is measured counts as well.
        assert_eq!(Depth::Paying(8).level(MEASURED), Some(8));
        assert_eq!([Depth::Asked, Depth::To(3)].map(|depth| depth.level(100 * MEASURED)), [None, Some(3)]);
    }
}
