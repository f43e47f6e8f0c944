//! The scenes of the repository.

use std::path::{Path, PathBuf};

/// Every scene and model right in the folder of fixtures, by name, and scenes with folders of their own (`office/office.toml`).
pub(crate) fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let own = |path: PathBuf| {
        let named = path.file_name().map(|name| path.join(name).with_extension("toml"));
        named.filter(|file| file.is_file()).unwrap_or(path)
    };
    let files = folder.read_dir().expect("the fixtures").map(|entry| own(entry.expect("a file").path()));
    let is_scene = |path: &PathBuf| {
        path.extension().is_some_and(|kind| ["toml", "obj", "gltf", "glb"].iter().any(|known| kind == *known))
    };
    let mut paths: Vec<PathBuf> = files.filter(is_scene).collect();
    paths.sort();
    paths
}
