//! Where a light sees points, and how far that may be off.

use glam::DVec3;
use umbriel_geometry::{
    Aabb,
    simd::{Float, Lanes},
};

use crate::{
    light_space::View,
    loose::{
        grid::{Grid, Grids, TilePlace},
        group::NEARNESS_MARGIN,
        tile::HEIGHT_LIMIT,
    },
};

/// Unit roundoff of f64.
const ROUNDOFF: f64 = f64::EPSILON / 2.0;
/// Points of a block.
pub(super) const BLOCK: usize = 64;

/// A row that begins with coordinates.
pub(super) trait Row {
    fn position(&self) -> [f64; 3];
}

impl<const N: usize> Row for [f32; N] {
    #[inline(always)]
    fn position(&self) -> [f64; 3] {
        [f64::from(self[0]), f64::from(self[1]), f64::from(self[2])]
    }
}

impl<const N: usize> Row for [f64; N] {
    #[inline(always)]
    fn position(&self) -> [f64; 3] {
        [self[0], self[1], self[2]]
    }
}

/// Points as a view sees them; `view` says which. Column by column, so that eight points are one vector.
pub(super) struct Block {
    u: [f64; BLOCK],
    v: [f64; BLOCK],
    pub(super) nearness: [f64; BLOCK],
    view: [u32; BLOCK],
    /// Where in their tiles.
    pub(super) s: [f32; BLOCK],
    pub(super) t: [f32; BLOCK],
    tile: [u32; BLOCK],
    /// The tiles' cells: the first one's number, and how many there are along each side.
    pub(super) first: [u32; BLOCK],
    pub(super) side: [u32; BLOCK],
    /// Whether they are known well enough for tiles.
    pub(super) is_told: [bool; BLOCK],
}

impl Block {
    pub(super) const EMPTY: Self = Self {
        u: [0.0; BLOCK],
        v: [0.0; BLOCK],
        nearness: [0.0; BLOCK],
        view: [0; BLOCK],
        s: [0.0; BLOCK],
        t: [0.0; BLOCK],
        tile: [0; BLOCK],
        first: [0; BLOCK],
        side: [1; BLOCK],
        is_told: [false; BLOCK],
    };

    /// Finds the tiles; `offs` is what points are off by in each view.
    ///
    /// All points are placed in one view after the other, of which neighbours need one or two: what is the same for all of them stays in registers, and the loop becomes vectors.
    #[inline(always)]
    pub(super) fn locate(&mut self, grids: &Grids, offs: &[Off]) {
        let views = self.view.iter().fold(0u32, |views, view| views | 1 << view);
        for (view, (grid, &off)) in (0..).zip(grids.grids.iter().zip(offs)) {
            if views >> view & 1 == 0 {
                continue;
            }
            let tiling = grid.tiling;
            for index in 0..BLOCK {
                let is_here = self.view[index] == view;
                let (tile, [s, t]) = tiling.locate(self.u[index], self.v[index]);
                let is_told = off.is_told(self.nearness[index] as f32);
                self.tile[index] = if is_here { tile } else { self.tile[index] };
                self.s[index] = if is_here { s } else { self.s[index] };
                self.t[index] = if is_here { t } else { self.t[index] };
                self.is_told[index] = if is_here { is_told } else { self.is_told[index] };
            }
        }
        for index in 0..BLOCK {
            let TilePlace { first, side } = grids.place(self.tile[index]);
            (self.first[index], self.side[index]) = (first, side);
        }
    }

    /// u, v and nearness of the first points.
    #[inline(always)]
    pub(super) fn columns(&self, count: usize) -> [&[f64]; 3] {
        [&self.u[..count], &self.v[..count], &self.nearness[..count]]
    }

    /// Their views.
    #[inline(always)]
    pub(super) fn views(&self, count: usize) -> &[u32] {
        &self.view[..count]
    }

    #[inline(always)]
    pub(super) fn see_sun<T: Row>(&mut self, view: &View, rows: &[T]) {
        for (index, row) in rows.iter().enumerate() {
            let seen = view.see(DVec3::from_array(row.position()));
            (self.u[index], self.v[index], self.nearness[index]) = (seen.x, seen.y, seen.h);
        }
    }

    /// The views of a lamp come in the order +x, −x, +y, and so on. `view` is any of them.
    #[inline(always)]
    pub(super) fn see_lamp<T: Row>(&mut self, view: &View, rows: &[T]) {
        let (lamp, scale) = (view.origin(), view.nearness_scale());
        for (index, row) in rows.iter().enumerate() {
            let [x, y, z] = (DVec3::from_array(row.position()) - lamp).to_array();
            let (a, b, c) = (x.abs(), y.abs(), z.abs());
            let (is_x, is_y) = ((a >= b) & (a >= c), b >= c);
            let (along, u, v, axis) = if is_x {
                (x, y, z, 0)
            } else if is_y {
                (y, z, x, 2)
            } else {
                (z, x, y, 4)
            };
            let inverse = 1.0 / along.abs();
            self.u[index] = u * inverse;
            self.v[index] = v * inverse;
            self.nearness[index] = scale * inverse;
            self.view[index] = axis + u32::from(along < 0.0);
        }
    }
}

