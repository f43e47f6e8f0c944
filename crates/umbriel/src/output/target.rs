//! Where results go: files chosen by their extensions, all of them written or none.

use std::{
    ffi::OsStr,
    fs,
    path::{Path, PathBuf},
};

use umbriel_io::write::{Staged, check_target};

use crate::cli::Failure;

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Json,
    Csv,
    Glb,
    Npy,
    Png,
    Svg,
    Vtu,
}

impl Format {
    fn extension(self) -> &'static str {
        match self {
            Self::Json => "json",
            Self::Csv => "csv",
            Self::Glb => "glb",
            Self::Npy => "npy",
            Self::Png => "png",
            Self::Svg => "svg",
            Self::Vtu => "vtu",
        }
    }
}

/// A file that was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Target {
    pub(crate) path: PathBuf,
    pub(crate) format: Format,
}

/// Checks the files that were asked for before anything is computed: known extensions, folders that exist, no file
/// twice, none of `inputs`.
pub(crate) fn targets(paths: &[PathBuf], formats: &[Format], inputs: &[&Path]) -> Result<Vec<Target>, Failure> {
    let mut targets: Vec<Target> = Vec::new();
    for path in paths {
        let extension = path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
        let format = formats.iter().copied().find(|format| extension.as_deref() == Some(format.extension()));
        let format = format.ok_or_else(|| {
            let known: Vec<String> = formats.iter().map(|format| format!(".{}", format.extension())).collect();
            Failure::Unusable(format!("-o {}: the name must end in {}", path.display(), known.join(" or ")))
        })?;
        check_file(path, inputs)?;
        add_target(&mut targets, Target { path: path.clone(), format })?;
    }
    Ok(targets)
}

/// As [`targets`], with the file that JSON goes to if one was typed; `-` is standard output.
pub(crate) fn targets_and_json(
    paths: &[PathBuf],
    json: Option<&Path>,
    formats: &[Format],
    inputs: &[&Path],
) -> Result<Vec<Target>, Failure> {
    let mut targets = targets(paths, formats, inputs)?;
    if let Some(path) = json.filter(|path| *path != Path::new("-")) {
        check_file(path, inputs)?;
        add_target(&mut targets, Target { path: path.to_owned(), format: Format::Json })?;
    }
    Ok(targets)
}

/// Adds a file, unless it is there already under whichever name of its folder.
pub(crate) fn add_target(targets: &mut Vec<Target>, target: Target) -> Result<(), Failure> {
    if targets.iter().any(|other| place(&other.path) == place(&target.path)) {
        return Err(Failure::Unusable(format!("{} is to be written twice", target.path.display())));
    }
    targets.push(target);
    Ok(())
}

/// The file `name-OBJECT.ext` beside `name.ext`. Of the object's name only letters, digits, `-`, `_` and `.` stay, the
/// first hundred: what comes out of a scene must not lead into other folders.
pub(crate) fn file_of_object(path: &Path, object: &str) -> PathBuf {
    let safe = |character: char| if character.is_alphanumeric() || "-_.".contains(character) { character } else { '_' };
    let object: String = object.chars().take(100).map(safe).collect();
    let part = |part: Option<&OsStr>| part.map(|part| part.to_string_lossy().into_owned()).unwrap_or_default();
    path.with_file_name(format!("{}-{object}.{}", part(path.file_stem()), part(path.extension())))
}

/// A path whose folder is resolved; the file itself need not exist.
fn place(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (folder.canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_path_buf(),
    }
}

/// Whether none of the files was read: by now all that the scene names are known, resolved.
pub(crate) fn check_unread(targets: &[Target], read: &[PathBuf]) -> Result<(), Failure> {
    let is_read = |target: &&Target| fs::canonicalize(&target.path).is_ok_and(|path| read.contains(&path));
    targets.iter().find(is_read).map_or(Ok(()), |target| Err(is_read_failure(&target.path)))
}

fn is_read_failure(path: &Path) -> Failure {
    Failure::Unusable(format!("{} is read; choose another file for the results", path.display()))
}

/// Whether the file can be written, and is not read.
pub(crate) fn check_file(path: &Path, inputs: &[&Path]) -> Result<(), Failure> {
    check_target(path)?;
    let same = |input: &&Path| match (fs::canonicalize(path), fs::canonicalize(input)) {
        (Ok(path), Ok(input)) => path == input,
        _ => false,
    };
    if inputs.iter().any(same) {
        return Err(is_read_failure(path));
    }
    Ok(())
}

/// Puts all files in their places; by now each is whole.
pub(crate) fn commit_all(files: Vec<Staged>) -> Result<(), Failure> {
    files.into_iter().try_for_each(|file| file.commit().map_err(Failure::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_do_not_lead_into_other_folders() {
        let file = |object: &str| file_of_object(Path::new("out/map.v2.png"), object);
        assert_eq!(file("wall 3"), Path::new("out/map.v2-wall_3.png"));
        assert_eq!(file("../../etc/passwd"), Path::new("out/map.v2-.._.._etc_passwd.png"));
        assert_eq!(file(&"é".repeat(200)), Path::new("out").join(format!("map.v2-{}.png", "é".repeat(100))));
    }

    #[test]
    fn targets_are_checked_before_the_work() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let formats = [Format::Json, Format::Csv];
        let check = |paths: &[PathBuf]| targets(paths, &formats, &[&at("in.csv")]);
        fs::write(at("in.csv"), "").expect("written");
        assert_eq!(check(&[at("a.JSON"), at("b.csv")]).expect("targets")[0].format, Format::Json);
        for (paths, expected) in [
            (vec![at("a.png")], "must end in .json or .csv"),
            (vec![at("a")], "must end in"),
            (vec![at("no/a.csv")], "folder does not exist"),
            (vec![at("a.csv"), at("a.csv")], "twice"),
            (vec![at("a.csv"), at("./a.csv")], "twice"),
            (vec![at("in.csv")], "is read"),
        ] {
            let failure = check(&paths).expect_err(expected);
            assert_eq!(failure.exit_code(), 2);
            assert!(failure.message().is_some_and(|message| message.contains(expected)), "{failure:?}");
        }
    }
}
