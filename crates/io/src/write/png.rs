//! Pictures as PNG: eight bits a channel, no alpha; sRGB, or one channel of linear shares. [`write_png_parts`] writes pictures that are never held whole.

use std::io::{self, Write};

use ::png::{BitDepth, ColorType, Compression, Encoder};

/// An RGB picture, row by row from the upper left corner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width` × `height` pixels; red, green, blue, sRGB.
    pub pixels: Vec<[u8; 3]>,
}

/// A picture of shares, row by row from the upper left corner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GrayPicture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width` × `height` shares: 0 none, 255 all, linear.
    pub pixels: Vec<u8>,
}

/// Writes a picture as PNG.
///
/// # Errors
/// What the system says, or `InvalidInput` when the number of pixels is not width × height, or one of them is zero.
pub fn write_png(picture: &Picture, out: &mut impl Write) -> io::Result<()> {
    encode([picture.width, picture.height], picture.pixels.as_flattened(), ColorType::Rgb, out)
}

/// Writes a picture of shares as PNG with one channel.
///
/// # Errors
/// As [`write_png`].
pub fn write_gray_png(picture: &GrayPicture, out: &mut impl Write) -> io::Result<()> {
    encode([picture.width, picture.height], &picture.pixels, ColorType::Grayscale, out)
}

/// Writes a PNG part by part: memory for some rows, whatever the picture's size. The parts are pixels in order, of any number.
///
/// # Errors
/// The first error among the parts, what the system says, or `InvalidInput` when the number of pixels is not width × height, or one of them is zero.
pub fn write_png_parts(
    [width, height]: [u32; 2],
    parts: impl Iterator<Item = io::Result<Vec<[u8; 3]>>>,
    out: &mut impl Write,
) -> io::Result<()> {
    let expected = u64::from(width) * u64::from(height);
    let refused = |pixels: u64| {
        let text = format!("{pixels} pixels for a picture of {width} x {height}");
        io::Error::new(io::ErrorKind::InvalidInput, text)
    };
    if expected == 0 {
        return Err(refused(0));
    }
    let mut writer = encoder([width, height], ColorType::Rgb, out).write_header()?;
    let mut stream = writer.stream_writer()?;
    let mut written = 0;
    for part in parts {
        let pixels = part?;
        written += pixels.len() as u64;
        if written > expected {
            return Err(refused(written));
        }
        stream.write_all(pixels.as_flattened())?;
    }
    if written < expected {
        return Err(refused(written));
    }
    Ok(stream.finish()?)
}

fn encode(size: [u32; 2], bytes: &[u8], color: ColorType, out: &mut impl Write) -> io::Result<()> {
    let ([width, height], channels) = (size, color.samples() as u64);
    let expected = u64::from(width) * u64::from(height);
    if bytes.len() as u64 != expected * channels || expected == 0 {
        let text = format!("{} pixels for a picture of {width} x {height}", bytes.len() as u64 / channels);
        return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
    }
    let mut writer = encoder(size, color, out).write_header()?;
    writer.write_image_data(bytes)?;
    Ok(writer.finish()?)
}

fn encoder<W: Write>([width, height]: [u32; 2], color: ColorType, out: W) -> Encoder<'static, W> {
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(color);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    encoder
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_comes_back_as_it_was() {
        let picture = Picture { width: 2, height: 1, pixels: vec![[255, 0, 7], [1, 2, 3]] };
        let mut bytes = Vec::new();
        write_png(&picture, &mut bytes).expect("written");
        let read = image::load_from_memory(&bytes).expect("a picture").into_rgb8();
        assert_eq!((read.width(), read.height()), (2, 1));
        assert_eq!(read.into_raw(), picture.pixels.as_flattened());
    }

    #[test]
    fn parts_make_the_same_picture() {
        let pixels: Vec<[u8; 3]> = (0..12 * 300).map(|k| [k as u8, (k / 7) as u8, (k / 251) as u8]).collect();
        let parts = |pixels: &[[u8; 3]]| pixels.chunks(12 * 7).map(|part| Ok(part.to_vec())).collect::<Vec<_>>();
        let mut bytes = Vec::new();
        write_png_parts([12, 300], parts(&pixels).into_iter(), &mut bytes).expect("written");
        let read = image::load_from_memory(&bytes).expect("a picture").into_rgb8();
        assert_eq!((read.width(), read.height()), (12, 300));
        assert_eq!(read.into_raw(), pixels.as_flattened());
        for size in [[12, 299], [12, 301], [0, 300]] {
            assert!(write_png_parts(size, parts(&pixels).into_iter(), &mut Vec::new()).is_err(), "{size:?}");
        }
    }

    #[test]
    fn shares_have_one_channel() {
        let picture = GrayPicture { width: 1, height: 3, pixels: vec![0, 127, 255] };
        let mut bytes = Vec::new();
        write_gray_png(&picture, &mut bytes).expect("written");
        let read = image::load_from_memory(&bytes).expect("a picture");
        assert_eq!(read.color(), image::ColorType::L8);
        assert_eq!(read.into_luma8().into_raw(), picture.pixels);
    }

    #[test]
    fn a_wrong_size_is_refused() {
        let picture = Picture { width: 2, height: 2, pixels: vec![[0; 3]; 3] };
        assert!(write_png(&picture, &mut Vec::new()).is_err());
        assert!(write_png(&Picture { width: 0, height: 0, pixels: Vec::new() }, &mut Vec::new()).is_err());
    }
}
