//! `cargo xtask portals`: what cells and portals spare, and whether anything visible is missing; `cargo xtask office` writes the scenes.
//!
//! On offices of 200, 2,000 and 10,000 rooms: objects submitted for eyes in random rooms, by portals and by plain frustum culling; time to
//! bake the shadow of one lamp after loading, beside that in a scene of only what it reaches. Then random eyes and lamps on the stored office, in its rooms, outdoors and in the planes of portals: rays in random directions, cast
//! against all objects, must meet nothing that is not among what is reached. The table goes to `docs/portals.md` by hand, with the
//! machine that it was taken on.

use std::{path::PathBuf, time::Instant};

use anyhow::{Context, Result, anyhow, ensure};
use glam::DVec3;
use umbriel_geometry::LightSource;
use umbriel_io::{LoadOptions, load};
use umbriel_scene::{Camera, Projection, Scene};
use umbriel_shadow::{Detail, Request, Silent, bake, reached_receivers};
use umbriel_visibility::{
    Ray, RayCaster, View,
    portals::{Start, frustum_culling, reach_of_eye, reach_of_light},
};

use crate::fixtures::{Office, SplitMix64};

/// How often a lamp is baked.
const RUNS: usize = 9;

/// Which office.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct OfficeOptions {
    /// At least so many rooms
    #[arg(long, value_name = "N", default_value = "200")]
    rooms: usize,
    /// Rooms with a lamp
    #[arg(long, value_name = "N", default_value = "5")]
    lamps: usize,
    /// The folder to write office.toml and office-parts.glb to
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// How much is measured and judged.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Options {
    /// Numbers of rooms
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "200,2000,10000")]
    rooms: Vec<usize>,
    /// Eyes for which submitted objects are counted
    #[arg(long, value_name = "N", default_value = "100")]
    eyes: usize,
    /// Random eyes and lamps whose rays judge
    #[arg(long, value_name = "N", default_value = "10000")]
    judged: usize,
    /// Rays of each
    #[arg(long, value_name = "N", default_value = "100")]
    rays: usize,
}

/// Writes an office.
pub(crate) fn write_office(options: &OfficeOptions) -> Result<()> {
    let office = Office::with_rooms(options.rooms, options.lamps);
    let (text, parts) = office.files()?;
    std::fs::create_dir_all(&options.output)?;
    std::fs::write(options.output.join("office.toml"), text)?;
    std::fs::write(options.output.join("office-parts.glb"), parts)?;
    println!("{} rooms in {}", office.rooms(), options.output.join("office.toml").display());
    Ok(())
}

pub(crate) fn run(options: &Options) -> Result<()> {
    println!(
        "| rooms | objects | load s | frustum | portals | fewer | reached by a lamp | bake ms | alone ms | bake/alone |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for &rooms in &options.rooms {
        measure(rooms, options.eyes)?;
    }
    let scene = office(200)?.0;
    let (rays, met) = judge(&scene, options.judged, options.rays)?;
    println!(
        "\n{} eyes and {} lamps, {rays} rays, {met} met something: all of it was among what is reached",
        options.judged, options.judged
    );
    Ok(())
}

/// An office as the program loads it, and the seconds that took.
fn office(rooms: usize) -> Result<(Scene, f64)> {
    let folder = std::env::temp_dir().join(format!("umbriel-office-{}-{rooms}", std::process::id()));
    write_files(&folder, rooms)?;
    let start = Instant::now();
    let loaded = load(&folder.join("office.toml"), &LoadOptions::default()).context("the office is not read");
    let seconds = start.elapsed().as_secs_f64();
    std::fs::remove_dir_all(&folder)?;
    Ok((loaded?.scene, seconds))
}

fn write_files(folder: &std::path::Path, rooms: usize) -> Result<()> {
    let (text, parts) = Office::with_rooms(rooms, 5).files()?;
    std::fs::create_dir_all(folder)?;
    std::fs::write(folder.join("office.toml"), text)?;
    std::fs::write(folder.join("office-parts.glb"), parts)?;
    Ok(())
}

/// A row of the table.
fn measure(rooms: usize, eyes: usize) -> Result<()> {
    let (scene, seconds) = office(rooms)?;
    let mut random = SplitMix64::new(5);
    let (mut by_frustum, mut by_portals) = (0, 0);
    for _ in 0..eyes {
        let view = view(eye(&scene, &mut random), &mut random);
        by_frustum += frustum_culling(&scene, &view).context("an eye")?.len();
        let reach = reach_of_eye(&scene, &view).context("an eye")?;
        ensure!(reach.start == Start::Cells, "an eye is in no cell");
        by_portals += reach.objects.len();
    }
    let lamps = bake_lamps(&scene)?;
    let rooms = scene.cells.cells().iter().filter(|cell| cell.name.starts_with("room")).count();
    println!(
        "| {rooms} | {} | {seconds:.2} | {:.0} | {:.0} | {:.0} times | {:.0} | {:.1} | {:.1} | {:.2} |",
        scene.objects.len(),
        by_frustum as f64 / eyes as f64,
        by_portals as f64 / eyes as f64,
        by_frustum as f64 / by_portals as f64,
        lamps.reached,
        lamps.milliseconds,
        lamps.alone,
        lamps.milliseconds / lamps.alone,
    );
    Ok(())
}

/// Means over the lamps of an office.
struct Lamps {
    /// Objects that one reaches.
    reached: f64,
    /// Bakes one in the office, and in a scene of only the objects that it reaches: the quickest of some runs.
    milliseconds: f64,
    alone: f64,
}

