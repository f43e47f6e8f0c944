//! Soft shadows: areas with bounds and a comparison of methods, for people, as JSON (names and order of the fields are a contract), and as a strip of pictures.

use std::fmt::Write;

use serde::Serialize;
use umbriel_io::write::Picture;
use umbriel_scene::Scene;
use umbriel_shadow::{AreaBounds, Detail, LitArea, SoftLight, SoftObject};

use super::{
    drawing::{self, Anchor},
    json::DetailUsed,
    table::{aligned, number},
};

const SCHEMA: u32 = 1;

/// How an error is painted: this much is all red.
const FULL_ERROR: f64 = 0.5;

/// Height of the words over a picture, pixels.
const CAPTION: u32 = 16;

/// Where nothing is seen.
const BACKGROUND: [u8; 3] = [0xc4, 0xd2, 0xe2];

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

/// All methods on one picture, or on several frames.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Comparison {
    pub(crate) light: String,
    /// Width and height.
    #[serde(rename = "picture")]
    pub(crate) size: [u32; 2],
    /// Edge of the depth map, texels.
    #[serde(rename = "depth_map")]
    pub(crate) map: usize,
    /// To draw it; wall, the mean of frames.
    #[serde(rename = "depth_map_seconds")]
    pub(crate) map_seconds: f64,
    pub(crate) truth_points: usize,
    /// Of these, those on faces that are not turned to the light's middle: no method is judged by them.
    #[serde(rename = "points_turned_away")]
    pub(crate) turned_away: usize,
    pub(crate) boxes: usize,
    /// Boxes that reach the light's plane or are flattened to a line, and so shade nothing.
    pub(crate) boxes_left_out: usize,
    pub(crate) outline_corners: Vec<usize>,
    pub(crate) frames: u32,
    #[serde(rename = "methods")]
    pub(crate) rows: Vec<Row>,
}

/// What every object gets of area lights.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Areas {
    detail: DetailUsed,
    lights: Vec<LightAreas>,
    /// For all lights; wall.
    seconds: f64,
}

#[derive(Clone, Debug, Serialize)]
struct LightAreas {
    name: String,
    cells: u64,
    objects: Vec<ObjectAreas>,
}

/// Square metres.
#[derive(Clone, Debug, Serialize)]
struct ObjectAreas {
    name: String,
    area: f64,
    lit: Between,
    penumbra: Between,
    umbra: Between,
    /// The visible fraction summed over the surface.
    visible: Estimated,
    /// Its mean over the surface.
    visible_fraction: Estimated,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct Between {
    lower: f64,
    upper: f64,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct Estimated {
    lower: f64,
    upper: f64,
    estimate: f64,
}

/// All that the command tells.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Document<'a> {
    schema: u32,
    umbriel: &'static str,
    #[serde(flatten)]
    areas: &'a Areas,
    pictures: &'a Comparison,
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

impl Areas {
    /// Sums of `soft_bake`, which took so many seconds.
    pub(crate) fn new(scene: &Scene, detail: Detail, report: &[SoftLight], seconds: f64) -> Self {
        let lights = report.iter().map(|light| LightAreas {
            name: scene.lights[light.light].name.clone(),
            cells: light.cells,
            objects: light.objects.iter().map(|object| ObjectAreas::new(scene, object)).collect(),
        });
        Self { detail: DetailUsed::of(detail), lights: lights.collect(), seconds }
    }

    fn to_text(&self) -> String {
        let mut text = String::new();
        for light in &self.lights {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "light {}", light.name);
            let mut rows = vec![["object", "area m²", "lit %", "penumbra %", "umbra %", "mean %"].map(str::to_owned)];
            rows.extend(light.objects.iter().map(ObjectAreas::row));
            text.push_str(&aligned(&rows));
        }
        let cells: u64 = self.lights.iter().map(|light| light.cells).sum();
        let _ = writeln!(text, "{cells} cells, {:.1} ms", 1e3 * self.seconds);
        text
    }
}

impl ObjectAreas {
    fn new(scene: &Scene, object: &SoftObject) -> Self {
        let between = |bounds: AreaBounds| Between { lower: bounds.lower, upper: bounds.upper };
        let LitArea { lower, upper, estimate } = object.visible;
        let area = object.area;
        let share = |part: f64| if area > 0.0 { (part / area).clamp(0.0, 1.0) } else { 0.0 };
        // Quotients are rounded outward, but a share is no more than all.
        let visible_fraction = Estimated {
            lower: share(lower).next_down().max(0.0),
            upper: share(upper).next_up().min(1.0),
            estimate: share(estimate),
        };
        Self {
            name: scene.objects[object.object].name.clone(),
            area,
            lit: between(object.lit),
            penumbra: between(object.penumbra),
            umbra: between(object.umbra),
            visible: Estimated { lower, upper, estimate },
            visible_fraction,
        }
    }

    fn row(&self) -> [String; 6] {
        let percent = |part: f64| if self.area > 0.0 { (100.0 * part / self.area).clamp(0.0, 100.0) } else { 0.0 };
        let between = |part: Between| format!("{:.2} to {:.2}", percent(part.lower), percent(part.upper));
        let Estimated { lower, upper, estimate } = self.visible_fraction;
        let mean = format!("{:.2} ({:.2} to {:.2})", 100.0 * estimate, 100.0 * lower, 100.0 * upper);
        let [lit, penumbra, umbra] = [self.lit, self.penumbra, self.umbra].map(between);
        [self.name.clone(), number(self.area), lit, penumbra, umbra, mean]
    }
}

impl<'a> Document<'a> {
    pub(crate) fn new(areas: &'a Areas, pictures: &'a Comparison) -> Self {
        Self { schema: SCHEMA, umbriel: env!("CARGO_PKG_VERSION"), areas, pictures }
    }

