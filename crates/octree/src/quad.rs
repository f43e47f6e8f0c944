//! Cells of a face: its parameter square, halved again and again.
//!
//! Cell (level, i, j) is [i, i+1] × [j, j+1] / 2^level of the parameters (u, v). On a triangle, where corner weights
//! are (1 − u − v, u, v), the square is cut by u + v ≤ 1: a cell with i + j + 1 < 2^level is whole, one with
//! i + j + 1 = 2^level keeps its lower half, the others are no part of the triangle. The cells of one level are then all
//! whole or halves of equal area, and children divide their parent exactly. All numbers here are exact.

use crate::morton::Quadrant;

#[cfg(test)]
mod tests;

/// What the parameters of a face run over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Face {
    /// The whole square: a rectangle, a side of a box, a patch.
    Square,
    /// The half with u + v ≤ 1: a triangle.
    Triangle,
}

impl Face {
    /// Whether the cell has area on the face.
    #[inline]
    pub fn has(self, cell: Quadrant) -> bool {
        self == Self::Square || place(cell) <= 0
    }

    /// Whether the cell keeps only its lower half: it lies on the side u + v = 1 of a triangle.
    #[inline]
    pub fn halves(self, cell: Quadrant) -> bool {
        self == Self::Triangle && place(cell) == 0
    }

    /// The children that have area on the face, in Morton order; none at the deepest level.
    #[inline]
    pub fn children(self, cell: Quadrant) -> impl Iterator<Item = Quadrant> {
        cell.children().filter(move |&child| self.has(child))
    }

    /// The share of the face's parameter area that the cell covers; exact. The face's cells of a level sum to 1.
    pub fn share(self, cell: Quadrant) -> f64 {
        let square = cell.edge() * cell.edge();
        match self {
            Self::Square => square,
            Self::Triangle if !self.has(cell) => 0.0,
            Self::Triangle if self.halves(cell) => square,
            Self::Triangle => square * 2.0,
        }
    }

    /// The cell's corners (u, v), counter-clockwise in the parameter plane: four, or three of a half; exact.
    #[inline]
    pub fn corners(self, cell: Quadrant) -> impl Iterator<Item = [f64; 2]> {
        let ([u, v], edge) = (cell.low_corner(), cell.edge());
        let corners = [[u, v], [u + edge, v], [u + edge, v + edge], [u, v + edge]];
        let is_half = self.halves(cell);
        corners.into_iter().enumerate().filter(move |(index, _)| !(is_half && *index == 2)).map(|(_, corner)| corner)
    }
}

impl Quadrant {
    /// The least parameters of the cell; exact.
    #[inline]
    pub fn low_corner(self) -> [f64; 2] {
        self.coordinates().map(|coordinate| f64::from(coordinate) * self.edge())
    }

    /// The edge of the cell, 2^−level; exact.
    #[inline]
    pub fn edge(self) -> f64 {
        1.0 / (1u64 << self.level()) as f64
    }
}

/// i + j + 1 − 2^level: negative below the diagonal of the square, zero on it.
#[inline]
fn place(cell: Quadrant) -> i64 {
    let [i, j] = cell.coordinates();
    i64::from(i) + i64::from(j) + 1 - (1 << cell.level())
}
