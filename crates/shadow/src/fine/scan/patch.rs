//! A part of a face's lattice, up to 32 × 32 samples, as occluders are tested against it.
//!
//! In homogeneous light space the sample in row i and column j of a plane's lattice is first + i·row + j·column; its depth times
//! its third coordinate is linear, too. Small faces find these vectors from the images of their corners, others in f64 from the
//! corners themselves; f32 within a patch, relative to its middle.

use super::{
    axes::Axes,
    faces::{Face, Rect, depths},
    layout::FaceLattice,
    pack::ROUNDOFF,
    view::{Image, View},
};
use crate::fine::lattice::{Lattice, first_bits};

/// Most rows and columns of a patch.
pub(super) const EDGE: u32 = 32;

/// What boxes and depths of samples are widened by, relative; more than what rounding does to them. 2^-18.
pub(super) const WIDER: f32 = 64.0 * ROUNDOFF;

/// x, y, z and depth times z.
type Homogeneous = [f64; 4];

/// The lattice of a face in light space: quanta, z scaled to 1 at most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    first: Homogeneous,
    row: Homogeneous,
    column: Homogeneous,
}

impl Frame {
    /// From the images of the first, next and last corner, all of which the view sees.
    #[inline(always)]
    pub(super) fn of_images(corners: [&Image; 3], lattice: &Lattice, view: &View) -> Self {
        if view.is_sun() {
            let corner = |image: &Image| [f64::from(image.x), f64::from(image.y), 1.0, f64::from(image.depth)];
            return Self::of_corners([corner(corners[0]), corner(corners[1]), corner(corners[2])], lattice);
        }
        let least = corners[0].depth.max(corners[1].depth).max(corners[2].depth);
        let corner = |image: &Image| {
            // Depth is −1/z up to a factor.
            let z = f64::from(least) / f64::from(image.depth);
            [f64::from(image.x) * z, f64::from(image.y) * z, z, f64::from(least)]
        };
        Self::of_corners([corner(corners[0]), corner(corners[1]), corner(corners[2])], lattice)
    }

    /// From homogeneous coordinates.
    #[inline(always)]
    pub(super) fn of_corners([a, b, d]: [Homogeneous; 3], lattice: &Lattice) -> Self {
        let [u, v] = [lattice.coordinate(0, 0), lattice.coordinate(1, 0)];
        // One division for four: an ulp matters nowhere here.
        let [rows, columns] = [1.0 / f64::from(lattice.counts()[0]), 1.0 / f64::from(lattice.counts()[1])];
        let mut frame = Self { first: a, row: [0.0; 4], column: [0.0; 4] };
        for k in 0..4 {
            let along = [b[k] - a[k], d[k] - a[k]];
            frame.first[k] += u * along[0] + v * along[1];
            frame.row[k] = along[0] * rows;
            frame.column[k] = along[1] * columns;
        }
        frame
    }

    /// A sample.
    #[inline(always)]
    pub(super) fn at(&self, row: f64, column: f64) -> Homogeneous {
        let mut sample = self.first;
        for (k, x) in sample.iter_mut().enumerate() {
            *x += row * self.row[k] + column * self.column[k];
        }
        sample
    }
}

/// Samples of one face, and those that nothing is known to block yet.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    pub(super) face: Face,
    /// The convex solid whose faces do not block its samples; −2 for none.
    pub(super) solid: i32,
    /// Its first row and column.
    pub(super) origin: [u32; 2],
    pub(super) rows: u32,
    pub(super) columns: u32,
    /// What coordinates are relative to.
    pub(super) center: [i32; 2],
    /// First sample, step of a row, step of a column.
    pub(super) x: [f32; 3],
    pub(super) y: [f32; 3],
    pub(super) z: [f32; 3],
    /// Depth beyond the middle one, times z.
    pub(super) depth: [f32; 3],
    pub(super) middle: f32,
    /// The largest coordinate of a sample.
    pub(super) reach: f32,
    /// Holds the images of all samples.
    pub(super) rect: Rect,
    pub(super) nearest: f32,
    pub(super) farthest: f32,
    pub(super) axes: Axes,
    /// A bit a sample, a word a row.
    pub(super) open: [i32; EDGE as usize],
}

/// Where a patch lies in the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) rect: Rect,
    /// The least and the greatest depth.
    pub(super) depths: [f32; 2],
}

impl Extent {
    pub(super) const EMPTY: Self = Self { rect: Rect::EMPTY, depths: [f32::INFINITY, f32::NEG_INFINITY] };

    /// What holds both.
    #[inline(always)]
    pub(super) fn union(&self, other: &Self) -> Self {
        let [[near, far], [other_near, other_far]] = [self.depths, other.depths];
        Self { rect: self.rect.union(&other.rect), depths: [near.min(other_near), far.max(other_far)] }
    }

    #[inline(always)]
    pub(super) fn of_images(images: &[Image]) -> Self {
        Self { rect: Rect::of(images), depths: depths(images) }
    }

