//! Points against the cells they fall into: lit, in shadow, or in doubt with what causes it.
//!
//! A block of points goes through three steps, so that the processor fetches the lists of many points at once: where each is
//! seen; which cell that is, and what its list begins with; the groups of the list.

use glam::DVec3;
use umbriel_geometry::{
    decisions::{Level, count},
    simd::{Kernel, Simd},
};

use crate::loose::{
    grid::Grid,
    group::{Bounds, Eight, NEARNESS_MARGIN, Said, TilePoint},
    tile::{Entry, HEIGHT_LIMIT, PLACE_LIMIT, Tile},
};

/// Unit roundoff of f64.
const ROUNDOFF: f64 = f64::EPSILON / 2.0;
/// Points of a block.
const BLOCK: usize = 64;

/// All views of a light.
pub(super) struct Grids<'a> {
    pub(super) grids: Vec<Grid<'a>>,
}

/// A point that the filter cannot tell.
pub(super) struct Doubtful {
    pub(super) index: u32,
    /// What may stand in its way or meet its slack box; `None` when the point is too roughly known to say.
    pub(super) pieces: Option<Vec<u32>>,
}

/// The points of a part of the input.
pub(super) struct Filter<'a, 'b, T> {
    pub(super) grids: &'a Grids<'b>,
    /// Rows that begin with x, y, z.
    pub(super) rows: &'a [T],
    /// What any coordinate of a slack box differs from the point's by at most.
    pub(super) slack: f64,
    /// Greatest magnitude of a point's coordinates.
    pub(super) size: f64,
    pub(super) lit: &'a mut [bool],
}

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

impl<T: Row> Kernel for Filter<'_, '_, T> {
    type Output = Vec<Doubtful>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Vec<Doubtful> {
        let grids = &self.grids.grids;
        let off: Vec<Off> = grids.iter().map(|grid| Off::of(grid, self.slack, self.size)).collect();
        let mut doubtful = Vec::new();
        let mut block = Block::EMPTY;
        for (number, (rows, lit)) in self.rows.chunks(BLOCK).zip(self.lit.chunks_mut(BLOCK)).enumerate() {
            match grids.as_slice() {
                [grid] => block.see_sun(grid, rows),
                grids => block.see_lamp(&grids[0], rows),
            }
            let mut single = u64::MAX >> (BLOCK - rows.len());
            for part in 0..rows.len() / 8 {
                let from = 8 * part;
                let view = block.view[from] as usize;
                if let Some(told) = tell_eight(simd, &grids[view], &off[view], &block, from) {
                    for (k, lit) in lit[from..from + 8].iter_mut().enumerate() {
                        *lit = told.lit >> k & 1 == 1;
                    }
                    single &= !(u64::from(0xff & !told.doubtful) << from);
                }
            }
            while single != 0 {
                let index = single.trailing_zeros() as usize;
                single &= single - 1;
                let view = block.view[index] as usize;
                match tell_one(simd, &grids[view], &off[view], &block, index) {
                    Told::Lit => lit[index] = true,
                    Told::Shadowed => lit[index] = false,
                    Told::Doubtful(pieces) => {
                        doubtful.push(Doubtful { index: (number * BLOCK + index) as u32, pieces });
                    }
                }
            }
        }
        count(Level::Single, (self.rows.len() - doubtful.len()) as u64);
        doubtful
    }
}

/// Points as a view sees them; `view` says which.
struct Block {
    u: [f64; BLOCK],
    v: [f64; BLOCK],
    nearness: [f64; BLOCK],
    view: [u8; BLOCK],
}

impl Block {
    const EMPTY: Self = Self { u: [0.0; BLOCK], v: [0.0; BLOCK], nearness: [0.0; BLOCK], view: [0; BLOCK] };

    #[inline(always)]
    fn see_sun<T: Row>(&mut self, grid: &Grid, rows: &[T]) {
        for (index, row) in rows.iter().enumerate() {
            let seen = grid.view.see(DVec3::from_array(row.position()));
            (self.u[index], self.v[index], self.nearness[index]) = (seen.x, seen.y, seen.h);
        }
    }

    /// The views of a lamp come in the order +x, −x, +y, and so on. `grid` is any of them.
    #[inline(always)]
    fn see_lamp<T: Row>(&mut self, grid: &Grid, rows: &[T]) {
        let (lamp, scale) = (grid.view.origin(), grid.view.nearness_scale());
        for (index, row) in rows.iter().enumerate() {
            let [x, y, z] = (DVec3::from_array(row.position()) - lamp).to_array();
            let (a, b, c) = (x.abs(), y.abs(), z.abs());
            let (is_x, is_y) = (a >= b && a >= c, b >= c);
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
            self.view[index] = axis + u8::from(along < 0.0);
        }
    }
}

