//! Boxes over what is in order: eight faces a pack, eight packs or volumes a node, eight nodes a node above.
//!
//! The tree has no pointers: node n of a level holds numbers 8n to 8n + 7 of the level below (a packed tree, Kamel and Faloutsos
//! 1993). A box has an extent in the image and a least depth. Cost: a look at every face, and 20 bytes a pack.

use rayon::prelude::*;
use umbriel_geometry::simd::{Float, Int, Mask, Simd};

use super::{
    faces::Rect,
    pack::{Pack, Triangles},
};

/// Children of a node, and faces of a pack.
pub(super) const WIDTH: usize = 8;

/// Nodes that a thread makes at a time, at least.
const NODES: usize = 64;

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

    /// The boxes of eight triangles.
    #[inline(always)]
    pub(super) fn of_triangles<S: Simd>(triangles: &Triangles<S>) -> Self {
        let [min, max] = triangles.boxes();
        Self {
            min: [min[0].to_array(), min[1].to_array()],
            max: [max[0].to_array(), max[1].to_array()],
            nearest: triangles.nearest().to_array(),
        }
    }

    /// Of eight boxes with their least depths at most.
    fn of(boxes: impl Iterator<Item = (Rect, f32)>) -> Self {
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

/// The boxes of all packs and of what is above them.
pub(super) struct Tree {
    /// From the packs' boxes up to a single node.
    levels: Vec<Vec<Node>>,
}

impl Tree {
    /// Of packs in order.
    pub(super) fn of_packs(packs: &[Pack]) -> Self {
        let lowest = packs.par_chunks(WIDTH).with_min_len(NODES).map(|packs| Node::of(packs.iter().map(Pack::bounds)));
        Self::above(lowest.collect())
    }

    /// Of boxes with their least depths, in order; on one thread.
    pub(super) fn of_boxes(boxes: &[(Rect, f32)]) -> Self {
        Self::above(boxes.chunks(WIDTH).map(|boxes| Node::of(boxes.iter().copied())).collect())
    }

    fn above(lowest: Vec<Node>) -> Self {
        let mut levels = vec![lowest];
        while let Some(below) = levels.last().filter(|below| below.len() > 1) {
            let above = below.chunks(WIDTH).map(|children| Node::of(children.iter().map(Node::whole))).collect();
            levels.push(above);
        }
        Self { levels }
    }

    /// The next pack of a walk that may hold something over a box of images, not all deeper than `farthest`; in order.
    #[inline(always)]
    pub(super) fn walk<S: Simd>(&self, simd: S, rect: &Rect, farthest: f32, path: &mut Vec<Step>) -> Option<usize> {
        loop {
            let Step { level, node, lanes } = path.last_mut()?;
            if *lanes == 0 {
                path.pop();
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

    /// The box of a pack and its least depth.
    #[inline(always)]
    pub(super) fn bounds(&self, pack: usize) -> (Rect, f32) {
        let (node, lane) = (&self.levels[0][pack / WIDTH], pack % WIDTH);
        let rect = Rect { min: [node.min[0][lane], node.min[1][lane]], max: [node.max[0][lane], node.max[1][lane]] };
        (rect, node.nearest[lane])
    }

    /// Begins a walk.
    #[inline(always)]
    pub(super) fn begin<S: Simd>(&self, simd: S, rect: &Rect, farthest: f32, path: &mut Vec<Step>) {
        path.clear();
        let level = self.levels.len() - 1;
        if let Some(top) = self.levels[level].first() {
            path.push(Step { level, node: 0, lanes: top.overlapping(simd, rect, farthest) });
        }
    }
}

/// Where a walk is: a node, and the children still to be seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    level: usize,
    node: u32,
    lanes: u32,
}
