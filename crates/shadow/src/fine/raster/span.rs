//! Which cells of a row a segment touches.
//!
//! A cell counts as touched when it is within the margin of the segment, in both coordinates: the row is widened by the
//! margin before the segment is cut to it, and the columns after. So the true segment, whose points are within the margin of
//! ours, touches no other cell.

use super::segments::Segment;

/// Whole numbers below this are floats.
const MOST: f64 = (1u64 << 52) as f64;

/// The greatest whole number not above x, but not beyond ±2^52. Without a call.
#[inline]
pub(crate) fn floor(x: f64) -> i64 {
    let x = x.clamp(-MOST, MOST);
    let whole = x as i64;
    whole - i64::from(x < whole as f64)
}

/// A segment ready to be walked row by row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Walk {
    low: [f64; 2],
    high: [f64; 2],
    /// Change of x with y; zero for level segments.
    slope: f64,
    margin: f64,
    /// Least and greatest x.
    sides: [f64; 2],
}

impl Walk {
    pub(crate) fn new(a: [f64; 2], b: [f64; 2], margin: f64) -> Self {
        let (low, high) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        let rise = high[1] - low[1];
        // A slope beyond all floats is that of a segment no higher than a subnormal number, which lies in one row.
        let slope = if rise > 0.0 { ((high[0] - low[0]) / rise).clamp(-f64::MAX, f64::MAX) } else { 0.0 };
        Self { low, high, slope, margin, sides: [a[0].min(b[0]), a[0].max(b[0])] }
    }

    pub(crate) fn of(segment: &Segment) -> Self {
        Self::new(segment.from, segment.to, f64::from(segment.margin))
    }

    /// The rows touched, out of `first..end`.
    pub(crate) fn rows(&self, first: i64, end: i64) -> std::ops::Range<i64> {
        let from = floor(self.low[1] - self.margin).max(first);
        let to = (floor(self.high[1] + self.margin) + 1).min(end);
        from..to.max(from)
    }

    /// Where the segment, extended level beyond its ends, is at height y.
    #[inline]
    fn x_at(&self, y: f64) -> f64 {
        if y <= self.low[1] {
            self.low[0]
        } else if y >= self.high[1] {
            self.high[0]
        } else {
            (self.low[0] + (y - self.low[1]) * self.slope).clamp(self.sides[0], self.sides[1])
        }
    }

    /// The x range in which the segment is near the row [row, row + 1]. A level segment is all in it.
    #[inline]
    pub(crate) fn reach_in(&self, row: i64) -> [f64; 2] {
        let (bottom, top) = (row as f64 - self.margin, row as f64 + 1.0 + self.margin);
        if self.low[1] == self.high[1] {
            return [self.sides[0] - self.margin, self.sides[1] + self.margin];
        }
        let (a, b) = (self.x_at(bottom), self.x_at(top));
        [a.min(b) - self.margin, a.max(b) + self.margin]
    }

    /// The x range in which the segment is near rows `first..end`.
    pub(crate) fn reach_over(&self, first: i64, end: i64) -> [f64; 2] {
        let [a, b] = self.reach_in(first);
        let [c, d] = self.reach_in(end - 1);
        [a.min(c), b.max(d)]
    }

    /// Calls `visit` with each row touched out of `first..end`, the x range in which the segment is near it, and where it
    /// crosses its middle. The ranges hold those of [`Walk::reach_in`].
    #[inline]
    pub(crate) fn visit_rows(&self, first: i64, end: i64, mut visit: impl FnMut(i64, [f64; 2], Option<f64>)) {
        let rows = self.rows(first, end);
        let is_level = self.low[1] == self.high[1];
        // Widening the row by the margin moves the ends of the range by this.
        let slide = if is_level { f64::INFINITY } else { self.margin * self.slope.abs() };
        let at = |y: f64| self.low[0] + (y - self.low[1]) * self.slope;
        let mut bottom = at(rows.start as f64);
        for row in rows {
            let top = at((row + 1) as f64);
            let (low, high) = if bottom < top { (bottom, top) } else { (top, bottom) };
            let low = (low - slide).max(self.sides[0]).min(self.sides[1]) - self.margin;
            let high = (high + slide).min(self.sides[1]).max(self.sides[0]) + self.margin;
            visit(row, [low, high], self.crossing(row));
            bottom = top;
        }
    }

    /// Where the segment crosses the middle of a row, if it does: it holds its lower end, not its higher one.
    #[inline]
    pub(crate) fn crossing(&self, row: i64) -> Option<f64> {
        let middle = row as f64 + 0.5;
        (self.low[1] <= middle && middle < self.high[1]).then(|| self.x_at(middle))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steep_segment_touches_one_cell_a_row_and_a_level_one_all() {
        let steep = Walk::new([1.5, 0.25], [1.75, 3.5], 1e-9);
        assert_eq!(steep.rows(0, 64), 0..4);
        assert!(steep.rows(0, 64).all(|row| steep.reach_in(row).map(f64::floor) == [1.0, 1.0]));
        steep.visit_rows(0, 64, |row, reach, _| assert_eq!(reach.map(f64::floor), steep.reach_in(row).map(f64::floor)));
        assert_eq!((0..5).filter(|&row| steep.crossing(row).is_some()).count(), 3);
        let level = Walk::new([7.5, 2.0], [-1.5, 2.0], 1e-9);
        assert_eq!(level.rows(0, 64), 1..3, "it lies on the border of two rows");
        assert!(level.reach_in(1)[0] < -1.5 && level.reach_in(2)[1] > 7.5);
        assert_eq!(level.crossing(1), None);
    }

    #[test]
    fn nearly_level_segments_are_cut_to_the_widened_row() {
        let flat = Walk::new([0.0, 0.999_999_9], [10.0, 1.000_000_1], 1e-3);
        let [low, high] = flat.reach_in(0);
        assert!(low < 0.0 && high > 10.0, "all of it is within the margin of row 0");
    }
}
