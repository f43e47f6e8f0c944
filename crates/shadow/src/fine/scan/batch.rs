//! Patches that lie together, against all occluders over them.
//!
//! A batch walks the tree once with the box round its patches and gathers the occluders into packs, a round of them at a time.
//! Each patch then meets the packs whose boxes overlap its own: a patch with few samples takes them one by one against
//! eight occluders, another scans the rows of one occluder after the other. Doubtful pairs are kept to the end and
//! decided exactly where nothing else blocks the sample. Cost: about ten nanoseconds a patch and occluder over it.

use umbriel_geometry::simd::{I8, Int, Kernel, Mask, Simd};

use super::{
    faces::{Face, Rect},
    pack::Pack,
    patch::{EDGE, Patch},
    sampler::Sampler,
    spans::{Bounds, Functions},
    tree::{Node, Step, WIDTH},
};

/// Packs that are gathered in a round.
const ROUND: usize = 256;

/// Samples up to which a patch takes them one by one.
const FEW_SAMPLES: u32 = 4;

/// Patches that are not parted further.
const FEW_PATCHES: usize = 8;

/// A part is worth its own walk where the box of the whole is larger than those of the halves, this many times.
const APART: f64 = 2.0;

/// Storage that batches share.
#[derive(Default)]
pub(super) struct Storage {
    /// Packs of the tree over a batch, the boxes of their triangles, and boxes over eight packs each.
    found: Vec<usize>,
    lanes: Vec<Node>,
    nodes: Vec<Node>,
    path: Vec<Step>,
    doubts: Vec<Doubt>,
    /// The samples of the patches' rows that are in doubt.
    asked: Vec<u32>,
    /// Patches that walk the tree together, and the box round them.
    parts: Vec<(usize, usize, Rect)>,
}

impl Storage {
    /// Gives the packs up.
    fn clear(&mut self) {
        self.found.clear();
        self.lanes.clear();
        self.nodes.clear();
    }

    /// Whether nothing but a solid is over a box of images and not all deeper than `farthest`.
    #[inline(always)]
    pub(super) fn is_clear<S: Simd>(
        &mut self,
        simd: S,
        sampler: &Sampler,
        solid: i32,
        whole: &Rect,
        farthest: f32,
    ) -> bool {
        let farthest = farthest + sampler.errors.depth_slack(farthest);
        let rect = whole.widened(sampler.wide);
        sampler.tree.begin(simd, &rect, farthest, &mut self.path);
        while let Some(pack) = sampler.tree.walk(simd, &rect, farthest, &mut self.path) {
            let pack = &sampler.packs[pack];
            let others = !pack.of_solid(simd, solid) & 0xff;
            if others != 0 && Node::of_triangles(&pack.load(simd)).overlapping(simd, &rect, farthest) & others != 0 {
                return false;
            }
        }
        true
    }

    /// Adds a pack with the boxes of its triangles.
    #[inline(always)]
    fn add(&mut self, pack: usize, (rect, nearest): (Rect, f32), lanes: Node) {
        let lane = self.found.len() % WIDTH;
        if lane == 0 {
            self.nodes.push(Node::EMPTY);
        }
        let last = self.nodes.len() - 1;
        self.nodes[last].add(lane, &rect, nearest);
        self.found.push(pack);
        self.lanes.push(lanes);
    }
}

/// Samples of a row of a patch that a face may block.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    patch: u32,
    row: u32,
    columns: u32,
    face: Face,
}

/// Decides the open samples of these patches: afterwards those are open that are lit.
pub(super) struct Batch<'a, 'b> {
    pub(super) sampler: &'a Sampler<'b>,
    pub(super) storage: &'a mut Storage,
    pub(super) patches: &'a mut [Patch],
}

impl Kernel for Batch<'_, '_> {
    /// How many samples were in doubt.
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> u64 {
        let mut parts = std::mem::take(&mut self.storage.parts);
        parts.clear();
        self.part(0, self.patches.len(), &mut parts);
        let mut asked = 0;
        for (first, end, whole) in &parts {
            asked += self.together(simd, (*first, *end), whole);
        }
        self.storage.parts = parts;
        asked
    }
}

