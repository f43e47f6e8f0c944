//! Buffer views: ranges of buffers, decompressed where EXT_meshopt_compression or KHR_meshopt_compression says so.

use std::{cell::OnceCell, rc::Rc};

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
        self.buffers.unused_problems()
    }

    /// The bytes behind a URI that is no buffer's, all of them.
    pub(super) fn resource(&self, uri: &str, place: &str) -> Result<Rc<Vec<u8>>, LoadProblem> {
        self.buffers.resource(uri, place, usize::MAX)
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

    fn decompress(&self, place: &str, declared: &BufferView, view: &MeshoptView) -> Result<Vec<u8>, LoadProblem> {
        let refused = |message: String| LoadProblem::element(place, message);
        let length = view.count.checked_mul(view.byte_stride).filter(|&length| length == declared.byte_length);
        let length = length.ok_or_else(|| {
            let (count, stride, length) = (view.count, view.byte_stride, declared.byte_length);
            refused(format!("{count} elements of {stride} bytes are not the {length} bytes of its view"))
        })?;
        let stream = self.range(place, view.buffer, view.byte_offset, view.byte_length)?;
        self.ledger().decode(length.div_ceil(ELEMENT))?;
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
