//! Buffer views: ranges of buffers, decompressed where EXT_meshopt_compression or KHR_meshopt_compression says so.

use std::{
    borrow::Cow,
    cell::OnceCell,
    collections::{BTreeSet, HashSet},
    rc::Rc,
};

use super::{
    container::Buffers,
    json::{BufferView, MeshoptView, existing},
    meshopt,
};
use crate::{error::LoadProblem, ledger::Ledger};

/// Decompressed bytes that count as one element of an accessor: the largest element of plain vertices, four floats.
pub(super) const ELEMENT: usize = 16;

/// The buffer views of a document; a compressed one is decompressed when first asked for.
#[derive(Debug)]
pub(super) struct Views<'a> {
    declared: &'a [BufferView],
    buffers: Buffers<'a>,
    decompressed: Vec<OnceCell<Vec<u8>>>,
}

impl<'a> Views<'a> {
    pub(super) fn new(declared: &'a [BufferView], buffers: Buffers<'a>) -> Self {
        let decompressed = declared.iter().map(|_| OnceCell::new()).collect();
        Self { declared, buffers, decompressed }
    }

    /// The account of the scene.
    pub(super) fn ledger(&self) -> &Ledger {
        self.buffers.ledger()
    }

    /// See [`Buffers::unused_problems`].
    pub(super) fn unused_problems(&self) -> Vec<LoadProblem> {
        let (mut compressed, mut used) = (HashSet::new(), HashSet::new());
        for view in self.declared {
            match compression(view) {
                Some((_, stream)) => {
                    compressed.insert(view.buffer);
                    used.insert(stream.buffer);
                }
                None => _ = used.insert(view.buffer),
            }
        }
        self.buffers.unused_problems(|index| compressed.contains(&index) && !used.contains(&index))
    }

    /// See [`Buffers::broken_rules`].
    pub(super) fn broken_rules(&self) -> BTreeSet<String> {
        self.buffers.broken_rules()
    }

    /// The bytes behind a URI that is no buffer's, all of them.
    pub(super) fn resource(&self, uri: &str, place: &str) -> Result<Rc<Vec<u8>>, LoadProblem> {
        self.buffers.resource(uri, place, usize::MAX)
    }

    /// See [`Buffers::check`].
    pub(super) fn check(&self, uri: &str, place: &str) -> Result<Option<Rc<Vec<u8>>>, LoadProblem> {
        self.buffers.check(uri, place)
    }

    /// The declared view and its bytes.
    pub(super) fn get(&self, index: usize) -> Result<(&'a BufferView, &[u8]), LoadProblem> {
        let declared = existing(self.declared, index, "buffer view")?;
        let place = format!("buffer view {index}");
        let Some((extension, compressed)) = compression(declared) else {
            let bytes = self.range(&place, declared.buffer, declared.byte_offset, declared.byte_length)?;
            return Ok((declared, bytes));
        };
        let cell = &self.decompressed[index];
        let bytes = match cell.get() {
            Some(bytes) => bytes,
            None => {
                let bytes = self.decompress(&format!("{place}, {extension}"), declared, compressed)?;
                cell.get_or_init(|| bytes)
            }
        };
        Ok((declared, bytes))
    }

    /// Whether a view is compressed and nobody has asked for it.
    pub(super) fn is_compressed(&self, index: usize) -> bool {
        compression(&self.declared[index]).is_some() && self.decompressed[index].get().is_none()
    }

    /// Whether the bytes of a view are there without reading a file or decompressing a stream.
    pub(super) fn is_at_hand(&self, index: usize) -> bool {
        let declared = &self.declared[index];
        let is_plain = compression(declared).is_none() && self.buffers.is_at_hand(declared.buffer);
        is_plain || self.decompressed[index].get().is_some()
    }

    /// The bytes of a view, if its buffer has been read. They are not kept: what they would cost decompressed is taken from `left`, and
    /// where that is too little they are not looked at.
    pub(super) fn at_hand(&self, index: usize, left: &mut u64) -> Option<Result<Cow<'_, [u8]>, LoadProblem>> {
        let declared = &self.declared[index];
        match compression(declared).filter(|_| self.is_compressed(index)) {
            None => self.is_at_hand(index).then(|| self.get(index).map(|(_, bytes)| bytes.into())),
            Some((extension, view)) => {
                let rest = left.checked_sub(declared.byte_length.div_ceil(ELEMENT) as u64);
                *left = rest.filter(|_| self.buffers.is_at_hand(view.buffer))?;
                Some(
                    self.decode(&format!("buffer view {index}, {extension}"), declared, view, || Ok(()))
                        .map(Cow::Owned),
                )
            }
        }
    }

    fn decompress(&self, place: &str, declared: &BufferView, view: &MeshoptView) -> Result<Vec<u8>, LoadProblem> {
        self.decode(place, declared, view, || self.ledger().decode(declared.byte_length.div_ceil(ELEMENT)))
    }

    /// Decodes a compressed view; `account` is asked before anything is allocated.
    fn decode(
        &self,
        place: &str,
        declared: &BufferView,
        view: &MeshoptView,
        account: impl Fn() -> Result<(), LoadProblem>,
    ) -> Result<Vec<u8>, LoadProblem> {
        let refused = |message: String| LoadProblem::element(place, message);
        let length = view.count.checked_mul(view.byte_stride).filter(|&length| length == declared.byte_length);
        length.ok_or_else(|| {
            let (count, stride, length) = (view.count, view.byte_stride, declared.byte_length);
            refused(format!("{count} elements of {stride} bytes are not the {length} bytes of its view"))
        })?;
        let stream = self.range(place, view.buffer, view.byte_offset, view.byte_length)?;
        account()?;
        meshopt::decode(stream, view).map_err(refused)
    }

    /// Bytes of a buffer.
    fn range(&self, place: &str, buffer: usize, offset: usize, length: usize) -> Result<&[u8], LoadProblem> {
        let bytes = self.buffers.bytes(buffer)?;
        let range = offset.checked_add(length).and_then(|end| bytes.get(offset..end));
        range.ok_or_else(|| {
            let has = bytes.len();
            let message = format!("its {length} bytes from byte {offset} on leave buffer {buffer}, which has {has}");
            LoadProblem::element(place, message)
        })
    }
}

/// How a view is compressed, with the extension that says so.
pub(super) fn compression(view: &BufferView) -> Option<(&'static str, &MeshoptView)> {
    let extensions = &view.extensions;
    let ext = extensions.ext_meshopt.as_ref().map(|view| ("EXT_meshopt_compression", view));
    extensions.khr_meshopt.as_ref().map(|view| ("KHR_meshopt_compression", view)).or(ext)
}
