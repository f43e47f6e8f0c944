//! Samples of many small faces, sixteen side by side.
//!
//! Where faces have a sample or two each, making patches of them costs more than deciding their samples. Here samples are points of the image with
//! depths, whatever faces they are of: sixteen are a bunch, eight bunches walk the tree together, and an occluder over
//! the box of a bunch is held against all sixteen at once.
//!
//! Source: as for patches ([`scan`](super)); the samples of an irregular depth buffer (Aila and Laine 2004; Johnson, Lee, Burns and Mark 2005).
//! Guarantee: what is not decided for certain is asked exactly; NUMERICS.md, "Samples by scan conversion", "Bunches". Cost: some
//! five nanoseconds a bunch and occluder over it.

use umbriel_geometry::simd::{F16, Float, Int, Lanes, M16, Mask, Simd};

use super::{
    faces::{Face, Rect},
    group::Small,
    pack::{Pack, Triangles},
    patch::{Extent, WIDER},
    sampler::Sampler,
    spans::{Errors, Outlines},
    tree::{Node, Path, WIDTH},
    volumes::common_solid,
};

/// Samples of a bunch.
const LANES: usize = 16;

/// Samples that walk the tree together.
const MOST: u64 = (WIDTH * LANES) as u64;

/// Samples of a face up to which it is worth its place in a bunch.
const FEW_SAMPLES: u64 = 6;

/// A sample.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// Its image, quanta, and its depth.
    at: [f64; 3],
    face: Face,
    /// The convex solid whose faces do not block it; −2 for none.
    solid: i32,
    place: [u32; 2],
    /// The byte and the bit of its answer.
    byte: u64,
    bit: u32,
}

/// Sixteen samples; lanes without one are not open.
#[derive(Clone, Debug)]
struct Bunch {
    /// Images, counted from the middle of all bunches, and depths beyond the middle one.
    x: [f32; LANES],
    y: [f32; LANES],
    depth: [f32; LANES],
    source: [i32; LANES],
    number: [i32; LANES],
    solid: [i32; LANES],
    /// Holds the images of whatever is over one of them, quanta.
    rect: Rect,
    /// Depths beyond which nothing blocks one of them.
    farthest: f32,
    /// A bit a sample that nothing is known to block yet.
    open: u32,
}

/// Lanes of a bunch that an occluder may block.
struct Doubt {
    bunch: usize,
    lanes: u32,
    occluder: Face,
}

/// Samples of neighbouring faces, in bunches.
#[derive(Default)]
pub(super) struct Bunches {
    samples: Vec<Sample>,
    all: Vec<Bunch>,
    doubts: Vec<Doubt>,
    path: Path,
    origin: Origin,
}

/// What images and depths are counted from.
#[derive(Clone, Copy, Debug, Default)]
struct Origin {
    center: [i32; 2],
    middle: f32,
    /// How far corners of the samples' faces are from these at most.
    reach: f32,
    range: f32,
    /// The longest side of a box round a face.
    face: f32,
}

impl Origin {
    #[inline(always)]
    fn of(&Extent { rect, depths: [nearest, farthest] }: &Extent, face: f32) -> Self {
        let (center, middle) = (rect.center(), 0.5 * (nearest + farthest));
        let reach = |k: usize| (rect.max[k] - center[k]).max(center[k] - rect.min[k]) as f32;
        Self { center, middle, reach: reach(0).max(reach(1)), range: (farthest - middle).max(middle - nearest), face }
    }
}

impl Bunches {
    /// How many of the first of these faces have few samples, and have room for them together.
    #[inline(always)]
    pub(super) fn taken(small: &[Small]) -> usize {
        let mut samples = 0;
        for (number, face) in small.iter().enumerate() {
            let own = face.lattice.lattice.len();
            samples += own;
            if own > FEW_SAMPLES || samples > MOST {
                return number;
            }
        }
        small.len()
    }

