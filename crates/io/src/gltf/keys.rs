//! Names that stand twice in an object. Readers of JSON differ in which of the two they take (glTF 2.0, 2.7: they must be unique).
//!
//! The text is walked without recursion, since what nothing reads may be of any depth. The names of an object are sorted where it ends, so that takes
//! O(n log n) in their number, whatever they are.

use std::{borrow::Cow, fmt};

use umbriel_scene::FindingKind;

use super::text::Tokens;
use crate::{error::excerpt, model::Findings};

/// An object or a list that has not ended.
struct Open {
    /// The first of its names among those of all that are open.
    first: usize,
    /// The number of the element, if it is a list.
    element: Option<usize>,
}

/// Tells the names that stand twice, by their JSON pointers (RFC 6901). The text is JSON.
pub(super) fn check(text: &[u8]) -> Findings {
    let mut findings = Findings::default();
    let (mut open, mut names): (Vec<Open>, Vec<Cow<str>>) = (Vec::new(), Vec::new());
    let mut is_name = false;
    for token in Tokens::of(text) {
        match token[0] {
            b'{' => open.push(Open { first: names.len(), element: None }),
            b'[' => open.push(Open { first: names.len(), element: Some(0) }),
            b',' => {
                if let Some(Open { element: Some(number), .. }) = open.last_mut() {
                    *number += 1;
                }
            }
            b'"' if is_name => names.push(name_of(token)),
            b'}' => {
                let first = open.last().map_or(0, |last| last.first);
                names[first..].sort_unstable();
                for twice in names[first..].windows(2).filter(|two| two[0] == two[1]) {
                    let place = Pointer { open: &open, names: &names, name: &twice[0] };
                    findings.add_at(FindingKind::BrokenRule, "JSON: a name that stands twice in an object", place);
                }
            }
            _ => {}
        }
        if let b'}' | b']' = token[0] {
            names.truncate(open.pop().map_or(0, |last| last.first));
        }
        let is_in_object = open.last().is_some_and(|last| last.element.is_none());
        is_name = is_in_object && (matches!(token[0], b'{' | b',') || is_name && token[0].is_ascii_whitespace());
    }
    findings
}

/// What a name says.
fn name_of(token: &[u8]) -> Cow<'_, str> {
    let written = token.get(1..token.len() - 1).unwrap_or_default();
    match str::from_utf8(written) {
        Ok(plain) if !written.contains(&b'\\') => plain.into(),
        // One that says nothing is like none that does.
        _ => serde_json::from_slice(token).map_or_else(|_| String::from_utf8_lossy(token), Cow::Owned),
    }
}

/// Where a member of the last object is: written out for the few that are shown, as it is as long as the text is deep.
struct Pointer<'a> {
    open: &'a [Open],
    names: &'a [Cow<'a, str>],
    name: &'a str,
}

/// The last names of the objects around it, and numbers of elements.
impl fmt::Display for Pointer<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        for (outer, inner) in self.open.iter().zip(self.open.iter().skip(1)) {
            match (outer.element, self.names[..inner.first].last()) {
                (Some(number), _) => write!(formatter, "/{number}")?,
                (None, Some(name)) => write_name(formatter, name)?,
                (None, None) => {}
            }
        }
        write_name(formatter, self.name)
    }
}

/// A name as a step of a JSON pointer.
pub(super) fn write_name(formatter: &mut fmt::Formatter, name: &str) -> fmt::Result {
    write!(formatter, "/{}", excerpt(name).replace('~', "~0").replace('/', "~1"))
}
