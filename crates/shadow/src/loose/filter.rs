//! Points against the cells they fall into: lit, in shadow, or in doubt with what causes it.
//!
//! The points of a job are seen and sorted by cell. Then eight or sixteen points of one cell at a time are compared with the
//! cell's groups, nearest first: one triangle with all points, or one point with all triangles of a group, whichever are fewer.

use umbriel_geometry::{
    decisions::{Level, count},
    simd::{Float, Int, Kernel, Lanes, Mask, Simd},
};

use crate::loose::{
    grid::{Grids, TilePlace},
    group::{Said, TilePoint, TilePoints},
    on_faces::LEFT_OUT,
    seen::{BLOCK, Block, Off, Row},
    sorted::{BATCH, Buckets, Seen},
    tile::{Cell, Entry, PLACE_LIMIT, Tile, cell_along},
};

/// A point that the filter cannot tell.
pub(super) struct Doubtful {
    pub(super) index: u32,
    /// The faces, by their first pieces, that may stand in its way or meet its slack box; `None` when the point is too roughly known to say.
    pub(super) faces: Option<Vec<u32>>,
}

/// The points of a part of the input.
pub(super) struct Filter<'a, 'b, T> {
    pub(super) grids: &'a Grids<'b>,
    /// Rows that begin with x, y, z.
    pub(super) rows: &'a [T],
    /// Each point's own face, by its first piece, which does not hide it, or [`LEFT_OUT`]; empty where points have none.
    pub(super) own: &'a [i32],
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
            let places = grids.places_of(grid);
            let begin = ((begin * places.len() as u64) >> 32) as usize;
            for index in (begin..places.len()).chain(0..begin) {
                let place = places[index];
                if buckets.start(place.first as usize) < buckets.start((place.first + place.cells()) as usize) {
                    Over { tile: grid.tile(index), place, buckets, off, own }.tell(simd, &mut told);
                }
            }
        }
        let [beside, rough] = [grids.cells, grids.cells + 1].map(|bucket| buckets.of(bucket as usize));
        beside.iter().for_each(|point| told.lit[point.index as usize] = true);
        told.doubtful.extend(rough.iter().map(|point| Doubtful { index: point.index, faces: None }));
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
        match grids.grids.as_slice() {
            [grid] => block.see_sun(&grid.view, rows),
            views => block.see_lamp(&views[0].view, rows),
        }
        block.locate(grids, offs);
        for (index, key) in keys.iter_mut().enumerate() {
            let side = block.side[index];
            let [s, t] = [block.s[index], block.t[index]];
            let cell = cell_along(t, side as f32) * side + cell_along(s, side as f32);
            *key = if block.is_told[index] { block.first[index] + cell } else { beside + 1 };
        }
        for (index, point) in points.iter_mut().enumerate() {
            let [s, t, nearness] = [block.s[index], block.t[index], block.nearness[index] as f32];
            *point = Seen { s, t, nearness, index: (number * BLOCK + index) as u32 };
        }
        buckets.extend(&keys, &points, rows.len());
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
    /// The tile's cells.
    place: TilePlace,
    buckets: &'a Buckets,
    off: &'a Off,
    /// As in [`Filter`].
    own: &'a [i32],
}

/// Up to `N` points of one cell, a lane each; lanes behind the last are of no meaning.
struct Batch<'a, S: Lanes<N>, const N: usize> {
    seen: &'a [Seen; N],
    points: TilePoints<S, N>,
    /// The points' own faces; `None` where points have none.
    own: Option<S::Int>,
}