/// What points are off by in one view.
struct Off {
    /// Place in half tiles: fixed, and times the nearness.
    place: [f64; 2],
    /// Nearness: fixed, and times the nearness squared.
    height: [f64; 2],
    /// What nearness counts from.
    unit: f32,
}

impl Off {
    /// With e = slack and f = the error of [`View::see`]: a sun's u is off by 2e + f and the rounding of its offset from the
    /// corner, less than 2f more; its nearness by e + f. A lamp's u, |u| ≤ 17/16, is off by (e + f)·(1 + |u|)/(w − e − f) and
    /// its nearness h/w by n·(e + f)/(w − e − f); (e + f)/w is below 1/16 where [`PLACE_LIMIT`] holds.
    ///
    /// [`View::see`]: crate::light_space::View::see
    fn of(grid: &Grid, slack: f64, size: f64) -> Self {
        let view = &grid.view;
        let error = view.error(size);
        let half = 2.0 * grid.density;
        if view.is_sun() {
            let place = half * (2.0 * slack + 4.0 * error);
            return Self { place: [place, 0.0], height: [(slack + error) * view.nearness_scale(), 0.0], unit: 1.0 };
        }
        let off = slack + error;
        Self {
            place: [half * 16.0 * ROUNDOFF, half * 2.5 * off / view.nearness_scale()],
            height: [0.0, 1.25 * off / view.nearness_scale()],
            unit: 0.0,
        }
    }
}

impl Off {
    /// What a point of this nearness is off by, place and height; `None` for one that is too roughly known for cells.
    #[inline(always)]
    fn at(&self, nearness: f64) -> Option<(f32, f32)> {
        let place = self.place[0] + self.place[1] * nearness;
        let size = nearness.abs() as f32 + self.unit;
        let height = (self.height[0] + self.height[1] * nearness * nearness) as f32 + size * NEARNESS_MARGIN;
        // Not so for NaN.
        let is_told = place < 0.25 && height < HEIGHT_LIMIT * size;
        is_told.then_some((place as f32, height + f32::MIN_POSITIVE))
    }
}

/// What the filter says of one point.
enum Told {
    Lit,
    Shadowed,
    Doubtful(Option<Vec<u32>>),
}

/// One point: its cell, and the groups of the cell until one hides the point or the rest is farther.
#[inline(always)]
fn tell_one<S: Simd>(simd: S, grid: &Grid, off: &Off, block: &Block, index: usize) -> Told {
    let nearness = block.nearness[index];
    let Some((place, height)) = off.at(nearness) else { return Told::Doubtful(None) };
    let Some((tile, [s, t])) = grid.tile(block.u[index], block.v[index]) else { return Told::Lit };
    let nearness = nearness as f32;
    let scale = (1u32 << tile.level) as f32;
    if place * scale > PLACE_LIMIT {
        return Told::Doubtful(None);
    }
    // Casts to i32 are the cheapest; numbers are small and not negative.
    let (column, row) = ((s * f64::from(scale)) as i32 as usize, (t * f64::from(scale)) as i32 as usize);
    let (covered, entries) = tile.list_of(row << tile.level | column);
    if nearness + height < covered {
        return Told::Shadowed;
    }
    let point = TilePoint { s: (2.0 * s - 1.0) as f32, t: (2.0 * t - 1.0) as f32, nearness, place, height };
    let mut is_doubtful = false;
    for entry in entries {
        if entry.nearest < nearness - height {
            break;
        }
        match tile.groups[entry.group as usize].test(simd, &point) {
            Said::Blocked => return Told::Shadowed,
            Said::Doubt(lanes) => is_doubtful |= lanes != 0,
        }
    }
    if is_doubtful { Told::Doubtful(Some(doubts(simd, tile, entries, &point))) } else { Told::Lit }
}

/// The pieces that a point's groups cannot tell about.
fn doubts<S: Simd>(simd: S, tile: &Tile, entries: &[Entry], point: &TilePoint) -> Vec<u32> {
    let mut pieces = Vec::new();
    for entry in entries {
        if let Said::Doubt(lanes) = tile.groups[entry.group as usize].test(simd, point) {
            let of_group = &tile.pieces[entry.group as usize];
            pieces.extend((0..8).filter(|lane| lanes >> lane & 1 == 1).map(|lane| of_group[lane]));
        }
    }
    pieces
}

/// What the filter says of eight points, a bit each.
struct ToldEight {
    lit: u32,
    doubtful: u32,
}

/// Eight points of one tile and of a few cells.
struct Together<'a> {
    tile: &'a Tile,
    points: Eight,
    bounds: Bounds,
    columns: [usize; 2],
    rows: [usize; 2],
}

