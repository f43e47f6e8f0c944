//! Scenes from files beside the workspace, which is where large data lies; absent, they are left out.

use std::path::Path;

use anyhow::{Context, Result};
use glam::DVec3;
use umbriel_geometry::Aabb;
use umbriel_io::{LoadOptions, load};
use umbriel_scene::{Object, Scene, Shape, Sides};

use super::{object, on_a_plane, scene};
use crate::{fixtures::meshes::TriangleMesh, workspace::root};

/// The Stanford bunny.
pub(super) fn bunny() -> Result<Option<Scene>> {
    alone("bunny/stanford-bunny.obj")
}

/// A cow.
pub(super) fn spot() -> Result<Option<Scene>> {
    alone("spot/spot.obj")
}

/// Buildings, terrain, water and roads, an object each; a lamp over the middle.
pub(super) fn delft() -> Result<Option<Scene>> {
    let Some(meshes) = meshes("delft-city/delft.obj")? else { return Ok(None) };
    let bounds = Aabb::of(meshes.iter().flat_map(|(_, mesh)| mesh.positions.iter().copied()));
    let lamp = bounds.center() + DVec3::Y * bounds.size().x.max(bounds.size().z) / 8.0;
    scene(one_sided(&meshes)?, lamp).map(Some)
}

/// A file of one's own, its meshes with one side each; with its lights, or else the two suns and a lamp over the middle.
pub(crate) fn of_file(path: &Path) -> Result<Scene> {
    let mut loaded = loaded(path)?;
    let lights = std::mem::take(&mut loaded.lights);
    let meshes = placed_meshes(loaded);
    let bounds = Aabb::of(meshes.iter().flat_map(|(_, mesh)| mesh.positions.iter().copied()));
    let lamp = bounds.center() + DVec3::Y * bounds.size().max_element();
    let made = scene(one_sided(&meshes)?, lamp)?;
    Ok(if lights.is_empty() { made } else { Scene { lights, ..made } })
}

/// All meshes of a file as one, on a plane.
fn alone(path: &str) -> Result<Option<Scene>> {
    let Some(meshes) = meshes(path)? else { return Ok(None) };
    let mut whole = TriangleMesh::default();
    meshes.iter().for_each(|(_, mesh)| whole.append(mesh));
    on_a_plane(&whole).map(Some)
}

/// The placed meshes of a file by the names of their objects.
fn meshes(path: &str) -> Result<Option<Vec<(String, TriangleMesh)>>> {
    let path = root().join("../shared/data").join(path);
    if !path.is_file() {
        return Ok(None);
    }
    Ok(Some(placed_meshes(loaded(&path)?)))
}

fn loaded(path: &Path) -> Result<Scene> {
    let loaded = load(path, &LoadOptions::default()).with_context(|| format!("cannot load {}", path.display()))?;
    Ok(loaded.scene)
}

/// An object for each mesh.
fn one_sided(meshes: &[(String, TriangleMesh)]) -> Result<Vec<Object>> {
    meshes.iter().map(|(name, mesh)| object(name, mesh, Sides::One)).collect()
}

/// The placed meshes of a scene by the names of their objects; what is no mesh is left out.
fn placed_meshes(scene: Scene) -> Vec<(String, TriangleMesh)> {
    let meshes = scene.objects.into_iter().filter_map(|object| {
        let Shape::Mesh(mesh) = &object.shape else { return None };
        let positions = mesh.positions().iter().map(|&position| object.placement.round(position)).collect();
        let placed = TriangleMesh { positions, triangles: mesh.triangles().to_vec() };
        let placed = if object.placement.is_mirrored() { placed.flipped() } else { placed };
        Some((object.name, placed))
    });
    meshes.collect()
}
