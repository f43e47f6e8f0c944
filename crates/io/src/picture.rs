//! Pictures in: the alpha of a PNG, and nothing else of it.
//!
//! Dimensions are read first and entered into the account of the scene; a picture without alpha is not decoded. Time is linear in its
//! texels, memory some ten bytes each while it is decoded, and four after.

use std::io::Cursor;

use image::{ColorType, ImageDecoder, codecs::png::PngDecoder};
use umbriel_geometry::cut_out::AlphaMap;

use crate::{error::excerpt, ledger::Ledger};

/// Alphas of 8 bits times this are alphas of 16 bits.
const WIDEN: u16 = 257;

/// The alpha of a picture; `None` for one that is opaque because its kind has none. The message says why a picture is not read.
pub(crate) fn alpha(bytes: &[u8], ledger: &Ledger) -> Result<Option<AlphaMap>, String> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => png_alpha(bytes, ledger),
        // JPEG has no alpha.
        [0xff, 0xd8, 0xff, ..] => Ok(None),
        _ => Err("it is neither PNG nor JPEG".to_owned()),
    }
}

fn png_alpha(bytes: &[u8], ledger: &Ledger) -> Result<Option<AlphaMap>, String> {
    let unread = |fault: image::ImageError| format!("its PNG is not read: {}", excerpt(&fault.to_string()));
    let decoder = PngDecoder::new(Cursor::new(bytes)).map_err(unread)?;
    let (size, color) = (<[u32; 2]>::from(decoder.dimensions()), decoder.color_type());
    if !color.has_alpha() {
        return Ok(None);
    }
    let texels = u64::from(size[0]) * u64::from(size[1]);
    ledger.picture(texels).map_err(|problem| problem.to_string())?;
    let mut content = vec![0; usize::try_from(decoder.total_bytes()).map_err(|_| "it is too large".to_owned())?];
    decoder.read_image(&mut content).map_err(unread)?;
    let texels = match color {
        ColorType::La8 | ColorType::Rgba8 => {
            let last = usize::from(color.bytes_per_pixel());
            content.chunks_exact(last).map(|pixel| u16::from(pixel[last - 1]) * WIDEN).collect()
        }
        _ => {
            let last = usize::from(color.bytes_per_pixel());
            content.chunks_exact(last).map(|pixel| u16::from_ne_bytes([pixel[last - 2], pixel[last - 1]])).collect()
        }
    };
    AlphaMap::new(size, texels).map(Some).map_err(|defect| defect.to_string())
}

#[cfg(test)]
mod tests {
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
        assert_eq!(read(&[0xff, 0xd8, 0xff, 0xe0]), Ok(None), "JPEG has no alpha");
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
}
