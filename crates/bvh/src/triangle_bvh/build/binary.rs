//! A binary tree by the surface-area heuristic over bins.
//!
//! Wald, "On fast construction of SAH-based bounding volume hierarchies", IEEE Symposium on Interactive Ray Tracing
//! 2007, counting packs instead of triangles: a part with n triangles costs its area times ⌈n/8⌉. Leaves hold up to
//! eight triangles. O(n log n); the depth is at most [`MAX_DEPTH`]. Nodes lie in preorder. The tree depends on the
//! triangles and their order alone.

use std::num::NonZeroU32;

use umbriel_geometry::simd::{self, Kernel, Simd};

use super::{
    super::{bounds::Bounds, layout::WIDTH},
    tasks::{CHUNK, for_each, join},
    widen::Forest,
};

/// Most nodes on a way from the root to a leaf.
pub(in super::super) const MAX_DEPTH: usize = 48;

/// Bins on an axis, at most.
const BINS: usize = 16;

/// Below so many triangles a part is not worth a thread.
const SERIAL: usize = 4096;

/// A node over the items `first .. first + count`.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    pub(super) bounds: Bounds,
    pub(super) first: u32,
    pub(super) count: u32,
    /// The right child; the left one is the next node. `None` for a leaf.
    pub(super) right: Option<NonZeroU32>,
    /// What the wide tree may make of it.
    pub(super) forest: Forest,
}

impl BinaryNode {
    /// Of at most eight items.
    pub(super) fn leaf(bounds: Bounds, first: u32, count: u32) -> Self {
        Self { bounds, first, count, right: None, forest: Forest::of_pack(&bounds) }
    }

    /// Finds what the wide tree may make of a node whose children know it, `offset` being the index of the first of
    /// `nodes` in the tree.
    pub(super) fn choose(nodes: &mut [Self], index: usize, offset: usize) {
        let node = &nodes[index];
        nodes[index].forest = match node.right {
            None => Forest::of_pack(&node.bounds),
            Some(right) => {
                let (left, right) = (&nodes[index + 1], &nodes[right.get() as usize - offset]);
                Forest::join(&node.bounds, node.count, &left.forest, &right.forest)
            }
        };
    }
}

/// Builds the tree over tagged boxes, which are put in leaf order. `items` must not be empty.
pub(super) fn build(items: &mut [Bounds]) -> Vec<BinaryNode> {
    let mut nodes = Vec::with_capacity(items.len() / 2);
    let scratch = &mut vec![Bounds::ZERO; items.len()];
    Part::new(items, scratch, 0, 1).build(&mut nodes);
    nodes
}

/// How often so many items have to be halved until they make leaves.
pub(super) fn halvings(items: usize) -> usize {
    items.div_ceil(WIDTH).next_power_of_two().trailing_zeros() as usize
}

fn bounds_of(items: &[Bounds]) -> Bounds {
    items.iter().fold(Bounds::EMPTY, |all, item| all.union(item))
}

/// The box of the items' middles, doubled.
pub(super) fn centers_of(items: &[Bounds]) -> Bounds {
    let (mut min, mut max) = ([f32::INFINITY; 4], [f32::NEG_INFINITY; 4]);
    for item in items {
        let center = item.twice_center();
        for lane in 0..4 {
            min[lane] = if center[lane] < min[lane] { center[lane] } else { min[lane] };
            max[lane] = if center[lane] > max[lane] { center[lane] } else { max[lane] };
        }
    }
    Bounds::new([min[0], min[1], min[2]], [max[0], max[1], max[2]])
}

/// Items that become a subtree.
pub(super) struct Part<'a> {
    items: &'a mut [Bounds],
    /// As many, of no meaning.
    scratch: &'a mut [Bounds],
    /// Index of the first of them in leaf order.
    first: u32,
    /// Of the subtree's root; the tree's root has depth 1.
    depth: usize,
    /// The box of the middles, doubled.
    centers: Bounds,
    bounds: Bounds,
}

impl<'a> Part<'a> {
    /// All of the items, the first of them at `first` in leaf order. `scratch` is as long, and of no meaning.
    pub(super) fn new(items: &'a mut [Bounds], scratch: &'a mut [Bounds], first: u32, depth: usize) -> Self {
        let (centers, bounds) = (centers_of(items), bounds_of(items));
        Self { items, scratch, first, depth, centers, bounds }
    }

