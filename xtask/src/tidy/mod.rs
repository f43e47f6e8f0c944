//! What no compiler checks: sizes, leftovers, READMEs, lists.

mod constants;
mod literals;
mod source;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Result, ensure};

use crate::{
    downstream::first_example,
    workspace::{self, no_complaints},
};

/// Lines of a file without its tests; lines of a function.
const FILE_LINES: usize = 500;
const FUNCTION_LINES: usize = 60;

/// What may be larger, and why. An entry that is not needed any more is a complaint.
const EXCEPTIONS: [(&str, &str); 1] = [(
    "crates/umbriel/tests/judges/oracle/fixtures.rs",
    "a list of small scenes, a few lines each; cutting it would tell nothing",
)];

/// Words that code must not hold. In pieces, so that this file does not hold them either.
const LEFTOVERS: [&str; 6] = [
    concat!("to", "do!"),
    concat!("unimple", "mented!"),
    concat!("#[ig", "nore"),
    concat!(", ig", "nore)"),
    concat!(", ig", "nore ="),
    concat!("TO", "DO"),
];

/// The files that may hold unsafe code: instructions that the compiler cannot know the processor to have.
const UNSAFE_FILES: [&str; 2] = ["crates/geometry/src/simd/avx2.rs", "crates/geometry/src/simd/avx512.rs"];

/// What switches the lint against unsafe code off. In pieces, so that this file does not hold it either.
const ALLOWS_UNSAFE: [&str; 2] = [concat!("allow(unsafe", "_code"), concat!("expect(unsafe", "_code")];

/// Beginnings of paths and hosts that belong to some machine or other.
const MACHINE_BOUND: [&str; 6] = [
    concat!("/wo", "rk/"),
    concat!("/ho", "me/"),
    concat!("/ro", "ot/"),
    concat!("/us", "ers/"),
    concat!("index.", "crates.io"),
    concat!("static.", "crates.io"),
];

pub(crate) fn run() -> Result<()> {
    let files = workspace::files()?;
    ensure!(!files.is_empty(), "git lists no files");
    let numerics = fs::read_to_string(workspace::root().join("NUMERICS.md"))?;
    let listed = literals::listed(&numerics);
    let mut complaints = Vec::new();
    let (mut used, mut holding) = (Vec::new(), Vec::new());
    for file in &files {
        let Ok(text) = fs::read_to_string(workspace::root().join(file)) else { continue };
        complaints.extend(machine_bound(file, &text));
        if file.extension().is_some_and(|extension| extension == "rs") {
            complaints.extend(leftovers(file, &text));
            complaints.extend(unsafe_code(file, &text));
            let small = literals::small_literals(file, &text);
            if !small.is_empty() {
                holding.push(file.display().to_string());
            }
            complaints.extend(unlisted_literals(file, &small, &listed));
            let large = sizes(file, &text);
            match exception(file) {
                Some(excepted) if !large.is_empty() => used.push(excepted),
                _ => complaints.extend(large),
            }
        }
    }
    let unused = EXCEPTIONS.iter().filter(|(file, _)| !used.contains(file));
    complaints.extend(unused.map(|(file, reason)| format!("{file}: needs no exception any more ({reason})")));
    complaints.extend(needless_entries(&listed, &holding));
    complaints.extend(readmes()?);
    complaints.extend(unlisted_fixtures(&files)?);
    no_complaints(&complaints)?;
    println!("{} files are tidy", files.len());
    Ok(())
}

fn exception(file: &Path) -> Option<&'static str> {
    EXCEPTIONS.iter().map(|(excepted, _)| *excepted).find(|excepted| file == Path::new(excepted))
}

