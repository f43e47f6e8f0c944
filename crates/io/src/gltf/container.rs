//! Where the bytes of a glTF are: the chunks of a GLB, and buffers inside it, in data URIs and in files.

use std::{
    cell::{OnceCell, RefCell},
    collections::{BTreeSet, HashMap},
    path::PathBuf,
    rc::Rc,
};

use base64::Engine;

use super::json::{Buffer, existing};
use crate::{
    error::{LoadProblem, excerpt},
    folder::{Folder, Located},
    ledger::Ledger,
};

/// The parts of a file.
#[derive(Debug, Default)]
pub(super) struct Container<'a> {
    /// The JSON text.
    pub(super) text: &'a [u8],
    /// The binary chunk.
    pub(super) binary: Option<&'a [u8]>,
    /// Rules that are broken without harm.
    pub(super) broken: Vec<&'static str>,
}

/// The JSON text and the binary chunk of a file; a `.gltf` is all text.
///
/// ```text
/// GLB:   | "glTF" | version 2 | length |   then chunks  | length | type | bytes, padded to 4 |
/// ```
pub(super) fn split(bytes: &[u8]) -> Result<Container<'_>, LoadProblem> {
    let refused = |message: &str| LoadProblem::element("GLB container", message);
    if !bytes.starts_with(b"glTF") {
        let without_mark = bytes.strip_prefix(b"\xef\xbb\xbf");
        let broken = without_mark.map(|_| "a byte order mark before its text").into_iter().collect();
        return Ok(Container { text: without_mark.unwrap_or(bytes), broken, ..Container::default() });
    }
    let word = |at: usize| bytes.get(at..at + 4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]]) as usize);
    let (Some(version), Some(length)) = (word(4), word(8)) else { return Err(refused("its header is cut off")) };
    if version != 2 {
        return Err(refused(&format!("its version is {version}; only version 2 is read")));
    }
    if length > bytes.len() {
        return Err(refused(&format!("it says that it has {length} bytes, but the file has {}", bytes.len())));
    }
    let (mut at, mut json, mut binary, mut broken) = (12, None, None, Vec::new());
    if length < bytes.len() {
        broken.push("bytes after its end");
    }
    for number in 0.. {
        if at >= length {
            break;
        }
        let (Some(size), Some(kind)) = (word(at), word(at + 4)) else { return Err(refused("a chunk is cut off")) };
        let end = (at + 8).checked_add(size).filter(|&end| end <= length);
        let Some(end) = end else { return Err(refused("a chunk is longer than the file")) };
        if !size.is_multiple_of(4) {
            broken.push("a chunk whose length is no multiple of 4");
        }
        match (&(kind as u32).to_le_bytes(), json, binary) {
            (b"JSON", None, _) => {
                json = Some(&bytes[at + 8..end]);
                broken.extend((number != 0).then_some("a JSON chunk that is not the first"));
            }
            (b"BIN\0", Some(_), None) => {
                binary = Some(&bytes[at + 8..end]);
                broken.extend((number != 1).then_some("a BIN chunk that is not the second"));
            }
            (b"JSON" | b"BIN\0", ..) => return Err(refused("its chunks are not one JSON, then at most one BIN")),
            _ => {}
        }
        at = end;
    }
    let text = json.ok_or_else(|| refused("it has no JSON chunk"))?;
    Ok(Container { text, binary, broken })
}

/// The beginning of a file, and whether it is all of it.
type Beginning = (Rc<Vec<u8>>, bool);

/// The buffers of a document, read when first asked for.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    declared: &'a [Buffer],
    binary: Option<&'a [u8]>,
    folder: &'a Folder,
    loaded: Vec<OnceCell<Bytes<'a>>>,
    /// The beginnings of files by their resolved paths, and whether that is all of them: several buffers may name one.
    files: RefCell<HashMap<PathBuf, Beginning>>,
    /// How many bytes of a file the buffers that name it need at most, by its resolved path.
    needs: OnceCell<HashMap<PathBuf, usize>>,
    /// What is wrong with buffers that were asked for: decoding up to a fault takes its time.
    refused: RefCell<HashMap<usize, String>>,
    /// Rules that are broken without harm.
    broken: RefCell<BTreeSet<String>>,
}

