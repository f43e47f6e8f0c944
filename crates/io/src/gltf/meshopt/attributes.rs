//! Mode 0, attributes: every byte of an element is a difference from the element before, stored apart from the other
//! bytes, in groups of 16 elements with as few bits as the group needs.

use super::{Reader, unzigzag};

/// Elements that share one width.
const GROUP: usize = 16;
/// The header of a stream of version 1; version 0 is one less.
const VERSION_1: u8 = 0xa1;

/// How the four bytes of a channel follow from those of the element before.
#[derive(Clone, Copy)]
enum Channel {
    Bytes,
    Words,
    /// Exclusive or, turned left by so many bits when it was written.
    Xor(u32),
}

/// The elements of a stream, one after another. `count * stride` must not overflow.
pub(super) fn decode(stream: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    let is_new = stream.first() == Some(&VERSION_1);
    let modes = if is_new { stride / 4 } else { 0 };
    let padded = (stride + modes).max(if is_new { 24 } else { 32 });
    let (_, mut reader, tail) = Reader::open(stream, &[VERSION_1 - 1, VERSION_1], padded)?;
    let (baseline, modes) = tail[padded - stride - modes..].split_at(stride);
    let channels = channels(modes, stride)?;
    let mut element = baseline.to_vec();
    let (mut elements, mut codes) = (Vec::new(), Vec::new());
    while elements.len() < count * stride {
        let block = (count - elements.len() / stride).min(((8192 / stride) & !(GROUP - 1)).min(256));
        let height = read_block(&mut reader, block, stride, is_new, &mut codes)?;
        let start = elements.len();
        elements.resize(start + block * stride, 0);
        let steps = codes.chunks_exact(4 * height);
        for ((channel, four), (number, steps)) in
            channels.iter().zip(element.chunks_exact_mut(4)).zip(steps.enumerate())
        {
            let mut value = [four[0], four[1], four[2], four[3]];
            for (row, target) in elements[start..].chunks_exact_mut(stride).enumerate() {
                value = channel.next(value, std::array::from_fn(|byte| steps[byte * height + row]));
                target[4 * number..4 * number + 4].copy_from_slice(&value);
            }
            four.copy_from_slice(&value);
        }
    }
    reader.close()?;
    Ok(elements)
}

fn channels(modes: &[u8], stride: usize) -> Result<Vec<Channel>, String> {
    let channel = |&mode: &u8| match (mode & 15, mode >> 4) {
        (0, 0) => Ok(Channel::Bytes),
        (1, 0) => Ok(Channel::Words),
        (2, turn) => Ok(Channel::Xor(u32::from(turn))),
        _ => Err(format!("its stream has a channel of mode {mode:#04x}, which there is not")),
    };
    if modes.is_empty() { Ok(vec![Channel::Bytes; stride / 4]) } else { modes.iter().map(channel).collect() }
}

impl Channel {
    /// The bytes of an element, from those of the element before.
    fn next(self, bytes: [u8; 4], step: [u8; 4]) -> [u8; 4] {
        match self {
            Self::Bytes => std::array::from_fn(|i| bytes[i].wrapping_add(unzigzag(step[i].into()) as u8)),
            Self::Words => {
                let word = |four: [u8; 4], i: usize| u16::from_le_bytes([four[2 * i], four[2 * i + 1]]);
                let next = |i: usize| word(bytes, i).wrapping_add(unzigzag(word(step, i).into()) as u16).to_le_bytes();
                let ([a, b], [c, d]) = (next(0), next(1));
                [a, b, c, d]
            }
            Self::Xor(turn) => (u32::from_le_bytes(bytes) ^ u32::from_le_bytes(step).rotate_right(turn)).to_le_bytes(),
        }
    }
}

/// Reads a block of `count` elements: for each byte of an element a column with the codes of its steps. Returns the
/// height of the columns, `count` rounded up to whole groups.
fn read_block(
    reader: &mut Reader,
    count: usize,
    stride: usize,
    is_new: bool,
    codes: &mut Vec<u8>,
) -> Result<usize, String> {
    let height = count.next_multiple_of(GROUP);
    let controls = reader.take(if is_new { stride / 4 } else { 0 })?;
    codes.clear();
    for byte in 0..stride {
        match controls.get(byte / 4).map(|control| control >> (byte % 4 * 2) & 3) {
            None => read_column(reader, height, [0, 2, 4, 8], codes)?,
            Some(0) => read_column(reader, height, [0, 1, 2, 4], codes)?,
            Some(1) => read_column(reader, height, [1, 2, 4, 8], codes)?,
            Some(2) => {}
            Some(_) => codes.extend(reader.take(count)?),
        }
        codes.resize(height * (byte + 1), 0);
    }
    Ok(height)
}

/// The codes of one byte over a block: two bits for each group say which of the widths it has.
fn read_column(reader: &mut Reader, height: usize, widths: [usize; 4], codes: &mut Vec<u8>) -> Result<(), String> {
    let groups = height / GROUP;
    let headers = reader.take(groups.div_ceil(4))?;
    (0..groups).try_for_each(|group| {
        let width = widths[usize::from(headers[group / 4] >> (group % 4 * 2) & 3)];
        read_group(reader, width, codes)
    })
}

/// Sixteen codes of `width` bits; one with all bits set stands for a whole byte that follows.
fn read_group(reader: &mut Reader, width: usize, codes: &mut Vec<u8>) -> Result<(), String> {
    if width == 0 {
        codes.extend([0; GROUP]);
        return Ok(());
    }
    let packed = reader.take(GROUP * width / 8)?;
    if width == 8 {
        codes.extend(packed);
        return Ok(());
    }
    let (per_byte, sentinel) = (8 / width, (1 << width) - 1);
    for i in 0..GROUP {
        let place = i % per_byte;
        // Single bits begin at the least significant end, wider codes at the most significant.
        let shift = if width == 1 { place } else { 8 - width * (place + 1) };
        let code = packed[i / per_byte] >> shift & sentinel;
        codes.push(if code == sentinel { reader.byte()? } else { code });
    }
    Ok(())
}
