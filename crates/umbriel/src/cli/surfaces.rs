//! `umbriel render --method`: the picture by the methods of hidden surfaces, and what each of them did.
//!
//! The faces of a picture with more pixels, `--aa` along each edge of a pixel, are found band by band, shaded, and averaged; only
//! one band of faces is held.

use std::time::{Duration, Instant};

use glam::DVec3;
use rayon::prelude::*;
use umbriel_io::write::Picture;
use umbriel_scene::Scene;
use umbriel_shadow::Progress;
use umbriel_visibility::{
    View,
    hidden_surface::{
        DepthBuffer, DepthSort, FacePicture, HiddenSurface, RayCasting, RayTree, ScanLine, Shot, Statistics, Warnock,
        draw_rows,
    },
};

use crate::{
    cli::{Failure, render_args::SurfaceMethod},
    output::{
        self,
        picture::{Studio, background, to_srgb},
        table,
    },
    progress::Bar,
};

/// Samples of a band: some tens of megabytes with all that is kept of them.
const BAND: u32 = 1 << 22;

/// Pictures beside each other.
const COLUMNS: usize = 3;

/// What a picture is drawn from.
pub(crate) struct Canvas<'a> {
    pub(crate) scene: &'a Scene,
    /// The objects that it is drawn from.
    pub(crate) objects: &'a [usize],
    pub(crate) studio: &'a Studio<'a>,
    pub(crate) view: View,
    /// Samples along each edge of a pixel.
    pub(crate) subpixels: u32,
    pub(crate) bar: &'a Bar,
}

/// What one method did.
struct Row {
    name: &'static str,
    time: Duration,
    work: Statistics,
    differing: usize,
}

impl Canvas<'_> {
    /// The picture by one method, or the pictures of all of them; what they did goes to standard output.
    pub(crate) fn draw(&self, method: SurfaceMethod) -> Result<Picture, Failure> {
        let fine =
            View { width: self.view.width * self.subpixels, height: self.view.height * self.subpixels, ..self.view };
        let shot = Shot::of_objects(self.scene, self.objects, &fine)
            .map_err(|defect| Failure::Unusable(defect.to_string()))?;
        let methods = methods(method, &shot);
        let mut rows: Vec<Row> = methods.iter().map(|method| Row::new(method.as_ref())).collect();
        let mut pixels: Vec<Vec<[u8; 3]>> = vec![Vec::new(); methods.len()];
        let band = (BAND / fine.width / self.subpixels).max(1);
        for first in (0..self.view.height).step_by(band as usize) {
            if self.bar.is_cancelled() {
                return Err(Failure::Interrupted);
            }
            let last = (first + band).min(self.view.height);
            let mut known: Option<(FacePicture, Vec<[u8; 3]>)> = None;
            for ((method, row), pixels) in methods.iter().zip(&mut rows).zip(&mut pixels) {
                let start = Instant::now();
                let (faces, work) = draw_rows(method.as_ref(), &shot, first * self.subpixels..last * self.subpixels);
                row.time += start.elapsed();
                row.work += work;
                let differing = known.as_ref().map_or(0, |(other, _)| faces.differences(other));
                row.differing += differing;
                match &known {
                    // The same faces have the same colours.
                    Some((_, colors)) if differing == 0 => pixels.extend_from_slice(colors),
                    _ => {
                        let colors = self.colors(&shot, &faces, first..last);
                        pixels.extend_from_slice(&colors);
                        known.get_or_insert((faces, colors));
                    }
                }
            }
            self.bar.advance("picture", u64::from(last), u64::from(self.view.height));
        }
        output::print(&text(&shot, &rows))?;
        Ok(side_by_side([self.view.width, self.view.height], pixels))
    }

    /// Some rows of pixels, each the mean of its samples.
    fn colors(&self, shot: &Shot, faces: &FacePicture, rows: std::ops::Range<u32>) -> Vec<[u8; 3]> {
        let n = self.subpixels;
        let sample = |column: u32, row: u32| match faces.hit(shot, [column, row]) {
            Some(hit) => self.studio.surface(&hit, &shot.view().ray(f64::from(column) + 0.5, f64::from(row) + 0.5)),
            None => background((f64::from(row) + 0.5) / f64::from(shot.view().height)),
        };
        let pixel = |x: u32, y: u32| {
            let samples = (0..n * n).map(|k| sample(x * n + k / n, y * n + k % n));
            to_srgb(samples.sum::<DVec3>() / f64::from(n * n))
        };
        rows.into_par_iter().flat_map_iter(|y| (0..self.view.width).map(move |x| pixel(x, y))).collect()
    }
}

