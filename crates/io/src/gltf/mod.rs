//! glTF 2.0, as text (`.gltf`) or binary (`.glb`).
//!
//! Read by own types instead of the `gltf` crate: that one keeps matrices in 32 bits, refuses required extensions it
//! does not know, accepts node cycles and indices out of range, and panics on some malformed files. What is used is
//! checked here; of what is not (normals, joints, animations, shading) it is told where it is broken ([`validate`], [`unread`]).
//!
//! - An object is a node with a mesh, named after the node; with EXT_mesh_gpu_instancing one object an instance,
//!   `name#0`, `name#1`, ... All primitives of a glTF mesh are one [`Mesh`](umbriel_geometry::Mesh), shared by all nodes
//!   and instances.
//! - A node's matrix is the f64 product of its ancestors' matrices and its own, multiplied from the root:
//!   ((root · child) · grandchild) · instance. Numbers of the text are read as f64, 32-bit floats become f64 exactly.
//! - KHR_lights_punctual: a directional light is a sun along the node's −Z, a point or spot light stands at the node.
//! - Nodes that are hidden (KHR_node_visibility), and all below them, have neither bodies nor lights; cameras, cells and portals count.
//! - The scene is the default one, else the first, else all nodes without a parent. Families are its nodes with children.
//! - Sparse accessors, accessors without a buffer view, KHR_mesh_quantization and all three ways of compression
//!   (EXT_meshopt_compression, KHR_meshopt_compression, KHR_draco_mesh_compression) are read.
//! - Morph targets are added by the weights of the node, else of the mesh. Skins are taken at their bind pose.
//! - A node without a mesh whose collider (KHR_physics_rigid_bodies) has a shape of KHR_implicit_shapes is that body; with
//!   [`Colliders::InPlace`](crate::Colliders) a node with a mesh, too.
//! - Nodes may be cells and portals by their names or extras ([`rooms`]).
//! - Triangles of MASK materials are cut out by alpha ([`textures`]).

mod accessor;
mod container;
mod draco;
mod hierarchy;
mod json;
mod keys;
mod lights;
mod mesh;
mod meshopt;
mod nodes;
mod primitive;
mod rooms;
mod shapes;
mod skins;
mod text;
mod textures;
mod unread;
mod validate;
mod views;

use std::borrow::Cow;

use umbriel_scene::FindingKind;

use crate::{
    error::{LoadProblem, excerpt},
    folder::Folder,
    load::Reading,
    model::Model,
};
use accessor::Accessors;
use container::Buffers;
use json::Document;
use mesh::Meshes;
use views::Views;

/// Extensions that are read.
const READ: [&str; 12] = [
    "KHR_lights_punctual",
    "EXT_mesh_gpu_instancing",
    "KHR_mesh_quantization",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_implicit_shapes",
    "KHR_collision_shapes",
    "KHR_physics_rigid_bodies",
    "KHR_texture_transform",
    "KHR_node_visibility",
    "KHR_materials_pbrSpecularGlossiness",
];
/// Extensions that change nothing but shading, pictures, motions and remarks: they may be required.
const WITHOUT_EFFECT: [&str; 27] = [
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_materials_volume_scatter",
    "ADOBE_materials_clearcoat_specular",
    "ADOBE_materials_clearcoat_tint",
    "ADOBE_materials_thin_transparency",
    "KHR_texture_basisu",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "MSFT_texture_dds",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "KHR_animation_pointer",
    "EXT_mesh_features",
    "EXT_instance_features",
    "EXT_structural_metadata",
];
/// Beginnings of the names of others that are of such kinds: where they are not required, they need not be told.
const LIKELY_WITHOUT_EFFECT: [&str; 6] =
    ["KHR_materials_", "ADOBE_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_xmp"];

/// Reads a glTF file.
pub(crate) fn read(bytes: &[u8], folder: &Folder, reading: &Reading) -> Result<Model, LoadProblem> {
    let container = container::split(bytes)?;
    let (document, text) = parse(container.text)?;
    check_version(&document)?;
    check_required(&document)?;
    let buffers = Buffers::new(&document.buffers, container.binary, folder);
    let accessors = Accessors::new(&document, Views::new(&document.buffer_views, buffers));
    let hierarchy = hierarchy::Hierarchy::new(&document)?;
    let meshes = Meshes::new(&document, &accessors, reading);
    let (mut model, cameras) = nodes::read(&document, &hierarchy, &accessors, meshes, reading.colliders)?;
    model.findings.absorb(validate::check(&document, &cameras)?, str::to_owned);
    // What data URIs hold is at hand from here on.
    for problem in accessors.views().unused_problems() {
        model.tell("unused", &problem.to_string());
    }
    model.findings.absorb(unread::check(&document, &accessors), str::to_owned);
    model.findings.absorb(skins::check(&document, &accessors), str::to_owned);
    model.findings.absorb(textures::check(&document, &accessors), str::to_owned);
    model.findings.absorb(textures::check_rest(&document, &accessors), str::to_owned);
    for rule in accessors.views().broken_rules() {
        model.findings.add(FindingKind::BrokenRule, &rule, 1);
    }
    model.findings.absorb(validate::kinds::check(&text, &document.extensions_used), str::to_owned);
    model.findings.absorb(keys::check(&text), str::to_owned);
    if let Cow::Owned(_) = text {
        let subject = "JSON: halves of characters, which no text has, taken as U+FFFD";
        model.findings.add(FindingKind::BrokenRule, subject, text::halves(container.text));
    }
    for rule in container.broken {
        model.tell("file", rule);
    }
    for name in document.extensions_used.iter().filter(|name| !is_known(name) && !is_likely_without_effect(name)) {
        model.findings.add(FindingKind::UnknownExtension, name, 1);
    }
    Ok(model)
}