fn sizes(file: &Path, text: &str) -> Vec<String> {
    let is_test = file.components().any(|part| part.as_os_str() == "tests") || file.ends_with("tests.rs");
    let mut complaints = Vec::new();
    let own = source::without_tests(text);
    let lines = own.lines().count();
    if lines > FILE_LINES && !is_test {
        complaints.push(format!("{}: {lines} lines without tests, {FILE_LINES} at most", file.display()));
    }
    for (name, line, length) in source::functions(&own) {
        if length > FUNCTION_LINES {
            complaints.push(format!("{}:{line}: {name} has {length} lines, {FUNCTION_LINES} at most", file.display()));
        }
    }
    complaints
}

/// Small literals of a file that NUMERICS.md does not list with a reason.
fn unlisted_literals(file: &Path, small: &[String], listed: &BTreeMap<&str, &str>) -> Option<String> {
    let is_listed = listed.get(&*file.display().to_string()).is_some_and(|reason| !reason.is_empty());
    let text = || format!("{}: {} without a reason in NUMERICS.md (Small literals)", file.display(), small.join(", "));
    (!small.is_empty() && !is_listed).then(text)
}

/// Entries of that list that no file needs any more.
fn needless_entries(listed: &BTreeMap<&str, &str>, holding: &[String]) -> Vec<String> {
    let needless = listed.keys().filter(|file| !holding.iter().any(|held| held == *file));
    needless.map(|file| format!("NUMERICS.md (Small literals): {file} has none")).collect()
}

fn leftovers(file: &Path, text: &str) -> Vec<String> {
    let found = text.lines().enumerate().flat_map(|(number, line)| {
        let words = LEFTOVERS.iter().filter(move |word| line.contains(*word));
        words.map(move |word| format!("{}:{}: {word}", file.display(), number + 1))
    });
    found.collect()
}

/// Unsafe code outside of its files, or in them without a note on why it is sound.
fn unsafe_code(file: &Path, text: &str) -> Option<String> {
    if !ALLOWS_UNSAFE.iter().any(|words| text.contains(words)) {
        return None;
    }
    if !UNSAFE_FILES.iter().any(|allowed| file == Path::new(allowed)) {
        return Some(format!("{}: unsafe code has its own files: {}", file.display(), UNSAFE_FILES.join(", ")));
    }
    (!text.contains("SAFETY")).then(|| format!("{}: unsafe code without a SAFETY note", file.display()))
}

fn machine_bound(file: &Path, text: &str) -> Vec<String> {
    let found = text.lines().enumerate().flat_map(|(number, line)| {
        let line = line.to_lowercase();
        let places = MACHINE_BOUND.iter().filter(move |place| line.contains(*place));
        places.map(move |place| format!("{}:{}: speaks of {place}", file.display(), number + 1))
    });
    found.collect()
}

/// Crates whose README is missing or shows no code.
fn readmes() -> Result<Vec<String>> {
    let mut complaints = Vec::new();
    let mut crates = fs::read_dir(workspace::root().join("crates"))?.collect::<Result<Vec<_>, _>>()?;
    crates.retain(|entry| entry.path().join("Cargo.toml").is_file());
    ensure!(!crates.is_empty(), "there are no crates");
    for entry in crates {
        let readme = fs::read_to_string(entry.path().join("README.md")).unwrap_or_default();
        if first_example(&readme).is_none() {
            complaints.push(format!("{}: its README has no Rust example", entry.file_name().display()));
        }
    }
    Ok(complaints)
}

/// Fixtures that the list of fixtures does not name, or whose source or licence it does not tell.
fn unlisted_fixtures(files: &[PathBuf]) -> Result<Vec<String>> {
    let list = fs::read_to_string(crate::fixtures::folder().join("README.md"))?;
    let fixtures = files.iter().filter_map(|file| file.strip_prefix("fixtures").ok());
    let named = fixtures.map(|file| file.display().to_string());
    // Stored results and the inputs of fuzzing are told as a whole.
    let is_listed = |name: &String| name != "README.md" && !name.starts_with("expected/") && !name.starts_with("fuzz/");
    let outside = named.filter(is_listed);
    Ok(outside.filter_map(|name| fixture_defect(&list, &name)).collect())
}

