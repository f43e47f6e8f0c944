//! How times grow: with samples, triangles, lights and threads, one of them at a time.

use anyhow::Result;
use serde::Serialize;
use umbriel_geometry::LightSource;
use umbriel_scene::{Light, Scene};

use super::{
    contest::{Contest, Task},
    embree::Embree,
    options::Options,
    scenes::{city, knot},
    table::Row,
};

/// Rows that differ in one number.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Series {
    /// What the number counts.
    pub(super) over: &'static str,
    /// The number and its row.
    pub(super) points: Vec<(u64, Row)>,
}

/// The suns of the series over lights.
const SUNS: usize = 16;

/// All series.
pub(super) fn run(options: &Options, mut embree: Option<&mut Embree>) -> Result<Vec<Series>> {
    let samples = options.samples[0];
    let town = city(if options.small { 2000 } else { 20_000 })?;
    let on_town = |lights, samples, threads| Contest {
        name: "city",
        scene: &town,
        lights,
        samples,
        threads,
        task: Task::Samples,
        options,
        is_class: false,
    };
    let counts: Vec<u64> = (0..5).map(|step| (samples >> 4) << (2 * step)).filter(|&count| count > 0).collect();
    let over_samples = on_town(vec![vec![0]], &counts[..if options.small { 3 } else { 5 }], &[1]);
    let rows = over_samples.run(embree.as_deref_mut())?;
    let mut all = vec![Series::of("samples", rows, |row| row.samples)];
    let mut rows = Vec::new();
    for divisions in if options.small { [1, 2, 4] } else { [4, 8, 16] } {
        let scene = knot(94 * divisions, 19 * divisions)?;
        let contest = Contest {
            name: "knot",
            scene: &scene,
            lights: vec![vec![0]],
            samples: &[samples],
            threads: &[1],
            task: Task::Samples,
            options,
            is_class: false,
        };
        rows.extend(contest.run(embree.as_deref_mut())?);
    }
    all.push(Series::of("triangles", rows, |row| row.triangles as u64));
    let day = under_a_day(town.clone())?;
    let groups = [1, 2, 4, 8, SUNS].map(|count| (0..count).collect()).to_vec();
    let over_lights = Contest {
        name: "city",
        scene: &day,
        lights: groups,
        samples: &[samples],
        threads: &[1],
        task: Task::Samples,
        options,
        is_class: false,
    };
    all.push(Series::of("lights", over_lights.run(embree.as_deref_mut())?, |row| row.lights as u64));
    let threads: Vec<usize> = (1..=std::thread::available_parallelism().map_or(1, usize::from)).collect();
    let rows = on_town(vec![vec![0]], &[samples], &threads).run(embree)?;
    all.push(Series::of("threads", rows, |row| row.threads as u64));
    Ok(all)
}

impl Series {
    fn of(over: &'static str, rows: Vec<Row>, number: impl Fn(&Row) -> u64) -> Self {
        Self { over, points: rows.into_iter().map(|row| (number(&row), row)).collect() }
    }
}

/// The scene under suns that go from east over south to west, from 8 degrees up to 60 and down again.
fn under_a_day(mut scene: Scene) -> Result<Scene> {
    scene.lights.clear();
    for hour in 0..SUNS {
        let part = (hour as f64 + 0.5) / SUNS as f64 * std::f64::consts::PI;
        let direction = [-libm::cos(part), -0.14 - 1.6 * libm::sin(part), 0.9 * libm::sin(part)];
        let source = LightSource::sun(direction.map(|x| f64::from(x as f32)))?;
        scene.lights.push(Light::new(format!("sun {hour}"), source));
    }
    Ok(scene)
}
