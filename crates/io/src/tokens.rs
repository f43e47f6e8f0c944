//! Words between white space, each with its line.

/// The words of a text. O(bytes) for all of them.
#[derive(Clone)]
pub(crate) struct Tokens<'a> {
    rest: &'a str,
    line: usize,
}

impl<'a> Tokens<'a> {
    /// The words of `text`, whose first line has the number `line`.
    pub(crate) fn new(text: &'a str, line: usize) -> Self {
        Self { rest: text, line }
    }

    /// The next word.
    pub(crate) fn next(&mut self) -> Option<&'a str> {
        self.skip_space();
        let (word, rest) = self.rest.split_at(self.rest.find(char::is_whitespace).unwrap_or(self.rest.len()));
        self.rest = rest;
        (!word.is_empty()).then_some(word)
    }

    /// Goes to where the next word begins.
    pub(crate) fn skip_space(&mut self) {
        let start = self.rest.find(|c: char| !c.is_whitespace()).unwrap_or(self.rest.len());
        let (space, word) = self.rest.split_at(start);
        let space = space.as_bytes();
        let ends = |(i, &byte): (usize, &u8)| byte == b'\n' || byte == b'\r' && space.get(i + 1) != Some(&b'\n');
        self.line += space.iter().enumerate().filter(|&end| ends(end)).count();
        self.rest = word;
    }

    /// What is left of the line of the last word, up to a word that `ends` it: that is asked of all that begins with one.
    pub(crate) fn line_until(&mut self, ends: impl Fn(&str) -> bool) -> &'a str {
        let (line, rest) = self.rest.split_at(self.line_length(ends));
        self.rest = rest;
        line
    }

    /// Whether a word of the same line follows that `ends` it.
    pub(crate) fn has_on_line(&self, ends: impl Fn(&str) -> bool) -> bool {
        let behind = &self.rest[self.line_length(ends)..];
        behind.starts_with(|character| !matches!(character, '\n' | '\r'))
    }

    fn line_length(&self, ends: impl Fn(&str) -> bool) -> usize {
        let mut before = ' ';
        for (at, character) in self.rest.char_indices() {
            let begins_word = before.is_whitespace() && !character.is_whitespace();
            if matches!(character, '\n' | '\r') || begins_word && ends(&self.rest[at..]) {
                return at;
            }
            before = character;
        }
        self.rest.len()
    }

    /// Passes a word or several whole words if they come next, after white space of the line.
    pub(crate) fn skip(&mut self, words: &str) {
        let rest = self.rest.trim_start_matches([' ', '\t']);
        let behind = rest.strip_prefix(words).filter(|behind| !behind.starts_with(|c: char| !c.is_whitespace()));
        self.rest = behind.unwrap_or(rest);
    }

    /// The line of the last word, or of the next one where space was skipped; where there is none, the last line.
    pub(crate) fn line(&self) -> usize {
        self.line
    }

    /// The bytes that are left.
    pub(crate) fn remaining(&self) -> usize {
        self.rest.len()
    }
}

/// A finite number as programs in Fortran write their double precision, `1.5D+00`; other readers take it as 1.5, whatever the exponent.
pub(crate) fn fortran_number(word: &str) -> Option<f64> {
    let standard = word.replace(['d', 'D'], "e");
    // Words without digits before the exponent are names of infinities and the like.
    let begins = standard.trim_start_matches(['+', '-', '.']).starts_with(|first: char| first.is_ascii_digit());
    standard.parse().ok().filter(|number: &f64| begins && number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_of_fortran() {
        let read = ["1.5D+00", "-2d3", ".5d-1", "7", "+1E2"].map(fortran_number);
        assert_eq!(read, [Some(1.5), Some(-2000.0), Some(0.05), Some(7.0), Some(100.0)]);
        assert_eq!(["d", "1d", "1dd2", "d1", "1d999", "inf", "nand", ""].map(fortran_number), [None; 8]);
    }

    #[test]
    fn words_and_their_lines() {
        let mut tokens = Tokens::new(" a b\r\n\r\nc\rd rest of it \ne", 10);
        let mut next = || (tokens.next(), tokens.line());
        assert_eq!([next(), next()], [(Some("a"), 10), (Some("b"), 10)]);
        assert_eq!([next(), next()], [(Some("c"), 12), (Some("d"), 13)]);
        assert!(tokens.has_on_line(|rest| rest.starts_with("of")) && !tokens.has_on_line(|rest| rest.starts_with("e")));
        assert_eq!(tokens.line_until(|rest| rest.starts_with("of")), " rest ");
        assert_eq!((tokens.line_until(|_| false), tokens.next(), tokens.line()), ("of it ", Some("e"), 14));
        assert_eq!((tokens.next(), tokens.remaining()), (None, 0));
    }
}
