//! Small float literals: what looks like an epsilon must say why it is none.
//!
//! The libraries hold no float between 1e-20 and 1e-3 in size but in files that NUMERICS.md lists with the reason. Bounds that
//! are derived come from the unit roundoff, and need no such number.

use std::{collections::BTreeMap, path::Path};

use super::source;

/// What counts as small; magnitudes.
const SMALL: std::ops::RangeInclusive<f64> = 1e-20..=1e-3;

/// The heading in NUMERICS.md whose table lists the files.
const HEADING: &str = "Small literals";

/// The files that NUMERICS.md lists, each with its reason.
pub(super) fn listed(numerics: &str) -> BTreeMap<&str, &str> {
    let section = numerics.lines().skip_while(|line| !(line.starts_with("## ") && line.contains(HEADING))).skip(1);
    let rows = section.take_while(|line| !line.starts_with("## ")).filter_map(|line| {
        let mut cells = line.strip_prefix('|')?.split('|').map(str::trim);
        let file = cells.next()?.strip_prefix('`')?.strip_suffix('`')?;
        cells.next_back().filter(|rest| rest.is_empty())?;
        Some((file, line.trim_end_matches('|').rsplit('|').next()?.trim()))
    });
    rows.collect()
}

/// The small literals of a library's file, tests and comments left out.
pub(super) fn small_literals(file: &Path, text: &str) -> Vec<String> {
    let is_library = file.starts_with("crates") && file.components().any(|part| part.as_os_str() == "src");
    let is_test = file.components().any(|part| part.as_os_str() == "tests") || file.ends_with("tests.rs");
    if !is_library || is_test {
        return Vec::new();
    }
    let own = source::without_tests(text);
    let code = own.lines().map(|line| line.split("//").next().unwrap_or_default());
    let numbers = code.flat_map(|line| {
        let literals = float_literals(line).into_iter().map(|(text, value)| (text.to_owned(), value));
        literals.chain(powers(line)).collect::<Vec<_>>()
    });
    numbers.filter(|(_, value)| SMALL.contains(value)).map(|(text, _)| text).collect()
}

/// The numbers written as negative powers in a line of code: `2f64.powi(-20)`.
fn powers(line: &str) -> Vec<(String, f64)> {
    const POWER: &str = ".powi(-";
    let all = line.match_indices(POWER).filter_map(|(place, _)| {
        let (before, after) = (&line[..place], &line[place + POWER.len()..]);
        let exponent: i32 = after[..after.find(')')?].parse().ok()?;
        let start = before.rfind(|c: char| !(c.is_alphanumeric() || c == '_' || c == '.')).map_or(0, |end| end + 1);
        let base = before[start..].trim_end_matches("f64").trim_end_matches("f32").replace('_', "");
        let value: f64 = base.parse().ok()?;
        Some((format!("{}{POWER}{exponent})", &before[start..]), value.powi(-exponent)))
    });
    all.collect()
}

/// The numbers with a point or an exponent in a line of code.
fn float_literals(line: &str) -> Vec<(&str, f64)> {
    let mut found = Vec::new();
    let mut rest = line;
    while let Some(start) = rest.find(|c: char| c.is_alphanumeric() || c == '_') {
        let word = &rest[start..];
        let length = if word.starts_with(|c: char| c.is_ascii_digit()) {
            let length = number_length(word);
            let number = word[..length].trim_end_matches('_');
            found.extend(number.replace('_', "").parse().ok().map(|value| (number, value)));
            length
        } else {
            0
        };
        // What is left of the word: a name, a suffix, the digits of a hexadecimal number.
        let end = word[length..].find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(word.len() - length);
        rest = &word[length + end..];
    }
    found
}

/// How long the decimal number at the beginning of a text is.
fn number_length(text: &str) -> usize {
    let digits = |from: usize| {
        let rest = text.get(from..).unwrap_or_default();
        rest.find(|c: char| !(c.is_ascii_digit() || c == '_')).unwrap_or(rest.len())
    };
    let mut length = digits(0);
    if text[length..].starts_with('.') && digits(length + 1) > 0 {
        length += 1 + digits(length + 1);
    }
    if text[length..].starts_with(['e', 'E']) {
        let sign = usize::from(text[length + 1..].starts_with(['-', '+']));
        let exponent = digits(length + 1 + sign);
        length += if exponent > 0 { 1 + sign + exponent } else { 0 };
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "crates/a/src/lib.rs";

    #[test]
    fn small_literals_are_found() {
        let found = |line: &str| small_literals(Path::new(FILE), line);
        for (line, literal) in [
            ("if x < 1e-9 {", "1e-9"),
            ("let a = 0.000_1f32;", "0.000_1"),
            ("f(1.5E-6_f64.min(y))", "1.5E-6"),
            ("const A: f64 = -2.5e-4;", "2.5e-4"),
            ("if x < 2f64.powi(-40) {", "2f64.powi(-40)"),
            ("f(10.0_f32.powi(-7))", "10.0_f32.powi(-7)"),
            ("1_000f64.powi(-2)", "1_000f64.powi(-2)"),
        ] {
            assert_eq!(found(line), [literal], "{line}");
        }
        for line in [
            "let a = 1e-21;",
            "0..3",
            "x1e-9",
            "0.5 // not 1e-9",
            "tuple.0.1",
            "0x1e-9",
            "1.0e300",
            "0.0",
            "2f64.powi(-100)",
            "2f64.powi(40)",
            "x.powi(-9)",
        ] {
            assert!(found(line).is_empty(), "{line}");
        }
    }

    #[test]
    fn tests_and_programs_may_hold_them() {
        let text = "#[cfg(test)]\nmod tests {\n    const A: f64 = 1e-9;\n}\n";
        assert!(small_literals(Path::new(FILE), text).is_empty());
        for file in ["crates/a/src/a/tests.rs", "crates/a/tests/a.rs", "crates/a/examples/a.rs", "xtask/src/a.rs"] {
            assert!(small_literals(Path::new(file), "1e-9").is_empty(), "{file}");
        }
    }

    #[test]
    fn the_list_is_read() {
        let text = "## 1. Other\n| `a.rs` | no |\n## 14. Small literals\ntext\n\n| file | why |\n|---|---|\n| `b.rs` | 1e-9 | for printing |\n## 15. More\n| `c.rs` | no |\n";
        assert_eq!(listed(text), BTreeMap::from([("b.rs", "for printing")]));
        assert!(listed("").is_empty());
    }
}
