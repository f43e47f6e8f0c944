//! Points against the cells they fall into: lit, in shadow, or in doubt with what causes it.
//!
//! The points of a job are seen and sorted by cell. Then eight points of one cell at a time are compared with the
//! cell's groups, nearest first: one triangle with all points, or one point with all triangles of a group, whichever are fewer.

use umbriel_geometry::{
    decisions::{Level, count},
    simd::{Float, I8, Int, Kernel, Mask, Simd},
};

use crate::loose::{
    grid::Grids,
    group::{Eight, Said, TilePoint},
    seen::{BLOCK, Block, Off, Row},
    sorted::{Buckets, Seen},
    tile::{Entry, PLACE_LIMIT, Tile, cell_along},
};

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
    /// The pieces of each point's own face, first and last, which do not hide it; empty where points have none.
    pub(super) own: &'a [[u32; 2]],
    /// What any coordinate of a slack box differs from the point's by at most.
    pub(super) slack: f64,
    /// Greatest magnitude of a point's coordinates.
    pub(super) size: f64,
    pub(super) lit: &'a mut [bool],
    pub(super) buckets: &'a mut Buckets,
}

impl<T: Row> Kernel for Filter<'_, '_, T> {
    type Output = Vec<Doubtful>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Vec<Doubtful> {
        let Self { grids, rows, own, slack, size, lit, buckets } = self;
        let offs: Vec<Off> = grids.grids.iter().map(|grid| Off::of(grid, slack, size)).collect();
        list(grids, &offs, rows, buckets);
        buckets.sort();
        let mut told = Told { lit, doubtful: Vec::new() };
        let begin = u64::from(grids.begin());
        for (grid, off) in grids.grids.iter().zip(&offs) {
            let places = grid.places();
            let begin = ((begin * places.len() as u64) >> 32) as usize;
            for index in (begin..places.len()).chain(0..begin) {
                let place = places[index];
                let (first, cells) = (place.first as usize, 1 << (2 * place.level));
                if buckets.start(first) < buckets.start(first + cells) {
                    Over { tile: grid.tile(index), buckets, first, off, own }.tell(simd, &mut told);
                }
            }
        }
        let beside = grids.cells as usize;
        let (beside, rough) =
            buckets.points()[buckets.start(beside)..].split_at(buckets.start(beside + 1) - buckets.start(beside));
        beside.iter().for_each(|point| told.lit[point.index as usize] = true);
        told.doubtful.extend(rough.iter().map(|point| Doubtful { index: point.index, pieces: None }));
        count(Level::Single, (rows.len() - told.doubtful.len()) as u64);
        told.doubtful
    }
}

/// Puts all points into buckets: one a cell, one for what lies beside all cells, one for what is too roughly known.
#[inline(always)]
fn list<T: Row>(grids: &Grids, offs: &[Off], rows: &[T], buckets: &mut Buckets) {
    let beside = grids.cells;
    buckets.clear(beside as usize + 2);
    let mut block = Block::EMPTY;
    let (mut keys, mut points) = ([0; BLOCK], [Seen::default(); BLOCK]);
    for (number, rows) in rows.chunks(BLOCK).enumerate() {
        if let [grid] = grids.grids.as_slice() {
            block.see_sun(&grid.view, rows);
            block.locate(|_| (grid, &offs[0]));
        } else {
            block.see_lamp(&grids.grids[0].view, rows);
            block.locate(|view| (&grids.grids[view], &offs[view]));
        }
        for (index, key) in keys.iter_mut().enumerate() {
            let scale = (1u32 << block.level[index]) as f32;
            let [s, t] = [block.s[index], block.t[index]];
            let cell = cell_along(t, scale) << block.level[index] | cell_along(s, scale);
            *key = if block.is_told[index] { block.first[index] + cell } else { beside + 1 };
        }
        for (index, point) in points.iter_mut().enumerate() {
            let [s, t, nearness] = [block.s[index], block.t[index], block.nearness[index] as f32];
            *point = Seen { s, t, nearness, index: (number * BLOCK + index) as u32 };
        }
        buckets.extend(&keys[..rows.len()], &points[..rows.len()]);
    }
}

/// What is found out about the points of a job.
struct Told<'a> {
    lit: &'a mut [bool],
    doubtful: Vec<Doubtful>,
}

/// The points over one tile.
struct Over<'a> {
    tile: &'a Tile,
    buckets: &'a Buckets,
    /// The number of the tile's first cell.
    first: usize,
    off: &'a Off,
    /// As in [`Filter`].
    own: &'a [[u32; 2]],
}

