//! Pictures in: the alpha of a PNG, and nothing else of it.
//!
//! Dimensions are read first and entered into the account of the scene; a picture without alpha is decoded only to see whether
//! it is whole, and not where that is too much. Time is linear in its texels, memory some ten bytes each while it is decoded, and four after.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, DecodingError, Info, Limits, Transformations};
use umbriel_geometry::cut_out::AlphaMap;

use crate::{error::excerpt, ledger::Ledger};

/// Alphas of 8 bits times this are alphas of 16 bits.
const WIDEN: u16 = 257;

/// The alpha of a picture; `None` for one that is opaque because its kind has none. The message says why a picture is not read.
pub(crate) fn alpha(bytes: &[u8], ledger: &Ledger) -> Result<Option<AlphaMap>, String> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => png_alpha(bytes, ledger),
        // JPEG has no alpha; but one that is cut off is no picture.
        [0xff, 0xd8, 0xff, ..] if is_jpeg(bytes) => Ok(None),
        [0xff, 0xd8, 0xff, ..] => Err("its JPEG is broken".to_owned()),
        _ => Err("it is neither PNG nor JPEG".to_owned()),
    }
}

/// What is wrong with a PNG or JPEG as far as that is seen without decoding it: that it is cut off, or has no size. Others are not looked at.
pub(crate) fn fault(bytes: &[u8]) -> Option<&'static str> {
    let (is_broken, fault) = match bytes {
        [0x89, b'P', b'N', b'G', ..] => (!has_png_chunks(bytes), "its PNG is cut off or broken"),
        [0xff, 0xd8, 0xff, ..] => (!is_jpeg(bytes), "its JPEG is cut off or broken"),
        _ => return None,
    };
    is_broken.then_some(fault)
}

/// Whether the chunks of a PNG (3rd edition, 5) follow each other from a header with a size to the end, with pixels among them.
fn has_png_chunks(bytes: &[u8]) -> bool {
    let Some(mut rest) = bytes.strip_prefix(b"\x89PNG\r\n\x1a\n") else { return false };
    let (mut has_size, mut has_pixels) = (false, false);
    while let Some((length, named)) = rest.split_first_chunk::<4>() {
        let length = u32::from_be_bytes(*length) as usize;
        // The name, the content, and a checksum.
        let Some((chunk, behind)) = length.checked_add(8).and_then(|length| named.split_at_checked(length)) else {
            return false;
        };
        match &chunk[..4] {
            b"IHDR" => has_size = length == 13 && chunk[4..8] != [0; 4] && chunk[8..12] != [0; 4],
            b"IDAT" => has_pixels = true,
            b"IEND" => return has_pixels,
            _ => {}
        }
        if !has_size {
            return false;
        }
        rest = behind;
    }
    false
}

/// Whether the segments of a JPEG (ITU-T T.81, annex B) follow each other up to its lines of pixels, with a size among them, and it has
/// an end.
fn is_jpeg(bytes: &[u8]) -> bool {
    let (mut rest, mut has_size) = (&bytes[2..], false);
    while let &[0xff, kind, ref behind @ ..] = rest {
        if kind == 0xff {
            rest = &rest[1..];
            continue;
        }
        let Some(length) = behind.first_chunk::<2>().map(|&two| usize::from(u16::from_be_bytes(two))) else {
            return false;
        };
        let Some(segment) = behind.get(2..length) else { return false };
        match kind {
            // Frames, but not the tables among their numbers.
            0xc0..=0xcf if !matches!(kind, 0xc4 | 0xc8 | 0xcc) => {
                has_size = segment.get(1..5).is_some_and(|size| size[..2] != [0, 0] && size[2..] != [0, 0]);
            }
            0xda => return has_size && behind[length..].windows(2).rev().any(|pair| pair == [0xff, 0xd9]),
            _ => {}
        }
        rest = &behind[length..];
    }
    false
}

