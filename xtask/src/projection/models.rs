//! The models of the experiment, as single meshes: files beside the workspace, and two made here that are always there.

use std::sync::Arc;

use anyhow::{Context, Result};
use glam::DVec3;
use umbriel_geometry::{LightSource, Mesh};
use umbriel_io::{LoadOptions, load};
use umbriel_octree::Viewpoint;
use umbriel_scene::{Scene, Shape};

use crate::{
    bench::{city, knot},
    workspace::root,
};

/// A model and where to look at it from.
pub(super) struct Model {
    pub(super) name: &'static str,
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

    /// The direction of a ray through the middle of a pixel of a picture with `side` pixels in a row.
    pub(super) fn direction(&self, pixel: u64, side: u64) -> DVec3 {
        let at = |place: u64| (2 * place + 1) as f64 / side as f64 - 1.0;
        self.forward + at(pixel % side) * self.right - at(pixel / side) * self.up
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
const MODELS: [(&str, Source); 8] = [
    ("spot", Source::File("spot/spot.obj")),
    ("house", Source::File("house-mask/house.glb")),
    ("bunny", Source::File("bunny/stanford-bunny.obj")),
    ("helmet", Source::File("flighthelmet/FlightHelmet.gltf")),
    ("delft", Source::File("delft-city/delft.obj")),
    ("town", Source::Made(|| city(20_000))),
    ("apartment", Source::File("apartment-meshopt/dream-apartment.glb")),
    ("knot", Source::Made(|| knot(1000, 250))),
];

/// The names of all models.
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
    let mesh = Arc::new(joined(&scene)?);
    Ok((!mesh.triangles().is_empty()).then(|| framed(name, mesh)))
}

/// All meshes of a scene as they stand in it.
fn joined(scene: &Scene) -> Result<Mesh> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for object in &scene.objects {
        let Shape::Mesh(mesh) = &object.shape else { continue };
        let first = positions.len() as u32;
        positions.extend(mesh.positions().iter().map(|&position| object.placement.round(position).to_array()));
        triangles.extend(mesh.triangles().iter().map(|triangle| triangle.map(|corner| corner + first)));
    }
    Ok(Mesh::new(positions, triangles)?)
}

/// Seen from a corner above, thirty degrees wide; the lamp hangs a tenth of the height under the top of the middle.
fn framed(name: &'static str, mesh: Arc<Mesh>) -> Model {
    let bounds = mesh.bounds();
    let (middle, size) = (bounds.center(), bounds.size());
    let radius = 0.5 * size.length();
    let back = DVec3::new(0.41, 0.57, 0.71).normalize();
    let distance = 3.2 * radius;
    let forward = -back * distance;
    let right = forward.cross(DVec3::Y).normalize() * radius;
    let up = right.cross(forward).normalize() * radius;
    let picture = Picture { eye: middle + back * distance, forward, right, up };
    let lamp = middle + DVec3::new(0.07 * size.x, 0.4 * size.y, 0.05 * size.z);
    Model { name, mesh, picture, lamp, sun: DVec3::new(0.45, -0.8, 0.3) }
}
