//! A convex solid over a batch of patches, and against one patch of it.
//!
//! Lines and planes of a [`Volume`](super::volumes::Volume) are linear in the row and the column of a lattice. Over a batch, lines that have all of it on their
//! inner side are dropped, and a line that has all of it on its outer side drops the solid; then the same is asked for each patch, and
//! what is left bounds the columns of its rows. NUMERICS.md, "Volumes", derives the tolerances.

use glam::DVec3;
use umbriel_geometry::{
    Aabb,
    simd::{F8, Float, I8, Int, Mask, Simd},
};

use super::{
    doubts::{Doubt, Occluder, doubt},
    faces::Rect,
    pack::ROUNDOFF,
    patch::{EDGE, Patch},
    sampler::Sampler,
    spans::{Errors, Limits, Linear, Side, beside_lines, is_none, side},
    tree::{Node, WIDTH},
    volumes::{Edges, Lanes, Planes},
};

/// Roundoff of f64.
const ROUNDOFF_64: f64 = f64::EPSILON / 2.0;

/// A solid over a batch.
struct Shade {
    /// Index into the volumes.
    volume: usize,
    solid: i32,
    /// Lines and planes that are left.
    edges: Lanes,
    planes: Lanes,
}

/// What holds all samples of a batch.
pub(super) struct Whole {
    /// Their images, widened.
    pub(super) rect: Rect,
    /// Depths up to which something is nearer than all of them.
    pub(super) limit: f32,
    /// The middle and the half sides of a box, metres.
    center: [f64; 3],
    half: [f64; 3],
    /// What distances behind planes may be off by.
    error: f64,
    /// See [`Sampler`].
    scale: f64,
}

impl Whole {
    #[inline(always)]
    pub(super) fn new(sampler: &Sampler, rect: Rect, nearest: f32, bounds: &Aabb) -> Self {
        Self {
            rect,
            limit: nearest - sampler.errors.depth_slack(nearest),
            center: bounds.center().to_array(),
            half: (0.5 * bounds.size()).to_array(),
            error: error(sampler, bounds.magnitude()),
            scale: sampler.scale,
        }
    }
}

/// What distances behind planes are off by at points made of coordinates up to `size`.
#[inline(always)]
fn error(sampler: &Sampler, size: f64) -> f64 {
    512.0 * ROUNDOFF_64 * (size + sampler.size) + 64.0 * sampler.slack
}

/// The solids over a batch.
#[derive(Default)]
pub(super) struct Shades {
    all: Vec<Shade>,
    edges: Vec<Edges>,
    planes: Vec<Planes>,
    /// Boxes of eight solids each.
    nodes: Vec<Node>,
    sides: Sides,
}

/// Lines and planes with samples of a patch on both sides, or perhaps on both; those of the lanes given.
#[derive(Default)]
struct Sides {
    all: Vec<(Side, u32)>,
    /// Whether some of them make nothing certain.
    are_uncertain: bool,
}

/// What a solid does to a patch.
enum Shadow {
    /// It blocks no sample.
    Nothing,
    /// It blocks all samples.
    All,
    /// Its [`Shades::over_rows`] tell.
    Part,
}

