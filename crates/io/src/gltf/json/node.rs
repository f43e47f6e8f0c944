//! Nodes: where things stand, and what they are. Files may have millions, so what few of them have is boxed.

use serde::{Deserialize, Deserializer};
use serde_json::value::RawValue;

use super::Members;

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Node {
    pub(in crate::gltf) name: Option<Box<str>>,
    #[serde(default)]
    pub(in crate::gltf) children: Box<[usize]>,
    pub(in crate::gltf) matrix: Option<Box<[f64; 16]>>,
    pub(in crate::gltf) translation: Option<Box<[f64; 3]>>,
    pub(in crate::gltf) rotation: Option<Box<[f64; 4]>>,
    pub(in crate::gltf) scale: Option<Box<[f64; 3]>>,
    pub(in crate::gltf) mesh: Option<usize>,
    pub(in crate::gltf) camera: Option<usize>,
    pub(in crate::gltf) skin: Option<usize>,
    pub(in crate::gltf) weights: Option<Box<[f64]>>,
    /// As written: it may be anything, however deep.
    pub(in crate::gltf) extras: Option<Box<RawValue>>,
    #[serde(default, deserialize_with = "boxed")]
    extensions: Option<Box<NodeExtensions>>,
}

const _: () = assert!(size_of::<Node>() <= 152, "three million empty nodes are a file of nine megabytes");

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(in crate::gltf) light: Option<LightReference>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(in crate::gltf) instancing: Option<Instancing>,
    #[serde(rename = "KHR_physics_rigid_bodies")]
    pub(in crate::gltf) rigid_body: Option<RigidBody>,
    #[serde(rename = "KHR_node_visibility")]
    pub(in crate::gltf) visibility: Option<Visibility>,
}

/// What is there, boxed.
fn boxed<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Box<NodeExtensions>>, D::Error> {
    Box::deserialize(value).map(Some)
}

impl Node {
    /// Its extensions; none where it has none.
    pub(in crate::gltf) fn extensions(&self) -> &NodeExtensions {
        const NONE: &NodeExtensions =
            &NodeExtensions { light: None, instancing: None, rigid_body: None, visibility: None };
        self.extensions.as_deref().unwrap_or(NONE)
    }

    /// Whether it and all below it are not shown.
    pub(in crate::gltf) fn is_hidden(&self) -> bool {
        self.extensions().visibility.as_ref().and_then(|visibility| visibility.visible) == Some(false)
    }
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Visibility {
    pub(in crate::gltf) visible: Option<bool>,
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct RigidBody {
    pub(in crate::gltf) collider: Option<Collider>,
    pub(in crate::gltf) trigger: Option<Collider>,
    pub(in crate::gltf) joint: Option<PhysicsJoint>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct PhysicsJoint {
    pub(in crate::gltf) connected_node: Option<usize>,
    pub(in crate::gltf) joint: Option<usize>,
}

/// What collides in place of a node: named by itself in the older drafts, within `geometry` in the newer ones.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Collider {
    pub(in crate::gltf) shape: Option<usize>,
    pub(in crate::gltf) geometry: Option<ColliderGeometry>,
    pub(in crate::gltf) physics_material: Option<usize>,
    pub(in crate::gltf) collision_filter: Option<usize>,
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct ColliderGeometry {
    pub(in crate::gltf) shape: Option<usize>,
    pub(in crate::gltf) mesh: Option<usize>,
    pub(in crate::gltf) node: Option<usize>,
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct LightReference {
    pub(in crate::gltf) light: usize,
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Instancing {
    pub(in crate::gltf) attributes: Members<usize>,
}
