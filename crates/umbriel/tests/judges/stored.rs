//! The scenes of the repository.

use std::path::{Path, PathBuf};

/// Every scene and model right in the folder of fixtures, by name.
pub(crate) fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let files = folder.read_dir().expect("the fixtures").map(|entry| entry.expect("a file").path());
    let is_scene = |path: &PathBuf| {
        path.extension().is_some_and(|kind| ["toml", "obj", "gltf", "glb"].iter().any(|known| kind == *known))
    };
    let mut paths: Vec<PathBuf> = files.filter(is_scene).collect();
    paths.sort();
    paths
}
