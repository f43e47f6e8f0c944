//! What the colours of a picture with undecided cells mean, in its lower left corner.

use umbriel_io::write::Picture;

use crate::output::drawing::{self, Anchor, BLACK, Drawing};

/// Width and height of the legend, pixels.
const SIZE: [u32; 2] = [212, 18];

/// Writes the legend, if the picture has room for it.
pub(crate) fn add(picture: &mut Picture, undecided: [u8; 3]) {
    let [width, height] = SIZE;
    if picture.width < width || picture.height < 4 * height {
        return;
    }
    let legend = drawing::picture(&marks(undecided));
    for row in 0..height {
        let from = (row * width) as usize;
        let to = ((picture.height - height + row) * picture.width) as usize;
        picture.pixels[to..to + width as usize].copy_from_slice(&legend.pixels[from..from + width as usize]);
    }
}

/// As surfaces are drawn: bright where they are lit, dark in shadow, and the colour that was asked for.
fn marks(undecided: [u8; 3]) -> Drawing {
    let mut drawing = Drawing { width: SIZE[0], height: SIZE[1], marks: Vec::new() };
    let mut left = 10.0;
    for (words, colour, width) in
        [("lit", [230, 228, 222], 52.0), ("shadow", [72, 76, 88], 70.0), ("undecided", undecided, 0.0)]
    {
        drawing.dot([left, 9.0], 5.0, BLACK, true);
        drawing.dot([left, 9.0], 4.0, colour, true);
        drawing.words([left + 9.0, 13.0], Anchor::Start, words, BLACK);
        left += width;
    }
    drawing
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_legend_stands_in_the_corner() {
        let colour = [255, 140, 26];
        let mut picture = Picture { width: 300, height: 200, pixels: vec![[1, 2, 3]; 60_000] };
        add(&mut picture, colour);
        assert!(
            picture.pixels.contains(&colour) && picture.pixels[..300 * 182].iter().all(|&pixel| pixel == [1, 2, 3])
        );
        let small = Picture { width: 48, height: 32, pixels: vec![[1, 2, 3]; 48 * 32] };
        let mut same = Picture { pixels: small.pixels.clone(), ..small };
        add(&mut same, colour);
        assert!(same.pixels.iter().all(|&pixel| pixel == [1, 2, 3]));
    }
}
