//! Windows of a picture, and which faces may be seen in which: what makes pictures of any size out of small ones.

use super::footprint::Footprint;

/// A rectangle of pixels: columns left..right of rows top..bottom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// First column.
    pub left: u32,
    /// First row.
    pub top: u32,
    /// One past the last column.
    pub right: u32,
    /// One past the last row.
    pub bottom: u32,
}

impl Window {
    /// Columns.
    pub fn width(&self) -> u32 {
        self.right.saturating_sub(self.left)
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.bottom.saturating_sub(self.top)
    }

    /// Number of pixels.
    pub fn area(&self) -> usize {
        self.width() as usize * self.height() as usize
    }

    /// What both cover; may be empty.
    #[must_use]
    pub fn meet(&self, other: &Self) -> Self {
        Self {
            left: self.left.max(other.left),
            top: self.top.max(other.top),
            right: self.right.min(other.right),
            bottom: self.bottom.min(other.bottom),
        }
    }

    /// Whether there is no pixel in it.
    pub fn is_empty(&self) -> bool {
        self.left >= self.right || self.top >= self.bottom
    }

    /// Place of a pixel in a list of the window's pixels, row by row.
    #[inline]
    pub(super) fn index(&self, [column, row]: [u32; 2]) -> usize {
        (row - self.top) as usize * self.width() as usize + (column - self.left) as usize
    }

    /// Two or four parts, halved where there is more than one row or column.
    pub(super) fn quarters(&self) -> impl Iterator<Item = Self> {
        let (x, y) = (self.left + self.width() / 2, self.top + self.height() / 2);
        let part = |left, top, right, bottom| Self { left, top, right, bottom };
        let parts = [
            part(self.left, self.top, x, y),
            part(x, self.top, self.right, y),
            part(self.left, y, x, self.bottom),
            part(x, y, self.right, self.bottom),
        ];
        parts.into_iter().filter(|part| !part.is_empty())
    }
}

/// A rectangle cut into windows of one size, row by row; those at the right and lower borders may be smaller.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    whole: Window,
    edges: [u32; 2],
    columns: u32,
    rows: u32,
}

impl Grid {
    pub(super) fn new(whole: Window, edges: [u32; 2]) -> Self {
        let edges = [edges[0].clamp(1, whole.width().max(1)), edges[1].clamp(1, whole.height().max(1))];
        Self { whole, edges, columns: whole.width().div_ceil(edges[0]), rows: whole.height().div_ceil(edges[1]) }
    }

    pub(super) fn len(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    pub(super) fn window(&self, index: usize) -> Window {
        let (column, row) = (index as u32 % self.columns, index as u32 / self.columns);
        let (left, top) = (self.whole.left + column * self.edges[0], self.whole.top + row * self.edges[1]);
        Window { left, top, right: left + self.edges[0], bottom: top + self.edges[1] }.meet(&self.whole)
    }

    /// The windows that share pixels with another rectangle.
    fn meeting(&self, other: &Window) -> impl Iterator<Item = usize> + use<> {
        let part = self.whole.meet(other);
        let (whole, [width, height], columns) = (self.whole, self.edges, self.columns);
        let range = |from: u32, to: u32, start: u32, edge: u32| (from - start) / edge..(to - start).div_ceil(edge);
        let (across, down) = if part.is_empty() {
            (0..0, 0..0)
        } else {
            (range(part.left, part.right, whole.left, width), range(part.top, part.bottom, whole.top, height))
        };
        down.flat_map(move |row| across.clone().map(move |column| (row * columns + column) as usize))
    }
}

/// The faces of each window of a grid, in ascending order: two passes of counting.
pub(super) struct Bins {
    starts: Vec<u32>,
    faces: Vec<u32>,
}

impl Bins {
    pub(super) fn new(grid: &Grid, footprints: &[Footprint]) -> Self {
        let mut starts = vec![0u32; grid.len() + 1];
        for footprint in footprints {
            grid.meeting(&footprint.window).for_each(|window| starts[window + 1] += 1);
        }
        for window in 1..starts.len() {
            starts[window] += starts[window - 1];
        }
        let mut next = starts.clone();
        let mut faces = vec![0; starts.last().map_or(0, |&end| end as usize)];
        for (face, footprint) in footprints.iter().enumerate() {
            for window in grid.meeting(&footprint.window) {
                faces[next[window] as usize] = face as u32;
                next[window] += 1;
            }
        }
        Self { starts, faces }
    }

    pub(super) fn of(&self, window: usize) -> &[u32] {
        &self.faces[self.starts[window] as usize..self.starts[window + 1] as usize]
    }
}
