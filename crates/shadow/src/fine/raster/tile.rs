//! A square of up to 64 × 64 cells: what the segments and veils that meet it make of its cells.
//!
//! One bit a cell in 64-bit rows. A segment touches cells, and where it crosses the middle of a row the winding of all
//! cells to the right changes. A cell that nothing touches has one winding W everywhere: lit if it is 0, shadowed if it is
//! at least 1. In a touched cell W is that of its middle, and each segment through it that does not have the middle on its
//! outer side takes its facets away, twice where the side is in doubt (NUMERICS.md, "Borders on a face"). Cost: some 10 ns
//! for each row of a segment and 50 ns for each row with segments.

use super::{
    segments::{Segment, Veil},
    span::{Walk, floor},
};

/// Cells along the edge of a full tile.
pub(crate) const TILE: usize = 64;

/// Where a tile lies, in cells of the face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TilePlace {
    pub(crate) column: i64,
    pub(crate) row: i64,
    /// Cells along its edge, at most [`TILE`].
    pub(crate) size: i64,
}

impl TilePlace {
    /// The middle of the cell at a row and a column, in cells of the face.
    #[inline]
    pub(crate) fn middle(&self, [row, column]: [usize; 2]) -> [f64; 2] {
        [self.column + column as i64, self.row + row as i64].map(|place| place as f64 + 0.5)
    }

    /// The columns of the tile that a range of x meets, as places in the tile; the end is not among them.
    #[inline]
    fn columns(&self, [low, high]: [f64; 2]) -> std::ops::Range<usize> {
        let (start, size) = (self.column as f64, self.size as f64);
        // Rounding the differences is covered by the margin, like that of x itself.
        let (low, high) = (low - start, high - start);
        let end = if high < 0.0 { 0 } else { high.min(size - 1.0) as usize + 1 };
        let first = if low < 0.0 { 0 } else { low.min(size) as usize };
        first.min(end)..end
    }
}

/// What is collected of a tile.
#[derive(Debug)]
pub(crate) struct Tile {
    pub(crate) place: TilePlace,
    /// Cells that a segment touches; bit k is column k.
    touched: [u64; TILE],
    /// Cells that a veil touches.
    veiled: [u64; TILE],
    /// Rows with anything in them; the others hold old numbers below.
    used: u64,
    /// How the winding changes from the middle of the column before.
    change: [[i32; TILE]; TILE],
    /// What the segments through a cell can take away from the winding at its middle; `u16::MAX` stands for all.
    loss: [[u16; TILE]; TILE],
}

/// What is proved of the cells of a tile.
#[derive(Clone, Debug)]
pub(crate) struct Proofs {
    pub(crate) lit: [u64; TILE],
    pub(crate) shadowed: [u64; TILE],
}

impl Tile {
    /// An empty tile; to be used again and again.
    pub(crate) fn new() -> Box<Self> {
        Box::new(Self {
            place: TilePlace { column: 0, row: 0, size: 0 },
            touched: [0; TILE],
            veiled: [0; TILE],
            used: 0,
            change: [[0; TILE]; TILE],
            loss: [[0; TILE]; TILE],
        })
    }

    /// Starts over at another place.
    pub(crate) fn move_to(&mut self, place: TilePlace) {
        self.place = place;
        self.used = 0;
    }

    /// The row's place in the tile, cleared on first use.
    fn use_row(&mut self, row: i64) -> usize {
        let local = (row - self.place.row) as usize;
        if self.used >> local & 1 == 0 {
            self.used |= 1 << local;
            (self.touched[local], self.veiled[local]) = (0, 0);
            (self.change[local], self.loss[local]) = ([0; TILE], [0; TILE]);
        }
        local
    }

    /// Draws a segment. `touch` is told of each cell that it touches, by row and column, and whether the cell's middle lies on the left of the segment, in the
    /// same way as the windings count it.
    #[inline]
    pub(crate) fn add(&mut self, segment: &Segment, mut touch: impl FnMut([usize; 2], bool)) {
        let side = Side::of(segment);
        let is_upward = segment.to[1] > segment.from[1];
        let change = if is_upward { -segment.net } else { segment.net };
        let place = self.place;
        Walk::of(segment).visit_rows(place.row, place.row + place.size, |row, reach, crossing| {
            let local = self.use_row(row);
            // The first column whose middle is beyond the crossing.
            let beyond = crossing.map(|x| floor(x + 0.5) - place.column);
            let columns = if segment.is_beside { 0..0 } else { place.columns(reach) };
            self.touched[local] |= bits(&columns);
            let first = side.left(place.middle([local, columns.start]));
            for (k, column) in columns.enumerate() {
                let left = first - side.along[1] * k as f64;
                let loss = &mut self.loss[local][column];
                *loss = loss.saturating_add(side.loss(left));
                let is_left = beyond.map_or(left > 0.0, |beyond| ((column as i64) < beyond) == is_upward);
                touch([local, column], is_left);
            }
            if let Some(beyond) = beyond {
                // Left of the face that is the first one.
                let column = beyond.max(-place.column);
                if (0..place.size).contains(&column) {
                    self.change[local][column as usize] += change;
                }
            }
        });
    }

