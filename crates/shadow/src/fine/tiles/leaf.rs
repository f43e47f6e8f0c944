//! A part of the window with few occluders: its samples, decided.
//!
//! Occluders come front to back, in packs of eight. A face with few samples takes them one by one against the packs; a
//! face with many goes along the rows of its lattice, eight samples at a time against the occluders whose boxes meet
//! it. A face that no occluder may reach is lit without looking at its samples. What the filter leaves in doubt is decided
//! exactly, after it has tried everything else.

use umbriel_geometry::simd::{F8, Float, Kernel, Mask, Simd, dispatch};

use super::{
    boxes::Boxes,
    corners::Corners,
    pack::{Pack, Samples},
    pattern::{Block, blocks},
    rows::Rows,
    sampler::Sampler,
    soup::{Area, Occluder, Receiver, margin},
};

/// Samples up to which a face takes them one by one.
const FEW_SAMPLES: u64 = 4;

/// Storage that leaves share.
#[derive(Default)]
pub(super) struct Leaf {
    packs: Vec<Pack>,
    /// Occluders (pack, lane) that may block some sample of a face.
    candidates: Vec<(u32, u32)>,
    doubts: Vec<u32>,
    /// Occluders that some of eight samples are in doubt about, and which samples.
    doubtful: Vec<(u32, u32)>,
}

/// Occluders and receivers: all of a tile, and the numbers of those that matter.
type Chosen<'a, T> = (&'a [T], &'a [u32]);

impl Leaf {
    /// Decides the samples of these receivers in an area; all that may block one is among these occluders.
    pub(super) fn run(
        &mut self,
        sampler: &Sampler,
        area: &Area,
        occluders: Chosen<Occluder>,
        receivers: Chosen<Receiver>,
    ) {
        Pack::fill(&mut self.packs, occluders.0, occluders.1, area, &sampler.view);
        let wide = margin(area.half.map(|half| 2.0 * half), &sampler.view);
        let work = Work {
            sampler,
            area,
            occluders: occluders.0,
            packs: &self.packs,
            candidates: &mut self.candidates,
            doubts: &mut self.doubts,
            doubtful: &mut self.doubtful,
            receivers,
            wide,
        };
        dispatch(work);
    }
}

struct Work<'a, 'b> {
    sampler: &'a Sampler<'b>,
    area: &'a Area,
    occluders: &'a [Occluder],
    packs: &'a [Pack],
    candidates: &'a mut Vec<(u32, u32)>,
    doubts: &'a mut Vec<u32>,
    doubtful: &'a mut Vec<(u32, u32)>,
    receivers: Chosen<'a, Receiver>,
    /// How far the area looks beyond its border.
    wide: f64,
}

impl Kernel for Work<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let (pool, items) = self.receivers;
        for &item in items {
            let receiver = &pool[item as usize];
            let lattice = self.sampler.lattice(receiver);
            if !receiver.is_small(self.area, self.sampler.view.is_sun()) {
                self.many(simd, receiver);
            } else if lattice.lattice.len_at_most() <= FEW_SAMPLES {
                self.few(simd, receiver);
            } else if let Some(blocks) = blocks(&lattice.lattice) {
                self.blocks(simd, receiver, blocks);
            } else {
                self.many(simd, receiver);
            }
        }
    }
}

impl Work<'_, '_> {
    /// The samples of a small face, one by one.
    #[inline(always)]
    fn few<S: Simd>(&mut self, simd: S, receiver: &Receiver) {
        let lattice = self.sampler.lattice(receiver);
        let first = self.sampler.first_bit(receiver);
        let reach = [0, 1].map(|k| (self.area.half[k] + self.wide) as f32);
        let corners = Corners::new(receiver, lattice.corner, self.area, self.sampler.view.is_sun());
        let [rows, columns] = lattice.lattice.counts();
        let mut lit = 0u64;
        for row in 0..rows {
            for column in 0..lattice.lattice.row_len(row) {
                let sample =
                    corners.at(lattice.lattice.coordinate(0, row) as f32, lattice.lattice.coordinate(1, column) as f32);
                if sample.x.abs() > reach[0] || sample.y.abs() > reach[1] {
                    continue;
                }
                if !self.is_blocked(simd, receiver, &sample, [row, column]) {
                    lit |= 1 << (row * columns + column);
                }
            }
        }
        self.sampler.set_lit(receiver, first, lit);
    }

