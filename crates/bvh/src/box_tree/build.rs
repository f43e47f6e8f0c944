//! Top-down construction: bins along each axis, the cheapest plane between bins, halves where no plane helps.
//!
//! Every choice is made from counts, minima and maxima, which do not depend on the order of the boxes.

use std::cmp::Ordering;

use glam::DVec3;
use umbriel_geometry::Aabb;

use super::{BoxTree, MAX_DEPTH, Node};

/// Most items in a leaf: their boxes are tested one by one, which costs less than another two nodes.
const LEAF_ITEMS: usize = 4;

/// Bins an axis. More bins find little better planes (Wald 2007, section 4).
const BINS: usize = 16;

/// From this depth on nodes are halved. Halving 2^32 items takes at most 32 levels, so no tree is deeper than
/// `MAX_DEPTH`, whatever the boxes.
const HALVING_DEPTH: usize = 46;

const _: () = assert!(HALVING_DEPTH + 1 + 32 < MAX_DEPTH);

/// An item while the tree is built.
#[derive(Clone, Copy)]
struct Entry {
    bounds: Aabb,
    id: u32,
}

impl Entry {
    /// Its middle along an axis. Finite: boxes may reach to infinity, and only the shape of the tree depends on this.
    #[inline]
    fn center(&self, axis: usize) -> f64 {
        let center = self.bounds.min[axis] * 0.5 + self.bounds.max[axis] * 0.5;
        if center.is_nan() { 0.0 } else { center.clamp(-f64::MAX, f64::MAX) }
    }
}

/// A node that waits for its children: its index, its items, its depth (the root's is 1).
struct Open {
    node: usize,
    first: usize,
    end: usize,
    depth: usize,
}

/// After so many looks at boxes it is asked whether to go on; some tenths of a millisecond.
const LOOKS: usize = 1 << 13;

/// See [`BoxTree::build_while`].
pub(super) fn build(boxes: &[Aabb], goes_on: &dyn Fn() -> bool) -> Option<BoxTree> {
    assert!(u32::try_from(boxes.len()).is_ok(), "more boxes than a u32 can name");
    let mut entries: Vec<Entry> = (0u32..)
        .zip(boxes)
        .filter(|(_, bounds)| !bounds.is_empty())
        .map(|(id, &bounds)| Entry { bounds, id })
        .collect();
    let mut nodes = Vec::new();
    if !entries.is_empty() {
        nodes.push(leaf(&entries, 0));
        let mut open = vec![Open { node: 0, first: 0, end: entries.len(), depth: 1 }];
        let mut looks = 0;
        while let Some(next) = open.pop() {
            looks += next.end - next.first;
            if looks >= LOOKS {
                looks = 0;
                if !goes_on() {
                    return None;
                }
            }
            grow(&mut nodes, &mut entries, &next, &mut open);
        }
    }
    let (item_boxes, ids) = entries.iter().map(|entry| (entry.bounds, entry.id)).unzip();
    nodes.shrink_to_fit(); // a tree may be kept for each of thousands of objects
    Some(BoxTree { nodes, boxes: item_boxes, ids, len: boxes.len() })
}

/// Gives an open node its two children, or leaves it a leaf.
fn grow(nodes: &mut Vec<Node>, entries: &mut [Entry], next: &Open, open: &mut Vec<Open>) {
    let items = &mut entries[next.first..next.end];
    if items.len() <= LEAF_ITEMS {
        items.sort_unstable_by_key(|entry| entry.id);
        return;
    }
    let middle = next.first + split(items, &nodes[next.node].bounds, next.depth);
    let left = nodes.len();
    nodes.push(leaf(&entries[next.first..middle], next.first));
    nodes.push(leaf(&entries[middle..next.end], middle));
    (nodes[next.node].first, nodes[next.node].count) = (left as u32, 0);
    let depth = next.depth + 1;
    open.push(Open { node: left + 1, first: middle, end: next.end, depth });
    open.push(Open { node: left, first: next.first, end: middle, depth });
}

/// A leaf over `entries`, which begin at `first` in leaf order.
fn leaf(entries: &[Entry], first: usize) -> Node {
    let bounds = entries.iter().fold(Aabb::EMPTY, |sum, entry| sum.union(entry.bounds));
    Node { bounds, first: first as u32, count: entries.len() as u32 }
}

