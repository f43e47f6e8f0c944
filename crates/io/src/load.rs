//! One door for all kinds of scenes.

use std::path::Path;

use umbriel_scene::Sides;

use crate::{
    error::{LoadError, LoadProblem},
    folder::Folder,
    gltf,
    ledger::as_named,
    model::Model,
    obj,
    options::{Blend, Colliders, DetailSetting, LoadOptions, LoadedScene, OwnSettings, UpAxis},
    ply, scene_file, stl,
};

/// Reads a scene: a scene file (`.toml`), glTF 2.0 (`.gltf`, `.glb`), Wavefront OBJ (`.obj`), STL (`.stl`) or PLY (`.ply`).
///
/// All names are unique, all numbers accepted, all indices in range; what was taken otherwise than the file says is a
/// finding. A scene without lights is fine. Time O(n log n) in the size of the files; memory a small multiple of it.
///
/// # Errors
/// A file that is missing, unreadable or of an unknown kind, content that is refused, or a scene without any triangle
/// or body, or one that makes too much of small files; see [`LoadError::is_unreadable`].
pub fn load(path: &Path, options: &LoadOptions) -> Result<LoadedScene, LoadError> {
    let folder = Folder::of_scene(path, options.outside);
    let bytes = folder.ledger().read(&as_named(path)).map_err(|problem| problem.in_file(path))?;
    read(path, &bytes, folder, options)
}

/// As [`load`], with the content of the scene's file at hand. `path` says what kind of file it is and where the files lie
/// that it names; the file itself need not be there.
///
/// # Errors
/// As of [`load`].
pub fn load_bytes(path: &Path, bytes: &[u8], options: &LoadOptions) -> Result<LoadedScene, LoadError> {
    let folder = Folder::of_scene(path, options.outside);
    folder.ledger().count(bytes);
    read(path, bytes, folder, options)
}

fn read(path: &Path, bytes: &[u8], folder: Folder, options: &LoadOptions) -> Result<LoadedScene, LoadError> {
    let (model, stated) = match Format::of(path) {
        Some(Format::SceneFile) => scene_file::read(path, bytes, &folder, options)?,
        Some(Format::Mesh(format)) => {
            let reading = Reading::new(options, options.up);
            let model = read_mesh(path, format, bytes, &folder, &reading)?;
            (model, Stated::default())
        }
        None => return Err(LoadProblem::UnknownFormat.in_file(path)),
    };
    let up = options.up.or(stated.up).unwrap_or_default();
    let north_degrees = options.north_degrees.unwrap_or(stated.north);
    let sides = options.sides.or(stated.sides).unwrap_or_default();
    let lightmaps = model.objects.iter().map(|object| object.lightmap.clone()).collect();
    let scene = model.into_scene(up.turn(), sides, folder.ledger()).map_err(|problem| problem.in_file(path))?;
    let Stated { detail, own, .. } = stated;
    Ok(LoadedScene { scene, detail, own, north_degrees, up, lightmaps, files: folder.ledger().files() })
}

/// What a scene file says about the scene as a whole.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stated {
    pub(crate) up: Option<UpAxis>,
    pub(crate) north: f64,
    pub(crate) sides: Option<Sides>,
    pub(crate) detail: Option<DetailSetting>,
    pub(crate) own: OwnSettings,
}

#[derive(Clone, Copy, Debug)]
enum Format {
    SceneFile,
    Mesh(MeshFormat),
}

/// The formats that a scene file can name.
#[derive(Clone, Copy, Debug)]
pub(crate) enum MeshFormat {
    Obj,
    Gltf,
    Stl,
    Ply,
}

impl MeshFormat {
    pub(crate) fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "obj" => Some(Self::Obj),
            "gltf" | "glb" => Some(Self::Gltf),
            "stl" => Some(Self::Stl),
            "ply" => Some(Self::Ply),
            _ => None,
        }
    }
}

impl Format {
    fn of(path: &Path) -> Option<Self> {
        let is_toml = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
        if is_toml { Some(Self::SceneFile) } else { MeshFormat::of(path).map(Self::Mesh) }
    }
}

/// How to read a mesh file.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reading {
    /// Keeps a file that does not say from being suspected of pointing up elsewhere.
    pub(crate) up_is_stated: bool,
    /// See [`LoadOptions::lightmap_set`].
    pub(crate) lightmap_set: Option<u32>,
    pub(crate) blend: Blend,
    pub(crate) colliders: Colliders,
}

impl Reading {
    /// As the user says; `up` is which axis is known to point up.
    pub(crate) fn new(options: &LoadOptions, up: Option<UpAxis>) -> Self {
        let &LoadOptions { lightmap_set, blend, colliders, .. } = options;
        Self { up_is_stated: up.is_some(), lightmap_set, blend, colliders }
    }
}

/// The content of a mesh file.
pub(crate) fn read_mesh(
    path: &Path,
    format: MeshFormat,
    bytes: &[u8],
    folder: &Folder,
    reading: &Reading,
) -> Result<Model, LoadError> {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let folder = folder.of_file(path);
    let model = match format {
        MeshFormat::Obj => obj::read(bytes, &stem, &folder, reading),
        MeshFormat::Gltf => gltf::read(bytes, &folder, reading),
        MeshFormat::Stl => stl::read(bytes, &stem, reading),
        MeshFormat::Ply => ply::read(bytes, &stem, reading),
    };
    model.map_err(|problem| problem.in_file(path))
}