/// What points are off by in one view: bounds, rounded up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Off {
    /// Place in half tiles: fixed, and times the nearness.
    place: [f32; 2],
    /// Nearness: fixed, and times the nearness squared.
    height: [f32; 2],
    /// What nearness counts from: 1 for a sun, 0 for a lamp.
    unit: f32,
}

/// Points that are off by more, in half tiles, are not known well enough for tiles: half of what lies beside all pieces.
const PLACE_TOLD: f32 = 1.0 / 32.0;

/// More than what the roundings of [`Off::at`] and of the nearness itself take away: ten of 2^-24 at most.
const UPWARD: f32 = 1.0 + 1.0 / (1u32 << 20) as f32;

/// What points in a view are off by, in its own units: fixed, and by their nearness.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointError {
    /// u and v: fixed, and times the nearness.
    place: [f64; 2],
    /// Nearness: fixed, and times the nearness squared.
    nearness: [f64; 2],
}

impl PointError {
    /// `bounds` holds the scene; the points' coordinates are off by `slack` and no greater than `size`.
    ///
    /// With e = slack and f = the error of [`View::see`]: a sun's u is off by 2e + f and the rounding of its offset from a corner, less than 2f more; its
    /// nearness by e + f. A lamp's u, |u| ≤ 17/16, is off by (e + f)·(1 + |u|)/(w − e − f) and its nearness h/w by n·(e + f)/(w − e − f), where (e + f)/w is
    /// below 1/16.
    pub(super) fn of(view: &View, bounds: &Aabb, slack: f64, size: f64) -> Self {
        let error = view.error(0.0, size.max(bounds.magnitude()) + view.origin().abs().max_element());
        if view.is_sun() {
            let nearness = (slack + error) * view.nearness_scale();
            return Self { place: [2.0 * slack + 4.0 * error, 0.0], nearness: [nearness, 0.0] };
        }
        let off = (slack + error) / view.nearness_scale();
        Self { place: [16.0 * ROUNDOFF, 2.5 * off], nearness: [0.0, 1.25 * off] }
    }

    /// What place and nearness of a point are off by, a few roundings aside; `None` where (e + f)/w is too large to say.
    pub(super) fn at(&self, nearness: f64) -> Option<[f64; 2]> {
        let [place, by_nearness] = self.place;
        let by_nearness = by_nearness * nearness;
        let off = self.nearness[0] + self.nearness[1] * nearness * nearness;
        (by_nearness < 1.0 / 16.0).then_some([place + by_nearness, off])
    }
}

impl Off {
    /// As [`PointError`] has it; what it asks of lamps is so where [`PLACE_LIMIT`] holds.
    ///
    /// [`PLACE_LIMIT`]: crate::loose::tile::PLACE_LIMIT
    pub(super) fn of(grid: &Grid, slack: f64, size: f64) -> Self {
        let error = PointError::of(&grid.view, &grid.pieces.bounds, slack, size);
        let half = 2.0 * grid.tiling.density;
        let up = |bound: f64| if bound == 0.0 { 0.0 } else { (bound as f32).next_up() };
        Self { place: error.place.map(|off| up(half * off)), height: error.nearness.map(up), unit: grid.view.unit() }
    }

    /// What a point of this nearness is off by: place, and height with its [`NEARNESS_MARGIN`].
    #[inline(always)]
    pub(super) fn at(&self, nearness: f32) -> (f32, f32) {
        let ([place, place_by], [height, height_by]) = (self.place, self.height);
        let size = nearness.abs() + self.unit;
        let height = (height + (height_by * nearness) * nearness) + size * NEARNESS_MARGIN;
        ((place + place_by * nearness) * UPWARD, height * UPWARD + f32::MIN_POSITIVE)
    }

    /// [`Off::at`] of `N` points.
    #[inline(always)]
    pub(super) fn at_lanes<S: Lanes<N>, const N: usize>(&self, simd: S, nearness: S::Float) -> (S::Float, S::Float) {
        let ([place, place_by], [height, height_by]) = (self.place, self.height);
        let size = nearness.abs() + simd.splat(self.unit);
        let height =
            (simd.splat(height) + (simd.splat(height_by) * nearness) * nearness) + size * simd.splat(NEARNESS_MARGIN);
        let place = simd.splat(place) + simd.splat(place_by) * nearness;
        (place * simd.splat(UPWARD), height * simd.splat(UPWARD) + simd.splat(f32::MIN_POSITIVE))
    }

    /// Whether a point of this nearness is known well enough for tiles. Not so for NaN.
    #[inline(always)]
    pub(super) fn is_told(&self, nearness: f32) -> bool {
        let (place, height) = self.at(nearness);
        (place < PLACE_TOLD) & (height < HEIGHT_LIMIT * (nearness.abs() + self.unit))
    }
}