impl Over<'_> {
    /// Tells all of them.
    #[inline(always)]
    fn tell<S: Simd>(&self, simd: S, told: &mut Told) {
        let mut first = self.buckets.start(self.first);
        for cell in 0..1 << (2 * self.tile.level) {
            let end = self.buckets.start(self.first + cell + 1);
            for points in self.buckets.points()[first..end].chunks(8) {
                self.tell_eight(simd, cell, points, told);
            }
            first = end;
        }
    }

    /// Tells up to eight points of one cell.
    #[inline(always)]
    fn tell_eight<S: Simd>(&self, simd: S, cell: usize, seen: &[Seen], told: &mut Told) {
        let points = self.eight(simd, seen);
        let valid = 0xff >> (8 - seen.len());
        let limit = simd.splat8(PLACE_LIMIT / (1u32 << self.tile.level) as f32);
        let known = valid & points.place.le(limit).bits();
        let (covered, entries) = self.tile.list_of(cell);
        let mut open = known & !(points.nearness + points.height).lt(simd.splat8(covered)).bits();
        let front = points.nearness - points.height;
        let mut doubts = 0;
        let own = self.own_of(simd, seen);
        for entry in entries {
            let concerned = open & !front.gt(simd.splat8(entry.nearest)).bits();
            if concerned == 0 {
                break;
            }
            let (hits, unclear) = self.compare(simd, entry, &points, own, concerned, seen);
            open &= !hits;
            doubts |= unclear & concerned;
        }
        doubts &= open;
        for (lane, point) in seen.iter().enumerate() {
            told.lit[point.index as usize] = open >> lane & 1 == 1;
        }
        let mut left = doubts | valid & !known;
        while left != 0 {
            let lane = left.trailing_zeros();
            left &= left - 1;
            let point = &seen[lane as usize % 8];
            let pieces = (known >> lane & 1 == 1).then(|| self.doubts(simd, entries, point));
            told.doubtful.push(Doubtful { index: point.index, pieces });
        }
    }

    /// Which points a group hides and which it leaves in doubt; what it says of points that are not concerned does not matter.
    #[inline(always)]
    fn compare<S: Simd>(
        &self,
        simd: S,
        entry: &Entry,
        points: &Eight<S>,
        own: Option<[I8<S>; 2]>,
        mut concerned: u32,
        seen: &[Seen],
    ) -> (u32, u32) {
        let group = &self.tile.groups[entry.group as usize];
        let (mut hits, mut doubts) = (0, 0);
        if concerned.count_ones() < entry.lanes.count_ones() {
            while concerned != 0 {
                let lane = concerned.trailing_zeros();
                concerned &= concerned - 1;
                match group.test(simd, entry.vague, &self.point(&seen[lane as usize % 8])) {
                    Said::Blocked => hits |= 1 << lane,
                    Said::Doubt(lanes) => {
                        let is_left = self.others(simd, entry.group, lanes, &seen[lane as usize % 8]) != 0;
                        doubts |= u32::from(is_left) << lane;
                    }
                }
            }
        } else {
            let mut lanes = entry.lanes;
            while lanes != 0 && concerned & !hits != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                let (hit, doubt) = group.test_points(simd, lane, entry.vague, points);
                let doubt = if doubt == 0 { 0 } else { doubt & !self.owners(simd, entry.group, lane, own) };
                (hits, doubts) = (hits | hit, doubts | doubt);
            }
        }
        (hits, doubts)
    }

    /// The pieces that a cell's groups cannot tell about.
    #[inline(always)]
    fn doubts<S: Simd>(&self, simd: S, entries: &[Entry], seen: &Seen) -> Vec<u32> {
        let point = self.point(seen);
        let mut pieces = Vec::new();
        for entry in entries {
            if let Said::Doubt(lanes) = self.tile.groups[entry.group as usize].test(simd, entry.vague, &point) {
                let lanes = self.others(simd, entry.group, lanes, seen);
                let numbers = self.tile.pieces[entry.group as usize];
                pieces.extend((0..8).filter(|lane| lanes >> lane & 1 == 1).map(|lane| numbers[lane]));
            }
        }
        pieces
    }

    /// Of these lanes of a group those that are not of the point's own face.
    #[inline(always)]
    fn others<S: Simd>(&self, simd: S, group: u32, lanes: u32, seen: &Seen) -> u32 {
        let Some(&[first, last]) = self.own.get(seen.index as usize) else { return lanes };
        let mut pieces = [0; 8];
        for (piece, &number) in pieces.iter_mut().zip(&self.tile.pieces[group as usize]) {
            *piece = number as i32;
        }
        let pieces = simd.load_int(&pieces);
        let is_own = pieces.eq(simd.splat_int8(first as i32)) | pieces.eq(simd.splat_int8(last as i32));
        lanes & !is_own.bits()
    }

    /// Which points lie on the face that a lane of a group is of.
    #[inline(always)]
    fn owners<S: Simd>(&self, simd: S, group: u32, lane: usize, own: Option<[I8<S>; 2]>) -> u32 {
        let Some([first, last]) = own else { return 0 };
        let piece = simd.splat_int8(self.tile.pieces[group as usize][lane] as i32);
        (piece.eq(first) | piece.eq(last)).bits()
    }

    /// The pieces of the points' own faces, first and last; `None` where points have none.
    #[inline(always)]
    fn own_of<S: Simd>(&self, simd: S, seen: &[Seen]) -> Option<[I8<S>; 2]> {
        if self.own.is_empty() {
            return None;
        }
        let (mut first, mut last) = ([-1; 8], [-1; 8]);
        for (lane, point) in seen.iter().enumerate().take(8) {
            let own = self.own[point.index as usize];
            (first[lane], last[lane]) = (own[0] as i32, own[1] as i32);
        }
        Some([simd.load_int(&first), simd.load_int(&last)])
    }

    #[inline(always)]
    fn point(&self, &Seen { s, t, nearness, .. }: &Seen) -> TilePoint {
        let (place, height) = self.off.at(nearness);
        TilePoint { s, t, nearness, place, height }
    }

    /// Up to eight points; lanes behind the last are of no meaning.
    #[inline(always)]
    fn eight<S: Simd>(&self, simd: S, seen: &[Seen]) -> Eight<S> {
        let (mut s, mut t, mut nearness) = ([0.0; 8], [0.0; 8], [0.0; 8]);
        for (lane, point) in seen.iter().enumerate().take(8) {
            (s[lane], t[lane], nearness[lane]) = (point.s, point.t, point.nearness);
        }
        let (s, t, nearness) = (simd.load(&s), simd.load(&t), simd.load(&nearness));
        let (place, height) = self.off.at_eight(simd, nearness);
        Eight { s, t, nearness, place, height }
    }
}