    #[inline(always)]
    fn add(&mut self, sampler: &Sampler, small: &Small) {
        let Small { face, solid, ref lattice, .. } = *small;
        let frame = small.frame(sampler);
        let row_bytes = lattice.row_bytes();
        for row in 0..lattice.lattice.counts()[0] {
            let mut columns = small.row(row) as u32;
            while columns != 0 {
                let column = columns.trailing_zeros();
                columns &= columns - 1;
                let [x, y, z, depth] = frame.at(f64::from(row), f64::from(column));
                self.samples.push(Sample {
                    at: [x / z, y / z, depth / z],
                    face,
                    solid,
                    place: [row, column],
                    byte: lattice.first_byte + u64::from(row) * row_bytes + u64::from(column / 8),
                    bit: column % 8,
                });
            }
        }
    }

    /// Decides the samples of faces that are [taken](Bunches::taken) and keeps the answers; how many samples there are, and how many of them were in
    /// doubt. `None` where convex solids may be over them: those are held against patches.
    #[inline(always)]
    pub(super) fn decide<S: Simd>(&mut self, simd: S, sampler: &Sampler, small: &[Small]) -> Option<[u64; 2]> {
        let (mut whole, mut longest) = (Extent::EMPTY, 0);
        for Small { extent, .. } in small {
            whole = whole.union(extent);
            longest = longest.max(extent.rect.longest());
        }
        let solid = common_solid(small.iter().map(|face| face.solid));
        let farthest = whole.depths[1] + sampler.errors.depth_slack(whole.depths[1]);
        if self.is_under_others(simd, sampler, (&whole.rect.widened(sampler.wide), farthest), solid) {
            return None;
        }
        self.origin = Origin::of(&whole, longest as f32);
        self.samples.clear();
        small.iter().for_each(|face| self.add(sampler, face));
        self.meet_all(simd, sampler, solid);
        let asked = self.settle(sampler);
        self.write(sampler);
        Some([self.samples.len() as u64, asked])
    }

    /// The samples against all occluders over them but those of one solid; doubts are kept.
    #[inline(always)]
    fn meet_all<S: Simd>(&mut self, simd: S, sampler: &Sampler, solid: Option<i32>) {
        self.all.clear();
        self.doubts.clear();
        let (mut rect, mut farthest, mut boxes) = (Rect::EMPTY, f32::NEG_INFINITY, Node::EMPTY);
        for (number, samples) in self.samples.chunks(LANES).enumerate() {
            let bunch = Bunch::new(samples, &self.origin, sampler);
            rect = rect.union(&bunch.rect);
            farthest = farthest.max(bunch.farthest);
            // Depths change sign: what is nearer than the farthest sample is not beside.
            boxes.add(number, &bunch.rect, -bunch.farthest);
            self.all.push(bunch);
        }
        let Self { all, doubts, path, origin, .. } = self;
        sampler.tree.begin(simd, &rect, farthest, path);
        while let Some(number) = sampler.tree.walk(simd, &rect, farthest, path) {
            let pack = &sampler.packs[number];
            let own = solid.map_or(0, |solid| pack.of_solid(simd, solid));
            let triangles = pack.load(simd);
            let lanes = triangles.node();
            let mut occluders = None;
            let (pack_rect, nearest) = sampler.tree.bounds(number);
            let mut meeting = boxes.overlapping(simd, &pack_rect, -nearest);
            while meeting != 0 {
                let number = meeting.trailing_zeros() as usize;
                meeting &= meeting - 1;
                let bunch = &mut all[number];
                let mut over = lanes.overlapping(simd, &bunch.rect, bunch.farthest) & !own;
                if over == 0 || bunch.open == 0 {
                    continue;
                }
                let occluders = match &occluders {
                    Some(occluders) => occluders,
                    None => occluders.insert(Occluders::new(simd, &triangles, origin, &sampler.errors)),
                };
                while over != 0 {
                    let lane = over.trailing_zeros() as usize;
                    over &= over - 1;
                    let doubtful = bunch.meet(simd, occluders, pack, lane);
                    if doubtful != 0 {
                        doubts.push(Doubt { bunch: number, lanes: doubtful, occluder: pack.face(lane) });
                    }
                }
            }
        }
    }