impl Shades {
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.all.clear();
        self.edges.clear();
        self.planes.clear();
        self.nodes.clear();
    }

    /// Whether no solid is over the batch.
    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Adds a volume if it may block something of a batch.
    #[inline(always)]
    pub(super) fn add<S: Simd>(&mut self, simd: S, sampler: &Sampler, number: usize, whole: &Whole) {
        let volume = &sampler.volumes.all[number];
        let sides = &sampler.volumes.sides[volume.part];
        let mut planes = Lanes { first: self.planes.len(), count: 0 };
        if let (false, Some(lanes)) = (volume.cover < whole.limit, volume.planes) {
            for (pack, lanes) in lanes.of(&sides.planes) {
                let [missed, covered] = planes_over_box(simd, pack, whole);
                if missed & lanes != 0 {
                    return self.planes.truncate(planes.first);
                }
                planes.take(&mut self.planes, pack, lanes & !covered);
            }
        }
        let mut edges = Lanes { first: self.edges.len(), count: 0 };
        for (pack, lanes) in volume.edges.of(&sides.edges) {
            let [missed, covered] = edges_over_box(simd, pack, &whole.rect, &sampler.errors);
            if missed & lanes != 0 {
                self.planes.truncate(planes.first);
                return self.edges.truncate(edges.first);
            }
            edges.take(&mut self.edges, pack, lanes & !covered);
        }
        let lane = self.all.len() % WIDTH;
        if lane == 0 {
            self.nodes.push(Node::EMPTY);
        }
        let last = self.nodes.len() - 1;
        self.nodes[last].add(lane, &volume.rect, volume.nearest);
        self.all.push(Shade { volume: number, solid: volume.solid, edges, planes });
    }

    /// What a solid does to a patch; the sides that are left are kept for [`Shades::over_rows`].
    #[inline(always)]
    fn over_patch<S: Simd>(
        &mut self,
        simd: S,
        sampler: &Sampler,
        shade: usize,
        patch: &Patch,
        world: &World,
    ) -> Shadow {
        let Self { all, edges, planes, sides, .. } = self;
        let shade = &all[shade];
        sides.all.clear();
        sides.are_uncertain = false;
        let is_behind = || {
            let cover = sampler.volumes.all[shade.volume].cover;
            cover < patch.nearest - sampler.errors.depth_slack(patch.nearest)
        };
        if shade.planes.count != 0 && !is_behind() {
            for (pack, lanes) in shade.planes.of(planes) {
                if !sides.keep(simd, &heights(simd, pack, patch, world), lanes, patch) {
                    return Shadow::Nothing;
                }
            }
        }
        for (pack, lanes) in shade.edges.of(edges) {
            if !sides.keep(simd, &lines(simd, pack, patch, &sampler.errors), lanes, patch) {
                return Shadow::Nothing;
            }
        }
        if sides.all.is_empty() { Shadow::All } else { Shadow::Part }
    }

    /// The columns that the solid of the last [`Shades::over_patch`] hides in eight rows from `row` on: those for certain, and those
    /// and the doubtful.
    #[inline(always)]
    fn over_rows<S: Simd>(&self, simd: S, row: u32) -> [I8<S>; 2] {
        let mut limits = Limits::new(simd, row);
        for (side, lanes) in &self.sides.all {
            let mut lanes = *lanes;
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                limits.add(simd, side, lane);
            }
        }
        let [certain, maybe] = limits.columns(simd);
        [if self.sides.are_uncertain { simd.splat_int8(0) } else { certain }, maybe]
    }
}

/// A patch that meets convex solids.
pub(super) struct Shading<'a, 'b> {
    pub(super) sampler: &'a Sampler<'b>,
    pub(super) patch: &'a mut Patch,
    pub(super) number: u32,
    pub(super) doubts: &'a mut Vec<Doubt>,
}

impl Shading<'_, '_> {
    /// The patch against those solids whose boxes it meets.
    #[inline(always)]
    pub(super) fn run<S: Simd>(&mut self, simd: S, shades: &mut Shades, world: &World) {
        let sampler = self.sampler;
        let rect = self.patch.rect.widened(sampler.wide);
        let farthest = self.patch.farthest + sampler.errors.depth_slack(self.patch.farthest);
        for number in 0..shades.nodes.len() {
            let mut children = shades.nodes[number].overlapping(simd, &rect, farthest);
            while children != 0 {
                let place = number * WIDTH + children.trailing_zeros() as usize;
                children &= children - 1;
                if shades.all[place].solid == self.patch.solid {
                    continue;
                }
                match shades.over_patch(simd, sampler, place, self.patch, world) {
                    Shadow::Nothing => continue,
                    Shadow::All => self.patch.open = [0; EDGE as usize],
                    Shadow::Part => self.by_rows(simd, shades, shades.all[place].volume as u32),
                }
                if self.patch.is_done() {
                    return;
                }
            }
        }
    }