/// What the list of fixtures lacks about one: its row ends with the source and the licence.
fn fixture_defect(list: &str, name: &str) -> Option<String> {
    let quoted = format!("`{name}`");
    let row = list.lines().find(|line| line.split('|').nth(1).is_some_and(|files| files.contains(&quoted)));
    let Some(row) = row else { return Some(format!("fixtures/{name} is not in fixtures/README.md")) };
    let cells: Vec<&str> = row.trim_end_matches('|').split('|').map(str::trim).collect();
    let is_sourced = cells.len() >= 6 && cells[cells.len() - 2..].iter().all(|cell| !cell.is_empty());
    (!is_sourced).then(|| format!("fixtures/{name} has no source and licence in fixtures/README.md"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_count_without_tests() {
        let file = Path::new("crates/a/src/lib.rs");
        let long = format!("fn long() {{\n{}}}\n", "    step();\n".repeat(FUNCTION_LINES));
        assert_eq!(sizes(file, &long).len(), 1);
        assert!(sizes(file, &format!("#[cfg(test)]\nmod tests {{\n{long}}}\n")).is_empty());
        assert_eq!(sizes(file, &"const A: u8 = 0;\n".repeat(FILE_LINES + 1)).len(), 1);
    }

    #[test]
    fn unsafe_code_stays_in_its_files() {
        let text = format!("#![{}, reason = \"\")]\n", ALLOWS_UNSAFE[0]);
        assert!(unsafe_code(Path::new("a.rs"), &text).is_some());
        assert!(unsafe_code(Path::new(UNSAFE_FILES[0]), &text).is_some());
        assert_eq!(unsafe_code(Path::new(UNSAFE_FILES[0]), &format!("// SAFETY: none.\n{text}")), None);
    }

    #[test]
    fn small_literals_need_a_reason() {
        let (file, small) = (Path::new("crates/a/src/lib.rs"), ["1e-9".to_owned()]);
        let listed = |reason| BTreeMap::from([("crates/a/src/lib.rs", reason)]);
        assert!(unlisted_literals(file, &small, &BTreeMap::new()).is_some());
        assert!(unlisted_literals(file, &small, &listed("")).is_some(), "a row without a reason");
        assert_eq!(unlisted_literals(file, &small, &listed("for printing")), None);
        assert_eq!(unlisted_literals(file, &[], &BTreeMap::new()), None);
        assert_eq!(needless_entries(&listed("for printing"), &[]).len(), 1);
        assert!(needless_entries(&listed("for printing"), &[file.display().to_string()]).is_empty());
    }

    #[test]
    fn fixtures_need_a_source() {
        let list =
            "| `a.obj` | what for | checks | generated | as the project |\n| `b.obj` | what for | checks | | |\n";
        assert_eq!(fixture_defect(list, "a.obj"), None);
        assert!(fixture_defect(list, "b.obj").is_some_and(|defect| defect.contains("source")));
        assert!(fixture_defect(list, "c.obj").is_some_and(|defect| defect.contains("not in")));
    }

    #[test]
    fn ignored_tests_are_leftovers() {
        let own = format!("{}]", LEFTOVERS[2]);
        let conditional =
            [format!("#[cfg_attr(unix{}]", LEFTOVERS[3]), format!("#[cfg_attr(unix{} \"slow\")]", LEFTOVERS[4])];
        for attribute in [own].into_iter().chain(conditional) {
            let text = format!("#[test]\n{attribute}\nfn slow() {{}}\n");
            assert_eq!(leftovers(Path::new("a.rs"), &text).len(), 1, "{attribute}");
        }
    }

    #[test]
    fn leftovers_and_paths_are_found() {
        let file = Path::new("a.rs");
        let text = format!("fine();\n{}();\nopen(\"{}x\");\n", LEFTOVERS[0], MACHINE_BOUND[0]);
        assert_eq!(leftovers(file, &text).len(), 1);
        assert_eq!(machine_bound(file, &text).len(), 1);
    }
}
