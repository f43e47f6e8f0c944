//! `cargo xtask bench --proofs`: what proofs on the ground take beside as many samples, and how much they leave open.
//!
//! Cells of the ground at boundary depth 10 and as many samples of it are asked for in turn, on one thread. What is left
//! undecided is held against the visible outline times the edge of the smallest cells: a border of length l crosses some 4/π · l
//! / edge cells of a grid, so any method that tells by whole cells leaves about 1.3 of this. The outline is the border between light and
//! shadow on the ground, measured by Crofton's formula (Cauchy's for lines in four directions): with n crossings over lines that lie d
//! apart, its length is π/2 · d times the mean of n, within some 5 % for outlines of one direction. The answers on the
//! lines are exact; borders that are closer to each other than two points of a line are missed.

use std::f64::consts::{FRAC_PI_4, FRAC_PI_8};

use anyhow::{Context, Result, anyhow, ensure};
use glam::{DVec2, DVec3};
use rayon::ThreadPool;
use umbriel_geometry::{Aabb, LightSource};
use umbriel_scene::{Scene, Sides};
use umbriel_shadow::{Detail, Points, Queries, Report, Request, Silent, Verdict, bake};

use super::{
    clock::{Seconds, timed},
    contest::asked_lights,
    duel::{bake_once, request},
    options::Options,
    scenes::{CLASSES, bodies, object},
};

/// The boundary depth of the proofs.
const DEPTH: u8 = 10;
/// Scenes over ground; a town on terrain gets a plane under it.
const SCENES: [&str; 6] = ["bunny", "spot", "knot", "city", "delft", "field"];
/// Lines in each of four directions, and points on each.
const LINES: u32 = 400;
const POINTS: u32 = 4000;

/// Prints a line for each scene and light.
pub(super) fn run(options: &Options) -> Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    println!("scene    light       edge, m  cells   proofs  samples   ratio  undecided  outline x edge  ratio");
    for class in CLASSES.iter().filter(|class| SCENES.contains(&class.name)) {
        if !options.scene.is_empty() && !options.scene.iter().any(|scene| scene == class.name) {
            continue;
        }
        let Some(scene) = (class.make)()? else {
            println!("{:<8} left out: its data is not there", class.name);
            continue;
        };
        let scene = with_ground(scene)?;
        for light in asked_lights(&scene, options) {
            let figures = Figures::take(&scene, light, options.runs, &pool)?;
            println!("{:<8} {:<10} {}", class.name, scene.lights[light].name, figures.line());
        }
    }
    Ok(())
}

/// The scene with an object `ground` as its first.
fn with_ground(mut scene: Scene) -> Result<Scene> {
    if let Some(place) = scene.objects.iter().position(|object| object.name == "ground") {
        scene.objects.swap(0, place);
        return Ok(scene);
    }
    let bounds = scene.objects.iter().filter_map(|object| object.facets()).map(|facets| facets.bounds());
    let bounds = bounds.fold(Aabb::EMPTY, Aabb::union);
    let ([x, y, z], size) = (bounds.center().to_array(), bounds.size());
    let half = 0.5 * size.x.max(size.z);
    let height = y - 0.5 * size.y - size.y / 64.0;
    let ground = bodies::ground([x - half, z - half], [x + half, z + half], height);
    scene.objects.insert(0, object("ground", &ground, Sides::One)?);
    Ok(scene)
}

/// What is measured for one scene and light.
#[derive(Clone, Copy, Debug)]
struct Figures {
    /// Of the smallest cells, metres.
    edge: f64,
    /// As many samples are asked for.
    cells: u64,
    proofs: Seconds,
    samples: Seconds,
    /// Square metres.
    undecided: f64,
    /// Metres.
    outline: f64,
}

impl Figures {
    fn take(scene: &Scene, light: usize, rounds: usize, pool: &ThreadPool) -> Result<Self> {
        let detail = Detail::Depth { interior: 0, boundary: DEPTH };
        let asked = |keep_cells| Request {
            receivers: vec![0],
            lights: vec![light],
            keep_cells,
            ..Request::everything(scene, detail)
        };
        let report = bake(scene, &asked(true), &Silent)?;
        let (ground, edge) = (&report.lights[0].objects[0], smallest_edge(scene, &report)?);
        let cells = (ground.area / (edge * edge)).round() as u64;
        let sampled = Request { receivers: vec![0], ..request(scene, &[light], cells) };
        let (mut proofs, mut samples) = (Seconds::MOST, Seconds::MOST);
        for _ in 0..rounds {
            let (proved, seconds) = timed(|| pool.install(|| bake(scene, &asked(false), &Silent)));
            proved.map_err(|_| anyhow!("the bake was cancelled"))?;
            proofs = proofs.min(seconds);
            samples = samples.min(bake_once(scene, &sampled, pool)?.seconds);
        }
        let outline = outline(scene, &scene.lights[light].source)?;
        Ok(Self { edge, cells, proofs, samples, undecided: ground.undecided(), outline })
    }

