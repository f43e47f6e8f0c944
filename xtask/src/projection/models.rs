//! The models of the experiment, as single meshes: files beside the workspace, and some made here that are always there. The
//! judge takes every scene besides: all fixtures, and all files beside the workspace.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use anyhow::{Context, Result};
use glam::DVec3;
use umbriel_geometry::{LightSource, Mesh, Placement};
use umbriel_io::{LoadOptions, load};
use umbriel_octree::Viewpoint;
use umbriel_scene::{Camera, Object, Projection, Scene, Shape, Sides};
use umbriel_shadow::rivals::Polygons;
use umbriel_visibility::View;

use crate::{
    bench::{city, knot},
    fixtures::SplitMix64,
    workspace::root,
};

/// A model and where to look at it from.
pub(super) struct Model {
    pub(super) name: String,
    pub(super) mesh: Arc<Mesh>,
    /// A picture that frames it.
    pub(super) picture: Picture,
    /// A lamp among its parts or over them.
    pub(super) lamp: DVec3,
    /// The way that the light of its sun travels.
    pub(super) sun: DVec3,
}

/// A picture as a viewpoint has it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Picture {
    pub(super) eye: DVec3,
    pub(super) forward: DVec3,
    pub(super) right: DVec3,
    pub(super) up: DVec3,
}

impl Picture {
    pub(super) fn viewpoint(&self) -> Viewpoint {
        let Self { eye, forward, right, up } = *self;
        Viewpoint::Picture { eye, forward, right, up }
    }

    /// The same as a view of `side` × `side` pixels.
    pub(super) fn view(&self, side: u32) -> View {
        let Self { eye, forward, right, .. } = *self;
        let vertical_degrees = 2.0 * (right.length() / forward.length()).atan().to_degrees();
        let projection = Projection::Perspective { vertical_degrees };
        View { camera: Camera { eye, target: eye + forward, up: DVec3::Y, projection }, width: side, height: side }
    }

    /// The direction of a ray through the middle of a pixel of a picture with `side` pixels in a row.
    pub(super) fn direction(&self, pixel: u64, side: u64) -> DVec3 {
        let at = |place: u64| (2 * place + 1) as f64 / side as f64 - 1.0;
        self.at([at(pixel % side), -at(pixel / side)])
    }

    /// The direction through a place of the picture, −1 to 1 each.
    pub(super) fn at(&self, [a, b]: [f64; 2]) -> DVec3 {
        self.forward + a * self.right + b * self.up
    }
}

impl Model {
    pub(super) fn lamp_source(&self) -> Result<LightSource> {
        Ok(LightSource::point(self.lamp.to_array())?)
    }

    pub(super) fn sun_source(&self) -> Result<LightSource> {
        Ok(LightSource::sun(self.sun.to_array())?)
    }
}

/// Where a model comes from.
enum Source {
    File(&'static str),
    Made(fn() -> Result<Scene>),
}

/// From small to large.
const MODELS: [(&str, Source); 11] = [
    ("soup", Source::Made(|| soup(1000, 1.0))),
    ("spot", Source::File("spot/spot.obj")),
    ("house", Source::File("house-mask/house.glb")),
    ("bunny", Source::File("bunny/stanford-bunny.obj")),
    ("litter", Source::Made(|| soup(30_000, 0.05))),
    ("helmet", Source::File("flighthelmet/FlightHelmet.gltf")),
    ("delft", Source::File("delft-city/delft.obj")),
    ("town", Source::Made(|| city(20_000))),
    ("apartment", Source::File("apartment-meshopt/dream-apartment.glb")),
    ("knot", Source::Made(|| knot(1000, 250))),
    ("dense", Source::Made(|| knot(2000, 500))),
];

/// Triangles at random in a cube of edge 1, each within a cube of this edge: the larger, the worse for any tree.
fn soup(triangles: usize, edge: f64) -> Result<Scene> {
    let mut random = SplitMix64::new(17);
    let mut vector =
        |from: f64, to: f64| DVec3::new(random.between(from, to), random.between(from, to), random.between(from, to));
    let corners = (0..triangles).flat_map(|_| {
        let place = vector(0.0, 1.0 - edge);
        [(); 3].map(|()| (place + vector(0.0, edge)).to_array())
    });
    let mesh = Mesh::new(corners.collect(), (0..triangles as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect())?;
    let object = Object::new("soup".to_owned(), Shape::Mesh(Arc::new(mesh)), Placement::IDENTITY, Sides::Auto)?;
    Ok(Scene { objects: [object].into(), ..Scene::default() })
}

/// The models that are made here: no file holds them.
pub(super) fn made() -> impl Iterator<Item = &'static str> {
    MODELS.iter().filter(|(_, source)| matches!(source, Source::Made(_))).map(|(name, _)| *name)
}

/// The names of all models of the experiment.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    MODELS.iter().map(|(name, _)| *name)
}

