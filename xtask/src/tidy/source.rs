//! Rough reading of formatted Rust: where tests and functions begin and end, by indentation. rustfmt makes that enough.

/// The text without its `#[cfg(test)]` items.
pub(super) fn without_tests(text: &str) -> String {
    let mut kept = String::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.trim() == "#[cfg(test)]" {
            skip_item(&mut lines, indentation(line));
        } else {
            kept.push_str(line);
            kept.push('\n');
        }
    }
    kept
}

/// Takes the lines of one item: attributes, then up to a line that ends at its indentation.
fn skip_item<'a>(lines: &mut impl Iterator<Item = &'a str>, indent: usize) {
    for line in lines {
        if indentation(line) == indent && (line.ends_with(';') || line.ends_with('}')) {
            return;
        }
    }
}

/// The functions with bodies: name, first line (from 1), number of lines.
pub(super) fn functions(text: &str) -> Vec<(&str, usize, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (first, line) in lines.iter().enumerate() {
        let Some(name) = function_name(line) else { continue };
        let indent = indentation(line);
        let ends = |line: &&str| indentation(line) == indent && (line.ends_with('}') || line.ends_with(';'));
        let Some(length) = lines[first..].iter().position(ends) else { continue };
        found.push((name, first + 1, length + 1));
    }
    found
}

fn function_name(line: &str) -> Option<&str> {
    let mut words = line.split_whitespace().skip_while(|word| {
        *word == "pub" || word.starts_with("pub(") || ["const", "async", "unsafe", "extern"].contains(word)
    });
    let name = (words.next()? == "fn").then(|| words.next())??;
    name.split(['(', '<']).next()
}

fn indentation(line: &str) -> usize {
    line.len() - line.trim_start().len()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "\
use a;

pub(crate) const fn short<T>(a: T) -> T { a }

impl A {
    fn long(
        &self,
    ) -> u8 {
        if self.a {
            1
        } else {
            2
        }
    }
}

#[cfg(test)]
mod tests {
    fn hidden() {
    }
}

#[cfg(test)]
mod more;
fn last() {
}
";

    #[test]
    fn functions_are_measured() {
        assert_eq!(functions(&without_tests(TEXT)), [("short", 3, 1), ("long", 6, 9), ("last", 18, 2)]);
    }
}
