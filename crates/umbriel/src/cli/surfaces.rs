//! `umbriel render --method`: the picture by the methods of hidden surfaces, and what each of them did.
//!
//! The faces of a picture with more pixels, `--aa` along each edge of a pixel, are found band by band, shaded, and averaged; only
//! one band of faces is held.

use std::{
    ops::Range,
    time::{Duration, Instant},
};

use glam::DVec3;
use rayon::prelude::*;
use umbriel_io::write::Picture;
use umbriel_scene::Scene;
use umbriel_shadow::Progress;
use umbriel_visibility::{
    RayCaster, View,
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
        side_by_side::{self, Captioned},
        table,
    },
    progress::Bar,
};

/// Samples of a band: some tens of megabytes with all that is kept of them.
const BAND: u32 = 1 << 22;

/// What a picture is drawn from.
pub(crate) struct Canvas<'a> {
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

/// A picture in the making by one method, or the same by all of them.
pub(crate) struct Drawing<'a> {
    canvas: Canvas<'a>,
    shot: &'a Shot,
    methods: Vec<Box<dyn HiddenSurface>>,
    rows: Vec<Row>,
}

impl<'a> Canvas<'a> {
    /// The faces that may be seen, of some objects of a scene.
    pub(crate) fn shot(&self, scene: &Scene, objects: &[usize]) -> Result<Shot, Failure> {
        let fine =
            View { width: self.view.width * self.subpixels, height: self.view.height * self.subpixels, ..self.view };
        Shot::of_objects(scene, objects, &fine).map_err(|defect| Failure::Unusable(defect.to_string()))
    }

    /// Ready to draw a shot of this canvas.
    pub(crate) fn begin(self, shot: &'a Shot, method: SurfaceMethod) -> Drawing<'a> {
        let methods = methods(method, shot);
        let rows = methods.iter().map(|method| Row::new(method.as_ref())).collect();
        Drawing { canvas: self, shot, methods, rows }
    }

    /// Rows of pixels that are drawn at once: no square of pixels whose rays are cast together is cut.
    pub(crate) fn band(&self) -> u32 {
        (BAND / self.view.width / (self.subpixels * self.subpixels)).max(1).next_multiple_of(RayCaster::SQUARE)
    }
}

impl Drawing<'_> {
    /// Some rows of pixels by each method.
    pub(crate) fn draw(&mut self, rows: Range<u32>) -> Result<Vec<Vec<[u8; 3]>>, Failure> {
        let Canvas { view, subpixels, bar, .. } = &self.canvas;
        if bar.is_cancelled() {
            return Err(Failure::Interrupted);
        }
        let mut pixels: Vec<Vec<[u8; 3]>> = Vec::with_capacity(self.methods.len());
        let mut known: Option<FacePicture> = None;
        for (method, row) in self.methods.iter().zip(&mut self.rows) {
            let start = Instant::now();
            let (faces, work) = draw_rows(method.as_ref(), self.shot, rows.start * subpixels..rows.end * subpixels);
            row.time += start.elapsed();
            row.work += work;
            let differing = known.as_ref().map_or(0, |other| faces.differences(other));
            row.differing += differing;
            // The same faces have the same colours.
            let colors = match pixels.first() {
                Some(first) if differing == 0 => first.clone(),
                _ => self.canvas.colors(self.shot, &faces, rows.clone()),
            };
            pixels.push(colors);
            known.get_or_insert(faces);
        }
        bar.advance("picture", u64::from(rows.end), u64::from(view.height));
        Ok(pixels)
    }

    /// The whole picture; those of several methods side by side.
    pub(crate) fn whole(&mut self) -> Result<Picture, Failure> {
        let View { width, height, .. } = self.canvas.view;
        let mut pixels: Vec<Vec<[u8; 3]>> = vec![Vec::new(); self.methods.len()];
        let band = self.canvas.band();
        for first in (0..height).step_by(band as usize) {
            let parts = self.draw(first..(first + band).min(height))?;
            pixels.iter_mut().zip(parts).for_each(|(pixels, part)| pixels.extend(part));
        }
        if pixels.len() == 1 {
            return Ok(Picture { width, height, pixels: pixels.remove(0) });
        }
        let captioned = |(pixels, row): (Vec<[u8; 3]>, &Row)| Captioned { pixels, caption: row.caption() };
        let pictures: Vec<Captioned> = pixels.into_iter().zip(&self.rows).map(captioned).collect();
        Ok(side_by_side::join([width, height], &pictures))
    }

    /// What the methods did, to standard output.
    pub(crate) fn tell(&self) -> Result<(), Failure> {
        output::print(&text(self.shot, &self.rows))
    }
}

impl Canvas<'_> {
    /// Some rows of pixels, each the mean of its samples.
    fn colors(&self, shot: &Shot, faces: &FacePicture, rows: Range<u32>) -> Vec<[u8; 3]> {
        let n = self.subpixels;
        let eye = shot.rays();
        let sample = |column: u32, row: u32| match faces.hit(shot, [column, row]) {
            Some(hit) => self.studio.surface(&hit, &eye.through(f64::from(column) + 0.5, f64::from(row) + 0.5)),
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

    /// Its name and its counts; not its time, so that the same picture has the same caption.
    fn caption(&self) -> Vec<String> {
        let Statistics { windows, tests, depths, skipped, written, divided, judged } = self.work;
        vec![
            self.name.to_owned(),
            format!("windows {windows}, tests {tests}, depths {depths}"),
            format!("skipped {skipped}, written {written}, divided {divided}, judged {judged}"),
        ]
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
