//! Names made unique, and fit to be shown: the first keeps its name, later ones get `_2`, `_3`, ...

use std::{
    borrow::Cow,
    collections::{HashMap, HashSet},
};

/// The text with its control characters written out (`\n`, `\u{1b}`): what is printed must not move a terminal's cursor, and a
/// name is one line.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(char::is_control) {
        return text.into();
    }
    let mut shown = String::with_capacity(text.len());
    for character in text.chars() {
        if character.is_control() { shown.extend(character.escape_default()) } else { shown.push(character) }
    }
    shown.into()
}

/// A name as a file gives it, of 200 characters at most: a scene may place the object that has it thousands of times. One that is
/// longer ends with a hash of all of it, so that it stays another than its neighbour's. Cutting twice changes nothing.
pub(crate) fn brief_name(name: &str) -> String {
    const LONGEST: usize = 200;
    match name.char_indices().nth(LONGEST) {
        Some(_) => {
            let ending = format!("…{:016x}", hash(name));
            name.chars().take(LONGEST - 17).chain(ending.chars()).collect()
        }
        None => name.to_owned(),
    }
}

/// FNV-1a, 64 bits (Fowler, Noll and Vo; RFC 9923): the same wherever it is computed.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// The names given so far.
#[derive(Debug, Default)]
pub(crate) struct Names {
    taken: HashSet<String>,
    /// The last number tried for a name, so that many equal names cost one try each.
    last: HashMap<String, usize>,
}

impl Names {
    /// `name`, as it can be printed, or a variant of it that is not taken yet.
    pub(crate) fn unique(&mut self, name: &str) -> String {
        let name = &*printable(name);
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
    use super::*;

    #[test]
    fn equal_names_are_numbered() {
        let mut names = Names::default();
        let given = ["a", "a_2", "a", "a", ""].map(|name| names.unique(name));
        assert_eq!(given, ["a", "a_2", "a_3", "a_4", ""]);
        assert_eq!(names.unique("\u{1b}[2Jä\n\u{9b}"), "\\u{1b}[2Jä\\n\\u{9b}");
    }

    #[test]
    fn long_names_are_cut_once() {
        assert_eq!(brief_name(&"ä".repeat(200)), "ä".repeat(200));
        let cut = brief_name(&"ä".repeat(100_000));
        assert!(cut.starts_with(&("ä".repeat(183) + "…")) && cut.chars().count() == 200, "{cut}");
        assert_ne!(cut, brief_name(&("ä".repeat(300) + "b")));
        assert_eq!(brief_name(&cut), cut);
    }
}