    #[inline(always)]
    fn is_blocked<S: Simd>(&mut self, simd: S, receiver: &Receiver, sample: &Samples<f32>, place: [u32; 2]) -> bool {
        let beyond = sample.depth + self.sampler.depth_slack(sample.depth);
        self.doubts.clear();
        for pack in self.packs {
            if pack.least > beyond {
                break;
            }
            let outcome = pack.test_one(simd, sample, self.sampler.view.depth_error);
            if outcome.blocked.any() {
                return true;
            }
            let mut doubtful = outcome.doubtful.bits();
            while doubtful != 0 {
                let item = pack.items[doubtful.trailing_zeros() as usize];
                if !self.sampler.is_own(receiver, &self.occluders[item as usize]) {
                    self.doubts.push(item);
                }
                doubtful &= doubtful - 1;
            }
        }
        if self.doubts.is_empty() && self.sampler.unbounded.is_empty() {
            return false;
        }
        self.sampler.settle(receiver, place, self.doubts.iter().map(|&item| &self.occluders[item as usize]))
    }

    /// The samples of a face whose lattice is kept as blocks.
    #[inline(always)]
    fn blocks<S: Simd>(&mut self, simd: S, receiver: &Receiver, blocks: &[Block]) {
        let lattice = self.sampler.lattice(receiver);
        let corners = Corners::new(receiver, lattice.corner, self.area, self.sampler.view.is_sun());
        let [u, v] = [0, 1].map(|axis| lattice.lattice.coordinate(axis, 0) as f32);
        let far = if lattice.lattice.is_triangle() { [1.0 - v, 1.0 - u] } else { [1.0 - u, 1.0 - v] };
        let opposite = if lattice.lattice.is_triangle() { [u, far[1]] } else { far };
        let hull = [[u, v], [far[0], v], opposite, [u, far[1]]].map(|[u, v]| corners.at(u, v));
        let (low, high) = receiver.overlap(self.area, self.wide);
        if low[0] > high[0] || low[1] > high[1] || self.is_hidden(simd, Some(&hull), (low, high), receiver.depths[1]) {
            return;
        }
        let first = self.sampler.first_bit(receiver);
        let columns = lattice.lattice.counts()[1];
        let reach = [0, 1].map(|k| simd.splat8((self.area.half[k] + self.wide) as f32));
        for block in blocks {
            let samples = corners.at_eight(simd, simd.load(&block.u), simd.load(&block.v));
            let inside = samples.x.abs().le(reach[0]) & samples.y.abs().le(reach[1]);
            let asked = inside.bits() & block.used;
            if asked == 0 {
                continue;
            }
            let place = |lane: u32| block.places[lane as usize].map(u32::from);
            let mut lit = self.lit(simd, receiver, &samples, asked, place);
            while lit != 0 {
                // A run of lanes in one row is a run of bits.
                let lane = lit.trailing_zeros();
                let [row, column] = place(lane);
                let run = (lit >> lane).trailing_ones().min(lattice.lattice.row_len(row) - column);
                self.sampler.set_lit(receiver, first + u64::from(row * columns + column), (1 << run) - 1);
                lit &= !(((1 << run) - 1) << lane);
            }
        }
    }

    /// Finds the occluders that may block a point of a hull, given its box and its greatest depth; `true` if one blocks
    /// all of it.
    #[inline(always)]
    fn is_hidden<S: Simd>(
        &mut self,
        simd: S,
        hull: Option<&[Samples<f32>; 4]>,
        (low, high): ([f32; 2], [f32; 2]),
        farthest: f32,
    ) -> bool {
        self.candidates.clear();
        let beyond = farthest + self.sampler.depth_slack(farthest);
        for (number, pack) in self.packs.iter().enumerate() {
            if pack.least > beyond {
                break;
            }
            let mut lanes = pack.overlapping(simd, low, high, beyond);
            if lanes == 0 {
                continue;
            }
            if let Some(hull) = hull {
                let hold = pack.test_hull(simd, hull, self.sampler.view.depth_error);
                if hold.covered & lanes != 0 {
                    return true;
                }
                lanes &= !hold.missed;
            }
            while lanes != 0 {
                self.candidates.push((number as u32, lanes.trailing_zeros()));
                lanes &= lanes - 1;
            }
        }
        false
    }

