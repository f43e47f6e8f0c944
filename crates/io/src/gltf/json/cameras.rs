//! Cameras.

use serde::Deserialize;

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Eye {
    #[serde(rename = "type")]
    pub(in crate::gltf) kind: Option<String>,
    pub(in crate::gltf) perspective: Option<Perspective>,
    pub(in crate::gltf) orthographic: Option<Orthographic>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Perspective {
    pub(in crate::gltf) aspect_ratio: Option<f64>,
    pub(in crate::gltf) yfov: f64,
    pub(in crate::gltf) znear: Option<f64>,
    pub(in crate::gltf) zfar: Option<f64>,
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Orthographic {
    pub(in crate::gltf) xmag: Option<f64>,
    pub(in crate::gltf) ymag: f64,
    pub(in crate::gltf) znear: Option<f64>,
    pub(in crate::gltf) zfar: Option<f64>,
}
