//! Rules that a document breaks without leaving a doubt about what it shows: they are told.

use std::{
    collections::{BTreeSet, HashSet},
    f64::consts::{FRAC_PI_2, FRAC_PI_4, PI},
};

use glam::DAffine3;
use umbriel_geometry::MAX_MAGNITUDE;

use super::Check;
use crate::{
    gltf::{
        hierarchy,
        json::{Eye, Image, ImplicitShape, Node, Orthographic, Perspective, PunctualLight, SpotCone},
        shapes::body,
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

    /// Skins, weights and instances of nothing, rotations that are none, matrices that are no product of a translation, a rotation and scales, and numbers that no scene has.
    pub(super) fn node(&mut self, index: usize, node: &Node) {
        let place = || hierarchy::place(index, node);
        if node.skin.is_some() && node.mesh.is_none() {
            self.tell(&place(), "it has a skin and no mesh");
        }
        if node.weights.is_some() && node.mesh.is_none() {
            self.tell(&place(), "it has weights and no mesh");
        }
        if node.extensions().instancing.is_some() && node.mesh.is_none() {
            self.tell(&place(), "it has EXT_mesh_gpu_instancing and no mesh");
        }
        if node.rotation.as_deref().is_some_and(|rotation| !is_unit(*rotation)) {
            self.tell(&place(), "its rotation is no unit quaternion");
        }
        if node.matrix.as_ref().is_some_and(|matrix| is_skewed(matrix)) {
            self.tell(&place(), "its matrix skews");
        }
        if node.matrix.as_ref().is_some_and(|matrix| !is_affine(matrix)) {
            self.tell(&place(), "the last row of its matrix is not quite 0 0 0 1");
        }
        // What is shown there is refused where it is placed.
        let is_far = |map: DAffine3| map.to_cols_array().iter().any(|entry| entry.abs() > MAX_MAGNITUDE);
        if hierarchy::own_map(node).is_ok_and(is_far) {
            self.tell(&place(), "numbers of its matrix, translation or scale are above 2^200");
        }
    }

    /// Lights, bodies, materials, images, cameras and variants that say too much or too little; the projections of `read` cameras are sound, or told.
    pub(super) fn looks(&mut self, read: &BTreeSet<usize>) {
        let document = self.document;
        let lights = document.extensions.lights.iter().flat_map(|lights| &lights.lights);
        for (index, light) in lights.enumerate() {
            self.light(light, &format!("light {index}"));
        }
        let shapes = [&document.extensions.implicit_shapes, &document.extensions.collision_shapes];
        for (index, shape) in shapes.into_iter().flatten().flat_map(|shapes| shapes.shapes.iter().enumerate()) {
            self.shape(shape, &format!("shape {index}"));
        }
        for (index, material) in document.materials.iter().enumerate() {
            let place = format!("material {index}");
            if !matches!(material.alpha_mode.as_deref(), None | Some("OPAQUE" | "MASK" | "BLEND")) {
                self.tell(&place, "its alphaMode is none of glTF's, taken as OPAQUE");
            }
            if material.alpha_cutoff.is_some() && material.alpha_mode.is_none() {
                self.tell(&place, "it has a cutoff and no alphaMode");
            }
        }
        for (index, image) in document.images.iter().enumerate() {
            self.image(image, &format!("image {index}"));
        }
        for (index, camera) in document.cameras.iter().enumerate() {
            self.camera(camera, read.contains(&index), &format!("camera {index}"));
        }
        let variants = document.extensions.variants.iter().flat_map(|variants| &variants.variants);
        for (index, _) in variants.enumerate().filter(|(_, variant)| variant.name.is_none()) {
            self.tell(&format!("variant {index}"), "it has no name");
        }
    }

    fn light(&mut self, light: &PunctualLight, place: &str) {
        let is_color = |color: &[f64]| color.len() == 3 && color.iter().all(|part| (0.0..=1.0).contains(part));
        let is_odd = light.intensity.is_some_and(|intensity| intensity < 0.0)
            || light.range.is_some_and(|range| range <= 0.0)
            || light.color.as_ref().is_some_and(|color| !is_color(color));
        if is_odd {
            self.tell(place, "its colour, intensity or range is none of glTF's");
        }
        if !matches!(light.kind.as_str(), "directional" | "point" | "spot") {
            self.tell(place, "its type is none of directional, point, spot");
        }
        if light.kind == "spot" && !light.spot.as_ref().is_some_and(is_cone) {
            self.tell(place, "it has no spot, or the angles of that are out of order");
        }
    }

    fn shape(&mut self, shape: &ImplicitShape, place: &str) {
        if shape.is_of_another_type() {
            self.tell(place, "it has no numbers of its type, but of another");
        }
        if body(shape).is_some_and(|body| body.is_wrong()) {
            self.tell(place, "a size of it is negative");
        }
    }

    fn image(&mut self, image: &Image, place: &str) {
        if image.uri.is_some() == image.buffer_view.is_some() {
            self.tell(place, "it has not just one of uri and bufferView");
        }
        image.uri.iter().for_each(|uri| self.data_uri(uri, place));
        if let Some(view) = image.buffer_view.filter(|&view| view < self.document.buffer_views.len()) {
            self.plain_view(view, place);
        }
        match image.mime_type.as_deref() {
            None if image.buffer_view.is_some() => self.tell(place, "it is in a buffer view and has no mimeType"),
            None | Some("image/png" | "image/jpeg") => {}
            // Other kinds come with extensions of textures.
            Some(_) if self.document.extensions_used.iter().any(|name| is_for_pictures(name)) => {}
            Some(_) => self.tell(place, "its mimeType is none of glTF's"),
        }
    }

    fn camera(&mut self, camera: &Eye, is_read: bool, place: &str) {
        if !is_read && camera.perspective.is_some() == camera.orthographic.is_some() {
            self.tell(place, "it is not either perspective or orthographic");
        }
        if !is_read && camera.perspective.as_ref().is_some_and(|eye| eye.yfov <= 0.0 || eye.yfov >= PI) {
            self.tell(place, "its yfov is not between 0 and half a turn");
        }
        if !has_sound_planes(camera) {
            self.tell(place, "its type is not its projection's, or its planes are out of order");
        }
        if !has_sound_width(camera) {
            self.tell(place, "its aspectRatio, xmag or ymag is none of glTF's");
        }
    }
}

/// Whether the angles of a spot are in order, and not above a right angle as 32 bits hold it.
fn is_cone(spot: &SpotCone) -> bool {
    let (inner, outer) = (spot.inner_cone_angle.unwrap_or(0.0), spot.outer_cone_angle.unwrap_or(FRAC_PI_4));
    0.0 <= inner && inner < outer && outer as f32 <= FRAC_PI_2 as f32
}

/// Whether an extension brings pictures of other kinds.
fn is_for_pictures(extension: &str) -> bool {
    extension != "KHR_texture_transform" && ["texture", "image"].iter().any(|word| extension.contains(word))
}

/// Whether a camera says how wide it sees, where it has to, and not nothing.
fn has_sound_width(camera: &Eye) -> bool {
    let is_narrow = |eye: &Perspective| eye.aspect_ratio.is_some_and(|ratio| ratio <= 0.0);
    let is_flat = |eye: &Orthographic| eye.ymag == 0.0 || eye.xmag.is_none_or(|width| width == 0.0);
    !camera.perspective.as_ref().is_some_and(is_narrow) && !camera.orthographic.as_ref().is_some_and(is_flat)
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
