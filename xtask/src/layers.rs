//! Which crate may use which: the table of the design, and what the lowest layers must not need.
//!
//! Names are compared both ways: a crate that the table does not know, and a name in the table without a crate, fail
//! the check instead of slipping through it.

use std::{collections::BTreeMap, fs, path::Path};

use anyhow::{Context, Result, ensure};
use serde::Deserialize;

use crate::workspace::{self, no_complaints, output_of};

/// A crate and the crates of the workspace that it may use.
type Rule = (&'static str, &'static [&'static str]);

const ALL: [&str; 8] = [
    "umbriel-geometry",
    "umbriel-scene",
    "umbriel-bvh",
    "umbriel-octree",
    "umbriel-visibility",
    "umbriel-shadow",
    "umbriel-io",
    "umbriel",
];

const TABLE: [Rule; 9] = [
    ("umbriel-geometry", &[]),
    ("umbriel-scene", &["umbriel-geometry"]),
    ("umbriel-bvh", &["umbriel-geometry"]),
    ("umbriel-octree", &["umbriel-geometry", "umbriel-bvh"]),
    ("umbriel-io", &["umbriel-geometry", "umbriel-scene"]),
    ("umbriel-visibility", &["umbriel-geometry", "umbriel-scene", "umbriel-bvh", "umbriel-octree"]),
    ("umbriel-shadow", &["umbriel-geometry", "umbriel-scene", "umbriel-bvh", "umbriel-octree", "umbriel-visibility"]),
    (
        "umbriel",
        &[
            "umbriel-geometry",
            "umbriel-scene",
            "umbriel-bvh",
            "umbriel-octree",
            "umbriel-visibility",
            "umbriel-shadow",
            "umbriel-io",
        ],
    ),
    ("xtask", &ALL),
];

/// Layers that use no files, no threads, and none of these crates unless a feature asks for it.
const PURE: [&str; 3] = ["umbriel-geometry", "umbriel-bvh", "umbriel-octree"];
const NOT_IN_PURE: [&str; 6] = ["rayon", "rayon-core", "serde", "serde_core", "serde_derive", "serde_json"];
const PATHS_NOT_IN_PURE: [&str; 5] = ["std::fs", "std::thread", "std::process", "std::net", "std::env"];

#[derive(Debug, Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

#[derive(Debug, Deserialize)]
struct Package {
    name: String,
    dependencies: Vec<Dependency>,
}

#[derive(Debug, Deserialize)]
struct Dependency {
    name: String,
    /// None for a normal one.
    kind: Option<String>,
}

pub(crate) fn run() -> Result<()> {
    let text = output_of(&mut workspace::cargo(&["metadata", "--no-deps", "--format-version", "1"]))?;
    let metadata: Metadata = serde_json::from_str(&text).context("cargo metadata printed something unknown")?;
    let mut complaints = check(&TABLE, &metadata.packages);
    for layer in PURE {
        // A name that cargo does not know makes it fail, and so this check.
        let tree = output_of(&mut workspace::cargo(&["tree", "-e", "normal", "-p", layer, "--prefix", "none"]))?;
        complaints.extend(forbidden_crates(layer, &tree));
        complaints.extend(forbidden_paths(layer)?);
    }
    no_complaints(&complaints)?;
    println!("{} crates use what they may", metadata.packages.len());
    Ok(())
}

/// Compares what the crates use with the table.
fn check(table: &[Rule], packages: &[Package]) -> Vec<String> {
    let mut complaints = Vec::new();
    let rules: BTreeMap<&str, &[&str]> = table.iter().copied().collect();
    let exists = |name: &str| packages.iter().any(|package| package.name == name);
    for name in
        rules.iter().flat_map(|(name, allowed)| std::iter::once(name).chain(*allowed)).filter(|name| !exists(name))
    {
        complaints.push(format!("the table speaks of {name}, but there is no such crate"));
    }
    for package in packages {
        let Some(allowed) = rules.get(package.name.as_str()) else {
            complaints.push(format!("the table does not speak of {}", package.name));
            continue;
        };
        for dependency in package.dependencies.iter().filter(|dependency| exists(&dependency.name)) {
            let is_test = dependency.kind.as_deref() == Some("dev");
            let may = if is_test { dependency.name != "xtask" } else { allowed.contains(&dependency.name.as_str()) };
            if !may {
                complaints.push(format!("{} may not use {}", package.name, dependency.name));
            }
        }
    }
    complaints
}

/// The crates of a dependency tree that a pure layer must not have.
fn forbidden_crates(layer: &str, tree: &str) -> Vec<String> {
    let names = tree.lines().filter_map(|line| line.split_whitespace().next());
    let forbidden = names.filter(|name| NOT_IN_PURE.contains(name));
    forbidden.map(|name| format!("{layer} needs {name} without being asked to")).collect()
}

/// The places where a pure layer reaches for the system.
fn forbidden_paths(layer: &str) -> Result<Vec<String>> {
    let folder = layer.trim_start_matches("umbriel-");
    let source = Path::new("crates").join(folder).join("src");
    let mut complaints = Vec::new();
    let files = workspace::files()?;
    let own: Vec<_> = files.iter().filter(|file| file.starts_with(&source)).collect();
    ensure!(!own.is_empty(), "{} holds no source", source.display());
    for file in own {
        let text = fs::read_to_string(workspace::root().join(file))?;
        let code = text.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//"));
        for (number, line) in code {
            let found = PATHS_NOT_IN_PURE.iter().filter(|path| line.contains(*path));
            complaints.extend(found.map(|path| format!("{}:{}: {path} in a pure layer", file.display(), number + 1)));
        }
    }
    Ok(complaints)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(name: &str, uses: &[(&str, Option<&str>)]) -> Package {
        let dependency =
            |&(name, kind): &(&str, Option<&str>)| Dependency { name: name.to_owned(), kind: kind.map(str::to_owned) };
        Package { name: name.to_owned(), dependencies: uses.iter().map(dependency).collect() }
    }

    const SMALL: [Rule; 3] = [("low", &[]), ("high", &["low"]), ("xtask", &["low", "high"])];

    fn complaints_about(low: Package, high: Package) -> usize {
        check(&SMALL, &[low, high, package("xtask", &[("high", None)])]).len()
    }

    #[test]
    fn what_the_table_allows_passes() {
        assert_eq!(complaints_about(package("low", &[("glam", None)]), package("high", &[("low", None)])), 0);
        assert_eq!(complaints_about(package("low", &[("high", Some("dev"))]), package("high", &[])), 0);
    }

    #[test]
    fn what_it_does_not_allow_fails() {
        assert_eq!(complaints_about(package("low", &[("high", None)]), package("high", &[])), 1);
        assert_eq!(complaints_about(package("low", &[("high", Some("build"))]), package("high", &[])), 1);
        assert_eq!(complaints_about(package("low", &[("xtask", Some("dev"))]), package("high", &[])), 1);
    }

    #[test]
    fn a_misspelt_name_fails() {
        assert_eq!(check(&[("lwo", &[])], &[package("low", &[])]).len(), 2, "unknown both ways");
        assert_eq!(check(&[("low", &["hihg"])], &[package("low", &[])]).len(), 1);
        let unknown = output_of(&mut workspace::cargo(&["tree", "-e", "normal", "-p", "umbriel-geometri"]));
        assert!(unknown.is_err());
    }

    #[test]
    fn crates_are_found_in_a_tree() {
        let tree = "umbriel-bvh v0.1.0 (/somewhere)\nglam v0.34.0\nserde v1.0.1\nserde_derive v1.0.1 (proc-macro)\n";
        assert_eq!(forbidden_crates("umbriel-bvh", tree).len(), 2);
        assert!(forbidden_crates("umbriel-bvh", "glam v0.34.0\nserdeless v1.0.0\n").is_empty());
    }
}