/// The bytes behind a buffer.
#[derive(Clone, Debug)]
enum Bytes<'a> {
    Chunk(&'a [u8]),
    Own(Rc<Vec<u8>>),
}

impl Bytes<'_> {
    fn get(&self) -> &[u8] {
        match self {
            Self::Chunk(bytes) => bytes,
            Self::Own(bytes) => bytes,
        }
    }
}

impl<'a> Buffers<'a> {
    pub(super) fn new(declared: &'a [Buffer], binary: Option<&'a [u8]>, folder: &'a Folder) -> Self {
        let loaded = declared.iter().map(|_| OnceCell::new()).collect();
        let (files, needs, refused, broken) = Default::default();
        Self { declared, binary, folder, loaded, files, needs, refused, broken }
    }

    /// The account of the scene.
    pub(super) fn ledger(&self) -> &Ledger {
        self.folder.ledger()
    }

    /// The declared bytes of a buffer.
    pub(super) fn bytes(&self, index: usize) -> Result<&[u8], LoadProblem> {
        let declared = existing(self.declared, index, "buffer")?;
        let cell = &self.loaded[index];
        let bytes = match cell.get() {
            Some(bytes) => bytes,
            None => {
                let bytes = self.fetch(index, declared)?;
                cell.get_or_init(|| bytes)
            }
        };
        let bytes = bytes.get();
        bytes.get(..declared.byte_length).ok_or_else(|| too_short(index, declared, bytes.len() as u64))
    }

    /// Whether the bytes of a buffer have been read.
    pub(super) fn is_at_hand(&self, index: usize) -> bool {
        self.loaded.get(index).is_some_and(|bytes| bytes.get().is_some())
    }

    /// What is wrong with the buffers that nothing has read, file by file; these are looked up, not opened. And with the binary
    /// chunk, which may be padded to a multiple of four. `stands_for` says which buffers only stand for what is compressed elsewhere:
    /// their bytes may be left out.
    pub(super) fn unused_problems(&self, stands_for: impl Fn(usize) -> bool) -> Vec<LoadProblem> {
        let is_left_out = |index: usize| {
            self.declared[index].is_left_out() || self.declared[index].uri.is_none() && stands_for(index)
        };
        let is_unread = |&index: &usize| self.loaded[index].get().is_none() && !is_left_out(index);
        let unread = (0..self.declared.len()).filter(is_unread);
        let mut problems: Vec<_> = unread.filter_map(|index| self.look_up(index).err()).collect();
        // One without bytes is for nothing, and may be left in.
        if let Some(binary) = self.binary.filter(|binary| !binary.is_empty()) {
            let needed = self.declared.first().filter(|buffer| buffer.uri.is_none()).map(|buffer| buffer.byte_length);
            let fault = match needed {
                None => Some("no buffer is for it: the first one has a URI, or there is none"),
                Some(needed) if binary.len() > needed.saturating_add(3) => {
                    Some("it is longer than the buffer that it is for")
                }
                Some(_) => None,
            };
            problems.extend(fault.map(|fault| LoadProblem::element("binary chunk", fault)));
        }
        problems
    }

    fn look_up(&self, index: usize) -> Result<(), LoadProblem> {
        let declared = &self.declared[index];
        let uri = declared.uri.as_deref().filter(|uri| is_file(uri));
        let Some(uri) = uri else { return self.bytes(index).map(|_| ()) };
        let length = self.length(uri, &format!("buffer {index}"))?;
        if length < declared.byte_length as u64 { Err(too_short(index, declared, length)) } else { Ok(()) }
    }

    /// The bytes of the file that a URI names.
    fn length(&self, uri: &str, place: &str) -> Result<u64, LoadProblem> {
        let file = self.file(uri, place)?;
        match std::fs::metadata(&file.real) {
            Ok(metadata) if metadata.is_file() => Ok(metadata.len()),
            Ok(_) => Err(LoadProblem::element(place, format!("\"{}\" is not a file", excerpt(uri)))),
            Err(source) => Err(LoadProblem::Unreadable { path: file.shown, source }),
        }
    }

