//! Lines, dots and words, as SVG and as pixels: one drawing, two forms, no fonts of the system.
//!
//! SVG leaves words to the reader's fonts; pixels take them from [`font`]. Lines and dots are drawn by their distance, softened over one pixel.

mod font;
mod raster;

use std::fmt::Write;

pub(crate) use raster::{picture, write};

/// Red, green, blue.
pub(crate) type Colour = [u8; 3];

pub(crate) const BLACK: Colour = [0x22, 0x22, 0x22];
pub(crate) const GRAY: Colour = [0xdd, 0xdd, 0xdd];

/// Which end of words stands at their place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// A part of a drawing. Places in pixels from the upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Mark {
    Line { points: Vec<[f64; 2]>, width: f64, colour: Colour },
    Dot { at: [f64; 2], radius: f64, colour: Colour, is_filled: bool },
    Words { at: [f64; 2], anchor: Anchor, words: String, colour: Colour },
}

/// Marks on white, later ones over earlier ones.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drawing {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) marks: Vec<Mark>,
}

impl Drawing {
    pub(crate) fn line(&mut self, points: &[[f64; 2]], width: f64, colour: Colour) {
        self.marks.push(Mark::Line { points: points.to_vec(), width, colour });
    }

    pub(crate) fn dot(&mut self, at: [f64; 2], radius: f64, colour: Colour, is_filled: bool) {
        self.marks.push(Mark::Dot { at, radius, colour, is_filled });
    }

    pub(crate) fn words(&mut self, at: [f64; 2], anchor: Anchor, words: impl Into<String>, colour: Colour) {
        self.marks.push(Mark::Words { at, anchor, words: words.into(), colour });
    }

    /// The drawing as SVG.
    pub(crate) fn to_svg(&self) -> String {
        let Self { width, height, marks } = self;
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" \
             font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        );
        for mark in marks {
            // Writing to a string cannot fail.
            let _ = match mark {
                Mark::Line { points, width, colour } => {
                    let path: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
                    let (path, colour) = (path.join(" "), hex(*colour));
                    writeln!(
                        text,
                        "<polyline points=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"/>"
                    )
                }
                Mark::Dot { at: [x, y], radius, colour, is_filled } => {
                    let fill = if *is_filled { hex(*colour) } else { "none".into() };
                    let colour = hex(*colour);
                    writeln!(
                        text,
                        "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{fill}\" stroke=\"{colour}\"/>"
                    )
                }
                Mark::Words { at: [x, y], anchor, words, colour } => {
                    let anchor = match anchor {
                        Anchor::Start => "start",
                        Anchor::Middle => "middle",
                        Anchor::End => "end",
                    };
                    let (words, colour) = (escaped(words), hex(*colour));
                    writeln!(
                        text,
                        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{colour}\">{words}</text>"
                    )
                }
            };
        }
        text + "</svg>\n"
    }
}

fn hex([red, green, blue]: Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn escaped(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drawing_has_two_forms() {
        let mut drawing = Drawing { width: 60, height: 20, marks: Vec::new() };
        drawing.line(&[[2.0, 10.5], [58.0, 10.5]], 1.0, [255, 0, 0]);
        drawing.dot([30.0, 10.5], 4.0, [0, 0, 255], true);
        drawing.words([2.0, 8.0], Anchor::Start, "a < b", BLACK);
        assert!(drawing.to_svg().contains("a &lt; b") && drawing.to_svg().contains("cx=\"30.0\""));
        let picture = picture(&drawing);
        let at = |x: usize, y: usize| picture.pixels[y * 60 + x];
        assert_eq!((at(10, 10), at(30, 10), at(0, 19)), ([255, 0, 0], [0, 0, 255], [255; 3]));
        assert!(picture.pixels[..9 * 60].contains(&BLACK), "words are drawn");
    }
}
