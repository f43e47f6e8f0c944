//! Patches that lie together, against all occluders over them.
//!
//! A batch walks the tree once with the box round its patches and gathers the occluders into packs, a round of them at a time.
//! Each patch then meets the packs whose boxes overlap its own: a patch with few samples takes them one by one against
//! eight occluders, another scans the rows of one occluder after the other. Doubtful pairs are kept to the end and
//! decided exactly where nothing else blocks the sample. Cost: about ten nanoseconds a patch and occluder over it.

use umbriel_geometry::{
    Aabb,
    simd::{Int, Kernel, Simd},
};

use super::{
    doubts::{Doubt, Occluder, doubt, settle},
    faces::{Face, Rect},
    pack::Pack,
    patch::Patch,
    sampler::Sampler,
    shade::{Shades, Shading, Whole, World},
    spans::{Bounds, Functions, is_none},
    tree::{Node, Path, WIDTH},
    volumes::common_solid,
};

/// Packs that are gathered in a round.
const ROUND: usize = 256;

/// Samples up to which a patch takes them one by one.
const FEW_SAMPLES: u32 = 4;

/// Patches that are not parted further.
const FEW_PATCHES: usize = 8;

/// A part is worth its own walk where the box of the whole is larger than those of the halves, this many times.
const APART: f64 = 2.0;

/// A pack of the order, or of a volume.
#[derive(Clone, Copy)]
struct PackId {
    volume: Option<u32>,
    pack: usize,
}

impl PackId {
    #[inline(always)]
    fn of<'a>(self, sampler: &'a Sampler) -> &'a Pack {
        match self.volume {
            None => &sampler.packs[self.pack],
            Some(volume) => {
                &sampler.volumes.all[volume as usize].pieces(&sampler.faces, &sampler.view).packs[self.pack]
            }
        }
    }
}

/// Storage that batches share.
#[derive(Default)]
pub(super) struct Storage {
    /// Packs over a batch, the boxes of their triangles, and boxes over eight packs each.
    found: Vec<PackId>,
    lanes: Vec<Node>,
    nodes: Vec<Node>,
    /// Solids over a batch, and the patches' lattices in the world.
    shades: Shades,
    worlds: Vec<World>,
    path: Path,
    inner_path: Path,
    beside: Beside,
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

    /// Whether nothing but a solid is over a batch, none of which is deeper than `farthest`.
    #[inline(always)]
    pub(super) fn is_clear<S: Simd>(
        &mut self,
        simd: S,
        sampler: &Sampler,
        solid: i32,
        whole: &Whole,
        farthest: f32,
    ) -> bool {
        let farthest = farthest + sampler.errors.depth_slack(farthest);
        let rect = whole.rect;
        let volumes = &sampler.volumes;
        self.shades.clear();
        volumes.tree.begin(simd, &rect, farthest, &mut self.path);
        while let Some(number) = volumes.tree.walk(simd, &rect, farthest, &mut self.path) {
            if volumes.all[number].solid != solid {
                self.shades.add(simd, sampler, number, whole);
                if !self.shades.is_empty() {
                    return false;
                }
            }
        }
        sampler.tree.begin(simd, &rect, farthest, &mut self.path);
        while let Some(pack) = sampler.tree.walk(simd, &rect, farthest, &mut self.path) {
            let pack = &sampler.packs[pack];
            let others = !pack.of_solid(simd, solid) & 0xff;
            if others != 0 && pack.load(simd).node().overlapping(simd, &rect, farthest) & others != 0 {
                return false;
            }
        }
        true
    }

    /// Adds a pack with the boxes of its triangles.
    #[inline(always)]
    fn add(&mut self, pack: PackId, (rect, nearest): (Rect, f32), lanes: Node) {
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
        let solid = common_solid(self.patches[first..end].iter().map(|patch| patch.solid));
        self.storage.doubts.clear();
        self.storage.beside = Beside::default();
        self.storage.clear();
        let mut path = std::mem::take(&mut self.storage.path);
        self.gather_volumes(simd, (first, end), (&rect, farthest), solid, &mut path);
        sampler.tree.begin(simd, &rect, farthest, &mut path);
        while let Some(pack) = sampler.tree.walk(simd, &rect, farthest, &mut path) {
            let triangles = &sampler.packs[pack];
            let own = solid.map_or(0, |solid| triangles.of_solid(simd, solid));
            let lanes = triangles.load(simd).node();
            if lanes.overlapping(simd, &rect, farthest) & !own == 0 {
                continue;
            }
            self.storage.add(PackId { volume: None, pack }, sampler.tree.bounds(pack), lanes);
            if self.storage.found.len() >= ROUND {
                self.round(simd, first, end);
            }
        }
        self.storage.path = path;
        self.round(simd, first, end);
        self.settle(first, end)
    }

    /// Meets the convex solids over a box of images, not all deeper than `farthest`, but for one; the faces of those that are
    /// not to be taken as one are gathered.
    #[inline(always)]
    fn gather_volumes<S: Simd>(
        &mut self,
        simd: S,
        (first, end): (usize, usize),
        (rect, farthest): (&Rect, f32),
        own: Option<i32>,
        path: &mut Path,
    ) {
        let sampler = self.sampler;
        self.storage.shades.clear();
        sampler.volumes.tree.begin(simd, rect, farthest, path);
        let mut whole = None;
        while let Some(number) = sampler.volumes.tree.walk(simd, rect, farthest, path) {
            let volume = &sampler.volumes.all[number];
            if Some(volume.solid) == own {
                continue;
            }
            let whole = match &whole {
                Some(whole) => whole,
                None => whole.insert(self.whole(first, end, rect)),
            };
            if volume.cover < whole.limit || volume.planes.is_some() {
                self.storage.shades.add(simd, sampler, number, whole);
            } else {
                self.gather_pieces(simd, (first, end), (rect, farthest), number);
            }
        }
        if !self.storage.shades.is_empty() {
            self.under_shades(simd, first, end);
        }
    }