    /// Whether something is behind a URI that is no buffer's; its bytes, if the URI itself holds them. What is elsewhere is not looked for.
    pub(super) fn check(&self, uri: &str, place: &str) -> Result<Option<Rc<Vec<u8>>>, LoadProblem> {
        match data_of(uri) {
            Some(_) => self.resource(uri, place, 0).map(Some),
            None if has_scheme(uri) => Ok(None),
            None => self.length(uri, place).map(|_| None),
        }
    }

    /// The file that a URI names; what is odd about the URI is told.
    fn file(&self, uri: &str, place: &str) -> Result<Located, LoadProblem> {
        let (file, is_turned) = self.located(uri, place)?;
        if is_turned {
            self.broken.borrow_mut().insert(format!("{place}: its uri has backslashes, taken as slashes"));
        }
        Ok(file)
    }

    /// The file that a URI names, and whether its backslashes were taken as slashes: so browsers do, and so it is where no file has them in its name.
    fn located(&self, uri: &str, place: &str) -> Result<(Located, bool), LoadProblem> {
        let path = percent_encoding::percent_decode_str(uri).decode_utf8();
        let path = path.map_err(|_| LoadProblem::element(place, "its uri is not UTF-8 once percent-decoded"))?;
        let turned = || {
            let turned = path.contains('\\').then(|| path.replace('\\', "/"))?;
            self.folder.resolve(&turned, place).ok().map(|file| (file, true))
        };
        self.folder.resolve(&path, place).map(|file| (file, false)).or_else(|problem| turned().ok_or(problem))
    }

    fn fetch(&self, index: usize, declared: &Buffer) -> Result<Bytes<'a>, LoadProblem> {
        if let Some(message) = self.refused.borrow().get(&index) {
            return Err(LoadProblem::element(format!("buffer {index}"), message));
        }
        self.fetch_once(index, declared).inspect_err(|problem| {
            if let LoadProblem::Element { message, .. } = problem {
                self.refused.borrow_mut().insert(index, message.clone());
            }
        })
    }

    fn fetch_once(&self, index: usize, declared: &Buffer) -> Result<Bytes<'a>, LoadProblem> {
        let place = format!("buffer {index}");
        let Some(uri) = &declared.uri else {
            return match self.binary {
                Some(binary) if index == 0 => Ok(Bytes::Chunk(binary)),
                _ => Err(LoadProblem::element(place, "it has no uri, and there is no binary chunk for it")),
            };
        };
        self.resource(uri, &place, declared.byte_length).map(Bytes::Own)
    }

    /// The bytes behind a URI, a data URI or a file in the scene's folder: all of them, or `needed` at least.
    pub(super) fn resource(&self, uri: &str, place: &str, needed: usize) -> Result<Rc<Vec<u8>>, LoadProblem> {
        if let Some(data) = data_of(uri) {
            let (bytes, is_exact) = decode_data(data).map_err(|message| LoadProblem::element(place, message))?;
            if !is_exact {
                self.broken.borrow_mut().insert(format!("{place}: its base64 ends with bits that mean nothing"));
            }
            return Ok(Rc::new(bytes));
        }
        if has_scheme(uri) {
            return Err(LoadProblem::element(
                place,
                format!("\"{}\" is not a file; only files and data URIs are read", excerpt(uri)),
            ));
        }
        let file = self.file(uri, place)?;
        let needed = self.needs().get(&file.real).map_or(needed, |&most| most.max(needed));
        let mut files = self.files.borrow_mut();
        if let Some((bytes, _)) = files.get(&file.real).filter(|(bytes, is_whole)| *is_whole || bytes.len() >= needed) {
            return Ok(Rc::clone(bytes));
        }
        let (bytes, is_whole) = self.ledger().read_most(&file, needed)?;
        let bytes = Rc::new(bytes);
        files.insert(file.real, (Rc::clone(&bytes), is_whole));
        Ok(bytes)
    }

    /// Buffers of one file share one reading, so it is as long as the longest of them needs.
    fn needs(&self) -> &HashMap<PathBuf, usize> {
        self.needs.get_or_init(|| {
            let mut of_uri: HashMap<&str, usize> = HashMap::new();
            for buffer in self.declared {
                if let Some(uri) = buffer.uri.as_deref().filter(|uri| is_file(uri)) {
                    let most = of_uri.entry(uri).or_default();
                    *most = buffer.byte_length.max(*most);
                }
            }
            let mut needs = HashMap::new();
            for (uri, length) in of_uri {
                // What does not lead to a file is told where it is asked for.
                if let Ok((file, _)) = self.located(uri, "") {
                    let most: &mut usize = needs.entry(file.real).or_default();
                    *most = length.max(*most);
                }
            }
            needs
        })
    }

    /// Rules that were found broken without harm, with their places.
    pub(super) fn broken_rules(&self) -> BTreeSet<String> {
        self.broken.take()
    }
}

