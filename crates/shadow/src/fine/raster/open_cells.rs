//! The cells of a tile that its marks leave open: what the segments through each make of it.
//!
//! One walk along the segments notes in each open cell which meet it. A cell whose regions are all covered is shadowed ([`lowest`](super::lowest)); of
//! each other one 16 points say how much is likely lit ([`estimate`](super::estimate)). Where very many segments meet, only the points are looked at, by a second walk.

use super::{
    Raster,
    estimate::{Estimate, OpenCell, Places},
    lowest::{MOST_SEGMENTS, Met, Surroundings},
    tile::{TILE, Tile, columns},
};

/// What is found out about the open cells of a tile.
pub(super) struct Found {
    /// Open cells that are shadowed after all.
    pub(super) shadowed: [u64; TILE],
    /// How many points of each of the others are lit, in the order of rows and columns.
    pub(super) lit_points: Vec<u8>,
}

/// The segments that meet an open cell.
#[derive(Clone, Copy)]
struct Meeting {
    /// How many; only the first [`MOST_SEGMENTS`] are known.
    count: usize,
    touches: [Touch; MOST_SEGMENTS],
}

/// One of them: its number in the tile, and in the lowest bit whether it has the cell's middle on its left, as the windings count it.
#[derive(Clone, Copy, Default)]
struct Touch(u32);

impl Touch {
    fn segment(self) -> usize {
        (self.0 >> 1) as usize
    }

    fn is_left(self) -> bool {
        self.0 & 1 == 1
    }
}

impl Found {
    /// No more than how many points are lit.
    pub(super) fn points(lit_points: Vec<u8>) -> Self {
        Self { shadowed: [0; TILE], lit_points }
    }
}

/// Looks at the cells `open` of a tile that these segments meet; `carry` is the winding at the left of the tile's rows.
pub(super) fn look(
    raster: &Raster,
    tile: &Tile,
    (open, carry): (&[u64; TILE], &[i32; TILE]),
    segments: &[Met],
) -> Found {
    let meetings = meetings(tile, open, segments);
    let mut of_crowded = lit_points_of_crowded(raster, tile, (open, carry), (&meetings, segments)).into_iter();
    let mut found = Found { shadowed: [0; TILE], lit_points: Vec::with_capacity(meetings.len()) };
    let mut surroundings = Surroundings::default();
    let mut meetings = meetings.iter();
    for (row, &bits) in open.iter().enumerate().filter(|(_, bits)| **bits != 0) {
        let windings = tile.windings(row, carry[row]);
        for (column, meeting) in columns(bits).zip(&mut meetings) {
            let Some(touches) = meeting.touches.get(..meeting.count) else {
                found.lit_points.extend(of_crowded.next());
                continue;
            };
            let (cell, winding) = ([row, column], windings[column]);
            let Some(mut open_cell) = OpenCell::new(raster, tile, cell, winding) else { continue };
            let (middle, of_cell) = (tile.middle(cell), touches.iter().map(|touch| segments[touch.segment()]));
            for (touch, (segment, _)) in touches.iter().zip(of_cell.clone()) {
                open_cell.cross(middle, segment, touch.is_left());
            }
            // A lit point is not proved, but there is little hope then.
            let lit_points = open_cell.lit_points();
            if lit_points == 0 && touches.len() > 1 && surroundings.are_covered(middle, winding, of_cell) {
                found.shadowed[row] |= 1 << column;
            } else {
                found.lit_points.push(lit_points);
            }
        }
    }
    found
}

/// Which segments meet each open cell, in the order of rows and columns.
fn meetings(tile: &Tile, open: &[u64; TILE], segments: &[Met]) -> Vec<Meeting> {
    let places = Places::of(open);
    let mut meetings = vec![Meeting { count: 0, touches: [Touch::default(); MOST_SEGMENTS] }; places.count()];
    for (number, (segment, _)) in segments.iter().enumerate() {
        tile.for_each_touched(segment, open, |cell, _, is_left| {
            let meeting = &mut meetings[places.of_cell(cell)];
            if let Some(touch) = meeting.touches.get_mut(meeting.count) {
                *touch = Touch((number as u32) << 1 | u32::from(is_left));
            }
            meeting.count += 1;
        });
    }
    meetings
}

/// How many points are lit of each cell that more than [`MOST_SEGMENTS`] meet.
fn lit_points_of_crowded(
    raster: &Raster,
    tile: &Tile,
    (open, carry): (&[u64; TILE], &[i32; TILE]),
    (meetings, segments): (&[Meeting], &[Met]),
) -> Vec<u8> {
    if meetings.iter().all(|meeting| meeting.count <= MOST_SEGMENTS) {
        return Vec::new();
    }
    let (mut crowded, mut meetings) = ([0; TILE], meetings.iter());
    for (crowded, &bits) in crowded.iter_mut().zip(open) {
        for (column, _) in columns(bits).zip(&mut meetings).filter(|(_, meeting)| meeting.count > MOST_SEGMENTS) {
            *crowded |= 1 << column;
        }
    }
    estimate(raster, tile, (&crowded, carry), segments).lit_points
}

/// As [`look`], but by points alone.
pub(super) fn estimate(
    raster: &Raster,
    tile: &Tile,
    (open, carry): (&[u64; TILE], &[i32; TILE]),
    segments: &[Met],
) -> Found {
    let mut estimate = Estimate::new(raster, tile, open, carry);
    segments.iter().for_each(|(segment, _)| estimate.add(tile, segment));
    Found::points(estimate.lit_points())
}
