//! Points against the cells they fall into: lit, in shadow, or in doubt with what causes it.

use glam::DVec3;
use umbriel_geometry::simd::{Kernel, Simd};

use crate::{
    light_space::{Homogeneous, View},
    loose::{
        grid::Grid,
        group::{CellPoint, NEARNESS_MARGIN, Said},
        tile::{HEIGHT_LIMIT, PLACE_LIMIT},
    },
};

/// Unit roundoff of f64.
const ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// Pieces in doubt that are kept for one point.
const MOST_DOUBTS: usize = 24;

/// All views of a light.
pub(super) struct Grids<'a> {
    pub(super) grids: Vec<Grid<'a>>,
}

/// A point that the filter cannot tell, and what may stand in its way or meet its slack box.
pub(super) struct Doubtful {
    pub(super) index: u32,
    /// `None`: too many, or the point is too roughly known.
    pub(super) pieces: Option<Vec<u32>>,
}

/// What the filter says of one point.
enum Verdict {
    Lit,
    Shadowed,
    Doubtful,
}

/// The pieces in doubt about one point.
struct Doubts {
    pieces: [u32; MOST_DOUBTS],
    count: usize,
}

impl Doubts {
    /// False when there is no more room.
    #[inline(always)]
    fn add(&mut self, pieces: &[u32; 8], mut lanes: u32) -> bool {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            if self.count == MOST_DOUBTS {
                return false;
            }
            self.pieces[self.count] = pieces[lane];
            self.count += 1;
            lanes &= lanes - 1;
        }
        true
    }
}

/// The points of a part of the input.
pub(super) struct Filter<'a, 'b, P> {
    pub(super) grids: &'a Grids<'b>,
    pub(super) points: P,
    /// What any coordinate of a slack box differs from the point's by at most.
    pub(super) slack: f64,
    /// Greatest magnitude of a point's coordinates.
    pub(super) size: f64,
    pub(super) lit: &'a mut [bool],
}

impl<P: Iterator<Item = DVec3>> Kernel for Filter<'_, '_, P> {
    type Output = Vec<Doubtful>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Vec<Doubtful> {
        let off: Vec<Off> = self.grids.grids.iter().map(|grid| Off::of(grid, self.slack, self.size)).collect();
        let mut doubtful = Vec::new();
        let mut doubts = Doubts { pieces: [0; MOST_DOUBTS], count: 0 };
        for (index, (point, lit)) in self.points.zip(self.lit).enumerate() {
            let view = self.grids.view_of(point);
            let verdict = judge(simd, &self.grids.grids[view], &off[view], point, &mut doubts);
            *lit = matches!(verdict, Verdict::Lit);
            if let Verdict::Doubtful = verdict {
                let pieces = (doubts.count <= MOST_DOUBTS).then(|| doubts.pieces[..doubts.count].to_vec());
                doubtful.push(Doubtful { index: index as u32, pieces });
            }
        }
        doubtful
    }
}

impl Grids<'_> {
    /// The view that sees a point.
    #[inline(always)]
    fn view_of(&self, point: DVec3) -> usize {
        if self.grids.len() == 1 {
            return 0;
        }
        let away = point - self.grids[0].view.origin();
        let size = away.abs();
        let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
        2 * axis + usize::from(away[axis] < 0.0)
    }
}

/// What points are off by in one view.
struct Off {
    /// Place in half tiles: fixed, and times 1/w.
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
            place: [half * 16.0 * ROUNDOFF, half * 2.5 * off],
            height: [0.0, 1.25 * off / view.nearness_scale()],
            unit: 0.0,
        }
    }
}

/// Finds a point's cell and asks its groups.
#[inline(always)]
fn judge<S: Simd>(simd: S, grid: &Grid, off: &Off, point: DVec3, doubts: &mut Doubts) -> Verdict {
    let seen = grid.view.see(point);
    let inverse = 1.0 / seen.w;
    let [u, v] = grid.locate(&seen, inverse);
    let nearness = seen.h * inverse;
    let place = off.place[0] + off.place[1] * inverse;
    let height = off.height[0] + off.height[1] * nearness * nearness;
    doubts.count = MOST_DOUBTS + 1;
    // Not so for NaN.
    if !(place < 0.25) {
        return Verdict::Doubtful;
    }
    let Some((tile, [s, t])) = grid.tile(u, v) else { return Verdict::Lit };
    let nearness = nearness as f32;
    let height = (height as f32) + nearness.abs() * NEARNESS_MARGIN + f32::MIN_POSITIVE;
    let scale = f64::from(1u32 << tile.level);
    let place = (place * scale) as f32;
    if !(place < PLACE_LIMIT && height < HEIGHT_LIMIT * (nearness.abs() + off.unit)) {
        return Verdict::Doubtful;
    }
    // Which cell of the tile, and where in it.
    let (s, t) = (s * scale, t * scale);
    let (column, row) = (s as u32, t as u32);
    let index = (row << tile.level | column) as usize;
    let cell = &tile.cells[index];
    if nearness + height < cell.covered {
        return Verdict::Shadowed;
    }
    let local = |place: f64, cell: u32| ((place - f64::from(cell)) * 2.0 - 1.0) as f32;
    let point = CellPoint { s: local(s, column), t: local(t, row), nearness, place, height };
    doubts.count = 0;
    let mut is_full = false;
    for group in &tile.groups[cell.first as usize..tile.cells[index + 1].first as usize] {
        if group.nearest < nearness - height {
            break;
        }
        match group.test(simd, &point) {
            Said::Blocked => return Verdict::Shadowed,
            Said::Doubt(lanes) => is_full |= !doubts.add(&group.pieces, lanes),
        }
    }
    if is_full {
        doubts.count = MOST_DOUBTS + 1;
    }
    if doubts.count == 0 { Verdict::Lit } else { Verdict::Doubtful }
}