/// Bakes each lamp's shadow by itself, in turns with and without the rest of the office.
fn bake_lamps(scene: &Scene) -> Result<Lamps> {
    let mut sum = Lamps { reached: 0.0, milliseconds: 0.0, alone: 0.0 };
    for lamp in 0..scene.lights.len() {
        let receivers = reached_receivers(scene, &[lamp]);
        let part = Scene {
            objects: receivers.iter().map(|&object| scene.objects[object].clone()).collect(),
            lights: vec![scene.lights[lamp].clone()],
            ..Scene::default()
        };
        let (mut best, mut alone) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..RUNS {
            best = best.min(bake_lamp(scene, lamp)?);
            alone = alone.min(bake_lamp(&part, 0)?);
        }
        sum.reached += receivers.len() as f64;
        sum.milliseconds += 1e3 * best;
        sum.alone += 1e3 * alone;
    }
    let lamps = scene.lights.len() as f64;
    Ok(Lamps { reached: sum.reached / lamps, milliseconds: sum.milliseconds / lamps, alone: sum.alone / lamps })
}

/// Seconds to find what a lamp reaches and to bake its shadow on all of it.
fn bake_lamp(scene: &Scene, lamp: usize) -> Result<f64> {
    let start = Instant::now();
    let receivers = reached_receivers(scene, &[lamp]);
    let detail = Detail::Depth { interior: 2, boundary: 6 };
    let request = Request { lights: vec![lamp], receivers, ..Request::everything(&Scene::default(), detail) };
    bake(scene, &request, &Silent).map_err(|_| anyhow!("cancelled"))?;
    Ok(start.elapsed().as_secs_f64())
}

/// A place in a random cell of the building, off the walls.
fn eye(scene: &Scene, random: &mut SplitMix64) -> DVec3 {
    let cells = scene.cells.cells();
    loop {
        if let umbriel_scene::Region::Convex(body) = &cells[random.below(cells.len())].region {
            let bounds = body.bounds();
            let at =
                |axis: usize, random: &mut SplitMix64| random.between(bounds.min[axis] + 0.25, bounds.max[axis] - 0.25);
            return DVec3::new(at(0, random), at(1, random), at(2, random));
        }
    }
}

fn direction(random: &mut SplitMix64) -> DVec3 {
    loop {
        let vector = DVec3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        if (0.01..1.0).contains(&vector.length_squared()) {
            return vector;
        }
    }
}

/// A view along a random direction that is about level.
fn view(eye: DVec3, random: &mut SplitMix64) -> View {
    let ahead = direction(random) * DVec3::new(1.0, 0.2, 1.0);
    let projection = Projection::Perspective { vertical_degrees: random.between(20.0, 90.0) };
    let camera = Camera { eye, target: eye + ahead, up: DVec3::Y, projection };
    View { camera, width: 160, height: 100 }
}

/// Where rays are cast from: half of the places are in cells, one in four outdoors, one in four in the very plane of a portal.
fn any_place(scene: &Scene, number: usize, random: &mut SplitMix64) -> DVec3 {
    match number % 4 {
        2 => on_portal(scene, random),
        3 => outdoors(scene, random),
        _ => eye(scene, random),
    }
}

/// A point of a random portal, off its borders, which lie within walls and slabs; in its plane where that is one of the axes'.
fn on_portal(scene: &Scene, random: &mut SplitMix64) -> DVec3 {
    let portals = scene.cells.portals();
    let corners = &portals[random.below(portals.len())].corners;
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let along = corners[0].lerp(corners[1], random.between(0.0, 1.0));
    middle.lerp(along.lerp(corners[2], random.between(0.0, 1.0)), 0.8)
}

/// A place near the building, in no room.
fn outdoors(scene: &Scene, random: &mut SplitMix64) -> DVec3 {
    let bounds = scene.cells.bounds().iter().copied().fold(umbriel_geometry::Aabb::EMPTY, |all, own| all.union(own));
    let far = 0.2 * bounds.size().max_element();
    loop {
        let at = |axis: usize, random: &mut SplitMix64| random.between(bounds.min[axis] - far, bounds.max[axis] + far);
        let place = DVec3::new(at(0, random), at(1, random), at(2, random));
        if scene.cells.cells_at(place).iter().all(|&cell| Some(cell) == scene.cells.outdoors()) {
            return place;
        }
    }
}

/// Casts rays from random eyes and lamps against the whole scene; what they meet must be among what is reached.
fn judge(scene: &Scene, places: usize, rays: usize) -> Result<(usize, usize)> {
    let caster = RayCaster::new(scene);
    let mut random = SplitMix64::new(11);
    let (mut cast, mut met) = (0, 0);
    for number in 0..places {
        let view = view(any_place(scene, number, &mut random), &mut random);
        let reach = reach_of_eye(scene, &view).context("an eye")?;
        let seen: Vec<usize> = reach.indices().collect();
        let lamp = any_place(scene, number / 4, &mut random);
        let lit: Vec<usize> = reach_of_light(scene, &LightSource::point(lamp.to_array())?).indices().collect();
        for _ in 0..rays {
            let pixel = [random.between(0.0, 160.0), random.between(0.0, 100.0)];
            for (ray, reached, what) in
                [(view.ray(pixel[0], pixel[1]), &seen, "eye"), (Ray::new(lamp, direction(&mut random)), &lit, "lamp")]
            {
                cast += 1;
                let Some(hit) = caster.nearest(&ray) else { continue };
                met += 1;
                let name = &scene.objects[hit.object].name;
                ensure!(
                    reached.binary_search(&hit.object).is_ok(),
                    "{what} {number}: {name} is seen by {ray:?} and missing"
                );
            }
        }
    }
    Ok((cast, met))
}
