//! The benchmarks of the single layers: lists what there is and runs it.

use std::fs;

use anyhow::Result;

use crate::workspace::{cargo, root, succeed};

/// Runs every benchmark under `crates/*/benches`, layer by layer.
pub(super) fn run() -> Result<()> {
    for (package, bench) in benches()? {
        println!("{package}: {bench}");
        succeed(&mut cargo(&["bench", "--quiet", "--package", &package, "--bench", &bench]))?;
    }
    Ok(())
}

/// Packages and their benchmarks, sorted.
fn benches() -> Result<Vec<(String, String)>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(root().join("crates"))? {
        let folder = entry?.path();
        let name = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let package = if name == "umbriel" { name } else { format!("umbriel-{name}") };
        let Ok(files) = fs::read_dir(folder.join("benches")) else { continue };
        for file in files {
            let file = file?.path();
            if file.extension().is_some_and(|extension| extension == "rs") {
                let bench = file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
                found.push((package.clone(), bench));
            }
        }
    }
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_layers_have_benchmarks() {
        let found = super::benches().expect("the workspace is there");
        for package in ["umbriel-bvh", "umbriel-octree"] {
            assert!(found.iter().any(|(known, _)| known == package), "{package}");
        }
    }
}