fn png_alpha(bytes: &[u8], ledger: &Ledger) -> Result<Option<AlphaMap>, String> {
    let unread = |fault: DecodingError| format!("its PNG is not read: {}", excerpt(&fault.to_string()));
    // What the pixels may take is for the ledger to say; what else may be in the file is not unpacked.
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: usize::MAX });
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_ignore_text_chunk(true);
    let is_indexed = decoder.read_header_info().map_err(unread)?.color_type == ColorType::Indexed;
    // Colours of a palette are looked up here: the decoder takes those that it lacks for black.
    decoder.set_transformations(if is_indexed { Transformations::IDENTITY } else { Transformations::EXPAND });
    let mut reader = decoder.read_info().map_err(unread)?;
    let (size, kind) = (<[u32; 2]>::from(reader.info().size()), reader.output_color_type());
    let has_alpha = matches!(kind.0, ColorType::GrayscaleAlpha | ColorType::Rgba) || reader.info().trns.is_some();
    let texels = u64::from(size[0]) * u64::from(size[1]);
    if has_alpha {
        ledger.picture(texels).map_err(|problem| problem.to_string())?;
    } else if !ledger.may_look_at(texels) {
        return Ok(None);
    }
    let rows = if is_indexed { Rows::of_palette(reader.info()) } else { Rows::of_pixels(kind, has_alpha) };
    let mut texels = Vec::with_capacity(if has_alpha { texels as usize } else { 0 });
    if reader.info().interlaced {
        let mut content = vec![0; reader.output_buffer_size().ok_or("it is too large")?];
        let line = reader.next_frame(&mut content).map_err(unread)?.line_size;
        content.chunks_exact(line).try_for_each(|row| rows.read(row, &mut texels))?;
    } else {
        while let Some(row) = reader.next_row().map_err(unread)? {
            rows.read(row.data(), &mut texels)?;
        }
    }
    if has_alpha { AlphaMap::new(size, texels).map(Some).map_err(|defect| defect.to_string()) } else { Ok(None) }
}

/// How a row of pixels has alphas.
enum Rows {
    /// As packed numbers of a palette's colours (PNG, 3rd edition, 7.2 and 11.3.1): bits of a number, pixels of a row, colours, and the alphas of the first ones, if
    /// any has one; others are opaque.
    Palette { bits: usize, width: usize, colors: usize, alphas: Option<Vec<u8>> },
    /// In the last of so many channels.
    Bytes { channels: usize },
    /// The same with channels of two bytes.
    Words { channels: usize },
    /// Not at all.
    Opaque,
}

impl Rows {
    fn of_palette(info: &Info) -> Self {
        let colors = info.palette.as_ref().map_or(0, |palette| palette.len() / 3);
        let alphas = info.trns.as_ref().map(|alphas| alphas.to_vec());
        Self::Palette { bits: info.bit_depth as usize, width: info.width as usize, colors, alphas }
    }

    fn of_pixels((color, depth): (ColorType, BitDepth), has_alpha: bool) -> Self {
        let channels = color.samples();
        match depth {
            _ if !has_alpha => Self::Opaque,
            BitDepth::Sixteen => Self::Words { channels },
            _ => Self::Bytes { channels },
        }
    }

