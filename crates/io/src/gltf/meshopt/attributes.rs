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
    let (mut element, mut step) = (baseline.to_vec(), vec![0; stride]);
    let (mut elements, mut codes) = (Vec::new(), Vec::new());
    while elements.len() < count * stride {
        let block = (count - elements.len() / stride).min(((8192 / stride) & !(GROUP - 1)).min(256));
        let height = read_block(&mut reader, block, stride, is_new, &mut codes)?;
        for row in 0..block {
            step.iter_mut().zip(codes[row..].iter().step_by(height)).for_each(|(step, &code)| *step = code);
            for ((channel, four), step) in channels.iter().zip(element.chunks_exact_mut(4)).zip(step.chunks_exact(4)) {
                channel.advance(four, step);
            }
            elements.extend_from_slice(&element);
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
    fn advance(self, previous: &mut [u8], step: &[u8]) {
        match self {
            Self::Bytes => {
                previous.iter_mut().zip(step).for_each(|(p, &s)| *p = p.wrapping_add(unzigzag(s.into()) as u8));
            }
            Self::Words => {
                for (p, s) in previous.chunks_exact_mut(2).zip(step.chunks_exact(2)) {
                    let change = unzigzag(u16::from_le_bytes([s[0], s[1]]).into()) as u16;
                    p.copy_from_slice(&u16::from_le_bytes([p[0], p[1]]).wrapping_add(change).to_le_bytes());
                }
            }
            Self::Xor(turn) => {
                let word = |b: &[u8]| u32::from_le_bytes([b[0], b[1], b[2], b[3]]);
                let changed = word(previous) ^ word(step).rotate_right(turn);
                previous.copy_from_slice(&changed.to_le_bytes());
            }
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
