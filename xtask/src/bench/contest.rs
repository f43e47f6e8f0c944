//! All duels over one scene: every number of samples, group of lights and number of threads.

use std::process::Command;

use anyhow::Result;
use umbriel_scene::Scene;

use super::{
    clock::MemoryPeak,
    duel::{Duel, FirstLook, bake_once, request},
    embree::{Embree, Setup, scratch},
    options::Options,
    rays::Soup,
    rivals::{Starts, all},
    table::{OwnFigures, PeerFigures, RivalFigures, Row},
};

/// A scene and what varies.
pub(super) struct Contest<'a> {
    pub(super) name: &'a str,
    pub(super) scene: &'a Scene,
    /// Each group is one bake.
    pub(super) lights: Vec<Vec<usize>>,
    pub(super) samples: &'a [u64],
    pub(super) threads: &'a [usize],
    pub(super) options: &'a Options,
    /// Whether `--scene` makes this scene.
    pub(super) is_class: bool,
}

impl Contest<'_> {
    /// Measures and shows every row.
    pub(super) fn run(&self, mut embree: Option<&mut Embree>) -> Result<Vec<Row>> {
        let soup = Soup::of(self.scene)?;
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
                    let row = self.row(&soup, lights, (samples, threads), embree.as_deref_mut(), &finalists)?;
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
        FirstLook::take(embree, self.scene, &first, [samples, most], self.options.order)
    }

    fn row(
        &self,
        soup: &Soup,
        lights: &[usize],
        (samples, threads): (u64, usize),
        embree: Option<&mut Embree>,
        finalists: &[Setup],
    ) -> Result<Row> {
        let request = request(self.scene, lights, samples);
        let (rounds, order) = (self.options.runs, self.options.order);
        let (own, peer) = Duel { scene: self.scene, request, threads, rounds, order }.run(embree, finalists)?;
        let light = match lights {
            [light] => self.scene.lights[*light].name.clone(),
            _ => format!("{} lights", lights.len()),
        };
        let memory = if self.is_class && lights.len() == 1 { self.memory(&light, samples, threads) } else { None };
        let rivals = if self.options.rivals && threads == 1 { self.rivals(soup, lights, samples)? } else { Vec::new() };
        Ok(Row {
            scene: self.name.into(),
            triangles: soup.triangles.len(),
            light,
            lights: lights.len(),
            samples,
            threads,
            own: OwnFigures::new(own, memory),
            embree: peer.map(PeerFigures::new),
            rivals,
        })
    }

    /// The peak of one bake in a process of its own.
    fn memory(&self, light: &str, samples: u64, threads: usize) -> Option<u64> {
        let mut own = Command::new(std::env::current_exe().ok()?);
        own.args(["bench", "--memory", "--scene", self.name, "--light", light]);
        // With glibc: what is freed goes back to the system, so that making the scene leaves nothing behind.
        own.env("MALLOC_MMAP_THRESHOLD_", "65536").env("MALLOC_TRIM_THRESHOLD_", "65536");
        own.args(["--samples", &samples.to_string(), "--threads", &threads.to_string()]);
        String::from_utf8(own.output().ok()?.stdout).ok()?.trim().parse().ok()
    }

    /// Each rival once: they are not close.
    fn rivals(&self, soup: &Soup, lights: &[usize], samples: u64) -> Result<Vec<RivalFigures>> {
        let [light] = lights else { return Ok(Vec::new()) };
        let starts = Starts::of(soup, self.scene, &request(self.scene, lights, samples));
        let figures = all().into_iter().map(|rival| {
            let (total, lit) = starts.run(&rival, soup, &self.scene.lights[*light].source)?;
            Ok(RivalFigures { name: rival.name, total, lit })
        });
        figures.collect()
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
    let (report, _) = bake_once(scene, &request, &pool)?;
    if let Some(bytes) = peak.bytes() {
        println!("{bytes}");
    }
    drop(report);
    Ok(())
}
