//! A binary tree by the surface-area heuristic over bins.
//!
//! Wald, "On fast construction of SAH-based bounding volume hierarchies", IEEE Symposium on Interactive Ray Tracing
//! 2007, counting packs instead of triangles: a part with n triangles costs its area times ⌈n/8⌉. Leaves hold up to
//! eight triangles. O(n log n); the depth is at most [`MAX_DEPTH`]. Nodes lie in preorder. The tree depends on the
//! triangles and their order alone.

use super::super::{bounds::Bounds, layout::WIDTH};

/// Most nodes on a way from the root to a leaf.
pub(in super::super) const MAX_DEPTH: usize = 48;

/// Bins on an axis, at most.
const BINS: usize = 16;

/// Below so many triangles a part is not worth a thread.
#[cfg(feature = "rayon")]
const SERIAL: usize = 4096;

/// A node over the items `first .. first + count`.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    pub(super) bounds: Bounds,
    pub(super) first: u32,
    pub(super) count: u32,
    /// The right child; the left one is the next node. `None` for a leaf.
    pub(super) right: Option<std::num::NonZeroU32>,
}

/// Builds the tree over tagged boxes, which are put in leaf order. `items` must not be empty.
pub(super) fn build(items: &mut [Bounds]) -> Vec<BinaryNode> {
    let mut nodes = Vec::with_capacity(items.len() / 2);
    let centers = centers_of(items);
    let bounds = items.iter().fold(Bounds::EMPTY, |all, item| all.union(item));
    Part { items, first: 0, depth: 1, centers, bounds }.build(&mut nodes);
    nodes
}

/// The box of the items' middles, doubled.
fn centers_of(items: &[Bounds]) -> Bounds {
    items.iter().fold(Bounds::EMPTY, |all, item| all.union(&Bounds::of_point(&item.twice_center())))
}

/// Items that become a subtree.
struct Part<'a> {
    items: &'a mut [Bounds],
    /// Index of the first of them in leaf order.
    first: u32,
    /// Of the subtree's root; the tree's root has depth 1.
    depth: usize,
    /// The box of the middles, doubled.
    centers: Bounds,
    bounds: Bounds,
}

impl<'a> Part<'a> {
    /// Appends the subtree to `nodes`.
    fn build(self, nodes: &mut Vec<BinaryNode>) {
        let index = nodes.len();
        let (first, count) = (self.first, self.items.len() as u32);
        nodes.push(BinaryNode { bounds: self.bounds, first, count, right: None });
        if self.items.len() <= WIDTH {
            return;
        }
        let (left, right) = self.split();
        #[cfg(feature = "rayon")]
        if count as usize > SERIAL {
            let subtree = |part: Part| {
                let mut nodes = Vec::with_capacity(part.items.len() / 2);
                part.build(&mut nodes);
                nodes
            };
            let (left, right) = rayon::join(|| subtree(left), || subtree(right));
            append(nodes, left);
            nodes[index].right = std::num::NonZeroU32::new(nodes.len() as u32);
            append(nodes, right);
            return;
        }
        left.build(nodes);
        nodes[index].right = std::num::NonZeroU32::new(nodes.len() as u32);
        right.build(nodes);
    }

    fn split(self) -> (Part<'a>, Part<'a>) {
        // What is left of the depth must do for halving down to leaves.
        let halvings = (self.items.len().div_ceil(WIDTH)).next_power_of_two().trailing_zeros() as usize;
        let best = if self.depth + halvings >= MAX_DEPTH { None } else { Bins::fill(&self).best() };
        match best {
            Some(plane) => self.partition(&plane),
            None => self.halve(),
        }
    }

    /// In the order that the items have: middles coincide, or the depth runs out.
    fn halve(self) -> (Part<'a>, Part<'a>) {
        let middle = self.items.len() / 2;
        let (left, right) = self.items.split_at_mut(middle);
        let part = |items: &'a mut [Bounds], first| {
            let bounds = items.iter().fold(Bounds::EMPTY, |all, item| all.union(item));
            Part { centers: centers_of(items), bounds, items, first, depth: self.depth + 1 }
        };
        (part(left, self.first), part(right, self.first + middle as u32))
    }

    fn partition(self, plane: &Plane) -> (Part<'a>, Part<'a>) {
        let items = self.items;
        let (mut left, mut right) = (Bounds::EMPTY, Bounds::EMPTY);
        let (mut low, mut high) = (0, items.len());
        while low < high {
            let center = items[low].twice_center();
            if plane.binning.bin(center[plane.axis], plane.axis) < plane.bin {
                left = left.union(&Bounds::of_point(&center));
                low += 1;
            } else {
                right = right.union(&Bounds::of_point(&center));
                high -= 1;
                items.swap(low, high);
            }
        }
        let (left_items, right_items) = items.split_at_mut(low);
        let depth = self.depth + 1;
        let second = self.first + low as u32;
        (
            Part { items: left_items, first: self.first, depth, centers: left, bounds: plane.left },
            Part { items: right_items, first: second, depth, centers: right, bounds: plane.right },
        )
    }
}

/// Puts a subtree behind the nodes that are there.
#[cfg(feature = "rayon")]
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

impl Binning {
    fn new(centers: &Bounds, items: usize) -> Self {
        let count = (4 + items / 8).min(BINS);
        let low = [0, 1, 2].map(|axis| centers.min(axis));
        let factor = [0, 1, 2].map(|axis| {
            let width = centers.max(axis) - centers.min(axis);
            // Just below the count, so that the greatest middle falls into the last bin.
            let factor = count as f32 * 0.999_99 / width;
            if factor.is_finite() { factor } else { 0.0 }
        });
        Self { low, factor, count }
    }

    #[inline(always)]
    fn bin(&self, center: f32, axis: usize) -> usize {
        (((center - self.low[axis]) * self.factor[axis]) as usize).min(BINS - 1)
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

struct Bins {
    binning: Binning,
    bounds: [[Bounds; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    fn fill(part: &Part) -> Self {
        let binning = Binning::new(&part.centers, part.items.len());
        let mut bins = Self { binning, bounds: [[Bounds::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };
        for item in part.items.iter() {
            let [x, y, z, _] = item.twice_center();
            for (axis, center) in [x, y, z].into_iter().enumerate() {
                let bin = binning.bin(center, axis);
                bins.bounds[axis][bin] = bins.bounds[axis][bin].union(item);
                bins.counts[axis][bin] += 1;
            }
        }
        bins
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