    /// Adds the alphas of a row.
    fn read(&self, row: &[u8], texels: &mut Vec<u16>) -> Result<(), String> {
        match self {
            Self::Opaque => {}
            Self::Bytes { channels } => {
                texels.extend(row.chunks_exact(*channels).map(|pixel| u16::from(pixel[channels - 1]) * WIDEN));
            }
            Self::Words { channels } => {
                let alpha = |pixel: &[u8]| pixel.last_chunk().map_or(u16::MAX, |&last| u16::from_be_bytes(last));
                texels.extend(row.chunks_exact(2 * channels).map(alpha));
            }
            Self::Palette { bits, width, colors, alphas } => {
                let number = |column: usize| {
                    let byte = usize::from(row[column * bits / 8]);
                    byte >> (8 - bits - column * bits % 8) & ((1 << bits) - 1)
                };
                for color in (0..*width).map(number) {
                    if color >= *colors {
                        return Err(format!("it has {colors} colours, and none of number {color}"));
                    }
                    let alpha =
                        |alphas: &Vec<u8>| alphas.get(color).map_or(u16::MAX, |&alpha| u16::from(alpha) * WIDEN);
                    texels.extend(alphas.as_ref().map(alpha));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

    use super::*;

    fn png(pixels: &[u8], size: [u32; 2], color: ExtendedColorType) -> Vec<u8> {
        let mut bytes = Vec::new();
        PngEncoder::new(&mut bytes).write_image(pixels, size[0], size[1], color).expect("a picture");
        bytes
    }

    fn read(bytes: &[u8]) -> Result<Option<AlphaMap>, String> {
        alpha(bytes, &Ledger::default())
    }

    #[test]
    fn alphas_of_all_depths_are_read() {
        let map = |texels: &[u16]| Ok(AlphaMap::new([2, 1], texels.to_vec()).ok());
        assert_eq!(read(&png(&[9, 9, 9, 0, 9, 9, 9, 255], [2, 1], ExtendedColorType::Rgba8)), map(&[0, 65535]));
        assert_eq!(read(&png(&[9, 1, 9, 128], [2, 1], ExtendedColorType::La8)), map(&[257, 128 * 257]));
        let wide: Vec<u8> = [9u16, 9, 9, 12345, 9, 9, 9, 54321].iter().flat_map(|value| value.to_ne_bytes()).collect();
        assert_eq!(read(&png(&wide, [2, 1], ExtendedColorType::Rgba16)), map(&[12345, 54321]));
        assert_eq!(read(&png(&[1, 2, 3], [1, 1], ExtendedColorType::Rgb8)), Ok(None), "no alpha");
        assert_eq!(read(&jpeg()), Ok(None), "JPEG has no alpha");
    }

    /// As short as one can be: a frame of one pixel, a scan, two bytes of data, the end.
    pub(crate) fn jpeg() -> Vec<u8> {
        let frame = [0xff, 0xc0, 0, 11, 8, 0, 1, 0, 1, 1, 1, 0x11, 0];
        let scan = [0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0, 0x12, 0x34];
        [&[0xff, 0xd8][..], &frame, &scan, &[0xff, 0xd9]].concat()
    }

    #[test]
    fn a_jpeg_that_is_cut_off_is_told() {
        let whole = jpeg();
        assert!((3..whole.len()).all(|length| read(&whole[..length]).is_err()));
        let mut flat = whole;
        flat[8] = 0;
        assert!(read(&flat).is_err(), "no line of pixels");
    }

    #[test]
    fn broken_pictures_are_told_and_large_ones_not_decoded() {
        let whole = png(&[7; 400], [10, 10], ExtendedColorType::Rgba8);
        assert!((0..whole.len() - 20).all(|length| read(&whole[..length]).is_err()));
        // The header claims 2^30 by 2^30 texels.
        let mut huge = whole;
        huge[16..24].copy_from_slice(&[0x40, 0, 0, 0, 0x40, 0, 0, 0]);
        assert!(read(&huge).is_err());
        assert_eq!(read(b"RIFF....WEBP"), Err("it is neither PNG nor JPEG".to_owned()));
    }

    #[test]
    fn broken_pictures_without_alpha_are_told() {
        for (color, channels) in [(ExtendedColorType::L8, 1), (ExtendedColorType::Rgb8, 3)] {
            let whole = png(&vec![7; 100 * channels], [10, 10], color);
            assert_eq!(read(&whole), Ok(None));
            assert!((0..whole.len() - 20).all(|length| read(&whole[..length]).is_err()), "{color:?}");
            let mut spoiled = whole;
            let at = spoiled.windows(4).position(|name| name == b"IDAT").expect("a chunk");
            spoiled[at + 6] ^= 0xff;
            assert!(read(&spoiled).is_err(), "{color:?}");
        }
    }

    /// A picture of one colour in a palette, or without one.
    fn indexed(palette: Option<Vec<u8>>) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_palette(palette.clone().unwrap_or_else(|| vec![9; 3]));
        let mut writer = encoder.write_header().expect("a header");
        writer.write_image_data(&[0, 0]).expect("a picture");
        writer.finish().expect("an end");
        if palette.is_none() {
            let at = bytes.windows(4).position(|name| name == b"PLTE").expect("a chunk");
            // Length, name, colour and checksum.
            bytes.drain(at - 4..at + 11);
        }
        bytes
    }

    #[test]
    fn faults_are_seen_without_decoding() {
        let whole = png(&[7; 400], [10, 10], ExtendedColorType::Rgba8);
        assert_eq!([fault(&whole), fault(&[&whole[..], b"more"].concat()), fault(b"RIFF....WEBP")], [None; 3]);
        assert!((4..whole.len()).all(|length| fault(&whole[..length]).is_some()));
        let mut flat = whole.clone();
        flat[20..24].fill(0);
        assert!(fault(&flat).is_some());
        // Header and end, and no pixels between them.
        let empty = [&whole[..33], &whole[whole.len() - 12..]].concat();
        assert!(fault(&empty).is_some());
        assert_eq!((fault(&jpeg()), fault(&jpeg()[..20]).is_some()), (None, true));
    }

    #[test]
    fn a_palette_that_is_missing_is_told() {
        assert_eq!(read(&indexed(Some(vec![9; 3]))), Ok(None));
        assert!(read(&indexed(None)).is_err());
    }

    /// Four pixels to a byte and five in a row, the last byte of a row three pixels empty: numbers of these bits.
    fn packed(rows: [[u8; 2]; 2], colors: usize, alphas: Option<Vec<u8>>) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 5, 2);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Two);
        encoder.set_palette(vec![9; 3 * colors]);
        alphas.into_iter().for_each(|alphas| encoder.set_trns(alphas));
        let mut writer = encoder.write_header().expect("a header");
        writer.write_image_data(rows.as_flattened()).expect("a picture");
        writer.finish().expect("an end");
        bytes
    }