/// The method, or all of them.
fn methods(method: SurfaceMethod, shot: &Shot) -> Vec<Box<dyn HiddenSurface>> {
    let one = |method: SurfaceMethod| -> Option<Box<dyn HiddenSurface>> {
        Some(match method {
            SurfaceMethod::Depth => Box::new(DepthBuffer::default()),
            SurfaceMethod::Scanline => Box::new(ScanLine::default()),
            SurfaceMethod::Warnock => Box::new(Warnock::default()),
            SurfaceMethod::Raycast => Box::new(RayCasting::new(shot, RayTree::Boxes)),
            SurfaceMethod::Octree => Box::new(RayCasting::new(shot, RayTree::Octree)),
            SurfaceMethod::Sort => Box::new(DepthSort::default()),
            SurfaceMethod::All | SurfaceMethod::Lines => return None,
        })
    };
    let all = <SurfaceMethod as clap::ValueEnum>::value_variants();
    one(method).map_or_else(|| all.iter().filter_map(|&method| one(method)).collect(), |method| vec![method])
}

impl Row {
    fn new(method: &dyn HiddenSurface) -> Self {
        Self { name: method.name(), time: Duration::ZERO, work: Statistics::default(), differing: 0 }
    }

    fn columns(&self) -> [String; 10] {
        let Statistics { windows, tests, depths, skipped, written, divided, judged } = self.work;
        let numbers = [windows, tests, depths, skipped, written, divided, judged].map(|number| number.to_string());
        let [windows, tests, depths, skipped, written, divided, judged] = numbers;
        let seconds = format!("{:.3}", self.time.as_secs_f64());
        let differing = self.differing.to_string();
        [self.name.to_owned(), seconds, windows, tests, depths, skipped, written, divided, judged, differing]
    }
}

/// What was done, for people.
fn text(shot: &Shot, rows: &[Row]) -> String {
    let header =
        ["method", "seconds", "windows", "tests", "depths", "skipped", "written", "divided", "judged", "differing"];
    let mut lines = vec![header.map(str::to_owned)];
    lines.extend(rows.iter().map(Row::columns));
    let (faces, seen, back) = (shot.faces(), shot.faces_in_picture(), shot.back_faces_removed());
    let size = format!("{} x {} samples", shot.view().width, shot.view().height);
    format!("{size}; {faces} faces, {seen} may be seen, {back} back faces left out\n{}", table::aligned(&lines))
}

/// Pictures of one size in rows of three.
fn side_by_side([width, height]: [u32; 2], mut pictures: Vec<Vec<[u8; 3]>>) -> Picture {
    if pictures.len() == 1 {
        return Picture { width, height, pixels: pictures.remove(0) };
    }
    let (columns, rows) = (COLUMNS.min(pictures.len()), pictures.len().div_ceil(COLUMNS));
    let mut pixels = Vec::with_capacity(columns * rows * pictures[0].len());
    for part in pictures.chunks(columns) {
        for y in 0..height as usize {
            let line = y * width as usize..(y + 1) * width as usize;
            part.iter().for_each(|picture| pixels.extend_from_slice(&picture[line.clone()]));
            // A row that is not full ends with empty places.
            pixels.resize(pixels.len() + (columns - part.len()) * width as usize, [255; 3]);
        }
    }
    Picture { width: width * columns as u32, height: height * rows as u32, pixels }
}
