//! A drawing as pixels.

use glam::DVec2;
use umbriel_io::write::Picture;

use super::{Anchor, Colour, Drawing, Mark, font};

/// The drawing, a pixel a unit. O(marks × their boxes).
pub(crate) fn picture(drawing: &Drawing) -> Picture {
    let [width, height] = [drawing.width, drawing.height];
    let mut picture = Picture { width, height, pixels: vec![[255; 3]; (width * height) as usize] };
    for mark in &drawing.marks {
        match mark {
            Mark::Line { points, width, colour } => {
                points.windows(2).for_each(|ends| line(&mut picture, [ends[0], ends[1]], *width, *colour));
            }
            Mark::Dot { at, radius, colour, is_filled } => dot(&mut picture, *at, *radius, *colour, *is_filled),
            Mark::Words { at, anchor, words, colour } => write(&mut picture, *at, *anchor, words, *colour),
        }
    }
    picture
}

/// Mixes a colour into the pixels of a box, by how much of each it covers.
fn blend(picture: &mut Picture, low: DVec2, high: DVec2, colour: Colour, cover: impl Fn(DVec2) -> f64) {
    let range =
        |low: f64, high: f64, size: u32| (low.max(0.0) as u32).min(size)..(high.max(0.0).ceil() as u32).min(size);
    for y in range(low.y, high.y, picture.height) {
        for x in range(low.x, high.x, picture.width) {
            let cover = cover(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).clamp(0.0, 1.0);
            let pixel = &mut picture.pixels[(y * picture.width + x) as usize];
            for (part, colour) in pixel.iter_mut().zip(colour) {
                *part = (f64::from(*part) + cover * (f64::from(colour) - f64::from(*part))).round() as u8;
            }
        }
    }
}

fn line(picture: &mut Picture, ends: [[f64; 2]; 2], width: f64, colour: Colour) {
    let [a, b] = ends.map(DVec2::from_array);
    let along = b - a;
    let distance = |at: DVec2| {
        let share = (along.dot(at - a) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        at.distance(a + share * along)
    };
    let reach = DVec2::splat(0.5 * width + 1.0);
    blend(picture, a.min(b) - reach, a.max(b) + reach, colour, |at| 0.5 * width + 0.5 - distance(at));
}

fn dot(picture: &mut Picture, at: [f64; 2], radius: f64, colour: Colour, is_filled: bool) {
    let center = DVec2::from_array(at);
    let reach = DVec2::splat(radius + 1.0);
    let cover = |at: DVec2| {
        let outside = at.distance(center) - radius;
        if is_filled { 0.5 - outside } else { 1.0 - outside.abs() }
    };
    blend(picture, center - reach, center + reach, colour, cover);
}

/// Words whose letters stand on `at`.
pub(crate) fn write(picture: &mut Picture, [x, y]: [f64; 2], anchor: Anchor, words: &str, colour: Colour) {
    let length = words.chars().count() as i64 * font::ADVANCE;
    let shift = match anchor {
        Anchor::Start => 0,
        Anchor::Middle => length / 2,
        Anchor::End => length,
    };
    let (left, top) = (x.round() as i64 - shift, y.round() as i64 - font::HEIGHT);
    for (number, letter) in (0..).zip(words.chars()) {
        for (column, row) in font::pixels(letter) {
            let (x, y) = (left + number * font::ADVANCE + column, top + row);
            if (0..i64::from(picture.width)).contains(&x) && (0..i64::from(picture.height)).contains(&y) {
                picture.pixels[(y * i64::from(picture.width) + x) as usize] = colour;
            }
        }
    }
}
