//! The rows of a face's lattice that cross an area.
//!
//! In homogeneous light space a point of the face is A + u·(B − A) + v·(D − A), and "inside the area" is four linear
//! conditions, so on a row (one u) the samples inside are an interval of v. All f64, rounded outward by a part of the area's
//! margin.

use std::ops::Range;

use super::{
    sampler::Sampler,
    soup::{Area, Receiver},
};
use crate::fine::lattice::Lattice;

/// A face over an area.
pub(super) struct Rows {
    lattice: Lattice,
    /// A, B − A, D − A: homogeneous, relative to the area's middle, quanta.
    origin: [f64; 3],
    along: [[f64; 3]; 2],
    /// Half extents of the area with a part of its margin.
    half: [f64; 2],
    range: Range<u32>,
}

/// One row.
pub(super) struct Row {
    /// Index along u.
    pub(super) number: u32,
    /// Indices along v inside the area.
    pub(super) columns: Range<u32>,
    /// Samples in a row of the lattice.
    width: u32,
}

impl Rows {
    /// Finds the rows that may have samples in the area.
    pub(super) fn new(sampler: &Sampler, receiver: &Receiver, area: &Area, wide: f64) -> Self {
        let view = &sampler.view;
        let corners = sampler.corners(receiver);
        let homogeneous = corners.map(|corner| {
            let [x, y, z] = view.homogeneous(corner);
            [x - area.center[0] * z, y - area.center[1] * z, z]
        });
        let [a, b, d] = homogeneous;
        let along = [b, d].map(|corner| [0, 1, 2].map(|k| corner[k] - a[k]));
        let mut rows = Self {
            lattice: sampler.lattice(receiver).lattice,
            origin: a,
            along,
            half: area.half.map(|half| half + 0.5 * wide),
            range: 0..0,
        };
        rows.range = rows.find_range();
        rows
    }

    /// The rows.
    pub(super) fn range(&self) -> Range<u32> {
        self.range.clone()
    }

    /// The rows whose u lies between those of the area's corners, mapped back; all where a corner has no u.
    fn find_range(&self) -> Range<u32> {
        let count = self.lattice.counts()[0];
        if count <= 4 {
            return 0..count;
        }
        let [a, b, d] = [self.origin, self.along[0], self.along[1]];
        let cross = |p: [f64; 3], q: [f64; 3]| {
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        };
        let (weight, u) = (cross(b, d), cross(d, a));
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut signs = [false; 2];
        for (sx, sy) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let place = [sx * self.half[0], sy * self.half[1], 1.0];
            let dot = |row: &[f64; 3]| row[0] * place[0] + row[1] * place[1] + row[2] * place[2];
            let divisor = dot(&weight);
            signs[usize::from(divisor > 0.0)] = true;
            let value = dot(&u) / divisor;
            low = low.min(value);
            high = high.max(value);
        }
        if signs == [true, true] || !low.is_finite() || !high.is_finite() {
            return 0..count;
        }
        let rows = f64::from(count);
        // A row more on either side than the corners say.
        let first = (low * rows - 2.0).floor().clamp(0.0, rows);
        let end = (high * rows + 2.0).ceil().clamp(0.0, rows);
        first as u32..end as u32
    }

    /// The samples of a row inside the area; `None` if there are none.
    pub(super) fn row(&self, number: u32) -> Option<Row> {
        let u = self.lattice.coordinate(0, number);
        let start = [0, 1, 2].map(|k| self.origin[k] + u * self.along[0][k]);
        let step = self.along[1];
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        for k in 0..2 {
            for sign in [-1.0, 1.0] {
                let (value, slope) =
                    (self.half[k] * start[2] + sign * start[k], self.half[k] * step[2] + sign * step[k]);
                if slope > 0.0 {
                    low = low.max(-value / slope);
                } else if slope < 0.0 {
                    high = high.min(-value / slope);
                } else if value < 0.0 {
                    return None;
                }
            }
        }
        if low > high {
            return None;
        }
        let columns = self.lattice.columns_between(number, low, high);
        if columns.is_empty() {
            return None;
        }
        Some(Row { number, columns, width: self.lattice.counts()[1] })
    }
}

impl Row {
    /// The bit of the first sample, counted from the face's first.
    pub(super) fn first_bit(&self) -> u64 {
        u64::from(self.number) * u64::from(self.width) + u64::from(self.columns.start)
    }
}