    #[test]
    fn colours_of_a_palette_have_alphas_and_others_are_told() {
        let rows = [[0b00_01_10_00, 0b10_11_11_11], [0b10_10_10_01, 0b00_11_00_01]];
        let texels = [0, 7, 255, 0, 255, 255, 255, 255, 7, 0].map(|alpha: u16| alpha * WIDEN);
        let expected = AlphaMap::new([5, 2], texels.to_vec()).ok();
        assert_eq!(read(&packed(rows, 3, Some(vec![0, 7]))), Ok(expected), "the third has no alpha of its own");
        assert_eq!(read(&packed(rows, 3, None)), Ok(None));
        for alphas in [None, Some(vec![0, 7])] {
            let told = read(&packed(rows, 2, alphas));
            assert_eq!(told, Err("it has 2 colours, and none of number 2".to_owned()));
        }
    }

    #[test]
    fn pictures_without_alpha_may_be_too_large_to_look_at() {
        let mut huge = png(&[7; 300], [10, 10], ExtendedColorType::Rgb8);
        // 2^14 by 2^14 texels; the checksum of the header with them.
        huge[16..24].copy_from_slice(&[0, 0, 64, 0, 0, 0, 64, 0]);
        let sum = checksum(&huge[12..29]);
        huge[29..33].copy_from_slice(&sum.to_be_bytes());
        assert_eq!(read(&huge), Ok(None));
    }

    /// Two by two pixels in the order of Adam7 (PNG, 3rd edition, 8.1), stored as they are: the first pass has the first, the sixth its neighbour, the last the second row.
    #[test]
    fn interlaced_pictures_are_put_together() {
        let pixel = |alpha: u8| [9, 9, 9, alpha];
        let mut lines = Vec::new();
        for line in [vec![1], vec![2], vec![3, 4]] {
            lines.push(0);
            lines.extend(line.into_iter().flat_map(pixel));
        }
        let (mut low, mut high) = (1u32, 0u32);
        for &byte in &lines {
            low = (low + u32::from(byte)) % 65521;
            high = (high + low) % 65521;
        }
        let length = lines.len() as u16;
        let mut stored = vec![0x78, 0x01, 1];
        stored.extend([length.to_le_bytes(), (!length).to_le_bytes()].concat());
        stored.extend(lines);
        stored.extend((high << 16 | low).to_be_bytes());
        let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
        let header = [0, 0, 0, 2, 0, 0, 0, 2, 8, 6, 0, 0, 1];
        for (name, content) in [(b"IHDR", header.as_slice()), (b"IDAT", &stored), (b"IEND", &[])] {
            let named = [name.as_slice(), content].concat();
            bytes.extend((content.len() as u32).to_be_bytes());
            bytes.extend(&named);
            bytes.extend(checksum(&named).to_be_bytes());
        }
        let texels = [1, 2, 3, 4].map(|alpha| alpha * WIDEN);
        assert_eq!(read(&bytes), Ok(AlphaMap::new([2, 2], texels.to_vec()).ok()));
    }

    /// That of PNG's chunks.
    fn checksum(bytes: &[u8]) -> u32 {
        let step = |sum: u32| if sum & 1 == 1 { 0xedb8_8320 ^ (sum >> 1) } else { sum >> 1 };
        !bytes.iter().fold(!0, |sum, &byte| (0..8).fold(sum ^ u32::from(byte), |sum, _| step(sum)))
    }
}