/// The document of a text, and the text as it was read. Some exporters write whole numbers as `3.0`, which is the same number in JSON, or
/// halves of characters, which its grammar has; a text that is not glTF is read once more with `3`, and U+FFFD.
fn parse(text: &[u8]) -> Result<(Document, Cow<'_, [u8]>), LoadProblem> {
    check_encoding(text)?;
    if let Ok(document) = serde_json::from_slice(text) {
        return Ok((document, text.into()));
    }
    if text.trim_ascii_start().first() != Some(&b'{') {
        let message = "it begins neither with the { of JSON nor with the glTF of a GLB container".to_owned();
        return Err(LoadProblem::Text { line: 1, column: Some(1), message });
    }
    let plain = text::plain(text);
    let document = serde_json::from_slice(&plain).map_err(|fault| LoadProblem::Text {
        line: fault.line(),
        column: Some(fault.column().max(1)),
        message: format!("its JSON is not glTF 2.0: {}", without_place(&fault)),
    })?;
    Ok((document, plain.into()))
}

/// Refuses what is not UTF-8, which members that are not read may hold, too.
fn check_encoding(text: &[u8]) -> Result<(), LoadProblem> {
    let Err(fault) = str::from_utf8(text) else { return Ok(()) };
    let mut lines = text[..fault.valid_up_to()].split(|&byte| byte == b'\n');
    let last = lines.next_back().map_or(0, <[u8]>::len);
    let message = "its JSON is not UTF-8".to_owned();
    Err(LoadProblem::Text { line: lines.count() + 1, column: Some(last + 1), message })
}

/// The message without the line and column that end it, in words of the format.
fn without_place(fault: &serde_json::Error) -> String {
    let message = fault.to_string();
    let text = message.rsplit_once(" at line ").map_or(&*message, |(text, _)| text);
    let words = text.split(' ').collect::<Vec<_>>();
    let mut told = Vec::with_capacity(words.len());
    let mut rest = &words[..];
    while let Some((&word, behind)) = rest.split_first() {
        let (word, behind) = match (word, behind) {
            // Types are written as in Rust: `struct Eye with 3 elements`, `u32`.
            ("struct", [_, "with", _, "element" | "elements", behind @ ..]) => ("an object", behind),
            ("struct", [_, behind @ ..]) => ("an object", behind),
            ("usize" | "u32" | "u8", _) => ("a whole number, 0 or more", behind),
            ("f64", _) => ("a number", behind),
            _ => (word, behind),
        };
        told.push(word);
        rest = behind;
    }
    told.join(" ")
}

fn check_version(document: &Document) -> Result<(), LoadProblem> {
    let needed = document.asset.min_version.as_deref().filter(|&minimum| minimum != "2.0");
    let is_second = |version: &&str| {
        let minor = version.strip_prefix("2.");
        minor.is_some_and(|minor| !minor.is_empty() && minor.bytes().all(|digit| digit.is_ascii_digit()))
    };
    let unread = needed.or(Some(&*document.asset.version).filter(|version| !is_second(version)));
    match unread {
        Some(version) => Err(LoadProblem::element("asset", format!("needs glTF {version}; glTF 2.0 is read"))),
        None => Ok(()),
    }
}

fn is_known(extension: &str) -> bool {
    READ.contains(&extension) || WITHOUT_EFFECT.contains(&extension)
}

fn is_likely_without_effect(extension: &str) -> bool {
    LIKELY_WITHOUT_EFFECT.iter().any(|beginning| extension.starts_with(beginning))
}

fn check_required(document: &Document) -> Result<(), LoadProblem> {
    const NAMED: usize = 8;
    let unknown = || document.extensions_required.iter().filter(|name| !is_known(name));
    let mut names: Vec<_> = unknown().take(NAMED).map(|name| excerpt(name)).collect();
    if names.is_empty() {
        return Ok(());
    }
    if unknown().count() > NAMED {
        names.push("...".into());
    }
    Err(LoadProblem::Extension { name: names.join(", "), advice: "export the file without them" })
}

#[cfg(test)]
mod tests;
