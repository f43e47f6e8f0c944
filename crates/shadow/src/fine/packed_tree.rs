//! A tree over boxes in light space that are in order: eight to a node, eight nodes to a node above.
//!
//! The tree has no pointers: node n of a level holds numbers 8n to 8n + 7 of the level below (a packed tree, Kamel and Faloutsos
//! 1993). A box has an extent across the light, in whole numbers, and a least depth. Boxes that follow each other should lie together: [`key`] puts
//! large ones first, then all along a Morton curve (Morton 1966). Cost: a look at every box, and 23 bytes each.

use umbriel_geometry::simd::{F8, Float, I8, Int, Mask, Simd};

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// Levels of a tree at most: over 2^32 boxes.
const LEVELS: usize = 11;

/// A box of images, quanta.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rect {
    pub(super) min: [i32; 2],
    pub(super) max: [i32; 2],
}

impl Rect {
    pub(super) const EMPTY: Self = Self { min: [i32::MAX; 2], max: [i32::MIN; 2] };

    /// More than any window.
    pub(super) const EVERYWHERE: Self = Self { min: [-(1 << 30); 2], max: [1 << 30; 2] };

    #[inline(always)]
    pub(super) fn union(&self, other: &Self) -> Self {
        Self {
            min: [self.min[0].min(other.min[0]), self.min[1].min(other.min[1])],
            max: [self.max[0].max(other.max[0]), self.max[1].max(other.max[1])],
        }
    }

    /// What both share; its least corner may lie beyond its greatest.
    pub(super) fn intersection(&self, other: &Self) -> Self {
        Self {
            min: [self.min[0].max(other.min[0]), self.min[1].max(other.min[1])],
            max: [self.max[0].min(other.max[0]), self.max[1].min(other.max[1])],
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.min[0] > self.max[0] || self.min[1] > self.max[1]
    }

    /// Square quanta, sides one longer.
    pub(super) fn area(&self) -> f64 {
        let side = |k: usize| f64::from(self.max[k]) - f64::from(self.min[k]) + 1.0;
        side(0) * side(1)
    }

    /// The longer side, quanta.
    #[inline(always)]
    pub(super) fn longest(&self) -> i64 {
        let side = |k: usize| i64::from(self.max[k]) - i64::from(self.min[k]);
        side(0).max(side(1))
    }

    /// Farther by `wide` on all sides; inside of [`Rect::EVERYWHERE`] still an `i32`.
    #[inline(always)]
    pub(super) fn widened(&self, wide: i32) -> Self {
        Self { min: self.min.map(|x| x.saturating_sub(wide)), max: self.max.map(|x| x.saturating_add(wide)) }
    }

    #[inline(always)]
    pub(super) fn center(&self) -> [i32; 2] {
        [0, 1].map(|k| self.min[k].midpoint(self.max[k]))
    }
}

/// Classes of size have four binary digits each.
const CLASS: u32 = 4;

/// Bits of a key's place along the curve.
const CURVE_BITS: u32 = 40;

/// A box's place in an order: sizes by factors of 16, large ones first, `is_late` after the others of a size, then along the curve. `offset` binary
/// digits are counted before the first.
pub(super) fn key(rect: &Rect, is_late: bool, offset: u32) -> u64 {
    let class = ((digits(rect) + offset) / CLASS).min(7);
    let [x, y] = rect.center().map(|x| (x + (1 << 29)).clamp(0, (1 << 30) - 1) as u64 >> 10);
    u64::from(7 - class) << (CURVE_BITS + 1) | u64::from(is_late) << CURVE_BITS | spread(x) | spread(y) << 1
}

/// Binary digits of the longer side of a box, 31 at most.
#[inline(always)]
pub(super) fn digits(rect: &Rect) -> u32 {
    (64 - rect.longest().leading_zeros()).min(31)
}

/// The bits of a 20-bit number at even places.
fn spread(x: u64) -> u64 {
    let x = (x | x << 16) & 0x0000_ffff_0000_ffff;
    let x = (x | x << 8) & 0x00ff_00ff_00ff_00ff;
    let x = (x | x << 4) & 0x0f0f_0f0f_0f0f_0f0f;
    let x = (x | x << 2) & 0x3333_3333_3333_3333;
    (x | x << 1) & 0x5555_5555_5555_5555
}

/// The boxes of eight.
#[derive(Clone, Debug)]
pub(super) struct Node {
    min: [[i32; WIDTH]; 2],
    max: [[i32; WIDTH]; 2],
    nearest: [f32; WIDTH],
}

impl Node {
    /// Eight boxes of nothing.
    pub(super) const EMPTY: Self =
        Self { min: [[i32::MAX; WIDTH]; 2], max: [[i32::MIN; WIDTH]; 2], nearest: [f32::INFINITY; WIDTH] };

    /// The boxes in the lanes of vectors.
    #[inline(always)]
    pub(super) fn of_lanes<S: Simd>([min, max]: [[I8<S>; 2]; 2], nearest: F8<S>) -> Self {
        Self {
            min: [min[0].to_array(), min[1].to_array()],
            max: [max[0].to_array(), max[1].to_array()],
            nearest: nearest.to_array(),
        }
    }

