//! The pipeline: coarse step, fine step, sums.

use std::{
    collections::HashMap,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::Instant,
};

use rayon::prelude::*;
use umbriel_geometry::{LightSource, predicates::exact_fallbacks};
use umbriel_scene::Scene;

use crate::{
    bodies::Bodies,
    budget::{Limit, refine},
    by_object::ByObject,
    coarse::{Coarse, Influences, most_faces},
    effort::Purse,
    fine::{Occluders, lattice::Spacing, scan::Layout},
    groups::groups,
    portals,
    progress::{Cancelled, Progress},
    receivers::{FaceSums, Job, Receivers},
    report::{LightReport, ObjectReport, Report, Time, Work},
    request::{Detail, Request},
    samples::Samples,
    solids::Solids,
    spacing::spacing,
    throng,
    trial::Trial,
};

/// So many faces look for what is over them, and lie over others, that the trees that they look through are made beforehand.
const LARGE: usize = 1 << 14;

/// Where the effort was not enough, the bake that goes as far as it can takes this part of it, beside what was taken in vain.
const ANEW: u64 = 3;

/// Computes the shadows that `request` asks for. Deterministic: the same bits for any number of threads, but for
/// times and, where a mesh has instances, the count of decisions (an instance may be placed once more or less).
///
/// In a scene with cells, only what each light reaches through portals is modelled.
///
/// Cost: proportional to the shadow borders' length in cells, plus a look at every face.
///
/// # Errors
/// [`Cancelled`] when `progress` says so.
///
/// # Panics
/// If the request names a light or an object that the scene does not have.
pub fn bake(scene: &Scene, request: &Request, progress: &dyn Progress) -> Result<Report, Cancelled> {
    if !scene.cells.is_empty() {
        return portals::bake(scene, request, progress);
    }
    let lights: Vec<LightSource> = request.lights.iter().map(|&light| scene.lights[light].source).collect();
    let stage = Stage::new(scene, request, Some(&lights));
    let mut expense = stage.expense();
    let mut lights = Vec::with_capacity(request.lights.len());
    for &light in &request.lights {
        let own = request.own.lights.get(&light).copied();
        let objects = stage.bake(&scene.lights[light].source, own, progress, &mut expense)?;
        lights.push(LightReport { light, objects });
    }
    Ok(Report { lights, work: expense.work, time: expense.time })
}

/// What was done for some lights, and how long it took.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Expense {
    pub(crate) work: Work,
    pub(crate) time: Time,
    /// Lights that are done.
    pub(crate) lights: usize,
}

/// All of a bake that no light changes: made once.
pub(crate) struct Stage<'a> {
    pub(crate) bodies: Bodies<'a>,
    pub(crate) request: &'a Request,
    /// How far apart samples are.
    pub(crate) spacing: Option<Spacing>,
    /// The samples of each object's flat faces, each made when it is first asked for; none of instances.
    pub(crate) layouts: ByObject<Arc<Layout>>,
    /// The solids of each object, each made when it is first asked for; none of instances.
    pub(crate) solids: ByObject<Arc<Solids>>,
    pub(crate) coarse: Coarse,
    /// For each receiver the first one that has the same answer.
    answered_by: Vec<usize>,
    /// False where it is known that the scene is no [`throng`].
    pub(crate) may_be_throng: bool,
    /// When making it began, and how many seconds it took.
    begun: Instant,
    seconds: f64,
}

impl<'a> Stage<'a> {
    /// The object tree and the sample spacing; bodies are placed when they are first asked for. With the lights that will be asked about, what matters to
    /// none of them is left out.
    pub(crate) fn new(scene: &'a Scene, request: &'a Request, lights: Option<&[LightSource]>) -> Self {
        Self::of_bodies(Instant::now(), request, lights, Bodies::bare(scene))
    }

    /// As [`Stage::new`], with what is known of the objects that light may reach.
    pub(crate) fn with_reached(scene: &'a Scene, request: &'a Request, reached: Vec<bool>) -> Self {
        Self::of_bodies(Instant::now(), request, None, Bodies::bare(scene).reached(reached))
    }

