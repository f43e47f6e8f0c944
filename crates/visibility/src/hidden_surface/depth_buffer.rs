//! Depth buffer: a depth for each pixel, and the nearer face wins (Catmull, "A subdivision algorithm for computer display of
//! curved surfaces", 1974; tiles and depths by increments as in the lecture of chapter 8).
//!
//! A tile is drawn at a time, so memory is that of tiles; a tile may be one scan line. Depths are affine in the pixel: a row needs one
//! product and one sum a pixel, eight pixels at a time (`fill`). Faces come nearest first, and of each row the least nearness of all its pixels is known
//! once all are filled, so a face that is farther all over the row is passed over (the min-max test).
//!
//! Guarantee: two depths are compared as they are only where they differ by more than both their bounds; else the judge decides. Cost:
//! O(faces + covered pixels), memory O(tile) a thread. Curved bodies are asked pixel by pixel in their boxes.

use super::{
    HiddenSurface, Shot, Statistics, Window,
    fill::{self, Run},
    footprint::Plane,
};

/// Depth buffer by tiles.
#[derive(Clone, Copy, Debug)]
pub struct DepthBuffer {
    /// Columns and rows of a tile, both at least 1.
    pub tile: [u32; 2],
}

impl Default for DepthBuffer {
    /// Tiles whose depths stay in the first cache.
    fn default() -> Self {
        Self { tile: [64, 32] }
    }
}

impl HiddenSurface for DepthBuffer {
    fn name(&self) -> &'static str {
        "depth"
    }

    fn window(&self) -> [u32; 2] {
        self.tile
    }

    fn draw(&self, shot: &Shot, window: &Window, faces: &[u32], pixels: &mut [u32]) -> Statistics {
        let mut tile = Tile::new(shot, window, faces, pixels);
        // Nearest first: what follows is likelier to be hidden.
        let mut order = faces.to_vec();
        order.sort_by(|&a, &b| tile.nearest(b).total_cmp(&tile.nearest(a)).then(a.cmp(&b)));
        for face in order {
            tile.draw(face);
        }
        tile.work
    }
}

/// A tile and its depths.
struct Tile<'a> {
    shot: &'a Shot,
    window: &'a Window,
    /// The face of each pixel.
    pixels: &'a mut [u32],
    /// Its nearness, off by `widest` at most; NaN where that is not known, −∞ where there is no face.
    nearness: Vec<f64>,
    /// The greatest of the faces' bounds that are finite.
    widest: f64,
    /// A bound below the nearness of all pixels of a row; `None` where it must be found again.
    floors: Vec<Option<f64>>,
    /// Room for the pixels of a run whose depths are too close to be told apart.
    doubtful: Vec<u32>,
    work: Statistics,
}

impl<'a> Tile<'a> {
    fn new(shot: &'a Shot, window: &'a Window, faces: &[u32], pixels: &'a mut [u32]) -> Self {
        let planes = faces.iter().filter_map(|&face| shot.footprints[face as usize].plane.as_ref());
        let errors = planes.map(|plane| plane.nearness.error).filter(|error| error.is_finite());
        Self {
            shot,
            window,
            nearness: vec![f64::NEG_INFINITY; pixels.len()],
            pixels,
            widest: errors.fold(0.0, f64::max),
            floors: vec![Some(f64::NEG_INFINITY); window.height() as usize],
            doubtful: Vec::new(),
            work: Statistics::default(),
        }
    }

    fn nearest(&self, face: u32) -> f64 {
        self.shot.footprints[face as usize].nearest
    }

    fn draw(&mut self, face: u32) {
        let footprint = &self.shot.footprints[face as usize];
        let part = footprint.window.meet(self.window);
        for row in part.top..part.bottom {
            if self.floor(row) > footprint.nearest {
                self.work.skipped += 1;
                continue;
            }
            self.work.tests += 1;
            let span = footprint.span(&self.shot.frame, row, part.left..part.right);
            let plane = footprint.plane.as_ref().filter(|plane| plane.nearness.error.is_finite());
            for column in (span.outer.start..span.inner.start).chain(span.inner.end..span.outer.end) {
                self.contest(face, [column, row], plane);
            }
            match plane {
                Some(plane) => self.fill(face, plane, row, span.inner),
                None => span.inner.for_each(|column| self.contest(face, [column, row], None)),
            }
        }
    }

    /// Draws a run of pixels that the face covers.
    fn fill(&mut self, face: u32, plane: &Plane, row: u32, columns: std::ops::Range<u32>) {
        if columns.is_empty() {
            return;
        }
        let frame = &self.shot.frame;
        let (start, slope) = (plane.nearness.on_row(frame.y(row)), plane.nearness.x);
        let apart = plane.nearness.error + self.widest;
        let from = self.window.index([columns.start, row]);
        let part = from..from + columns.len();
        let mut doubtful = std::mem::take(&mut self.doubtful);
        let run = Run {
            face,
            start,
            slope,
            x: frame.x(columns.start),
            apart,
            nearness: &mut self.nearness[part.clone()],
            pixels: &mut self.pixels[part],
            doubtful: &mut doubtful,
        };
        let written = run.draw();
        doubtful.drain(..).for_each(|k| self.contest(face, [columns.start + k, row], Some(plane)));
        self.doubtful = doubtful;
        self.work.depths += columns.len() as u64;
        self.work.written += written;
        if written > 0 {
            self.floors[(row - self.window.top) as usize] = None;
        }
    }

    /// A pixel that the face may cover, or whose depths are too close to be told apart.
    fn contest(&mut self, face: u32, pixel: [u32; 2], plane: Option<&Plane>) {
        let index = self.window.index(pixel);
        let before = self.pixels[index];
        self.shot.contest(face, pixel, &mut self.pixels[index], &mut self.work);
        if self.pixels[index] != before {
            let frame = &self.shot.frame;
            self.nearness[index] =
                plane.map_or(f64::NAN, |plane| plane.nearness.at(frame.x(pixel[0]), frame.y(pixel[1])));
            self.floors[(pixel[1] - self.window.top) as usize] = None;
        }
    }

    /// A bound below the nearness of all pixels of a row.
    fn floor(&mut self, row: u32) -> f64 {
        let place = (row - self.window.top) as usize;
        if let Some(floor) = self.floors[place] {
            return floor;
        }
        let width = self.window.width() as usize;
        let line = place * width..(place + 1) * width;
        // A pixel without a face is infinitely far; one of unknown nearness leaves the row open, too.
        let floor = fill::least(&self.nearness[line]) - self.widest;
        self.floors[place] = Some(floor);
        floor
    }
}
