//! A scene that changes, and shadows that follow: only what a change touches is redone.
//!
//! The answer for a receiver and a light depends on the receiver, on the light, on the objects that may shadow the receiver by the coarse step, and on the detail;
//! on nothing else, and not on the order of the objects. (Names of objects say whether their mesh has several instances, too: points that placing
//! rounds together count apart then, and so may facets be of which only some are looked at: NUMERICS.md, "Crowds".) In a scene with cells, only the objects count that the light reaches through portals. A session keeps for each such pair who was involved, under names that a change of an
//! object renews. After a change the coarse step runs again, over boxes alone, and pairs whose list of names is another one are baked. So
//! what [`Session::lights`] answers is what a [`bake`](crate::bake) of the scene as it stands answers, bit for bit.
//!
//! Cost of an update: the coarse step, and the receivers whose answer may differ. Details that spread over all receivers
//! ([`Detail::MaxUndecided`], [`Detail::Time`], [`Detail::Memory`]) have all of them redone, and so has a scene in which too much lies over everything
//! ([`throng`](crate::throng)); samples by their count look at every area anew.

use std::collections::BTreeMap;

use umbriel_geometry::{LightSource, Placement};
use umbriel_scene::{Family, Light, Member, Object, ObjectDefect, Scene};
use umbriel_visibility::portals::reach_of_light;

use crate::{
    bake::Stage,
    coarse::Influences,
    fine::{Occluders, lattice::Spacing},
    progress::{Cancelled, Progress},
    report::{LightReport, ObjectReport, Time, Work},
    request::{Detail, Request},
};

/// A change of the scene. Objects and lights are named by their indices at that moment.
#[derive(Clone, Debug)]
#[non_exhaustive]
#[allow(clippy::large_enum_variant, reason = "changes come one by one and are taken apart at once")]
pub enum Change {
    /// An object stands elsewhere.
    Move {
        /// Which object.
        object: usize,
        /// Where it stands now.
        placement: Placement,
    },
    /// A new object, behind all others; it receives and casts.
    Add(Object),
    /// An object goes; those behind it move up by one.
    Remove(usize),
    /// A light is another one.
    SetLight(usize, Light),
    /// A new light, behind all others.
    AddLight(Light),
    /// A light goes; those behind it move up by one.
    RemoveLight(usize),
}

/// Why a change is refused. Nothing is changed then.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ChangeDefect {
    /// No such object.
    #[error("there is no object {0}")]
    NoObject(usize),
    /// No such light.
    #[error("there is no light {0}")]
    NoLight(usize),
    /// The object cannot stand there.
    #[error(transparent)]
    Object(#[from] ObjectDefect),
}

/// What an update did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Update {
    /// Pairs of a receiver and a light that were baked.
    pub redone: u64,
    /// Pairs whose answer was kept.
    pub kept: u64,
    /// Counters of what was done.
    pub work: Work,
    /// Wall times of it.
    pub time: Time,
}

/// Who an answer depends on: the receiver's name, then its occluders' in their order; each twice, and one more for an instance.
type Involved = Vec<u64>;

/// The name of nobody, in the place of occluders: no light reaches the receiver.
const DARK: u64 = u64::MAX;

/// In a throng whoever changes changes the answer: who is involved is not kept.
const ALL: [u64; 0] = [];

/// A light's answers, one a receiver.
#[derive(Debug, Default)]
struct Answers {
    involved: Vec<Involved>,
    report: LightReport,
}

/// A scene with its shadows.
#[derive(Debug)]
pub struct Session {
    scene: Scene,
    /// Without lights and receivers: those are all.
    request: Request,
    /// Per object: renewed by every change of it.
    names: Vec<u64>,
    next_name: u64,
    answers: Vec<Answers>,
    spacing: Option<Spacing>,
    /// Whether objects may be in other cells than before.
    is_moved: bool,
}