    /// The samples of a large face: by rows where nothing may block, else box by box.
    #[inline(always)]
    fn many<S: Simd>(&mut self, simd: S, receiver: &Receiver) {
        let (low, high) = receiver.overlap(self.area, self.wide);
        if low[0] > high[0] || low[1] > high[1] {
            return;
        }
        let first = self.sampler.first_bit(receiver);
        if self.packs.is_empty() && self.sampler.unbounded.is_empty() {
            let rows = Rows::new(self.sampler, receiver, self.area, self.wide);
            for row in rows.range() {
                let Some(row) = rows.row(row) else { continue };
                self.sampler.fill_lit(receiver, first + row.first_bit(), row.columns.len() as u64);
            }
            return;
        }
        let reach = [0, 1].map(|k| (self.area.half[k] + self.wide) as f32);
        let boxes = Boxes::new(self.sampler, receiver, self.area, self.wide);
        for cell in boxes.iter() {
            let hull = boxes.hull(&cell);
            let (low, high, farthest) = match &hull {
                Some(hull) => bounds(hull),
                None => (reach.map(|reach| -reach), reach, f32::INFINITY),
            };
            let is_outside = (0..2).any(|k| low[k] > reach[k] || high[k] < -reach[k]);
            if is_outside || self.is_hidden(simd, hull.as_ref(), (low, high), farthest) {
                continue;
            }
            let is_inside = hull.is_some() && (0..2).all(|k| low[k] > -reach[k] && high[k] < reach[k]);
            if is_inside && self.candidates.is_empty() && self.sampler.unbounded.is_empty() {
                for row in cell.rows.clone() {
                    let count = boxes.row_end(row, &cell.columns).saturating_sub(cell.columns.start);
                    self.sampler.set_lit(receiver, first + boxes.bit(row, cell.columns.start), (1 << count) - 1);
                }
                continue;
            }
            for row in cell.rows.clone() {
                let (samples, asked) = boxes.row(simd, row, &cell.columns, reach);
                if asked == 0 {
                    continue;
                }
                let column = cell.columns.start;
                let lit = self.lit(simd, receiver, &samples, asked, |lane| [row, column + lane]);
                self.sampler.set_lit(receiver, first + boxes.bit(row, column), u64::from(lit));
            }
        }
    }

    /// Which of the `asked` lanes are lit, against the candidates.
    #[inline(always)]
    fn lit<S: Simd>(
        &mut self,
        simd: S,
        receiver: &Receiver,
        samples: &Samples<F8<S>>,
        asked: u32,
        place: impl Fn(u32) -> [u32; 2],
    ) -> u32 {
        let mut open = asked;
        let mut in_doubt = 0;
        self.doubtful.clear();
        for &(pack, lane) in self.candidates.iter() {
            let pack = &self.packs[pack as usize];

            let outcome = pack.test_eight(simd, lane as usize, samples, self.sampler.view.depth_error);
            open &= !outcome.blocked.bits();
            if open == 0 {
                return 0;
            }
            let doubtful = outcome.doubtful.bits() & open;
            if doubtful != 0 && !self.sampler.is_own(receiver, &self.occluders[pack.items[lane as usize] as usize]) {
                in_doubt |= doubtful;
                self.doubtful.push((pack.items[lane as usize], doubtful));
            }
        }
        let mut lanes = if self.sampler.unbounded.is_empty() { open & in_doubt } else { open };
        while lanes != 0 {
            let lane = lanes.trailing_zeros();
            lanes &= lanes - 1;
            let asked = self.doubtful.iter().filter(|(_, lanes)| lanes >> lane & 1 == 1);
            if self.sampler.settle(receiver, place(lane), asked.map(|&(item, _)| &self.occluders[item as usize])) {
                open &= !(1 << lane);
            }
        }
        open
    }
}

/// The box of some samples and their greatest depth; a quantum wider for the roundings of the points between.
fn bounds(hull: &[Samples<f32>; 4]) -> ([f32; 2], [f32; 2], f32) {
    let (mut low, mut high, mut farthest) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2], f32::NEG_INFINITY);
    for point in hull {
        (low, high) = ([low[0].min(point.x), low[1].min(point.y)], [high[0].max(point.x), high[1].max(point.y)]);
        farthest = farthest.max(point.depth);
    }
    (low.map(|x| x - 1.0), high.map(|x| x + 1.0), farthest)
}
