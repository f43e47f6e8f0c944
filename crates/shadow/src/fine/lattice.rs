//! Samples: a lattice over the parameter square of a face.
//!
//! On squares the points are ((a + ½)/n, (b + ½)/m). On triangles they are ((a + ⅓)/n, (b + ⅓)/m) strictly below
//! u + v = 1, so every face has one at least. The rounded floats *are* the points.

use std::{ops::Range, sync::OnceLock};

use umbriel_octree::Quadrant;

/// A face's lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lattice {
    counts: [u32; 2],
    is_triangle: bool,
}

/// The points of a small lattice.
#[derive(Clone, Debug)]
pub(crate) struct SmallRows {
    /// A word a row, a bit a column.
    pub(crate) words: Vec<i32>,
    /// How many points there are.
    points: u64,
    /// The greatest sum of row and column, counted in all rows and all columns.
    pub(crate) reach: f32,
}

impl SmallRows {
    fn new(lattice: &Lattice) -> Self {
        let lens = || (0..lattice.counts[0]).map(|row| lattice.row_len(row));
        let [rows, columns] = lattice.counts.map(f64::from);
        let ends = lens().enumerate().filter(|&(_, len)| len > 0);
        let sums = ends.map(|(row, len)| row as f64 / rows + f64::from(len - 1) / columns);
        let reach = sums.fold(0.0, f64::max) as f32;
        Self { words: lens().map(first_bits).collect(), points: lens().map(u64::from).sum(), reach }
    }
}

/// `count` low bits, 32 at most.
#[inline(always)]
pub(crate) fn first_bits(count: u32) -> i32 {
    ((1_u64 << count) - 1) as i32
}

/// How far apart points are, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Spacing {
    /// At most this far along both parameters.
    AtMost(f64),
    /// About one point on a square with this edge; at least one a face.
    About(f64),
}

impl Spacing {
    /// A square as wide, m².
    pub(crate) fn square(self) -> f64 {
        let (Self::AtMost(edge) | Self::About(edge)) = self;
        edge * edge
    }
}

impl Lattice {
    /// With so many rows and columns, at most.
    #[inline(always)]
    pub(crate) fn of_counts(counts: [u32; 2], is_triangle: bool) -> Self {
        Self { counts, is_triangle }
    }

    /// A lattice on a face with edges of these lengths, metres.
    #[inline(always)]
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
        Self { counts: [count(edges[0]), count(edges[1])], is_triangle }
    }

    /// Whether points end at u + v = 1.
    pub(crate) fn is_triangle(&self) -> bool {
        self.is_triangle
    }

    /// Rows (along the first parameter) and columns.
    pub(crate) fn counts(&self) -> [u32; 2] {
        self.counts
    }

    /// How many points. O(rows) for a large triangle.
    #[inline]
    pub(crate) fn len(&self) -> u64 {
        if !self.is_triangle {
            return u64::from(self.counts[0]) * u64::from(self.counts[1]);
        }
        match self.small_rows() {
            Some(rows) => rows.points,
            None => (0..self.counts[0]).map(|row| u64::from(self.row_len(row))).sum(),
        }
    }

    /// The points of a triangle with at most 32 rows and columns; made once for each size.
    #[inline]
    pub(crate) fn small_rows(&self) -> Option<&'static SmallRows> {
        const SIZES: usize = 33;
        static KNOWN: [OnceLock<SmallRows>; SIZES * SIZES] = [const { OnceLock::new() }; SIZES * SIZES];
        let [rows, columns] = self.counts.map(|count| count as usize);
        let is_small = self.is_triangle && rows < SIZES && columns < SIZES;
        is_small.then(|| KNOWN[rows * SIZES + columns].get_or_init(|| SmallRows::new(self)))
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
