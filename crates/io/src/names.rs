//! Names made unique: the first keeps its name, later ones get `_2`, `_3`, ...

use std::collections::{HashMap, HashSet};

/// The names given so far.
#[derive(Debug, Default)]
pub(crate) struct Names {
    taken: HashSet<String>,
    /// The last number tried for a name, so that many equal names cost one try each.
    last: HashMap<String, usize>,
}

impl Names {
    /// `name`, or a variant of it that is not taken yet.
    pub(crate) fn unique(&mut self, name: &str) -> String {
        let mut unique = name.to_owned();
        while !self.taken.insert(unique.clone()) {
            let number = self.last.entry(name.to_owned()).or_insert(1);
            *number += 1;
            unique = format!("{name}_{number}");
        }
        unique
    }
}

#[cfg(test)]
mod tests {
    use super::Names;

    #[test]
    fn equal_names_are_numbered() {
        let mut names = Names::default();
        let given = ["a", "a_2", "a", "a", ""].map(|name| names.unique(name));
        assert_eq!(given, ["a", "a_2", "a_3", "a_4", ""]);
    }
}
