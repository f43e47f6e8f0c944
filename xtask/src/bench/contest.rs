//! All duels over one scene: every number of samples, group of lights and number of threads.

use std::process::Command;

use anyhow::{Result, anyhow};
use umbriel_io::MemoryPeak;
use umbriel_scene::Scene;
use umbriel_shadow::{Place, Points, Queries, Request, SamplePoint, Silent, bake};

use super::{
    duel::{Duel, FirstLook, Own, Peer, ask_once, bake_once, request},
    embree::{Embree, Order, Setup, scratch},
    judge::{Verdicts, judge},
    options::Options,
    rays::{Numbered, Soup},
    rivals::{Starts, all},
    table::{OwnFigures, PeerFigures, RivalFigures, Row},
};

/// Samples that are compared one by one at most.
const MOST_LISTED: u64 = 1 << 24;

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Task {
    /// The samples of a bake.
    Samples,
    /// The same places as loose points, off the surface.
    Points(Order),
}

/// A scene and what varies.
pub(super) struct Contest<'a> {
    pub(super) name: &'a str,
    pub(super) scene: &'a Scene,
    /// Each group is one bake.
    pub(super) lights: Vec<Vec<usize>>,
    pub(super) samples: &'a [u64],
    pub(super) threads: &'a [usize],
    pub(super) task: Task,
    pub(super) options: &'a Options,
    /// Whether `--scene` makes this scene.
    pub(super) is_class: bool,
}

/// What one row measures.
struct Case<'a> {
    soup: &'a Soup,
    lights: &'a [usize],
    samples: u64,
    threads: usize,
    finalists: &'a [Setup],
}

impl Task {
    fn order(self) -> Order {
        if let Self::Points(order) = self { order } else { Order::Coherent }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Points(Order::Coherent) => "points",
            Self::Points(Order::Shuffled) => "shuffled",
        }
    }
}

