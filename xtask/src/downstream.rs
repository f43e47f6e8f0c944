//! Each layer, used the way a stranger would: a small crate outside the workspace, whose program is the first Rust
//! example of the layer's README, built and run.
//!
//! Such a crate depends on the layer by its path. Types of other crates that are part of the layer's interface (glam's
//! vectors, the bodies of umbriel-geometry) are named by the example too; those crates are added, at the layer's own
//! versions, but only if the layer itself depends on them: the example can need nothing else.

use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use anyhow::{Context, Result, ensure};
use serde::Deserialize;

use crate::workspace::{self, output_of, succeed};

const LAYERS: [&str; 7] = ["geometry", "scene", "bvh", "octree", "io", "visibility", "shadow"];

#[derive(Debug, Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

#[derive(Debug, Deserialize)]
struct Package {
    name: String,
    dependencies: Vec<Dependency>,
}

/// A dependency with all that is needed to ask for the same thing again.
#[derive(Debug, Deserialize)]
struct Dependency {
    name: String,
    kind: Option<String>,
    req: String,
    path: Option<PathBuf>,
    features: Vec<String>,
    uses_default_features: bool,
}

pub(crate) fn run() -> Result<()> {
    let text = output_of(&mut workspace::cargo(&["metadata", "--no-deps", "--format-version", "1"]))?;
    let metadata: Metadata = serde_json::from_str(&text).context("cargo metadata printed something unknown")?;
    let downstream = workspace::root().join("target/downstream");
    for layer in LAYERS {
        let name = format!("umbriel-{layer}");
        let package = metadata.packages.iter().find(|package| package.name == name);
        let package = package.with_context(|| format!("there is no crate {name}"))?;
        let folder = downstream.join(layer);
        make(layer, package, &folder).with_context(|| format!("the example of {name}"))?;
        build_and_run(layer, &folder, &downstream.join("target")).with_context(|| format!("the example of {name}"))?;
        println!("{name}: its example works from outside");
    }
    Ok(())
}

/// Writes the crate.
fn make(layer: &str, package: &Package, folder: &Path) -> Result<()> {
    let crate_folder = workspace::root().join("crates").join(layer);
    let readme = fs::read_to_string(crate_folder.join("README.md"))?;
    let example = first_example(&readme).context("its README has no Rust example")?;
    let mut manifest = format!(
        "[package]\nname = \"downstream-{layer}\"\nversion = \"0.0.0\"\nedition = \"2024\"\npublish = false\n\n\
         [workspace]\n\n[dependencies]\n{} = {{ path = {crate_folder:?} }}\n",
        package.name
    );
    let is_named = |dependency: &&Dependency| {
        dependency.kind.is_none() && example.contains(&format!("{}::", dependency.name.replace('-', "_")))
    };
    for dependency in package.dependencies.iter().filter(is_named) {
        manifest.push_str(&dependency.line());
    }
    fs::create_dir_all(folder.join("src"))?;
    fs::write(folder.join("Cargo.toml"), manifest)?;
    fs::write(folder.join("src/main.rs"), program(&example))?;
    // The versions that the workspace was tested with.
    fs::copy(workspace::root().join("Cargo.lock"), folder.join("Cargo.lock"))?;
    Ok(())
}

impl Dependency {
    /// Its line in a manifest.
    fn line(&self) -> String {
        let mut line = format!("{} = {{ version = {:?}", self.name, self.req);
        // Writing to a string cannot fail.
        if let Some(path) = &self.path {
            let _ = write!(line, ", path = {path:?}");
        }
        if !self.uses_default_features {
            line.push_str(", default-features = false");
        }
        if !self.features.is_empty() {
            let _ = write!(line, ", features = {:?}", self.features);
        }
        line + " }\n"
    }
}

/// Runs it in the folder of the fixtures: an example may load a scene.
fn build_and_run(layer: &str, folder: &Path, target: &Path) -> Result<()> {
    let mut build = workspace::cargo(&["build", "--quiet", "--manifest-path"]);
    build.arg(folder.join("Cargo.toml")).arg("--target-dir").arg(target);
    succeed(&mut build)?;
    let program = target.join("debug").join(format!("downstream-{layer}{}", std::env::consts::EXE_SUFFIX));
    let output = Command::new(program).current_dir(crate::fixtures::folder()).output()?;
    ensure!(output.status.success(), "it ended with {}:\n{}", output.status, String::from_utf8_lossy(&output.stderr));
    Ok(())
}

/// The first block of Rust in a README, without its fences.
pub(crate) fn first_example(readme: &str) -> Option<String> {
    let mut lines = readme.lines();
    lines.find(|line| line.starts_with("```rust"))?;
    Some(lines.take_while(|line| !line.starts_with("```")).flat_map(|line| [line, "\n"]).collect())
}

/// A whole program, by the rules of documentation tests: hidden lines are shown, a missing `main` is added.
fn program(example: &str) -> String {
    let shown = |line: &str| line.strip_prefix("# ").map_or_else(|| line.to_owned(), str::to_owned) + "\n";
    let code: String = example.lines().map(shown).collect();
    if code.contains("fn main()") {
        code
    } else if code.trim_end().ends_with("(())") {
        format!(
            "fn main() {{\nfn example() -> Result<(), impl std::fmt::Debug> {{\n{code}}}\nexample().unwrap();\n}}\n"
        )
    } else {
        format!("fn main() {{\n{code}}}\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_rust_block_is_taken() {
        let readme = "# A\n\n```toml\na = 1\n```\n\n```rust,no_run\nlet a = 1;\n```\n\n```rust\nlet b = 2;\n```\n";
        assert_eq!(first_example(readme).as_deref(), Some("let a = 1;\n"));
        assert_eq!(first_example("no code"), None);
    }

    #[test]
    fn examples_become_programs() {
        assert_eq!(program("fn main() {}\n"), "fn main() {}\n");
        assert_eq!(program("let a = 1;\n# let b = a;\n"), "fn main() {\nlet a = 1;\nlet b = a;\n}\n");
        assert!(program("f()?;\n# Ok::<(), Error>(())\n").contains("example().unwrap()"));
    }
}