    fn of_bodies(begun: Instant, request: &'a Request, lights: Option<&[LightSource]>, bodies: Bodies<'a>) -> Self {
        let scene = bodies.scene;
        let coarse = Coarse::new(&bodies, &request.receivers, lights);
        let bodies = bodies.sharing(coarse.present());
        let spacing = spacing(&bodies, request);
        let answered_by = answered_by(&coarse, scene, request);
        let (layouts, solids) = (ByObject::new(scene.objects.len()), ByObject::new(scene.objects.len()));
        let seconds = begun.elapsed().as_secs_f64();
        let may_be_throng = true;
        Self { bodies, request, spacing, layouts, solids, coarse, answered_by, may_be_throng, begun, seconds }
    }

    /// The account to which lights are added.
    pub(crate) fn expense(&self) -> Expense {
        Expense { time: Time { coarse: self.seconds, ..Time::default() }, ..Expense::default() }
    }

    /// Computes the shadows of one light, which may have a detail of its own: a report for each receiver.
    pub(crate) fn bake(
        &self,
        light: &LightSource,
        own: Option<Detail>,
        progress: &dyn Progress,
        expense: &mut Expense,
    ) -> Result<Vec<ObjectReport>, Cancelled> {
        let (start, fallbacks) = (Instant::now(), exact_fallbacks());
        let mut influences = self.influences(light);
        let occluders = Occluders::new(&self.bodies, light);
        // Samples are decided whatever the clock says, and need all that may block them.
        let deadline = self.limit(expense.lights).filter(|_| self.spacing.is_none()).and_then(|limit| limit.deadline);
        deadline.into_iter().for_each(|deadline| occluders.stop_at(deadline));
        self.prepare(&occluders, &influences);
        let is_throng = self.is_throng(&influences, &occluders);
        if !is_throng {
            influences.see_all();
        }
        let counts = influences.counts();
        expense.work.pairs_tested += counts.tested;
        expense.work.pairs_registered += counts.registered;
        expense.work.pairs_excluded += counts.excluded;
        expense.time.coarse += start.elapsed().as_secs_f64();
        let start = Instant::now();
        let receivers = Receivers::new(self, occluders, own, &influences, is_throng);
        let objects = self.refine(receivers, expense.lights, progress, &mut expense.work)?;
        expense.lights += 1;
        expense.time.fine += start.elapsed().as_secs_f64();
        expense.work.exact_fallbacks += exact_fallbacks() - fallbacks;
        Ok(objects)
    }