impl Batch<'_, '_> {
    /// Patches first..end: together, or in halves where those lie apart.
    fn part(&self, first: usize, end: usize, parts: &mut Vec<(usize, usize, Rect)>) {
        let union = |patches: &[Patch]| patches.iter().fold(Rect::EMPTY, |rect, patch| rect.union(&patch.rect));
        let middle = first.midpoint(end);
        let halves = [union(&self.patches[first..middle]), union(&self.patches[middle..end])];
        let whole = halves[0].union(&halves[1]);
        if end - first > FEW_PATCHES && whole.area() > APART * (halves[0].area() + halves[1].area()) {
            self.part(first, middle, parts);
            return self.part(middle, end, parts);
        }
        parts.push((first, end, whole));
    }

    #[inline(always)]
    fn together<S: Simd>(&mut self, simd: S, (first, end): (usize, usize), whole: &Rect) -> u64 {
        let sampler = self.sampler;
        let farthest = self.patches[first..end].iter().fold(f32::NEG_INFINITY, |most, patch| most.max(patch.farthest));
        let farthest = farthest + sampler.errors.depth_slack(farthest);
        let rect = whole.widened(sampler.wide);
        // Faces of the convex solid of all these patches block none of them.
        let solid = self.patches[first].solid;
        let is_common = solid >= 0 && self.patches[first..end].iter().all(|patch| patch.solid == solid);
        self.storage.doubts.clear();
        self.storage.clear();
        let mut path = std::mem::take(&mut self.storage.path);
        sampler.tree.begin(simd, &rect, farthest, &mut path);
        while let Some(pack) = sampler.tree.walk(simd, &rect, farthest, &mut path) {
            let triangles = &sampler.packs[pack];
            let own = if is_common { triangles.of_solid(simd, solid) } else { 0 };
            let lanes = Node::of_triangles(&triangles.load(simd));
            if lanes.overlapping(simd, &rect, farthest) & !own == 0 {
                continue;
            }
            self.storage.add(pack, sampler.tree.bounds(pack), lanes);
            if self.storage.found.len() >= ROUND {
                self.round(simd, first, end);
            }
        }
        self.storage.path = path;
        self.round(simd, first, end);
        self.settle(first, end)
    }

    /// The patches against the packs found so far, which are then given up.
    #[inline(always)]
    fn round<S: Simd>(&mut self, simd: S, first: usize, end: usize) {
        let Self { sampler, storage: Storage { found, lanes, nodes, doubts, .. }, patches } = self;
        for (number, patch) in (first..end).zip(&mut patches[first..end]) {
            let open = patch.count_open();
            if open != 0 {
                let has_few = open <= FEW_SAMPLES;
                Meeting { sampler, patch, number: number as u32, has_few, doubts }.run(simd, found, lanes, nodes);
            }
        }
        self.storage.clear();
    }

    /// Decides what is in doubt, and what is asked of faces whose shadow nothing bounds; how many samples that were.
    fn settle(&mut self, first: usize, end: usize) -> u64 {
        let unbounded = &self.sampler.unbounded;
        if !unbounded.is_empty() {
            for number in first..end {
                for row in 0..self.patches[number].rows {
                    let columns = self.patches[number].open[row as usize] as u32;
                    let doubt = |&face: &Face| Doubt { patch: number as u32, row, columns, face };
                    self.storage.doubts.extend(unbounded.iter().map(doubt));
                }
            }
        }
        let Storage { doubts, asked, .. } = &mut *self.storage;
        asked.clear();
        if !doubts.is_empty() {
            asked.resize((end - first) * EDGE as usize, 0_u32);
        }
        for doubt in doubts {
            let patch = &mut self.patches[doubt.patch as usize];
            let mut columns = doubt.columns & patch.open[doubt.row as usize] as u32;
            asked[(doubt.patch as usize - first) * EDGE as usize + doubt.row as usize] |= columns;
            while columns != 0 {
                let column = columns.trailing_zeros();
                columns &= columns - 1;
                let place = [patch.origin[0] + doubt.row, patch.origin[1] + column];
                if self.sampler.blocks_exactly(patch.face, place, doubt.face) {
                    patch.open[doubt.row as usize] &= !(1 << column);
                }
            }
        }
        asked.iter().map(|columns| u64::from(columns.count_ones())).sum()
    }
}

/// Whether no bit is set.
#[inline(always)]
fn is_none<S: Simd>(simd: S, rows: I8<S>) -> bool {
    rows.eq(simd.splat_int8(0)).bits() == 0xff
}

/// A patch that meets occluders.
struct Meeting<'a, 'b> {
    sampler: &'a Sampler<'b>,
    patch: &'a mut Patch,
    number: u32,
    /// Whether samples take the occluders one by one.
    has_few: bool,
    doubts: &'a mut Vec<Doubt>,
}