impl Session {
    /// A session with the shadows of all objects under all lights; nothing is computed before the first [`Session::update`]. Of `request`, the
    /// lights and the receivers are not looked at.
    pub fn new(scene: Scene, request: Request) -> Self {
        let names: Vec<u64> = (0..scene.objects.len() as u64).collect();
        let answers = scene.lights.iter().map(|_| Answers::default()).collect();
        let next_name = names.len() as u64;
        Self { scene, request, names, next_name, answers, spacing: None, is_moved: false }
    }

    /// The scene as it stands.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What a bake of the scene would answer as of the last update: one report a light.
    pub fn lights(&self) -> impl ExactSizeIterator<Item = &LightReport> {
        self.answers.iter().map(|answers| &answers.report)
    }

    /// Changes the scene; shadows follow with the next [`Session::update`]. O(vertices of the object), and O(families) to remove one.
    ///
    /// # Errors
    /// [`ChangeDefect`].
    pub fn change(&mut self, change: Change) -> Result<(), ChangeDefect> {
        match change {
            Change::Move { object, placement } => {
                let old = self.scene.objects.get(object).ok_or(ChangeDefect::NoObject(object))?;
                let moved = old.moved(placement)?;
                self.scene.objects[object] = moved;
                self.is_moved = true;
                self.names[object] = self.new_name();
            }
            Change::Add(object) => {
                self.scene.families.roots.push(Member::Object(self.scene.objects.len()));
                self.scene.objects.push(object);
                self.is_moved = true;
                let name = self.new_name();
                self.names.push(name);
            }
            Change::Remove(object) => self.remove(object)?,
            Change::SetLight(light, new) => {
                *self.scene.lights.get_mut(light).ok_or(ChangeDefect::NoLight(light))? = new;
                self.answers[light] = Answers::default();
            }
            Change::AddLight(light) => {
                self.scene.lights.push(light);
                self.answers.push(Answers::default());
            }
            Change::RemoveLight(light) => {
                self.scene.lights.get(light).ok_or(ChangeDefect::NoLight(light))?;
                self.scene.lights.remove(light);
                self.request.own.lights = without(&self.request.own.lights, light);
                self.answers.remove(light);
            }
        }
        Ok(())
    }

    fn new_name(&mut self) -> u64 {
        self.next_name += 1;
        self.next_name - 1
    }

    fn remove(&mut self, object: usize) -> Result<(), ChangeDefect> {
        self.scene.objects.get(object).ok_or(ChangeDefect::NoObject(object))?;
        self.scene.objects.remove(object);
        self.is_moved = true;
        self.request.own.objects = without(&self.request.own.objects, object);
        self.names.remove(object);
        let kept = |members: &mut Vec<Member>| {
            members.retain(|member| *member != Member::Object(object));
            for member in members {
                if let Member::Object(number) = member {
                    *number -= usize::from(*number > object);
                }
            }
        };
        kept(&mut self.scene.families.roots);
        self.scene.families.families.iter_mut().for_each(|Family { members, .. }| kept(members));
        for answers in &mut self.answers {
            if object < answers.involved.len() {
                answers.involved.remove(object);
                answers.report.objects.remove(object);
            }
        }
        Ok(())
    }

    /// Bakes what changes touched since the last update.
    ///
    /// # Errors
    /// [`Cancelled`] when `progress` says so; answers are then partly old, and the next update goes on.
    pub fn update(&mut self, progress: &dyn Progress) -> Result<Update, Cancelled> {
        let mut update = Update::default();
        if std::mem::take(&mut self.is_moved) {
            self.scene.cells = self.scene.cells.with_objects(&self.scene.objects);
        }
        let mut answers = std::mem::take(&mut self.answers);
        let result = self.update_all(&mut answers, progress, &mut update);
        self.answers = answers;
        result.map(|()| update)
    }

