//! The ordinary traversal of the same octree, from the root down: the counterpart of the maps.
//!
//! Parametric, after Revelles, Ureña and Lastra, "An efficient parametric algorithm for octree traversal", WSCG 2000: a cell
//! is the range of ray parameters (here depths) between its planes; halving it needs the means of the planes' parameters, the first
//! child is told by comparing them with the parameter of entry, and each next one by the plane that is left through. Axes on which
//! the ray runs down are turned. O(leaves met × levels).
//!
//! *Rounding* moves a place of the ray by some u of the cube's size, which is less than the leaves' slack: the cells visited
//! together hold the ray up to that. A direction component below 2^-60 counts as that; it moves the ray by less over the scene. Rays known
//! too roughly (see [`query`](super::query)) look at every leaf.

use glam::DVec3;
use umbriel_geometry::simd::{Kernel, Simd, dispatch};

use super::{
    Leaf,
    frame::Kind,
    query::{Look, Walk},
    tree::{LEAF, Link, NOTHING},
};

/// The least size of a direction's component: 2^-60.
const LEAST: f64 = 1.0 / (1u64 << 60) as f64;

/// A cell with the parameters of its planes.
#[derive(Clone, Copy)]
struct Open {
    node: Link,
    near: DVec3,
    far: DVec3,
}

/// What does not change on the way down.
#[derive(Clone, Copy)]
struct Line {
    /// Axes that are turned.
    turned: usize,
    /// Where the ray begins.
    first: f64,
}

/// A leaf that is come to. A kernel of its own, because what calls itself is in no kernel, and vectors there would be functions.
struct LookAt<'w, 'a, L> {
    walk: &'w mut Walk<'a, L>,
    leaf: &'a Leaf,
}

impl<L: Look> Kernel for LookAt<'_, '_, L> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        self.walk.look_at(simd, self.leaf)
    }
}

impl<L: Look> Walk<'_, L> {
    /// Walks down from the root.
    #[inline(always)]
    pub(super) fn by_descent<S: Simd>(&mut self, simd: S) {
        let projection = self.projection;
        let (root, kind) = (&projection.root, projection.frame.kind);
        if self.sight.spread > 0.25 * root.slack {
            let _ = projection.leaves.iter().any(|leaf| self.look_at(simd, leaf));
            return;
        }
        let (start, along) = match kind {
            Kind::Parallel => (self.sight.direction.with_z(0.0), DVec3::Z),
            _ => (DVec3::ZERO, self.sight.direction),
        };
        let sizes = along.abs().max(DVec3::splat(LEAST));
        let along = sizes * DVec3::select(along.cmplt(DVec3::ZERO), DVec3::NEG_ONE, DVec3::ONE);
        let (low, high) = ((root.min - start) / along, (root.min + root.edge - start) / along);
        let turned = along.cmplt(DVec3::ZERO).bitmask() as usize;
        let first = self.sight.begin;
        let open = Open { node: projection.tree.root, near: low.min(high), far: low.max(high) };
        let enter = open.near.max_element().max(first);
        if enter <= open.far.min_element() && open.node != NOTHING {
            self.down(&Line { turned, first }, open, enter);
        }
    }

    /// Visits what is below a cell, front to back; true when all is found.
    fn down(&mut self, line: &Line, open: Open, mut enter: f64) -> bool {
        if open.node & LEAF != 0 {
            let leaf = &self.projection.leaves[(open.node & !LEAF) as usize];
            return dispatch(LookAt { walk: self, leaf })
                || self.look.depth().is_some_and(|depth| depth <= open.far.min_element());
        }
        let children = &self.projection.tree.nodes[open.node as usize];
        let middle = (open.near + open.far) * 0.5;
        let mut upper = DVec3::splat(enter).cmpge(middle).bitmask() as usize;
        loop {
            let is_upper = |axis: usize| upper >> axis & 1 == 1;
            let pick = |axis: usize| {
                if is_upper(axis) { [middle[axis], open.far[axis]] } else { [open.near[axis], middle[axis]] }
            };
            let [x, y, z] = [pick(0), pick(1), pick(2)];
            let (near, far) = (DVec3::new(x[0], y[0], z[0]), DVec3::new(x[1], y[1], z[1]));
            let exit = far.min_element();
            let node = children[upper ^ line.turned];
            if node != NOTHING && exit >= line.first && self.down(line, Open { node, near, far }, enter) {
                return true;
            }
            let axis = if exit == far.x { 0 } else { 1 + usize::from(exit != far.y) };
            if is_upper(axis) {
                return false;
            }
            upper |= 1 << axis;
            enter = exit.max(enter);
            if self.is_behind(enter) {
                return true;
            }
        }
    }
}