    /// A solid over eight rows after the other.
    #[inline(always)]
    fn by_rows<S: Simd>(&mut self, simd: S, shades: &Shades, volume: u32) {
        for first in (0..self.patch.rows).step_by(WIDTH) {
            let group = first as usize / WIDTH;
            let left = simd.load_int(&self.patch.open.as_chunks::<WIDTH>().0[group]);
            let [certain, maybe] = shades.over_rows(simd, first);
            let left = left.without(certain);
            let doubtful = maybe & left;
            if !is_none(simd, doubtful) {
                doubt(self.doubts, self.number, Occluder::Volume(volume), first, doubtful.to_array());
            }
            self.patch.open.as_chunks_mut::<WIDTH>().0[group] = left.to_array();
        }
    }
}

/// The planes that have all of a batch before them, and those that have it behind them.
#[inline(always)]
fn planes_over_box<S: Simd>(simd: S, planes: &Planes, whole: &Whole) -> [u32; 2] {
    let (mut most, mut least) = ([0.0; WIDTH], [0.0; WIDTH]);
    let Whole { center, half, error, scale, .. } = *whole;
    for lane in 0..WIDTH {
        let (mut middle, mut spread) = (-planes.offset[lane], error);
        for k in 0..3 {
            middle += planes.normal[k][lane] * center[k];
            spread += planes.normal[k][lane].abs() * half[k];
        }
        // Signs outlast rounding.
        most[lane] = ((middle + spread) * scale) as f32;
        least[lane] = ((middle - spread) * scale) as f32;
    }
    let none = simd.splat8(0.0);
    [simd.load(&most).lt(none).bits(), simd.load(&least).gt(none).bits()]
}

/// The edges that have all of a box on their outer side, and those that have it on their inner side.
#[inline(always)]
fn edges_over_box<S: Simd>(simd: S, edges: &Edges, rect: &Rect, errors: &Errors) -> [u32; 2] {
    let center = rect.center();
    let (wide, high) = (simd.splat8(half(rect, 0)), simd.splat8(half(rect, 1)));
    let [from, along] = in_floats(simd, edges, center);
    let length = along[0].abs().max(along[1].abs());
    let reach = from[0].abs().max(from[1].abs()).max(wide).max(high);
    let off = tolerance(simd, reach, length, errors);
    let middle = along[1] * from[0] - along[0] * from[1];
    let spread = along[0].abs() * high + along[1].abs() * wide;
    [(middle + spread).lt(-off).bits(), (middle - spread).gt(off).bits()]
}

/// At least half a side of a box.
#[inline(always)]
fn half(rect: &Rect, k: usize) -> f32 {
    let center = rect.center()[k];
    rect.max[k].saturating_sub(center).max(center.saturating_sub(rect.min[k])) as f32
}

/// Where edges begin, relative to a point, and how they go on.
#[inline(always)]
fn in_floats<S: Simd>(simd: S, edges: &Edges, center: [i32; 2]) -> [[F8<S>; 2]; 2] {
    let x = simd.load_int(&edges.from[0]) - simd.splat_int8(center[0]);
    let y = simd.load_int(&edges.from[1]) - simd.splat_int8(center[1]);
    let (along_x, along_y) = (simd.load_int(&edges.along[0]), simd.load_int(&edges.along[1]));
    [[x.to_float(), y.to_float()], [along_x.to_float(), along_y.to_float()]]
}

/// What a line's function may be off by, where nothing is farther out than `reach`.
#[inline(always)]
fn tolerance<S: Simd>(simd: S, reach: F8<S>, length: F8<S>, errors: &Errors) -> F8<S> {
    simd.splat8(10.0 * errors.image) * (reach + length) + simd.splat8(256.0 * ROUNDOFF) * length * reach
}

/// Lines over the lattice of a patch.
#[inline(always)]
fn lines<S: Simd>(simd: S, edges: &Edges, patch: &Patch, errors: &Errors) -> Linear<F8<S>> {
    let [from, along] = in_floats(simd, edges, patch.center);
    let length = along[0].abs().max(along[1].abs());
    let reach = from[0].abs().max(from[1].abs()).max(simd.splat8(patch.reach));
    beside_lines(simd, along, from, patch, tolerance(simd, reach, length, errors))
}

