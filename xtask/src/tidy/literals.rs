//! Small numbers: what looks like an epsilon must say why it is none.
//!
//! The libraries hold no float between 1e-20 and 1e-3 in size, written as a literal or made of literals, but in files that
//! NUMERICS.md lists with the reason. Bounds that are derived come from the unit roundoff, and need no such number.

use std::{collections::BTreeMap, path::Path};

use super::{
    constants::{Constant, constants_where},
    source,
};

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

/// The small numbers of a library's file, tests and comments left out.
pub(super) fn small_literals(file: &Path, text: &str) -> Vec<String> {
    let is_library = file.starts_with("crates") && file.components().any(|part| part.as_os_str() == "src");
    let is_test = file.components().any(|part| part.as_os_str() == "tests") || file.ends_with("tests.rs");
    if !is_library || is_test {
        return Vec::new();
    }
    let own = source::without_tests(text);
    let code = own.lines().map(|line| line.split("//").next().unwrap_or_default());
    let is_small = |number: Constant| number.is_float && SMALL.contains(&number.value.abs());
    code.flat_map(|line| constants_where(line, is_small)).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "crates/a/src/lib.rs";

    #[test]
    fn small_numbers_are_found() {
        let found = |line: &str| small_literals(Path::new(FILE), line);
        for (line, number) in [
            ("if x < 1e-9 {", "1e-9"),
            ("let a = 0.000_1f32;", "0.000_1f32"),
            ("f(1.5E-6_f64.min(y))", "1.5E-6_f64"),
            ("const A: f64 = -2.5e-4;", "2.5e-4"),
            ("if x < 5e-4 * 1e4 {", "5e-4"),
            ("if x < 2f64.powi(-40) {", "2f64.powi(-40)"),
            ("f(10.0_f32.powi(-7))", "(10.0_f32.powi(-7))"),
            ("1_000f64.powi(-2)", "1_000f64.powi(-2)"),
            ("0.5f64.powi(20)", "0.5f64.powi(20)"),
            ("f64::powi(2.0, -20)", "f64::powi(2.0, -20)"),
            ("f64::powi(x, 2) < f64::powi(0.5, 20)", "f64::powi(0.5, 20)"),
            ("2f64.powf(-20.0)", "2f64.powf(-20.0)"),
            ("(-20f64).exp2()", "(-20f64).exp2()"),
            ("libm::ldexp(1.0, -20)", "libm::ldexp(1.0, -20)"),
            ("1.0 / (1u64 << 40) as f64", "1.0 / (1u64 << 40) as f64"),
            ("1.0 / f64::from(1u32 << 20)", "1.0 / f64::from(1u32 << 20)"),
            ("1.0 / (1 << 20) as f32 * y", "1.0 / (1 << 20) as f32"),
            ("1.0 - 1.0 / 1_048_576.0", "1.0 / 1_048_576.0"),
            ("(1.0 + 1.0 / 4096.0) * x", "1.0 / 4096.0"),
            ("x < width / 65536.0", "/ 65536.0"),
            ("x.0 / (1u64 << 16) as f64", "/ (1u64 << 16) as f64"),
            ("x / tuple.0 / 4096.0", "/ 4096.0"),
            ("0.0..1e-3", "1e-3"),
            ("4096f64.recip()", "4096f64.recip()"),
            ("f64::from_bits((1023 - 40) << 52)", "f64::from_bits((1023 - 40) << 52)"),
        ] {
            assert_eq!(found(line), [number], "{line}");
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
            "2f64.powi(-n)",
            "1 / 4096",
            "x / 64.0",
            "8e6 / 4096.0",
            "8.0 * f64::EPSILON",
            "f64::from_bits((1023 - 200) << 52)",
            "1.0 / 4096f64.max(x)",
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