    pub(crate) fn add_veil(&mut self, veil: &Veil) {
        let margin = f64::from(veil.margin);
        let count = veil.corners.len();
        let sides: Vec<Walk> =
            (0..count).map(|k| Walk::new(veil.corners[k], veil.corners[(k + 1) % count], margin)).collect();
        for row in self.place.row..self.place.row + self.place.size {
            let near = sides.iter().filter(|side| !side.rows(row, row + 1).is_empty());
            let reach = near.map(|side| side.reach_in(row)).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
            if let Some(reach) = reach {
                let local = self.use_row(row);
                self.veiled[local] |= bits(&self.place.columns(reach));
            }
        }
    }

    /// What is proved, given the winding at the left of each row's middle, which moves on to the right end.
    pub(crate) fn settle(&self, carry: &mut [i32; TILE]) -> Proofs {
        let mut proofs = Proofs { lit: [0; TILE], shadowed: [0; TILE] };
        let size = self.place.size as usize;
        for (row, winding) in carry.iter_mut().enumerate().take(size) {
            let (mut clear, mut covered) = (0u64, 0u64);
            if self.used >> row & 1 == 0 {
                clear = if *winding == 0 { u64::MAX } else { 0 };
                covered = if *winding > 0 { u64::MAX } else { 0 };
                (proofs.lit[row], proofs.shadowed[row]) = (clear, covered);
                continue;
            }
            for column in 0..size {
                *winding += self.change[row][column];
                clear |= u64::from(*winding == 0) << column;
                let loss = self.loss[row][column];
                covered |= u64::from(*winding > i32::from(loss) && loss != u16::MAX) << column;
            }
            proofs.lit[row] = clear & !self.touched[row] & !self.veiled[row];
            proofs.shadowed[row] = covered;
        }
        proofs
    }

    /// The winding at the middles of a row, from that at its left.
    pub(crate) fn windings(&self, row: usize, left: i32) -> [i32; TILE] {
        let mut windings = [left; TILE];
        if self.used >> row & 1 == 1 {
            let mut winding = left;
            for (at, change) in windings.iter_mut().zip(&self.change[row]) {
                winding += change;
                *at = winding;
            }
        }
        windings
    }
}

/// On which side of a segment points lie.
struct Side {
    /// The cross product of the segment with the way from its start to (x, y) is across_y·y − across_x·x + constant.
    along: [f64; 2],
    constant: f64,
    doubt: f64,
    /// `u16::MAX` for more.
    net: u16,
}

impl Side {
    fn of(segment: &Segment) -> Self {
        let (a, b) = (segment.from, segment.to);
        let along = [b[0] - a[0], b[1] - a[1]];
        let length = along[0].abs() + along[1].abs();
        Self {
            along,
            constant: along[1] * a[0] - along[0] * a[1],
            // Both ends may move by the margin; near the segment that turns the product by this, roundings included.
            doubt: f64::from(segment.margin) * (3.0 * length + 8.0),
            net: u16::try_from(segment.net).unwrap_or(u16::MAX),
        }
    }

    /// Positive on the left, up to `doubt`.
    #[inline]
    fn left(&self, [x, y]: [f64; 2]) -> f64 {
        self.along[0] * y - self.along[1] * x + self.constant
    }

    /// How many facets can be lost on a straight way through the segment from a point this far on the left.
    #[inline]
    fn loss(&self, left: f64) -> u16 {
        let times = u16::from(left >= -self.doubt) + u16::from(left.abs() <= self.doubt);
        self.net.saturating_mul(times)
    }
}

/// The columns of these bits of a row.
pub(super) fn columns(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let column = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (column < TILE).then_some(column)
    })
}

/// The bits of a range of columns.
fn bits(columns: &std::ops::Range<usize>) -> u64 {
    let below = |end: usize| if end >= 64 { u64::MAX } else { (1u64 << end) - 1 };
    below(columns.end) & !below(columns.start)
}