/// Orders the items so that those before the returned index go left, the others right; neither side is empty.
fn split(items: &mut [Entry], bounds: &Aabb, depth: usize) -> usize {
    let centers = Aabb::of(items.iter().map(|entry| DVec3::from_array([0, 1, 2].map(|axis| entry.center(axis)))));
    if depth < HALVING_DEPTH
        && let Some(plane) = cheapest_plane(items, &centers)
    {
        return partition(items, |entry| plane.bin_of(entry) <= plane.last);
    }
    halve(items, longest_axis(if centers.size() == DVec3::ZERO { bounds } else { &centers }))
}

/// A plane between bins: bins up to `last` lie below it.
struct Plane {
    axis: usize,
    least: f64,
    bins_per_length: f64,
    last: usize,
}

impl Plane {
    /// Bins along an axis between the least and the greatest centre.
    fn bins(axis: usize, centers: &Aabb) -> Self {
        let (least, greatest) = (centers.min[axis], centers.max[axis]);
        Self { axis, least, bins_per_length: BINS as f64 / (greatest - least), last: 0 }
    }

    /// The bin of an item. The cast takes NaN to 0 and clips, so every item has one.
    #[inline]
    fn bin_of(&self, entry: &Entry) -> usize {
        (((entry.center(self.axis) - self.least) * self.bins_per_length) as usize).min(BINS - 1)
    }
}

/// What falls into the bins of an axis: how many items, and the box around them.
type Bins = [(usize, Aabb); BINS];

/// The plane of least cost over all axes; `None` when no plane has items on both sides.
fn cheapest_plane(items: &[Entry], centers: &Aabb) -> Option<Plane> {
    let planes = [0, 1, 2].map(|axis| Plane::bins(axis, centers));
    let mut best: Option<(f64, Plane)> = None;
    for (bins, plane) in fill_bins(items, &planes).iter().zip(planes) {
        let Some((cost, last)) = cheapest_bin(bins) else { continue };
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, Plane { last, ..plane }));
        }
    }
    best.map(|(_, plane)| plane)
}

/// Fills the bins of all axes in one walk over the items.
fn fill_bins(items: &[Entry], planes: &[Plane; 3]) -> [Bins; 3] {
    let mut bins = [[(0, Aabb::EMPTY); BINS]; 3];
    for entry in items {
        for (bins, plane) in bins.iter_mut().zip(planes) {
            let (count, bounds) = &mut bins[plane.bin_of(entry)];
            *count += 1;
            *bounds = bounds.union(entry.bounds);
        }
    }
    bins
}

/// The least cost (surface area times items, both sides summed) and the last bin below its plane.
fn cheapest_bin(bins: &Bins) -> Option<(f64, usize)> {
    let mut above = [(0, 0.0); BINS];
    let (mut count, mut bounds) = (0, Aabb::EMPTY);
    for index in (1..BINS).rev() {
        count += bins[index].0;
        bounds = bounds.union(bins[index].1);
        above[index - 1] = (count, bounds.half_area() * count as f64);
    }
    let (mut count, mut bounds) = (0, Aabb::EMPTY);
    let mut best: Option<(f64, usize)> = None;
    for (last, &(items_above, cost_above)) in above.iter().enumerate() {
        count += bins[last].0;
        bounds = bounds.union(bins[last].1);
        let cost = bounds.half_area() * count as f64 + cost_above;
        if count > 0 && items_above > 0 && best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, last));
        }
    }
    best
}

/// Moves the items that `goes_left` accepts to the front and returns how many they are.
fn partition(items: &mut [Entry], goes_left: impl Fn(&Entry) -> bool) -> usize {
    let mut left = 0;
    for index in 0..items.len() {
        if goes_left(&items[index]) {
            items.swap(left, index);
            left += 1;
        }
    }
    left
}

/// Half of the items each side, by their centres along `axis`, then by their boxes.
fn halve(items: &mut [Entry], axis: usize) -> usize {
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| in_order(a, b, axis));
    middle
}

/// A total order that leaves nothing but equal boxes to their ids.
fn in_order(a: &Entry, b: &Entry, axis: usize) -> Ordering {
    let key = |entry: &Entry| [entry.bounds.min.to_array(), entry.bounds.max.to_array()];
    let boxes =
        || key(a).iter().flatten().zip(key(b).iter().flatten()).map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne());
    let by_box = || boxes().unwrap_or(Ordering::Equal);
    a.center(axis).total_cmp(&b.center(axis)).then_with(by_box).then_with(|| a.id.cmp(&b.id))
}

/// The axis on which the box is longest; the first of equals.
fn longest_axis(bounds: &Aabb) -> usize {
    let size = bounds.size();
    (1..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best })
}