fn too_short(index: usize, declared: &Buffer, there: u64) -> LoadProblem {
    let message = format!("it should have {} bytes, but {there} are there", declared.byte_length);
    LoadProblem::element(format!("buffer {index}"), message)
}

/// What follows the `data:` of a data URI; schemes are written in letters of either size.
fn data_of(uri: &str) -> Option<&str> {
    let (scheme, data) = uri.split_at_checked(5)?;
    scheme.eq_ignore_ascii_case("data:").then_some(data)
}

/// Whether a URI names a file.
fn is_file(uri: &str) -> bool {
    data_of(uri).is_none() && !has_scheme(uri)
}

/// Whether a URI begins with a scheme (`http:`); one letter is a drive, so a path.
fn has_scheme(uri: &str) -> bool {
    let is_scheme = |scheme: &str| {
        scheme.len() > 1
            && scheme.starts_with(|first: char| first.is_ascii_alphabetic())
            && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    };
    uri.split_once(':').is_some_and(|(scheme, _)| is_scheme(scheme))
}

/// The media type of a data URI, and its first bytes: a score of them at least, where it has so many.
pub(super) fn head_of_data(uri: &str) -> Option<(&str, Vec<u8>)> {
    let (kind, content) = data_of(uri)?.split_once(',')?;
    let head = content.get(..HEAD).unwrap_or(content);
    let (bytes, _) = decode_data(&format!("{kind},{head}")).ok()?;
    Some((media_type(uri)?, bytes))
}

/// The media type of a data URI, which may be empty.
pub(super) fn media_type(uri: &str) -> Option<&str> {
    let (kind, _) = data_of(uri)?.split_once(',')?;
    kind.split(';').next().map(str::trim)
}

/// Characters of a data URI that hold its first bytes: whole groups of base64, or bytes of which each takes three.
const HEAD: usize = 60;

/// The bytes of a data URI, after `data:`, and whether these are all that it says: bits that fill no byte are left out, as browsers do.
fn decode_data(data: &str) -> Result<(Vec<u8>, bool), String> {
    let (kind, content) = data.split_once(',').ok_or("its data URI has no comma")?;
    let mut bytes: Vec<u8> = percent_encoding::percent_decode_str(content).collect();
    if !kind.rsplit_once(';').is_some_and(|(_, last)| last.trim().eq_ignore_ascii_case("base64")) {
        return Ok((bytes, true));
    }
    bytes.retain(|byte| !byte.is_ascii_whitespace());
    let exact = base64::engine::GeneralPurposeConfig::new()
        .with_decode_padding_mode(base64::engine::DecodePaddingMode::Indifferent);
    let decode = |config| base64::engine::GeneralPurpose::new(&base64::alphabet::STANDARD, config).decode(&bytes);
    match decode(exact) {
        Ok(decoded) => Ok((decoded, true)),
        Err(base64::DecodeError::InvalidLastSymbol(..)) => {
            decode(exact.with_decode_allow_trailing_bits(true)).map(|decoded| (decoded, false))
        }
        Err(fault) => Err(fault),
    }
    .map_err(|fault| format!("its data URI is not base64: {fault}"))
}