    fn update_all(
        &mut self,
        answers: &mut [Answers],
        progress: &dyn Progress,
        update: &mut Update,
    ) -> Result<(), Cancelled> {
        let everything = Request {
            lights: (0..self.scene.lights.len()).collect(),
            receivers: (0..self.scene.objects.len()).collect(),
            ..self.request.clone()
        };
        let stage = Stage::new(&self.scene, &everything, None);
        let is_shared = self.request.effort.is_some()
            || matches!(self.request.detail, Detail::MaxUndecided { .. } | Detail::Time { .. } | Detail::Memory { .. });
        if is_shared || stage.spacing != self.spacing {
            answers.iter_mut().for_each(|answers| answers.involved.clear());
        }
        self.spacing = stage.spacing;
        for (light, answers) in answers.iter_mut().enumerate() {
            let source = &self.scene.lights[light].source;
            let reached = self.reached(source);
            let within = reached.as_ref().map(|reached| self.stage(&everything, source, Some(reached.clone())));
            let whole = within.as_ref().unwrap_or(&stage);
            let mut influences = whole.influences(source);
            let is_throng = whole.is_throng(&influences, &Occluders::new(&whole.bodies, source));
            if !is_throng {
                influences.see_all();
            }
            let is_dark = |object: usize| reached.as_ref().is_some_and(|reached| !reached[object]);
            let involved_in = |object: usize| match is_throng {
                true => ALL.to_vec(),
                false => self.involved(object, is_dark(object), &influences, &stage),
            };
            let involved: Vec<Involved> = (0..self.names.len()).map(involved_in).collect();
            let is_new = |&object: &usize| is_throng || answers.involved.get(object) != Some(&involved[object]);
            let touched: Vec<usize> = (0..involved.len()).filter(is_new).collect();
            update.redone += touched.len() as u64;
            update.kept += (involved.len() - touched.len()) as u64;
            let request = Request { lights: vec![light], receivers: touched.clone(), ..self.request.clone() };
            let mut part = self.stage(&request, source, reached);
            (part.spacing, part.may_be_throng) = (self.spacing, is_throng);
            let mut expense = part.expense();
            let reports = part.bake(source, request.own.lights.get(&light).copied(), progress, &mut expense)?;
            update.work.add(&expense.work);
            update.time.coarse += expense.time.coarse;
            update.time.fine += expense.time.fine;
            answers.take(light, touched, reports, involved);
        }
        Ok(())
    }

    /// Which objects the light may reach through portals; `None` without cells.
    fn reached(&self, source: &LightSource) -> Option<Vec<bool>> {
        if self.scene.cells.is_empty() {
            return None;
        }
        let mut reached = vec![false; self.scene.objects.len()];
        reach_of_light(&self.scene, source).indices().for_each(|object| reached[object] = true);
        Some(reached)
    }

    fn stage<'a>(&'a self, request: &'a Request, source: &LightSource, reached: Option<Vec<bool>>) -> Stage<'a> {
        match reached {
            Some(reached) => Stage::with_reached(&self.scene, request, reached),
            None => Stage::new(&self.scene, request, Some(&[*source])),
        }
    }

    /// What no light reaches depends on itself alone, and is told apart from what is in nobody's shadow.
    fn involved(&self, object: usize, is_dark: bool, influences: &Influences, stage: &Stage) -> Involved {
        let name = |object: usize| 2 * self.names[object] + u64::from(stage.bodies.is_instance(object));
        if is_dark {
            return vec![name(object), DARK];
        }
        let occluders = influences.occluders_of(object as u32);
        std::iter::once(name(object)).chain(occluders.iter().map(|&other| name(other as usize))).collect()
    }
}

/// Details by number after one of the numbers has gone.
fn without(details: &BTreeMap<usize, Detail>, gone: usize) -> BTreeMap<usize, Detail> {
    let kept = details.iter().filter(|(number, _)| **number != gone);
    kept.map(|(&number, &detail)| (number - usize::from(number > gone), detail)).collect()
}

impl Answers {
    /// Puts the new answers beside those that were kept.
    fn take(&mut self, light: usize, touched: Vec<usize>, reports: Vec<ObjectReport>, involved: Vec<Involved>) {
        let Self { report, involved: names } = self;
        report.light = light;
        report.objects.resize_with(involved.len(), ObjectReport::default);
        for (object, new) in touched.into_iter().zip(reports) {
            report.objects[object] = new;
        }
        (0..).zip(&mut report.objects).for_each(|(object, one)| one.object = object);
        *names = involved;
    }
}