    /// What holds patches; their lattices in the world are kept.
    #[inline(always)]
    fn whole(&mut self, first: usize, end: usize, rect: &Rect) -> Whole {
        self.storage.worlds.clear();
        let (mut nearest, mut bounds) = (f32::INFINITY, Aabb::EMPTY);
        for patch in &self.patches[first..end] {
            let world = World::new(self.sampler, patch);
            nearest = nearest.min(patch.nearest);
            bounds = bounds.union(world.bounds(patch));
            self.storage.worlds.push(world);
        }
        Whole::new(self.sampler, *rect, nearest, &bounds)
    }

    /// Gathers the faces of a volume over a box of images.
    #[inline(always)]
    fn gather_pieces<S: Simd>(
        &mut self,
        simd: S,
        (first, end): (usize, usize),
        (rect, farthest): (&Rect, f32),
        volume: usize,
    ) {
        let sampler = self.sampler;
        let pieces = sampler.volumes.all[volume].pieces(&sampler.faces, &sampler.view);
        let mut path = std::mem::take(&mut self.storage.inner_path);
        pieces.tree.begin(simd, rect, farthest, &mut path);
        while let Some(pack) = pieces.tree.walk(simd, rect, farthest, &mut path) {
            let lanes = pieces.packs[pack].load(simd).node();
            if lanes.overlapping(simd, rect, farthest) == 0 {
                continue;
            }
            self.storage.add(PackId { volume: Some(volume as u32), pack }, pieces.tree.bounds(pack), lanes);
            if self.storage.found.len() >= ROUND {
                self.round(simd, first, end);
            }
        }
        self.storage.inner_path = path;
    }

    /// The patches against the solids that are taken as one.
    #[inline(always)]
    fn under_shades<S: Simd>(&mut self, simd: S, first: usize, end: usize) {
        let Self { sampler, storage: Storage { shades, worlds, doubts, .. }, patches } = self;
        for (number, (patch, world)) in (first..end).zip(patches[first..end].iter_mut().zip(worlds.iter())) {
            Shading { sampler, patch, number: number as u32, doubts }.run(simd, shades, world);
        }
    }

    /// The patches against the packs found so far, which are then given up.
    #[inline(always)]
    fn round<S: Simd>(&mut self, simd: S, first: usize, end: usize) {
        if self.storage.found.is_empty() {
            return;
        }
        let Self { sampler, storage: Storage { found, lanes, nodes, beside, doubts, .. }, patches } = self;
        for (number, patch) in (first..end).zip(&mut patches[first..end]) {
            let open = patch.count_open();
            if open != 0 {
                let has_few = open <= FEW_SAMPLES;
                Meeting { sampler, patch, number: number as u32, has_few, beside, doubts }
                    .run(simd, found, lanes, nodes);
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
                    let doubt =
                        |&face: &Face| Doubt { patch: number as u32, row, columns, occluder: Occluder::Face(face) };
                    self.storage.doubts.extend(unbounded.iter().map(doubt));
                }
            }
        }
        let Storage { doubts, asked, .. } = &mut *self.storage;
        settle(self.sampler, (first, &mut self.patches[first..end]), doubts, asked)
    }
}

/// Whether asking for occluders beside patches of a batch pays: where surfaces hang together it does, among leaves it does not.
#[derive(Clone, Copy, Debug, Default)]
struct Beside {
    asked: u32,
    /// How often all eight were beside.
    all: u32,
}

impl Beside {
    #[inline(always)]
    fn is_worth_it(self) -> bool {
        self.asked < 16 || 3 * self.all > self.asked
    }

    #[inline(always)]
    fn note(&mut self, is_all: bool) {
        self.asked += 1;
        self.all += u32::from(is_all);
    }
}

/// A patch that meets occluders.
struct Meeting<'a, 'b> {
    sampler: &'a Sampler<'b>,
    patch: &'a mut Patch,
    number: u32,
    /// Whether samples take the occluders one by one.
    has_few: bool,
    beside: &'a mut Beside,
    doubts: &'a mut Vec<Doubt>,
}

impl Meeting<'_, '_> {
    /// The patch against those packs whose boxes it meets. Triangles whose boxes it meets are put side by side first: a pack
    /// of the tree has two or three of them.
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S, found: &[PackId], lanes_of: &[Node], nodes: &[Node]) {
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
                let pack = found[place].of(sampler);
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
        let triangles = pack.load(simd);
        if self.beside.is_worth_it() {
            let left = lanes & !self.patch.axes.beside(simd, &triangles, self.patch.center);
            self.beside.note(left == 0);
            if left == 0 {
                return;
            }
        }
        let functions = Functions::new(simd, &triangles, lanes, self.patch, &self.sampler.errors);
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
                    let occluder = Occluder::Face(face);
                    self.doubts.push(Doubt { patch: self.number, row, columns: 1 << column, occluder });
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
                    let occluder = Occluder::Face(pack.face(lane));
                    doubt(self.doubts, self.number, occluder, first, doubtful.to_array());
                }
            }
            self.patch.open.as_chunks_mut::<WIDTH>().0[group] = left.to_array();
        }
    }
}
