//! Text of files that may come in several encodings and with several line ends.
//!
//! UTF-8 (bytes that are none become U+FFFD, so that a name in an old encoding spoils nothing), and UTF-16 in both byte
//! orders, told by the byte order mark or, without one, by the zero half of the first character (text formats here begin
//! with ASCII). Lines end with LF, CR LF or CR. O(bytes); UTF-8 is not copied.

use std::borrow::Cow;

use crate::error::LoadProblem;

/// The text, without a byte order mark, and the first line with something that is no character of its encoding, taken as U+FFFD.
///
/// # Errors
/// A zero character (binary data, or UTF-32), or half a character at the end, by its line.
pub(crate) fn decode(bytes: &[u8]) -> Result<(Cow<'_, str>, Option<usize>), LoadProblem> {
    let (text, odd_line) = match bytes {
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes)?,
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes)?,
        [first, 0, ..] if *first != 0 => utf16(bytes, u16::from_le_bytes)?,
        [0, second, ..] if *second != 0 => utf16(bytes, u16::from_be_bytes)?,
        [0xef, 0xbb, 0xbf, rest @ ..] => utf8(rest),
        _ => utf8(bytes),
    };
    match text.find('\0') {
        Some(at) => Err(LoadProblem::line(last_line(&text[..at]), "a zero character: this is no text")),
        None => Ok((without_end_mark(text), odd_line)),
    }
}

/// The text without the Ctrl-Z that old systems end it with.
fn without_end_mark(text: Cow<'_, str>) -> Cow<'_, str> {
    const END: char = '\u{1a}';
    let Some(length) = text.trim_end().strip_suffix(END).map(str::len) else { return text };
    match text {
        Cow::Borrowed(text) => text[..length].into(),
        Cow::Owned(mut text) => {
            text.truncate(length);
            text.into()
        }
    }
}

/// See [`decode`].
fn utf8(bytes: &[u8]) -> (Cow<'_, str>, Option<usize>) {
    let text = String::from_utf8_lossy(bytes);
    let odd = str::from_utf8(bytes).err().map(|fault| last_line(&text[..fault.valid_up_to()]));
    (text, odd)
}

/// See [`decode`].
fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<(Cow<'static, str>, Option<usize>), LoadProblem> {
    let (units, rest) = bytes.as_chunks::<2>();
    let (mut text, mut odd) = (String::new(), None);
    for character in char::decode_utf16(units.iter().map(|&bytes| unit(bytes))) {
        if character.is_err() {
            odd = odd.or_else(|| Some(last_line(&text)));
        }
        text.push(character.unwrap_or(char::REPLACEMENT_CHARACTER));
    }
    if rest.is_empty() {
        Ok((text.into(), odd))
    } else {
        Err(LoadProblem::line(last_line(&text), "the file ends within a character of UTF-16"))
    }
}

/// The lines, without their ends.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = Some(text);
    std::iter::from_fn(move || {
        let (line, behind) = cut_line(rest.take()?);
        rest = behind;
        Some(line)
    })
}

/// The first line, and what follows its end if it has one.
pub(crate) fn cut_line(text: &str) -> (&str, Option<&str>) {
    let Some(end) = text.find(['\n', '\r']) else { return (text, None) };
    let behind = &text[end..];
    (&text[..end], behind.strip_prefix("\r\n").or_else(|| behind.get(1..)))
}

/// The number of the line in which `text` ends, counted from 1.
pub(crate) fn last_line(text: &str) -> usize {
    lines(text).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoded(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(bytes).collect()
    }

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "v 1 2 3\r\no täst 🏠\n";
        let marked = format!("\u{feff}{text}");
        let forms = [
            text.as_bytes().to_vec(),
            marked.as_bytes().to_vec(),
            encoded(text, u16::to_le_bytes),
            encoded(text, u16::to_be_bytes),
            encoded(&marked, u16::to_le_bytes),
            encoded(&marked, u16::to_be_bytes),
        ];
        for bytes in forms {
            assert_eq!(decode(&bytes).expect("text"), (text.into(), None));
        }
        assert_eq!(decode(b"v 1 2 3\x1a\n").expect("text").0, "v 1 2 3");
        assert_eq!(decode(b"").expect("text").0, "");
    }

    #[test]
    fn what_is_no_character_is_replaced_and_told() {
        assert_eq!(decode(b"v\no t\xe4st\no \xff").expect("text"), ("v\no t\u{fffd}st\no \u{fffd}".into(), Some(2)));
        assert_eq!(decode(b"\xff\xfeo\0\n\0\0\xd8s\0").expect("text"), ("o\n\u{fffd}s".into(), Some(2)));
        let written = "o t\u{fffd}st";
        assert_eq!(decode(written.as_bytes()).expect("text"), (written.into(), None));
    }

    #[test]
    fn what_is_no_text_is_told_with_its_line() {
        let line = |bytes: &[u8]| match decode(bytes) {
            Err(LoadProblem::Text { line, .. }) => line,
            other => panic!("{other:?}"),
        };
        assert_eq!(line(b"a\r\nb\rc\nd\0"), 4);
        assert_eq!(line(b"\xff\xfea\0\n\0b"), 2);
        assert_eq!(line(b"\xff\xfe\0\0a\0\0\0"), 1, "UTF-32");
        assert_eq!(line(b"\0\0"), 1);
    }

    #[test]
    fn all_line_ends_end_lines() {
        assert_eq!(lines("a\nb\r\nc\rd\n\ne").collect::<Vec<_>>(), ["a", "b", "c", "d", "", "e"]);
        assert_eq!(lines("a\n").collect::<Vec<_>>(), ["a", ""]);
    }
}
