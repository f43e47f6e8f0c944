//! Hard shadows by several ways on one picture: a table, JSON (names and order of the fields are a contract), and a strip of pictures.

use std::fmt::Write;

use serde::Serialize;
use umbriel_io::write::Picture;
use umbriel_shadow::{Verdict, tradeoff::Measurement};

const SCHEMA: u32 = 1;

const LIT: [u8; 3] = [0xf4, 0xe6, 0xc8];
const DARK: [u8; 3] = [0x3a, 0x46, 0x66];
const UNDECIDED: [u8; 3] = [0xff, 0x8c, 0x1a];
const WRONG: [u8; 3] = [0xe0, 0x10, 0x30];
const NOTHING: [u8; 3] = [0xff; 3];

/// What all ways say of the points of one picture.
pub(crate) struct Comparison {
    pub(crate) light: String,
    pub(crate) size: [u32; 2],
    /// The pixel of each judged point.
    pub(crate) pixels: Vec<usize>,
    pub(crate) truth: Vec<bool>,
    /// How bright each point's surface is by its tilt, 0 to 1.
    pub(crate) shades: Vec<f64>,
    /// Wall seconds for the polygons that all rivals work on, made beforehand.
    pub(crate) polygons_seconds: f64,
    pub(crate) ways: Vec<(Measurement, Vec<Verdict>)>,
    pub(crate) refused: Vec<(String, String)>,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    umbriel: &'static str,
    light: &'a str,
    picture: [u32; 2],
    points: usize,
    polygons_seconds: f64,
    methods: Vec<Entry<'a>>,
}

#[derive(Serialize)]
struct Entry<'a> {
    name: &'a str,
    ready_seconds: f64,
    first_seconds: f64,
    second_seconds: f64,
    stored_bytes: u64,
    rays: u64,
    undecided: u64,
    wrong: u64,
}

impl Comparison {
    pub(crate) fn to_json<'a>(&'a self) -> String {
        let entry = |(one, _): &'a (Measurement, Vec<Verdict>)| Entry {
            name: &one.name,
            ready_seconds: one.ready_seconds,
            first_seconds: one.first_seconds,
            second_seconds: one.second_seconds,
            stored_bytes: one.bytes,
            rays: one.rays,
            undecided: one.score.undecided,
            wrong: one.score.wrong,
        };
        let methods = self.ways.iter().map(entry).collect();
        let document = Document {
            schema: SCHEMA,
            umbriel: env!("CARGO_PKG_VERSION"),
            light: &self.light,
            picture: self.size,
            points: self.truth.len(),
            polygons_seconds: self.polygons_seconds,
            methods,
        };
        // Plain numbers and strings: there is nothing to refuse.
        serde_json::to_string_pretty(&document).unwrap_or_default() + "\n"
    }

    pub(crate) fn to_text(&self) -> String {
        let [width, height] = self.size;
        let mut text = format!(
            "light {}; picture {width} x {height}, {} points of surface; truth by exact queries\n\
             ready: made beforehand, the same for all lights; polygons for the rivals {:.2} ms\n\n\
             {:<22}{:>10}{:>10}{:>11}{:>11}{:>12}{:>11}{:>9}\n",
            self.light,
            self.truth.len(),
            1e3 * self.polygons_seconds,
            "method",
            "ready ms",
            "first ms",
            "second ms",
            "stored MB",
            "rays",
            "undecided",
            "wrong"
        );
        for (one, _) in &self.ways {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{:<22}{:>10.2}{:>10.2}{:>11.2}{:>11.3}{:>12}{:>11}{:>9}",
                one.name,
                1e3 * one.ready_seconds,
                1e3 * one.first_seconds,
                1e3 * one.second_seconds,
                one.bytes as f64 / 1e6,
                one.rays,
                one.score.undecided,
                one.score.wrong
            );
        }
        for (name, reason) in &self.refused {
            let _ = writeln!(text, "{name:<22}{reason}");
        }
        text
    }

    /// The truth and each way from left to right; wrong points red, undecided ones orange, both a pixel wider than they are.
    pub(crate) fn strip(&self) -> Picture {
        let [width, height] = self.size;
        let columns = 1 + self.ways.len() as u32;
        let mut pixels = vec![NOTHING; (width * columns * height) as usize];
        let place = |column: u32, pixel: usize| {
            let (x, y) = (pixel as u32 % width, pixel as u32 / width);
            (y * width * columns + column * width + x) as usize
        };
        for (number, &pixel) in self.pixels.iter().enumerate() {
            let of = |is_lit: bool| shaded(if is_lit { LIT } else { DARK }, self.shades[number]);
            pixels[place(0, pixel)] = of(self.truth[number]);
            for (column, (_, stated)) in (1..).zip(&self.ways) {
                pixels[place(column, pixel)] = of(stated[number] != Verdict::Shadowed);
            }
        }
        for (column, (_, stated)) in (1..).zip(&self.ways) {
            for (number, &pixel) in self.pixels.iter().enumerate() {
                let colour = match (stated[number], self.truth[number]) {
                    (Verdict::Undecided, _) => UNDECIDED,
                    (Verdict::Lit, false) | (Verdict::Shadowed, true) => WRONG,
                    _ => continue,
                };
                let is_last = (pixel as u32 + 1).is_multiple_of(width);
                pixels[place(column, pixel)] = colour;
                if !is_last {
                    pixels[place(column, pixel + 1)] = colour;
                }
            }
        }
        Picture { width: width * columns, height, pixels }
    }
}

fn shaded(colour: [u8; 3], shade: f64) -> [u8; 3] {
    colour.map(|part| (f64::from(part) * (0.6 + 0.4 * shade.clamp(0.0, 1.0))).round() as u8)
}
