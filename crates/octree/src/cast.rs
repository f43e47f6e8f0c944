//! Which leaves does a ray meet, in which order? Parametric, on the sorted list.
//!
//! After Revelles, Ureña & Lastra, "An Efficient Parametric Algorithm for Octree Traversal", WSCG 2000: a cell is the
//! range of ray parameters between its planes, and halving the cell needs one more plane on each axis. What differs:
//!
//! - there are no pointers: a cell is a Morton code and a run of the sorted list, and the open cells are on a stack;
//! - a plane's parameter is computed from the plane, not from its parent's, and carries its error;
//! - cells and rays are closed. A ray along a face or an edge meets the cells on all sides of it, one through a corner
//!   all that touch there.
//!
//! **No leaf is missed, none is met in vain.** A closed cell is the intersection of three slabs. On the ray's line a slab
//! is a closed interval of parameters: between the parameters of its two planes, or everything or nothing where the line
//! runs along the slab. The ray itself is an interval too. Intervals have a common point exactly when every two of them
//! have one (Helly's theorem on the line), so a cell is met exactly when no interval begins behind the end of another.
//! Parameters are floats with outward bounds; where these overlap the two are compared as fractions of exact dyadics.
//! A leaf that is met lies in cells that are met, up to the root, and every met child of a met cell is visited.
//!
//! O((met + log leaves)·levels). What breaks it: nothing in range.

use std::{cmp::Ordering, ops::Range};

use umbriel_geometry::decisions::{Level, count};

use crate::{cube::CELLS, morton::Octant, partition::Partition};

mod mark;
mod ray;

use mark::{Mark, Marks};
pub use ray::{Ray, RayDefect};

/// A leaf that a ray meets, and where on the ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The leaf's place in the list.
    pub leaf: usize,
    /// Parameter of the first common point, rounded down.
    pub enter: f64,
    /// Parameter of the last common point, rounded up.
    pub exit: f64,
}

/// A cell that the ray meets.
#[derive(Clone, Debug)]
struct Open {
    cell: Octant,
    run: Range<usize>,
    near: [Mark; 3],
    far: [Mark; 3],
    enter: f64,
}

/// The leaves that a ray meets, each once: an iterator in the order of [`Crossing::enter`]. Of leaves that are entered at
/// one parameter, those with lower coordinates along the ray tend to come first.
#[derive(Clone, Debug)]
pub struct Cast<'a> {
    partition: &'a Partition,
    marks: Marks,
    /// Sorted, the next one last. Children begin no earlier than their parent, so what is taken from it is sorted too.
    open: Vec<Open>,
}

impl<'a> Cast<'a> {
    pub(crate) fn new(partition: &'a Partition, ray: &Ray) -> Self {
        let marks = Marks::new(*partition.cube(), *ray);
        let mut cast = Self { partition, marks, open: Vec::new() };
        let (mut near, mut far) = ([Mark::BEFORE_ALL; 3], [Mark::BEHIND_ALL; 3]);
        let mut is_beside = false;
        for axis in 0..3 {
            match cast.marks.heading(axis) {
                Ordering::Equal => {
                    let is_within = cast.marks.side(axis, 0).is_ge() && cast.marks.side(axis, CELLS).is_le();
                    is_beside |= !is_within;
                }
                Ordering::Greater => {
                    (near[axis], far[axis]) = (cast.marks.mark(axis, 0), cast.marks.mark(axis, CELLS));
                }
                Ordering::Less => (near[axis], far[axis]) = (cast.marks.mark(axis, CELLS), cast.marks.mark(axis, 0)),
            }
        }
        if !is_beside && cast.marks.overlap(&near, &far) {
            let (enter, run) = (cast.marks.enter(&near), 0..partition.cells().len());
            cast.open.push(Open { cell: Octant::ROOT, run, near, far, enter });
        }
        cast
    }

    /// Puts the children that the ray meets on the stack.
    fn halve(&mut self, parent: &Open) {
        let below = Octant::MAX_LEVEL - parent.cell.level() - 1;
        let middle = parent.cell.coordinates().map(|place| (2 * place + 1) << below);
        let marks: [Mark; 3] = std::array::from_fn(|axis| match self.marks.heading(axis) {
            Ordering::Equal => Mark::BEFORE_ALL,
            _ => self.marks.mark(axis, middle[axis]),
        });
        // One look at the bounds a child; pairs of marks that are compared exactly count for themselves.
        count(Level::Double, 8);
        // Bits of the axes along which the ray runs down: the order of its visits is Morton order with these turned.
        let turned = (0..3).filter(|&axis| self.marks.heading(axis).is_lt()).fold(0, |bits, axis| bits | 1 << axis);
        for order in (0..8u8).rev() {
            let number = order ^ turned;
            let (mut near, mut far) = (parent.near, parent.far);
            let mut is_beside = false;
            for axis in 0..3 {
                let is_upper = number >> axis & 1 == 1;
                match self.marks.heading(axis) {
                    Ordering::Equal => {
                        let side = self.marks.side(axis, middle[axis]);
                        is_beside |= if is_upper { side.is_lt() } else { side.is_gt() };
                    }
                    heading if is_upper == heading.is_gt() => near[axis] = marks[axis],
                    _ => far[axis] = marks[axis],
                }
            }
            if !is_beside && self.marks.overlap(&near, &far) {
                self.push(parent, number, near, far);
            }
        }
    }

    /// Puts one child on the stack, in front of all that are entered no earlier.
    fn push(&mut self, parent: &Open, number: u8, near: [Mark; 3], far: [Mark; 3]) {
        let Some(cell) = parent.cell.child(number) else { return };
        let leaves = &self.partition.cells()[parent.run.clone()];
        let range = cell.range();
        let first = leaves.partition_point(|leaf| leaf.start() < *range.start());
        let count = leaves[first..].partition_point(|leaf| leaf.start() <= *range.end());
        let run = parent.run.start + first..parent.run.start + first + count;
        let enter = self.marks.enter(&near).max(parent.enter);
        let later = self.open.iter().rev().take_while(|open| open.enter < enter).count();
        self.open.insert(self.open.len() - later, Open { cell, run, near, far, enter });
    }
}

impl Iterator for Cast<'_> {
    type Item = Crossing;

    fn next(&mut self) -> Option<Crossing> {
        loop {
            let open = self.open.pop()?;
            if open.run.len() <= 1 {
                return Some(Crossing { leaf: open.run.start, enter: open.enter, exit: self.marks.exit(&open.far) });
            }
            self.halve(&open);
        }
    }
}