    pub(crate) fn to_text(&self) -> String {
        format!("{}\n{}", self.areas.to_text(), self.pictures.to_text())
    }

    pub(crate) fn to_json(&self) -> String {
        // Plain numbers and strings: there is nothing to refuse.
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        text + "\n"
    }
}

impl Comparison {
    /// Takes another frame in: times and RMSE become means, other errors the greatest.
    pub(crate) fn add_frame(&mut self, frame: &Self) {
        let count = f64::from(self.frames);
        let mean = |old: f64, new: f64| (old * count + new) / (count + 1.0);
        self.map_seconds = mean(self.map_seconds, frame.map_seconds);
        for (row, new) in self.rows.iter_mut().zip(&frame.rows) {
            row.seconds = mean(row.seconds, new.seconds);
            let (errors, new) = (&mut row.errors, &new.errors);
            errors.rmse = mean(errors.rmse, new.rmse);
            errors.touched = mean(errors.touched, new.touched);
            errors.percentile_99 = errors.percentile_99.max(new.percentile_99);
            errors.largest = errors.largest.max(new.largest);
        }
        self.frames += frame.frames;
    }

    fn to_text(&self) -> String {
        let [width, height] = self.size;
        let (map, count) = (self.map, self.truth_points);
        let mut text = format!(
            "light {}; picture {width} x {height}; depth map {map} x {map}, {:.1} ms; truth at {count} points",
            self.light,
            1e3 * self.map_seconds
        );
        // Writing to a string cannot fail.
        if self.turned_away > 0 {
            let _ = write!(text, ", {} of them turned away from the light and not judged", self.turned_away);
        }
        if self.frames > 1 {
            let _ = write!(text, "; {} frames, times are their means", self.frames);
        }
        let _ = write!(text, "\nboxes: {}, corners of their outlines: {:?}", self.boxes, self.outline_corners);
        if self.boxes_left_out > 0 {
            let _ = write!(
                text,
                "; {} shade nothing, as they reach the light's plane or are flattened to a line",
                self.boxes_left_out
            );
        }
        let _ = writeln!(
            text,
            "\n\n{:<15}{:>12}{:>10}{:>10}{:>10}{:>11}",
            "method", "time/ms", "RMSE", "99 %", "largest", "touched/%"
        );
        for Row { name, seconds, errors } in &self.rows {
            let Errors { rmse, percentile_99, largest, touched } = errors;
            let _ = writeln!(
                text,
                "{name:<15}{:>12.2}{rmse:>10.4}{percentile_99:>10.4}{largest:>10.4}{:>11.2}",
                1e3 * seconds,
                100.0 * touched
            );
        }
        text
    }

    /// The picture by the only method, or the truth and each method from left to right, and below the errors: red too light, blue too dark. What shows no
    /// surface is the background.
    pub(crate) fn picture(&self, seen: &Seen) -> Picture {
        let [width, height] = self.size;
        if let [shade] = seen.shades {
            let pixels = shade.iter().zip(seen.is_surface).map(|(&shade, &is_surface)| shown(shade.into(), is_surface));
            return Picture { width, height, pixels: pixels.collect() };
        }
        let columns = 1 + seen.shades.len() as u32;
        let rows = 2 * (height + CAPTION);
        let mut strip =
            Picture { width: width * columns, height: rows, pixels: vec![[255; 3]; (width * columns * rows) as usize] };
        for column in 0..columns {
            let shade = column.checked_sub(1).map(|method| &seen.shades[method as usize]);
            self.caption(&mut strip, column);
            for (number, (truth, &is_surface)) in seen.truth.iter().zip(seen.is_surface).enumerate() {
                let (x, y) = (column * width + number as u32 % width, CAPTION + number as u32 / width);
                let value = shade.map_or(truth.unwrap_or(1.0), |shade| shade[number].into());
                let mut put = |y: u32, color| strip.pixels[(y * width * columns + x) as usize] = color;
                put(y, shown(value, is_surface));
                put(y + height + CAPTION, error_shown(truth.map_or(0.0, |truth| value - truth)));
            }
        }
        strip
    }

    /// A column's name, and below its error.
    fn caption(&self, strip: &mut Picture, column: u32) {
        let [width, height] = self.size;
        let mut words = |y: u32, text: &str| {
            let at = [f64::from(column * width + 4), f64::from(y + CAPTION - 4)];
            drawing::write(strip, at, Anchor::Start, text, drawing::BLACK);
        };
        match column.checked_sub(1).map(|method| &self.rows[method as usize]) {
            None => words(0, "truth"),
            Some(row) => {
                words(0, row.name);
                let rmse = format!("RMSE {:.4}: red too light, blue too dark", row.errors.rmse);
                words(height + CAPTION, &rmse);
            }
        }
    }
}

/// What a comparison shows: pixel by pixel, and the shades method by method.
pub(crate) struct Seen<'a> {
    pub(crate) truth: &'a [Option<f64>],
    pub(crate) shades: &'a [Vec<f32>],
    pub(crate) is_surface: &'a [bool],
}

fn shown(value: f64, is_surface: bool) -> [u8; 3] {
    if is_surface { [(255.0 * value.clamp(0.0, 1.0)).round() as u8; 3] } else { BACKGROUND }
}

/// An error as a colour.
fn error_shown(error: f64) -> [u8; 3] {
    let error = (error / FULL_ERROR).clamp(-1.0, 1.0);
    let other = (255.0 * (1.0 - error.abs())).round() as u8;
    if error > 0.0 { [255, other, other] } else { [other, other, 255] }
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
