//! Boxes of a face's lattice over an area: eight rows by eight columns.
//!
//! In homogeneous light space a point of the face is A + u·(B − A) + v·(D − A). The area's corners, mapped back to (u, v),
//! say which rows and columns may be in it. Places are f64 up to the corner of a box and f32 within it, relative to the
//! area's middle.

use std::ops::Range;

use umbriel_geometry::simd::{F8, Float, M8, Mask, Simd};

use super::{
    pack::{LANES, Samples},
    sampler::Sampler,
    soup::{Area, Receiver},
};
use crate::fine::lattice::Lattice;

/// Rows and columns of a box.
const EDGE: u32 = LANES as u32;

/// A face over an area.
pub(super) struct Boxes {
    lattice: Lattice,
    /// The first sample and the steps of a row and a column: homogeneous, relative to the area's middle, quanta; and the
    /// depth under a sun.
    first: [f64; 4],
    steps: [[f64; 4]; 2],
    is_sun: bool,
    depth_scale: f64,
    ranges: [Range<u32>; 2],
}

/// Some rows and columns.
pub(super) struct LatticeBox {
    pub(super) rows: Range<u32>,
    pub(super) columns: Range<u32>,
}

impl Boxes {
    pub(super) fn new(sampler: &Sampler, receiver: &Receiver, area: &Area, wide: f64) -> Self {
        let view = &sampler.view;
        let corners = sampler.corners(receiver).map(|corner| {
            let [x, y, z] = view.homogeneous(corner);
            let depth = if view.is_sun() { view.depth_of_sun(corner) } else { 0.0 };
            [x - area.center[0] * z, y - area.center[1] * z, z, depth]
        });
        let [a, b, d] = corners;
        let along = [b, d].map(|corner| [0, 1, 2, 3].map(|k| corner[k] - a[k]));
        let flat = [a, along[0], along[1]].map(|[x, y, z, _]| [x, y, z]);
        let lattice = sampler.lattice(receiver).lattice;
        let [u, v] = [0, 1].map(|axis| lattice.coordinate(axis, 0));
        let steps = [0, 1].map(|axis| along[axis].map(|x| x / f64::from(lattice.counts()[axis])));
        Self {
            lattice,
            first: [0, 1, 2, 3].map(|k| a[k] + u * along[0][k] + v * along[1][k]),
            steps,
            is_sun: view.is_sun(),
            depth_scale: view.depth_scale_of_lamp(),
            ranges: find_ranges(&lattice, flat, area.half.map(|half| half + wide)),
        }
    }