    /// Of the patch `rows` × `columns` from `origin` on, within the extent of its face; all of that where a corner of
    /// the patch has no image.
    #[inline(always)]
    fn of_part(frame: &Frame, origin: [u32; 2], [rows, columns]: [u32; 2], whole: &Self) -> Self {
        let [row, column] = origin.map(f64::from);
        let ends = [row + f64::from(rows - 1), column + f64::from(columns - 1)];
        let mut extent = Self::EMPTY;
        for [row, column] in [[row, column], [ends[0], column], [row, ends[1]], ends] {
            let [x, y, z, depth] = frame.at(row, column);
            if z <= 0.0 {
                return *whole;
            }
            // A quantum more for roundings; casts saturate.
            let [x, y, depth] = [x / z, y / z, depth / z];
            let rect = Rect {
                min: [x, y].map(|x| (x.floor() as i32).saturating_sub(1)),
                max: [x, y].map(|x| (x.ceil() as i32).saturating_add(1)),
            };
            extent = extent.union(&Self { rect, depths: [depth as f32; 2] });
        }
        extent.rect = extent.rect.intersection(&whole.rect);
        extent
    }
}

impl Patch {
    /// All of a face that the view sees as a whole, with `open` samples.
    #[inline(always)]
    pub(super) fn whole(face: Face, frame: &Frame, extent: &Extent, lattice: &FaceLattice, wide: f32) -> Self {
        let [rows, columns] = lattice.lattice.counts();
        let triangle = lattice.lattice.small_rows();
        let mut open = [0; EDGE as usize];
        match triangle {
            Some(triangle) => open[..rows as usize].copy_from_slice(&triangle.words),
            None => open[..rows as usize].fill(first_bits(columns)),
        }
        let mut patch = Self::new((face, [0, 0]), frame, extent, [rows, columns], open);
        match triangle {
            Some(triangle) => patch.bound_triangle(triangle.reach, wide),
            None => patch.bound_rectangle(wide),
        }
        patch
    }

    /// Makes the extent that of the samples, which lie in the hull of the given ones; what the patch's own
    /// vectors say of them is off by less than 2^-18 of its reach and of its range of depths.
    #[inline(always)]
    fn tighten(&mut self, hull: &[[f32; 3]]) {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for corner in hull {
            for k in 0..3 {
                low[k] = low[k].min(corner[k]);
                high[k] = high[k].max(corner[k]);
            }
        }
        let margin = self.margin();
        let depth_margin = (self.farthest - self.nearest) * WIDER;
        for k in 0..2 {
            self.rect.min[k] = self.rect.min[k].max(self.center[k].saturating_add((low[k] - margin) as i32));
            self.rect.max[k] = self.rect.max[k].min(self.center[k].saturating_add((high[k] + margin) as i32));
        }
        self.nearest = self.nearest.max(self.middle + low[2] - depth_margin);
        self.farthest = self.farthest.min(self.middle + high[2] + depth_margin);
    }

    /// What the patch's vectors say of the images of samples is off by less than this, quanta.
    #[inline(always)]
    fn margin(&self) -> f32 {
        self.reach * WIDER + 2.0
    }

    /// Image and depth at a row and a column, relative to the patch's middle; what is not before the light has none.
    #[inline(always)]
    fn at(&self, row: f32, column: f32) -> Option<[f32; 3]> {
        let at = |vector: &[f32; 3]| vector[0] + row * vector[1] + column * vector[2];
        let z = at(&self.z);
        let inverse = 1.0 / z;
        (z > 0.0).then(|| [at(&self.x) * inverse, at(&self.y) * inverse, at(&self.depth) * inverse])
    }

    /// Which way rows and columns go in the image at its first sample.
    #[inline(always)]
    fn sides(&self, first: &[f32; 3]) -> [[f32; 2]; 2] {
        [1, 2].map(|k| [self.x[k] - first[0] * self.z[k], self.y[k] - first[1] * self.z[k]])
    }

    /// Bounds the samples of a whole triangle: in units of the lattice they lie up to `reach` from the first corner.
    #[inline(always)]
    fn bound_triangle(&mut self, reach: f32, wide: f32) {
        let (rows, columns) = (self.rows as f32, self.columns as f32);
        let corners = [self.at(0.0, 0.0), self.at(reach * rows, 0.0), self.at(0.0, reach * columns)];
        let [Some(a), Some(b), Some(c)] = corners else { return };
        let hull = [a, b, c];
        self.tighten(&hull);
        let [row, column] = self.sides(&a);
        let third = [0, 1].map(|k| rows * row[k] - columns * column[k]);
        self.axes = Axes::across(&[row, column, third], &hull, self.margin() + wide);
    }

    /// Bounds the samples by the corners of all rows and columns.
    #[inline(always)]
    fn bound_rectangle(&mut self, wide: f32) {
        let ends = [(self.rows - 1) as f32, (self.columns - 1) as f32];
        let corners = [self.at(0.0, 0.0), self.at(ends[0], 0.0), self.at(0.0, ends[1]), self.at(ends[0], ends[1])];
        let [Some(a), Some(b), Some(c), Some(d)] = corners else { return };
        let hull = [a, b, c, d];
        self.tighten(&hull);
        self.axes = Axes::across(&self.sides(&a), &hull, self.margin() + wide);
    }

