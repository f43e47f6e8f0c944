//! Files that appear whole or not at all.
//!
//! The content goes to a temporary file in the target's own folder (renaming works only within a file system); a
//! rename then puts it in the target's place. Dropping a [`Staged`] file removes it. What cannot be replaced by a
//! rename, a pipe or a device, is written directly at the end.

use std::{
    fs::{self, File},
    io::{self, BufWriter, Seek, Write},
    path::{Path, PathBuf},
};

use tempfile::NamedTempFile;

/// Why a file was not written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct WriteError {
    /// The file that was asked for.
    pub path: PathBuf,
    /// What the system or the format says.
    pub source: io::Error,
}

impl WriteError {
    fn new(path: &Path, source: io::Error) -> Self {
        Self { path: path.to_path_buf(), source }
    }
}

/// A whole file that does not stand in its place yet.
#[derive(Debug)]
pub struct Staged {
    target: PathBuf,
    file: NamedTempFile,
}

/// Whether `path` looks as if a file could be written there, told before long work: its folder exists, and it is no
/// folder itself.
///
/// # Errors
/// [`WriteError`] that says what is in the way.
pub fn check_target(path: &Path) -> Result<(), WriteError> {
    let refuse = |kind, text: &str| Err(WriteError::new(path, io::Error::new(kind, text)));
    if path.is_dir() {
        return refuse(io::ErrorKind::IsADirectory, "it is a folder");
    }
    if path.file_name().is_none() {
        return refuse(io::ErrorKind::InvalidInput, "the path names no file");
    }
    if !folder_of(path).is_dir() {
        return refuse(io::ErrorKind::NotFound, "its folder does not exist; create it first");
    }
    Ok(())
}

impl Staged {
    /// Writes a file's content beside `path`; `fill` produces it through a buffer.
    ///
    /// # Errors
    /// [`WriteError`] when the folder is missing or closed to us, or when `fill` fails. Nothing stays behind.
    pub fn new(
        path: &Path,
        fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
    ) -> Result<Self, WriteError> {
        check_target(path)?;
        let fail = |error| WriteError::new(path, error);
        // A link keeps pointing where it points; the file behind it is replaced.
        let target = if path.exists() { fs::canonicalize(path).map_err(fail)? } else { path.to_path_buf() };
        let mut file = temporary_file(folder_of(&target)).map_err(fail)?;
        let mut buffer = BufWriter::new(file.as_file_mut());
        fill(&mut buffer).and_then(|()| buffer.flush()).map_err(fail)?;
        drop(buffer);
        Ok(Self { target, file })
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// [`WriteError`]; the place is then as it was.
    pub fn commit(self) -> Result<(), WriteError> {
        let Self { target, mut file } = self;
        if is_special(&target) {
            return copy_into(&mut file, &target).map_err(|error| WriteError::new(&target, error));
        }
        file.persist(&target).map(drop).map_err(|error| WriteError::new(&target, error.error))
    }
}

/// The folder a path lies in; `.` for a bare name.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Whether something stands at `target` that a rename would destroy rather than fill: a device, a pipe.
fn is_special(target: &Path) -> bool {
    fs::metadata(target).is_ok_and(|metadata| !metadata.is_file())
}

fn copy_into(file: &mut NamedTempFile, target: &Path) -> io::Result<()> {
    let source = file.as_file_mut();
    source.rewind()?;
    io::copy(source, &mut File::options().write(true).open(target)?).map(drop)
}

#[cfg(unix)]
fn temporary_file(folder: &Path) -> io::Result<NamedTempFile> {
    use std::os::unix::fs::PermissionsExt;
    // Temporary files are private by default; a result is as open as any other new file (the umask still applies).
    tempfile::Builder::new().prefix(".umbriel-").permissions(fs::Permissions::from_mode(0o666)).tempfile_in(folder)
}

#[cfg(not(unix))]
fn temporary_file(folder: &Path) -> io::Result<NamedTempFile> {
    tempfile::Builder::new().prefix(".umbriel-").tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder");
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn a_file_appears_only_when_it_is_whole() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("out.txt");
        let staged = Staged::new(&path, |out| out.write_all(b"all of it")).expect("staged");
        assert!(!path.exists());
        staged.commit().expect("written");
        assert_eq!(fs::read(&path).expect("a file"), b"all of it");
        assert_eq!(names(folder.path()), ["out.txt"]);
    }

    #[test]
    fn a_failure_leaves_nothing_and_keeps_the_old_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("out.txt");
        fs::write(&path, "old").expect("written");
        let fill = |out: &mut BufWriter<&mut File>| {
            out.write_all(b"half of")?;
            Err(io::Error::other("no more paper"))
        };
        let error = Staged::new(&path, fill).expect_err("a failure");
        assert!(error.to_string().contains("out.txt") && error.to_string().contains("no more paper"));
        drop(Staged::new(&path, |out| out.write_all(b"never committed")).expect("staged"));
        assert_eq!(fs::read(&path).expect("a file"), b"old");
        assert_eq!(names(folder.path()), ["out.txt"]);
    }

    #[test]
    fn targets_that_cannot_be_are_told_early() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(check_target(folder.path()).is_err());
        assert!(check_target(&folder.path().join("missing/out.txt")).is_err());
        assert!(check_target(&folder.path().join("out.txt")).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_written_to_and_stay_devices() {
        let null = Path::new("/dev/null");
        let folder = tempfile::tempdir().expect("a folder");
        let link = folder.path().join("link");
        std::os::unix::fs::symlink(null, &link).expect("a link");
        // Staging needs a temporary file in the folder of the device, which not every user may write to.
        if let Ok(staged) = Staged::new(&link, |out| out.write_all(b"gone")) {
            staged.commit().expect("written");
        }
        assert!(is_special(null), "still a device");
    }
}
