//! Samples: a lattice over the parameter square of a face.
//!
//! On squares the points are ((a + ½)/n, (b + ½)/m). On triangles they are ((a + ⅓)/n, (b + ⅓)/m) strictly below
//! u + v = 1, so every face has one at least. The rounded floats *are* the points.

use std::ops::Range;

use umbriel_octree::Quadrant;

/// A face's lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lattice {
    counts: [u32; 2],
    is_triangle: bool,
}

impl Lattice {
    /// A lattice whose points are at most `spacing` apart along edges of these lengths, both in metres.
    pub(crate) fn new(edges: [f64; 2], spacing: f64, is_triangle: bool) -> Self {
        // 2^24 points along an edge keep a whole lattice countable.
        let count = |length: f64| (length / spacing).ceil().clamp(1.0, 16_777_216.0) as u32;
        Self { counts: edges.map(count), is_triangle }
    }

    /// One coordinate of point `index`.
    fn coordinate(&self, axis: usize, index: u32) -> f64 {
        let count = f64::from(self.counts[axis]);
        if self.is_triangle { (f64::from(index) * 3.0 + 1.0) / (3.0 * count) } else { (f64::from(index) + 0.5) / count }
    }

    /// The indices whose coordinate lies in cell `place` of 2^level along an axis: the half-open interval.
    fn indices(&self, axis: usize, level: u8, place: u32) -> Range<u32> {
        let cells = f64::from(1u32 << level);
        let first_from = |bound: f64| {
            let guess = (bound * f64::from(self.counts[axis])).max(1.0) as u32 - 1;
            let mut index = guess.saturating_sub(1);
            while index < self.counts[axis] && self.coordinate(axis, index) < bound {
                index += 1;
            }
            index
        };
        first_from(f64::from(place) / cells)..first_from((f64::from(place) + 1.0) / cells)
    }

    /// The points (u, v) in a cell.
    pub(crate) fn points(&self, cell: Quadrant) -> impl Iterator<Item = [f64; 2]> + '_ {
        let (level, [i, j]) = (cell.level(), cell.coordinates());
        let across = self.indices(1, level, j);
        self.indices(0, level, i).flat_map(move |a| {
            let u = self.coordinate(0, a);
            let inside = move |v: f64| !self.is_triangle || u + v < 1.0;
            across.clone().map(move |b| self.coordinate(1, b)).filter(move |&v| inside(v)).map(move |v| [u, v])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_share_the_points_out_without_loss() {
        for is_triangle in [false, true] {
            for (n, m) in [(1, 1), (1, 7), (13, 5), (64, 64), (100, 3)] {
                let lattice = Lattice { counts: [n, m], is_triangle };
                let whole = lattice.points(Quadrant::ROOT).count();
                let parts: usize = (0..64)
                    .filter_map(|code| Quadrant::from_bits(3, code))
                    .map(|cell| lattice.points(cell).count())
                    .sum();
                assert_eq!(parts, whole, "{n} × {m}");
                assert!(whole >= 1);
                if !is_triangle {
                    assert_eq!(whole, (n * m) as usize);
                }
            }
        }
    }
}