    /// The patch from `origin` on of a face with extent `whole`; `None` if it holds no samples, or none in the window of a
    /// `view` that does not see all of the face.
    #[inline(always)]
    pub(super) fn part(
        (face, origin): (Face, [u32; 2]),
        frame: &Frame,
        whole: &Extent,
        lattice: &Lattice,
        view: Option<&View>,
    ) -> Option<Self> {
        let counts = lattice.counts();
        let size = [0, 1].map(|k| (counts[k] - origin[k]).min(EDGE));
        let extent = Extent::of_part(frame, origin, size, whole);
        let is_beside = view.is_some_and(|view| !view.meets(&extent.rect));
        if extent.rect.is_empty() || is_beside {
            return None;
        }
        let columns = |row: u32| lattice.row_len(origin[0] + row).saturating_sub(origin[1]).min(size[1]);
        let mut open = [0; EDGE as usize];
        // Rows do not get longer.
        if columns(size[0] - 1) == size[1] {
            open[..size[0] as usize].fill(first_bits(size[1]));
        } else {
            (0..size[0]).for_each(|row| open[row as usize] = first_bits(columns(row)));
        }
        if let Some(view) = view.filter(|view| !view.holds(&extent.rect)) {
            keep_seen(&mut open, frame, origin, view);
        }
        (open != [0; EDGE as usize]).then(|| Self::new((face, origin), frame, &extent, size, open))
    }

    #[inline(always)]
    fn new(
        (face, origin): (Face, [u32; 2]),
        frame: &Frame,
        extent: &Extent,
        [rows, columns]: [u32; 2],
        open: [i32; EDGE as usize],
    ) -> Self {
        let center = extent.rect.center();
        let [nearest, farthest] = extent.depths;
        let middle = if (farthest - nearest).is_finite() { 0.5 * (nearest + farthest) } else { 0.0 };
        let first = frame.at(f64::from(origin[0]), f64::from(origin[1]));
        let vectors = [first, frame.row, frame.column];
        let mut patch = Self {
            face,
            solid: -2,
            origin,
            rows,
            columns,
            center,
            x: [0.0; 3],
            y: [0.0; 3],
            z: [0.0; 3],
            depth: [0.0; 3],
            middle,
            reach: 0.0,
            rect: extent.rect,
            nearest,
            farthest,
            axes: Axes::NONE,
            open,
        };
        for (k, vector) in vectors.iter().enumerate() {
            patch.x[k] = (vector[0] - f64::from(center[0]) * vector[2]) as f32;
            patch.y[k] = (vector[1] - f64::from(center[1]) * vector[2]) as f32;
            patch.z[k] = vector[2] as f32;
            patch.depth[k] = (vector[3] - f64::from(middle) * vector[2]) as f32;
        }
        let reach = |values: &[f32; 3]| {
            values[0].abs() + (rows - 1) as f32 * values[1].abs() + (columns - 1) as f32 * values[2].abs()
        };
        patch.reach = reach(&patch.x).max(reach(&patch.y));
        patch
    }

    /// How many samples are open.
    #[inline(always)]
    pub(super) fn count_open(&self) -> u32 {
        self.open[..self.rows as usize].iter().map(|row| row.count_ones()).sum()
    }

    /// Whether no sample is open.
    #[inline(always)]
    pub(super) fn is_done(&self) -> bool {
        self.open[..self.rows as usize].iter().fold(0, |all, row| all | row) == 0
    }
}

/// Leaves open what lies in the window or just beside it: the next view takes the same samples again.
fn keep_seen(open: &mut [i32; EDGE as usize], frame: &Frame, origin: [u32; 2], view: &View) {
    let half = view.half.map(|half| half + 8.0 * view.error + 2.0);
    for (row, open) in open.iter_mut().enumerate() {
        for column in 0..EDGE {
            let [x, y, z, _] = frame.at(f64::from(origin[0]) + row as f64, f64::from(origin[1] + column));
            if !(z > 0.0 && x.abs() <= half[0] * z && y.abs() <= half[1] * z) {
                *open &= !(1 << column);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fine::lattice::Spacing;

    #[test]
    fn words_hold_every_sample_once() {
        for edges in [[1.0, 1.0], [1.0, 5.0], [16.0, 16.0], [7.0, 32.0], [32.0, 32.0]] {
            let lattice = Lattice::new(edges, Spacing::AtMost(1.0), true);
            let words = &lattice.small_rows().expect("it is small").words;
            let samples: u32 = words.iter().map(|row| row.count_ones()).sum();
            let rows = 0..lattice.counts()[0];
            assert_eq!(samples, rows.map(|row| lattice.row_len(row)).sum::<u32>());
        }
        assert_eq!([0, 1, 31, 32].map(first_bits), [0, 1, i32::MAX, -1]);
    }
}
