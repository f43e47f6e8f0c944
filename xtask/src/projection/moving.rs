//! What a projection costs to renew where a part of the model moved: the triangles of a box round a corner, as an object among others.

use std::sync::Arc;

use anyhow::{Result, ensure};
use glam::DVec3;
use umbriel_geometry::Mesh;
use umbriel_octree::{Projection, ProjectionOptions};

use super::{
    measure::Rays,
    models::{Model, model},
};
use crate::bench::clock::timed;

/// Edges of the box whose triangles move, over the model's size.
const SHARES: [f64; 3] = [0.02, 0.08, 0.32];

pub(super) fn run(names: impl Iterator<Item = &'static str>) -> Result<()> {
    for name in names {
        let Some(model) = model(name)? else { continue };
        for rays in Rays::ALL {
            let max_level = ProjectionOptions::level_for(model.mesh.triangles().len());
            let options = ProjectionOptions { max_level, ..ProjectionOptions::default() };
            let former = Projection::build(Arc::clone(&model.mesh), rays.viewpoint(&model), &options)?;
            for share in SHARES {
                let mesh = Arc::new(moved(&model, share)?);
                let (renewed, time) = timed(|| former.renewed(Arc::clone(&mesh)));
                let (renewed, renewal) = renewed?;
                let (built, whole) = timed(|| Projection::build(mesh, rays.viewpoint(&model), &options));
                ensure!(renewed == built?, "{name}: what was renewed is not what is built");
                println!(
                    "{name:<9} {rays:?}: {} of {} triangles moved, {} of {} leaves made anew{}: {:.1} ms, {:.1} ms to build, {:.1} %",
                    renewal.moved,
                    model.mesh.triangles().len(),
                    renewal.leaves,
                    renewed.report().leaves,
                    if renewal.is_whole { " (all)" } else { "" },
                    time.cpu * 1e3,
                    whole.cpu * 1e3,
                    100.0 * time.cpu / whole.cpu,
                );
            }
        }
    }
    Ok(())
}

/// The model with the triangles in a box round one of its corners moved towards its middle by a hundredth of its size.
fn moved(model: &Model, share: f64) -> Result<Mesh> {
    let mesh = &model.mesh;
    let (bounds, triangles) = (mesh.bounds(), mesh.triangles());
    let size = bounds.size().max_element();
    let place = mesh.positions()[triangles[triangles.len() / 3][0] as usize];
    let shift = (bounds.center() - place).normalize_or(DVec3::Y) * (0.01 * size);
    let is_near = |x: DVec3| (x - place).abs().max_element() <= 0.5 * share * size;
    let (mut positions, mut corners) = (Vec::new(), Vec::new());
    for triangle in triangles {
        let own = triangle.map(|corner| mesh.positions()[corner as usize]);
        let is_moved = own.iter().all(|&x| is_near(x));
        let first = positions.len() as u32;
        corners.push([first, first + 1, first + 2]);
        positions.extend(own.map(|x| (if is_moved { x + shift } else { x }).to_array()));
    }
    Ok(Mesh::new(positions, corners)?)
}
