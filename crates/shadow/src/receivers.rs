//! The asked receivers under one light, cut into jobs of some faces each.

use std::ops::Range;

use umbriel_bvh::Influences;
use umbriel_geometry::{
    Approx, Facet, Facets, LightSource, PlacedAnalytic, Point, Surd, analytic::PatchArea, blocking::Probe,
};

use crate::{
    bake::Stage,
    bodies::{Bodies, Body},
    exact::{Own, face_blocks, patch_probe, turned_to},
    fine::{
        Occluders,
        flat::FLAT,
        lattice::{Lattice, Spacing},
        patch::Patch,
        tally::{Tally, Units, cell_units},
    },
    flat_receiver::FlatReceiver,
    levels,
    report::{Cell, SampleCount},
    request::{Detail, Request, Sampling},
    sums::{AreaSums, ExactSum},
};

/// Faces that one job takes.
const FACES_PER_JOB: usize = 64;

/// Some faces of one receiver.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    /// Index into the request's receivers.
    pub(crate) receiver: usize,
    faces: Range<usize>,
}

/// What a job found out.
#[derive(Debug, Default)]
pub(crate) struct FaceSums {
    pub(crate) areas: AreaSums,
    pub(crate) cells: Vec<Cell>,
    pub(crate) samples: SampleCount,
    pub(crate) examined: u64,
    pub(crate) points: u64,
    /// Whether any face had to be divided.
    pub(crate) divided: bool,
}

/// All receivers of a request under one light.
pub(crate) struct Receivers<'a> {
    pub(crate) bodies: &'a Bodies<'a>,
    pub(crate) light: &'a LightSource,
    pub(crate) request: &'a Request,
    pub(crate) detail: Detail,
    pub(crate) influences: &'a Influences,
    pub(crate) occluders: Occluders<'a>,
    /// How far apart samples are.
    pub(crate) spacing: Option<Spacing>,
}

impl<'a> Receivers<'a> {
    /// Builds nothing yet.
    pub(crate) fn new(
        stage: &'a Stage<'a>,
        light: &'a LightSource,
        detail: Detail,
        influences: &'a Influences,
    ) -> Self {
        let Stage { bodies, request, spacing, .. } = stage;
        let occluders = Occluders::new(bodies, light);
        Self { bodies, light, request, detail, influences, occluders, spacing: *spacing }
    }

    /// All jobs of the receivers that are `asked`, in the order of receivers and faces.
    pub(crate) fn jobs(&self, asked: impl Fn(usize) -> bool) -> Vec<Job> {
        let mut jobs = Vec::new();
        for (receiver, &object) in self.request.receivers.iter().enumerate().filter(|&(receiver, _)| asked(receiver)) {
            let (faces, step) = match self.bodies.get(object) {
                Body::Flat(facets) => (facets.len(), FACES_PER_JOB),
                Body::Analytic(body) => (body.charts().len(), 1),
            };
            let starts = (0..faces).step_by(step);
            jobs.extend(starts.map(|first| Job { receiver, faces: first..(first + step).min(faces) }));
        }
        jobs
    }

    /// Classifies the faces of a job.
    pub(crate) fn run(&self, job: &Job, is_cancelled: &(dyn Fn() -> bool + Sync)) -> FaceSums {
        let mut sums = FaceSums::default();
        for face in job.faces.clone() {
            match self.bodies.get(self.request.receivers[job.receiver]) {
                Body::Flat(facets) => self.run_flat(job, facets, face, is_cancelled, &mut sums),
                Body::Analytic(body) => self.run_patch(job, body, face, is_cancelled, &mut sums),
            }
        }
        sums
    }

    fn run_flat(
        &self,
        job: &Job,
        facets: &Facets,
        face: usize,
        is_cancelled: &(dyn Fn() -> bool + Sync),
        sums: &mut FaceSums,
    ) {
        let object = self.request.receivers[job.receiver];
        let area = facets.area(face);
        if area.upper() == 0.0 {
            return;
        }
        let is_triangle = matches!(facets.facet(face), Facet::Triangle(_));
        let asked = FlatReceiver::new(self, object, (facets, face), is_cancelled);
        let tally = asked.run();
        let all = cell_units(0, is_triangle);
        let share = |units: Units| scaled(area, units, all);
        let possible = share(all - tally.shadowed.min(all));
        sums.areas.add(area, share(tally.lit), possible, share(tally.lit + tally.likely));
        sums.take(tally);
    }