impl Sides {
    /// Keeps those of eight functions that have samples of the patch on both sides, or may have; false if one has none on its inner
    /// side.
    #[inline(always)]
    fn keep<S: Simd>(&mut self, simd: S, linear: &Linear<F8<S>>, lanes: u32, patch: &Patch) -> bool {
        let (rows, columns) = (simd.splat8((patch.rows - 1) as f32), simd.splat8((patch.columns - 1) as f32));
        let [low, high] = linear.range(simd, simd.splat8(0.0), rows, columns);
        if high.lt(-linear.tolerance).bits() & lanes != 0 {
            return false;
        }
        let left = lanes & !low.gt(linear.tolerance).bits();
        if left != 0 {
            let (side, holds) = side(simd, linear);
            self.are_uncertain |= left & !holds.bits() != 0;
            self.all.push((side, left));
        }
        true
    }
}

/// The lattice of a patch in the world, metres.
#[derive(Clone, Debug)]
pub(super) struct World {
    first: [f64; 3],
    row: [f64; 3],
    column: [f64; 3],
    /// What distances behind planes may be off by, in units of the planes' normals.
    error: f64,
    /// See [`Sampler`].
    scale: f64,
}

impl World {
    #[inline(always)]
    pub(super) fn new(sampler: &Sampler, patch: &Patch) -> Self {
        let face = sampler.lattice(patch.face);
        let [a, b, d] = sampler.positions(patch.face, face.corner);
        let [rows, columns] = face.lattice.counts();
        let (u, v) = (face.lattice.coordinate(0, patch.origin[0]), face.lattice.coordinate(1, patch.origin[1]));
        let (ab, ad) = (b - a, d - a);
        let size = a.abs().max_element() + ab.abs().max_element() + ad.abs().max_element();
        Self {
            first: (a + ab * u + ad * v).to_array(),
            row: (ab / f64::from(rows)).to_array(),
            column: (ad / f64::from(columns)).to_array(),
            error: error(sampler, size),
            scale: sampler.scale,
        }
    }

    /// A box round the samples of a patch.
    #[inline(always)]
    pub(super) fn bounds(&self, patch: &Patch) -> Aabb {
        let (first, rows, columns) = (DVec3::from(self.first), f64::from(patch.rows - 1), f64::from(patch.columns - 1));
        let (along, across) = (DVec3::from(self.row) * rows, DVec3::from(self.column) * columns);
        let none = DVec3::ZERO;
        Aabb { min: first + along.min(none) + across.min(none), max: first + along.max(none) + across.max(none) }
    }
}

/// Distances behind planes over the lattice of a patch, scaled.
#[inline(always)]
fn heights<S: Simd>(simd: S, planes: &Planes, patch: &Patch, world: &World) -> Linear<F8<S>> {
    let (mut first, mut row, mut column, mut off) = ([0.0; WIDTH], [0.0; WIDTH], [0.0; WIDTH], [0.0; WIDTH]);
    let (rows, columns) = (f64::from(patch.rows - 1), f64::from(patch.columns - 1));
    let World { error, scale, .. } = *world;
    for lane in 0..WIDTH {
        let mut values = [-planes.offset[lane], 0.0, 0.0];
        for k in 0..3 {
            let normal = planes.normal[k][lane];
            values[0] += normal * world.first[k];
            values[1] += normal * world.row[k];
            values[2] += normal * world.column[k];
        }
        let most = values[0].abs() + rows * values[1].abs() + columns * values[2].abs();
        let [of_first, of_row, of_column] = values.map(|value| (value * scale) as f32);
        (first[lane], row[lane], column[lane]) = (of_first, of_row, of_column);
        off[lane] = ((256.0 * f64::from(ROUNDOFF) * most + error) * scale) as f32;
    }
    Linear {
        first: simd.load(&first),
        row: simd.load(&row),
        column: simd.load(&column),
        tolerance: simd.load(&off) + simd.splat8(f32::MIN_POSITIVE),
    }
}