impl Contest<'_> {
    /// Measures and shows every row.
    pub(super) fn run(&self, mut embree: Option<&mut Embree>) -> Result<Vec<Row>> {
        let soup = &Soup::of(self.scene)?;
        let (mut look, mut rows) = (None, Vec::new());
        for &samples in self.samples {
            if let Some(embree) = embree.as_deref_mut() {
                let file = scratch()?.join("rays.bin");
                soup.write(self.scene, &request(self.scene, &[0], samples), &file)?;
                embree.load(&file)?;
                if look.is_none() {
                    look = Some(self.first_look(embree, samples)?);
                }
            }
            for (group, lights) in self.lights.iter().enumerate() {
                let finalists = look.as_ref().map(|look| look.finalists(group, samples)).unwrap_or_default();
                for &threads in self.threads {
                    let case = Case { soup, lights, samples, threads, finalists: &finalists };
                    let row = self.row(&case, embree.as_deref_mut())?;
                    println!("{}", row.line());
                    rows.push(row);
                }
            }
        }
        Ok(rows)
    }

    fn first_look(&self, embree: &mut Embree, samples: u64) -> Result<FirstLook> {
        let first: Vec<usize> = self.lights.iter().filter_map(|group| group.first().copied()).collect();
        let most_lights = self.lights.iter().map(|group| group.len() as u64).max().unwrap_or(1);
        let most = self.samples.iter().copied().max().unwrap_or(samples) * most_lights;
        FirstLook::take(embree, self.scene, &first, [samples, most], self.task.order())
    }

    fn row(&self, case: &Case, mut embree: Option<&mut Embree>) -> Result<Row> {
        let &Case { lights, samples, threads, .. } = case;
        let (scene, order, rounds) = (self.scene, self.task.order(), self.options.runs);
        let points = if self.task == Task::Samples { Vec::new() } else { self.points(case) };
        let asked = request(scene, lights, samples);
        let duel = Duel {
            scene,
            lights,
            own: &|pool| match self.task {
                Task::Samples => bake_once(scene, &asked, pool),
                Task::Points(_) => ask_once(scene, &points, lights[0], pool),
            },
            threads,
            rounds,
            order,
        };
        let (own, peer) = duel.run(embree.as_deref_mut(), case.finalists)?;
        let differing = match (&peer, embree) {
            (Some(peer), Some(embree)) if self.task == Task::Samples => self.differing_samples(case, peer, embree)?,
            (Some(peer), Some(embree)) => self.differing(&own, peer, &points, lights[0], embree)?,
            _ => None,
        };
        let light = match lights {
            [light] => scene.lights[*light].name.clone(),
            _ => format!("{} lights", lights.len()),
        };
        let memory = self.memory(&light, case);
        Ok(Row {
            scene: self.name.into(),
            triangles: case.soup.triangles.len(),
            task: self.task.name(),
            light,
            lights: lights.len(),
            samples,
            threads,
            own: OwnFigures::new(&own, memory),
            embree: peer.map(|peer| PeerFigures::new(peer, differing)),
            rivals: self.rivals(case)?,
        })
    }

    /// The starts of the rays as loose points, in the order of the task.
    fn points(&self, case: &Case) -> Vec<[f32; 6]> {
        let light = &self.scene.lights[case.lights[0]].source;
        let mut points = Vec::new();
        let request = request(self.scene, case.lights, case.samples);
        case.soup.for_each_start(self.scene, &request, |_, start| points.push(start.point(light, case.soup.offset)));
        if self.task.order() == Order::Shuffled {
            shuffle(&mut points);
        }
        points
    }

    /// Compares answers one by one, where the own side tells them; Embree's best configuration runs once more.
    fn differing(
        &self,
        own: &Own,
        peer: &Peer,
        points: &[[f32; 6]],
        light: usize,
        embree: &mut Embree,
    ) -> Result<Option<Verdicts>> {
        let Some(own) = &own.answers else { return Ok(None) };
        embree.build(peer.setup.build, 1)?;
        embree.trace(peer.setup.rays, self.task.order(), 1)?;
        let mut theirs = embree.answers()?;
        if self.task.order() == Order::Shuffled {
            shuffle(&mut theirs);
        }
        let (queries, points) = (Queries::new(self.scene), Points::OrientedSingle(points));
        let source = &self.scene.lights[light].source;
        let is_lit = |index: usize| queries.lit(&points.place(index), source).is_ok_and(|answer| answer.lit);
        Ok(Some(judge(own, &theirs, is_lit)))
    }

    /// Compares the samples of a bake that keeps its answers, one by one, unless there are too many to list.
    fn differing_samples(&self, case: &Case, peer: &Peer, embree: &mut Embree) -> Result<Option<Verdicts>> {
        let ([light], true) = (case.lights, case.samples <= MOST_LISTED) else { return Ok(None) };
        let asked = Request { keep_cells: true, ..request(self.scene, case.lights, case.samples) };
        let report = bake(self.scene, &asked, &Silent).map_err(|_| anyhow!("the bake was cancelled"))?;
        let answers = report.lights[0].objects.iter().filter_map(|object| object.answers.as_ref());
        let answers: Vec<bool> = answers.flat_map(|object| (0..object.len()).map(|n| object.is_lit(n))).collect();
        let (mut own, mut places) = (Vec::new(), Vec::new());
        case.soup.for_each_start(self.scene, &asked, |Numbered { number, sample }, _| {
            own.push(answers[number]);
            places.push(sample);
        });
        embree.build(peer.setup.build, 1)?;
        embree.set_light(&self.scene.lights[*light].source)?;
        embree.trace(peer.setup.rays, self.task.order(), 1)?;
        let queries = Queries::new(self.scene);
        let is_lit = |index: usize| {
            let SamplePoint { object, face, u, v, .. } = places[index];
            queries.lit(&Place::Surface { object, face, u, v }, &self.scene.lights[*light].source).is_ok_and(|a| a.lit)
        };
        Ok(Some(judge(&own, &embree.answers()?, is_lit)))
    }

    /// The peak of one bake in a process of its own.
    fn memory(&self, light: &str, case: &Case) -> Option<u64> {
        if !self.is_class || case.lights.len() > 1 || self.task != Task::Samples {
            return None;
        }
        let mut own = Command::new(std::env::current_exe().ok()?);
        // With glibc: what is freed goes back to the system, so that making the scene leaves nothing behind.
        own.env("MALLOC_MMAP_THRESHOLD_", "65536").env("MALLOC_TRIM_THRESHOLD_", "65536");
        own.args(["bench", "--memory", "--scene", self.name, "--light", light]);
        own.args(["--samples", &case.samples.to_string(), "--threads", &case.threads.to_string()]);
        String::from_utf8(own.output().ok()?.stdout).ok()?.trim().parse().ok()
    }

    /// Each rival once, if asked for: they are not close.
    fn rivals(&self, case: &Case) -> Result<Vec<RivalFigures>> {
        let ([light], true, 1) = (case.lights, self.options.rivals, case.threads) else { return Ok(Vec::new()) };
        let starts = Starts::of(case.soup, self.scene, &request(self.scene, case.lights, case.samples));
        let figures = all().into_iter().map(|rival| {
            let (total, lit) = starts.run(&rival, case.soup, &self.scene.lights[*light].source)?;
            Ok(RivalFigures { name: rival.name, total, lit })
        });
        figures.collect()
    }
}

/// The permutation of the Embree program (Fisher and Yates).
fn shuffle<T>(items: &mut [T]) {
    let mut random = crate::fixtures::SplitMix64::new(1);
    for end in (2..=items.len()).rev() {
        items.swap(end - 1, random.below(end));
    }
}

/// The lights of a scene that are asked for.
pub(super) fn asked_lights(scene: &Scene, options: &Options) -> Vec<usize> {
    let is_asked = |name: &String| options.light.is_empty() || options.light.contains(name);
    (0..scene.lights.len()).filter(|&light| is_asked(&scene.lights[light].name)).collect()
}

/// Prints the peak memory of one bake: of the first light, number of samples and number of threads that are asked for.
pub(super) fn print_memory(scene: &Scene, options: &Options) -> Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads[0]).build()?;
    let request = request(scene, &asked_lights(scene, options)[..1], options.samples[0]);
    let peak = MemoryPeak::start();
    bake_once(scene, &request, &pool)?;
    if let Some(bytes) = peak.bytes() {
        println!("{bytes}");
    }
    Ok(())
}