    /// Of eight boxes with their least depths at most.
    pub(super) fn of(boxes: impl Iterator<Item = (Rect, f32)>) -> Self {
        let mut node = Self::EMPTY;
        boxes.enumerate().for_each(|(lane, (rect, nearest))| node.add(lane, &rect, nearest));
        node
    }

    /// Widens the box in a lane.
    #[inline(always)]
    pub(super) fn add(&mut self, lane: usize, rect: &Rect, nearest: f32) {
        for k in 0..2 {
            self.min[k][lane] = self.min[k][lane].min(rect.min[k]);
            self.max[k][lane] = self.max[k][lane].max(rect.max[k]);
        }
        self.nearest[lane] = self.nearest[lane].min(nearest);
    }

    /// The box round all lanes.
    fn whole(&self) -> (Rect, f32) {
        let least = |values: &[i32; WIDTH]| values.iter().copied().fold(i32::MAX, i32::min);
        let most = |values: &[i32; WIDTH]| values.iter().copied().fold(i32::MIN, i32::max);
        let rect =
            Rect { min: [least(&self.min[0]), least(&self.min[1])], max: [most(&self.max[0]), most(&self.max[1])] };
        (rect, self.nearest.iter().copied().fold(f32::INFINITY, f32::min))
    }

    /// The lanes whose boxes meet a box of images and are not all deeper than `farthest`.
    #[inline(always)]
    pub(super) fn overlapping<S: Simd>(&self, simd: S, rect: &Rect, farthest: f32) -> u32 {
        let mut beside = simd.load(&self.nearest).gt(simd.splat8(farthest));
        for k in 0..2 {
            beside = beside | simd.load_int(&self.max[k]).lt(simd.splat_int8(rect.min[k]));
            beside = beside | simd.splat_int8(rect.max[k]).lt(simd.load_int(&self.min[k]));
        }
        (!beside).bits()
    }
}

/// Boxes and what is above them.
#[derive(Debug)]
pub(super) struct Tree {
    /// From the boxes up to a single node.
    levels: Vec<Vec<Node>>,
}

impl Tree {
    /// Of boxes with their least depths, in order.
    pub(super) fn of_boxes(boxes: &[(Rect, f32)]) -> Self {
        Self::above(boxes.chunks(WIDTH).map(|boxes| Node::of(boxes.iter().copied())).collect())
    }

    /// Over nodes of eight boxes each.
    pub(super) fn above(lowest: Vec<Node>) -> Self {
        let mut levels = vec![lowest];
        while let Some(below) = levels.last().filter(|below| below.len() > 1) {
            let above = below.chunks(WIDTH).map(|children| Node::of(children.iter().map(Node::whole))).collect();
            levels.push(above);
        }
        Self { levels }
    }

    /// The next box of a walk that meets a box and is not all deeper than `farthest`; in order.
    #[inline(always)]
    pub(super) fn walk<S: Simd>(&self, simd: S, rect: &Rect, farthest: f32, path: &mut Path) -> Option<usize> {
        loop {
            let Step { level, node, lanes } = &mut path.steps[path.len.checked_sub(1)?];
            if *lanes == 0 {
                path.len -= 1;
                continue;
            }
            let child = *node * WIDTH as u32 + lanes.trailing_zeros();
            *lanes &= *lanes - 1;
            if *level == 0 {
                return Some(child as usize);
            }
            let level = *level - 1;
            let lanes = self.levels[level][child as usize].overlapping(simd, rect, farthest);
            path.push(Step { level, node: child, lanes });
        }
    }

    /// A box and its least depth.
    #[inline(always)]
    pub(super) fn bounds(&self, number: usize) -> (Rect, f32) {
        let (node, lane) = (&self.levels[0][number / WIDTH], number % WIDTH);
        let rect = Rect { min: [node.min[0][lane], node.min[1][lane]], max: [node.max[0][lane], node.max[1][lane]] };
        (rect, node.nearest[lane])
    }

    /// Begins a walk.
    #[inline(always)]
    pub(super) fn begin<S: Simd>(&self, simd: S, rect: &Rect, farthest: f32, path: &mut Path) {
        path.len = 0;
        let level = self.levels.len() - 1;
        if let Some(top) = self.levels[level].first() {
            path.push(Step { level, node: 0, lanes: top.overlapping(simd, rect, farthest) });
        }
    }
}

/// Where a walk is: the nodes from the top down.
#[derive(Debug, Default)]
pub(super) struct Path {
    steps: [Step; LEVELS],
    len: usize,
}

impl Path {
    #[inline(always)]
    fn push(&mut self, step: Step) {
        self.steps[self.len] = step;
        self.len += 1;
    }
}

/// A node, and the children still to be seen.
#[derive(Clone, Copy, Debug, Default)]
struct Step {
    level: usize,
    node: u32,
    lanes: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_put_large_boxes_first_and_neighbours_together() {
        let at = |x: i32, y: i32, size: i32| key(&Rect { min: [x, y], max: [x + size, y + size] }, false, 0);
        assert!(at(0, 0, 1 << 20) < at(-500_000, -500_000, 1 << 10));
        assert!(at(-5_000_000, -5_000_000, 9) < at(-5_000_000, 5_000_000, 9));
        assert!(at(5_000_000, -5_000_000, 9) < at(-5_000_000, 5_000_000, 9));
        assert_eq!(at(7, 9, 3), at(8, 9, 3), "closer than the curve's steps");
    }
}
