//! Line drawings as SVG 1.1: layers of straight strokes, each with its pen.

use std::io::{self, Write};

/// Strokes of one pen.
#[derive(Clone, Debug, PartialEq)]
pub struct LineLayer {
    /// What the layer is called: letters, digits and hyphens.
    pub name: &'static str,
    /// sRGB.
    pub color: [u8; 3],
    /// Width of the pen, pixels.
    pub width: f64,
    /// Lengths of dashes and of the gaps between them, pixels; none for a full line.
    pub dashes: Option<[f64; 2]>,
    /// Ends, pixels from the upper left corner.
    pub strokes: Vec<[[f64; 2]; 2]>,
}

/// A line drawing; later layers lie above earlier ones.
#[derive(Clone, Debug, PartialEq)]
pub struct LineArt {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// From the lowest to the highest.
    pub layers: Vec<LineLayer>,
}

/// Writes a line drawing as SVG, on white. Places are rounded to hundredths of a pixel.
///
/// # Errors
/// What the system says.
pub fn write_svg(art: &LineArt, out: &mut impl Write) -> io::Result<()> {
    let [width, height] = art.size;
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">"
    )?;
    writeln!(out, "<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>")?;
    for layer in &art.layers {
        let [red, green, blue] = layer.color;
        write!(
            out,
            "<path id=\"{}\" fill=\"none\" stroke=\"#{red:02x}{green:02x}{blue:02x}\" stroke-width=\"{}\" \
             stroke-linecap=\"round\"",
            layer.name, layer.width
        )?;
        if let Some([dash, gap]) = layer.dashes {
            write!(out, " stroke-dasharray=\"{dash} {gap}\"")?;
        }
        write!(out, " d=\"")?;
        for [from, to] in &layer.strokes {
            writeln!(out, "M{:.2} {:.2}L{:.2} {:.2}", from[0], from[1], to[0], to[1])?;
        }
        writeln!(out, "\"/>")?;
    }
    writeln!(out, "</svg>")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drawing_is_text_with_its_strokes() {
        let layer = LineLayer {
            name: "hidden",
            color: [255, 0, 16],
            width: 0.5,
            dashes: Some([4.0, 3.0]),
            strokes: vec![[[0.0, 1.0], [2.5, 3.125]]],
        };
        let mut bytes = Vec::new();
        write_svg(&LineArt { size: [4, 3], layers: vec![layer] }, &mut bytes).expect("written");
        let text = String::from_utf8(bytes).expect("text");
        for part in ["viewBox=\"0 0 4 3\"", "#ff0010", "stroke-dasharray=\"4 3\"", "M0.00 1.00L2.50 3.12", "</svg>"] {
            assert!(text.contains(part), "{part} is not in {text}");
        }
    }
}
