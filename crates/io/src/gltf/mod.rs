//! glTF 2.0, as text (`.gltf`) or binary (`.glb`).
//!
//! Read by own types instead of the `gltf` crate: that one keeps matrices in 32 bits, refuses required extensions it
//! does not know, accepts node cycles and indices out of range, and panics on some malformed files. What is used is
//! checked here; what is not (animations, shading) is skipped.
//!
//! - An object is a node with a mesh, named after the node; with EXT_mesh_gpu_instancing one object an instance,
//!   `name#0`, `name#1`, ... All primitives of a glTF mesh are one [`Mesh`](umbriel_geometry::Mesh), shared by all nodes
//!   and instances.
//! - A node's matrix is the f64 product of its ancestors' matrices and its own, multiplied from the root:
//!   ((root · child) · grandchild) · instance. Numbers of the text are read as f64, 32-bit floats become f64 exactly.
//! - KHR_lights_punctual: a directional light is a sun along the node's −Z, a point or spot light stands at the node.
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
mod mesh;
mod meshopt;
mod nodes;
mod primitive;
mod rooms;
mod shapes;
mod skins;
mod textures;
mod validate;
mod views;

use serde_json::Value;
use umbriel_scene::FindingKind;

use crate::{error::LoadProblem, folder::Folder, load::Reading, model::Model};
use accessor::Accessors;
use container::Buffers;
use json::Document;
use mesh::Meshes;
use views::Views;

/// Extensions that are read.
const READ: [&str; 10] = [
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
];
/// Beginnings of the names of extensions that change nothing but shading, pictures, motions and remarks.
const WITHOUT_EFFECT: [&str; 10] = [
    "KHR_materials_",
    "ADOBE_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_xmp",
    "KHR_animation_pointer",
    "EXT_mesh_features",
    "EXT_instance_features",
    "EXT_structural_metadata",
];
/// Reads a glTF file.
pub(crate) fn read(bytes: &[u8], folder: &Folder, reading: &Reading) -> Result<Model, LoadProblem> {
    let (text, binary) = container::split(bytes)?;
    let document = parse(text)?;
    check_version(&document)?;
    check_required(&document)?;
    let accessors =
        Accessors::new(&document, Views::new(&document.buffer_views, Buffers::new(&document.buffers, binary, folder)));
    let hierarchy = hierarchy::Hierarchy::new(&document)?;
    let meshes = Meshes::new(&document, &accessors, reading);
    let mut model = nodes::read(&document, &hierarchy, &accessors, meshes, reading.colliders)?;
    model.findings.absorb(validate::check(&document)?, str::to_owned);
    for name in document.extensions_used.iter().filter(|name| !is_known(name)) {
        model.findings.add(FindingKind::UnknownExtension, name, 1);
    }
    Ok(model)
}

/// The document of a text. Some exporters write whole numbers as `3.0`, which is the same number in JSON; a text that is
/// not glTF is read once more with those as `3`.
fn parse(text: &[u8]) -> Result<Document, LoadProblem> {
    serde_json::from_slice(text).or_else(|fault| {
        let again = serde_json::from_slice(text).ok().map(whole_numbers);
        again.and_then(|value| serde_json::from_value(value).ok()).ok_or_else(|| LoadProblem::Text {
            line: fault.line(),
            column: Some(fault.column().max(1)),
            message: format!("its JSON is not glTF 2.0: {}", without_place(&fault)),
        })
    })
}

/// Turns floats that are whole numbers into integers.
fn whole_numbers(mut value: Value) -> Value {
    let mut open = vec![&mut value];
    while let Some(value) = open.pop() {
        match value {
            Value::Array(elements) => open.extend(elements),
            Value::Object(members) => open.extend(members.values_mut()),
            // Floats hold all whole numbers up to 2^53.
            Value::Number(number) => match number.as_f64() {
                Some(float) if number.is_f64() && float.fract() == 0.0 && float.abs() <= 9_007_199_254_740_992.0 => {
                    *number = (float as i64).into();
                }
                _ => {}
            },
            _ => {}
        }
    }
    value
}

/// The message without the line and column that end it, in words of the format.
fn without_place(fault: &serde_json::Error) -> String {
    let message = fault.to_string();
    let text = message.rsplit_once(" at line ").map_or(&*message, |(text, _)| text);
    text.replace("usize", "a whole number, 0 or more")
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
    READ.contains(&extension) || WITHOUT_EFFECT.iter().any(|beginning| extension.starts_with(beginning))
}

fn check_required(document: &Document) -> Result<(), LoadProblem> {
    let Some(name) = document.extensions_required.iter().find(|name| !is_known(name)) else { return Ok(()) };
    Err(LoadProblem::Extension { name: name.clone(), advice: "export the file without it" })
}

#[cfg(test)]
mod tests;
