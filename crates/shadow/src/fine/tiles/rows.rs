//! The rows of a face's lattice that cross an area.
//!
//! In homogeneous light space a point of the face is A + u·(B − A) + v·(D − A), and "inside the area" is four linear
//! conditions, so on a row (one u) the samples inside are an interval of v. All f64, rounded outward by a part of the area's
//! margin.

use std::ops::Range;

use super::{
    boxes::find_ranges,
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
        let lattice = sampler.lattice(receiver).lattice;
        let half = area.half.map(|half| half + 0.5 * wide);
        let [range, _] = find_ranges(&lattice, [a, along[0], along[1]], half);
        Self { lattice, origin: a, along, half, range }
    }

    /// The rows.
    pub(super) fn range(&self) -> Range<u32> {
        self.range.clone()
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
