//! `cargo xtask pictures`: all methods of hidden surfaces on all fixtures and on real models, from ten cameras each; no pixel may
//! differ.
//!
//! The cameras stand around the scene, in its middle, far above, and look along axes and in parallel, where edges run through many
//! pixel centres at once. Times are wall times of drawing, preparing apart.

use std::{
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use anyhow::{Context, Result, ensure};
use glam::DVec3;
use umbriel_geometry::Aabb;
use umbriel_io::{LoadOptions, load};
use umbriel_scene::{Camera, Projection, Scene};
use umbriel_visibility::{
    View,
    hidden_surface::{
        DepthBuffer, DepthSort, FacePicture, HiddenSurface, RayCasting, RayTree, ScanLine, Shot, Statistics, Warnock,
        draw,
    },
};

use crate::{rasteriser, workspace::root};

/// What is drawn.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Options {
    /// Width and height of the pictures in pixels
    #[arg(long, value_name = "N", default_value = "1024")]
    size: u32,
    /// Cameras for each scene, 1 to 10
    #[arg(long, value_name = "N", default_value = "10")]
    cameras: usize,
    /// Only scenes whose path holds this
    #[arg(long, value_name = "TEXT")]
    scene: Option<String>,
    /// Time the depth buffer beside a rasteriser from the registry instead, for the first camera; needs the feature `rasterisers`
    #[arg(long)]
    rival: bool,
}

/// Real models; those that are not there are left out, with a line that says so.
const MODELS: [&str; 6] = [
    "spot/spot.obj",
    "house-mask/house.glb",
    "bunny/stanford-bunny.obj",
    "flighthelmet/FlightHelmet.gltf",
    "delft-city/delft.obj",
    "apartment-meshopt/dream-apartment.glb",
];

pub(crate) fn run(options: &Options) -> Result<()> {
    let (mut differing, mut pictures) = (0, 0);
    for path in scenes()? {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if options.scene.as_ref().is_some_and(|part| !path.to_string_lossy().contains(part.as_str())) {
            continue;
        }
        if !path.is_file() {
            println!("{name}: left out, it is not there");
            continue;
        }
        let scene =
            load(&path, &LoadOptions::default()).with_context(|| format!("cannot read {}", path.display()))?.scene;
        if options.rival {
            if scene.objects.iter().any(|object| object.facets().is_none()) {
                println!("{name}: left out, the rival draws triangles only");
                continue;
            }
            println!("{name}");
            rasteriser::compare(&scene, &View::around(&scene, 30.0, 35.0, options.size, options.size))?;
            continue;
        }
        let mut totals = Totals::default();
        for view in views(&scene, options.size).into_iter().take(options.cameras) {
            totals.add(&scene, &view)?;
        }
        println!(
            "{name}: {} pictures, {} pixels with a face, {} differ",
            totals.pictures, totals.covered, totals.differing
        );
        totals.rows.iter().for_each(|row| println!("  {}", row.text()));
        differing += totals.differing;
        pictures += totals.pictures;
    }
    if options.rival {
        return Ok(());
    }
    ensure!(pictures > 0, "no scene was drawn");
    ensure!(differing == 0, "{differing} pixels differ");
    println!("{pictures} pictures by each method, no pixel differs");
    Ok(())
}

/// All fixtures that are scenes, then the models.
fn scenes() -> Result<Vec<PathBuf>> {
    let folder = root().join("fixtures");
    let entries = std::fs::read_dir(&folder).with_context(|| format!("cannot read {}", folder.display()))?;
    let mut paths = entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?;
    let is_scene = |path: &Path| {
        path.extension().is_some_and(|kind| ["toml", "obj", "gltf", "glb"].iter().any(|known| kind == *known))
    };
    paths.retain(|path| is_scene(path));
    paths.push(folder.join("office/office.toml"));
    paths.sort();
    paths.extend(MODELS.iter().map(|model| root().join("../shared/data").join(model)));
    Ok(paths)
}

/// Ten cameras.
fn views(scene: &Scene, size: u32) -> Vec<View> {
    let around = [(30.0, 35.0), (-60.0, 20.0), (120.0, 50.0), (200.0, 5.0), (0.0, 0.0), (90.0, 89.0)];
    let mut views: Vec<View> =
        around.iter().map(|&(turn, height)| View::around(scene, turn, height, size, size)).collect();
    let bounds = scene.objects.iter().map(|object| object.bounds()).fold(Aabb::EMPTY, |all, own| all.union(own));
    let (middle, reach) = (bounds.center(), bounds.size().length().max(f64::MIN_POSITIVE));
    let camera = |eye: DVec3, target: DVec3, up: DVec3, projection| View {
        camera: Camera { eye, target, up, projection },
        width: size,
        height: size,
    };
    let (wide, parallel) =
        (Projection::Perspective { vertical_degrees: 80.0 }, Projection::Orthographic { height: reach });
    views.push(camera(middle, middle + DVec3::new(1.0, -0.2, 0.4), DVec3::Y, wide));
    views.push(camera(middle + reach * DVec3::Z, middle, DVec3::Y, parallel));
    views.push(camera(middle + reach * DVec3::Y, middle, DVec3::NEG_Z, parallel));
    views.push(camera(middle + reach * DVec3::new(0.6, 0.5, 0.7), middle, DVec3::Y, parallel));
    views
}

/// What one method did over all cameras of a scene.
struct Row {
    name: &'static str,
    time: Duration,
    work: Statistics,
}

impl Row {
    fn text(&self) -> String {
        let Statistics { windows, tests, depths, skipped, written, divided, judged } = self.work;
        format!(
            "{:<15}{:>9.3} s  windows {windows}, tests {tests}, depths {depths}, skipped {skipped}, written {written}, \
             divided {divided}, judged {judged}",
            self.name,
            self.time.as_secs_f64()
        )
    }
}

#[derive(Default)]
struct Totals {
    rows: Vec<Row>,
    pictures: usize,
    covered: usize,
    differing: usize,
}

impl Totals {
    fn add(&mut self, scene: &Scene, view: &View) -> Result<()> {
        let shot = Shot::new(scene, view)?;
        let methods: [Box<dyn HiddenSurface>; 6] = [
            Box::new(RayCasting::new(&shot, RayTree::Boxes)),
            Box::new(RayCasting::new(&shot, RayTree::Octree)),
            Box::new(DepthBuffer::default()),
            Box::new(ScanLine::default()),
            Box::new(Warnock::default()),
            Box::new(DepthSort::default()),
        ];
        let mut first: Option<FacePicture> = None;
        for (place, method) in methods.iter().enumerate() {
            let start = Instant::now();
            let (picture, work) = draw(method.as_ref(), &shot);
            let time = start.elapsed();
            if self.rows.len() <= place {
                self.rows.push(Row { name: method.name(), time: Duration::ZERO, work: Statistics::default() });
            }
            self.rows[place].time += time;
            self.rows[place].work += work;
            match &first {
                Some(first) => self.differing += picture.differences(first),
                None => {
                    self.covered += picture.covered();
                    first = Some(picture);
                }
            }
        }
        self.pictures += 1;
        Ok(())
    }
}
