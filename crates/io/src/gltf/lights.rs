//! Lights of KHR_lights_punctual.

use glam::DVec3;
use umbriel_geometry::{LightDefect, LightSource};
use umbriel_scene::{FindingKind, Light};

use super::{
    hierarchy::{Placed, clear_tiny, place},
    json::{Document, PunctualLight, element},
};
use crate::{error::excerpt, model::Model, names::brief_name};

/// The light of a node, if it has one.
pub(super) fn add(model: &mut Model, document: &Document, placed: &Placed) -> Result<(), String> {
    let node = &document.nodes[placed.node];
    let Some(reference) = &node.extensions().light else { return Ok(()) };
    let declared = document.extensions.lights.as_ref().map_or(&[][..], |lights| &lights.lights);
    let declared = element(declared, reference.light, "light")?;
    match light(declared, placed, document)? {
        Some(light) => {
            model.findings.add(FindingKind::SpotAsPoint, &light.name, usize::from(declared.kind == "spot"));
            model.lights.push(light);
        }
        None => model.tell(&place(placed.node, node), "its light is left out: no direction is left of it"),
    }
    Ok(())
}

/// A light, which shines along the node's −Z; `None` for a sun whose direction a matrix flattens away.
fn light(declared: &PunctualLight, placed: &Placed, document: &Document) -> Result<Option<Light>, String> {
    let source = match declared.kind.as_str() {
        "directional" => LightSource::sun(direction(placed)),
        "point" | "spot" => LightSource::point(placed.map.transform_point3(DVec3::ZERO).to_array()),
        other => {
            let other = excerpt(other);
            return Err(format!("its light has the type \"{other}\", which is none of directional, point, spot"));
        }
    };
    let name = document.nodes[placed.node].name.as_deref().or(declared.name.as_deref());
    let name = name.filter(|name| !name.is_empty()).map_or_else(|| format!("light{}", placed.node), brief_name);
    match source {
        Ok(source) => Ok(Some(Light::new(name, source))),
        Err(LightDefect::NoDirection) => Ok(None),
        Err(defect) => Err(format!("its light: {defect}")),
    }
}

/// Where the node's −Z leads. Scales do not count, says KHR_lights_punctual, which matters where one is zero: then the
/// rotations alone are followed.
fn direction(placed: &Placed) -> [f64; 3] {
    let scaled = placed.map.transform_vector3(DVec3::NEG_Z);
    let mut direction = if scaled == DVec3::ZERO { placed.turn * DVec3::NEG_Z } else { scaled }.to_array();
    clear_tiny(&mut direction);
    direction
}
