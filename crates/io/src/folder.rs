//! Reading files, and keeping to the folder of the scene.
//!
//! A path inside a scene is relative to the file that names it and may not leave the folder of the scene: not by `..`,
//! not by being absolute, not through a symbolic link. What is checked is the resolved path, which is also the path
//! that is opened.

use std::{
    path::{Component, Path, PathBuf},
    rc::Rc,
};

use crate::{
    error::{LoadProblem, excerpt},
    ledger::Ledger,
    options::Outside,
};

/// Where relative paths start, and where they have to stay.
#[derive(Clone, Debug)]
pub(crate) struct Folder {
    base: PathBuf,
    root: PathBuf,
    /// How many folders the base lies below the root.
    depth: usize,
    outside: Outside,
    ledger: Rc<Ledger>,
}

/// A file that a scene names.
#[derive(Clone, Debug)]
pub(crate) struct Located {
    /// What messages call it: relative as the scene itself is.
    pub(crate) shown: PathBuf,
    /// The resolved path, which is opened.
    pub(crate) real: PathBuf,
}

impl Folder {
    /// The folder of a scene.
    pub(crate) fn of_scene(scene: &Path, outside: Outside) -> Self {
        let base = parent(scene);
        // A folder that cannot be resolved cannot be read either; the read says so.
        let root = base.canonicalize().unwrap_or_else(|_| base.clone());
        Self { base, root, depth: 0, outside, ledger: Rc::default() }
    }

    /// The folder of a file that the scene names: relative paths start there, the borders stay the scene's.
    pub(crate) fn of_file(&self, file: &Path) -> Self {
        let base = parent(file);
        let real = base.canonicalize().unwrap_or_else(|_| base.clone());
        let depth = real.strip_prefix(&self.root).map_or(0, |below| below.components().count());
        Self { base, depth, ..self.clone() }
    }

    /// The account of the scene.
    pub(crate) fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// The file that `path` means, if it exists and may be read. `place` is the element that names it.
    pub(crate) fn resolve(&self, path: &str, place: &str) -> Result<Located, LoadProblem> {
        let outside = || LoadProblem::Outside { place: place.to_owned(), path: excerpt(path).into_owned() };
        let joined = self.base.join(path);
        let confined = self.outside == Outside::Refused;
        // Before the file system is asked, so that nothing outside is even looked up.
        if confined && !self.stays_inside(Path::new(path)) {
            return Err(outside());
        }
        let shown = joined.strip_prefix(".").unwrap_or(&joined).to_path_buf();
        let real = joined.canonicalize().map_err(|source| LoadProblem::Unreadable { path: shown.clone(), source })?;
        if confined && !real.starts_with(&self.root) {
            return Err(outside());
        }
        Ok(Located { shown, real })
    }

    /// Whether the path, as written, never climbs above the folder of the scene.
    fn stays_inside(&self, path: &Path) -> bool {
        let mut depth = self.depth as i64;
        path.components().all(|component| {
            depth += match component {
                Component::Normal(_) => 1,
                Component::CurDir => 0,
                Component::ParentDir => -1,
                Component::RootDir | Component::Prefix(_) => return false,
            };
            depth >= 0
        })
    }
}

fn parent(file: &Path) -> PathBuf {
    match file.parent() {
        Some(parent) if parent != Path::new("") => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn paths_stay_in_the_folder_of_the_scene() {
        let folder = tempfile::tempdir().expect("a folder");
        let scene = folder.path().join("scene");
        fs::create_dir_all(scene.join("models")).expect("folders");
        fs::write(folder.path().join("secret.bin"), b"1").expect("a file");
        fs::write(scene.join("a.bin"), b"2").expect("a file");
        let inside = Folder::of_scene(&scene.join("scene.gltf"), Outside::Refused);
        assert!(inside.resolve("a.bin", "buffer 0").is_ok());
        assert!(inside.resolve("models/../a.bin", "buffer 0").is_ok());
        assert!(inside.of_file(&scene.join("models/x.gltf")).resolve("../a.bin", "buffer 0").is_ok());
        for path in ["../secret.bin", "../missing.bin", "models/../../secret.bin", "/etc/hostname", ".."] {
            assert!(matches!(inside.resolve(path, "buffer 0"), Err(LoadProblem::Outside { .. })), "{path}");
        }
        assert!(matches!(inside.resolve("missing.bin", "buffer 0"), Err(LoadProblem::Unreadable { .. })));
        let anywhere = Folder::of_scene(&scene.join("scene.gltf"), Outside::Allowed);
        assert!(anywhere.resolve("../secret.bin", "buffer 0").is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_does_not_lead_out() {
        let folder = tempfile::tempdir().expect("a folder");
        let scene = folder.path().join("scene");
        fs::create_dir(&scene).expect("a folder");
        fs::write(folder.path().join("secret.bin"), b"1").expect("a file");
        std::os::unix::fs::symlink("../secret.bin", scene.join("link.bin")).expect("a link");
        let inside = Folder::of_scene(&scene.join("scene.gltf"), Outside::Refused);
        assert!(matches!(inside.resolve("link.bin", "buffer 0"), Err(LoadProblem::Outside { .. })));
    }
}
