//! Hidden surfaces: which face each pixel shows, by several methods that give the same picture.
//!
//! **The picture.** Each pixel has one ray, through its centre: that of [`View::ray`](crate::View::ray), its origin and direction floats that are taken as
//! exact. A pixel shows the face that the ray o + t·d meets at the least t > 0. Faces are closed: a ray through an edge or a corner
//! meets all faces that share it, so nothing leaks. Of several at the same t the one with the lowest object is seen, in it the
//! lowest face. A face whose plane holds the ray is seen edge-on and is not met. All that is decided by signs of
//! the input numbers, never by rounded ones; only the patch of a curved body that a hit is said to lie on is found by rounding.
//!
//! **The methods** differ in how they come by the few faces that may be seen at a pixel, and in what they need not look at:
//!
//! | | |
//! |---|---|
//! | [`DepthBuffer`] | a depth a pixel, nearer wins; tiles, rows passed over by their least nearness |
//! | [`ScanLine`] | the faces of one row of pixels, decided by whole intervals |
//! | [`Warnock`] | windows quartered until one face decides them |
//! | [`RayCasting`] | a ray a pixel through a tree of boxes, or an octree |
//! | [`DepthSort`] | faces in an order of painting, split where there is none |
//!
//! They share the footprints (pixels and depths as affine functions, with bounds), and one judge for what these leave open. A picture
//! is drawn in windows, each by itself, so threads take windows and a picture of any size needs memory for some rows only
//! ([`draw_rows`]).

mod depth_buffer;
mod depth_sort;
mod fill;
mod footprint;
mod frame;
mod judge;
mod picture;
mod ray_caster;
mod scan_line;
mod shot;
mod statistics;
#[cfg(test)]
mod tests;
mod warnock;
mod window;

use std::ops::Range;

use rayon::prelude::*;

pub use depth_buffer::DepthBuffer;
pub use depth_sort::DepthSort;
pub use picture::{FacePicture, Seen};
pub use ray_caster::{RayCasting, RayTree};
pub use scan_line::ScanLine;
pub use shot::{Shot, ShotDefect};
pub use statistics::Statistics;
pub use warnock::Warnock;
pub use window::Window;

use window::{Bins, Grid};

/// What a pixel holds where no face is seen.
pub(crate) const NOTHING: u32 = u32::MAX;

/// A way to find the face that each pixel shows.
pub trait HiddenSurface: Sync {
    /// What it is called.
    fn name(&self) -> &'static str;

    /// The size of the windows that it likes to draw, columns and rows.
    fn window(&self) -> [u32; 2];

    /// Draws one window: the number of the seen face for each of its pixels, row by row, into `pixels`, which hold nothing
    /// yet. `faces` are those that may cover some of its pixels, in ascending order.
    fn draw(&self, shot: &Shot, window: &Window, faces: &[u32], pixels: &mut [u32]) -> Statistics;
}

/// Draws the whole picture. Threads take windows; the result is the same for any number of them.
pub fn draw(method: &dyn HiddenSurface, shot: &Shot) -> (FacePicture, Statistics) {
    draw_rows(method, shot, 0..shot.view().height)
}

/// Draws some rows of the picture: what a picture needs that is too large to be held.
pub fn draw_rows(method: &dyn HiddenSurface, shot: &Shot, rows: Range<u32>) -> (FacePicture, Statistics) {
    let whole = Window { left: 0, top: rows.start, right: shot.view().width, bottom: rows.end.min(shot.view().height) };
    let grid = Grid::new(whole, method.window());
    let bins = Bins::new(&grid, &shot.footprints);
    let draw = |index: usize| {
        let window = grid.window(index);
        let mut pixels = vec![NOTHING; window.area()];
        let mut work = method.draw(shot, &window, bins.of(index), &mut pixels);
        work.windows += 1;
        (window, pixels, work)
    };
    let parts: Vec<(Window, Vec<u32>, Statistics)> = (0..grid.len()).into_par_iter().map(draw).collect();
    let work = parts.iter().map(|(_, _, work)| *work).sum();
    (FacePicture::join(whole, parts.into_iter().map(|(window, pixels, _)| (window, pixels))), work)
}
