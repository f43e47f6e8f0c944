//! The extensions that a document says it uses.

use std::collections::HashSet;

use serde::Deserialize;

/// Names of extensions, each once.
#[derive(Debug, Default, Deserialize)]
#[serde(from = "Vec<String>")]
pub(in crate::gltf) struct ExtensionNames {
    names: HashSet<String>,
    /// Whether one of them is written twice.
    pub(in crate::gltf) repeats: bool,
}

impl From<Vec<String>> for ExtensionNames {
    fn from(written: Vec<String>) -> Self {
        let count = written.len();
        let names: HashSet<String> = written.into_iter().collect();
        Self { repeats: names.len() < count, names }
    }
}

impl ExtensionNames {
    pub(in crate::gltf) fn contains(&self, name: &str) -> bool {
        self.names.contains(name)
    }

    pub(in crate::gltf) fn iter(&self) -> impl Iterator<Item = &String> {
        self.names.iter()
    }
}
