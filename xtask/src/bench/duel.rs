//! One scene, some lights, one number of samples: the bake and Embree in turn, the quickest run of each.
//!
//! First every configuration of Embree runs once; the best few then compete with the bake, builds included, each in
//! every round. So a noisy moment of the machine hits both sides.

use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow};
use rayon::ThreadPool;
use umbriel_scene::Scene;
use umbriel_shadow::{Detail, Points, Queries, Request, Sampling, Silent, bake};

use super::{
    clock::{Seconds, timed},
    embree::{Embree, Order, RAYS, Setup, builds},
};

/// How many configurations of Embree go on after the first look.
const FINALISTS: usize = 3;
/// After this time no further round begins.
const PATIENCE: Duration = Duration::from_secs(90);

/// What the own side took and found.
#[derive(Clone, Debug)]
pub(super) struct Own {
    pub(super) seconds: Seconds,
    /// Over all lights.
    pub(super) samples: u64,
    pub(super) lit: u64,
    /// Whether each is lit, in the order of the surface, where that is known.
    pub(super) answers: Option<Vec<bool>>,
}

/// What Embree took and found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peer {
    pub(super) setup: Setup,
    pub(super) build: Seconds,
    pub(super) rays: Seconds,
    pub(super) memory: u64,
    pub(super) lit: u64,
}

impl Peer {
    pub(super) fn total(&self) -> Seconds {
        self.build + self.rays
    }
}

/// The request of the benchmark: samples of everything under some lights.
pub(super) fn request(scene: &Scene, lights: &[usize], samples: u64) -> Request {
    let sampling = Some(Sampling::Count(samples));
    Request { sampling, lights: lights.to_vec(), ..Request::everything(scene, Detail::Faces) }
}

/// One bake, on the threads of `pool`.
pub(super) fn bake_once(scene: &Scene, request: &Request, pool: &ThreadPool) -> Result<Own> {
    let (report, seconds) = timed(|| pool.install(|| bake(scene, request, &Silent)));
    let report = report.map_err(|_| anyhow!("the bake was cancelled"))?;
    let objects = report.lights.iter().flat_map(|light| &light.objects);
    let counts = objects.filter_map(|object| object.samples);
    let (samples, lit) = counts.fold((0, 0), |sum, count| (sum.0 + count.samples, sum.1 + count.lit));
    Ok(Own { seconds, samples, lit, answers: None })
}

/// All points at once, on the threads of `pool`; what queries need is built again every time.
pub(super) fn ask_once(scene: &Scene, points: &[[f32; 6]], light: usize, pool: &ThreadPool) -> Result<Own> {
    let source = &scene.lights[light].source;
    let ask = || Queries::new(scene).lit_many(Points::OrientedSingle(points), source, &Silent);
    let (answers, seconds) = timed(|| pool.install(ask));
    let answers = answers?;
    let lit = answers.iter().filter(|&&lit| lit).count() as u64;
    Ok(Own { seconds, samples: answers.len() as u64, lit, answers: Some(answers) })
}

/// What a configuration takes for its build, and for the rays to one light.
type Look = (Setup, Seconds, Seconds);

/// The first look: what each configuration takes on one thread for `samples` samples under each light.
pub(super) struct FirstLook {
    samples: u64,
    /// A list for each group of lights.
    found: Vec<Vec<Look>>,
}

impl FirstLook {
    /// Runs every configuration once on what is loaded. Builds that alone take longer than the best total for `most`
    /// samples, and better builds after them, are out.
    pub(super) fn take(
        embree: &mut Embree,
        scene: &Scene,
        lights: &[usize],
        [samples, most]: [u64; 2],
        order: Order,
    ) -> Result<Self> {
        let mut look = Self { samples, found: vec![Vec::new(); lights.len()] };
        for build in builds() {
            let best =
                |found: &Vec<Look>| found.iter().map(|entry| look.predict(entry, most)).fold(f64::INFINITY, f64::min);
            let hopeless = look.found.iter().map(best).fold(0.0, f64::max);
            let last = look.found.iter().flatten().last().map_or(0.0, |&(_, build, _)| build.cpu);
            if last > hopeless {
                break;
            }
            let built = embree.build(build, 1)?;
            for (found, &light) in look.found.iter_mut().zip(lights) {
                embree.set_light(&scene.lights[light].source)?;
                for rays in RAYS {
                    let (traced, _) = embree.trace(rays, order, 1)?;
                    found.push((Setup { build, rays }, built, traced));
                }
            }
        }
        Ok(look)
    }

    /// The most promising configurations for the `index`-th light and this many samples.
    pub(super) fn finalists(&self, index: usize, samples: u64) -> Vec<Setup> {
        let mut ranked = self.found[index].clone();
        ranked.sort_by(|a, b| self.predict(a, samples).total_cmp(&self.predict(b, samples)));
        ranked.iter().take(FINALISTS).map(|&(setup, ..)| setup).collect()
    }

    fn predict(&self, &(_, build, rays): &Look, samples: u64) -> f64 {
        build.cpu + rays.cpu * samples as f64 / self.samples as f64
    }
}

/// A duel of so many rounds.
pub(super) struct Duel<'a> {
    pub(super) scene: &'a Scene,
    pub(super) lights: &'a [usize],
    /// What competes: runs once.
    pub(super) own: &'a dyn Fn(&ThreadPool) -> Result<Own>,
    pub(super) threads: usize,
    pub(super) rounds: usize,
    pub(super) order: Order,
}

impl Duel<'_> {
    /// The own side, and the best configuration of Embree if there is one.
    pub(super) fn run(&self, mut embree: Option<&mut Embree>, finalists: &[Setup]) -> Result<(Own, Option<Peer>)> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads).build()?;
        let (mut own, mut peers): (Option<Own>, Vec<Peer>) = (None, Vec::new());
        let begun = Instant::now();
        for round in 0..self.rounds {
            let next = (self.own)(&pool)?;
            let seconds = own.as_ref().map_or(next.seconds, |own| own.seconds.min(next.seconds));
            own = Some(Own { seconds, ..next });
            if let Some(embree) = embree.as_deref_mut() {
                self.peer_round(embree, finalists, &mut peers)?;
            }
            if begun.elapsed() > PATIENCE && round + 1 < self.rounds {
                break;
            }
        }
        let measure = |peer: &Peer| if self.threads == 1 { peer.total().cpu } else { peer.total().wall };
        let best = peers.into_iter().min_by(|a, b| measure(a).total_cmp(&measure(b)));
        Ok((own.context("a duel has one round at least")?, best))
    }

    fn peer_round(&self, embree: &mut Embree, finalists: &[Setup], peers: &mut Vec<Peer>) -> Result<()> {
        for (number, &setup) in finalists.iter().enumerate() {
            let build = embree.build(setup.build, self.threads)?;
            let (mut rays, mut lit) = (Seconds::default(), 0);
            for &light in self.lights {
                embree.set_light(&self.scene.lights[light].source)?;
                let (seconds, count) = embree.trace(setup.rays, self.order, self.threads)?;
                (rays, lit) = (rays + seconds, lit + count);
            }
            match peers.get_mut(number) {
                Some(peer) => {
                    peer.build = peer.build.min(build);
                    peer.rays = peer.rays.min(rays);
                }
                None => peers.push(Peer { setup, build, rays, memory: embree.memory()?, lit }),
            }
        }
        Ok(())
    }
}