    fn run_patch(
        &self,
        job: &Job,
        body: &PlacedAnalytic,
        face: usize,
        is_cancelled: &(dyn Fn() -> bool + Sync),
        sums: &mut FaceSums,
    ) {
        let object = self.request.receivers[job.receiver];
        let chart = &body.charts()[face];
        let size = levels::FaceSize::of_patch(chart, body.placement());
        let levels = levels::of_face(self.detail, self.request.keep_cells, &self.bodies.boxes[object], &size);
        let objects = self.influences.occluders_of(object as u32);
        let is_lit_exactly = |u: f64, v: f64| {
            let probe = patch_probe(body, face, u, v)?;
            let own = turned_to(self.bodies, object, chart.surface, &probe, self.light);
            Some(own.is_some_and(|own| !self.point_is_blocked(objects, own, &probe)))
        };
        let exact = chart.plane_points().map(|points| points.map(|local| body.placement().exact(local)));
        let plane = exact.as_ref().map(|points| std::array::from_fn(|k| points[k].bounded()));
        let patch = Patch {
            face: face as u32,
            object: object as u32,
            body,
            is_one_sided: self.bodies.is_one_sided(object, face),
            plane,
            area: &PatchArea::new(chart, body.placement()),
            occluders: &self.occluders,
            objects,
            levels,
            lattice: self.spacing.map(|spacing| Lattice::new(size.edges, spacing, false)),
            is_lit_exactly: &is_lit_exactly,
            is_cancelled,
        };
        let mut tally = patch.run();
        if self.bodies.is_dark(object) {
            tally.darken();
        }
        let possible = tally.lit + tally.undecided;
        let all = possible + tally.shadowed;
        sums.areas.add(all, tally.lit, possible, tally.lit + tally.likely);
        sums.take(tally);
    }

    /// Whether anything among `objects` blocks the way from a point to the light. Exact.
    fn point_is_blocked(&self, objects: &[u32], own: Own, probe: &Probe<Surd>) -> bool {
        let candidates = self.occluders.candidates(objects, &[probe.bounds]);
        let facets = candidates.facets.iter().map(|id| (id.object as usize, id.facet as usize));
        let bodies = candidates.bodies.iter().map(|&object| (object as usize, 0));
        facets.chain(bodies).any(|face| face_blocks(self.bodies, face, probe, own, self.light))
    }
}

impl FaceSums {
    fn take<M>(&mut self, mut tally: Tally<M>) {
        self.cells.append(&mut tally.cells);
        self.samples.samples += tally.samples.samples;
        self.samples.lit += tally.samples.lit;
        self.examined += tally.examined;
        self.points += tally.points;
        self.divided |= tally.examined > 1;
    }
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

/// How far apart samples are, if the request asks for any.
///
/// The lattice of a face is a parallelogram's, so a slanted face has more points than its area says. Where faces are so slanted that
/// there would be far more than were asked for, points are farther apart: never more than 17 for each that was asked for and each face.
pub(crate) fn spacing(bodies: &Bodies, request: &Request) -> Option<Spacing> {
    request.sampling.map(|sampling| match sampling {
        Sampling::Spacing(spacing) => Spacing::AtMost(spacing),
        Sampling::Count(count) => {
            let lattices = Lattices::of(bodies, request);
            let points = 8.0 * (count as f64 + lattices.faces);
            let even = (total_area(bodies, request) / count.max(1) as f64).sqrt();
            Spacing::About(
                even.max((lattices.products.nearest() / points).sqrt()).max(lattices.lengths.nearest() / points),
            )
        }
    })
}

/// What bounds the number of points of all lattices together; the same bits whatever the order of faces.
#[derive(Default)]
pub(crate) struct Lattices {
    /// Products of the two edges that lattices lie along, m².
    products: ExactSum,
    /// Sums of these edges, metres.
    lengths: ExactSum,
    faces: f64,
}

impl Lattices {
    /// Of all receivers. One look at every face.
    pub(crate) fn of(bodies: &Bodies, request: &Request) -> Self {
        let mut lattices = Self::default();
        for &object in &request.receivers {
            match bodies.get(object) {
                Body::Flat(facets) => (0..facets.len()).for_each(|face| lattices.add(facets.base(face).sides)),
                Body::Analytic(body) => {
                    body.charts().iter().for_each(|chart| lattices.add(chart.steps(body.placement())))
                }
            }
        }
        lattices
    }

    fn add(&mut self, [a, b]: [f64; 2]) {
        self.products.add(a * b);
        self.lengths.add(a + b);
        self.faces += 1.0;
    }

    /// No lattices with points so far apart have more points: a/s + 1 and b/s + 1 are the most along the edges of a face.
    pub(crate) fn most_points(&self, spacing: f64) -> f64 {
        self.products.nearest() / spacing / spacing + self.lengths.nearest() / spacing + self.faces
    }
}

/// The area of all receivers, square metres, the same bits whatever their order and that of their faces.
fn total_area(bodies: &Bodies, request: &Request) -> f64 {
    let mut total = ExactSum::default();
    for &object in &request.receivers {
        match bodies.get(object) {
            Body::Flat(facets) => (0..facets.len()).for_each(|face| total.add(facets.area(face).value)),
            Body::Analytic(body) => {
                // What the lattices of its patches cover.
                let steps = body.charts().iter().map(|chart| chart.steps(body.placement()));
                steps.for_each(|[u, v]| total.add(u * v));
            }
        }
    }
    total.nearest()
}