impl Meeting<'_, '_> {
    /// The patch against those packs whose boxes it meets. Triangles whose boxes it meets are put side by side first: a pack
    /// of the tree has two or three of them.
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S, found: &[usize], lanes_of: &[Node], nodes: &[Node]) {
        let sampler = self.sampler;
        let rect = self.patch.rect.widened(sampler.wide);
        let farthest = self.patch.farthest + sampler.errors.depth_slack(self.patch.farthest);
        let (mut near, mut count) = (Pack::EMPTY, 0);
        for (number, node) in nodes.iter().enumerate() {
            let mut children = node.overlapping(simd, &rect, farthest);
            while children != 0 {
                let place = number * WIDTH + children.trailing_zeros() as usize;
                children &= children - 1;
                let mut lanes = lanes_of[place].overlapping(simd, &rect, farthest);
                if lanes == 0 {
                    continue;
                }
                let pack = &sampler.packs[found[place]];
                lanes &= !pack.of_solid(simd, self.patch.solid);
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize;
                    lanes &= lanes - 1;
                    near.copy(count, pack, lane);
                    count += usize::from(pack.face(lane) != self.patch.face);
                    if count == WIDTH {
                        count = 0;
                        self.meet(simd, &near, 0xff);
                        if self.patch.is_done() {
                            return;
                        }
                    }
                }
            }
        }
        if count != 0 {
            self.meet(simd, &near, (1 << count) - 1);
        }
    }

    #[inline(always)]
    fn meet<S: Simd>(&mut self, simd: S, pack: &Pack, lanes: u32) {
        let functions = Functions::new(simd, &pack.load(simd), lanes, self.patch, &self.sampler.errors);
        if self.has_few {
            self.by_samples(simd, pack, lanes, &functions);
        } else {
            self.by_spans(simd, pack, lanes, &functions);
        }
    }

    /// Each open sample against the eight occluders.
    #[inline(always)]
    fn by_samples<S: Simd>(&mut self, simd: S, pack: &Pack, lanes: u32, functions: &Functions<S>) {
        for row in 0..self.patch.rows {
            let mut columns = self.patch.open[row as usize] as u32;
            while columns != 0 {
                let column = columns.trailing_zeros();
                columns &= columns - 1;
                let [certain, doubtful] = functions.at(simd, row, column);
                if certain & lanes != 0 {
                    self.patch.open[row as usize] &= !(1 << column);
                    continue;
                }
                let mut doubtful = doubtful & lanes;
                while doubtful != 0 {
                    let face = pack.face(doubtful.trailing_zeros() as usize);
                    doubtful &= doubtful - 1;
                    self.doubts.push(Doubt { patch: self.number, row, columns: 1 << column, face });
                }
            }
        }
    }

    /// The occluders over eight rows after the other.
    #[inline(always)]
    fn by_spans<S: Simd>(&mut self, simd: S, pack: &Pack, lanes: u32, functions: &Functions<S>) {
        let (mut bounds, mut has_bounds) = (Bounds::EMPTY, false);
        for first in (0..self.patch.rows).step_by(WIDTH) {
            let [missed, covered] = functions.over_rows(simd, self.patch, first);
            let mut lanes = lanes & !missed;
            if lanes == 0 {
                continue;
            }
            let group = first as usize / WIDTH;
            let mut left = simd.load_int(&self.patch.open.as_chunks::<WIDTH>().0[group]);
            if covered & lanes != 0 {
                (left, lanes) = (simd.splat_int8(0), 0);
            }
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                if !has_bounds {
                    bounds = functions.bounds(simd);
                    has_bounds = true;
                }
                let [certain, maybe] = bounds.spans(simd, lane, first);
                left = left.without(certain);
                if is_none(simd, left) {
                    break;
                }
                let doubtful = maybe & left;
                if !is_none(simd, doubtful) {
                    self.doubt(first, pack.face(lane), doubtful.to_array());
                }
            }
            self.patch.open.as_chunks_mut::<WIDTH>().0[group] = left.to_array();
        }
    }

    /// Keeps samples that a face may block.
    #[cold]
    fn doubt(&mut self, first: u32, face: Face, doubtful: [i32; WIDTH]) {
        let rows = (first..).zip(doubtful).filter(|&(_, columns)| columns != 0);
        let patch = self.number;
        self.doubts.extend(rows.map(|(row, columns)| Doubt { patch, row, columns: columns as u32, face }));
    }
}