    /// Appends the subtree to `nodes`.
    pub(super) fn build(self, nodes: &mut Vec<BinaryNode>) {
        let index = nodes.len();
        let (first, count) = (self.first, self.items.len() as u32);
        nodes.push(BinaryNode::leaf(self.bounds, first, count));
        if self.items.len() <= WIDTH {
            return;
        }
        let (left, right) = self.split();
        let second = if cfg!(feature = "rayon") && count as usize > SERIAL {
            let (left, right) = join(|| left.subtree(), || right.subtree());
            append(nodes, left);
            let second = nodes.len();
            append(nodes, right);
            second
        } else {
            left.build(nodes);
            let second = nodes.len();
            right.build(nodes);
            second
        };
        nodes[index].right = NonZeroU32::new(second as u32);
        BinaryNode::choose(nodes, index, 0);
    }

    fn subtree(self) -> Vec<BinaryNode> {
        let mut nodes = Vec::with_capacity(self.items.len() / 2);
        self.build(&mut nodes);
        nodes
    }

    fn split(self) -> (Part<'a>, Part<'a>) {
        // What is left of the depth must do for halving down to leaves.
        let must_halve = self.depth + halvings(self.items.len()) >= MAX_DEPTH;
        let best = if must_halve { None } else { Bins::fill(&self).best() };
        match best {
            Some(plane) => self.partition(&plane),
            None => self.halve(),
        }
    }

    /// In the order that the items have: middles coincide, or the depth runs out.
    fn halve(self) -> (Part<'a>, Part<'a>) {
        let middle = self.items.len() / 2;
        let (left, right) = self.items.split_at_mut(middle);
        let (left_scratch, right_scratch) = self.scratch.split_at_mut(middle);
        let (depth, second) = (self.depth + 1, self.first + middle as u32);
        (Part::new(left, left_scratch, self.first, depth), Part::new(right, right_scratch, second, depth))
    }

    fn partition(self, plane: &Plane) -> (Part<'a>, Part<'a>) {
        let Part { items, scratch, first, depth, .. } = self;
        let middle = divide(items, scratch, plane);
        let (left, right) = items.split_at_mut(middle);
        let (left_scratch, right_scratch) = scratch.split_at_mut(middle);
        let (depth, second) = (depth + 1, first + middle as u32);
        let (left_centers, right_centers) = (centers_of(left), centers_of(right));
        (
            Part { items: left, scratch: left_scratch, first, depth, centers: left_centers, bounds: plane.left },
            Part {
                items: right,
                scratch: right_scratch,
                first: second,
                depth,
                centers: right_centers,
                bounds: plane.right,
            },
        )
    }
}

/// Puts what goes left first, in the order that the items have; returns how many do. Without branches, which no
/// processor could foresee.
fn divide(items: &mut [Bounds], scratch: &mut [Bounds], plane: &Plane) -> usize {
    let (mut left, mut right) = (0, 0);
    for index in 0..items.len() {
        let item = items[index];
        let goes_left = plane.binning.bin(item.twice_center()[plane.axis], plane.axis) < plane.bin;
        items[left] = item;
        scratch[right] = item;
        left += usize::from(goes_left);
        right += usize::from(!goes_left);
    }
    items[left..].copy_from_slice(&scratch[..right]);
    left
}

/// Puts a subtree behind the nodes that are there.
fn append(nodes: &mut Vec<BinaryNode>, subtree: Vec<BinaryNode>) {
    let offset = nodes.len() as u32;
    let moved = |node: BinaryNode| BinaryNode { right: node.right.and_then(|right| right.checked_add(offset)), ..node };
    nodes.extend(subtree.into_iter().map(moved));
}

/// Which bin a doubled middle belongs to.
#[derive(Clone, Copy)]
struct Binning {
    low: [f32; 3],
    factor: [f32; 3],
    count: usize,
}

/// Adding it to a small number leaves the nearest whole number in the low bits.
const WHOLE: f32 = 8_388_608.0;

impl Binning {
    fn new(centers: &Bounds, items: usize) -> Self {
        let count = (4 + items / 8).min(BINS);
        let low = [centers.min(0), centers.min(1), centers.min(2)];
        let factor = |axis: usize| {
            let factor = (count - 1) as f32 / (centers.max(axis) - centers.min(axis));
            if factor.is_finite() { factor } else { 0.0 }
        };
        Self { low, factor: [factor(0), factor(1), factor(2)], count }
    }

