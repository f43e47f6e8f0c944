//! JSON as its grammar allows it, made into what the reader of JSON takes.

/// What stands for a half of a character: as long as the escape of the half.
const REPLACEMENT: &[u8] = b"\\ufffd";

/// The text with floats that are whole numbers as integers, and without halves of characters, in the same place where there is room.
pub(super) fn plain(text: &[u8]) -> Vec<u8> {
    let mut changed = Vec::with_capacity(text.len());
    for token in Tokens(text) {
        let end = changed.len() + token.len();
        match whole_number(token).filter(|_| token[0] != b'"') {
            Some(number) => changed.extend(number.to_string().bytes()),
            None => changed.extend(token),
        }
        changed.resize(end.max(changed.len()), b' ');
        if token[0] == b'"' {
            let string = &mut changed[end - token.len()..end];
            for at in halves_of(token) {
                string[at..at + REPLACEMENT.len()].copy_from_slice(REPLACEMENT);
            }
        }
    }
    changed
}

/// How many halves of characters the strings of a text hold.
pub(super) fn halves(text: &[u8]) -> usize {
    Tokens(text).filter(|token| token[0] == b'"').map(|token| halves_of(token).len()).sum()
}

/// Strings, numbers, and what is between them byte by byte.
pub(super) struct Tokens<'a>(&'a [u8]);

impl<'a> Tokens<'a> {
    /// Those of a text.
    pub(super) fn of(text: &'a [u8]) -> Self {
        Self(text)
    }
}

impl<'a> Iterator for Tokens<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let length = match self.0.first()? {
            b'"' => string_length(self.0),
            b'-' | b'0'..=b'9' => {
                self.0.iter().take_while(|byte| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E')).count()
            }
            _ => 1,
        };
        let (token, behind) = self.0.split_at(length);
        self.0 = behind;
        Some(token)
    }
}

/// Where the escapes of halves of characters (U+D800 to U+DFFF, in UTF-16 one before the other) stand alone in a string.
fn halves_of(string: &[u8]) -> Vec<usize> {
    let unit = |at: usize| {
        let digits = string.get(at..at + 6)?.strip_prefix(b"\\u")?;
        u16::from_str_radix(str::from_utf8(digits).ok()?, 16).ok()
    };
    let (mut halves, mut at) = (Vec::new(), 0);
    while let Some(escape) = string[at..].iter().position(|&byte| byte == b'\\') {
        at += escape;
        let is_pair = matches!((unit(at), unit(at + 6)), (Some(0xD800..0xDC00), Some(0xDC00..0xE000)));
        let is_half = !is_pair && matches!(unit(at), Some(0xD800..0xE000));
        halves.extend(is_half.then_some(at));
        at = (at + if is_pair { 12 } else { 2 }).min(string.len());
    }
    halves
}

/// The integer that a float stands for, if it is one by its digits: `3.0`, `1e1`, `0.1e1`; not what is only rounded to one.
fn whole_number(token: &[u8]) -> Option<i64> {
    let text = str::from_utf8(token).ok().filter(|text| text.contains(['.', 'e', 'E']))?;
    let (digits, power) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let zeros_from_end = fraction.bytes().rev().chain(whole.bytes().rev()).take_while(|&digit| digit == b'0').count();
    let power: i64 = power.parse().ok()?;
    let is_zero = zeros_from_end == fraction.len() + whole.trim_start_matches('-').len();
    // The last digit that is no zero must stay before the point.
    if !is_zero && power.saturating_add(zeros_from_end as i64) < fraction.len() as i64 {
        return None;
    }
    // JSON wants a digit after the point.
    let float: f64 = serde_json::from_str(text).ok()?;
    // Floats hold all whole numbers up to 2^53, and round the next one to it.
    (float.abs() < 9_007_199_254_740_992.0).then_some(float as i64)
}

/// The length of the string that a text begins with, its quotes included.
fn string_length(text: &[u8]) -> usize {
    let mut at = 1;
    while let Some(&byte) = text.get(at) {
        match byte {
            b'"' => return at + 1,
            b'\\' => at += 2,
            _ => at += 1,
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_and_halves_keep_their_places() {
        let plain = |text: &str| String::from_utf8(plain(text.as_bytes())).expect("UTF-8");
        assert_eq!(plain(r#"{"3.0":[3.0,2.5,1e1,-0.0]}"#), r#"{"3.0":[3  ,2.5,10 ,0   ]}"#);
        assert_eq!(
            plain("[1.,1e-400,3.00000000000000000001,40e-1,-2.00e0]"),
            "[1.,1e-400,3.00000000000000000001,4    ,-2     ]"
        );
        assert_eq!(plain(r#""\ud83c\udfe0\\ud800""#), r#""\ud83c\udfe0\\ud800""#);
        assert_eq!(plain(r#""a\ud800b\udc00\ud801\ud802\udc02""#), r#""a\ufffdb\ufffd\ufffd\ud802\udc02""#);
        assert_eq!(halves(br#"["\ud800", "\\ud800", "\uDFFF\uD800", "\ud8"#), 3);
    }
}