    /// Whether a convex solid but one is over a box of images, not all deeper than `farthest`.
    #[inline(always)]
    fn is_under_others<S: Simd>(
        &mut self,
        simd: S,
        sampler: &Sampler,
        (rect, farthest): (&Rect, f32),
        own: Option<i32>,
    ) -> bool {
        let volumes = &sampler.volumes;
        volumes.tree.begin(simd, rect, farthest, &mut self.path);
        while let Some(number) = volumes.tree.walk(simd, rect, farthest, &mut self.path) {
            if Some(volumes.all[number].solid) != own {
                return true;
            }
        }
        false
    }

    /// Decides what is in doubt and not blocked by anything else; how many samples that were.
    fn settle(&mut self, sampler: &Sampler) -> u64 {
        let mut asked = [0_u32; WIDTH];
        for &Doubt { bunch: number, lanes, occluder } in &self.doubts {
            let bunch = &mut self.all[number];
            let mut lanes = lanes & bunch.open;
            asked[number] |= lanes;
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                let Sample { face, place, .. } = self.samples[number * LANES + lane];
                if sampler.blocks_exactly(face, place, occluder) {
                    bunch.open &= !(1 << lane);
                }
            }
        }
        asked.iter().map(|lanes| u64::from(lanes.count_ones())).sum()
    }

    /// Keeps which samples are lit.
    #[inline(always)]
    fn write(&self, sampler: &Sampler) {
        for (samples, bunch) in self.samples.chunks(LANES).zip(&self.all) {
            for (lane, sample) in samples.iter().enumerate() {
                if bunch.open >> lane & 1 == 1 {
                    sampler.lit[sample.face.source as usize].set(sample.byte, 1 << sample.bit);
                }
            }
        }
    }
}

impl Bunch {
    #[inline(always)]
    fn new(samples: &[Sample], origin: &Origin, sampler: &Sampler) -> Self {
        let mut bunch = Self {
            x: [0.0; LANES],
            y: [0.0; LANES],
            depth: [0.0; LANES],
            source: [-1; LANES],
            number: [-1; LANES],
            solid: [-2; LANES],
            rect: Rect::EMPTY,
            farthest: f32::NEG_INFINITY,
            open: (1 << samples.len()) - 1,
        };
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        let center = origin.center.map(f64::from);
        for (lane, sample) in samples.iter().enumerate() {
            let [x, y] = [0, 1].map(|k| (sample.at[k] - center[k]) as f32);
            low = [low[0].min(x), low[1].min(y)];
            high = [high[0].max(x), high[1].max(y)];
            (bunch.x[lane], bunch.y[lane]) = (x, y);
            bunch.depth[lane] = (sample.at[2] - f64::from(origin.middle)) as f32;
            bunch.farthest = bunch.farthest.max(bunch.depth[lane]);
            (bunch.source[lane], bunch.number[lane]) = (sample.face.source as i32, sample.face.number as i32);
            bunch.solid[lane] = sample.solid;
        }
        let margin = origin.reach * WIDER + 2.0 + sampler.wide as f32;
        let from_center = |k: usize, away: f32| origin.center[k].saturating_add(away as i32);
        bunch.rect = Rect {
            min: [0, 1].map(|k| from_center(k, (low[k] - margin).floor())),
            max: [0, 1].map(|k| from_center(k, (high[k] + margin).ceil())),
        };
        bunch.farthest += origin.middle + origin.range * WIDER;
        bunch.farthest += sampler.errors.depth_slack(bunch.farthest);
        bunch
    }

