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

/// How far apart points are, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Spacing {
    /// At most this far along both parameters.
    AtMost(f64),
    /// About one point on a square with this edge; at least one a face.
    About(f64),
}

impl Lattice {
    /// No points.
    pub(crate) const EMPTY: Self = Self { counts: [0; 2], is_triangle: false };

    /// A lattice on a face with edges of these lengths, metres.
    pub(crate) fn new(edges: [f64; 2], spacing: Spacing, is_triangle: bool) -> Self {
        // 2^24 points along an edge keep a whole lattice countable.
        let count = |length: f64| {
            let count = match spacing {
                Spacing::AtMost(spacing) => (length / spacing).ceil(),
                // A triangle with n rows has n(n + 1)/2 points: (n + ½)² points on twice its area.
                Spacing::About(spacing) if is_triangle => (length / spacing).floor(),
                Spacing::About(spacing) => (length / spacing).round(),
            };
            count.clamp(1.0, 16_777_216.0) as u32
        };
        Self { counts: edges.map(count), is_triangle }
    }

    /// Whether points end at u + v = 1.
    pub(crate) fn is_triangle(&self) -> bool {
        self.is_triangle
    }

    /// Rows (along the first parameter) and columns.
    pub(crate) fn counts(&self) -> [u32; 2] {
        self.counts
    }

    /// Rows times columns; a triangle has about half as many points.
    pub(crate) fn len_at_most(&self) -> u64 {
        u64::from(self.counts[0]) * u64::from(self.counts[1])
    }

    /// How many points. O(rows) for a triangle.
    pub(crate) fn len(&self) -> u64 {
        if self.is_triangle {
            (0..self.counts[0]).map(|row| u64::from(self.row_len(row))).sum()
        } else {
            self.len_at_most()
        }
    }

    /// How many points a row has: all with u + v < 1 on a triangle.
    #[inline]
    pub(crate) fn row_len(&self, row: u32) -> u32 {
        let columns = self.counts[1];
        if !self.is_triangle {
            return columns;
        }
        // (a + ⅓)/n + (b + ⅓)/m < 1 in whole numbers: b < (m·(3n − 3a − 1) − n) / 3n. Only equality may be rounded away.
        let (n, m) = (i64::from(self.counts[0]), i64::from(columns));
        let (above, below) = (m * (3 * n - 3 * i64::from(row) - 1) - n, 3 * n);
        if above < 0 {
            return 0;
        }
        if above % below != 0 {
            return (above / below + 1).min(m) as u32;
        }
        let u = self.coordinate(0, row);
        let guess = f64::from(columns) * (1.0 - u) + 2.0 / 3.0;
        let mut len = (guess as u32).min(columns);
        while len > 0 && u + self.coordinate(1, len - 1) >= 1.0 {
            len -= 1;
        }
        while len < columns && u + self.coordinate(1, len) < 1.0 {
            len += 1;
        }
        len
    }

    /// The columns of a row with low ≤ v ≤ high; the limits may be off by 2^-46.
    pub(crate) fn columns_between(&self, row: u32, low: f64, high: f64) -> Range<u32> {
        let count = f64::from(self.counts[1]);
        let shift = if self.is_triangle { 1.0 / 3.0 } else { 0.5 };
        let slack = count * 2f64.powi(-47);
        let (first, last) = ((low * count - shift - slack).ceil(), (high * count - shift + slack).floor());
        if !(first <= last && last >= 0.0) {
            return 0..0;
        }
        let end = (last.min(count) as u32 + 1).min(self.row_len(row));
        (first.max(0.0).min(count) as u32).min(end)..end
    }

    /// One coordinate of point `index`.
    #[inline]
    pub(crate) fn coordinate(&self, axis: usize, index: u32) -> f64 {
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
                assert_eq!(lattice.len(), whole as u64);
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
