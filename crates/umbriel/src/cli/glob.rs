//! Names with wildcards: `*` stands for any text, `?` for one character.

/// A pattern, ready for many names.
pub(crate) enum Pattern<'a> {
    /// One name.
    Plain(&'a str),
    /// With wildcards.
    Wild(Vec<char>),
}

impl<'a> Pattern<'a> {
    pub(crate) fn new(text: &'a str) -> Self {
        if text.contains(['*', '?']) { Self::Wild(text.chars().collect()) } else { Self::Plain(text) }
    }

    pub(crate) fn matches(&self, name: &str) -> bool {
        match self {
            Self::Plain(text) => *text == name,
            Self::Wild(pattern) => matches_wild(pattern, &name.chars().collect::<Vec<char>>()),
        }
    }
}

/// At a mismatch only the latest `*` is widened, which suffices: what an earlier one could take more of, the later one can take as
/// well. O(pattern · name) at worst.
fn matches_wild(pattern: &[char], name: &[char]) -> bool {
    let (mut p, mut n) = (0, 0);
    let mut star = None;
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(&c) if c == '?' || c == name[n] => (p, n) = (p + 1, n + 1),
            _ => {
                let Some((at, taken)) = star else { return false };
                star = Some((at, taken + 1));
                (p, n) = (at + 1, taken + 1);
            }
        }
    }
    pattern[p..].iter().all(|&c| c == '*')
}

#[cfg(test)]
mod tests {
    use super::Pattern;

    #[test]
    fn stars_and_question_marks() {
        for (pattern, name, expected) in [
            ("floor", "floor", true),
            ("floor", "floors", false),
            ("*", "", true),
            ("house/*", "house/roof", true),
            ("*roof", "house/roof/roof", true),
            ("b?ilding_*1", "building_301", true),
            ("?", "", false),
            ("?", "ü", true),
            ("a*b*c", "a__b__b__c", true),
            ("a*b*c", "a__c__b", false),
            ("", "", true),
            ("", "a", false),
        ] {
            assert_eq!(Pattern::new(pattern).matches(name), expected, "{pattern} on {name}");
        }
    }
}