impl Over<'_> {
    /// Tells all of them: sixteen of a cell at a time, and where no more than eight are left, those.
    #[inline(always)]
    fn tell<S: Simd>(&self, simd: S, told: &mut Told) {
        let begin = self.place.first as usize;
        let mut first = self.buckets.start(begin);
        for cell in 0..self.place.cells() as usize {
            let end = self.buckets.start(begin + cell + 1);
            while first < end {
                match end - first {
                    count @ ..=8 => self.tell_some::<S, 8>(simd, cell, self.buckets.batch(first), count, told),
                    count => self.tell_some::<S, BATCH>(simd, cell, self.buckets.batch(first), count.min(BATCH), told),
                }
                first += BATCH.min(end - first);
            }
        }
    }

    /// Tells the first `count` of `N` points, which are of one cell.
    #[inline(always)]
    fn tell_some<S: Simd + Lanes<N>, const N: usize>(
        &self,
        simd: S,
        cell: usize,
        seen: &[Seen; N],
        count: usize,
        told: &mut Told,
    ) {
        let batch = self.batch::<S, N>(simd, seen);
        let points = &batch.points;
        let valid = u32::MAX >> (32 - count);
        let limit = Lanes::<N>::splat(simd, PLACE_LIMIT / self.place.side as f32);
        let known = valid & points.place.le(limit).bits();
        let (Cell { covered, surface, .. }, entries) = self.tile.list_of(cell);
        let mut open = known & !(points.nearness + points.height).lt(Lanes::<N>::splat(simd, covered)).bits();
        let front = points.nearness - points.height;
        let on_surface = match batch.own {
            // A face that is left out is not of the sheet.
            Some(own) => {
                Lanes::<N>::splat(simd, surface).le(front).bits()
                    & !own.eq(Lanes::<N>::splat_int(simd, LEFT_OUT)).bits()
            }
            None => 0,
        };
        let mut doubts = 0;
        for entry in entries {
            let concerned = open & !on_surface & !front.gt(Lanes::<N>::splat(simd, entry.nearest)).bits();
            if concerned == 0 {
                break;
            }
            let (hits, unclear) = self.compare(simd, entry, &batch, concerned);
            open &= !hits;
            doubts |= unclear & concerned;
        }
        doubts &= open;
        for (lane, point) in seen.iter().enumerate().take(count) {
            told.lit[point.index as usize] = open >> lane & 1 == 1;
        }
        let mut left = doubts | valid & !known;
        while left != 0 {
            let lane = left.trailing_zeros();
            left &= left - 1;
            let point = &seen[lane as usize % N];
            let faces = (known >> lane & 1 == 1).then(|| self.doubts(simd, entries, point));
            told.doubtful.push(Doubtful { index: point.index, faces });
        }
    }

    /// Which points a group hides and which it leaves in doubt; what it says of points that are not concerned does not matter.
    #[inline(always)]
    fn compare<S: Simd + Lanes<N>, const N: usize>(
        &self,
        simd: S,
        entry: &Entry,
        batch: &Batch<S, N>,
        mut concerned: u32,
    ) -> (u32, u32) {
        let group = &self.tile.groups[entry.group as usize];
        let (mut hits, mut doubts) = (0, 0);
        if concerned.count_ones() < entry.lanes.count_ones() {
            while concerned != 0 {
                let lane = concerned.trailing_zeros();
                concerned &= concerned - 1;
                let seen = &batch.seen[lane as usize % N];
                match group.test(simd, entry.vague, &self.point(seen)) {
                    Said::Blocked => hits |= 1 << lane,
                    Said::Doubt(lanes) => {
                        let is_left = self.others(simd, entry.group, lanes, seen) != 0;
                        doubts |= u32::from(is_left) << lane;
                    }
                }
            }
        } else {
            let mut lanes = entry.lanes;
            while lanes != 0 && concerned & !hits != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                let (hit, clear) = group.test_points(simd, lane, entry.vague, &batch.points);
                let doubt = concerned & !(hit | clear);
                let doubt = if doubt == 0 { 0 } else { doubt & !self.owners(simd, entry.group, lane, batch) };
                (hits, doubts) = (hits | hit, doubts | doubt);
            }
        }
        (hits, doubts)
    }

    /// The faces that a cell's groups cannot tell about.
    #[inline(always)]
    fn doubts<S: Simd>(&self, simd: S, entries: &[Entry], seen: &Seen) -> Vec<u32> {
        let point = self.point(seen);
        let mut faces = Vec::new();
        for entry in entries {
            if let Said::Doubt(lanes) = self.tile.groups[entry.group as usize].test(simd, entry.vague, &point) {
                let lanes = self.others(simd, entry.group, lanes, seen);
                let numbers = self.tile.faces[entry.group as usize];
                faces.extend((0..8).filter(|lane| lanes >> lane & 1 == 1).map(|lane| numbers[lane] as u32));
            }
        }
        faces
    }

    /// Of these lanes of a group those that are not of the point's own face.
    #[inline(always)]
    fn others<S: Simd>(&self, simd: S, group: u32, lanes: u32, seen: &Seen) -> u32 {
        let Some(&own) = self.own.get(seen.index as usize) else { return lanes };
        let is_own = simd.load_int(&self.tile.faces[group as usize]).eq(simd.splat_int8(own));
        lanes & !is_own.bits()
    }

    /// Which points lie on the face that a lane of a group is of.
    #[inline(always)]
    fn owners<S: Lanes<N>, const N: usize>(&self, simd: S, group: u32, lane: usize, batch: &Batch<S, N>) -> u32 {
        let Some(own) = batch.own else { return 0 };
        own.eq(simd.splat_int(self.tile.faces[group as usize][lane])).bits()
    }

    #[inline(always)]
    fn point(&self, &Seen { s, t, nearness, .. }: &Seen) -> TilePoint {
        let (place, height) = self.off.at(nearness);
        TilePoint { s, t, nearness, place, height }
    }

    #[inline(always)]
    fn batch<'s, S: Lanes<N>, const N: usize>(&self, simd: S, seen: &'s [Seen; N]) -> Batch<'s, S, N> {
        let (mut s, mut t, mut nearness) = ([0.0; N], [0.0; N], [0.0; N]);
        for (lane, point) in seen.iter().enumerate() {
            (s[lane], t[lane], nearness[lane]) = (point.s, point.t, point.nearness);
        }
        let (s, t, nearness) = (simd.load(&s), simd.load(&t), simd.load(&nearness));
        let (place, height) = self.off.at_lanes(simd, nearness);
        Batch { seen, points: TilePoints { s, t, nearness, place, height }, own: self.own_of(simd, seen) }
    }

    #[inline(always)]
    fn own_of<S: Lanes<N>, const N: usize>(&self, simd: S, seen: &[Seen; N]) -> Option<S::Int> {
        if self.own.is_empty() {
            return None;
        }
        let mut own = [-1; N];
        for (own, point) in own.iter_mut().zip(seen) {
            *own = self.own[point.index as usize];
        }
        Some(simd.load_int(&own))
    }
}
