//! Buffer views compressed by EXT_meshopt_compression or KHR_meshopt_compression: the three bit streams and the filters
//! of their specifications (Kapoulkine, St. Pierre et al., Khronos Group, appendices A and B).
//!
//! Both extensions share one format; version 1 of the attribute stream and the colour filter came with the second, and
//! are read in either. A stream says nothing about its own length, so its view does, and a stream that ends early, leaves
//! bytes over or asks for a vertex that was not there yet is refused. Output grows only as input is consumed, and
//! indices, which cost a byte each at least (a triangle one byte), are bounded by the stream before any memory is taken.
//!
//! Time is linear in the output. Attributes shrink to 1/1024 at best, so the caller bounds their number.

mod attributes;
mod filters;
mod indices;

use super::json::{MeshoptFilter, MeshoptMode, MeshoptView};

/// Most bytes of an element.
const LARGEST_ELEMENT: usize = 256;

/// The bytes behind a compressed view: `count` elements of `byte_stride` bytes each.
pub(super) fn decode(stream: &[u8], view: &MeshoptView) -> Result<Vec<u8>, String> {
    check(view)?;
    let (count, stride) = (view.count, view.byte_stride);
    match view.mode {
        MeshoptMode::Attributes => {
            let mut elements = attributes::decode(stream, count, stride)?;
            filters::apply(view.filter, stride, &mut elements);
            Ok(elements)
        }
        MeshoptMode::Triangles => Ok(packed(&indices::triangles(stream, count)?, stride)),
        MeshoptMode::Indices => Ok(packed(&indices::sequence(stream, count)?, stride)),
    }
}

/// What the specification demands of a view before its bytes are looked at.
fn check(view: &MeshoptView) -> Result<(), String> {
    let stride = view.byte_stride;
    let fits = match (view.mode, view.filter) {
        (MeshoptMode::Attributes, MeshoptFilter::None | MeshoptFilter::Exponential) => {
            stride.is_multiple_of(4) && (4..=LARGEST_ELEMENT).contains(&stride)
        }
        (MeshoptMode::Attributes, MeshoptFilter::Octahedral | MeshoptFilter::Color) => stride == 4 || stride == 8,
        (MeshoptMode::Attributes, MeshoptFilter::Quaternion) => stride == 8,
        (_, MeshoptFilter::None) => stride == 2 || stride == 4,
        (_, filter) => return Err(format!("indices have no filter, but it says {filter:?}")),
    };
    if !fits {
        return Err(format!("its stride of {stride} bytes does not suit its mode and filter"));
    }
    if view.mode == MeshoptMode::Triangles && !view.count.is_multiple_of(3) {
        return Err(format!("its {} indices are no whole number of triangles", view.count));
    }
    Ok(())
}

/// Indices as bytes; two bytes keep the low half, as the specification says.
fn packed(indices: &[u32], stride: usize) -> Vec<u8> {
    indices.iter().flat_map(|index| index.to_le_bytes().into_iter().take(stride)).collect()
}

/// A stream that is consumed from its beginning.
struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    /// The stream without its first byte, which says the format, and without the last `tail` bytes, which come apart.
    fn open(stream: &'a [u8], headers: &[u8], tail: usize) -> Result<(u8, Self, &'a [u8]), String> {
        let (&header, rest) = stream.split_first().ok_or("its stream is empty")?;
        if !headers.contains(&header) {
            return Err(format!("its stream begins with {header:#04x}, which is not the header of its mode"));
        }
        let end = rest.len().checked_sub(tail).ok_or_else(ended)?;
        let (bytes, tail) = rest.split_at(end);
        Ok((header, Self { bytes }, tail))
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.bytes.split_at_checked(count).ok_or_else(ended)?;
        self.bytes = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, String> {
        self.take(1).map(|taken| taken[0])
    }

    /// Unsigned LEB128, one to five bytes; bits beyond 32 are ignored.
    fn varint(&mut self) -> Result<u32, String> {
        let mut value = 0_u32;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err("a number in its stream has more than five bytes".to_owned())
    }

    fn close(self) -> Result<(), String> {
        match self.bytes.len() {
            0 => Ok(()),
            left => Err(format!("its stream has {left} bytes too many")),
        }
    }
}

fn ended() -> String {
    "its stream ends too early".to_owned()
}

/// A signed difference from its zigzag code: 0, −1, 1, −2, ...
fn unzigzag(code: u32) -> u32 {
    if code & 1 == 0 { code >> 1 } else { !(code >> 1) }
}

#[cfg(test)]
mod tests;
