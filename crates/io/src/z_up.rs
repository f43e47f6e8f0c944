//! Formats that do not say which axis points up, and models that seem to mean z.

use umbriel_geometry::Aabb;
use umbriel_scene::{FindingKind, Shape};

use crate::{load::Reading, model::Model};

/// Tells that a model looks z-up, unless the user has said which axis points up.
pub(crate) fn tell_z_up(model: &mut Model, reading: &Reading) {
    model.findings.add(FindingKind::LooksZUp, "", usize::from(!reading.up_is_stated && looks_z_up(model)));
}

/// Whether the model is much flatter along z than along x and y: terrain, cities and floor plans are flat along their
/// up axis.
fn looks_z_up(model: &Model) -> bool {
    const FAR_BELOW: f64 = 0.25;
    let positions = model.objects.iter().filter_map(|object| match &object.shape {
        Shape::Mesh(mesh) => Some(mesh.positions().iter().copied()),
        _ => None,
    });
    let size = Aabb::of(positions.flatten()).size();
    size.z < FAR_BELOW * size.x.min(size.y)
}
