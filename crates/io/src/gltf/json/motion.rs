//! How nodes move.

use serde::Deserialize;

/// What is said of motions; nothing is moved.
#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Animation {
    #[serde(default)]
    pub(in crate::gltf) samplers: Vec<AnimationSampler>,
    #[serde(default)]
    pub(in crate::gltf) channels: Vec<AnimationChannel>,
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct AnimationSampler {
    pub(in crate::gltf) input: usize,
    pub(in crate::gltf) output: usize,
    pub(in crate::gltf) interpolation: Option<String>,
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct AnimationChannel {
    pub(in crate::gltf) sampler: usize,
    pub(in crate::gltf) target: AnimationTarget,
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct AnimationTarget {
    pub(in crate::gltf) node: Option<usize>,
    pub(in crate::gltf) path: Option<String>,
}