    /// Which objects may shadow which receivers, as far as is seen before it is asked whether the scene is a [`throng`].
    pub(crate) fn influences(&self, light: &LightSource) -> Influences<'_> {
        let mut influences = self.coarse.step(&self.request.receivers, light);
        if self.is_of_samples() {
            influences.see_more();
        }
        influences
    }

    /// Builds at once what many faces will look through; a clock has first what needs none of it.
    fn prepare(&self, occluders: &Occluders, influences: &Influences) {
        let count = |object: usize| most_faces(&self.bodies.scene.objects[object]);
        let is_large = |object: usize| count(object) >= LARGE;
        let are_many = || self.first_receivers().map(count).sum::<usize>() >= LARGE;
        let is_clocked = matches!(self.request.detail, Detail::Time { .. });
        if !self.is_of_samples() && !is_clocked && self.coarse.occluders().any(is_large) && are_many() {
            let over = influences.occluders_of_all(self.first_receivers());
            let is_whole = |object: usize| is_large(object) && !self.bodies.is_instance(object);
            occluders.prepare(over.into_iter().filter(|&object| is_whole(object as usize)).collect());
        }
    }

    /// Whether too much lies over everything to go through all pairs. Samples without cells, and faces as a clock lets them, do, unless even the objects are too
    /// many.
    pub(crate) fn is_throng(&self, influences: &Influences, occluders: &Occluders) -> bool {
        let is_clocked = matches!(self.request.detail, Detail::Time { .. });
        let is_asked = !(self.is_of_samples() || is_clocked) || !influences.is_whole();
        self.may_be_throng && is_asked && throng::is_throng(self, influences, occluders)
    }

    /// Whether samples are asked for, and no cells.
    fn is_of_samples(&self) -> bool {
        self.request.detail == Detail::Faces && self.spacing.is_some()
    }

    /// The objects that are asked for and have no answer of another one.
    pub(crate) fn first_receivers(&self) -> impl Iterator<Item = usize> + '_ {
        self.firsts().map(|receiver| self.request.receivers[receiver])
    }

    /// Their places among the receivers.
    fn firsts(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.answered_by.len()).filter(|&receiver| self.is_first(receiver))
    }

    fn is_first(&self, receiver: usize) -> bool {
        self.answered_by[receiver] == receiver
    }

    /// The fine step; once, or as far as a limit lets it.
    fn refine(
        &self,
        mut receivers: Receivers,
        lights_done: usize,
        progress: &dyn Progress,
        work: &mut Work,
    ) -> Result<Vec<ObjectReport>, Cancelled> {
        if self.is_of_samples() {
            let is_first = |receiver: usize| self.is_first(receiver);
            let samples = Samples::new(self, receivers.light, receivers.influences, is_first);
            let mut objects = unanswered(self.request);
            let left: Vec<usize> = self.firsts().filter(|&receiver| !samples.takes(receiver)).collect();
            let steps = Steps::of(&receivers, &left, progress);
            run(&receivers, (left, &Purse::new(u64::MAX)), &steps, (&mut objects, work))?;
            work.rays += samples.run(&mut objects, progress)?;
            self.repeat(&mut objects);
            return Ok(objects);
        }
        if let Some(limit) = self.limit(lights_done) {
            return self.refine_until(&mut receivers, &limit, progress, work);
        }
        let purse = self.purse();
        if let Some((objects, spent)) = self.whole(&receivers, &purse, progress)? {
            work.add(&spent);
            return Ok(objects);
        }
        work.lights_cut_short += 1;
        let limit = Limit { work: Some(purse.most / ANEW), ..Limit::default() };
        self.refine_until(&mut receivers, &limit, progress, work)
    }

    /// All of it with what was done for it, unless that is more than may be spent; some receivers, if they are many, tell early that it is.
    fn whole(
        &self,
        receivers: &Receivers,
        purse: &Purse,
        progress: &dyn Progress,
    ) -> Result<Option<(Vec<ObjectReport>, Work)>, Cancelled> {
        let (mut objects, mut spent) = (unanswered(self.request), Work::default());
        let firsts: Vec<usize> = self.firsts().collect();
        let steps = Steps::of(receivers, &firsts, progress);
        let Trial { tried, others, part } = self.trial(firsts, purse);
        let first = Purse::new((part * purse.most as f64) as u64);
        run(receivers, (tried, &first), &steps, (&mut objects, &mut spent))?;
        if !first.is_enough() {
            return Ok(None);
        }
        let rest = purse.without(&first);
        run(receivers, (others, &rest), &steps, (&mut objects, &mut spent))?;
        self.repeat(&mut objects);
        Ok(rest.is_enough().then_some((objects, spent)))
    }

    /// Which receivers come first; none where there is no end to what may be spent.
    fn trial(&self, receivers: Vec<usize>, purse: &Purse) -> Trial {
        if purse.most == u64::MAX {
            return Trial { tried: Vec::new(), others: receivers, part: 0.0 };
        }
        let object = |receiver: usize| self.request.receivers[receiver];
        let faces = |receiver: usize| most_faces(&self.bodies.scene.objects[object(receiver)]);
        Trial::of(receivers, |receiver| self.bodies.bounds(object(receiver)), faces)
    }

    /// As far as a limit lets it.
    fn refine_until(
        &self,
        receivers: &mut Receivers,
        limit: &Limit,
        progress: &dyn Progress,
        work: &mut Work,
    ) -> Result<Vec<ObjectReport>, Cancelled> {
        let sums = refine(receivers, limit, progress)?.into_iter().zip(&self.request.receivers);
        Ok(sums.map(|(sums, &object)| report(sums, object, self.request, work)).collect())
    }

    /// What may be spent on a light.
    fn purse(&self) -> Purse {
        let effort = self.request.effort.filter(|_| self.request.detail.is_fixed());
        Purse::new(effort.unwrap_or(u64::MAX))
    }

    /// Gives the answers to those receivers, too, that have the same ones.
    fn repeat(&self, objects: &mut [ObjectReport]) {
        for (receiver, &first) in self.answered_by.iter().enumerate().filter(|(receiver, first)| receiver != *first) {
            objects[receiver] = ObjectReport { object: objects[receiver].object, ..objects[first].clone() };
        }
    }

    /// Where to stop, if that is how the detail is given; time is shared by the lights of the request.
    fn limit(&self, lights_done: usize) -> Option<Limit> {
        match self.request.detail {
            Detail::MaxUndecided { share } => Some(Limit { share, ..Limit::default() }),
            Detail::Memory { bytes } => Some(Limit { bytes: Some(bytes), ..Limit::default() }),
            Detail::Time { limit } => {
                let lights = self.request.lights.len().max(1) as u32;
                let deadline = self.begun + limit / lights * (lights_done as u32 + 1).min(lights);
                Some(Limit { deadline: Some(deadline), ..Limit::default() })
            }
            _ => None,
        }
    }
}

