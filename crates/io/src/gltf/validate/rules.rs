//! Rules that a document breaks without leaving a doubt about what it shows: they are told.

use std::collections::HashSet;

use super::Check;
use crate::{
    gltf::{
        hierarchy,
        json::{Animation, Eye, Node},
    },
    transform::{is_affine, is_skewed, is_unit},
};

impl Check<'_> {
    /// Extensions that are required, and not among those that the document says it uses; of those that are there, `kinds` tells it.
    pub(super) fn extensions(&mut self) {
        let document = self.document;
        let required: HashSet<&str> = document.extensions_required.iter().map(String::as_str).collect();
        for (repeats, list) in [
            (document.extensions_used.repeats, "extensionsUsed"),
            (required.len() < document.extensions_required.len(), "extensionsRequired"),
        ] {
            if repeats {
                self.tell(list, "a name is there twice");
            }
        }
        if document.extensions_required.iter().any(|name| !document.uses(name)) {
            self.tell("extensionsRequired", "not all of them are among the extensionsUsed");
        }
        if document.uses("KHR_mesh_quantization") && !required.contains("KHR_mesh_quantization") {
            self.tell("KHR_mesh_quantization", "it is used and not required");
        }
    }

    /// Skins of nothing, rotations that are none, and matrices that are no product of a translation, a rotation and scales.
    pub(super) fn node(&mut self, index: usize, node: &Node) {
        let place = || hierarchy::place(index, node);
        if node.skin.is_some() && node.mesh.is_none() {
            self.tell(&place(), "it has a skin and no mesh");
        }
        if node.rotation.is_some_and(|rotation| !is_unit(rotation)) {
            self.tell(&place(), "its rotation is no unit quaternion");
        }
        if node.matrix.is_some_and(|matrix| is_skewed(&matrix)) {
            self.tell(&place(), "its matrix skews");
        }
        if node.matrix.is_some_and(|matrix| !is_affine(&matrix)) {
            self.tell(&place(), "the last row of its matrix is not quite 0 0 0 1");
        }
    }

    /// What an animation moves, and how.
    pub(super) fn motion(&mut self, animation: &Animation, place: &str) {
        let is_path = |path: &str| matches!(path, "translation" | "rotation" | "scale" | "weights" | "pointer");
        let is_way = |way: &str| matches!(way, "LINEAR" | "STEP" | "CUBICSPLINE");
        let paths_are_sound =
            animation.channels.iter().all(|channel| channel.target.path.as_deref().is_some_and(is_path));
        let ways_are_sound =
            animation.samplers.iter().all(|sampler| sampler.interpolation.as_deref().is_none_or(is_way));
        if !paths_are_sound || !ways_are_sound {
            self.tell(place, "a path or an interpolation in it is none of glTF's");
        }
    }

    /// Lights, materials, images and cameras that say too much or too little.
    pub(super) fn looks(&mut self) {
        let document = self.document;
        let lights = document.extensions.lights.iter().flat_map(|lights| &lights.lights);
        for (index, light) in lights.enumerate() {
            let is_odd = light.intensity.is_some_and(|intensity| intensity < 0.0)
                || light.range.is_some_and(|range| range <= 0.0)
                || light.color.as_ref().is_some_and(|color| color.len() != 3);
            if is_odd {
                self.tell(&format!("light {index}"), "its colour, intensity or range is none of glTF's");
            }
        }
        for (index, material) in document.materials.iter().enumerate() {
            if !matches!(material.alpha_mode.as_deref(), None | Some("OPAQUE" | "MASK" | "BLEND")) {
                self.tell(&format!("material {index}"), "its alphaMode is none of glTF's, taken as OPAQUE");
            }
        }
        for (index, image) in document.images.iter().enumerate() {
            if image.uri.is_some() == image.buffer_view.is_some() {
                self.tell(&format!("image {index}"), "it has not just one of uri and bufferView");
            }
            let view = image.buffer_view.and_then(|view| document.buffer_views.get(view));
            if view.is_some_and(|view| view.byte_stride.is_some()) {
                self.tell(&format!("image {index}"), "its buffer view has a stride");
            }
            if image.buffer_view.is_some() && image.mime_type.is_none() {
                self.tell(&format!("image {index}"), "it is in a buffer view and has no mimeType");
            }
        }
        // A camera of a node is looked at where it is read.
        let placed: HashSet<usize> = document.nodes.iter().filter_map(|node| node.camera).collect();
        for (index, camera) in document.cameras.iter().enumerate() {
            if !placed.contains(&index) && camera.perspective.is_some() == camera.orthographic.is_some() {
                self.tell(&format!("camera {index}"), "it is not either perspective or orthographic");
            }
            if !has_sound_planes(camera) {
                self.tell(
                    &format!("camera {index}"),
                    "its type is not its projection's, or its planes are out of order",
                );
            }
        }
    }
}

/// Whether a camera has the projection that its type names, and its planes are in order.
fn has_sound_planes(camera: &Eye) -> bool {
    let is_type = |name: &str| camera.kind.as_deref() == Some(name);
    let is_behind = |near: f64, far: Option<f64>| far.is_none_or(|far| far > near);
    match (&camera.perspective, &camera.orthographic) {
        (Some(eye), None) => {
            is_type("perspective") && eye.znear.is_some_and(|near| near > 0.0 && is_behind(near, eye.zfar))
        }
        (None, Some(eye)) => {
            let near = eye.znear.filter(|&near| near >= 0.0 && eye.zfar.is_some() && is_behind(near, eye.zfar));
            is_type("orthographic") && near.is_some()
        }
        // Told already.
        _ => true,
    }
}