/// Eight points at once, if they lie together. What holds them all is compared with the groups; only triangles that this
/// leaves open are compared with the points.
#[inline(always)]
fn tell_eight<S: Simd>(simd: S, grid: &Grid, off: &Off, block: &Block, from: usize) -> Option<ToldEight> {
    let together = together(grid, off, block, from)?;
    let Together { tile, bounds, columns, rows, .. } = &together;
    let mut covered = f32::INFINITY;
    for row in rows[0]..=rows[1] {
        for column in columns[0]..=columns[1] {
            covered = covered.min(tile.cells[row << tile.level | column].covered);
        }
    }
    if bounds.nearness[1] + bounds.height < covered {
        return Some(ToldEight { lit: 0, doubtful: 0 });
    }
    let (mut blocked, mut doubtful) = (0, 0);
    for row in rows[0]..=rows[1] {
        for column in columns[0]..=columns[1] {
            let cell = row << tile.level | column;
            let (hit, doubt) = compare(simd, &together, tile.list_of(cell).1, blocked);
            (blocked, doubtful) = (blocked | hit, doubtful | doubt);
        }
    }
    doubtful &= !blocked;
    Some(ToldEight { lit: !blocked & !doubtful & 0xff, doubtful })
}

/// Which of the points one list hides, beside those that are `blocked`, and which it leaves in doubt.
#[inline(always)]
fn compare<S: Simd>(simd: S, together: &Together, entries: &[Entry], mut blocked: u32) -> (u32, u32) {
    let Together { tile, points, bounds, .. } = together;
    let mut doubtful = 0;
    for entry in entries {
        if entry.nearest < bounds.nearness[0] - bounds.height || blocked == 0xff {
            break;
        }
        let group = &tile.groups[entry.group as usize];
        let Said::Doubt(mut lanes) = group.test_block(simd, bounds) else { return (0xff, 0) };
        while lanes != 0 && blocked != 0xff {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let (hit, doubt) = group.test_points(simd, lane, points, bounds);
            (blocked, doubtful) = (blocked | hit, doubtful | doubt);
        }
    }
    (blocked, doubtful)
}

/// Where eight points lie; `None` if they are strewn or too roughly known.
#[inline(always)]
fn together<'a>(grid: &'a Grid, off: &Off, block: &Block, from: usize) -> Option<Together<'a>> {
    let views = &block.view[from..from + 8];
    if views.iter().any(|view| *view != views[0]) {
        return None;
    }
    let (tile, origin) = grid.tile_of(block.u[from], block.v[from])?;
    let mut points = Eight { s: [0.0; 8], t: [0.0; 8], nearness: [0.0; 8] };
    for k in 0..8 {
        let [s, t] = grid.place(block.u[from + k], block.v[from + k], origin);
        points.s[k] = (2.0 * s - 1.0) as f32;
        points.t[k] = (2.0 * t - 1.0) as f32;
        points.nearness[k] = block.nearness[from + k] as f32;
    }
    let [low, high] = range(points.nearness);
    let ([s0, s1], [t0, t1]) = (range(points.s), range(points.t));
    // The greatest size has the greatest margins; the least must allow them.
    let (place, height) = off.at(f64::from(low.abs().max(high.abs())))?;
    let least_size = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
    let scale = (1u32 << tile.level) as f32;
    let is_inside = s0 >= -1.0 && t0 >= -1.0 && s1 < 1.0 && t1 < 1.0;
    if !is_inside || place * scale > PLACE_LIMIT || height > HEIGHT_LIMIT * (least_size + off.unit) {
        return None;
    }
    let (columns, rows) = ([s0, s1].map(|s| cell_index(s, scale)), [t0, t1].map(|t| cell_index(t, scale)));
    if (columns[1] - columns[0] + 1) * (rows[1] - rows[0] + 1) > MOST_CELLS {
        return None;
    }
    let (middle, half) = ([(s0 + s1) * 0.5, (t0 + t1) * 0.5], [half_width(s0, s1), half_width(t0, t1)]);
    let bounds = Bounds { middle, half, nearness: [low, high], place, height };
    Some(Together { tile, points, bounds, columns, rows })
}

/// Eight points look into this many cells at most.
const MOST_CELLS: usize = 4;

/// Least and greatest.
#[inline(always)]
fn range([a, b, c, d, e, f, g, h]: [f32; 8]) -> [f32; 2] {
    let low = [lesser(a, b), lesser(c, d), lesser(e, f), lesser(g, h)];
    let high = [lesser(-a, -b), lesser(-c, -d), lesser(-e, -f), lesser(-g, -h)];
    let least = |[a, b, c, d]: [f32; 4]| lesser(lesser(a, b), lesser(c, d));
    [least(low), -least(high)]
}

/// One instruction where `f32::min` looks for NaN, which is refused with its point.
#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Which cell of a tile, along one side.
#[inline(always)]
fn cell_index(place: f32, scale: f32) -> usize {
    ((place + 1.0) * 0.5 * scale) as i32 as usize
}

/// Half the distance and more: differences of numbers below one are off by less than epsilon.
#[inline(always)]
fn half_width(low: f32, high: f32) -> f32 {
    (high - low) * 0.5 + 2.0 * f32::EPSILON
}