    /// The samples against one occluder: those that it blocks are closed, those in doubt are answered.
    #[inline(always)]
    fn meet<S: Simd>(&mut self, simd: S, occluders: &Occluders, pack: &Pack, lane: usize) -> u32 {
        let (x, y) = (simd.load(&self.x), simd.load(&self.y));
        let [a, b, c] = &occluders.sides;
        let least = a.at(simd, lane, x, y).min(b.at(simd, lane, x, y)).min(c.at(simd, lane, x, y));
        let tolerance = simd.splat16(occluders.tolerance[lane]);
        // Not "at least": what is no number is in doubt.
        let mut over = !least.lt(-tolerance).bits() & self.open;
        if over == 0 {
            return 0;
        }
        let Face { source, number } = pack.face(lane);
        let is_own = simd.load_int(&self.number).eq(simd.splat_int16(number as i32))
            & simd.load_int(&self.source).eq(simd.splat_int16(source as i32));
        over &= !is_own.bits() & !simd.load_int(&self.solid).eq(simd.splat_int16(pack.solid(lane))).bits();
        if over == 0 {
            return 0;
        }
        let depth = simd.load(&self.depth);
        let nearer = simd.splat16(occluders.area[lane]) * depth + occluders.plane.at(simd, lane, x, y);
        let off = simd.splat16(occluders.plane_off[lane]);
        let is_thin = occluders.thin >> lane & 1 == 1;
        let is_before = depth.lt(simd.splat16(occluders.nearest[lane]));
        let is_behind = depth.gt(simd.splat16(occluders.farthest[lane]));
        let blocked: M16<S> = least.gt(tolerance) & (is_behind | nearer.gt(off));
        let beyond = if is_thin { is_before } else { is_before | nearer.lt(-off) };
        let blocked = if occluders.vague >> lane & 1 == 1 { 0 } else { blocked.bits() & over };
        self.open &= !blocked;
        over & !blocked & !beyond.bits()
    }
}

/// A function of eight occluders, linear in the image.
struct Linear {
    first: [f32; WIDTH],
    x: [f32; WIDTH],
    y: [f32; WIDTH],
}

impl Linear {
    /// That of one occluder at sixteen places.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, lane: usize, x: F16<S>, y: F16<S>) -> F16<S> {
        let of = |values: &[f32; WIDTH]| Lanes::<LANES>::splat(simd, values[lane]);
        of(&self.first) + x * of(&self.x) + y * of(&self.y)
    }
}

/// Eight occluders as functions of the image.
struct Occluders {
    sides: [Linear; 3],
    tolerance: [f32; WIDTH],
    /// Twice the areas.
    area: [f32; WIDTH],
    /// The corners' depths, weighted by the sides' functions and turned round.
    plane: Linear,
    plane_off: [f32; WIDTH],
    /// Depths before which, and beyond which, samples are nearer or deeper than all of the occluder.
    nearest: [f32; WIDTH],
    farthest: [f32; WIDTH],
    /// Occluders of which nothing is certain inside; and those that block nothing for certain.
    thin: u32,
    vague: u32,
}

impl Occluders {
    #[inline(always)]
    fn new<S: Simd>(simd: S, triangles: &Triangles<S>, origin: &Origin, errors: &Errors) -> Self {
        let outlines =
            Outlines::new(simd, triangles, (origin.center, origin.reach), [48.0, 32.0 * origin.face], errors);
        let Outlines { along, x, y, area, is_thin, tolerance } = outlines;
        let middle = simd.splat8(origin.middle);
        let depths = [triangles.depth[0] - middle, triangles.depth[1] - middle, triangles.depth[2] - middle];
        let plane_off = outlines.plane_off(simd, &depths, (origin.middle, origin.range), errors);
        let mut plane = [simd.splat8(0.0); 3];
        let mut sides = [[simd.splat8(0.0); 3]; 3];
        for k in 0..3 {
            let from = (k + 1) % 3;
            sides[k] = [along[k][1] * x[from] - along[k][0] * y[from], -along[k][1], along[k][0]];
            for n in 0..3 {
                plane[n] = plane[n] - sides[k][n] * depths[k];
            }
        }
        let slack = simd.splat8(errors.depth_slack(origin.middle.abs() + origin.range));
        let slack = slack + simd.splat8(origin.range * WIDER);
        Self {
            sides: [linear(sides[0]), linear(sides[1]), linear(sides[2])],
            tolerance: tolerance.to_array(),
            area: area.to_array(),
            plane: linear(plane),
            plane_off: plane_off.to_array(),
            nearest: (triangles.nearest() - middle - slack).to_array(),
            farthest: (triangles.farthest() - middle + slack).to_array(),
            thin: is_thin.bits(),
            vague: (is_thin | triangles.holed).bits(),
        }
    }
}

#[inline(always)]
fn linear<V: Float<WIDTH>>([first, x, y]: [V; 3]) -> Linear {
    Linear { first: first.to_array(), x: x.to_array(), y: y.to_array() }
}