    /// The boxes over the area, those that hold a sample at least.
    pub(super) fn iter(&self) -> impl Iterator<Item = LatticeBox> + '_ {
        let [rows, columns] = self.ranges.clone();
        let starts = |range: Range<u32>| range.step_by(EDGE as usize);
        let ends = [rows.end, columns.end];
        starts(rows).flat_map(move |row| {
            let end = ends[1].min(self.lattice.row_len(row));
            starts(columns.start..end.max(columns.start)).map(move |column| LatticeBox {
                rows: row..ends[0].min(row + EDGE),
                columns: column..end.min(column + EDGE),
            })
        })
    }

    /// The place of a sample in homogeneous light space, and its depth under a sun.
    fn place(&self, row: u32, column: u32) -> [f64; 4] {
        let (row, column) = (f64::from(row), f64::from(column));
        [0, 1, 2, 3].map(|k| self.first[k] + row * self.steps[0][k] + column * self.steps[1][k])
    }

    fn sample(&self, [x, y, z, depth]: [f64; 4]) -> Samples<f32> {
        if self.is_sun {
            return Samples { x: x as f32, y: y as f32, depth: depth as f32 };
        }
        Samples { x: (x / z) as f32, y: (y / z) as f32, depth: (-self.depth_scale / z) as f32 }
    }

    /// The hull of a box in the image; `None` where it reaches behind the light.
    pub(super) fn hull(&self, cell: &LatticeBox) -> Option<[Samples<f32>; 4]> {
        let [rows, columns] = [[cell.rows.start, cell.rows.end - 1], [cell.columns.start, cell.columns.end - 1]];
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]| self.place(rows[i], columns[j]));
        corners.iter().all(|corner| corner[2] > 0.0).then(|| corners.map(|corner| self.sample(corner)))
    }

    /// The samples of one row of a box, and which of them are before the light and within `reach` of the area's middle.
    #[inline(always)]
    pub(super) fn row<S: Simd>(
        &self,
        simd: S,
        row: u32,
        columns: &Range<u32>,
        reach: [f32; 2],
    ) -> (Samples<F8<S>>, u32) {
        const STEPS: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        let count = self.row_end(row, columns).saturating_sub(columns.start);
        let (first, last) = (self.place(row, columns.start), self.place(row, columns.end - 1));
        // Counted from the end nearer to the light: roundings are then relative to the distance.
        let is_reversed = last[2] < first[2];
        let (base, sign) = if is_reversed { (last, -1.0) } else { (first, 1.0) };
        let length = (columns.end - columns.start) as f32;
        let away = if is_reversed { simd.splat8(length - 1.0) - simd.load(&STEPS) } else { simd.load(&STEPS) };
        let at = |k: usize| simd.splat8(base[k] as f32) + away * simd.splat8((self.steps[1][k] * sign) as f32);
        let used = (1u32 << count) - 1;
        let (x, y, depth, before): (F8<S>, F8<S>, F8<S>, M8<S>) = if self.is_sun {
            (at(0), at(1), at(3), simd.mask8(0xff))
        } else {
            let z = at(2);
            (at(0) / z, at(1) / z, simd.splat8(-self.depth_scale as f32) / z, z.gt(simd.splat8(0.0)))
        };
        let inside = x.abs().le(simd.splat8(reach[0])) & y.abs().le(simd.splat8(reach[1])) & before;
        (Samples { x, y, depth }, inside.bits() & used)
    }

    /// Where a row of a box ends.
    #[inline]
    pub(super) fn row_end(&self, row: u32, columns: &Range<u32>) -> u32 {
        columns.end.min(self.lattice.row_len(row))
    }

    /// The bit of a sample, counted from the face's first.
    pub(super) fn bit(&self, row: u32, column: u32) -> u64 {
        u64::from(row) * u64::from(self.lattice.counts()[1]) + u64::from(column)
    }
}

/// The rows and columns whose (u, v) lie between those of the area's corners; all where a corner has none.
///
/// `[a, b, d]` are the first corner and the steps to the second and the last: homogeneous, relative to the area's middle.
pub(super) fn find_ranges(lattice: &Lattice, [a, b, d]: [[f64; 3]; 3], half: [f64; 2]) -> [Range<u32>; 2] {
    let counts = lattice.counts();
    let whole = counts.map(|count| 0..count);
    let cross =
        |p: [f64; 3], q: [f64; 3]| [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    let (weight, parameters) = (cross(b, d), [cross(d, a), cross(a, b)]);
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut signs = [false; 2];
    for [sx, sy] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
        let dot = |row: &[f64; 3]| row[0] * sx * half[0] + row[1] * sy * half[1] + row[2];
        let divisor = dot(&weight);
        signs[usize::from(divisor > 0.0)] = true;
        for k in 0..2 {
            let value = dot(&parameters[k]) / divisor;
            (low[k], high[k]) = (low[k].min(value), high[k].max(value));
        }
    }
    if signs == [true, true] || low.iter().chain(&high).any(|value| !value.is_finite()) {
        return whole;
    }
    [0, 1].map(|k| {
        let count = f64::from(counts[k]);
        // One more on either side than the corners say.
        let first = (low[k] * count - 2.0).clamp(0.0, count);
        let end = (high[k] * count + 2.0).clamp(0.0, count);
        first as u32..end as u32
    })
}
