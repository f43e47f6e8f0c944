//! Rings of corners seen in a plane, from which corners are cut.

use robust::{Coord, orient2d};

/// Corners in rings that run counter-clockwise round what they enclose. A ring of two corners encloses nothing and is done.
pub(super) struct Rings {
    pub(super) at: Vec<Coord<f64>>,
    next: Vec<usize>,
    previous: Vec<usize>,
    done: Vec<bool>,
}

impl Rings {
    /// One ring of three corners or more.
    pub(super) fn new(at: Vec<Coord<f64>>) -> Self {
        let n = at.len();
        let next = (0..n).map(|corner| (corner + 1) % n).collect();
        let previous = (0..n).map(|corner| (corner + n - 1) % n).collect();
        Self { at, next, previous, done: vec![false; n] }
    }

    /// The corners that are in rings still.
    pub(super) fn left(&self) -> impl Iterator<Item = usize> {
        (0..self.at.len()).filter(|&corner| self.is_left(corner))
    }

    pub(super) fn is_left(&self, corner: usize) -> bool {
        !self.done[corner]
    }

    /// The corners before and after one.
    pub(super) fn neighbours(&self, corner: usize) -> [usize; 2] {
        [self.previous[corner], self.next[corner]]
    }

    pub(super) fn turn(&self, a: usize, b: usize, c: usize) -> f64 {
        orient2d(self.at[a], self.at[b], self.at[c])
    }

    /// The corners that are not strictly convex.
    pub(super) fn bent(&self) -> Vec<usize> {
        let turn = |corner: usize| self.turn(self.previous[corner], corner, self.next[corner]);
        self.left().filter(|&corner| turn(corner) <= 0.0).collect()
    }

    /// Whether the ring goes back at a corner the way it came, or stays in its place: cutting that leaves all areas as they are.
    pub(super) fn folds_back(&self, corner: usize) -> bool {
        let [before, after] = self.neighbours(corner);
        if self.turn(before, corner, after) != 0.0 {
            return false;
        }
        // Of three places on a line the middle one is the middle one by coordinates as well.
        let [before, here, after] = [before, corner, after].map(|corner| (self.at[corner].x, self.at[corner].y));
        before == here || after == here || (before < here) == (after < here)
    }

    /// Cuts all corners at which a ring folds back, and those that do so then.
    pub(super) fn cut_folds(&mut self, triangles: &mut Vec<[usize; 3]>) {
        let mut open = Vec::new();
        for first in 0..self.at.len() {
            open.push(first);
            while let Some(tip) = open.pop() {
                if self.is_left(tip) && self.folds_back(tip) {
                    open.extend(self.neighbours(tip));
                    triangles.push(self.cut(tip));
                }
            }
        }
    }

    /// Takes a corner out: the triangle that it makes with its neighbours.
    pub(super) fn cut(&mut self, tip: usize) -> [usize; 3] {
        let [before, after] = self.neighbours(tip);
        self.done[tip] = true;
        self.join(before, after);
        [before, tip, after]
    }

    /// Makes a corner the next one of another.
    pub(super) fn join(&mut self, before: usize, after: usize) {
        self.next[before] = after;
        self.previous[after] = before;
        if self.next[after] == before && self.previous[before] == after {
            (self.done[before], self.done[after]) = (true, true);
        }
    }
}