/// A model; `None`, with a message, where its file is absent or of a kind that is not read.
pub(super) fn model(name: &str) -> Result<Option<Model>> {
    let (name, source) = MODELS.iter().find(|(known, _)| *known == name).context("no such model")?;
    let scene = match source {
        Source::Made(make) => make()?,
        Source::File(file) => {
            let path = root().join("../shared/data").join(file);
            if !path.is_file() {
                println!("{name:<9} left out: {file} is not there");
                return Ok(None);
            }
            match load(&path, &LoadOptions::default()) {
                Ok(loaded) => loaded.scene,
                Err(error) => {
                    println!("{name:<9} left out: {error}");
                    return Ok(None);
                }
            }
        }
    };
    let mesh = joined(&scene);
    Ok((!mesh.triangles().is_empty()).then(|| framed(name, mesh)))
}

/// How often each patch of a curved body is divided along its edges: octrees hold triangles.
const DIVISIONS: u32 = 6;

/// All faces of a scene as they stand in it, as triangles.
fn joined(scene: &Scene) -> Arc<Mesh> {
    Arc::clone(Polygons::new(scene, DIVISIONS).mesh())
}

/// Where scenes lie, from the workspace's root.
const FOLDERS: [&str; 2] = ["fixtures", "../shared/data"];

/// Folders of bytes that are no scenes on purpose, and of results.
const NO_SCENES: [&str; 2] = ["fuzz", "expected"];

/// All scene files, by their paths.
pub(super) fn scene_files() -> Vec<PathBuf> {
    let mut files = Vec::new();
    FOLDERS.iter().for_each(|folder| add_scene_files(&root().join(folder), &mut files));
    // Small ones first.
    files.sort_by_cached_key(|file| (fs::metadata(file).map_or(0, |metadata| metadata.len()), file.clone()));
    files
}

fn add_scene_files(folder: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        let has_scenes = !NO_SCENES.iter().any(|name| path.file_name().is_some_and(|own| own == *name));
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        if path.is_dir() && has_scenes {
            add_scene_files(&path, files);
        } else if ["toml", "obj", "gltf", "glb"].contains(&extension) {
            files.push(path);
        }
    }
}

/// A scene file as a model; `None`, with a message, where it cannot be read or holds no faces.
pub(super) fn model_of(path: &Path) -> Option<Model> {
    let name = path.strip_prefix(root()).unwrap_or(path).display().to_string();
    match load(path, &LoadOptions::default()) {
        Ok(loaded) => {
            let mesh = joined(&loaded.scene);
            if mesh.triangles().is_empty() {
                println!("{name} left out: it has no faces");
            }
            (!mesh.triangles().is_empty()).then(|| framed(&name, mesh))
        }
        Err(error) => {
            println!("{name} left out: {error}");
            None
        }
    }
}

/// Seen from a corner above, thirty degrees wide; the lamp hangs a tenth of the height under the top of the middle.
fn framed(name: &str, mesh: Arc<Mesh>) -> Model {
    let bounds = mesh.bounds();
    let (middle, size) = (bounds.center(), bounds.size());
    let picture = Picture::of(&mesh, DVec3::new(0.41, 0.57, 0.71), 3.2, 1.0 / 3.2);
    let lamp = middle + DVec3::new(0.07 * size.x, 0.4 * size.y, 0.05 * size.z);
    Model { name: name.to_owned(), mesh, picture, lamp, sun: DVec3::new(0.45, -0.8, 0.3) }
}

impl Model {
    /// The same seen from near and low on another side, sixty degrees wide: much of it lies outside the picture.
    pub(super) fn seen_from_near(&self) -> Self {
        let picture = Picture::of(&self.mesh, DVec3::new(-0.61, 0.23, 0.48), 1.1, 0.58);
        Self { name: format!("{} from near", self.name), mesh: Arc::clone(&self.mesh), picture, ..*self }
    }
}

impl Picture {
    /// Of a mesh from a direction, so many radii of it away, and so wide for its distance.
    fn of(mesh: &Mesh, back: DVec3, radii: f64, width: f64) -> Self {
        let (middle, radius) = (mesh.bounds().center(), 0.5 * mesh.bounds().size().length());
        let back = back.normalize() * (radii * radius);
        let forward = DVec3::ZERO - back;
        let half = width * radii * radius;
        let right = forward.cross(DVec3::Y).normalize() * half;
        let up = right.cross(forward).normalize() * half;
        Self { eye: middle + back, forward, right, up }
    }
}
