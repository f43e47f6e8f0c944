//! Pictures of one size side by side, each over its caption.

use umbriel_io::write::Picture;

use crate::output::drawing::{self, Anchor, BLACK, Drawing};

/// Pictures beside each other.
const COLUMNS: usize = 3;

/// Pixels between the lines of a caption.
const LINE: u32 = 14;

/// Pixels that a letter takes.
const LETTER: u32 = 6;

/// White beside and above a caption, pixels.
const MARGIN: u32 = 4;

/// A picture's pixels, and the lines of its caption.
pub(crate) struct Captioned {
    pub(crate) pixels: Vec<[u8; 3]>,
    pub(crate) caption: Vec<String>,
}

/// Rows of three. Captions are left out where some line is wider than the pictures.
pub(crate) fn join([width, height]: [u32; 2], pictures: &[Captioned]) -> Picture {
    let (columns, rows) = (COLUMNS.min(pictures.len()), pictures.len().div_ceil(COLUMNS));
    let longest = pictures.iter().flat_map(|one| &one.caption).map(|line| line.chars().count() as u32).max();
    let has_room = longest.is_some_and(|letters| letters * LETTER + 2 * MARGIN <= width);
    let lines = pictures.iter().map(|one| one.caption.len() as u32).max().unwrap_or(0);
    let below = if has_room { lines * LINE + MARGIN } else { 0 };
    let (whole, cell) = (width * columns as u32, height + below);
    let mut joined = Picture { width: whole, height: cell * rows as u32, pixels: Vec::new() };
    // Places without a picture stay white.
    joined.pixels.resize((joined.width * joined.height) as usize, [255; 3]);
    for (place, one) in pictures.iter().enumerate() {
        let corner = [(place % columns) as u32 * width, (place / columns) as u32 * cell];
        paste(&mut joined, corner, width, &one.pixels);
        if has_room {
            let caption = drawing::picture(&words([width, below], &one.caption));
            paste(&mut joined, [corner[0], corner[1] + height], width, &caption.pixels);
        }
    }
    joined
}

fn words([width, height]: [u32; 2], lines: &[String]) -> Drawing {
    let mut drawing = Drawing { width, height, marks: Vec::new() };
    for (number, line) in (1..).zip(lines) {
        drawing.words([f64::from(MARGIN), f64::from(number * LINE)], Anchor::Start, line.as_str(), BLACK);
    }
    drawing
}

/// Copies rows of `width` pixels to where their upper left corner belongs.
fn paste(into: &mut Picture, [left, top]: [u32; 2], width: u32, pixels: &[[u8; 3]]) {
    for (row, line) in (top..).zip(pixels.chunks(width as usize)) {
        let from = (row * into.width + left) as usize;
        into.pixels[from..from + line.len()].copy_from_slice(line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pictures(count: u8, size: usize) -> Vec<Captioned> {
        let one =
            |k| Captioned { pixels: vec![[k; 3]; size], caption: vec!["depth".to_owned(), "12 tests".to_owned()] };
        (0..count).map(one).collect()
    }

    #[test]
    fn pictures_stand_over_their_captions() {
        let joined = join([60, 20], &pictures(4, 1200));
        assert_eq!((joined.width, joined.height), (180, 2 * (20 + 32)));
        let at = |x: usize, y: usize| joined.pixels[y * 180 + x];
        assert_eq!(
            (at(0, 0), at(60, 19), at(179, 0), at(0, 52), at(179, 60)),
            ([0; 3], [1; 3], [2; 3], [3; 3], [255; 3])
        );
        let dark = |rows: std::ops::Range<usize>| {
            rows.flat_map(|y| (0..60).map(move |x| (x, y))).filter(|&(x, y)| at(x, y)[0] < 100).count()
        };
        assert!(dark(20..36) > 20 && dark(36..52) > 20, "two lines of words");
        // Too small for words: nothing but the pictures.
        let small = join([40, 5], &pictures(2, 200));
        assert_eq!((small.width, small.height, small.pixels[160], small.pixels[40]), (80, 5, [0; 3], [1; 3]));
    }
}