/// For each receiver the first one that has the same answer: that is the same body in the same place, with the same sides, and whose detail is the same.
fn answered_by(coarse: &Coarse, scene: &Scene, request: &Request) -> Vec<usize> {
    let mut firsts: HashMap<usize, Vec<usize>> = HashMap::new();
    let of_receiver = |(place, &object): (usize, &usize)| {
        let (first, is_alone) = coarse.first_of(object);
        if is_alone {
            return place;
        }
        let what = |object: usize| (scene.objects[object].sides, request.own.objects.get(&object));
        let known = firsts.entry(first).or_default();
        let same = known.iter().copied().find(|&other| what(request.receivers[other]) == what(object));
        same.unwrap_or_else(|| {
            known.push(place);
            place
        })
    };
    request.receivers.iter().enumerate().map(of_receiver).collect()
}

/// The report of a receiver, with what was done for it.
fn report(sums: FaceSums, object: usize, request: &Request, work: &mut Work) -> ObjectReport {
    work.octrees_built += u64::from(sums.divided);
    work.objects_crowded += u64::from(sums.is_crowded);
    work.cells += sums.examined;
    work.rays += sums.points;
    sums.report(object, request)
}

/// How many of some jobs are done.
struct Steps<'a> {
    progress: &'a dyn Progress,
    done: AtomicU64,
    of: u64,
}

impl<'a> Steps<'a> {
    /// The jobs of these receivers.
    fn of(receivers: &Receivers, some: &[usize], progress: &'a dyn Progress) -> Self {
        let of = some.iter().map(|&receiver| receivers.jobs_of(receiver).len() as u64).sum();
        Self { progress, done: AtomicU64::new(0), of }
    }

    fn advance(&self) {
        self.progress.advance("shadows", self.done.fetch_add(1, Ordering::Relaxed) + 1, self.of);
    }
}

/// A report of nothing for each receiver.
fn unanswered(request: &Request) -> Vec<ObjectReport> {
    request.receivers.iter().map(|&object| FaceSums::default().report(object, request)).collect()
}

/// Runs the jobs of the receivers that are `asked`, as far as the purse lasts, and adds them up per object: the sums of a group are reports before the next one begins.
fn run(
    receivers: &Receivers,
    (asked, purse): (Vec<usize>, &Purse),
    steps: &Steps,
    (objects, work): (&mut [ObjectReport], &mut Work),
) -> Result<(), Cancelled> {
    let request = receivers.request;
    for group in groups(receivers, asked) {
        if steps.progress.is_cancelled() {
            return Err(Cancelled);
        }
        if !purse.is_enough() {
            // Nobody takes what is found.
            break;
        }
        let sums = if receivers.bodies.has_instances() {
            let bodies = Bodies::of_group(receivers.bodies);
            let receivers = receivers.of_group(&bodies);
            receivers.prepare(&group);
            run_group(&receivers, (&group, purse), steps)
        } else {
            run_group(receivers, (&group, purse), steps)
        };
        for (receiver, sums) in group.into_iter().zip(sums) {
            objects[receiver] = report(sums, request.receivers[receiver], request, work);
        }
    }
    if steps.progress.is_cancelled() { Err(Cancelled) } else { Ok(()) }
}

/// The sums of some receivers. They are added up receiver by receiver: those of all jobs together would be most of what a scene of many faces takes.
fn run_group(receivers: &Receivers, (group, purse): (&[usize], &Purse), steps: &Steps) -> Vec<FaceSums> {
    let run_job = |job: Job| {
        let share = purse.share();
        let sums = receivers.run(&job, &|work| share.spend(work) && !steps.progress.is_cancelled());
        steps.advance();
        sums
    };
    let whole = |&receiver: &usize| {
        let jobs: Vec<Job> = receivers.jobs_of(receiver).collect();
        let sums: Vec<FaceSums> = jobs.into_par_iter().map(run_job).collect();
        let mut total = FaceSums::default();
        sums.into_iter().for_each(|sums| total.append(sums));
        receivers.sort_cells(receiver, &mut total.cells);
        total
    };
    group.par_iter().map(whole).collect()
}
