//! A comparison of soft shadows for people, as JSON (names and order of the fields are a contract), and as a strip of pictures.

use std::fmt::Write;

use serde::Serialize;
use umbriel_io::write::Picture;

const SCHEMA: u32 = 1;

/// How an error is painted: this much is all red.
const FULL_ERROR: f64 = 0.5;

/// How far a method is from the truth.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Errors {
    rmse: f64,
    percentile_99: f64,
    largest: f64,
    /// Share of the pixels that are not fully lit.
    touched: f64,
}

/// One method.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Row {
    pub(crate) name: &'static str,
    /// Shading and what it needs besides the depth map; wall.
    pub(crate) seconds: f64,
    #[serde(flatten)]
    pub(crate) errors: Errors,
}

/// All methods on one picture.
#[derive(Clone, Debug)]
pub(crate) struct Comparison {
    pub(crate) light: String,
    pub(crate) size: [u32; 2],
    pub(crate) map: usize,
    pub(crate) map_seconds: f64,
    pub(crate) truth_points: usize,
    pub(crate) boxes: usize,
    pub(crate) outline_corners: Vec<usize>,
    pub(crate) rows: Vec<Row>,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    umbriel: &'static str,
    light: &'a str,
    picture: [u32; 2],
    depth_map: DepthMapEntry,
    truth_points: usize,
    boxes: BoxesEntry<'a>,
    methods: &'a [Row],
}

#[derive(Serialize)]
struct DepthMapEntry {
    edge: usize,
    seconds: f64,
}

#[derive(Serialize)]
struct BoxesEntry<'a> {
    given: usize,
    outline_corners: &'a [usize],
}

impl Errors {
    /// From the absolute errors of points.
    pub(crate) fn of(mut errors: Vec<f64>, touched: f64) -> Self {
        errors.sort_by(f64::total_cmp);
        let count = errors.len().max(1) as f64;
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        // The smallest error that 99 of 100 do not exceed.
        let at = ((0.99 * errors.len() as f64).ceil() as usize).saturating_sub(1);
        let percentile_99 = errors.get(at).copied().unwrap_or(0.0);
        Self { rmse: (squares / count).sqrt(), percentile_99, largest: errors.last().copied().unwrap_or(0.0), touched }
    }
}

impl Comparison {
    pub(crate) fn to_text(&self) -> String {
        let Self { light, size: [width, height], map, map_seconds, truth_points, boxes, outline_corners, rows } = self;
        let mut text = format!(
            "light {light}; picture {width} x {height}; depth map {map} x {map}, {:.1} ms; truth at {truth_points} points\n\
             boxes: {boxes}, corners of their outlines: {outline_corners:?}\n\n\
             {:<15}{:>12}{:>10}{:>10}{:>10}{:>11}\n",
            1e3 * map_seconds,
            "method",
            "time/ms",
            "RMSE",
            "99 %",
            "largest",
            "touched/%"
        );
        for Row { name, seconds, errors } in rows {
            let Errors { rmse, percentile_99, largest, touched } = errors;
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{name:<15}{:>12.2}{rmse:>10.4}{percentile_99:>10.4}{largest:>10.4}{:>11.2}",
                1e3 * seconds,
                100.0 * touched
            );
        }
        text
    }

    pub(crate) fn to_json(&self) -> String {
        let document = Document {
            schema: SCHEMA,
            umbriel: env!("CARGO_PKG_VERSION"),
            light: &self.light,
            picture: self.size,
            depth_map: DepthMapEntry { edge: self.map, seconds: self.map_seconds },
            truth_points: self.truth_points,
            boxes: BoxesEntry { given: self.boxes, outline_corners: &self.outline_corners },
            methods: &self.rows,
        };
        // Plain numbers and strings: there is nothing to refuse.
        let text = serde_json::to_string_pretty(&document).unwrap_or_default();
        text + "\n"
    }

    /// The truth and each method from left to right; below, the errors: red too light, blue too dark.
    pub(crate) fn strip(&self, [width, height]: [u32; 2], truth: &[Option<f64>], shades: &[Vec<f32>]) -> Picture {
        let columns = 1 + shades.len() as u32;
        let mut pixels = vec![[0; 3]; (width * columns * 2 * height) as usize];
        let mut put = |column: u32, row: u32, number: usize, color: [u8; 3]| {
            let (x, y) = (number as u32 % width, number as u32 / width);
            pixels[((row * height + y) * width * columns + column * width + x) as usize] = color;
        };
        let gray = |value: f64| [(255.0 * value.clamp(0.0, 1.0)).round() as u8; 3];
        for (number, truth) in truth.iter().enumerate() {
            let value = truth.unwrap_or(1.0);
            put(0, 0, number, gray(value));
            put(0, 1, number, gray(1.0));
            for (column, shade) in shades.iter().enumerate() {
                let shade = f64::from(shade[number]);
                put(column as u32 + 1, 0, number, gray(shade));
                let error = if truth.is_some() { ((shade - value) / FULL_ERROR).clamp(-1.0, 1.0) } else { 0.0 };
                let other = gray(1.0 - error.abs())[0];
                put(column as u32 + 1, 1, number, if error > 0.0 { [255, other, other] } else { [other, other, 255] });
            }
        }
        Picture { width: width * columns, height: 2 * height, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_summed_up() {
        let errors = Errors::of((0..100).map(|k| f64::from(k) / 100.0).collect(), 0.5);
        assert_eq!((errors.percentile_99, errors.largest), (0.98, 0.99));
        assert!((errors.rmse - 0.328_35f64.sqrt()).abs() < 1e-12);
        assert_eq!(Errors::of(Vec::new(), 0.0).rmse, 0.0);
    }
}