    /// The nearest bin; never one that is not there.
    #[inline(always)]
    fn bin(&self, center: f32, axis: usize) -> usize {
        ((center - self.low[axis]) * self.factor[axis] + WHOLE).to_bits() as usize % BINS
    }
}

/// A split: items of `axis` in bins below `bin` go left.
struct Plane {
    binning: Binning,
    axis: usize,
    bin: usize,
    left: Bounds,
    right: Bounds,
}

#[derive(Clone)]
struct Bins {
    binning: Binning,
    bounds: [[Bounds; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

/// Puts items into bins.
struct Fill<'a> {
    items: &'a [Bounds],
    bins: &'a mut Bins,
}

impl Kernel for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Bins { binning, bounds, counts } = self.bins;
        for item in self.items {
            let center = item.twice_center();
            for axis in 0..3 {
                let bin = binning.bin(center[axis], axis);
                bounds[axis][bin].add(simd, item);
                counts[axis][bin] += 1;
            }
        }
    }
}

impl Bins {
    fn fill(part: &Part) -> Self {
        let empty = Self {
            binning: Binning::new(&part.centers, part.items.len()),
            bounds: [[Bounds::EMPTY; BINS]; 3],
            counts: [[0; BINS]; 3],
        };
        let fill = |(items, bins): &mut (&[Bounds], Self)| simd::dispatch(Fill { items, bins });
        if part.items.len() <= CHUNK {
            let mut task = (&*part.items, empty);
            fill(&mut task);
            return task.1;
        }
        let mut tasks: Vec<_> = part.items.chunks(CHUNK).map(|items| (items, empty.clone())).collect();
        for_each(&mut tasks, &fill);
        tasks.iter().fold(empty, |all, (_, bins)| all.with(bins))
    }

    /// All that is in either.
    fn with(mut self, other: &Self) -> Self {
        for (own, other) in self.bounds.as_flattened_mut().iter_mut().zip(other.bounds.as_flattened()) {
            *own = own.union(other);
        }
        for (own, other) in self.counts.as_flattened_mut().iter_mut().zip(other.counts.as_flattened()) {
            *own += other;
        }
        self
    }

    /// The split with the least cost; `None` where all middles are in one bin on every axis.
    fn best(&self) -> Option<Plane> {
        let mut best: Option<(f32, usize, usize)> = None;
        for axis in 0..3 {
            if self.binning.factor[axis] > 0.0
                && let Some((cost, bin)) = self.best_on(axis)
                && best.is_none_or(|(least, ..)| cost < least)
            {
                best = Some((cost, axis, bin));
            }
        }
        let (_, axis, bin) = best?;
        let union = |range: &[Bounds]| range.iter().fold(Bounds::EMPTY, |all, bounds| all.union(bounds));
        let (left, right) = self.bounds[axis][..self.binning.count].split_at(bin);
        Some(Plane { binning: self.binning, axis, bin, left: union(left), right: union(right) })
    }

    fn best_on(&self, axis: usize) -> Option<(f32, usize)> {
        let (bounds, counts, count) = (&self.bounds[axis], &self.counts[axis], self.binning.count);
        let packs = |triangles: u32| triangles.div_ceil(WIDTH as u32) as f32;
        let mut right_costs = [f32::INFINITY; BINS];
        let (mut right, mut triangles) = (Bounds::EMPTY, 0);
        for bin in (1..count).rev() {
            right = right.union(&bounds[bin]);
            triangles += counts[bin];
            right_costs[bin] = if triangles == 0 { f32::INFINITY } else { right.half_area() * packs(triangles) };
        }
        let mut best: Option<(f32, usize)> = None;
        let (mut left, mut triangles) = (Bounds::EMPTY, 0);
        for bin in 1..count {
            left = left.union(&bounds[bin - 1]);
            triangles += counts[bin - 1];
            if triangles == 0 {
                continue;
            }
            let cost = left.half_area() * packs(triangles) + right_costs[bin];
            if cost < best.map_or(f32::INFINITY, |(least, _)| least) {
                best = Some((cost, bin));
            }
        }
        best
    }
}
