//! Buffers and the views of them, compressed or not.

use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct BufferView {
    pub(in crate::gltf) buffer: usize,
    #[serde(default)]
    pub(in crate::gltf) byte_offset: usize,
    pub(in crate::gltf) byte_length: usize,
    pub(in crate::gltf) byte_stride: Option<usize>,
    pub(in crate::gltf) target: Option<u32>,
    #[serde(default)]
    pub(in crate::gltf) extensions: BufferViewExtensions,
}

impl BufferView {
    /// How far elements of that size are apart. Some exporters write a stride of 0 for none.
    pub(in crate::gltf) fn stride(&self, size: usize) -> usize {
        self.byte_stride.filter(|&stride| stride > 0).unwrap_or(size)
    }
}

#[derive(Debug, Default, Deserialize)]
pub(in crate::gltf) struct BufferViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    pub(in crate::gltf) ext_meshopt: Option<MeshoptView>,
    #[serde(rename = "KHR_meshopt_compression")]
    pub(in crate::gltf) khr_meshopt: Option<MeshoptView>,
}

/// The bytes that a compressed view stands for.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct MeshoptView {
    pub(in crate::gltf) buffer: usize,
    #[serde(default)]
    pub(in crate::gltf) byte_offset: usize,
    pub(in crate::gltf) byte_length: usize,
    pub(in crate::gltf) byte_stride: usize,
    pub(in crate::gltf) count: usize,
    pub(in crate::gltf) mode: MeshoptMode,
    #[serde(default)]
    pub(in crate::gltf) filter: MeshoptFilter,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(in crate::gltf) enum MeshoptMode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(in crate::gltf) enum MeshoptFilter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Buffer {
    pub(in crate::gltf) uri: Option<String>,
    pub(in crate::gltf) byte_length: usize,
    #[serde(default)]
    extensions: BufferExtensions,
}

#[derive(Debug, Default, Deserialize)]
struct BufferExtensions {
    #[serde(default, rename = "EXT_meshopt_compression")]
    ext_meshopt: Fallback,
    #[serde(default, rename = "KHR_meshopt_compression")]
    khr_meshopt: Fallback,
}

/// Whether a buffer only says how long the decompressed content is, so that its bytes may be left out.
#[derive(Debug, Default, Deserialize)]
struct Fallback {
    #[serde(default)]
    fallback: bool,
}

impl Buffer {
    /// Whether it stands for decompressed content and has no bytes.
    pub(in crate::gltf) fn is_left_out(&self) -> bool {
        self.uri.is_none() && (self.extensions.ext_meshopt.fallback || self.extensions.khr_meshopt.fallback)
    }
}