    /// Undecided area over outline times edge.
    fn width(&self) -> f64 {
        self.undecided / (self.outline * self.edge)
    }

    fn line(&self) -> String {
        format!(
            "{:>8.4} {:>6.1}M {:>8.4} {:>8.4} {:>7.2} {:>10.4} {:>15.4} {:>6.2}",
            self.edge,
            self.cells as f64 / f64::from(1 << 20),
            self.proofs.cpu,
            self.samples.cpu,
            self.proofs.cpu / self.samples.cpu,
            self.undecided,
            self.outline * self.edge,
            self.width()
        )
    }
}

/// The longer edge of the smallest cells on the ground.
fn smallest_edge(scene: &Scene, report: &Report) -> Result<f64> {
    let cells = &report.lights[0].objects[0].cells;
    let undecided = cells.iter().filter(|cell| cell.verdict == Verdict::Undecided);
    let cell = undecided.max_by_key(|cell| cell.level).context("something on the ground is undecided")?;
    let facets = scene.objects[0].facets().context("the ground is flat")?;
    let corners = facets.facet(cell.face as usize).corners();
    let place = |[u, v]: [f64; 2]| {
        let [a, b, d] = [0, 1, corners.len() - 1].map(|corner| facets.positions()[corners[corner] as usize]);
        a + (b - a) * u + (d - a) * v
    };
    let corner = place(cell.point([0.0, 0.0]));
    let edges = [[1.0, 0.0], [0.0, 1.0]].map(|along| (place(cell.point(along)) - corner).length());
    Ok(edges[0].max(edges[1]))
}

/// The length of the border of light and shadow on the level ground, metres.
fn outline(scene: &Scene, light: &LightSource) -> Result<f64> {
    let ground = scene.objects[0].facets().context("the ground is flat")?.bounds();
    let others = Scene { objects: scene.objects[1..].to_vec().into(), ..Scene::default() };
    let queries = Queries::new(&others);
    let (middle, half) = (ground.center(), 0.5 * ground.size());
    ensure!(half.y == 0.0, "the ground is level");
    // Lines through the circle round the ground, of which the part over the ground counts.
    let reach = half.x.hypot(half.z);
    let (apart, step) = (2.0 * reach / f64::from(LINES), 2.0 * reach / f64::from(POINTS));
    let mut crossings = 0u64;
    for direction in 0..4 {
        let along = DVec2::from_angle(f64::from(direction) * FRAC_PI_4);
        let (mut points, mut lines): (Vec<[f64; 3]>, Vec<usize>) = (Vec::new(), Vec::new());
        for line in 0..LINES {
            let offset = along.perp() * ((f64::from(line) + 0.5) * apart - reach);
            let places = (0..POINTS).map(|point| offset + along * ((f64::from(point) + 0.5) * step - reach));
            let over = places.filter(|place| place.x.abs() < half.x && place.y.abs() < half.z);
            points.extend(over.map(|place| (middle + DVec3::new(place.x, 0.0, place.y)).to_array()));
            lines.push(points.len());
        }
        let lit = queries.lit_many(Points::FreeDouble(&points), light, &Silent)?;
        let starts = std::iter::once(0).chain(lines.iter().copied());
        let of_line = |(from, to): (usize, &usize)| lit[from..*to].windows(2).filter(|pair| pair[0] != pair[1]).count();
        crossings += starts.zip(&lines).map(|line| of_line(line) as u64).sum::<u64>();
    }
    Ok(FRAC_PI_8 * apart * crossings as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::scenes::{city, sun_at};

    /// One box: the outline of its shadow on the ground is known, the part below the box left out.
    #[test]
    fn an_outline_is_measured() {
        let mut scene = with_ground(city(1).expect("a house")).expect("on ground");
        let size = scene.objects[1].facets().expect("a box").bounds().size();
        scene.lights = vec![sun_at(180.0, 45.0).expect("a sun in the south")];
        let known = 2.0 * (size.x + size.z + size.y);
        let found = outline(&scene, &scene.lights[0].source).expect("an answer");
        // The lines lie in four directions: a rectangle along two of them is the worst case, π/8·(1 + √2) = 0.948.
        assert!((found / known - 0.948).abs() < 0.02, "{found} of {known}");
    }

    #[test]
    fn what_is_left_open_on_the_ground_is_a_thin_line() {
        let scene = with_ground(city(100).expect("a town")).expect("on ground");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        for light in 0..2 {
            let figures = Figures::take(&scene, light, 1, &pool).expect("figures");
            assert!(figures.width() < 2.0, "{figures:?}");
        }
    }
}
